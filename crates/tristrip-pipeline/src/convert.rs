//! Conversion between formats and strip layouts. No new strips are built.

use serde::Serialize;
use tristrip::{Layout, Mesh, Method, StripifyOptions, Strips};
use tristrip_io::{Drawing, Format, Model, Part};

use crate::encode;
use crate::error::Error;
use crate::observer::{Observer, Stage, begin};
use crate::parts::meshes;
use crate::prepared::PreparedModel;

/// Options for converting a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// The format of the file.
    pub format: Format,
    /// The layout in which all parts are written as strips, in their stored order; `None` keeps
    /// faces as faces and strips as strips.
    pub layout: Option<Layout>,
    /// Whether the bytes are read back and verified.
    pub verify: bool,
}

impl Options {
    /// Creates options for a format. Faces stay faces, and strips stay strips if the format
    /// supports strips.
    pub fn new(format: Format) -> Self {
        Self { format, layout: None, verify: true }
    }

    tristrip::setters! {
        /// Sets the layout in which all parts are drawn as strips, in their stored order.
        with_layout(layout: Layout) as Some;

        /// Sets whether the bytes are read back and verified.
        with_verify(verify: bool);
    }

    /// Returns whether a part is drawn as strips.
    fn draws_strips(self, part: &Part) -> bool {
        self.layout.is_some() || (part.stripped && self.format != Format::Obj)
    }
}

/// A converted model. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// Whether the file draws exactly the faces of the input when it is read back; `null` in
    /// reports if verification was disabled.
    #[serde(serialize_with = "encode::true_or_null")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<bool>"))]
    pub proven: bool,
    /// The number of faces of the input.
    pub faces: usize,
    /// The number of triangles of the input: k − 2 per face of k corners.
    pub triangles: usize,
    /// The number of strips; `None` if the file has only faces.
    pub strips: Option<usize>,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// Human-readable notes on data that was read, dropped, changed or unusual.
    pub notes: Vec<String>,
    /// The strips of each part; `None` for a part drawn as faces.
    #[serde(skip)]
    pub drawn: Vec<Option<Strips>>,
    /// The file.
    #[serde(skip)]
    pub encoded: encode::Outcome,
}

/// Converts a model, and verifies the result.
///
/// # Errors
/// The format cannot store the model, the bytes fail verification, or the observer cancelled the
/// operation.
///
/// ```
/// use tristrip::Layout;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::convert;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let ply = convert::run(&model, &convert::Options::new(Format::Ply), &())?;
/// assert!(ply.strips.is_none(), "the polygon stays a polygon");
/// let read_back = read(&ply.encoded.bytes, Format::Ply)?;
/// assert_eq!(read_back.parts[0].mesh.faces().iter().next().map(<[u32]>::len), Some(4));
/// let glb = convert::Options::new(Format::Glb).with_layout(Layout::Restart);
/// assert_eq!(convert::run(&model, &glb, &())?.strips, Some(1));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    let drawn = strips_as_stored(model, *options, observer)?;
    let drawings: Vec<_> =
        drawn.iter().map(|strips| strips.as_ref().map_or(Drawing::Faces, Drawing::Strips)).collect();
    let encoding = encode::Options::new(options.format).with_verify(options.verify);
    let encoding = options.layout.map_or(encoding, |layout| encoding.with_layout(layout));
    let encoded = encode::run(model, &drawings, &encoding, observer)?;
    let has_strips = options.layout.is_some() || drawn.iter().any(Option::is_some);
    let meshes = meshes(model);
    Ok(Outcome {
        proven: options.verify,
        faces: meshes.iter().map(|mesh| mesh.faces().face_count()).sum(),
        triangles: meshes.iter().map(|mesh| mesh.faces().triangle_count()).sum(),
        strips: has_strips.then(|| drawn.iter().flatten().map(Strips::len).sum()),
        parts: meshes.len(),
        notes: model.notes.clone(),
        drawn,
        encoded,
    })
}

/// Returns the strips of each part in their stored order; `None` for a part that is drawn as faces.
fn strips_as_stored(
    model: &Model,
    options: Options,
    observer: &dyn Observer,
) -> Result<Vec<Option<Strips>>, Error> {
    let drawn: Vec<&Part> = model.parts.iter().filter(|part| options.draws_strips(part)).collect();
    let mut found = Vec::new();
    if options.layout.is_some() || !drawn.is_empty() {
        begin(observer, Stage::Prepare)?;
        let meshes: Vec<&Mesh> = drawn.iter().map(|part| &part.mesh).collect();
        let prepared = PreparedModel::of_meshes(&meshes, false);
        found = prepared.search(&StripifyOptions::default().with_method(Method::Input), observer)?.0;
    }
    let mut found = found.into_iter();
    let next = |part| if options.draws_strips(part) { found.next() } else { None };
    Ok(model.parts.iter().map(next).collect())
}
