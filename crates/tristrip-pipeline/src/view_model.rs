//! A view-dependent LOD model: one mesh, the strips of its full level, and collapses in levels.
//!
//! # Algorithm
//! The parts are joined into one mesh. Its strips are built and verified. The triangles that they
//! draw are collapsed by a merge tree, which keeps dependencies between collapses short
//! (`tristrip::lod::SkipStrips`).
//!
//! # Complexity
//! The time of the method that builds the strips, plus O(n log n) time for the collapses of n
//! vertices.

use std::sync::Arc;

use serde::Serialize;
use tristrip::lod::{SkipStrips, SkipView};
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree};
use tristrip::text::counted;
use tristrip::verify::verify_drawing;
use tristrip::{CollapseSequence, Faces, Mesh, StripifyOptions, Strips};
use tristrip_io::tlod::{self, TlodLimits, TlodModel};
use tristrip_io::{Model, Part};

use crate::encode::true_or_null;
use crate::error::Error;
use crate::figures::MeshProperties;
use crate::join::{Joined, join};
use crate::method::MethodDescription;
use crate::observer::{Observer, SearchStop, Stage, begin};
use crate::prepared::Survey;

/// Options for building a view-dependent LOD model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The method that builds the strips of the full mesh, with its options.
    pub stripify: StripifyOptions,
    /// The criterion that orders the collapses of a level.
    pub order: MergeOrder,
    /// Whether the strips are verified to draw exactly the faces of the mesh.
    pub verify: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { stripify: StripifyOptions::default(), order: MergeOrder::default(), verify: true }
    }
}

impl Options {
    tristrip::setters! {
        /// Sets the method that builds the strips, with its options.
        with_stripify(stripify: StripifyOptions);

        /// Sets the criterion that orders the collapses of a level.
        with_order(order: MergeOrder);

        /// Sets whether the strips are verified.
        with_verify(verify: bool);
    }
}

/// The data from which a vertex tree is built.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct ViewModel {
    /// The mesh of all parts.
    pub mesh: Mesh,
    /// The strips of the full mesh.
    pub strips: Strips,
    /// The collapses of the triangles of the strips, in order.
    pub sequence: Arc<CollapseSequence>,
}

/// The result of building a view-dependent LOD model. The field names are the keys of the JSON
/// report.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The model.
    #[serde(skip)]
    pub model: ViewModel,
    /// The vertex, edge and face counts of the full mesh.
    #[serde(skip)]
    pub mesh: MeshProperties,
    /// The method and the options that it uses.
    #[serde(flatten)]
    pub method: MethodDescription,
    /// The order in which the collapses of a level were chosen: `quadric` or `shortest-edge`.
    pub order: &'static str,
    /// Whether the strips draw exactly the faces of the mesh and the triangles of the collapses,
    /// and the file contains the same model when it is read back; `null` in reports if verification
    /// was disabled.
    #[serde(serialize_with = "true_or_null")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<bool>"))]
    pub proven: bool,
    /// The number of vertices of the mesh, as stored, used or not.
    pub vertices: usize,
    /// The number of triangles of the full mesh.
    pub triangles: usize,
    /// The number of strips of the full mesh.
    pub strips: usize,
    /// The number of half-edge collapses down to the base mesh. Vertices at one position collapse
    /// together.
    pub collapses: usize,
    /// The number of levels of the merge tree. The collapses of one level do not depend on each
    /// other.
    pub levels: usize,
    /// Why the search for strips ended before its effort was spent; `None` if it was not stopped.
    pub stopped: Option<SearchStop>,
    /// The number of parts of the input: glTF primitives or OBJ materials.
    pub parts: usize,
    /// Human-readable notes on data that was read, dropped, changed or unusual, and on a search
    /// that was stopped.
    pub notes: Vec<String>,
}

/// A `.tlod` file that was read back and compared. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct File {
    /// The bytes of the file.
    #[serde(skip)]
    pub bytes: Vec<u8>,
    /// The height of the vertex tree: the length of its longest chain of dependent collapses.
    pub height: u32,
    /// The size of the file in bytes.
    #[serde(rename = "bytes")]
    pub file_bytes: usize,
}

/// Builds one view-dependent LOD model of all parts, in their own coordinates; node transforms are
/// not applied.
///
/// # Errors
/// There are too many vertices, an option has an invalid value, the strips fail verification, or
/// the observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::view_model;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let built = view_model::run(model, &view_model::Options::default(), &())?;
/// assert_eq!((built.strips, built.triangles), (1, 2));
/// assert!(built.model.encode()?.bytes.starts_with(b"\x89TLOD"));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    let parts = model.parts.len();
    let Joined { mesh, notes } = join(model)?;
    let joined = Model { parts: vec![Part { mesh, ..Part::default() }], notes, ..Model::default() };
    let Survey { prepared, options: stripify, mesh: properties, mut notes } =
        Survey::new(&joined, options.stripify, observer)?;
    let (strips, stopped) = prepared.search(&stripify, observer)?;
    if options.verify {
        begin(observer, Stage::Prove)?;
        prepared.prove(&strips)?;
    }
    drop(prepared);
    let (Some(strips), Some(part)) = (strips.into_iter().next(), joined.parts.into_iter().next()) else {
        return Err(Error::unproven("found no strips, expected those of one mesh"));
    };
    begin(observer, Stage::Simplify)?;
    let tree = merge_tree(&part.mesh, strips.to_list(), options.order, &SimplifyOptions::default())?;
    notes.extend(stopped.map(|stopped| stopped.note().into()));
    let model = ViewModel { mesh: part.mesh, strips, sequence: Arc::new(tree.sequence) };
    Ok(Outcome {
        mesh: properties,
        method: MethodDescription::of(&stripify),
        order: options.order.name(),
        proven: options.verify,
        vertices: model.mesh.vertex_count(),
        triangles: model.triangle_count(),
        strips: model.strips.len(),
        collapses: model.sequence.len(),
        levels: tree.level_ends.len(),
        stopped,
        parts,
        notes,
        model,
    })
}

impl From<TlodModel> for ViewModel {
    fn from(TlodModel { mesh, strips, sequence, .. }: TlodModel) -> Self {
        Self { mesh, strips, sequence: Arc::new(sequence) }
    }
}

impl ViewModel {
    /// Returns the number of triangles of the full mesh.
    pub fn triangle_count(&self) -> usize {
        self.sequence.triangles().len() / 3
    }

    /// Builds the vertex tree, from which views are created.
    ///
    /// # Errors
    /// A position is not finite.
    pub fn vertex_tree(&self) -> Result<SkipStrips, Error> {
        Ok(SkipStrips::new(&self.strips, &self.sequence, self.mesh.positions())?)
    }

    /// Encodes the model as `.tlod`, reads the bytes back, and compares.
    ///
    /// # Errors
    /// The strips do not draw exactly the faces of the mesh, or the bytes contain another model.
    pub fn encode(&self) -> Result<File, Error> {
        let (mesh, strips) = (self.mesh.clone(), self.strips.clone());
        let model = TlodModel::new(mesh, strips, CollapseSequence::clone(&self.sequence))
            .map_err(|error| Error::unproven(error.to_string()))?;
        let bytes = encoded(&model)?;
        let again = tlod::read(&bytes[..], &TlodLimits::default())
            .map_err(|error| Error::unproven(format!("the file, read back: {error}")))?;
        // Compare bytes, not models: a NaN differs from itself.
        if encoded(&again)? != bytes {
            return Err(Error::unproven("the file, read back, differs from the model"));
        }
        let height = SkipStrips::of_levels(&again.strips, &again.sequence)?.height();
        Ok(File { height, file_bytes: bytes.len(), bytes })
    }
}

fn encoded(model: &TlodModel) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    tlod::write(model, &mut bytes)?;
    Ok(bytes)
}

/// Verifies that strips draw exactly the triangles of a view, with their winding. Returns the
/// number of triangles.
///
/// # Errors
/// [`Error::Unproven`]: the strips draw other triangles.
///
/// ```
/// use std::sync::Arc;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::view_model::{self, prove_view};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let tree = Arc::new(view_model::run(model, &view_model::Options::default(), &())?.model.vertex_tree()?);
/// let view = tree.view();
/// assert_eq!(prove_view(&view, &view.display_strips())?, view.triangle_count());
/// assert!(prove_view(&view, &tristrip::Strips::default()).is_err());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn prove_view(view: &SkipView, strips: &Strips) -> Result<usize, Error> {
    let expected = Faces::from_triangles(view.renamed_triangles().into_flattened())?;
    if expected.face_count() != view.triangle_count() {
        let (found, expected) = (view.triangle_count(), expected.face_count());
        return Err(Error::unproven(format!(
            "the view counts {}, expected {expected}",
            counted(found, "triangle")
        )));
    }
    let drawn: Vec<[u32; 3]> = strips.triangles().collect();
    let proof = verify_drawing(&expected, &drawn).map_err(|why| Error::unproven(why.to_string()))?;
    Ok(proof.triangles)
}
