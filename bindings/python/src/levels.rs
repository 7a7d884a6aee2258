//! Levels of detail: the class `Levels`, a cursor over any level model.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple, PyType};
use serde::Serialize;
use tristrip::Layout;
use tristrip::lod::{ModelKind, View};
use tristrip_pipeline::{
    Error, Ratio, SearchStop, levels, levels::LevelGoal, levels::ModelCursor, levels::ModelLevels, rounded,
};

use crate::arguments::Arguments;
use crate::arrays::indices_to_array;
use crate::attributes::{GivenAttributes, positions_of};
use crate::errors::Failure;
use crate::mesh::{mesh_of, one_part};
use crate::method;
use crate::numbers::Count;
use crate::reports::report;
use crate::scene::class::Scene;
use crate::scene::data::SceneData;
use crate::simplify::deviation;
use crate::strips::{Strips, index_bits, layout_of};

/// A mesh at any level of detail.
///
/// Levels share the strips of the full mesh, with vertices renamed by half-edge collapses; the
/// level model determines how they are stored. Level 0 is the base mesh and the last level is the
/// full mesh. All levels have the same vertices. An object is at one level at a time.
/// `Scene.levels` builds the levels of all parts of a scene.
///
/// Args:
///     vertices: positions of shape (n, 3).
///     faces: see `stripify`.
///     model: the level model: "progressive-mesh", "naive", "progressive", "sets", "blocks" or
///         "skip"; see `tristrip level --model`. "blocks" has the fewest indices at coarse levels
///         and uses the least memory.
///     base: the ratio of triangles in the base mesh. By default, the base mesh has as few
///         triangles as possible.
///     price: the cost function of collapses; see `simplify`.
///     normals, uv, colors, attributes: per-vertex values; see `simplify`. Their seams stay closed.
///     method, effort, cost, **options: the method for the strips of the full mesh; see `stripify`.
///     verify: whether to verify the strips.
///     progress: see `stripify`.
///
/// Raises:
///     MeshError: the arrays do not form a mesh.
///     ArrayTypeError: an array has an unsupported type.
///     ParameterError: an option is unknown or has an invalid value.
///
/// References:
///     "naive" and "progressive": Kim, Park, Yang, Neelamkavil: A Rendering-Efficient Progressive
///     Transmission of 3D Meshes, 2005.
///     "sets": Belmonte, Aguado, Sancho: Triangle Strip Multiresolution Modelling Using Sorted
///     Edges, 2006.
///     "progressive-mesh": Hoppe: Progressive Meshes, 1996.
///     "skip": El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli: Efficiently Computing and
///     Updating Triangle Strips for Real-Time Rendering, 2000.
///     "blocks": a model of this project.
///
/// >>> import numpy, tristrip
/// >>> angle = numpy.linspace(0, 2 * numpy.pi, 33)[:-1]
/// >>> rings = [numpy.column_stack([numpy.cos(angle), numpy.sin(angle), numpy.full(32, float(z))]) for z in range(20)]
/// >>> corner = numpy.arange(19 * 32)
/// >>> right = corner // 32 * 32 + (corner + 1) % 32
/// >>> levels = tristrip.Levels(numpy.concatenate(rings), numpy.column_stack([corner, right, right + 32, corner + 32]))
/// >>> levels.triangle_count
/// 1216
/// >>> level = levels.set_triangles(100)
/// >>> levels.triangle_count <= 100, len(levels.indices()) < 250
/// (True, True)
#[pyclass(frozen, module = "tristrip")]
pub(crate) struct Levels {
    built: Arc<ModelLevels>,
    /// Why the strip search was stopped, if it was.
    stopped: Option<SearchStop>,
    notes: Vec<String>,
    scene: Arc<SceneData>,
    kind: ModelKind,
    /// The arguments of `Scene.levels`, from which unpickling rebuilds the levels.
    arguments: Py<PyDict>,
    state: Mutex<State>,
}

/// An index buffer and its changed ranges.
type Updated<'py> = (Bound<'py, PyAny>, Vec<(usize, usize)>);

/// The mutable state.
struct State {
    cursor: ModelCursor,
    /// The index buffers of `update` by part, layout and index bits.
    buffers: HashMap<(usize, Layout, u8), Buffer>,
}

/// An index buffer that is updated in place.
enum Buffer {
    U8(Vec<u8>),
    U16(Vec<u16>),
    U32(Vec<u32>),
}

/// A row of `table`.
#[derive(Serialize)]
struct LevelRow {
    level: usize,
    triangles: usize,
    surface_error: f32,
    strips: usize,
    indices_restart: usize,
    indices_restart_per_triangle: f64,
}

impl Levels {
    /// Builds the levels of a scene from the arguments of `Scene.levels`.
    pub(crate) fn build(scene: Arc<SceneData>, arguments: &Arguments<'_>) -> PyResult<Self> {
        let watching = arguments.watching()?;
        let kept = arguments.rest()?;
        let kind: Option<String> = arguments.extract("model")?;
        let kind = kind
            .map(|name| name.parse::<ModelKind>().map_err(Failure::from))
            .transpose()?
            .unwrap_or_default();
        let options = options_of(arguments)?;
        let ended = watching.run(kept.py(), |watcher| {
            let built = levels::run(scene.as_read(), &options, watcher)?;
            let cursor = built.model.cursor(kind)?;
            Ok((built, cursor))
        })?;
        let (built, cursor) = ended.result()?;
        let (stopped, notes) = (built.stopped, built.notes);
        let state = Mutex::new(State { cursor, buffers: HashMap::new() });
        Ok(Self {
            built: Arc::new(built.model),
            stopped,
            notes,
            scene,
            kind,
            arguments: kept.unbind(),
            state,
        })
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, py: Python<'_>, goal: LevelGoal) -> PyResult<usize> {
        let moved: Result<usize, Error> = py.detach(|| {
            let level = self.built.level_of(goal)?;
            self.state().cursor.set_level(level)?;
            Ok(level)
        });
        Ok(moved.map_err(Failure::from)?)
    }

    /// Returns the strips of a part at the current level, over its vertices.
    fn strips_of(&self, py: Python<'_>, part: usize) -> Result<tristrip::Strips, Failure> {
        py.detach(|| self.strips_in(&mut self.state(), part))
    }

    fn strips_in(&self, state: &mut State, part: usize) -> Result<tristrip::Strips, Failure> {
        let count = self.built.parts.len();
        let cursors = state.cursor.of_parts_mut();
        let (Some(own), Some(cursor)) = (self.built.parts.get(part), cursors.get_mut(part)) else {
            return Err(Failure::option("part", part, &format!("less than {count}")));
        };
        Ok(own.outward(cursor.strips())?)
    }

    /// Returns the maximum error of the parts at a level.
    fn error_at(&self, level: usize) -> Result<f32, Failure> {
        let of_parts = self.built.order.of_parts(level)?;
        let errors = self.built.parts.iter().zip(of_parts).map(|(part, level)| part.sequence().error(level));
        Ok(errors.collect::<Result<Vec<f32>, _>>()?.into_iter().fold(0.0, f32::max))
    }

    fn row(&self, cursor: &mut ModelCursor, level: usize) -> Result<LevelRow, Failure> {
        cursor.set_level(level)?;
        let (mut strips, mut indices) = (0, 0);
        for part in cursor.of_parts_mut() {
            let drawn = part.strips();
            strips += drawn.len();
            indices += drawn.index_count(Layout::Restart);
        }
        let triangles = self.built.triangle_count(level)?;
        let ratio = if triangles > 0 { indices as f64 / triangles as f64 } else { 0.0 };
        let surface_error = self.error_at(level)?;
        let indices_restart_per_triangle = rounded(ratio);
        Ok(LevelRow {
            level,
            triangles,
            surface_error,
            strips,
            indices_restart: indices,
            indices_restart_per_triangle,
        })
    }
}

#[pymethods]
impl Levels {
    #[new]
    #[pyo3(signature = (
        vertices, faces, *, model = "blocks", base = None, price = "distance", normals = None, uv = None, colors = None,
        attributes = None, method = "best", effort = None, cost = None, verify = true, progress = None, **options
    ))]
    #[allow(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn new<'py>(
        py: Python<'py>,
        vertices: &Bound<'py, PyAny>,
        faces: &Bound<'py, PyAny>,
        model: &str,
        base: Option<f64>,
        price: &str,
        normals: Option<&Bound<'py, PyAny>>,
        uv: Option<&Bound<'py, PyAny>>,
        colors: Option<&Bound<'py, PyAny>>,
        attributes: Option<&Bound<'py, PyDict>>,
        method: &str,
        effort: Option<i64>,
        cost: Option<&str>,
        verify: bool,
        progress: Option<Bound<'py, PyAny>>,
        options: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Self> {
        let arguments = method::parameters(py, options, effort, cost)?;
        arguments.set_item("model", model)?;
        arguments.set_item("base", base)?;
        arguments.set_item("price", price)?;
        arguments.set_item("method", method)?;
        arguments.set_item("verify", verify)?;
        arguments.set_item("progress", progress)?;
        let given = GivenAttributes { normals, uv, colors, others: attributes };
        let model = one_part(given.add_to(mesh_of(vertices, faces)?)?);
        Self::build(Arc::new(SceneData::of_model(model)), &Arguments::of(py, Some(&arguments))?)
    }

    /// The current level.
    #[getter]
    fn level(&self, py: Python<'_>) -> usize {
        py.detach(|| self.state().cursor.level())
    }

    /// The last level, which is the full mesh. It equals the number of collapses.
    #[getter]
    fn last_level(&self) -> usize {
        self.built.collapse_count()
    }

    /// The number of parts. Each part has its own vertices and strips. Arrays make one part.
    #[getter]
    fn part_count(&self) -> usize {
        self.built.parts.len()
    }

    /// The name of the level model.
    #[getter]
    fn model(&self) -> &'static str {
        self.kind.name()
    }

    /// The number of triangles at the current level.
    #[getter]
    fn triangle_count(&self, py: Python<'_>) -> PyResult<usize> {
        Ok(self.built.triangle_count(self.level(py)).map_err(Failure::from)?)
    }

    /// The maximum collapse error at the current level, in mesh units.
    #[getter]
    fn surface_error(&self, py: Python<'_>) -> PyResult<f32> {
        Ok(self.error_at(self.level(py))?)
    }

    /// The diagonal of the bounding box, in mesh units. Error percentages are relative to it.
    #[getter]
    fn diagonal(&self) -> f64 {
        self.built.collapses.diagonal
    }

    /// Notes on dropped or unusual data.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Why the strip search was stopped: "budget", "interrupt", or None.
    #[getter]
    fn stopped(&self) -> Option<&'static str> {
        self.stopped.map(|stopped| if stopped == SearchStop::Budget { "budget" } else { "interrupt" })
    }

    /// Return the positions of a part: float32 of shape (n, 3). They are the same at all levels.
    ///
    /// Raises:
    ///     ParameterError: the part does not exist.
    #[pyo3(signature = (part = Count(0)), text_signature = "($self, part=0)")]
    fn vertices<'py>(&self, py: Python<'py>, part: Count) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let parts = &self.scene.as_read().parts;
        let (count, found) = (parts.len(), parts.get(part.0));
        let found = found.ok_or_else(|| Failure::option("part", part.0, &format!("less than {count}")))?;
        positions_of(py, &found.mesh)
    }

    /// Move to a level and return its index.
    ///
    /// Args:
    ///     level: an index from 0 (base mesh) to `last_level`, or a percentage such as "40%".
    ///
    /// Raises:
    ///     ParameterError: the level does not exist; the current level is unchanged.
    fn set_level(&self, py: Python<'_>, level: &Bound<'_, PyAny>) -> PyResult<usize> {
        let text = level.str()?.to_string();
        let level = text.parse().map_err(|why| Failure::Parameter(format!("level: {why}")))?;
        self.set(py, LevelGoal::Level(level))
    }

    /// Move to the finest level with at most this many triangles, and return its index.
    fn set_triangles(&self, py: Python<'_>, triangles: Count) -> PyResult<usize> {
        self.set(py, LevelGoal::Triangles(triangles.0))
    }

    /// Move to the coarsest level within an error, and return its index.
    ///
    /// Args:
    ///     error: the maximum error in mesh units, or in percent of the bounding-box diagonal, such
    ///         as "0.1%".
    ///
    /// Raises:
    ///     ParameterError: the error is negative or NaN.
    fn set_error(&self, py: Python<'_>, error: &Bound<'_, PyAny>) -> PyResult<usize> {
        self.set(py, LevelGoal::Error(deviation("error", error)?))
    }

    /// Move to the coarsest level within an error on screen, and return its index.
    ///
    /// Args:
    ///     pixels: the maximum error on screen, in pixels.
    ///     distance: from the camera to the nearest point of the mesh, in mesh units.
    ///     field_of_view: the vertical field of view, in degrees.
    ///     rows: the height of the screen, in pixels.
    ///
    /// Raises:
    ///     ParameterError: a number is not positive.
    #[pyo3(
        signature = (pixels, distance, *, field_of_view = View::FIELD_OF_VIEW, rows = View::ROWS),
        text_signature = "($self, pixels, distance, *, field_of_view=45.0, rows=1080.0)"
    )]
    fn set_pixels(
        &self,
        py: Python<'_>,
        pixels: f32,
        distance: f32,
        field_of_view: f32,
        rows: f32,
    ) -> PyResult<usize> {
        let view = View::of_camera(distance, field_of_view, rows).map_err(Failure::from)?;
        self.set(py, LevelGoal::Pixels(pixels, view))
    }

    /// Return the strips of a part at the current level.
    #[pyo3(signature = (part = Count(0)), text_signature = "($self, part=0)")]
    fn strips(&self, py: Python<'_>, part: Count) -> PyResult<Strips> {
        Ok(Strips::new(self.strips_of(py, part.0)?, None, None))
    }

    /// Return the index buffer of a part at the current level; see `Strips.indices`.
    #[pyo3(signature = (layout = "restart", dtype = None, *, part = Count(0)), text_signature = "($self, layout='restart', dtype=None, *, part=0)")]
    fn indices<'py>(
        &self,
        py: Python<'py>,
        layout: &str,
        dtype: Option<&Bound<'py, PyAny>>,
        part: Count,
    ) -> PyResult<Bound<'py, PyAny>> {
        let layout = layout_of(layout)?;
        let strips = self.strips_of(py, part.0)?;
        let vertex_count = self.built.parts.get(part.0).map_or(0, levels::LevelPart::vertex_count);
        let bits = index_bits(py, dtype, vertex_count)?;
        Ok(indices_to_array(py, &strips, layout, bits)?)
    }

    /// Return the triangles of a part at the current level: uint32 of shape (n, 3).
    #[pyo3(signature = (part = Count(0)), text_signature = "($self, part=0)")]
    fn triangles<'py>(&self, py: Python<'py>, part: Count) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let list = self.strips_of(py, part.0)?.to_list();
        let rows = list.len() / 3;
        PyArray1::from_vec(py, list).reshape([rows, 3])
    }

    /// Return the index buffer of a part at the current level, and its changed ranges.
    ///
    /// Each range (start, end) is in indices, relative to the last call with the same layout and
    /// dtype. Only these ranges need to be uploaded to the GPU.
    ///
    /// The dtype is "uint8", "uint16" or "uint32"; by default "uint16" if all vertices fit.
    #[pyo3(signature = (layout = "restart", dtype = None, *, part = Count(0)), text_signature = "($self, layout='restart', dtype=None, *, part=0)")]
    fn update<'py>(
        &self,
        py: Python<'py>,
        layout: &str,
        dtype: Option<&Bound<'py, PyAny>>,
        part: Count,
    ) -> PyResult<Updated<'py>> {
        let layout = layout_of(layout)?;
        let vertex_count = self.built.parts.get(part.0).map_or(0, levels::LevelPart::vertex_count);
        let bits = index_bits(py, dtype, vertex_count)?;
        // Don't keep the state locked while Python runs: threads that wait for it would deadlock.
        let (buffer, changed) = py.detach(|| {
            let mut state = self.state();
            let strips = self.strips_in(&mut state, part.0)?;
            let buffer = state.buffers.entry((part.0, layout, bits)).or_insert_with(|| match bits {
                8 => Buffer::U8(Vec::new()),
                16 => Buffer::U16(Vec::new()),
                _ => Buffer::U32(Vec::new()),
            });
            Ok::<_, Failure>(match buffer {
                Buffer::U8(old) => {
                    let changed = strips.update_indices(layout, old)?;
                    (Buffer::U8(old.clone()), changed)
                }
                Buffer::U16(old) => {
                    let changed = strips.update_indices(layout, old)?;
                    (Buffer::U16(old.clone()), changed)
                }
                Buffer::U32(old) => {
                    let changed = strips.update_indices(layout, old)?;
                    (Buffer::U32(old.clone()), changed)
                }
            })
        })?;
        let array = match buffer {
            Buffer::U8(indices) => PyArray1::from_vec(py, indices).into_any(),
            Buffer::U16(indices) => PyArray1::from_vec(py, indices).into_any(),
            Buffer::U32(indices) => PyArray1::from_vec(py, indices).into_any(),
        };
        Ok((array, changed.into_iter().map(|range| (range.start, range.end)).collect()))
    }

    /// Return the vertex that replaces each vertex of a part at the current level: uint32 of shape
    /// (n,).
    #[pyo3(signature = (part = Count(0)), text_signature = "($self, part=0)")]
    fn renaming<'py>(&self, py: Python<'py>, part: Count) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let level = self.level(py);
        let renamed = py.detach(|| {
            let count = self.built.parts.len();
            let found = self.built.parts.get(part.0);
            let found =
                found.ok_or_else(|| Failure::option("part", part.0, &format!("less than {count}")))?;
            let of_parts = self.built.order.of_parts(level)?;
            let level = of_parts.get(part.0).copied().unwrap_or_default();
            Ok::<_, Failure>(found.renaming(level)?)
        })?;
        Ok(PyArray1::from_vec(py, renamed))
    }

    /// Verify that the strips of all parts draw exactly the triangles of the current level.
    ///
    /// Raises:
    ///     NotProvenError: the strips draw other triangles, which is a bug in this package.
    fn verify(&self, py: Python<'_>) -> PyResult<()> {
        let proven: Result<(), Failure> = py.detach(|| {
            let mut state = self.state();
            let of_parts = self.built.order.of_parts(state.cursor.level())?;
            let cursors = state.cursor.of_parts_mut().iter_mut();
            for ((part, cursor), level) in self.built.parts.iter().zip(cursors).zip(of_parts) {
                part.prove(level, cursor.strips())?;
            }
            Ok(())
        });
        Ok(proven?)
    }

    /// Return a second cursor at the full mesh, for another instance or view. It shares the model.
    fn another(&self, py: Python<'_>) -> PyResult<Self> {
        let cursor = py.detach(|| self.state().cursor.another()).map_err(Failure::from)?;
        let (built, scene) = (Arc::clone(&self.built), Arc::clone(&self.scene));
        let arguments = self.arguments.clone_ref(py);
        let state = Mutex::new(State { cursor, buffers: HashMap::new() });
        let (stopped, notes) = (self.stopped, self.notes.clone());
        Ok(Self { built, stopped, notes, scene, kind: self.kind, arguments, state })
    }

    /// Return metrics of evenly spaced levels, from the base mesh to the full mesh.
    ///
    /// Args:
    ///     steps: the number of intervals between the levels.
    ///
    /// Returns:
    ///     A list of dictionaries: "level", "triangles", "surface_error", "strips",
    ///     "indices_restart" and "indices_restart_per_triangle".
    #[pyo3(signature = (steps = Count(20)), text_signature = "($self, steps=20)")]
    fn table<'py>(&self, py: Python<'py>, steps: Count) -> PyResult<Bound<'py, PyAny>> {
        let rows: Result<Vec<LevelRow>, Failure> = py.detach(|| {
            let mut cursor = self.state().cursor.another()?;
            let steps = steps.0.min(self.built.collapse_count().max(1));
            self.built.order.evenly(steps).into_iter().map(|level| self.row(&mut cursor, level)).collect()
        });
        report(py, &rows?)
    }

    /// The memory of the model and of this cursor in bytes: a dictionary with "model" and "cursor".
    #[getter]
    fn memory<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (model, cursor) = py.detach(|| {
            let state = self.state();
            (state.cursor.model_memory(), state.cursor.cursor_memory())
        });
        let memory = PyDict::new(py);
        memory.set_item("model", model)?;
        memory.set_item("cursor", cursor)?;
        Ok(memory)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let (level, last) = (self.level(py), self.last_level());
        let counted = tristrip_pipeline::text::counted;
        let triangles = counted(self.triangle_count(py)?, "triangle");
        Ok(format!("Levels(model {}, level {level} of {last}, {triangles})", self.kind.name()))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("levels_html", (slf,))
    }

    /// Pickles the meshes and the options. Unpickling rebuilds the levels with the same result. The
    /// levels themselves would take more space.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, this) = (slf.py(), slf.get());
        let scene = Scene { data: Arc::clone(&this.scene) };
        let state = (scene, this.arguments.clone_ref(py), this.level(py));
        Ok((slf.get_type().getattr("_restore")?, state.into_pyobject(py)?))
    }

    #[classmethod]
    fn _restore(
        _: &Bound<'_, PyType>,
        scene: &Bound<'_, Scene>,
        arguments: &Bound<'_, PyDict>,
        level: Count,
    ) -> PyResult<Self> {
        let py = arguments.py();
        let levels = Self::build(Arc::clone(&scene.get().data), &Arguments::of(py, Some(arguments))?)?;
        py.detach(|| levels.state().cursor.set_level(level.0)).map_err(Failure::from)?;
        Ok(levels)
    }
}

/// Takes the options of levels from the arguments of `Scene.levels`. All remaining arguments belong
/// to the method.
fn options_of(arguments: &Arguments<'_>) -> PyResult<levels::Options> {
    let mut options = levels::Options::default();
    if let Some(price) = arguments.extract::<String>("price")? {
        options = options.with_price(price.parse().map_err(Failure::from)?);
    }
    if let Some(base) = arguments.extract::<f64>("base")? {
        let ratio = Ratio::new(base).ok_or_else(|| Failure::option("base", base, "a number from 0 to 1"))?;
        options = options.with_base(ratio);
    }
    options = options.with_verify(arguments.extract("verify")?.unwrap_or(true));
    let name: Option<String> = arguments.extract("method")?;
    let stripify = method::options(name.as_deref().unwrap_or("best"), false, Some(&arguments.rest()?))?;
    Ok(options.with_stripify(stripify))
}
