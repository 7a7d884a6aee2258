//! View-dependent detail: the classes `ViewModel` and `View`.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyTuple, PyType};
use serde::Serialize;
use tristrip::lod::{
    Camera, Foveation, RESTART, RepairOptions, RepairedView, SkipStrips, SkipView, ViewCriteria, ViewUpdate,
};
use tristrip::simplify::MergeOrder;
use tristrip_io::Model;
use tristrip_io::tlod::{self, TlodLimits};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::view_model::{self, prove_view};
use tristrip_pipeline::{MethodDescription, SearchStop, levels::DisplayFilter};
use tristrip_render::images::{RenderOptions, strips_seen, triangles_seen};

use crate::arguments::{Arguments, Keywords};
use crate::arrays::triangle_rows;
use crate::attributes::{self, GivenAttributes};
use crate::errors::Failure;
use crate::input::{Input, format_of};
use crate::mesh::{mesh_of, one_part};
use crate::method;
use crate::numbers::Count;
use crate::reports::report;
use crate::strips::{Strips, index_bits};
use crate::work::Watching;

const USUAL_IMAGE: [u32; 2] = [1920, 1080];
const UPWARD: [f32; 3] = [0.0, 1.0, 0.0];
const MIDDLE: [f32; 2] = [0.5, 0.5];

/// A view-dependent LOD model: a mesh, its strips and a merge tree of collapses (Skip Strips).
///
/// Created by `ViewModel.build` from arrays or `ViewModel.from_scene` from a scene or file, or read
/// by `ViewModel.load` from a `.tlod` file. A model is immutable; `view` creates a cursor over it.
///
/// References:
///     El-Sana, Azanli, Varshney: Skip Strips: Maintaining Triangle Strips for View-Dependent
///     Rendering, 1999.
///     Xia, El-Sana, Varshney: Adaptive Real-Time Level-of-Detail-Based Rendering for Polygonal
///     Models, 1997 (order "shortest-edge").
///
/// >>> import numpy, tristrip
/// >>> x, y = numpy.meshgrid(numpy.arange(40.0), numpy.arange(40.0))
/// >>> vertices = numpy.column_stack([x.ravel(), (numpy.sin(x / 3) * numpy.cos(y / 4)).ravel(), y.ravel()])
/// >>> corner = (numpy.arange(39)[:, None] * 40 + numpy.arange(39)).ravel()
/// >>> faces = numpy.concatenate([corner + numpy.array([[0], [40], [1]]), corner + numpy.array([[1], [40], [41]])], axis=1).T
/// >>> model = tristrip.ViewModel.build(vertices, faces)
/// >>> view = model.view()
/// >>> near = view.set_view((20.0, 3.0, -4.0), (20.0, 0.0, 20.0), pixels=2.0)["triangles"]
/// >>> far = view.set_view((20.0, 900.0, -900.0), (20.0, 0.0, 20.0), pixels=2.0)["triangles"]
/// >>> far < near < model.triangle_count
/// True
#[pyclass(frozen, module = "tristrip")]
pub(crate) struct ViewModel {
    model: Arc<view_model::ViewModel>,
    tree: Arc<SkipStrips>,
    built: Built,
}

/// How a model was built. Empty for a model read from a file.
#[derive(Debug, Clone, Default, Serialize)]
struct Built {
    #[serde(flatten)]
    method: Option<MethodDescription>,
    order: Option<&'static str>,
    proven: Option<bool>,
    parts: Option<usize>,
    /// The levels of the merge tree.
    levels: Option<usize>,
    stopped: Option<SearchStop>,
    notes: Vec<String>,
}

/// The report of a model, with the keys of the JSON report of `tristrip build-lod`.
#[derive(Serialize)]
struct DescribedModel<'a> {
    #[serde(flatten)]
    built: &'a Built,
    vertices: usize,
    triangles: usize,
    strips: usize,
    collapses: usize,
    height: u32,
    /// The file size; `None` because no file has been written yet.
    bytes: Option<usize>,
}

impl ViewModel {
    /// Builds one model of all parts.
    pub(crate) fn of_model(
        py: Python<'_>,
        load: impl FnOnce() -> Result<Model, Failure> + Send,
        options: view_model::Options,
        watching: Watching,
    ) -> PyResult<Bound<'_, Self>> {
        let ended = watching.run(py, move |watcher| {
            let built = view_model::run(load()?, &options, watcher)?;
            let of_model = Built {
                method: Some(built.method),
                order: Some(built.order),
                proven: built.proven.then_some(true),
                parts: Some(built.parts),
                levels: Some(built.levels),
                stopped: built.stopped,
                notes: built.notes,
            };
            Self::new(built.model, of_model)
        })?;
        ended.object(py, |model| model)
    }

    fn new(model: view_model::ViewModel, built: Built) -> Result<Self, Failure> {
        let tree = Arc::new(model.vertex_tree()?);
        Ok(Self { model: Arc::new(model), tree, built })
    }

    fn encoded(&self, py: Python<'_>) -> Result<Vec<u8>, Failure> {
        let ended = Watching::default().run(py, |_| Ok(self.model.encode()?.bytes))?;
        ended.error.map_or(Ok(ended.value), |error| Err(error.into()))
    }
}

/// Takes the options of a model from keyword arguments. All remaining arguments belong to the strip
/// method.
fn options(arguments: &Arguments<'_>) -> PyResult<view_model::Options> {
    let order: Option<String> = arguments.extract("order")?;
    let order: MergeOrder = order.as_deref().unwrap_or("quadric").parse().map_err(Failure::from)?;
    let verify = arguments.extract("verify")?.unwrap_or(true);
    let stripify = method::taken(arguments, "best")?;
    if stripify.weld {
        return Err(Failure::option("weld", "True", "False: each vertex keeps its attributes").into());
    }
    Ok(view_model::Options::default().with_stripify(stripify).with_order(order).with_verify(verify))
}

#[pymethods]
impl ViewModel {
    /// Build a model of a mesh.
    ///
    /// Args:
    ///     vertices: positions of shape (n, 3).
    ///     faces: see `stripify`. Polygons are triangulated.
    ///     method, **options: the method for the strips of the full mesh; see `stripify`: `effort`,
    ///         `cost`, …
    ///     order: the collapses that come first in a level: "quadric" (the cheaper half first,
    ///         vertices on features last) or "shortest-edge" (as published).
    ///     normals, uv, colors, attributes: per-vertex values; see `simplify`. Their seams stay
    ///         closed.
    ///     verify: whether to verify that the strips draw exactly the faces.
    ///     budget: the time limit of the strip search in seconds; the search then returns its best
    ///         result.
    ///     progress: see `stripify`.
    ///
    /// Raises:
    ///     MeshError, ArrayTypeError: the arrays do not form a mesh.
    ///     ParameterError: an option is unknown or has an invalid value.
    ///
    /// >>> import tristrip
    /// >>> tristrip.ViewModel.build([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    /// ViewModel(1 triangle, 0 collapses, 1 strip)
    #[classmethod]
    #[pyo3(
        signature = (vertices, faces, **given),
        text_signature = "($cls, vertices, faces, *, method='best', order='quadric', normals=None, uv=None, colors=None, attributes=None, verify=True, budget=None, progress=None, **options)"
    )]
    fn build<'py>(
        _: &Bound<'py, PyType>,
        py: Python<'py>,
        vertices: &Bound<'py, PyAny>,
        faces: &Bound<'py, PyAny>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Bound<'py, Self>> {
        let arguments = Arguments::of(py, given)?;
        let [normals, uv, colors] =
            [arguments.take("normals")?, arguments.take("uv")?, arguments.take("colors")?];
        let others: Option<Bound<'_, PyDict>> = arguments.extract("attributes")?;
        let watching = arguments.watching_searches()?;
        let options = options(&arguments)?;
        let (normals, uv, colors) = (normals.as_ref(), uv.as_ref(), colors.as_ref());
        let given = GivenAttributes { normals, uv, colors, others: others.as_ref() };
        let model = one_part(given.add_to(mesh_of(vertices, faces)?)?);
        Self::of_model(py, || Ok(model), options, watching)
    }

    /// Build a model of a scene, a mesh file, or the bytes of a file.
    ///
    /// The parts become one mesh, without the transforms of their nodes. Attributes that some parts
    /// lack are dropped, with a note.
    ///
    /// Args:
    ///     input: a scene, a file, or the bytes of a file.
    ///     format: the format of a file by extension. By default the file name or the content
    ///         determines it.
    ///     method, order, verify, budget, progress, **options: see `ViewModel.build`.
    ///
    /// Raises:
    ///     FileError: the file cannot be read.
    ///     FormatError, LimitError: the file is invalid or exceeds the limits.
    ///     ParameterError: an option is unknown or has an invalid value.
    ///
    /// >>> import tristrip
    /// >>> tristrip.ViewModel.from_scene(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", format="obj").triangle_count
    /// 1
    #[classmethod]
    #[pyo3(
        signature = (input, **given),
        text_signature = "($cls, input, *, format=None, method='best', order='quadric', verify=True, budget=None, progress=None, **options)"
    )]
    fn from_scene<'py>(
        _: &Bound<'py, PyType>,
        py: Python<'py>,
        input: &Bound<'py, PyAny>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Bound<'py, Self>> {
        let arguments = Arguments::of(py, given)?;
        let format: Option<String> = arguments.extract("format")?;
        let watching = arguments.watching_searches()?;
        let options = options(&arguments)?;
        let (input, format) = (Input::of(input)?, format_of(format.as_deref())?);
        let source = input.source();
        Self::of_model(py, || Ok(source.scene(format)?.as_read().clone()), options, watching)
    }

    /// Read a model from a `.tlod` file or its bytes.
    ///
    /// Raises:
    ///     FileError: the file cannot be read.
    ///     FormatError, LimitError: the file is invalid or exceeds the limits.
    ///
    /// >>> import tristrip
    /// >>> tristrip.ViewModel.load(b"PK")
    /// Traceback (most recent call last):
    /// tristrip.FormatError: byte 2: found the end of the file, expected a .tlod file
    #[classmethod]
    #[pyo3(signature = (input))]
    fn load<'py>(
        _: &Bound<'py, PyType>,
        py: Python<'py>,
        input: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, Self>> {
        let input = Input::file(input)?;
        let source = input.source();
        let ended = Watching::default().run(py, |_| {
            let bytes = source.bytes()?;
            let model = tlod::read(&bytes[..], &TlodLimits::default())?;
            Self::new(model.into(), Built::default())
        })?;
        ended.object(py, |model| model)
    }

    /// Return the bytes of a `.tlod` file. They are read back and compared with the model first.
    ///
    /// >>> import tristrip
    /// >>> model = tristrip.ViewModel.build([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    /// >>> tristrip.ViewModel.load(model.to_bytes()).triangle_count
    /// 1
    fn to_bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        Ok(PyBytes::new(py, &self.encoded(py)?))
    }

    /// Write a `.tlod` file. An existing file is replaced.
    ///
    /// Raises:
    ///     FileError: the file cannot be written.
    ///     NotProvenError: the bytes that were read back differ from the model, which is a bug in
    ///         this package.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let bytes = self.encoded(py)?;
        Ok(py.detach(|| tristrip_io::replace_file(&path, &bytes)).map_err(Failure::from)?)
    }

    /// The positions: float32 of shape (n, 3).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        attributes::positions_of(py, &self.model.mesh)
    }

    /// The triangles of the full mesh, in strip order: uint32 of shape (m, 3).
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        triangle_rows(py, self.model.sequence.triangles().to_vec())
    }

    /// The attributes by name, such as "NORMAL" and "TEXCOORD_0".
    #[getter]
    fn attributes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        attributes::all(py, &self.model.mesh)
    }

    /// The strips of the full mesh.
    #[getter]
    fn strips(&self) -> Strips {
        Strips::new(self.model.strips.clone(), None, None)
    }

    /// The number of triangles of the full mesh.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.model.sequence.triangles().len() / 3
    }

    /// The number of triangles of the base mesh, where views start.
    #[getter]
    fn base_triangle_count(&self) -> PyResult<usize> {
        Ok(self.tree.levels().triangle_count(0).map_err(Failure::from)?)
    }

    /// The number of collapses.
    #[getter]
    fn collapse_count(&self) -> usize {
        self.model.sequence.len()
    }

    /// The height of the merge tree: the maximum number of collapses from a vertex to its root.
    #[getter]
    fn height(&self, py: Python<'_>) -> u32 {
        py.detach(|| self.tree.height())
    }

    /// The memory in bytes: a dictionary with "strips" (of the full mesh) and "tree" (everything
    /// else except the mesh).
    #[getter]
    fn memory<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let [strips, tree] = self.tree.memory_by_part();
        let memory = PyDict::new(py);
        memory.set_item("strips", strips)?;
        memory.set_item("tree", tree)?;
        Ok(memory)
    }

    /// The report: a dictionary with the keys of the command's JSON.
    ///
    /// "method", "cost", … and "order" (for a model that was built), "proven", "parts", "vertices",
    /// "triangles", "strips", "collapses", "levels" (of the merge tree), "height", "bytes" (None,
    /// as no file has been written), "stopped", "notes".
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let found = DescribedModel {
            built: &self.built,
            vertices: self.model.mesh.vertex_count(),
            triangles: self.model.triangle_count(),
            strips: self.model.strips.len(),
            collapses: self.model.sequence.len(),
            height: self.height(py),
            bytes: None,
        };
        report(py, &found)
    }

    /// Notes on dropped or unusual data.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.built.notes.clone()
    }

    /// Create a view at the base mesh.
    ///
    /// Args:
    ///     filter: how to derive display strips from the strips of the full mesh: "none", "stss"
    ///         (El-Sana et al.), "dtfs" (Kim et al.) or "linked". "repair" instead maintains strips
    ///         of the current triangles. It has the fewest indices, but its time is proportional to
    ///         the triangle count.
    ///
    /// Raises:
    ///     ParameterError: the filter is unknown.
    #[pyo3(signature = (filter = "dtfs"))]
    fn view(&self, py: Python<'_>, filter: &str) -> PyResult<View> {
        let filter: DisplayFilter =
            filter.parse().map_err(|why| Failure::Parameter(format!("filter: {why}")))?;
        let (model, tree) = (&self.model, &self.tree);
        let cursor: Result<Cursor, tristrip::Error> = py.detach(|| {
            if let Some(filter) = filter.scanner() {
                return Ok(Cursor::Filtered(Box::new(tree.view_by(filter))));
            }
            let (sequence, repair) = (Arc::clone(&model.sequence), RepairOptions::default());
            Ok(Cursor::Repaired(Box::new(RepairedView::new(tree, &model.strips, sequence, repair)?)))
        });
        let cursor = cursor.map_err(Failure::from)?;
        let state = State { cursor, camera: None, pending: Pending::default() };
        Ok(View { model: Arc::clone(&self.model), filter, state: Mutex::new(state) })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let bytes = this.to_bytes(py)?.into_any();
        let levels = this.built.levels.into_pyobject(py)?.into_any();
        let notes = this.notes().into_pyobject(py)?.into_any();
        Ok((slf.get_type().getattr("_restore")?, PyTuple::new(py, [bytes, levels, notes])?))
    }

    #[classmethod]
    fn _restore(
        _: &Bound<'_, PyType>,
        bytes: &[u8],
        levels: Option<usize>,
        notes: Vec<String>,
    ) -> PyResult<Self> {
        let read = tlod::read(bytes, &TlodLimits::default()).map_err(Failure::from)?;
        Ok(Self::new(read.into(), Built { levels, notes, ..Built::default() })?)
    }

    fn __repr__(&self) -> String {
        let (triangles, collapses) =
            (counted(self.triangle_count(), "triangle"), counted(self.collapse_count(), "collapse"));
        format!("ViewModel({triangles}, {collapses}, {})", counted(self.model.strips.len(), "strip"))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let report = slf.get().report(slf.py())?;
        let arguments = ("model of view-dependent detail", report);
        slf.py().import("tristrip._notebook")?.call_method1("report_html", arguments)
    }
}

/// The detail criteria for a camera: keyword arguments of `View.set_view`.
#[derive(Debug, Clone, Copy)]
struct Detail {
    field_of_view: f32,
    image: [u32; 2],
    criteria: ViewCriteria,
}

impl Detail {
    /// Takes the criteria from keyword arguments.
    fn taken(arguments: &Arguments<'_>) -> PyResult<Self> {
        let field_of_view = arguments.extract("field_of_view")?.unwrap_or(tristrip::lod::View::FIELD_OF_VIEW);
        let image = arguments.extract("image")?.unwrap_or(USUAL_IMAGE);
        let is_kept = |name: &str| PyResult::Ok(arguments.extract(name)?.unwrap_or(true));
        let mut criteria = ViewCriteria::default()
            .with_pixels(arguments.extract("pixels")?.unwrap_or(1.0))
            .with_frustum(is_kept("frustum")?)
            .with_back_faces(is_kept("back_faces")?)
            .with_silhouettes(is_kept("silhouettes")?);
        if let Some(Count(most)) = arguments.extract("triangles")? {
            criteria = criteria.with_budget(most);
        }
        match arguments.extract("steps")? {
            Some(Count(0)) => {
                return Err(Failure::option("steps", 0, "at least 1: a view could not change").into());
            }
            Some(Count(steps)) => criteria = criteria.with_steps(steps),
            None => (),
        }
        if let Some(direction) = arguments.extract("light")? {
            criteria = criteria.with_light(direction);
        }
        let attention = arguments.extract("attention")?.unwrap_or(MIDDLE);
        if let Some(growth) = arguments.extract("foveation")? {
            let wrong = |_| Failure::option("foveation", growth, "a finite number of at least 0");
            let foveation = Foveation::new(growth).map_err(wrong)?;
            criteria = criteria.with_foveation(foveation.with_attention(attention).map_err(Failure::from)?);
        }
        criteria.check().map_err(Failure::from)?;
        Ok(Self { field_of_view, image, criteria })
    }
}

/// A cursor over a `ViewModel` that follows one camera from frame to frame.
///
/// Created by `ViewModel.view` at the base mesh. Views share their model. `copy.copy` makes a
/// second view in the same state.
#[pyclass(frozen, module = "tristrip")]
pub(crate) struct View {
    model: Arc<view_model::ViewModel>,
    filter: DisplayFilter,
    state: Mutex<State>,
}

/// An index buffer and its changed ranges as (start, end).
type Changed<'py> = (Bound<'py, PyAny>, Vec<(usize, usize)>);

/// The mutable state.
#[derive(Clone)]
struct State {
    cursor: Cursor,
    camera: Option<Camera>,
    pending: Pending,
}

#[derive(Clone)]
enum Cursor {
    Filtered(Box<SkipView>),
    Repaired(Box<RepairedView>),
}

/// The changes since the last call of `update`.
#[derive(Clone, Default)]
struct Pending {
    /// The index bits at that time, and the indices if the filter reports no changes.
    last: Option<(u8, Vec<u32>)>,
    ranges: Vec<Range<usize>>,
}

impl Cursor {
    fn view(&self) -> &SkipView {
        match self {
            Self::Filtered(view) => view,
            Self::Repaired(view) => view.view(),
        }
    }

    fn update(&mut self, camera: &Camera, criteria: &ViewCriteria) -> Result<ViewUpdate, tristrip::Error> {
        match self {
            Self::Filtered(view) => view.update(camera, criteria),
            Self::Repaired(view) => view.update(camera, criteria),
        }
    }

    fn strips(&mut self) -> tristrip::Strips {
        match self {
            Self::Filtered(view) => view.display_strips(),
            Self::Repaired(view) => view.strips().clone(),
        }
    }
}

impl View {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Accesses the state. Releases the GIL while it waits for other threads.
    fn with<T: Send>(&self, py: Python<'_>, look: impl FnOnce(&mut State) -> T + Send) -> T {
        py.detach(|| look(&mut self.state()))
    }
}

#[pymethods]
impl View {
    /// Move to the detail that a camera needs. The work is proportional to what changes.
    ///
    /// Args:
    ///     eye: the camera position (x, y, z), in mesh units.
    ///     look_at: the point that the camera looks at.
    ///     direction: the view direction, instead of `look_at`.
    ///     up: the up direction of the image.
    ///     field_of_view: the vertical field of view, in degrees.
    ///     image: the width and height of the image, in pixels.
    ///     pixels: the maximum error of a collapse in the image, in pixels.
    ///     triangles: the maximum number of triangles. If the error needs more, the largest errors
    ///         in pixels are reduced first. The base mesh may exceed it.
    ///     steps: the maximum number of collapses and splits per call; the next call continues. By
    ///         default unlimited.
    ///     frustum: whether to use minimum detail outside the image.
    ///     back_faces: whether back faces may have four times the error.
    ///     silhouettes: whether silhouettes are limited to half the error.
    ///     light: the direction to a light. Faces turned away from it may have twice the error.
    ///     foveation: the growth of the allowed error per degree from the gaze direction; at d
    ///         degrees the factor is 1 + foveation × d.
    ///     attention: the gaze point in the image, as fractions of its width from the left and of
    ///         its height from the top.
    ///
    /// Returns: A dictionary: "triangles" and "active_vertices" of the view, "collapses" and
    ///     "splits" applied, "looked_at" (collapses whose error was computed), "segments" of strips
    ///     scanned, "complete" (False if the limit `steps` was reached).
    ///
    /// Raises:
    ///     ParameterError: the camera has no direction, or a number is out of range. The view is
    ///         unchanged.
    ///
    /// References:
    ///     El-Sana et al.: Efficiently Computing and Updating Triangle Strips for Real-Time
    ///     Rendering, 2000, section 5.
    ///     Guenter et al.: Foveated 3D Graphics, 2012.
    ///
    /// >>> import tristrip
    /// >>> view = tristrip.ViewModel.build([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]).view()
    /// >>> view.set_view((0, 0, 5), direction=(0, 0, -1), pixels=2, triangles=1000)["complete"]
    /// True
    #[pyo3(
        signature = (eye, look_at = None, **given),
        text_signature = "($self, eye, look_at=None, *, direction=None, up=(0.0, 1.0, 0.0), field_of_view=45.0, image=(1920, 1080), pixels=1.0, triangles=None, steps=None, frustum=True, back_faces=True, silhouettes=True, light=None, foveation=None, attention=(0.5, 0.5))"
    )]
    fn set_view<'py>(
        &self,
        py: Python<'py>,
        eye: [f32; 3],
        look_at: Option<[f32; 3]>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let arguments = Arguments::of(py, given)?;
        let (direction, up) = (arguments.extract("direction")?, arguments.extract("up")?.unwrap_or(UPWARD));
        let Detail { field_of_view, image: [columns, rows], criteria } = Detail::taken(&arguments)?;
        arguments.finish("View.set_view")?;
        let look_at = match (look_at, direction) {
            (Some(look_at), None) => look_at,
            (None, Some(direction)) => ahead(eye, direction)?,
            _ => return Err(Failure::Parameter("look_at, direction: expected exactly one".into()).into()),
        };
        let camera = Camera::new(eye, look_at)
            .and_then(|camera| camera.with_up(up))
            .and_then(|camera| camera.with_field_of_view(field_of_view))
            .and_then(|camera| camera.with_image(columns, rows))
            .map_err(Failure::from)?;
        let moved = self.with(py, |state| {
            let mut update = state.cursor.update(&camera, &criteria)?;
            state.camera = Some(camera);
            state.pending.ranges.append(&mut update.changed);
            let view = state.cursor.view();
            Ok::<_, Failure>((update, [view.triangle_count(), view.active_vertex_count()]))
        });
        let (update, [triangles, active_vertices]) = moved?;
        let found = PyDict::new(py);
        let ViewUpdate { collapses, splits, looked_at, segments, .. } = update;
        let counts =
            [("triangles", triangles), ("active_vertices", active_vertices), ("collapses", collapses)];
        let work = [("splits", splits), ("looked_at", looked_at), ("segments", segments)];
        for (name, count) in counts.into_iter().chain(work) {
            found.set_item(name, count)?;
        }
        found.set_item("complete", update.is_complete)?;
        Ok(found)
    }

    /// The number of triangles of the view.
    #[getter]
    fn triangle_count(&self, py: Python<'_>) -> usize {
        self.with(py, |state| state.cursor.view().triangle_count())
    }

    /// The number of active vertices. A vertex is active unless it has collapsed.
    #[getter]
    fn active_vertex_count(&self, py: Python<'_>) -> usize {
        self.with(py, |state| state.cursor.view().active_vertex_count())
    }

    /// The maximum error of the applied collapses, in mesh units. This error can be at a position
    /// that is not visible.
    #[getter]
    fn surface_error(&self, py: Python<'_>) -> f32 {
        self.with(py, |state| {
            let errors: Vec<f32> = self.model.sequence.iter().map(|collapse| collapse.error).collect();
            let done = state.cursor.view().collapses_done();
            done.filter_map(|number| errors.get(number)).copied().fold(0.0, f32::max)
        })
    }

    /// The name of the filter of the display strips.
    #[getter]
    fn filter(&self) -> &'static str {
        self.filter.name()
    }

    /// Return the display strips, over the vertices of the model.
    fn strips(&self, py: Python<'_>) -> Strips {
        Strips::new(self.with(py, |state| state.cursor.strips()), None, None)
    }

    /// Return the index buffer of the display strips; see `Strips.indices`.
    #[pyo3(signature = (layout = "restart", dtype = None))]
    fn indices<'py>(
        slf: &Bound<'py, Self>,
        layout: &str,
        dtype: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let strips = slf.get().strips(slf.py());
        Bound::new(slf.py(), strips)?.call_method1("indices", (layout, dtype))
    }

    /// Return an index buffer to draw, and its changed ranges.
    ///
    /// Each range (start, end) is in indices, relative to the last call with the same dtype. Only
    /// these ranges need to be uploaded to the GPU. The maximum of the dtype separates strips and
    /// fills unused slots, so unchanged strips keep their slots.
    ///
    /// The dtype is "uint8", "uint16" or "uint32"; by default "uint16" if all vertices fit.
    ///
    /// Raises:
    ///     ParameterError: the dtype is unknown, or a vertex index does not fit it.
    #[pyo3(signature = (dtype = None))]
    fn update<'py>(&self, py: Python<'py>, dtype: Option<&Bound<'py, PyAny>>) -> PyResult<Changed<'py>> {
        let vertex_count = self.model.mesh.vertex_count();
        let bits = index_bits(py, dtype, vertex_count)?;
        if vertex_count > (1_usize << bits) - 1 {
            let expected = format!("a dtype for {}", tristrip::text::counted(vertex_count, "vertex"));
            return Err(Failure::option("dtype", format!("uint{bits}"), &expected).into());
        }
        let (indices, changed) = self.with(py, |state| state.changes(bits));
        let array = match bits {
            8 => PyArray1::from_vec(py, narrowed(&indices, |x| x as u8)).into_any(),
            16 => PyArray1::from_vec(py, narrowed(&indices, |x| x as u16)).into_any(),
            _ => PyArray1::from_vec(py, indices).into_any(),
        };
        Ok((array, changed.into_iter().map(|range| (range.start, range.end)).collect()))
    }

    /// Return the triangles of the view: uint32 of shape (n, 3).
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        triangle_rows(py, self.with(py, |state| state.cursor.strips().to_list()))
    }

    /// Verify that the display strips draw exactly the triangles of the view, and return the number
    /// of triangles.
    ///
    /// Raises:
    ///     NotProvenError: the display strips draw other triangles, which is a bug in this package.
    fn verify(&self, py: Python<'_>) -> PyResult<usize> {
        let proven = self.with(py, |state| {
            let strips = state.cursor.strips();
            prove_view(state.cursor.view(), &strips)
        });
        Ok(proven.map_err(Failure::from)?)
    }

    /// Render the view from the camera of the last `set_view`, as the bytes of a PNG.
    ///
    /// Args:
    ///     shaded: whether to shade the surface in grey instead of one colour per strip.
    ///
    /// Raises:
    ///     ParameterError: `set_view` has not been called, or its image is larger than 8192 pixels.
    #[pyo3(signature = (*, shaded = false))]
    fn picture<'py>(&self, py: Python<'py>, shaded: bool) -> PyResult<Bound<'py, PyBytes>> {
        let (camera, strips) = self.with(py, |state| (state.camera, state.cursor.strips()));
        let camera = camera.ok_or_else(|| Failure::Parameter("picture: call set_view first".into()))?;
        let positions = self.model.mesh.positions();
        let ended = Watching::default().run(py, |_| {
            let [columns, rows] = camera.image();
            let options = RenderOptions::default().with_size(columns, rows);
            let picture = if shaded {
                triangles_seen(&[(positions, &strips.to_list())], &camera, &options)
            } else {
                strips_seen(&[(positions, &strips)], &camera, &options)
            };
            Ok(picture?)
        })?;
        Ok(PyBytes::new(py, &ended.result()?))
    }

    /// The memory of the view in bytes, without the model.
    #[getter]
    fn memory(&self, py: Python<'_>) -> usize {
        self.with(py, |state| match &state.cursor {
            Cursor::Filtered(view) => view.memory(),
            Cursor::Repaired(view) => view.memory(),
        })
    }

    fn __copy__(&self, py: Python<'_>) -> Self {
        let state = Mutex::new(self.with(py, |state| state.clone()));
        Self { model: Arc::clone(&self.model), filter: self.filter, state }
    }

    fn __deepcopy__(&self, py: Python<'_>, _memo: &Bound<'_, PyAny>) -> Self {
        self.__copy__(py)
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        let full = self.model.sequence.triangles().len() / 3;
        let found = count(self.triangle_count(py));
        format!("View({found} of {}, filter {})", counted(full, "triangle"), self.filter.name())
    }

    /// Returns the PNG that notebooks show.
    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyBytes>>> {
        if self.with(py, |state| state.camera.is_none()) {
            return Ok(None);
        }
        self.picture(py, false).map(Some)
    }
}

impl State {
    /// Returns the index buffer for indices of `bits` bits, and the ranges changed since the last
    /// call.
    fn changes(&mut self, bits: u8) -> (Vec<u32>, Vec<Range<usize>>) {
        let Self { cursor, pending, .. } = self;
        let is_first = pending.last.as_ref().is_none_or(|(last, _)| *last != bits);
        let (indices, changed) = match cursor {
            Cursor::Filtered(view) => (view.indices().to_vec(), joined(std::mem::take(&mut pending.ranges))),
            Cursor::Repaired(view) => {
                let mut old = pending.last.take().map(|(_, old)| old).unwrap_or_default();
                // 32-bit indices fit all vertices.
                let changed = view.strips().update_indices(tristrip::Layout::Restart, &mut old);
                (old, changed.unwrap_or_default())
            }
        };
        let kept = if matches!(cursor, Cursor::Repaired(_)) { indices.clone() } else { Vec::new() };
        pending.last = Some((bits, kept));
        if is_first {
            let all = 0..indices.len();
            return (indices, if all.is_empty() { Vec::new() } else { vec![all] });
        }
        (indices, changed)
    }
}

/// Sorts ranges, and merges those that overlap or touch.
fn joined(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    ranges.sort_unstable_by_key(|range| range.start);
    let mut out: Vec<Range<usize>> = Vec::with_capacity(ranges.len());
    for range in ranges {
        match out.last_mut().filter(|last| range.start <= last.end) {
            Some(last) => last.end = last.end.max(range.end),
            None => out.push(range),
        }
    }
    out
}

/// Converts indices to a smaller type. The `u32` restart value becomes the restart value of that
/// type.
fn narrowed<T>(indices: &[u32], narrow: fn(u32) -> T) -> Vec<T> {
    // All low bits of `RESTART` are set.
    const { assert!(RESTART == u32::MAX) };
    indices.iter().map(|&index| narrow(index)).collect()
}

/// Returns a point in a direction. Its distance equals the distance of the eye from the origin,
/// which keeps the rounding error of the direction small.
fn ahead(eye: [f32; 3], direction: [f32; 3]) -> Result<[f32; 3], Failure> {
    let wide = direction.map(f64::from);
    let length = wide.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length.is_finite() && length > 0.0) {
        return Err(Failure::option("direction", format!("{direction:?}"), "a finite direction"));
    }
    let distance = eye.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt().max(1.0);
    Ok([0, 1, 2].map(|k| (f64::from(eye[k]) + wide[k] / length * distance) as f32))
}
