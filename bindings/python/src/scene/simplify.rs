//! Simplification of a whole scene.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple, PyType};
use tristrip_io::Format;
use tristrip_io::gltf::Rounding;
use tristrip_pipeline::simplify::{self, CollapseRules, Normals};
use tristrip_pipeline::{Amount, encode};

use super::class::Scene;
use super::data::SceneData;
use super::output::{Destination, file_report};
use super::picture;
use crate::arguments::{Arguments, Keywords};
use crate::errors::Failure;
use crate::reports::{Report, report};
use crate::simplify::{deviation, goal};
use crate::work::{Watcher, Watching};

/// A simplified scene. Created by `Scene.simplify`.
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct SimplifiedScene {
    source: Arc<SceneData>,
    result: Arc<SceneData>,
    /// The arguments of `Scene.simplify`.
    arguments: Py<PyDict>,
    options: simplify::Options,
    /// The data for files. After unpickling, it is computed on first use.
    simplified: OnceLock<simplify::Outcome>,
    report: Py<PyAny>,
    proven: bool,
    notes: Vec<String>,
    warning: Option<String>,
    interrupted: bool,
}

/// The format a scene is simplified for by default. The format determines which vertices parts
/// share and which are referenced by other data.
pub(crate) const USUAL_FORMAT: Format = Format::Glb;

/// Takes the options of a simplification from the arguments of `Scene.simplify`.
fn options_of(arguments: &Arguments<'_>) -> PyResult<simplify::Options> {
    let error = arguments.take("error")?;
    let goal = goal(arguments.extract("ratio")?, arguments.extract("triangles")?, error.as_ref())?;
    let mut options = simplify::Options::default().with_goal(goal).with_rules(rules_of(arguments)?);
    if let Some(normals) = arguments.extract::<String>("normals")? {
        let normals: Result<Normals, String> = normals.parse();
        options = options.with_normals(normals.map_err(|why| Failure::Parameter(format!("normals: {why}")))?);
    }
    if arguments.flag("compact")? {
        options = options.with_rounding(Rounding::WeightsAndRotations);
    }
    let measure = arguments.extract("measure")?.unwrap_or(true);
    let verify = arguments.extract("verify")?.unwrap_or(true);
    let options = options.with_fit(arguments.flag("fit")?).with_measure(measure).with_verify(verify);
    arguments.finish("simplify")?;
    Ok(options.with_format(USUAL_FORMAT))
}

/// Takes the rules and prices of collapses from keyword arguments.
pub(crate) fn rules_of(arguments: &Arguments<'_>) -> PyResult<CollapseRules> {
    let mut rules = CollapseRules {
        permissive: arguments.flag("permissive")?,
        lock_borders: arguments.flag("lock_borders")?,
        ..CollapseRules::default()
    };
    if let Some(weight) = arguments.extract::<String>("weight")? {
        rules.weights = weight.parse().map_err(Failure::from)?;
    }
    if let Some(price) = arguments.extract::<String>("price")? {
        rules.price = price.parse().map_err(Failure::from)?;
    }
    if let Some(distance) = arguments.take("weld_distance")? {
        rules.weld_distance = deviation("weld_distance", &distance)?;
    }
    Ok(rules)
}

/// Simplifies a scene.
pub(crate) fn simplify<'py>(
    source: &Arc<SceneData>,
    arguments: &Arguments<'py>,
) -> PyResult<Bound<'py, SimplifiedScene>> {
    let watching = arguments.interruptible()?;
    let kept = arguments.rest()?;
    let py = kept.py();
    let mut options = options_of(arguments)?;
    let ended = watching.run(py, |watcher| Ok(simplify::run(source.model(), &options, watcher)?))?;
    let (simplified, figures) = (&ended.value, report(py, &ended.value)?.unbind());
    let interrupted = simplified.interrupted;
    if interrupted {
        // A later run for another format must have the same triangle count. Don't fit it if this
        // result was interrupted before the fit.
        let left = simplified.collapses.triangles_after;
        options.goal.amount = Some(Amount::Triangles(left));
        kept.del_item("ratio").ok();
        kept.set_item("triangles", left)?;
        options.fit &= simplified.moved_positions.is_some();
        kept.set_item("fit", options.fit)?;
    }
    ended.object(py, |simplified| SimplifiedScene {
        source: Arc::clone(source),
        result: Arc::new(SceneData::of_model(simplified.redrawn.model.clone())),
        arguments: kept.unbind(),
        options,
        report: figures,
        proven: simplified.proven,
        notes: simplified.notes.clone(),
        warning: simplified.warning.clone(),
        interrupted,
        simplified: simplified.into(),
    })
}

impl SimplifiedScene {
    /// Encodes the result for a destination. Simplifies again if the destination needs other
    /// vertices or images.
    fn encode(
        &self,
        destination: &Destination<'_>,
        verify: bool,
        watcher: &Watcher,
    ) -> Result<encode::Outcome, Failure> {
        let target = &destination.target;
        let model = self.source.model_for(target);
        let is_same = matches!(&model, Cow::Borrowed(model) if std::ptr::eq(*model, self.source.model()));
        let is_single = model.scene.is_none() && model.parts.len() < 2;
        if is_same && (target.format == self.options.format || is_single) {
            let known = if let Some(known) = self.simplified.get() {
                known
            } else {
                let found = simplify::run(&model, &self.options.with_measure(false), watcher)?;
                self.simplified.get_or_init(|| found)
            };
            return Ok(known.encode(target.format, verify, watcher)?);
        }
        let options = self.options.with_format(target.format).with_verify(verify).with_measure(false);
        let again = simplify::run(&model, &options, watcher)?;
        Ok(again.encode(target.format, verify, watcher)?)
    }

    fn destination<'a>(path: &'a Path, format: Option<&str>) -> Result<Destination<'a>, Failure> {
        Destination::file(path, format, Some("list"))
    }
}

#[pymethods]
impl SimplifiedScene {
    /// The source scene.
    #[getter]
    fn source(&self) -> Scene {
        Scene { data: Arc::clone(&self.source) }
    }

    /// The result as a scene, with its parts in the order of the source.
    #[getter]
    fn scene(&self) -> Scene {
        Scene { data: Arc::clone(&self.result) }
    }

    /// The report: a dictionary with the keys of the command's JSON.
    ///
    /// The keys include "triangles_before", "triangles_after", "moved_positions" (with `fit`),
    /// "surface_error" (in mesh units), "surface_error_percent" (of the diagonal), "rms_deviation",
    /// "normal_deviation_degrees", "uv_deviation_percent" and "vertices_kept".
    #[getter]
    fn report(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let copied = self.report.bind(py).cast::<PyDict>()?.copy()?;
        Ok(copied.into_any().unbind())
    }

    /// Whether the collapses were verified.
    #[getter]
    fn proven(&self) -> bool {
        self.proven
    }

    /// Notes on reading, dropped data and locked vertices.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// A message if the target was missed: the reason and what to try. None if the target was
    /// reached.
    #[getter]
    fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Whether Ctrl-C stopped the simplification early, or before the fit or measurement.
    #[getter]
    fn interrupted(&self) -> bool {
        self.interrupted
    }

    /// Write the result as triangle lists without newly unused vertices, as the command
    /// `simplify -o` does.
    ///
    /// Args:
    ///     path: the output file. An existing file is replaced after the new one is complete. A
    ///         .gltf file comes with a .bin file for its buffer, an OBJ file with its materials and
    ///         images.
    ///     format: "glb", "gltf", "ply" or "obj". By default the extension determines it. A glTF
    ///         scene is simplified again for other formats, because these formats keep no unused
    ///         vertices.
    ///     verify: whether to read the bytes back and verify them before the file is replaced.
    ///
    /// Returns:
    ///     A dictionary: "output", "proven", "faces", "bytes", "beside" (other files written),
    ///     "layout", "notes".
    ///
    /// Raises:
    ///     FileError: the file cannot be written.
    ///     ParameterError: the format is unknown.
    ///     NotProvenError: the bytes do not draw the result; nothing was written.
    #[pyo3(
        signature = (path, **given),
        text_signature = "($self, path, *, format=None, verify=True)"
    )]
    fn save<'py>(&self, py: Python<'py>, path: PathBuf, given: Option<Keywords<'_, 'py>>) -> Report<'py> {
        let arguments = Arguments::of(py, given)?;
        let format = arguments.extract::<String>("format")?;
        let verify = arguments.extract("verify")?.unwrap_or(true);
        arguments.finish("save")?;
        let destination = Self::destination(&path, format.as_deref())?;
        let saved = Watching::default().run(py, |watcher| {
            let encoded = self.encode(&destination, verify, watcher);
            let encoded = encoded.map_err(|failure| destination.unproven(failure))?;
            let written = destination.write(&encoded)?;
            Ok((encoded, written, self.source.image_notes(&destination.target)))
        });
        let (encoded, written, notes) = saved?.result()?;
        file_report(py, &destination, &encoded, &written, notes)
    }

    /// Return the bytes that `save` would write to a single file.
    ///
    /// Args:
    ///     format: "glb", "ply" or "obj".
    ///     verify: see `save`.
    #[pyo3(signature = (format = "glb", *, verify = true))]
    fn to_bytes<'py>(&self, py: Python<'py>, format: &str, verify: bool) -> PyResult<Bound<'py, PyBytes>> {
        let destination = Destination::memory(format, Some("list"))?;
        let encode = |watcher: &Watcher| self.encode(&destination, verify, watcher);
        Ok(PyBytes::new(py, &Watching::default().run(py, encode)?.result()?.bytes))
    }

    /// Render the scene before (upper row) and after (lower row) from eight sides, with base
    /// colours and textures.
    ///
    /// Args:
    ///     size: the width and height of each view in pixels.
    ///
    /// Returns:
    ///     The bytes of a PNG file.
    #[pyo3(signature = (size = 256))]
    fn picture<'py>(&self, py: Python<'py>, size: i64) -> PyResult<Bound<'py, PyBytes>> {
        picture::before_and_after(py, [&self.source, &self.result], size)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let report = self.report.bind(py);
        let number = |key: &str| report.get_item(key)?.extract::<usize>();
        let (before, after) = (number("triangles_before")?, number("triangles_after")?);
        let percent: f64 = report.get_item("surface_error_percent")?.extract()?;
        let before = tristrip_pipeline::text::count(before);
        let after = tristrip_pipeline::text::counted(after, "triangle");
        Ok(format!("SimplifiedScene({after} of {before}, surface error {percent:.3} % of the diagonal)"))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("simplified_scene_html", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let state = (
            this.source(),
            this.scene(),
            this.arguments.clone_ref(py),
            this.report(py)?,
            this.proven,
            this.notes(),
            this.warning(),
            this.interrupted,
        );
        Ok((slf.get_type().getattr("_restore")?, state.into_pyobject(py)?))
    }

    #[classmethod]
    #[allow(clippy::too_many_arguments, reason = "the state in a pickle")]
    fn _restore(
        _: &Bound<'_, PyType>,
        source: &Bound<'_, Scene>,
        scene: &Bound<'_, Scene>,
        arguments: Bound<'_, PyDict>,
        report: Py<PyAny>,
        proven: bool,
        notes: Vec<String>,
        warning: Option<String>,
        interrupted: bool,
    ) -> PyResult<Self> {
        let (source, result) = (Arc::clone(&source.get().data), Arc::clone(&scene.get().data));
        let options = options_of(&Arguments::of(arguments.py(), Some(&arguments))?)?;
        let (simplified, arguments) = (OnceLock::new(), arguments.unbind());
        Ok(Self {
            source,
            result,
            arguments,
            options,
            simplified,
            report,
            proven,
            notes,
            warning,
            interrupted,
        })
    }
}
