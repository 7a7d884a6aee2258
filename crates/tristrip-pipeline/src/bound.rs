//! Lower bounds on the strips, vertices and indices of a whole model.

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip::stripify::bound::{Bound, BoundMethod, sequential_strip};
use tristrip_io::Model;

use crate::bounds::Bounds;
use crate::error::Error;
use crate::figures::MeshFigures;
use crate::observer::{Event, Observer, Stage, begin};
use crate::parts::map;
use crate::prepared::Survey;

/// The bound of one part.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct PartBound {
    /// The bound, with its components.
    pub bound: Bound,
    /// Whether one strip without swaps draws the part completely.
    pub sequential: bool,
}

/// The bound of a component of a part; the keys are those of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct ComponentReport {
    /// The number of the part.
    pub part: usize,
    /// The triangles of the component.
    pub triangles: usize,
    /// The lower bound of its strips.
    pub strips: usize,
    /// The lower bound of the vertices sent.
    pub vertices_sent: usize,
    /// How the bound was found: `leaves`, `matching`, `subproblems`, `exact` or `one-strip`.
    pub proof: &'static str,
}

impl Bounded {
    /// Returns the bounds of all components, part by part.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let components = tristrip_pipeline::bound(&model, false)?.components();
    /// assert_eq!((components.len(), components[0].strips), (1, 1));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn components(&self) -> Vec<ComponentReport> {
        let of_part = |(part, found): (usize, &PartBound)| {
            let report = move |component: &tristrip::stripify::bound::ComponentBound| ComponentReport {
                part,
                triangles: component.triangles,
                strips: component.strips,
                vertices_sent: component.vertices_sent,
                proof: proof_name(component.method),
            };
            found.bound.components.iter().map(report).collect::<Vec<_>>()
        };
        self.parts.iter().enumerate().flat_map(of_part).collect()
    }
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

/// The bounds of a model and of its parts.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Bounded {
    /// The sums over all parts.
    pub bounds: Bounds,
    /// The bound of each part, in their order.
    pub parts: Vec<PartBound>,
    /// The counts of the mesh.
    pub mesh: MeshFigures,
    /// Notes of the reader, and on what was dropped, changed or unusual.
    pub notes: Vec<String>,
}

/// Computes lower bounds that hold for every method. `weld` joins vertices with the same bits in all attributes, as
/// [`StripifyOptions::with_weld`] does.
///
/// # Errors
/// As of [`bound_observed`].
///
/// ```
/// use tristrip_io::{Format, read};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let bounded = tristrip_pipeline::bound(&model, false)?;
/// assert_eq!((bounded.bounds.strips, bounded.bounds.vertices_sent, bounded.parts[0].sequential), (1, 4, true));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn bound(model: &Model, weld: bool) -> Result<Bounded, Error> {
    bound_observed(model, weld, &())
}

/// Does the same, and reports each stage to an observer.
///
/// # Errors
/// The observer cancelled.
///
/// ```
/// use tristrip_io::{Format, read};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// assert_eq!(tristrip_pipeline::bound_observed(&model, false, &())?.bounds.indices_restart, 3);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn bound_observed(model: &Model, weld: bool, observer: &dyn Observer) -> Result<Bounded, Error> {
    let options = StripifyOptions::default().with_weld(weld);
    let Survey { prepared, mesh, notes, .. } = Survey::new(model, options, observer)?;
    begin(observer, Stage::Bound)?;
    let parts = map(prepared.parts(), |part| {
        let triangles = part.surface.faces().as_triangles().is_some();
        let sequential = triangles && sequential_strip(&part.graph).is_some();
        Ok(PartBound { bound: Bound::of_prepared(&part.surface, &part.graph)?, sequential })
    });
    let parts = parts.into_iter().collect::<Result<Vec<_>, Error>>()?;
    observer.event(Event::Bounded(None));
    let bounds = Bounds::sum(parts.iter().map(|part| &part.bound));
    Ok(Bounded { bounds, parts, mesh, notes })
}
