//! Builds, measures and verifies the strips of a whole model, and compares them with their lower
//! bounds.

use serde::Serialize;
use tristrip::text::counted;
use tristrip::{Method, StripifyOptions, Strips};
use tristrip_io::Model;

use crate::bounds::{BoundGap, Bounds};
use crate::drawing::{Drawn, DrawnParts, FileCost, choose};
use crate::encode::{self, true_or_null};
use crate::error::{Error, UnprovenMetrics};
use crate::figures::{MeshProperties, PartMetrics};
use crate::method::MethodDescription;
use crate::metrics::StripMetrics;
use crate::observer::{Observer, SearchStop, Stage, begin};
use crate::prepared::Survey;

/// Options for building strips. The default is [`Method::Best`] with verification.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Options {
    /// The method and its options.
    pub stripify: StripifyOptions,
    /// Whether the strips are verified to draw exactly the faces of the model.
    pub verify: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { stripify: StripifyOptions::default(), verify: true }
    }
}

impl Options {
    tristrip::setters! {
        /// Sets the method and its options.
        with_stripify(stripify: StripifyOptions);

        /// Sets whether the strips are verified.
        with_verify(verify: bool);
    }
}

/// The strips of a model. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Outcome {
    /// The strips of each part, over its own vertices, in the order of the parts.
    #[serde(skip)]
    pub strips: Vec<Strips>,
    /// The options of the method, adapted to the model.
    #[serde(skip)]
    pub stripify: StripifyOptions,
    /// The method and the options that it uses.
    #[serde(flatten)]
    pub method: MethodDescription,
    /// Whether the strips draw exactly the faces of the model, and a written file draws the same
    /// faces when it is read back; `null` in reports if verification was disabled.
    #[serde(serialize_with = "true_or_null")]
    #[cfg_attr(feature = "schema", schemars(with = "Option<bool>"))]
    pub proven: bool,
    /// The metrics of the strips.
    #[serde(flatten)]
    pub metrics: StripMetrics,
    /// Why the search ended before its effort was spent; `None` if it was not stopped.
    pub stopped: Option<SearchStop>,
    /// The gap between the result and its lower bound, for `fewest`, and for `best` above its
    /// default effort. `None` otherwise, because the bound takes at least as long as those
    /// searches.
    pub bound: Option<BoundGap>,
    /// The vertex, edge and face counts of the mesh.
    pub mesh: MeshProperties,
    /// The number of parts: glTF primitives or OBJ materials.
    pub parts: usize,
    /// Human-readable notes on data that was read, dropped, changed or unusual, and on a search
    /// that was stopped.
    pub notes: Vec<String>,
    /// The metrics that decide how each part is drawn.
    #[serde(skip)]
    of_parts: Vec<PartMetrics>,
}

/// A file of strips. The field names are the keys of the JSON report.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct File {
    /// The bytes of the file. Its first notes report parts that are not drawn with the strips of
    /// the method.
    #[serde(skip)]
    pub encoded: encode::Outcome,
    /// The number of parts per kind of drawing.
    pub drawn: DrawnParts,
    /// The cost of the source as it was read. The caller sets the file size.
    pub before: FileCost,
    /// The file.
    pub after: FileCost,
}

impl Outcome {
    /// Encodes the model as a file, with the drawings that [`Outcome::draw`] chooses, and verifies
    /// it.
    ///
    /// # Errors
    /// The strips do not belong to the model, the format cannot store it, the bytes fail
    /// verification, or the observer cancelled the operation.
    pub fn encode(
        &self,
        model: &Model,
        options: &encode::Options,
        observer: &dyn Observer,
    ) -> Result<File, Error> {
        let drawn = self.draw(model, options);
        let encoded = encode::run(model, &drawn.drawings, options, observer);
        let mut encoded = encoded.map_err(|error| error.with_metrics(|| self.unproven()))?;
        encoded.notes.splice(0..0, drawn.parts().notes());
        Ok(File {
            drawn: drawn.parts(),
            before: FileCost::of(&drawn.before, None),
            after: FileCost::of(&drawn.after, Some(encoded.bytes.len() as u64)),
            encoded,
        })
    }

    /// Chooses how each part is drawn, by the fewest indices: as the strips of the method, as the
    /// strips that the source stores, or as a list. Strips of [`Method::Cache`] are always drawn,
    /// because they optimize misses and not indices.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{DrawnAs, encode, strip};
    /// let flat = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
    /// let model = read(flat, Format::Obj)?;
    /// let stripped = strip::run(&model, &strip::Options::default(), &())?;
    /// let drawn = stripped.draw(&model, &encode::Options::new(Format::Glb));
    /// assert_eq!((drawn.drawn_as[0], drawn.before.indices, drawn.after.indices), (DrawnAs::List, 6, 6));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn draw<'a>(&'a self, model: &'a Model, options: &encode::Options) -> Drawn<'a> {
        choose(model, (&self.strips, &self.of_parts), *options, self.stripify.method == Method::Cache)
    }

    fn unproven(&self) -> UnprovenMetrics {
        UnprovenMetrics::Strips(self.metrics.clone())
    }
}

/// Builds, measures and verifies the strips of a model.
///
/// # Errors
/// A part is too large, an option has an invalid value, the strips fail verification, or the
/// observer cancelled the operation.
///
/// ```
/// use tristrip::{Method, StripifyOptions};
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::strip;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", Format::Obj)?;
/// let fewest = StripifyOptions::default().with_method(Method::Fewest);
/// let stripped = strip::run(&model, &strip::Options::default().with_stripify(fewest), &())?;
/// assert_eq!(stripped.bound.map(|gap| (gap.found, gap.optimal)), Some((1, true)));
/// assert_eq!(stripped.strips[0].len(), 1);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub fn run(model: &Model, options: &Options, observer: &dyn Observer) -> Result<Outcome, Error> {
    let survey = Survey::new(model, options.stripify, observer)?;
    let (strips, stopped) = survey.prepared.search(&survey.options, observer)?;
    measured(survey, strips, stopped, options.verify, observer)
}

/// Measures and verifies existing strips of a model, one item per part. `options` and `stopped`
/// belong to the search that built them.
///
/// # Errors
/// The number of items differs from the number of parts, the strips fail verification, or the
/// observer cancelled the operation.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::{Error, strip};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let options = strip::Options::default();
/// let found = strip::run(&model, &options, &())?;
/// let again = strip::of_strips(&model, found.strips.clone(), None, &options, &())?;
/// assert_eq!(again.metrics, found.metrics);
/// // Strips for half of the square: the error has their metrics.
/// let mut half = tristrip::Strips::default();
/// half.push(&[0, 1, 2]);
/// let half = strip::of_strips(&model, vec![half], None, &options, &());
/// assert!(matches!(half, Err(Error::Unproven { metrics: Some(_), .. })));
/// # Ok::<(), Error>(())
/// ```
pub fn of_strips(
    model: &Model,
    strips: Vec<Strips>,
    stopped: Option<SearchStop>,
    options: &Options,
    observer: &dyn Observer,
) -> Result<Outcome, Error> {
    if strips.len() != model.parts.len() {
        let (found, expected) = (strips.len(), model.parts.len());
        return Err(Error::unproven(format!(
            "found strips of {}, expected {expected}",
            counted(found, "part")
        )));
    }
    measured(Survey::new(model, options.stripify, observer)?, strips, stopped, options.verify, observer)
}

/// Measures strips, compares them with their lower bounds, and verifies them if requested.
fn measured(
    survey: Survey<'_>,
    strips: Vec<Strips>,
    stopped: Option<SearchStop>,
    verify: bool,
    observer: &dyn Observer,
) -> Result<Outcome, Error> {
    let Survey { prepared, options: stripify, mesh, mut notes } = survey;
    notes.extend(stopped.map(|stopped| stopped.note().into()));
    begin(observer, Stage::Measure)?;
    let (metrics, of_parts) = prepared.metrics_with_parts(&strips, &stripify)?;
    let mut bound = None;
    if is_long_search(&stripify) {
        begin(observer, Stage::Bound)?;
        bound = Bounds::of(prepared.parts())?.gap(&stripify, &metrics);
    }
    let method = MethodDescription::of(&stripify);
    let parts = prepared.parts().len();
    let outcome = Outcome {
        strips,
        stripify,
        method,
        proven: verify,
        metrics,
        stopped,
        bound,
        mesh,
        parts,
        notes,
        of_parts,
    };
    if verify {
        begin(observer, Stage::Prove)?;
        let proof = prepared.prove(&outcome.strips);
        proof.map_err(|error| error.with_metrics(|| outcome.unproven()))?;
    }
    Ok(outcome)
}

/// Returns whether the options select a search that takes longer than the bound of its result.
fn is_long_search(options: &StripifyOptions) -> bool {
    match options.method {
        Method::Best => options.effort_or_default() > StripifyOptions::default().effort_or_default(),
        Method::Fewest => true,
        _ => false,
    }
}
