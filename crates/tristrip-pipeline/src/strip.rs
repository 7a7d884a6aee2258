//! Strips of a whole model: built, measured, compared with their lower bounds and proven.

use tristrip::{Method, StripifyOptions, Strips};
use tristrip_io::Model;

use crate::bounds::{BoundGap, Bounds};
use crate::drawing::{Drawn, choose};
use crate::encode::{EncodeOptions, Encoded, encode_observed};
use crate::error::Error;
use crate::figures::{Figures, MeshFigures, PartFigures};
use crate::observer::{Event, Observer, Stage, Stopped, begin};
use crate::prepared::Survey;

/// How strips are built. The default is [`Method::Best`], proven.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct StripOptions {
    /// The method and its options.
    pub stripify: StripifyOptions,
    /// Whether the strips are proven to draw exactly the faces of the model.
    pub verify: bool,
}

impl Default for StripOptions {
    fn default() -> Self {
        Self { stripify: StripifyOptions::default(), verify: true }
    }
}

impl StripOptions {
    /// Sets the method and its options.
    #[must_use]
    pub fn with_stripify(self, stripify: StripifyOptions) -> Self {
        Self { stripify, ..self }
    }

    /// Sets whether the strips are proven.
    #[must_use]
    pub fn with_verify(self, verify: bool) -> Self {
        Self { verify, ..self }
    }
}

/// The strips of a model.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Stripped {
    /// The strips of each part, over its own vertices, in the order of the parts.
    pub strips: Vec<Strips>,
    /// The metrics of the strips.
    pub figures: Figures,
    /// The counts of the mesh.
    pub mesh: MeshFigures,
    /// The gap between the result of `fewest`, or of `best` above its default effort, and its lower bound; `None` for others, which take
    /// no longer than the bound does.
    pub bound: Option<BoundGap>,
    /// The options of the method, adapted to the model.
    pub options: StripifyOptions,
    /// Why the search was stopped early, if it was.
    pub stopped: Option<Stopped>,
    /// Notes of the reader, and on what was dropped, changed or unusual.
    pub notes: Vec<String>,
    /// Whether the strips are proven to draw exactly the faces of the model.
    pub proven: bool,
    /// The figures of each part.
    of_parts: Vec<PartFigures>,
}

impl Stripped {
    /// Encodes the model as a file that draws each part as [`Stripped::draw`] chooses, and proves it.
    ///
    /// # Errors
    /// As of [`encode_observed`].
    pub fn encode(&self, model: &Model, options: &EncodeOptions) -> Result<Encoded, Error> {
        encode_observed(model, &self.draw(model, options).drawings, options, &())
    }

    /// Chooses how each part is drawn, by the fewest indices: as the strips found, as the strips that the
    /// source stores, or as a list. The strips of [`Method::Cache`], which optimizes misses and not indices, are always drawn.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{DrawnAs, EncodeOptions, StripOptions, strip};
    /// let flat = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
    /// let model = read(flat, Format::Obj)?;
    /// let stripped = strip(&model, &StripOptions::default())?;
    /// let drawn = stripped.draw(&model, &EncodeOptions::new(Format::Glb));
    /// assert_eq!((drawn.drawn_as[0], drawn.before.indices, drawn.after.indices), (DrawnAs::List, 6, 6));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn draw<'a>(&'a self, model: &'a Model, options: &EncodeOptions) -> Drawn<'a> {
        choose(model, (&self.strips, &self.of_parts), *options, self.options.method == Method::Cache)
    }
}

/// Builds the strips of a model, measures and proves them.
///
/// # Errors
/// As of [`strip_observed`].
///
/// ```
/// use tristrip::{Method, StripifyOptions};
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{StripOptions, strip};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let fewest = StripifyOptions::default().with_method(Method::Fewest);
/// let stripped = strip(&model, &StripOptions::default().with_stripify(fewest))?;
/// assert_eq!(stripped.bound.map(|gap| (gap.found, gap.optimal)), Some((1, true)));
/// assert_eq!(stripped.strips[0].len(), 1);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn strip(model: &Model, options: &StripOptions) -> Result<Stripped, Error> {
    strip_observed(model, options, &())
}

/// Does the same, and reports each stage to an observer.
///
/// # Errors
/// A part is too large, an option has an invalid value, the strips are not proven, or the observer cancelled.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Error, Observer, StripOptions, strip_observed};
/// struct Impatient;
/// impl Observer for Impatient {
///     fn is_cancelled(&self) -> bool {
///         true
///     }
/// }
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// let stripped = strip_observed(&model, &StripOptions::default(), &Impatient);
/// assert!(matches!(stripped, Err(Error::Cancelled)));
/// # Ok::<(), Error>(())
/// ```
pub fn strip_observed(
    model: &Model,
    options: &StripOptions,
    observer: &dyn Observer,
) -> Result<Stripped, Error> {
    let survey = Survey::new(model, options.stripify, observer)?;
    let (strips, stopped) = survey.prepared.search(&survey.options, observer)?;
    measured(survey, strips, stopped, options.verify, observer)
}

/// Measures strips of a model that were found before, one item per part, and proves them; `options` and `stopped` are those of their search.
///
/// # Errors
/// There is not one item per part, the strips are not proven, or the observer cancelled.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{StripOptions, strip, with_strips};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let found = strip(&model, &StripOptions::default())?;
/// let again = with_strips(&model, found.strips.clone(), None, &StripOptions::default(), &())?;
/// assert_eq!(again.figures, found.figures);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn with_strips(
    model: &Model,
    strips: Vec<Strips>,
    stopped: Option<Stopped>,
    options: &StripOptions,
    observer: &dyn Observer,
) -> Result<Stripped, Error> {
    if strips.len() != model.parts.len() {
        let (found, expected) = (strips.len(), model.parts.len());
        return Err(Error::Unproven(format!("found strips of {found} parts, expected {expected}")));
    }
    measured(Survey::new(model, options.stripify, observer)?, strips, stopped, options.verify, observer)
}

/// Measures strips, compares them with their lower bounds, and proves them if requested.
fn measured(
    survey: Survey<'_>,
    strips: Vec<Strips>,
    stopped: Option<Stopped>,
    verify: bool,
    observer: &dyn Observer,
) -> Result<Stripped, Error> {
    let Survey { prepared, options: stripify, mesh, notes } = survey;
    begin(observer, Stage::Measure)?;
    let (figures, of_parts) = prepared.figures_with_parts(&strips, &stripify)?;
    observer.event(Event::Measured(&figures));
    let mut bound = None;
    if is_long_search(&stripify) {
        begin(observer, Stage::Bound)?;
        bound = Bounds::of(prepared.parts())?.gap(&stripify, &figures);
        observer.event(Event::Bounded(bound.as_ref()));
    }
    if verify {
        begin(observer, Stage::Prove)?;
        prepared.prove(&strips)?;
        observer.event(Event::Proven { faces: mesh.faces });
    }
    Ok(Stripped { strips, figures, mesh, bound, options: stripify, stopped, notes, proven: verify, of_parts })
}

/// Returns whether the options ask for a search that takes longer than the bound of its result.
fn is_long_search(options: &StripifyOptions) -> bool {
    match options.method {
        Method::Best => options.effort_or_default() > StripifyOptions::default().effort_or_default(),
        Method::Fewest => true,
        _ => false,
    }
}
