//! Scenes: whole files and the operations of the command on them.
//!
//! ```text
//! file, bytes, arrays ─▶ data ─▶ class Scene ─┬▶ parts: arrays, materials
//!                                             ├▶ strip, simplify, chain: results ─▶ output ─▶ file, bytes
//!                                             ├▶ checks: bound, analyze, compare, verify
//!                                             └▶ picture
//! ```
//! Files are written by the same rules as in the command; see `tristrip_pipeline::Target`.

pub(crate) mod chain;
mod checks;
pub(crate) mod class;
pub(crate) mod data;
pub(crate) mod functions;
mod materials;
pub(crate) mod output;
pub(crate) mod part;
mod parts;
mod picture;
mod placements;
mod saving;
pub(crate) mod simplify;
pub(crate) mod strip;

use std::path::PathBuf;
use std::sync::Arc;

use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList, PyRange, PyType};
use tristrip_pipeline::text::counted;

use crate::arguments::{Arguments, Keywords};
use crate::arrays::type_name;
use crate::errors::{Failure, with_best};
use crate::input::bytes_of;
use crate::levels::Levels;
use crate::method;
use crate::reports::Report;
use crate::stream::{pack_object, pack_options};
use crate::work::Watching;
use chain::Chain;
use class::Scene;
use data::SceneData;
use functions::loaded;
use output::format_of;
use part::Part;
use simplify::SimplifiedScene;
use strip::StrippedScene;

#[pymethods]
impl Scene {
    /// Read a scene from the bytes of a file.
    ///
    /// Args:
    ///     data: bytes, or another object with the buffer protocol. A glTF must contain its
    ///         buffers.
    ///     format: see `load`. By default the content determines the format.
    ///
    /// Raises:
    ///     FormatError: the bytes do not conform to the format, or a glTF refers to buffers in
    ///         other files.
    ///     LimitError: the bytes declare a size above the limits.
    ///     MeshError: positions are not finite.
    ///     ParameterError: the format is unknown, or the data require an unsupported extension.
    ///
    /// >>> import tristrip
    /// >>> tristrip.Scene.from_bytes(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
    /// Scene(OFF, 1 part, 1 face, 3 vertices)
    #[classmethod]
    #[pyo3(signature = (data, format = None))]
    fn from_bytes(kind: &Bound<'_, PyType>, data: &Bound<'_, PyAny>, format: Option<&str>) -> PyResult<Self> {
        let format = format.map(format_of).transpose()?;
        let py = kind.py();
        let wrong = || Failure::Type(format!("data: found {}, expected bytes", type_name(data)));
        let bytes = bytes_of(data)?.ok_or_else(wrong)?.as_bytes().to_vec();
        let read = Watching::default().run(py, |_| SceneData::of_bytes(bytes, format));
        Ok(Self::new(read?.result()?))
    }

    /// Build a scene of one part. The arguments are those of `Part`.
    ///
    /// >>> import tristrip
    /// >>> scene = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]], name="square")
    /// >>> scene.parts
    /// [Part('square', 4 vertices, 1 face)]
    #[classmethod]
    #[pyo3(
        signature = (vertices, faces, **given),
        text_signature = "(vertices, faces, *, normals=None, uv=None, colors=None, attributes=None, name=None, material=None, uv_origin='bottom', normalized=None)"
    )]
    fn from_arrays(
        kind: &Bound<'_, PyType>,
        vertices: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        given: Option<Keywords<'_, '_>>,
    ) -> PyResult<Self> {
        let part = kind.py().get_type::<Part>().call((vertices, faces), given)?;
        let part = part.cast::<Part>()?.get().clone();
        Ok(Self::new(parts::scene_of(&[part])?))
    }

    /// Build a scene of parts. The parts can come from other scenes.
    ///
    /// Raises:
    ///     ParameterError: two different materials have the same name.
    ///
    /// >>> import tristrip
    /// >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    /// >>> halves = [tristrip.Part(square, [face], material={"base_color": (red, 0, 0)}) for face, red in [([0, 1, 2], 1), ([0, 2, 3], 0.5)]]
    /// >>> [part.material for part in tristrip.Scene.from_parts(halves).parts]
    /// ['material_0', 'material_1']
    #[classmethod]
    fn from_parts(_: &Bound<'_, PyType>, parts: Vec<Bound<'_, Part>>) -> PyResult<Self> {
        let parts: Vec<Part> = parts.iter().map(|part| part.get().clone()).collect();
        Ok(Self::new(parts::scene_of(&parts)?))
    }

    /// The parts in file order. A part of a glTF file is one primitive. The transforms of its nodes
    /// are not applied.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        PyList::new(py, parts::parts_of(&self.data)?)
    }

    /// How the nodes of a glTF scene place the parts.
    ///
    /// A list of pairs: a `range` of part indices, and the transform from part to scene space,
    /// float64 of shape (4, 4), for column vectors. Animations are not applied. Scenes of other
    /// formats have one placement with all parts.
    ///
    /// >>> import tristrip
    /// >>> scene = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    /// >>> [(list(parts), transform.shape) for parts, transform in scene.placements]
    /// [([0], (4, 4))]
    #[getter]
    #[allow(clippy::type_complexity, reason = "a pair per placement")]
    fn placements<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(Bound<'py, PyRange>, Bound<'py, PyArray2<f64>>)>> {
        placements::placements(py, &self.data)
    }

    /// Notes on data that was dropped or changed on reading.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.data.model().notes.clone()
    }

    /// The format of the file, such as "glb"; None for a scene built from arrays.
    #[getter]
    fn format(&self) -> Option<&'static str> {
        self.data.format().map(tristrip_io::Format::extension)
    }

    /// Compute triangle strips of all parts.
    ///
    /// Args:
    ///     method, effort, cost, weld, **options: see `stripify`.
    ///     verify: whether to verify the strips.
    ///     budget, progress, on_interrupt: see `stripify`.
    ///
    /// Returns:
    ///     The strips of each part with metrics, ready to save.
    ///
    /// Raises:
    ///     ParameterError: an option is unknown, has an invalid value, or does not belong to the
    ///         method.
    ///     Interrupted: Ctrl-C was pressed during a search; `best` has the best strips so far.
    #[pyo3(
        signature = (**given),
        text_signature = "($self, *, method='best', effort=None, cost=None, weld=False, verify=True, budget=None, progress=None, on_interrupt='raise', **options)"
    )]
    fn strip<'py>(
        &self,
        py: Python<'py>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Bound<'py, StrippedScene>> {
        let arguments = Arguments::of(py, given)?;
        let watching = arguments.interruptible_search()?;
        let verify = arguments.extract("verify")?.unwrap_or(true);
        let stripify = method::taken(&arguments, "best")?;
        let options =
            tristrip_pipeline::strip::Options::default().with_stripify(stripify).with_verify(verify);
        let found = strip::strip(py, &self.data, options, watching)?;
        found.object(py, |stripped| StrippedScene::new(Arc::clone(&self.data), stripped))
    }

    /// Simplify all parts by half-edge collapses.
    ///
    /// Parts that share borders are simplified as one surface.
    ///
    /// Args:
    ///     ratio: the ratio of triangles to keep, from 0 to 1, over all parts together.
    ///     triangles: the number of triangles to keep, instead of a ratio.
    ///     error: the maximum error in mesh units, or in percent of the bounding-box diagonal, such
    ///         as "0.1%". The default is "1%"; "100%" disables the limit.
    ///     weight, price, permissive, lock_borders, weld_distance: see `simplify`.
    ///     normals: "auto" (rebuild normals of flat-shaded parts, keep other normals where they
    ///         still fit), "keep" or "rebuild".
    ///     fit: whether to move the remaining vertices closer to the original surface, as `--fit`
    ///         does. Three kinds of vertices keep their positions: vertices on open borders,
    ///         vertices shared with parts placed elsewhere in the scene, and vertices that a GLB
    ///         cannot change. A note reports the last kind.
    ///     compact: whether to quantize joint weights to 8 bits and animation rotations to 16 bits
    ///         in a GLB.
    ///     measure: whether to measure the distance from the original. This doubles the time.
    ///     verify: whether to verify the collapses.
    ///     progress, on_interrupt: see `tristrip.simplify`.
    ///
    /// Returns:
    ///     The result and its report, ready to save.
    ///
    /// Raises:
    ///     ParameterError: an option has an invalid value.
    ///
    /// >>> import tristrip
    /// >>> fan = tristrip.Scene.from_bytes(b"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
    /// >>> fan.simplify(triangles=2).scene
    /// Scene(1 part, 2 faces, 4 vertices)
    #[pyo3(
        signature = (**given),
        text_signature = "($self, *, ratio=None, triangles=None, error=None, weight=None, price='distance', permissive=False, lock_borders=False, weld_distance=None, normals='auto', fit=False, compact=False, measure=True, verify=True, progress=None, on_interrupt='raise')"
    )]
    fn simplify<'py>(
        &self,
        py: Python<'py>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Bound<'py, SimplifiedScene>> {
        simplify::simplify(&self.data, &Arguments::of(py, given)?)
    }

    /// Build a chain of levels of detail over one vertex buffer, as the command `chain` does.
    ///
    /// Args:
    ///     ratios: the ratios of triangles per level, finest first: [1, 0.5, 0.25] or
    ///         "100%,50%,25%". At most 16.
    ///     error, weight, price, permissive, lock_borders, weld_distance: see `Scene.simplify`.
    ///     layout: the layout in files: "restart", "degenerate", "separate" or "list". The default
    ///         is "degenerate" for glTF and "restart" for PLY; a part is then drawn as a list if
    ///         that takes fewer indices.
    ///     method: the strip method; see `stripify`. The default is "best", or "cache" for the
    ///         layout "list".
    ///     effort, cost, weld, **options: see `stripify`.
    ///     verify: whether to verify the collapses.
    ///     budget: the time limit of each strip search when files are written, in seconds.
    ///     progress: see `stripify`.
    ///
    /// Returns:
    ///     The levels, ready to save.
    ///
    /// Raises:
    ///     ParameterError: an option is unknown or has an invalid value.
    ///
    /// >>> import tristrip
    /// >>> fan = tristrip.Scene.from_bytes(b"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
    /// >>> fan.chain([1, 0.5])
    /// Chain(2 levels of 4 / 2 triangles)
    #[pyo3(
        signature = (ratios = None, **given),
        text_signature = "($self, ratios='100%,50%,25%,10%', *, error=None, weight=None, price='distance', permissive=False, lock_borders=False, weld_distance=None, layout=None, method=None, effort=None, cost=None, weld=False, verify=True, budget=None, progress=None, **options)"
    )]
    fn chain<'py>(
        &self,
        py: Python<'py>,
        ratios: Option<&Bound<'py, PyAny>>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Chain> {
        chain::chain(&self.data, ratios, &Arguments::of(py, given)?)
    }

    /// Build all levels of detail of the scene. All parts change levels together.
    ///
    /// Args:
    ///     model, base, price, verify: see `Levels`.
    ///     method, effort, cost, **options: the method for the strips of the full meshes; see
    ///         `stripify`.
    ///     progress: see `stripify`.
    ///
    /// Returns:
    ///     The levels, at the full meshes.
    ///
    /// Raises:
    ///     ParameterError: an option is unknown or has an invalid value.
    ///
    /// >>> import tristrip
    /// >>> fan = tristrip.Scene.from_bytes(b"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n")
    /// >>> levels = fan.levels(model="sets")
    /// >>> levels.set_triangles(2), levels.triangles(part=0).shape
    /// (1, (2, 3))
    #[pyo3(
        signature = (**given),
        text_signature = "($self, *, model='blocks', base=None, price='distance', method='best', effort=None, cost=None, verify=True, progress=None, **options)"
    )]
    fn levels<'py>(&self, py: Python<'py>, given: Option<Keywords<'_, 'py>>) -> PyResult<Levels> {
        Levels::build(Arc::clone(&self.data), &Arguments::of(py, given)?)
    }

    /// Pack the scene as a progressive GLB. It renders from the first bytes and refines as the rest
    /// arrives. Arguments and result are those of `pack`.
    ///
    /// >>> import tristrip
    /// >>> square = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    /// >>> square.pack().report["triangles"]
    /// 2
    #[pyo3(
        signature = (output = None, **given),
        text_signature = "($self, output=None, *, eye=None, position_bits=None, verify=True, progress=None)"
    )]
    fn pack<'py>(
        &self,
        py: Python<'py>,
        output: Option<PathBuf>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let arguments = Arguments::of(py, given)?;
        let (options, watching) = (pack_options(&arguments)?, arguments.watching()?);
        arguments.finish("Scene.pack")?;
        pack_object(py, || Ok(Arc::clone(&self.data)), options, output.as_deref(), watching)
    }

    /// Compute lower bounds on strips, vertices and indices. They hold for every method.
    ///
    /// Args:
    ///     weld: whether to merge vertices that have bitwise equal positions and attributes.
    ///
    /// Returns:
    ///     A dictionary with the keys of the command's JSON: "bound" ("strips", "vertices_sent",
    ///     "gl_cost", "indices_restart", "indices_degenerate"), "mesh", "parts", "sequential" (per
    ///     part: whether one strip without swaps draws the part), "components" (with "proof", the
    ///     reason for the bound), "notes".
    ///
    /// >>> import tristrip
    /// >>> square = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    /// >>> square.bound()["bound"]["indices_restart"]
    /// 4
    #[pyo3(signature = (weld = false))]
    fn bound<'py>(&self, py: Python<'py>, weld: bool) -> PyResult<Bound<'py, PyDict>> {
        checks::bound(py, &self.data, weld)
    }

    /// Report the stored indices and their vertex-cache statistics. No strips are built.
    ///
    /// Each part starts with an empty cache.
    ///
    /// Args:
    ///     vertex_caches: the caches to simulate, such as "fifo:16,lru:8..32" or a list of such
    ///         strings. By default FIFO and LRU with 8, 16, 24, 32 and 64 entries.
    ///     flush: whether to empty the cache between strips.
    ///
    /// Returns:
    ///     A dictionary with the keys of the command's JSON: "drawn", "triangles", "indices",
    ///     "indices_per_triangle", "restarts", "degenerate", "strips", "lengths" (a histogram),
    ///     "vertex_caches" ("misses", "acmr" per triangle and "atvr" per used vertex), "by_part",
    ///     "notes", …
    ///
    /// Raises:
    ///     ParameterError: a cache is unknown.
    ///
    /// >>> import tristrip
    /// >>> square = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    /// >>> square.analyze("fifo:16")["vertex_caches"]
    /// [{'vertex_cache': 'fifo:16', 'misses': 4, 'acmr': 2.0, 'atvr': 1.0}]
    #[pyo3(signature = (vertex_caches = None, flush = false))]
    fn analyze<'py>(
        &self,
        py: Python<'py>,
        vertex_caches: Option<&Bound<'py, PyAny>>,
        flush: bool,
    ) -> PyResult<Bound<'py, PyDict>> {
        let options = checks::analyze_options(vertex_caches, flush)?;
        checks::statistics(py, &self.data, &options)
    }

    /// Compare all methods. Every result is verified.
    ///
    /// Args:
    ///     all: whether to compare all variants of the published methods.
    ///     effort: 0 to 9 for methods that search, or None for their defaults. "best" also runs at
    ///         its default effort.
    ///     cost: the cost that "best" minimizes; see `stripify`.
    ///     seed: the seed of methods that break ties at random.
    ///     weld: whether to merge vertices that have bitwise equal positions and attributes.
    ///     budget: the time limit of each search, in seconds.
    ///     progress: see `stripify`.
    ///     on_interrupt: the effect of Ctrl-C: "raise" raises `Interrupted` with the rows so far as
    ///         `best`; "return" returns them.
    ///
    /// Returns:
    ///     A list of dictionaries, one per method, suitable for `pandas.DataFrame`. The keys are
    ///     those of the command's JSON: "method" and its options, "proven", "seconds" ("stripify",
    ///     "verify"), "error", and the metrics of `Strips.metrics`.
    ///
    /// Raises:
    ///     ParameterError: an option has an invalid value.
    ///     Interrupted: Ctrl-C was pressed; `best` has the rows so far.
    ///
    /// >>> import tristrip
    /// >>> square = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    /// >>> [row["strips"] for row in square.compare() if row["method"] in ("best", "sgi")]
    /// [1, 1]
    #[pyo3(
        signature = (**given),
        text_signature = "($self, *, all=False, effort=None, cost='restart', seed=0, weld=False, budget=None, progress=None, on_interrupt='raise')"
    )]
    fn compare<'py>(
        &self,
        py: Python<'py>,
        given: Option<Keywords<'_, 'py>>,
    ) -> PyResult<Bound<'py, PyList>> {
        let ended = checks::compare(&self.data, &Arguments::of(py, given)?)?;
        match ended.error {
            None => Ok(ended.value),
            Some(error) => Err(with_best(py, error, ended.value.into_any().unbind())),
        }
    }

    /// Verify that another scene draws every face of this one exactly once, with its original
    /// winding.
    ///
    /// Vertices match if their positions are bitwise equal. Attributes are not compared.
    ///
    /// Args:
    ///     result: the other scene, or the path of a file.
    ///
    /// Returns:
    ///     A dictionary with the keys of the command's JSON: "proven", "faces" (of this scene),
    ///     "triangles" (of the other scene), "notes".
    ///
    /// Raises:
    ///     NotProvenError: the other scene draws different faces. Its attribute `difference` is a
    ///         dictionary with "kind", "missing", "extra", "flipped", "face" and "first"
    ///         (positions).
    ///
    /// >>> import tristrip
    /// >>> square = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    /// >>> square.verify(tristrip.Scene.from_bytes(square.strip().to_bytes()))["faces"]
    /// 1
    fn verify<'py>(&self, py: Python<'py>, result: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
        let result = loaded(result)?;
        checks::prove(py, &self.data, &result)
    }

    /// Write the scene without building strips, as the command `convert` does.
    ///
    /// Polygons remain polygons if the format supports them, and strips remain strips.
    ///
    /// Args:
    ///     path: the output file. An existing file is replaced after the new file is complete. A
    ///         .gltf file comes with a .bin file for its buffer, an OBJ file with its materials and
    ///         images.
    ///     format: "glb", "gltf", "ply" or "obj". By default the extension determines it.
    ///     layout: "restart", "degenerate", "separate" or "list". With a layout, all faces become
    ///         strips in their stored order.
    ///     verify: whether to read the bytes back and verify them before the file is replaced.
    ///
    /// Returns:
    ///     A dictionary with keys of the command's JSON: "output", "layout", "faces", "triangles",
    ///     "strips", "parts", "notes", "proven", "bytes", "beside" (other files written).
    ///
    /// Raises:
    ///     FileError: the file cannot be written.
    ///     ParameterError: the format or layout is unknown, or the format does not support the
    ///         layout.
    ///     NotProvenError: the bytes do not draw the scene; nothing was written.
    #[pyo3(
        signature = (path, **given),
        text_signature = "($self, path, *, format=None, layout=None, verify=True)"
    )]
    fn save<'py>(&self, py: Python<'py>, path: PathBuf, given: Option<Keywords<'_, 'py>>) -> Report<'py> {
        let arguments = Arguments::of(py, given)?;
        let [format, layout] = ["format", "layout"].map(|name| arguments.extract::<String>(name));
        let verify = arguments.extract("verify")?.unwrap_or(true);
        arguments.finish("save")?;
        saving::save(py, &self.data, &path, format?.as_deref(), layout?.as_deref(), verify)
    }

    /// Return the bytes that `save` would write to a single file.
    ///
    /// Args:
    ///     format: "glb", "ply" or "obj".
    ///     layout, verify: see `save`.
    ///
    /// >>> import tristrip
    /// >>> scene = tristrip.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    /// >>> print(scene.to_bytes("obj").decode())
    /// v 0 0 0
    /// v 1 0 0
    /// v 0 1 0
    /// f 1 2 3
    /// <BLANKLINE>
    #[pyo3(signature = (format = "glb", *, layout = None, verify = true))]
    fn to_bytes<'py>(
        &self,
        py: Python<'py>,
        format: &str,
        layout: Option<&str>,
        verify: bool,
    ) -> PyResult<Bound<'py, PyBytes>> {
        saving::to_bytes(py, &self.data, format, layout, verify)
    }

    /// Render the scene with node transforms, base colours and textures, without animations.
    ///
    /// Args:
    ///     width, height: the image size, 1 to 8192 pixels.
    ///     mode: "textured", "normals", "uv" or "shaded".
    ///
    /// Returns:
    ///     The bytes of a PNG file, for example for `IPython.display.Image`.
    ///
    /// Raises:
    ///     ParameterError: the size or mode is invalid, or an image of the scene cannot be decoded.
    #[pyo3(signature = (width = 1200, height = 900, *, mode = "textured"))]
    fn picture<'py>(
        &self,
        py: Python<'py>,
        width: i64,
        height: i64,
        mode: &str,
    ) -> PyResult<Bound<'py, PyBytes>> {
        picture::of_scene(py, &self.data, mode, (width, height))
    }

    fn __repr__(&self) -> String {
        let model = self.data.as_read();
        let format = self.data.format().map(|format| format!("{}, ", format.name())).unwrap_or_default();
        let faces = model.parts.iter().map(|part| part.mesh.faces().face_count()).sum();
        let vertices = model.parts.iter().map(|part| part.mesh.vertex_count()).sum();
        let (parts, faces) = (counted(model.parts.len(), "part"), counted(faces, "face"));
        format!("Scene({format}{parts}, {faces}, {})", counted(vertices, "vertex"))
    }

    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("tristrip._notebook")?.call_method1("scene_html", (slf,))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyAny>)> {
        let (py, this) = (slf.py(), slf.get());
        let notes = this.notes();
        let kind = slf.get_type();
        if this.data.as_read().scene.is_none() {
            let state = (this.parts(py)?, notes, this.format()).into_pyobject(py)?;
            return Ok((kind.getattr("_of_parts")?, state.into_any()));
        }
        let (bytes, format) = this.data.self_contained()?;
        let state = (PyBytes::new(py, &bytes), format.extension(), notes).into_pyobject(py)?;
        Ok((kind.getattr("_of_bytes")?, state.into_any()))
    }

    #[classmethod]
    fn _of_parts(
        _: &Bound<'_, PyType>,
        parts: Vec<Bound<'_, Part>>,
        notes: Vec<String>,
        format: Option<&str>,
    ) -> PyResult<Self> {
        let parts: Vec<Part> = parts.iter().map(|part| part.get().clone()).collect();
        let format = format.map(format_of).transpose()?;
        Ok(Self::new(parts::scene_of(&parts)?.restored(notes, format)))
    }

    #[classmethod]
    fn _of_bytes(kind: &Bound<'_, PyType>, bytes: &[u8], format: &str, notes: Vec<String>) -> PyResult<Self> {
        let (bytes, format) = (bytes.to_vec(), format_of(format)?);
        let read = Watching::default().run(kind.py(), |_| SceneData::of_bytes(bytes, Some(format)));
        Ok(Self::new(read?.result()?.restored(notes, Some(format))))
    }
}
