//! A model of which each view has its own detail: one mesh, the strips of its full level, and collapses level by level.
//!
//! # Algorithm
//! The parts become one mesh. Its strips are built and proven, and the triangles that they draw are collapsed by a merge tree, so that few collapses need each
//! other (`tristrip::lod::SkipStrips`).
//!
//! # Complexity
//! That of the method of strips, and O(n log n) for the collapses of n vertices.

use std::sync::Arc;

use serde::Serialize;
use tristrip::lod::{SkipStrips, SkipView};
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree};
use tristrip::verify::verify_drawing;
use tristrip::{CollapseSequence, Faces, Mesh, StripifyOptions, Strips};
use tristrip_io::tlod::{self, TlodLimits, TlodModel};
use tristrip_io::{Model, Part};

use crate::error::Error;
use crate::join::{Joined, join};
use crate::observer::{Event, Observer, Stage, Stopped, begin};
use crate::prepared::Survey;

/// How a model of views is built.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ViewModelOptions {
    /// The method of the strips of the full mesh, and its options.
    pub stripify: StripifyOptions,
    /// The order in which the collapses of a level are chosen.
    pub order: MergeOrder,
    /// Whether the strips are proven to draw exactly the faces of the mesh.
    pub verify: bool,
}

impl Default for ViewModelOptions {
    fn default() -> Self {
        Self { stripify: StripifyOptions::default(), order: MergeOrder::default(), verify: true }
    }
}

impl ViewModelOptions {
    /// Sets the method of the strips, and its options.
    #[must_use]
    pub fn with_stripify(self, stripify: StripifyOptions) -> Self {
        Self { stripify, ..self }
    }

    /// Sets the order in which the collapses of a level are chosen.
    #[must_use]
    pub fn with_order(self, order: MergeOrder) -> Self {
        Self { order, ..self }
    }

    /// Sets whether the strips are proven.
    #[must_use]
    pub fn with_verify(self, verify: bool) -> Self {
        Self { verify, ..self }
    }
}

/// What a vertex tree is built from.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ViewModel {
    /// The mesh of all parts.
    pub mesh: Mesh,
    /// Its strips.
    pub strips: Strips,
    /// The collapses of the triangles of the strips, in their order.
    pub sequence: Arc<CollapseSequence>,
    /// The levels of the merge tree; `None` for a model that was read from a file.
    pub levels: Option<usize>,
    /// Why the search for strips was stopped early, if it was.
    pub stopped: Option<Stopped>,
    /// Notes of the reader, and on what was dropped, changed or unusual.
    pub notes: Vec<String>,
}

/// The counts of a model of views; the keys are those of the JSON report of `tristrip build-lod`. All are `None` before it is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct ViewModelReport {
    /// The vertices of the mesh.
    pub vertices: Option<usize>,
    /// The triangles of the full mesh.
    pub triangles: Option<usize>,
    /// The strips of the full mesh.
    pub strips: Option<usize>,
    /// The collapses.
    pub collapses: Option<usize>,
    /// The levels of the merge tree.
    pub levels: Option<usize>,
    /// The longest chain of collapses, one into a result of the one before.
    pub height: Option<u32>,
    /// The size of the file.
    pub bytes: Option<usize>,
}

/// A `.tlod` file, which was read back and compared.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct EncodedViewModel {
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// The height of its vertex tree.
    pub height: u32,
}

/// Builds the model of views of all parts together, where their coordinates are: nodes do not place them.
///
/// # Errors
/// There are too many vertices, an option has an invalid value, the strips are not proven, or the observer cancelled.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{ViewModelOptions, view_model};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let built = view_model(model, &ViewModelOptions::default(), &())?;
/// assert_eq!((built.strips.len(), built.sequence.triangles().len()), (1, 6));
/// assert!(built.encode()?.bytes.starts_with(b"\x89TLOD"));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn view_model(
    model: Model,
    options: &ViewModelOptions,
    observer: &dyn Observer,
) -> Result<ViewModel, Error> {
    let Joined { mesh, notes } = join(model)?;
    let model = Model { parts: vec![Part { mesh, ..Part::default() }], notes, ..Model::default() };
    let Survey { prepared, options: stripify, mesh: figures, notes } =
        Survey::new(&model, options.stripify, observer)?;
    let (strips, stopped) = prepared.search(&stripify, observer)?;
    if options.verify {
        begin(observer, Stage::Prove)?;
        prepared.prove(&strips)?;
        observer.event(Event::Proven { faces: figures.faces });
    }
    drop(prepared);
    let (Some(strips), Some(part)) = (strips.into_iter().next(), model.parts.into_iter().next()) else {
        return Err(Error::Unproven("found no strips, expected those of one mesh".into()));
    };
    begin(observer, Stage::Simplify)?;
    let tree = merge_tree(&part.mesh, strips.to_list(), options.order, &SimplifyOptions::default())?;
    let levels = tree.level_ends.len();
    observer.event(Event::Merged { collapses: tree.sequence.len(), levels });
    let (mesh, sequence) = (part.mesh, Arc::new(tree.sequence));
    Ok(ViewModel { mesh, strips, sequence, levels: Some(levels), stopped, notes })
}

impl From<TlodModel> for ViewModel {
    fn from(TlodModel { mesh, strips, sequence, .. }: TlodModel) -> Self {
        let sequence = Arc::new(sequence);
        Self { mesh, strips, sequence, levels: None, stopped: None, notes: Vec::new() }
    }
}

impl ViewModel {
    /// Builds the vertex tree, of which views are.
    ///
    /// # Errors
    /// A position is not finite.
    pub fn vertex_tree(&self) -> Result<SkipStrips, Error> {
        Ok(SkipStrips::new(&self.strips, &self.sequence, self.mesh.positions())?)
    }

    /// Encodes the model as `.tlod`, reads the bytes back, and compares.
    ///
    /// # Errors
    /// The strips do not draw exactly the faces of the mesh, or the bytes hold another model.
    pub fn encode(&self) -> Result<EncodedViewModel, Error> {
        let (mesh, strips) = (self.mesh.clone(), self.strips.clone());
        let model = TlodModel::new(mesh, strips, CollapseSequence::clone(&self.sequence))
            .map_err(|error| Error::Unproven(error.to_string()))?;
        let bytes = encoded(&model)?;
        let again = tlod::read(&bytes[..], &TlodLimits::default())
            .map_err(|error| Error::Unproven(format!("the file, read back: {error}")))?;
        // Bytes are compared, not models: a value that is not a number differs from itself.
        if encoded(&again)? != bytes {
            return Err(Error::Unproven("the file, read back, is another model".into()));
        }
        let height = SkipStrips::of_levels(&again.strips, &again.sequence)?.height();
        Ok(EncodedViewModel { bytes, height })
    }

    /// Returns the counts for a report, without those of a file.
    pub fn report(&self) -> ViewModelReport {
        ViewModelReport {
            vertices: Some(self.mesh.vertex_count()),
            triangles: Some(self.sequence.triangles().len() / 3),
            strips: Some(self.strips.len()),
            collapses: Some(self.sequence.len()),
            levels: self.levels,
            height: None,
            bytes: None,
        }
    }
}

fn encoded(model: &TlodModel) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    tlod::write(model, &mut bytes)?;
    Ok(bytes)
}

/// Proves that strips draw exactly the triangles of a view, with their winding; returns their number.
///
/// # Errors
/// [`Error::Unproven`]: they do not.
///
/// ```
/// use std::sync::Arc;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{ViewModelOptions, prove_view, view_model};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let tree = Arc::new(view_model(model, &ViewModelOptions::default(), &())?.vertex_tree()?);
/// let view = tree.view();
/// assert_eq!(prove_view(&view, &view.display_strips())?, view.triangle_count());
/// assert!(prove_view(&view, &tristrip::Strips::default()).is_err());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn prove_view(view: &SkipView, strips: &Strips) -> Result<usize, Error> {
    let expected = Faces::from_triangles(view.renamed_triangles().into_flattened())?;
    if expected.face_count() != view.triangle_count() {
        let (found, expected) = (view.triangle_count(), expected.face_count());
        return Err(Error::Unproven(format!("the view counts {found} triangles, expected {expected}")));
    }
    let drawn: Vec<[u32; 3]> = strips.triangles().collect();
    let proof = verify_drawing(&expected, &drawn).map_err(|why| Error::Unproven(why.to_string()))?;
    Ok(proof.triangles)
}
