//! Encoding to memory: a model is encoded, read back and verified before its bytes are returned.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Serialize, Serializer};
use tristrip::Layout;
use tristrip::verify::verify_models;
use tristrip_io::gltf::{Rounding, SeparateFiles};
use tristrip_io::{Drawing, Format, Model, Redrawn, Reordered, SideFile, VertexGroup};

use crate::error::Error;
use crate::observer::{Observer, Stage, begin};
use crate::parts::meshes;
use crate::text::counted;

/// The format and layout of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// The format of the file.
    pub format: Format,
    /// The layout of strips in its index buffers.
    pub layout: Layout,
    /// Whether [`strip::Outcome::encode`](crate::strip::Outcome::encode) may draw a part as a list
    /// if that takes fewer indices than strips.
    pub list: bool,
    /// Whether vertices are reordered by first use in the drawings.
    pub reorder: bool,
    /// How a GLB is packed: duplicate data is stored once, redundant keyframes are removed, and
    /// values are rounded as given. `None` disables this.
    pub pack: Option<Rounding>,
    /// Whether the bytes are read back and verified.
    pub verify: bool,
}

impl Options {
    /// Creates options for a format. Parts are written in the layout that every reader of the
    /// format supports, or as lists where these take fewer indices. Bytes are verified, and
    /// vertices keep their order.
    pub fn new(format: Format) -> Self {
        Self { format, layout: default_layout(format), list: true, reorder: false, pack: None, verify: true }
    }

    /// Sets the layout of strips. Parts are then never drawn as lists instead.
    #[must_use]
    pub fn with_layout(self, layout: Layout) -> Self {
        Self { layout, list: false, ..self }
    }

    tristrip::setters! {
        /// Sets whether a part may be drawn as a list if that takes fewer indices than strips.
        with_list(list: bool);

        /// Sets whether vertices are reordered by first use in the drawings.
        with_reorder(reorder: bool);

        /// Sets how a GLB is packed.
        with_pack(pack: Option<Rounding>);

        /// Sets whether the bytes are read back and verified.
        with_verify(verify: bool);
    }
}

/// Returns the strip layout that readers of a format support: degenerate for GLB, restart for PLY,
/// and list for OBJ, because OBJ has no strips.
///
/// ```
/// use tristrip::Layout;
/// use tristrip_io::Format;
/// assert_eq!(tristrip_pipeline::encode::default_layout(Format::Glb), Layout::Degenerate);
/// ```
pub fn default_layout(format: Format) -> Layout {
    match format {
        Format::Obj => Layout::List,
        Format::Ply => Layout::Restart,
        _ => Layout::Degenerate,
    }
}

/// The bytes of a file.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Outcome {
    /// The encoded bytes.
    pub bytes: Vec<u8>,
    /// The number of faces that the bytes are verified to draw; `None` if verification was
    /// disabled.
    pub faces: Option<usize>,
    /// The new vertex order, if reordering was requested.
    pub groups: Option<Vec<VertexGroup>>,
    /// Notes on vertices that were not reordered or were kept although unused, on viewers that
    /// cannot draw the file, and on data that the format cannot store.
    pub notes: Vec<String>,
    /// Warnings about data of the model that viewers of the file do not show.
    pub warnings: Vec<String>,
    /// The files that an OBJ refers to. They belong in its directory.
    pub files: Vec<SideFile>,
}

impl Outcome {
    /// Returns the notes and then the warnings, for a report.
    pub fn all_notes(&self) -> Vec<String> {
        self.notes.iter().chain(&self.warnings).cloned().collect()
    }

    /// Splits a GLB into a `.gltf` document and a buffer with this file name. If the GLB was
    /// verified, verifies that both files contain the same meshes.
    ///
    /// # Errors
    /// The file is not a GLB, or the separate files fail verification.
    ///
    /// ```
    /// use tristrip_io::{Drawing, Format, read};
    /// use tristrip_pipeline::encode;
    /// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
    /// let glb = encode::run(&model, &[Drawing::Faces], &encode::Options::new(Format::Glb), &())?;
    /// let files = glb.separate("model.bin")?;
    /// assert!(files.json.starts_with(b"{") && !files.buffer.is_empty());
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn separate(&self, file_name: &str) -> Result<SeparateFiles, Error> {
        let files = tristrip_io::gltf::separate(self.bytes.clone(), file_name)?;
        if self.faces.is_some() {
            let unproven = |error: tristrip_io::Error| Error::unproven(error.to_string());
            let again = tristrip_io::gltf::read_separate(&files).map_err(unproven)?;
            let glb = tristrip_io::read(&self.bytes, Format::Glb).map_err(unproven)?;
            if meshes(&again) != meshes(&glb) {
                return Err(Error::unproven("the separate files differ from the GLB"));
            }
        }
        Ok(files)
    }
}

/// Encodes a model with one drawing per part, and verifies that the bytes draw the model.
///
/// # Errors
/// The drawings do not fit the model, the format cannot store it, the bytes fail verification, or
/// the observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Drawing, Format, read};
/// use tristrip_pipeline::{Error, encode};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let options = encode::Options::new(Format::Ply);
/// let ply = encode::run(&model, &[Drawing::Faces], &options, &())?;
/// assert_eq!(ply.faces, Some(2));
/// let mut half = tristrip::Strips::default();
/// half.push(&[1, 2, 0]);
/// let half = encode::run(&model, &[Drawing::Strips(&half)], &options, &());
/// assert!(matches!(half, Err(Error::Unproven { .. })));
/// # Ok::<(), Error>(())
/// ```
pub fn run(
    model: &Model,
    drawings: &[Drawing<'_>],
    options: &Options,
    observer: &dyn Observer,
) -> Result<Outcome, Error> {
    let Options { format, layout, .. } = *options;
    let mut notes = Vec::new();
    let reordered = if options.reorder { Some(reorder(model, drawings, *options, observer)?) } else { None };
    notes.extend(reordered.iter().flat_map(|moved| kept_groups(&moved.groups)));
    if has_restarts(drawings, *options) {
        notes.push(RESTART_NOTE.into());
    }
    begin(observer, Stage::Encode)?;
    let mut bytes = match &reordered {
        None => tristrip_io::write(model, drawings, format, layout)?,
        Some(moved) => tristrip_io::write(&moved.model, &moved.drawings(), format, moved.layout)?,
    };
    if let Some(rounding) = options.pack.filter(|_| format == Format::Glb) {
        bytes = tristrip_io::gltf::pack(bytes, rounding)?;
    }
    let written = reordered.as_ref().map_or(model, |moved| &moved.model);
    notes.extend(tristrip_io::losses(written, drawings, format));
    let unseen = tristrip_io::material_losses(model, format);
    let warnings = if unseen.is_empty() { Vec::new() } else { vec![unseen.join("; ")] };
    let mut faces = None;
    if options.verify {
        begin(observer, Stage::ReadBack)?;
        // The model that is read back shares the bytes. It is dropped after the proof.
        let shared = Arc::new(bytes);
        faces = Some(prove(model, &shared, format)?);
        bytes = Arc::unwrap_or_clone(shared);
    }
    let materials = model.materials.as_ref().filter(|_| format == Format::Obj);
    let files = materials.map(|materials| materials.files.clone()).unwrap_or_default();
    Ok(Outcome { bytes, faces, groups: reordered.map(|moved| moved.groups), notes, warnings, files })
}

/// The note for a GLB with restart indices.
const RESTART_NOTE: &str = "restarts in a GLB need the draft extension KHR_mesh_primitive_restart: viewers that ignore it, such as three.js, \
                            draw this file wrong; every viewer draws layout degenerate";

/// Returns whether a GLB gets restarts between strips.
fn has_restarts(drawings: &[Drawing<'_>], options: Options) -> bool {
    let several = |drawing: &Drawing<'_>| matches!(drawing, Drawing::Strips(strips) if strips.len() > 1);
    options.format == Format::Glb && options.layout == Layout::Restart && drawings.iter().any(several)
}

/// Reorders the vertices by first use.
fn reorder(
    model: &Model,
    drawings: &[Drawing<'_>],
    options: Options,
    observer: &dyn Observer,
) -> Result<Reordered, Error> {
    begin(observer, Stage::Reorder)?;
    Ok(tristrip_io::reorder(model, drawings, options.format, options.layout)?)
}

/// Returns a note per reason why parts kept their vertex order.
pub(crate) fn kept_groups(groups: &[VertexGroup]) -> Vec<String> {
    let mut by_reason: BTreeMap<&str, usize> = BTreeMap::new();
    for group in groups {
        if let Some(why) = &group.kept {
            *by_reason.entry(why).or_default() += group.parts.len();
        }
    }
    let note = |(why, parts)| format!("vertices not reordered in {}: {why}", counted(parts, "part"));
    by_reason.into_iter().map(note).collect()
}

/// Returns a note per reason why a scene keeps unused vertices.
pub(crate) fn kept_vertices(redrawn: &Redrawn) -> Vec<String> {
    let mut by_reason: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    for group in &redrawn.kept_groups {
        let (vertices, parts) = by_reason.entry(&group.why).or_default();
        (*vertices, *parts) = (*vertices + group.vertex_count, *parts + group.parts.len());
    }
    let note = |(why, (vertices, parts))| {
        format!("kept {} of {}: {why}", counted(vertices, "unused vertex"), counted(parts, "part"))
    };
    by_reason.into_iter().map(note).collect()
}

/// Reads the bytes back, verifies that they draw the source, and returns the number of faces.
fn prove(source: &Model, bytes: &Arc<Vec<u8>>, format: Format) -> Result<usize, Error> {
    let again =
        tristrip_io::read_shared(bytes, format).map_err(|error| Error::unproven(error.to_string()))?;
    match verify_models(&meshes(source), &meshes(&again))? {
        Ok(proof) => Ok(proof.faces),
        Err(difference) => Err(Error::unproven(difference.to_string())),
    }
}

/// Serializes whether a result is verified. `false` becomes `null`, which means that verification
/// was disabled. A result that fails verification is an error.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde calls")]
pub(crate) fn true_or_null<S: Serializer>(proven: &bool, serializer: S) -> Result<S::Ok, S::Error> {
    proven.then_some(true).serialize(serializer)
}
