//! Strips of a whole scene.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyMapping, PyTuple, PyType};
use tristrip::StripifyOptions;
use tristrip_io::VertexGroup;
use tristrip_pipeline::{SearchStop, encode, strip};

use super::class::Scene;
use super::data::SceneData;
use super::output::{Destination, file_report};
use super::picture;
use crate::arguments::{Arguments, Keywords};
use crate::errors::Failure;
use crate::reports::{Report, report};
use crate::strips::Strips;
use crate::work::{Ended, Watcher, Watching};

/// The strips of all parts of a scene, with metrics. Created by `Scene.strip`.
///
/// >>> import tristrip
/// >>> scene = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], [[0, 1, 2], [2, 1, 3]])
/// >>> stripped = scene.strip()
/// >>> stripped
/// StrippedScene(1 part, 2 triangles, 1 strip, 4 indices, proven, method best, cost restart, effort 2)
/// >>> stripped.parts[0].indices().tolist()
/// [3, 2, 1, 0]
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct StrippedScene {
    scene: Arc<SceneData>,
    stripped: strip::Outcome,
}

impl StrippedScene {
    pub(crate) fn new(scene: Arc<SceneData>, stripped: strip::Outcome) -> Self {
        Self { scene, stripped }
    }
}

fn options_of(destination: &Destination<'_>, reorder: bool, verify: bool) -> encode::Options {
    let options = encode::Options::new(destination.target.format).with_layout(destination.layout);
    options.with_list(!destination.is_chosen).with_reorder(reorder).with_verify(verify)
}

/// Builds the strips of a scene.
pub(crate) fn strip(
    py: Python<'_>,
    scene: &Arc<SceneData>,
    options: strip::Options,
    watching: Watching,
) -> Result<Ended<strip::Outcome>, Failure> {
    watching.run(py, |watcher| Ok(strip::run(scene.as_read(), &options, watcher)?))
}

#[pymethods]
impl StrippedScene {
    /// The source scene.
    #[getter]
    fn scene(&self) -> Scene {
        Scene { data: Arc::clone(&self.scene) }
    }

    /// The strips of each part, over its vertices.
    #[getter]
    fn parts(&self) -> Vec<Strips> {
        let strip::Outcome { strips, stripify, stopped, proven, .. } = &self.stripped;
        let of_part = |strips: &tristrip::Strips| {
            Strips::new(strips.clone(), Some(*stripify), *stopped).with_proof(*proven)
        };
        strips.iter().map(of_part).collect()
    }

    /// The method and its options, in the notation of the command.
    #[getter]
    fn method(&self) -> String {
        self.stripped.method.description()
    }

    /// Why the search was stopped early: "budget", "interrupt", or None.
    #[getter]
    fn stopped(&self) -> Option<&'static str> {
        let stopped = self.stripped.stopped?;
        Some(if stopped == SearchStop::Budget { "budget" } else { "interrupt" })
    }

    /// Whether the strips were verified to draw every face of the scene exactly once, with its
    /// original winding.
    #[getter]
    fn proven(&self) -> bool {
        self.stripped.proven
    }

    /// The counts of the mesh: a dictionary with the keys of the command's JSON.
    #[getter]
    fn mesh<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, &self.stripped.mesh)
    }

    /// The gap between the result and its lower bound: "figure", "found", "bound", "gap" and
    /// "optimal".
    ///
    /// None for methods that do not search, and for "best" up to effort 2.
    #[getter]
    fn bound<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.stripped.bound.as_ref().map(|bound| report(py, bound)).transpose()
    }

    /// Notes on reading, and on dropped, changed or unusual data.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.stripped.notes.clone()
    }

    /// Return the metrics of all strips: a dictionary with the keys of the command's JSON; see
    /// `Strips.metrics`.
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        report(py, &self.stripped.metrics)
    }

    /// Write the scene with its strips, as the command `strip -o` does.
    ///
    /// Args:
    ///     path: the output file. An existing file is replaced after the new one is complete. A
    ///         .gltf file comes with a .bin file for its buffer, an OBJ file with its materials and
    ///         images.
    ///     format: "glb", "gltf", "ply" or "obj". By default the extension determines it.
    ///     layout: "restart", "degenerate", "separate" or "list". The default is "degenerate" for
    ///         glTF and "restart" for PLY; a part is then drawn as a list if that takes fewer
    ///         indices.
    ///     reorder_vertices: whether to renumber vertices in the order of first use.
    ///     verify: whether to read the bytes back and verify them before the file is replaced.
    ///
    /// Returns:
    ///     A dictionary with keys of the command's JSON: "output", "layout", "drawn" (part counts
    ///     by drawing mode), "before" and "after" (indices, ACMR and bytes), "vertex_order" (if
    ///     reordered: parts, number of moved vertices and the old index of each vertex), "notes",
    ///     "proven", "faces", "bytes", "beside" (other files written).
    ///
    /// Raises:
    ///     FileError: the file cannot be written.
    ///     ParameterError: the format or layout is unknown, or the format does not support the
    ///         layout.
    ///     NotProvenError: the bytes do not draw the scene; nothing was written.
    #[pyo3(
        signature = (path, **given),
        text_signature = "($self, path, *, format=None, layout=None, reorder_vertices=False, verify=True)"
    )]
    fn save<'py>(&self, py: Python<'py>, path: PathBuf, given: Option<Keywords<'_, 'py>>) -> Report<'py> {
        let arguments = Arguments::of(py, given)?;
        let [format, layout] = ["format", "layout"].map(|name| arguments.extract::<String>(name));
        let destination = Destination::file(&path, format?.as_deref(), layout?.as_deref())?;
        let reorder_vertices = arguments.flag("reorder_vertices")?;
        let verify = arguments.extract("verify")?.unwrap_or(true);
        arguments.finish("save")?;
        let options = options_of(&destination, reorder_vertices, verify);
        let before_bytes = self.scene.file_bytes();
        let saved = Watching::default().run(py, |watcher| {
            let model = self.scene.model_for(&destination.target);
            let file = self.stripped.encode(&model, &options, watcher);
            let mut file = file.map_err(|error| destination.unproven(error.into()))?;
            file.before.bytes = before_bytes;
            file.after.bytes = file.after.bytes.filter(|_| !destination.target.separate);
            let written = destination.write(&file.encoded)?;
            Ok((file, written, self.scene.image_notes(&destination.target)))
        });
        let (file, written, notes) = saved?.result()?;
        let found = file_report(py, &destination, &file.encoded, &written, notes)?;
        found.update(report(py, &file)?.cast::<PyMapping>()?)?;
        let groups = file.encoded.groups.as_ref().map(|groups| vertex_order(py, groups)).transpose()?;
        found.set_item("vertex_order", groups)?;
        Ok(found)
    }

    /// Return the bytes that `save` would write to a single file.
    ///
    /// Args:
    ///     format: "glb", "ply" or "obj".
    ///     layout, reorder_vertices, verify: see `save`.
    ///
    /// >>> import tristrip
    /// >>> scene = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    /// >>> scene.strip().to_bytes()[:4]
    /// b'glTF'
    #[pyo3(signature = (format = "glb", *, layout = None, reorder_vertices = false, verify = true))]
    fn to_bytes<'py>(
        &self,
        py: Python<'py>,
        format: &str,
        layout: Option<&str>,
        reorder_vertices: bool,
        verify: bool,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let destination = Destination::memory(format, layout)?;
        let options = options_of(&destination, reorder_vertices, verify);
        let encoded = Watching::default().run(py, |watcher| {
            let model = self.scene.model_for(&destination.target);
            Ok(self.stripped.encode(&model, &options, watcher)?.encoded)
        });
        Ok(PyBytes::new(py, &encoded?.result()?.bytes))
    }

    /// Render the strips with one colour per strip.
    ///
    /// Strips that share an edge have different colours. Node transforms are not applied.
    ///
    /// Args:
    ///     width, height: the image size, 1 to 8192 pixels.
    ///
    /// Returns:
    ///     The bytes of a PNG file, for example for `IPython.display.Image`.
    #[pyo3(signature = (width = 1200, height = 900))]
    fn picture<'py>(&self, py: Python<'py>, width: i64, height: i64) -> PyResult<Bound<'py, PyBytes>> {
        picture::of_strips(py, self.scene.as_read(), &self.stripped.strips, (width, height))
    }

    fn __repr__(&self) -> String {
        let counted = tristrip_pipeline::text::counted;
        let metrics = &self.stripped.metrics;
        let words = [
            counted(self.stripped.strips.len(), "part"),
            counted(metrics.triangles, "triangle"),
            counted(metrics.strips, "strip"),
            counted(metrics.indices_restart, "index"),
        ];
        let proven = if self.stripped.proven { "proven" } else { "not proven" };
        format!("StrippedScene({}, {proven}, {})", words.join(", "), self.method())
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("stripped_html", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let options =
            serde_json::to_vec(&this.stripped.stripify).map_err(|e| Failure::Panic(e.to_string()))?;
        let state = (this.scene(), this.parts(), PyBytes::new(py, &options), this.stopped(), this.proven());
        Ok((slf.get_type().getattr("_restore")?, state.into_pyobject(py)?))
    }

    #[classmethod]
    fn _restore(
        kind: &Bound<'_, PyType>,
        scene: &Bound<'_, Scene>,
        parts: Vec<Bound<'_, Strips>>,
        options: &[u8],
        stopped: Option<&str>,
        proven: bool,
    ) -> PyResult<Self> {
        let wrong = |error: serde_json::Error| Failure::Parameter(format!("pickle: {error}"));
        let stripify: StripifyOptions = serde_json::from_slice(options).map_err(wrong)?;
        let options = strip::Options::default().with_stripify(stripify).with_verify(proven);
        let stopped =
            stopped.map(|why| if why == "budget" { SearchStop::Budget } else { SearchStop::Interrupt });
        let strips: Vec<_> = parts.iter().map(|strips| (**strips.get().inner()).clone()).collect();
        let scene = Arc::clone(&scene.get().data);
        let again =
            |watcher: &Watcher| Ok(strip::of_strips(scene.as_read(), strips, stopped, &options, watcher)?);
        let stripped = Watching::default().run(kind.py(), again)?.result()?;
        Ok(Self { scene, stripped })
    }
}

/// Reports the new vertex order.
fn vertex_order<'py>(py: Python<'py>, groups: &[VertexGroup]) -> PyResult<Bound<'py, PyList>> {
    let found = PyList::empty(py);
    for group in groups {
        let one = PyDict::new(py);
        one.set_item("parts", &group.parts)?;
        one.set_item("vertices", group.order.vertex_count())?;
        one.set_item("moved", group.order.moved_count())?;
        one.set_item("new_to_old", PyArray1::from_slice(py, group.order.new_to_old()))?;
        one.set_item("kept", &group.kept)?;
        found.append(one)?;
    }
    Ok(found)
}
