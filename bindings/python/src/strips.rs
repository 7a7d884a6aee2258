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

/// Triangle strips: the vertices of each, in the order in which they are drawn. Two strips in an index buffer are separated as its
/// layout says. Built by `stripify`, or from an index buffer by `Strips.from_indices`.
///
/// A sequence of arrays: `len(strips)` strips, each of which is an array of vertices.
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

/// What a pickle holds.
#[derive(Serialize, Deserialize)]
struct Pickled {
    strips: tristrip::Strips,
    options: Option<StripifyOptions>,
    stopped: Option<bool>,
    notes: Vec<String>,
    is_proven: bool,
}

impl Strips {
    /// Takes over strips of a method; the reason why its search was stopped becomes a note.
    pub(crate) fn new(
        strips: tristrip::Strips,
        options: Option<StripifyOptions>,
        stopped: Option<SearchStop>,
    ) -> Self {
        let notes = stopped.iter().map(|stopped| stopped.note().into()).collect();
        Self { inner: Arc::new(strips), options, stopped, notes, is_proven: false }
    }

    /// States that the strips are proven.
    pub(crate) fn with_proof(self, is_proven: bool) -> Self {
        Self { is_proven, ..self }
    }

    /// Adds a note.
    fn with_note(mut self, note: Option<String>) -> Self {
        self.notes.extend(note);
        self
    }

    pub(crate) fn inner(&self) -> &Arc<tristrip::Strips> {
        &self.inner
    }

    /// Counts the vertices up to the highest that is used.
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
    ///     layout: "restart" (the largest value of the dtype separates strips), "degenerate" (degenerate triangles join strips, which become strips
    ///         of their own), "separate" (one strip), or "list" (each triangle becomes a strip). Strips that draw nothing are left out.
    ///
    /// Raises:
    ///     MeshError: indices are negative or too large, or a list does not have three per triangle.
    ///     ArrayTypeError: indices are no integers.
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

    /// The vertices of all strips, one after the other: uint32 of shape (vertices_sent,).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        PyArray1::from_slice(py, self.inner.vertices())
    }

    /// The start of each strip in `vertices`, and the end of the last one: int64 of shape (strips + 1,).
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        let mut end = 0_u32;
        let ends = self.inner.iter().map(|strip| {
            end += strip.len() as u32;
            end
        });
        PyArray1::from_vec(py, std::iter::once(0).chain(ends).map(i64::from).collect())
    }

    /// The method and its options, as the command prints them; None for strips that were not built here.
    #[getter]
    fn method(&self) -> Option<String> {
        self.options.map(|options| MethodDescription::of(&options).description())
    }

    /// Why the search was stopped before its end: "budget", "interrupt", or None.
    #[getter]
    fn stopped(&self) -> Option<&'static str> {
        self.stopped.map(|stopped| if stopped == SearchStop::Budget { "budget" } else { "interrupt" })
    }

    /// Notes on what was dropped or is unusual.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Whether the strips were proven when they were built.
    #[getter]
    fn proven(&self) -> bool {
        self.is_proven
    }

    /// Return the index buffer.
    ///
    /// Args:
    ///     layout: "restart" (the largest value of the dtype separates strips), "degenerate" (one strip joined by degenerate triangles, winding
    ///         kept), "separate" (no separation; `offsets` has the ends), or "list" (triangles in the order of the strips).
    ///     dtype: "uint8", "uint16" or "uint32"; by default "uint16" where all vertices fit, else "uint32".
    ///
    /// Returns:
    ///     An array of shape (n,).
    ///
    /// Raises:
    ///     ParameterError: the layout or the dtype is unknown.
    ///     LimitError: a vertex does not fit the dtype.
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

    /// Return the triangles that are drawn, in their order, with their winding: uint32 of shape (triangles, 3).
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

    /// Prove that the strips draw every one of these faces exactly once, with its original winding.
    ///
    /// Args:
    ///     faces: as of `stripify`.
    ///     vertices: positions of shape (n, 3), which only strips of welded vertices need.
    ///
    /// Returns:
    ///     A dictionary: "faces" and "triangles" compared.
    ///
    /// Raises:
    ///     NotProvenError: they do not; the text has the first difference.
    ///     MeshError, ArrayTypeError: the faces are no faces.
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
                Err(Failure::option("vertices", "None", "the positions by which vertices were welded"))
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
    ///     cache: the replacement policy and the number of entries, as "fifo:16" or "lru:32".
    ///     flush: whether the cache is emptied between strips.
    ///
    /// Returns:
    ///     A dictionary: "misses", "acmr" (misses per triangle) and "atvr" (misses per vertex used).
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

/// Reads the name of a layout.
pub(crate) fn layout_of(name: &str) -> Result<Layout, Failure> {
    Ok(name.parse::<Layout>()?)
}

/// Returns the bits of an index type: those asked for, or the fewest of 16 and 32 that name all vertices beside the restart value.
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
///     faces: vertices of triangles as integers of any type, of shape (n, 3) or (3 n,); of polygons with k corners as shape (n, k); of
///         polygons of several sizes as a list of lists. A C-contiguous array of uint32 is used without a copy. Faces with a repeated vertex draw
///         nothing and are left out, with a note.
///     vertices: positions of shape (m, 3). Polygons with more than three corners need them, and `weld` does.
///     method: "best", "fewest", "cache", "sequential", "input", "stripe-local", "eta", …, or a method with parameters as the command's `--method` takes it:
///         "stripe-global:patches=full,cutoff=10".
///     effort: 0 to 9, of the methods that search; more finds fewer indices and takes longer.
///     cost: what method "best" minimizes: "restart", "degenerate", "opengl" or "gl".
///     weld: whether vertices with the same position are one.
///     verify: whether to prove the result.
///     budget: the time in seconds after which a search is stopped with its best result. The result depends on the machine then.
///     progress: True for a bar of tqdm, a bar, or a function that is called with a `Progress` some times per second.
///     on_interrupt: what Ctrl-C during a search does: "raise" an `Interrupted` with the best strips so far as `best`, or "return" them.
///     **options: other parameters of the method, such as `vertex_cache="fifo:24"` or `seed=1`; `tristrip help methods` lists them.
///
/// Returns:
///     The strips. They are the same for any number of threads.
///
/// Raises:
///     MeshError: the faces or vertices have wrong values or a wrong shape.
///     ArrayTypeError: an array has a type that is not a number.
///     ParameterError: an option is unknown or has a wrong value, or does not belong to the method.
///     NotProvenError: a proof was asked for and failed, which is a defect of this package.
///
/// References:
///     Evans, Skiena, Varshney: Optimizing Triangle Strips for Fast Rendering, 1996 ("stripe-local", "stripe-global"); Porcu, Scateni: An Iterative
///     Stripification Algorithm Based on Dual Graph Operations, 2003 ("tunnel"); Porcu, Scateni: Partitioning Meshes into Strips using the Enhanced
///     Tunnelling Algorithm, 2006 ("eta"). "best", "fewest", "cache", "sequential" and "guided-tunnels" are methods of this project.
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

/// Strips triangles without positions.
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

/// Strips faces with positions.
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
    (count > 0).then(|| format!("{counted} dropped: they draw nothing"))
}
