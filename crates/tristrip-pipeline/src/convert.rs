//! Conversion between formats and strip layouts, without new strips.

use tristrip::{Layout, Mesh, Method, StripifyOptions, Strips};
use tristrip_io::{Drawing, Format, Model, Part};

use crate::encode::{EncodeOptions, Encoded, encode_observed};
use crate::error::Error;
use crate::observer::{Event, Observer, Stage, begin};
use crate::prepared::PreparedModel;

/// How a model is converted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct ConvertOptions {
    /// The format of the file.
    pub format: Format,
    /// The layout of all parts as strips in their stored order; `None` to keep faces as faces and strips as strips.
    pub layout: Option<Layout>,
    /// Whether the bytes are read back and proven.
    pub verify: bool,
}

impl ConvertOptions {
    /// Chooses a format; faces stay faces, strips stay strips where the format has them.
    pub fn new(format: Format) -> Self {
        Self { format, layout: None, verify: true }
    }

    /// Draws all parts as strips in their stored order, in a layout.
    #[must_use]
    pub fn with_layout(self, layout: Layout) -> Self {
        Self { layout: Some(layout), ..self }
    }

    /// Sets whether the bytes are read back and proven.
    #[must_use]
    pub fn with_verify(self, verify: bool) -> Self {
        Self { verify, ..self }
    }

    /// Encodes a model with these strips, and faces where a part has none.
    ///
    /// # Errors
    /// The strips do not fit the model, the format cannot store it, the bytes are not proven, or the observer cancelled.
    pub fn encode(
        &self,
        model: &Model,
        strips: &[Option<Strips>],
        observer: &dyn Observer,
    ) -> Result<Encoded, Error> {
        let drawings: Vec<_> =
            strips.iter().map(|strips| strips.as_ref().map_or(Drawing::Faces, Drawing::Strips)).collect();
        let options = EncodeOptions::new(self.format).with_verify(self.verify);
        let options = self.layout.map_or(options, |layout| options.with_layout(layout));
        encode_observed(model, &drawings, &options, observer)
    }

    /// Returns whether a part is drawn as strips.
    fn draws_strips(self, part: &Part) -> bool {
        self.layout.is_some() || (part.stripped && self.format != Format::Obj)
    }
}

/// A converted model.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Converted {
    /// The strips of each part; `None` for a part drawn as faces.
    pub strips: Vec<Option<Strips>>,
    /// The file.
    pub encoded: Encoded,
}

/// Converts a model, and proves the result.
///
/// # Errors
/// As of [`convert_observed`].
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{ConvertOptions, convert};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let ply = convert(&model, &ConvertOptions::new(Format::Ply))?;
/// assert!(ply.strips[0].is_none(), "the polygon stays a polygon");
/// assert_eq!(read(&ply.encoded.bytes, Format::Ply)?.parts[0].mesh.faces().iter().next().map(<[u32]>::len), Some(4));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn convert(model: &Model, options: &ConvertOptions) -> Result<Converted, Error> {
    convert_observed(model, options, &())
}

/// Does the same, and reports each stage to an observer.
///
/// # Errors
/// The format cannot store the model, the bytes are not proven, or the observer cancelled.
///
/// ```
/// use tristrip::Layout;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{ConvertOptions, convert_observed};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let options = ConvertOptions::new(Format::Glb).with_layout(Layout::Restart);
/// let converted = convert_observed(&model, &options, &())?;
/// assert_eq!(converted.strips[0].as_ref().map(|strips| strips.len()), Some(1));
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn convert_observed(
    model: &Model,
    options: &ConvertOptions,
    observer: &dyn Observer,
) -> Result<Converted, Error> {
    let strips = strips_as_stored(model, options, observer)?;
    let encoded = options.encode(model, &strips, observer)?;
    Ok(Converted { strips, encoded })
}

/// Returns the strips of each part in their stored order; `None` for a part that the options draw as faces. The stages are reported to the
/// observer.
///
/// # Errors
/// The observer cancelled.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{ConvertOptions, strips_as_stored};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// assert!(strips_as_stored(&model, &ConvertOptions::new(Format::Ply), &())?[0].is_none());
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn strips_as_stored(
    model: &Model,
    options: &ConvertOptions,
    observer: &dyn Observer,
) -> Result<Vec<Option<Strips>>, Error> {
    let drawn: Vec<&Part> = model.parts.iter().filter(|part| options.draws_strips(part)).collect();
    let mut found = Vec::new();
    if options.layout.is_some() || !drawn.is_empty() {
        begin(observer, Stage::Prepare)?;
        let meshes: Vec<&Mesh> = drawn.iter().map(|part| &part.mesh).collect();
        let prepared = PreparedModel::of_meshes(&meshes, false);
        observer.event(Event::Prepared);
        found = prepared.search(&StripifyOptions::default().with_method(Method::Input), observer)?.0;
    }
    let mut found = found.into_iter();
    let next = |part| if options.draws_strips(part) { found.next() } else { None };
    Ok(model.parts.iter().map(next).collect())
}
