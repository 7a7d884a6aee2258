//! Chains of levels of detail of a whole scene.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyTuple, PyType};
use tristrip::Layout;
use tristrip_io::{Format, Model};
use tristrip_pipeline::chain::{Chain as BuiltChain, Options, run};
use tristrip_pipeline::{WrittenFiles, chain::ChainRatios, encode, path_of_level};

use super::class::Scene;
use super::data::SceneData;
use super::output::Destination;
use super::simplify::rules_of;
use crate::arguments::Arguments;
use crate::errors::Failure;
use crate::method;
use crate::reports::report;
use crate::simplify::deviation;
use crate::strips::layout_of;
use crate::work::{Watcher, Watching};

/// A chain of levels of detail of a scene over one vertex buffer, finest first.
///
/// Each level uses a prefix of the vertices of the previous one. Created by `Scene.chain`.
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct Chain {
    source: Arc<SceneData>,
    /// The arguments of `Scene.chain`.
    arguments: Py<PyDict>,
    options: Options,
    /// The data for a GLB. After unpickling, it is computed on first use.
    built: OnceLock<BuiltChain>,
    report: Py<PyDict>,
}

/// Builds the levels of a scene.
pub(crate) fn chain(
    source: &Arc<SceneData>,
    ratios: Option<&Bound<'_, PyAny>>,
    arguments: &Arguments<'_>,
) -> PyResult<Chain> {
    let watching = arguments.watching()?;
    let kept = arguments.rest()?;
    let py = kept.py();
    kept.set_item("ratios", ratios)?;
    let options = options_of(&Arguments::of(py, Some(&kept))?)?;
    let built = watching.run(py, |watcher| Ok(run(source.model(), &options, watcher)?));
    let built = built?.result()?;
    let found = report(py, &built)?.cast_into::<PyDict>()?;
    let (report, arguments) = (found.unbind(), kept.unbind());
    Ok(Chain { source: Arc::clone(source), arguments, options, built: built.chain.into(), report })
}

/// Takes the options of a chain from the arguments of `Scene.chain`.
fn options_of(arguments: &Arguments<'_>) -> PyResult<Options> {
    let ratios = arguments.take("ratios")?.map(|given| ratios(&given)).transpose()?.unwrap_or_default();
    let error = arguments.take("error")?.map(|error| deviation("error", &error)).transpose()?;
    let options = Options::new(ratios, Format::Glb).with_deviation(error.unwrap_or_default());
    let options = options.with_rules(rules_of(arguments)?);
    let options = options.with_verify(arguments.extract("verify")?.unwrap_or(true));
    // Validates the budget now; it is used when files are written.
    Watching::new(arguments.py(), None, arguments.extract("budget")?, "raise")?;
    let layout = arguments.extract::<String>("layout")?.map(|layout| layout_of(&layout)).transpose()?;
    // Strips save no indices in triangle lists, but a cache-friendly order still helps.
    let usual = if layout == Some(Layout::List) { "cache" } else { "best" };
    Ok(options.with_stripify(method::taken(arguments, usual)?))
}

/// Parses ratios: a string such as "100%,50%", or a sequence of numbers.
fn ratios(given: &Bound<'_, PyAny>) -> Result<ChainRatios, Failure> {
    let text = if let Ok(text) = given.extract::<String>() {
        text
    } else {
        let expected = "decreasing numbers from 0 to 1, or a string such as '100%,50%,25%'";
        let numbers: Vec<f64> = given.extract().map_err(|_| Failure::option("ratios", given, expected))?;
        numbers.iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
    };
    text.parse().map_err(|why| Failure::Parameter(format!("ratios: {why}")))
}

/// A written file, or its bytes.
struct ChainFile {
    encoded: encode::Outcome,
    /// The bytes of the file that each level uses.
    level_bytes: Vec<usize>,
    written: WrittenFiles,
    output: Option<String>,
    layout: Layout,
}

impl Chain {
    fn layout(&self, py: Python<'_>) -> PyResult<Option<String>> {
        self.arguments.bind(py).get_item("layout")?.map_or(Ok(None), |layout| layout.extract())
    }

    fn watching(&self, py: Python<'_>, progress: Option<Bound<'_, PyAny>>) -> PyResult<Watching> {
        let budget =
            self.arguments.bind(py).get_item("budget")?.map_or(Ok(None), |budget| budget.extract())?;
        Ok(Watching::new(py, progress, budget, "raise")?)
    }

    /// Calls a function with the levels for a destination. Rebuilds them for another format or
    /// other images.
    fn with_levels<T>(
        &self,
        destination: &Destination<'_>,
        watcher: &Watcher,
        call: impl FnOnce(&Model, &BuiltChain) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let model = self.source.model_for(&destination.target);
        let is_same = matches!(&model, Cow::Borrowed(model) if std::ptr::eq(*model, self.source.model()));
        let format = destination.target.format;
        if is_same && format == self.options.format {
            if let Some(built) = self.built.get() {
                return call(&model, built);
            }
            let built = run(&model, &self.options, watcher)?.chain;
            return call(&model, self.built.get_or_init(|| built));
        }
        let options = self.options.clone().with_format(format);
        call(&model, &run(&model, &options, watcher)?.chain)
    }

    fn encode_options(destination: &Destination<'_>, verify: bool) -> encode::Options {
        let options = encode::Options::new(destination.target.format).with_layout(destination.layout);
        options.with_list(!destination.is_chosen).with_verify(verify)
    }

    /// Encodes all levels as one GLB.
    fn encode_scene(
        &self,
        destination: &Destination<'_>,
        verify: bool,
        watcher: &Watcher,
    ) -> Result<(encode::Outcome, Vec<usize>), Failure> {
        if destination.target.format != Format::Glb {
            let found = format!("'{}'", destination.target.format.extension());
            return Err(Failure::option(
                "format",
                found,
                "'glb' or 'gltf', or a directory for a file per level",
            ));
        }
        let options = Self::encode_options(destination, verify);
        self.with_levels(destination, watcher, |model, chain| {
            let file = chain.encode(model, &options, watcher)?;
            Ok((file.encoded, file.level_bytes))
        })
    }

    /// Writes each level to its own file.
    fn write_levels(
        &self,
        directory: &Path,
        format: &str,
        layout: Option<&str>,
        verify: bool,
        watcher: &Watcher,
    ) -> Result<Vec<(ChainFile, Vec<String>)>, Failure> {
        let stem = self.source.path().and_then(Path::file_stem).unwrap_or("scene".as_ref());
        let mut name = stem.to_owned();
        name.push(format!(".{}", format.strip_prefix('.').unwrap_or(format)));
        let file = directory.join(name);
        let mut destination = Destination::file(&file, Some(format), layout)?;
        destination.target.creates_folder = true;
        let options = Self::encode_options(&destination, verify);
        self.with_levels(&destination, watcher, |model, chain| {
            let each = (0..self.options.ratios.as_slice().len()).map(|level| {
                let path = path_of_level(&file, level);
                let mut destination = destination;
                destination.target.path = Some(&path);
                let encoded = chain.encode_level(model, level, &options, watcher);
                let encoded = encoded.map_err(|error| destination.unproven(error.into()))?;
                let written = destination.write(&encoded)?;
                let notes = encoded.all_notes();
                let (level_bytes, output) = (vec![written.bytes], Some(path.display().to_string()));
                let layout = destination.layout;
                Ok((ChainFile { encoded, level_bytes, written, output, layout }, notes))
            });
            each.collect()
        })
    }

    /// Reports the levels with their sizes and files.
    fn levels_with<'py>(
        &self,
        py: Python<'py>,
        bytes: &[usize],
        outputs: &[Option<String>],
    ) -> PyResult<Bound<'py, PyList>> {
        let found = PyList::empty(py);
        for (number, level) in self.levels(py)?.try_iter()?.enumerate() {
            let level = level?.cast_into::<PyDict>()?.copy()?;
            level.set_item("bytes", bytes.get(number))?;
            level.set_item("output", outputs.get(number).cloned().flatten())?;
            found.append(level)?;
        }
        Ok(found)
    }
}

#[pymethods]
impl Chain {
    /// The source scene.
    #[getter]
    fn source(&self) -> Scene {
        Scene { data: Arc::clone(&self.source) }
    }

    /// The levels, finest first.
    ///
    /// A list of dictionaries: "level", "ratio", "target_triangles", "triangles", "vertices" (the
    /// length of the vertex prefix), "surface_error" (in mesh units), "surface_error_percent" (of
    /// the diagonal), "screen_coverage" (the level is drawn down to this ratio of the screen) and
    /// "reached".
    #[getter]
    fn levels<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.report.bind(py).as_any().get_item("chain")
    }

    /// The report: a dictionary with the keys of the command's JSON.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.report.bind(py).copy()
    }

    /// A message about levels that missed their target; None if all levels reached it.
    #[getter]
    fn warning<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.report.bind(py).as_any().get_item("warning")
    }

    /// Notes on reading, dropped data and locked vertices.
    #[getter]
    fn notes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.report.bind(py).as_any().get_item("notes")
    }

    /// Write all levels, as the command `chain` does.
    ///
    /// The output is one GLB or .gltf file whose nodes refer to coarser levels with `MSFT_lod`, or
    /// a directory with one file per level.
    ///
    /// Args:
    ///     path: the file or directory. A path that ends with a slash is a directory, which is
    ///         created if it does not exist.
    ///     format: the format of the files in a directory: "glb", "gltf", "ply" or "obj". The
    ///         default is "glb".
    ///     verify: whether to read the bytes back and verify them before a file is replaced.
    ///     progress: see `stripify`.
    ///
    /// Returns:
    ///     A dictionary: "output", "layout", "proven", "chain" (the levels with "bytes" and
    ///     "output"), "notes", "beside" (other files written).
    ///
    /// Raises:
    ///     FileError: a file cannot be written.
    ///     ParameterError: the format is unknown, or supports only one level per file.
    ///     NotProvenError: the bytes do not draw a level; that file was not written.
    #[pyo3(signature = (path, *, format = None, verify = true, progress = None))]
    fn save<'py>(
        &self,
        py: Python<'py>,
        path: PathBuf,
        format: Option<&str>,
        verify: bool,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let layout = self.layout(py)?;
        let layout = layout.as_deref();
        let last = path.as_os_str().as_encoded_bytes().last().copied();
        let is_directory = path.is_dir() || last.is_some_and(|last| std::path::is_separator(last.into()));
        let watching = self.watching(py, progress)?;
        let (files, notes, output) = if is_directory {
            let format = format.unwrap_or("glb");
            let write = |watcher: &Watcher| self.write_levels(&path, format, layout, verify, watcher);
            let (files, all): (Vec<_>, Vec<_>) = watching.run(py, write)?.result()?.into_iter().unzip();
            // Levels share most of their notes.
            let mut notes: Vec<String> = Vec::new();
            for note in all.concat() {
                if !notes.contains(&note) {
                    notes.push(note);
                }
            }
            (files, notes, None)
        } else {
            let destination = Destination::file(&path, format, layout)?;
            let write = |watcher: &Watcher| {
                let found = self.encode_scene(&destination, verify, watcher);
                let (encoded, level_bytes) = found.map_err(|failure| destination.unproven(failure))?;
                let written = destination.write(&encoded)?;
                let notes = encoded.all_notes();
                let (output, layout) = (None, destination.layout);
                Ok((ChainFile { encoded, level_bytes, written, output, layout }, notes))
            };
            let (file, notes) = watching.run(py, write)?.result()?;
            (vec![file], notes, Some(path.display().to_string()))
        };
        let bytes = files.iter().flat_map(|file| file.level_bytes.iter().copied()).collect::<Vec<_>>();
        let outputs: Vec<_> = files.iter().map(|file| file.output.clone()).collect();
        let found = PyDict::new(py);
        found.set_item("output", output)?;
        found.set_item("layout", files.first().map(|file| file.layout.name()))?;
        found.set_item("proven", files.iter().all(|file| file.encoded.faces.is_some()).then_some(true))?;
        found.set_item("chain", self.levels_with(py, &bytes, &outputs)?)?;
        let warnings = files.iter().flat_map(|file| file.written.warnings.iter().cloned());
        found.set_item("notes", notes.into_iter().chain(warnings).collect::<Vec<_>>())?;
        let beside = files.iter().flat_map(|file| &file.written.beside);
        found.set_item("beside", beside.map(|path| path.display().to_string()).collect::<Vec<_>>())?;
        Ok(found)
    }

    /// Return the bytes of a GLB with all levels.
    ///
    /// Args:
    ///     verify: see `save`.
    #[pyo3(signature = (*, verify = true))]
    fn to_bytes<'py>(&self, py: Python<'py>, verify: bool) -> PyResult<Bound<'py, PyBytes>> {
        let layout = self.layout(py)?;
        let destination = Destination::memory("glb", layout.as_deref())?;
        let encode = |watcher: &Watcher| Ok(self.encode_scene(&destination, verify, watcher)?.0);
        Ok(PyBytes::new(py, &self.watching(py, None)?.run(py, encode)?.result()?.bytes))
    }

    fn __len__(&self) -> usize {
        self.options.ratios.as_slice().len()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let levels = self.levels(py)?;
        let triangles = levels.try_iter()?.map(|level| level?.get_item("triangles")?.extract::<usize>());
        let triangles = triangles.map(|count| Ok(tristrip_pipeline::text::count(count?)));
        let triangles = triangles.collect::<PyResult<Vec<_>>>()?;
        let count = tristrip_pipeline::text::counted(triangles.len(), "level");
        Ok(format!("Chain({count} of {} triangles)", triangles.join(" / ")))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("chain_html", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let state = (this.source(), this.arguments.clone_ref(py), this.report.clone_ref(py));
        Ok((slf.get_type().getattr("_restore")?, state.into_pyobject(py)?))
    }

    #[classmethod]
    fn _restore(
        _: &Bound<'_, PyType>,
        source: &Bound<'_, Scene>,
        arguments: Bound<'_, PyDict>,
        report: Bound<'_, PyDict>,
    ) -> PyResult<Self> {
        let options = options_of(&Arguments::of(arguments.py(), Some(&arguments))?)?;
        let (source, built) = (Arc::clone(&source.get().data), OnceLock::new());
        Ok(Self { source, arguments: arguments.unbind(), options, built, report: report.unbind() })
    }
}
