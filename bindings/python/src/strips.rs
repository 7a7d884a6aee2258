//! Strips of arrays: the function `stripify` and the class `Strips`.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple, PyType};
use serde::{Deserialize, Serialize};
use tristrip::stripify::{Watch, plan_watched};
use tristrip::text::counted;
use tristrip::verify::{verify, verify_drawing};
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{DualGraph, Layout, Mesh, PreparedFaces, StripifyOptions, stripify_indices_watched};
use tristrip_pipeline::{MethodDescription, SearchStop, StripMetrics};

use crate::arrays::{GivenFaces, indices_of, indices_to_array, positions};
use crate::errors::Failure;
use crate::method;
use crate::reports::report;
use crate::work::{Watcher, Watching};

/// Triangle strips, a sequence of vertex arrays in draw order.
///
/// `len(strips)` is the number of strips and `strips[i]` the vertices of one strip. Created by
/// `stripify`, or from an index buffer by `Strips.from_indices`.
///
/// >>> import tristrip
/// >>> strips = tristrip.stripify([[0, 1, 2], [2, 1, 3], [2, 3, 4]])
/// >>> strips
/// Strips(1 strip, 3 triangles, 5 indices, method best, cost restart, effort 2)
/// >>> strips[0].tolist()
/// [0, 1, 2, 3, 4]
#[pyclass(frozen, module = "tristrip", eq, sequence)]
#[derive(Debug, PartialEq)]
pub(crate) struct Strips {
    inner: Arc<tristrip::Strips>,
    options: Option<StripifyOptions>,
    stopped: Option<SearchStop>,
    notes: Vec<String>,
    is_proven: bool,
}

/// The contents of a pickle.
#[derive(Serialize, Deserialize)]
struct Pickled {
    strips: tristrip::Strips,
    options: Option<StripifyOptions>,
    stopped: Option<bool>,
    notes: Vec<String>,
    is_proven: bool,
}

impl Strips {
    /// Wraps the strips of a method. If the search was stopped, a note has the reason.
    pub(crate) fn new(
        strips: tristrip::Strips,
        options: Option<StripifyOptions>,
        stopped: Option<SearchStop>,
    ) -> Self {
        let notes = stopped.iter().map(|stopped| stopped.note().into()).collect();
        Self { inner: Arc::new(strips), options, stopped, notes, is_proven: false }
    }

    /// Sets whether the strips are proven.
    pub(crate) fn with_proof(self, is_proven: bool) -> Self {
        Self { is_proven, ..self }
    }

    /// Adds a note, if there is one.
    fn with_note(mut self, note: Option<String>) -> Self {
        self.notes.extend(note);
        self
    }

    pub(crate) fn inner(&self) -> &Arc<tristrip::Strips> {
        &self.inner
    }

    /// Returns the highest vertex index plus one.
    fn vertex_count(&self) -> usize {
        self.inner.vertices().iter().max().map_or(0, |&highest| highest as usize + 1)
    }

    fn strip(&self, index: isize) -> Option<&[u32]> {
        let index = if index < 0 { index + isize::try_from(self.inner.len()).ok()? } else { index };
        self.inner.get(usize::try_from(index).ok()?)
    }
}

#[pymethods]
impl Strips {
    /// Read strips from an index buffer.
    ///
    /// Args:
    ///     indices: integers of shape (n,).
    ///     layout: "restart" (the maximum of the dtype separates strips), "degenerate" (degenerate
    ///         triangles join strips; they are split there), "separate" (one strip) or "list" (each
    ///         triangle becomes a strip). Strips that draw nothing are dropped.
    ///
    /// Raises:
    ///     MeshError: an index is negative or too large, or the length of a list is not a multiple
    ///         of three.
    ///     ArrayTypeError: the indices are not integers.
    ///     ParameterError: the layout is unknown.
    ///
    /// >>> import numpy, tristrip
    /// >>> buffer = numpy.array([0, 1, 2, 65535, 3, 4, 5], dtype="uint16")
    /// >>> [strip.tolist() for strip in tristrip.Strips.from_indices(buffer)]
    /// [[0, 1, 2], [3, 4, 5]]
    #[classmethod]
    #[pyo3(signature = (indices, layout = "restart"))]
    fn from_indices(_: &Bound<'_, PyType>, indices: &Bound<'_, PyAny>, layout: &str) -> PyResult<Self> {
        let layout = layout_of(layout)?;
        let given = indices_of("indices", indices, layout == Layout::Restart)?;
        let strips = tristrip::Strips::from_indices(&given, layout).map_err(Failure::from)?;
        Ok(Self::new(strips, None, None))
    }

    /// The vertices of all strips, concatenated: uint32 of shape (vertices_sent,).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_slice(py, self.inner.vertices())
    }

    /// The start of each strip in `vertices`, and the end of the last strip: int64 of shape
    /// (strips + 1,).
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let mut end = 0_u32;
        let ends = self.inner.iter().map(|strip| {
            end += strip.len() as u32;
            end
        });
        PyArray1::from_vec(py, std::iter::once(0).chain(ends).map(i64::from).collect())
    }

    /// The method and its options, in the notation of the command. None for strips from an index
    /// buffer.
    #[getter]
    fn method(&self) -> Option<String> {
        self.options.map(|options| MethodDescription::of(&options).description())
    }

    /// Why the search was stopped early: "budget", "interrupt", or None.
    #[getter]
    fn stopped(&self) -> Option<&'static str> {
        self.stopped.map(|stopped| if stopped == SearchStop::Budget { "budget" } else { "interrupt" })
    }

    /// Notes on dropped or unusual data.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Whether the strips were verified when they were built.
    #[getter]
    fn proven(&self) -> bool {
        self.is_proven
    }

    /// Return the index buffer.
    ///
    /// Args:
    ///     layout: "restart" (the maximum of the dtype separates strips), "degenerate" (degenerate
    ///         triangles join the strips and preserve winding), "separate" (no separators; see
    ///         `offsets`) or "list" (triangles in strip order).
    ///     dtype: "uint8", "uint16" or "uint32". The default is "uint16" if all vertices fit, else
    ///         "uint32".
    ///
    /// Returns:
    ///     An array of shape (n,).
    ///
    /// Raises:
    ///     ParameterError: the layout or dtype is unknown.
    ///     LimitError: a vertex index does not fit the dtype.
    ///
    /// >>> import tristrip
    /// >>> strips = tristrip.stripify([[0, 1, 2], [3, 4, 5]])
    /// >>> strips.indices(dtype="uint8").tolist()
    /// [0, 1, 2, 255, 3, 4, 5]
    #[pyo3(signature = (layout = "restart", dtype = None))]
    fn indices<'py>(
        &self,
        py: Python<'py>,
        layout: &str,
        dtype: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let layout = layout_of(layout)?;
        let bits = index_bits(py, dtype, self.vertex_count())?;
        Ok(indices_to_array(py, &self.inner, layout, bits)?)
    }

    /// Return the triangles in draw order, with their winding: uint32 of shape (triangles, 3).
    ///
    /// >>> import tristrip
    /// >>> tristrip.stripify([[0, 1, 2], [2, 1, 3]]).triangles().shape
    /// (2, 3)
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let strips = &*self.inner;
        let list = py.detach(|| strips.to_list());
        let rows = list.len() / 3;
        PyArray1::from_vec(py, list).reshape([rows, 3])
    }

    /// Verify that the strips draw each of these faces exactly once, with its original winding.
    ///
    /// Args:
    ///     faces: see `stripify`.
    ///     vertices: positions of shape (n, 3). Required for strips with welded vertices.
    ///
    /// Returns:
    ///     A dictionary with the numbers of "faces" and "triangles" compared.
    ///
    /// Raises:
    ///     NotProvenError: the strips draw something else; the message has the first difference.
    ///     MeshError, ArrayTypeError: the faces are invalid.
    ///
    /// >>> import tristrip
    /// >>> faces = [[0, 1, 2], [2, 1, 3]]
    /// >>> tristrip.stripify(faces).verify(faces)
    /// {'faces': 2, 'triangles': 2}
    /// >>> tristrip.stripify(faces).verify([[0, 1, 2], [2, 3, 1]])
    /// Traceback (most recent call last):
    /// tristrip.NotProvenError: triangles missing: 1, extra or flipped: 1; the first is [1, 2, 3]
    #[pyo3(signature = (faces, vertices = None))]
    fn verify<'py>(
        &self,
        py: Python<'py>,
        faces: &Bound<'py, PyAny>,
        vertices: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let faces = GivenFaces::of("faces", faces)?.to_faces()?;
        let points = vertices.map(|vertices| positions("vertices", vertices)).transpose()?;
        let points = points.map(|points| points.as_slice().map(|x| x.as_chunks().0.to_vec()));
        let points = points.transpose()?;
        let strips = Arc::clone(&self.inner);
        let ended = Watching::default().run(py, move |_| match points {
            Some(points) => {
                let mesh = Mesh::new(points, faces)?;
                verify(&mesh, &strips).map_err(|why| Failure::Unproven(why.to_string()))
            }
            None if !strips.welds().is_empty() => {
                Err(Failure::option("vertices", "None", "the positions used to weld vertices"))
            }
            None => {
                let drawn: Vec<[u32; 3]> = strips.triangles().collect();
                verify_drawing(&faces, &drawn).map_err(|why| Failure::Unproven(why.to_string()))
            }
        })?;
        let proof = ended.result()?;
        let found = PyDict::new(py);
        found.set_item("faces", proof.faces)?;
        found.set_item("triangles", proof.triangles)?;
        Ok(found)
    }

    /// Return the metrics of the strips: a dictionary with the keys of the command's JSON.
    ///
    /// >>> import tristrip
    /// >>> metrics = tristrip.stripify([[0, 1, 2], [2, 1, 3]]).metrics()
    /// >>> metrics["strips"], metrics["indices_restart"], metrics["acmr_fifo_16"]
    /// (1, 4, 2.0)
    fn metrics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let options = self.options.unwrap_or_default();
        let (strips, vertex_count) = (&*self.inner, self.vertex_count());
        let figures =
            py.detach(|| StripMetrics::of(&[(strips, vertex_count)], &options)).map_err(Failure::from)?;
        report(py, &figures)
    }

    /// Simulate a vertex cache while the strips are drawn.
    ///
    /// Args:
    ///     cache: the replacement policy and the number of entries, such as "fifo:16" or "lru:32".
    ///     flush: whether to empty the cache between strips.
    ///
    /// Returns:
    ///     A dictionary: "misses", "acmr" (misses per triangle) and "atvr" (misses per used vertex).
    ///
    /// Raises:
    ///     ParameterError: the cache is unknown.
    ///
    /// >>> import tristrip
    /// >>> tristrip.stripify([[0, 1, 2], [2, 1, 3]]).vertex_cache("fifo:16")
    /// {'misses': 4, 'acmr': 2.0, 'atvr': 1.0}
    #[pyo3(signature = (cache = "fifo:16", flush = false))]
    fn vertex_cache<'py>(&self, py: Python<'py>, cache: &str, flush: bool) -> PyResult<Bound<'py, PyDict>> {
        let cache: VertexCache = cache.parse().map_err(Failure::from)?;
        let policy = if flush { FlushPolicy::Flush } else { FlushPolicy::Keep };
        let strips = &*self.inner;
        let used = py.detach(|| VertexCacheStatistics::of(strips, cache, policy));
        let found = PyDict::new(py);
        found.set_item("misses", used.misses)?;
        found.set_item("acmr", used.acmr())?;
        found.set_item("atvr", used.atvr())?;
        Ok(found)
    }

    fn __len__(&self) -> usize {
        self.inner.len()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: isize) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let strip = self.strip(index).ok_or_else(|| {
            PyIndexError::new_err(format!("strip {index}: found {}", counted(self.inner.len(), "strip")))
        })?;
        Ok(PyArray1::from_slice(py, strip))
    }

    fn __iter__(slf: Bound<'_, Self>) -> StripIterator {
        StripIterator { strips: slf.unbind(), next: 0 }
    }

    fn __repr__(&self) -> String {
        let (strips, triangles) = (self.inner.len(), self.inner.triangles().count());
        let indices = self.inner.index_count(Layout::Restart);
        let counted = tristrip_pipeline::text::counted;
        let method = self.method().map(|method| format!(", {method}")).unwrap_or_default();
        let (strips, triangles) = (counted(strips, "strip"), counted(triangles, "triangle"));
        format!("Strips({strips}, {triangles}, {}{method})", counted(indices, "index"))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("strips_html", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let this = slf.get();
        let pickled = Pickled {
            strips: (*this.inner).clone(),
            options: this.options,
            stopped: this.stopped.map(|stopped| stopped == SearchStop::Budget),
            notes: this.notes.clone(),
            is_proven: this.is_proven,
        };
        let bytes = serde_json::to_vec(&pickled).map_err(|error| Failure::Panic(error.to_string()))?;
        let restore = slf.get_type().getattr("_restore")?;
        Ok((restore, PyTuple::new(slf.py(), [PyBytes::new(slf.py(), &bytes)])?))
    }

    #[classmethod]
    fn _restore(_: &Bound<'_, PyType>, bytes: &[u8]) -> PyResult<Self> {
        let pickled: Pickled =
            serde_json::from_slice(bytes).map_err(|error| Failure::Parameter(format!("pickle: {error}")))?;
        let Pickled { strips, options, stopped, notes, is_proven } = pickled;
        let stopped = stopped.map(|budget| if budget { SearchStop::Budget } else { SearchStop::Interrupt });
        Ok(Self { inner: Arc::new(strips), options, stopped, notes, is_proven })
    }
}

/// Iterates over strips as arrays of vertices.
#[pyclass(module = "tristrip")]
#[derive(Debug)]
pub(crate) struct StripIterator {
    strips: Py<Strips>,
    next: usize,
}

#[pymethods]
impl StripIterator {
    fn __iter__(slf: PyRef<'_, Self>) -> PyRef<'_, Self> {
        slf
    }

    fn __next__<'py>(&mut self, py: Python<'py>) -> Option<Bound<'py, PyArray1<u32>>> {
        let strip = PyArray1::from_slice(py, self.strips.get().inner.get(self.next)?);
        self.next += 1;
        Some(strip)
    }
}

/// Parses the name of a layout.
pub(crate) fn layout_of(name: &str) -> Result<Layout, Failure> {
    Ok(name.parse::<Layout>()?)
}

/// Returns the bits of an index type: those requested, or 16 if all vertices and the restart value
/// fit, else 32.
pub(crate) fn index_bits(
    py: Python<'_>,
    dtype: Option<&Bound<'_, PyAny>>,
    vertex_count: usize,
) -> Result<u8, Failure> {
    let Some(dtype) = dtype else { return Ok(if vertex_count < 1 << 16 { 16 } else { 32 }) };
    let found = py.import("numpy")?.call_method1("dtype", (dtype,));
    let name = found.and_then(|found| found.getattr("name")?.extract::<String>());
    match name.as_deref() {
        Ok("uint8") => Ok(8),
        Ok("uint16") => Ok(16),
        Ok("uint32") => Ok(32),
        _ => Err(Failure::option("dtype", dtype, "uint8, uint16 or uint32")),
    }
}

/// Compute triangle strips that draw every face exactly once, with its original winding.
///
/// Args:
///     faces: integers of shape (n, 3) or (3 n,) for triangles, of shape (n, k) for polygons with k
///         corners, or a list of lists for polygons of different sizes. A C-contiguous uint32 array
///         is not copied. Faces with a repeated vertex draw nothing; they are dropped with a note.
///     vertices: positions of shape (m, 3). Required for polygons with more than three corners and
///         for `weld`.
///     method: "best", "fewest", "cache", "sequential", "input", "stripe-local", "eta", …, or a
///         method with parameters as for `--method`: "stripe-global:patches=full,cutoff=10".
///     effort: 0 to 9, for methods that search. Higher values find fewer indices and take longer.
///     cost: the cost that "best" minimizes: "restart", "degenerate", "opengl" or "gl".
///     weld: whether to merge vertices with the same position.
///     verify: whether to verify the result.
///     budget: a time limit in seconds, after which the search returns its best result. The result
///         then depends on the machine.
///     progress: True for a tqdm progress bar, a progress bar, or a function that is called with a
///         `Progress` several times per second.
///     on_interrupt: the effect of Ctrl-C during a search: "raise" raises `Interrupted` with the
///         best strips so far as `best`; "return" returns them.
///     **options: other parameters of the method, such as `vertex_cache="fifo:24"` or `seed=1`.
///         `tristrip help methods` lists them.
///
/// Returns:
///     The strips. They do not depend on the number of threads.
///
/// Raises:
///     MeshError: the faces or vertices have invalid values or an invalid shape.
///     ArrayTypeError: an array has an unsupported type.
///     ParameterError: an option is unknown, has an invalid value, or does not belong to the
///         method.
///     NotProvenError: verification failed, which is a bug in this package.
///
/// References:
///     "stripe-local", "stripe-global": Evans, Skiena, Varshney: Optimizing Triangle Strips for
///     Fast Rendering, 1996.
///     "tunnel": Porcu, Scateni: An Iterative Stripification Algorithm Based on Dual Graph
///     Operations, 2003.
///     "eta": Porcu, Scateni: Partitioning Meshes into Strips using the Enhanced Tunnelling
///     Algorithm, 2006.
///     "best", "fewest", "cache", "sequential", "guided-tunnels": methods of this project.
///
/// >>> import tristrip
/// >>> strips = tristrip.stripify([[0, 1, 2], [2, 1, 3], [2, 3, 4]], method="cache", vertex_cache="fifo:24")
/// >>> strips.indices(layout="restart").tolist()
/// [0, 1, 2, 3, 4]
#[pyfunction]
#[pyo3(signature = (faces, vertices = None, *, method = "best", effort = None, cost = None, weld = false, verify = false, budget = None, progress = None, on_interrupt = "raise", **options))]
#[allow(clippy::too_many_arguments, reason = "keyword arguments of Python")]
pub(crate) fn stripify<'py>(
    py: Python<'py>,
    faces: &Bound<'py, PyAny>,
    vertices: Option<&Bound<'py, PyAny>>,
    method: &str,
    effort: Option<&Bound<'py, PyAny>>,
    cost: Option<&str>,
    weld: bool,
    verify: bool,
    budget: Option<f64>,
    progress: Option<Bound<'py, PyAny>>,
    on_interrupt: &str,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, Strips>> {
    let parameters = method::parameters(py, options, effort, cost)?;
    let options = method::options(method, weld, Some(&parameters))?;
    let watching = Watching::new(py, progress, budget, on_interrupt)?.keeping_best();
    let given = GivenFaces::of("faces", faces)?;
    let points = vertices.map(|vertices| positions("vertices", vertices)).transpose()?;
    let built = match (&given, &points) {
        (_, None) if weld => {
            Err(Failure::option("vertices", "None", "positions, by which vertices are welded"))
        }
        (GivenFaces::Triangles(_), None) => {
            let corners = given.corners();
            watching.run(py, |watcher| of_triangles(corners, &options, verify, watcher))
        }
        (GivenFaces::Polygons(_), None) => {
            Err(Failure::option("vertices", "None", "positions, for polygons with more than three corners"))
        }
        (_, Some(points)) => {
            let points = points.as_slice()?.as_chunks().0;
            let faces = given.to_faces()?;
            watching.run(py, move |watcher| {
                of_mesh(&Mesh::new(points.to_vec(), faces)?, &options, verify, watcher)
            })
        }
    };
    built?.object(py, |strips| strips)
}

/// Builds strips of triangles without positions.
fn of_triangles(
    corners: &[u32],
    options: &StripifyOptions,
    verify: bool,
    watcher: &Watcher,
) -> Result<Strips, Failure> {
    let vertex_count = corners.iter().max().map_or(0, |&highest| highest as usize + 1);
    let strips = stripify_indices_watched(corners, vertex_count, options, watcher)?;
    if verify {
        let faces = tristrip::Faces::from_triangles(corners.to_vec())?;
        let drawn: Vec<[u32; 3]> = strips.triangles().collect();
        verify_drawing(&faces, &drawn).map_err(|why| Failure::Unproven(why.to_string()))?;
    }
    let is_degenerate = |&&[a, b, c]: &&[u32; 3]| a == b || b == c || c == a;
    let dropped = corners.as_chunks().0.iter().filter(is_degenerate).count();
    Ok(Strips::new(strips, Some(*options), watcher.stopped())
        .with_note(dropped_note(dropped))
        .with_proof(verify))
}

/// Builds strips of faces with positions.
fn of_mesh(
    mesh: &Mesh,
    options: &StripifyOptions,
    proves: bool,
    watcher: &Watcher,
) -> Result<Strips, Failure> {
    let prepared = PreparedFaces::new(mesh, options.weld);
    let graph = DualGraph::new(prepared.faces());
    let watch: &dyn Watch = watcher;
    let strips = plan_watched(&prepared, &graph, options, watch)?.strips();
    if proves {
        verify(mesh, &strips).map_err(|why| Failure::Unproven(why.to_string()))?;
    }
    let dropped = dropped_note(prepared.counts().degenerate_faces);
    Ok(Strips::new(strips, Some(*options), watcher.stopped()).with_note(dropped).with_proof(proves))
}

fn dropped_note(count: usize) -> Option<String> {
    let counted = tristrip_pipeline::text::counted(count, "degenerate face");
    (count > 0).then(|| format!("{counted} dropped (no area)"))
}
