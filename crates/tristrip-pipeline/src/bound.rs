//! Lower bounds on the strips, vertices and indices of a whole model.

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip::stripify::bound::{Bound, BoundMethod, sequential_strip};
use tristrip_io::Model;

use crate::bounds::Bounds;
use crate::error::Error;
use crate::figures::MeshProperties;
use crate::observer::{Observer, Stage, begin};
use crate::parts::map;
use crate::prepared::Survey;

/// Options for computing lower bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Options {
    /// Whether vertices with the same bits in all attributes are welded; see
    /// [`StripifyOptions::with_weld`].
    pub weld: bool,
}

impl Options {
    tristrip::setters! {
        /// Sets whether vertices with the same bits in all attributes are welded.
        with_weld(weld: bool);
    }
}

/// The lower bounds of a model. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The vertex, edge and face counts of the mesh.
    pub mesh: MeshProperties,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// The lower bounds of the whole model.
    pub bound: Bounds,
    /// For each part, whether one strip without swaps draws it completely. It is always `false` for
    /// parts with polygons.
    pub sequential: Vec<bool>,
    /// The bounds of each connected component, part by part.
    pub components: Vec<Component>,
    /// Human-readable notes on data that was read, dropped, changed or unusual.
    pub notes: Vec<String>,
}

/// The lower bounds of a component of a part. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Component {
    /// The index of the part, from 0.
    pub part: usize,
    /// The number of triangles of the component.
    pub triangles: usize,
    /// The lower bound on the number of strips.
    pub strips: usize,
    /// The lower bound on the number of vertices sent.
    pub vertices_sent: usize,
    /// How the bound on strips was found: `one-strip`, `leaves`, `matching`, `subproblems`, or
    /// `exact` if the bound can be reached.
    pub proof: &'static str,
}

fn proof_name(proof: BoundMethod) -> &'static str {
    match proof {
        BoundMethod::Leaves => "leaves",
        BoundMethod::Matching => "matching",
        BoundMethod::Subproblems => "subproblems",
        BoundMethod::Exact => "exact",
        _ => "one-strip",
    }
}

/// Computes lower bounds that hold for every method.
///
/// # Errors
/// The observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::bound;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let found = bound::run(&model, &bound::Options::default(), &())?;
/// assert_eq!((found.bound.strips, found.bound.vertices_sent, found.sequential[0]), (1, 4, true));
/// assert_eq!((found.components.len(), found.components[0].proof), (1, "exact"));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    let stripify = StripifyOptions::default().with_weld(options.weld);
    let Survey { prepared, mesh, notes, .. } = Survey::new(model, stripify, observer)?;
    begin(observer, Stage::Bound)?;
    let parts = map(prepared.parts(), |part| {
        let triangles = part.surface.faces().as_triangles().is_some();
        let sequential = triangles && sequential_strip(&part.graph).is_some();
        Ok((Bound::of_prepared(&part.surface, &part.graph)?, sequential))
    });
    let parts = parts.into_iter().collect::<Result<Vec<(Bound, bool)>, Error>>()?;
    let of_part = |(part, (bound, _)): (usize, &(Bound, bool))| {
        let component = move |component: &tristrip::stripify::bound::ComponentBound| Component {
            part,
            triangles: component.triangles,
            strips: component.strips,
            vertices_sent: component.vertices_sent,
            proof: proof_name(component.method),
        };
        bound.components.iter().map(component).collect::<Vec<_>>()
    };
    Ok(Outcome {
        mesh,
        parts: parts.len(),
        bound: Bounds::sum(parts.iter().map(|(bound, _)| bound)),
        sequential: parts.iter().map(|&(_, sequential)| sequential).collect(),
        components: parts.iter().enumerate().flat_map(of_part).collect(),
        notes,
    })
}
