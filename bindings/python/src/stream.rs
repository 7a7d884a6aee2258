//! Progressive GLB: the functions `pack`, `unpack` and `inspect`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};
use serde::Serialize;
use tristrip::Layout;
use tristrip::stream::StreamOptions;
use tristrip_io::gltf::ProgressiveGlb;
use tristrip_io::{Drawing, Error as FileError, Format};
use tristrip_pipeline::{
    Target, encode, inspect as inspect_stream, join, levels::Level, pack as pack_scene,
    unpack as unpack_stream, unpack::StreamGoal,
};

use crate::arguments::{Arguments, Keywords};
use crate::attributes;
use crate::errors::Failure;
use crate::input::{Input, Source, format_of};
use crate::numbers::Count;
use crate::reports::report;
use crate::scene::class::Scene;
use crate::scene::data::SceneData;
use crate::scene::output::Destination;
use crate::work::{Watcher, Watching};

/// Supported bits per coordinate.
const POSITION_BITS: std::ops::RangeInclusive<u32> = 4..=16;
const USUAL_POSITION_BITS: u32 = 14;

/// Takes the options of `pack` from keyword arguments named like the command's flags.
pub(crate) fn pack_options(arguments: &Arguments<'_>) -> PyResult<pack_scene::Options> {
    let (eye, bits): (Option<[f32; 3]>, Option<u32>) =
        (arguments.extract("eye")?, arguments.extract("position_bits")?);
    let verify = arguments.extract("verify")?.unwrap_or(true);
    if eye.iter().flatten().any(|x| !x.is_finite()) {
        let found = format!("{:?}", eye.unwrap_or_default());
        return Err(Failure::option("eye", found, "three finite numbers").into());
    }
    let bits = bits.unwrap_or(USUAL_POSITION_BITS);
    if !POSITION_BITS.contains(&bits) {
        return Err(Failure::option("position_bits", bits, "4 to 16").into());
    }
    let stream = StreamOptions::default().with_position_bits(bits);
    Ok(pack_scene::Options::default().with_stream(stream).with_eye(eye).with_verify(verify))
}

/// The report of `pack`, with the keys of the JSON report of `tristrip pack`.
#[derive(Debug, Serialize)]
struct PackedFile {
    #[serde(flatten)]
    packed: pack_scene::Outcome,
    output: Option<String>,
}

/// Packs a scene, and writes it if there is an output path.
fn pack_model(
    scene: &SceneData,
    options: &pack_scene::Options,
    output: Option<&Path>,
    watcher: &Watcher,
) -> Result<PackedFile, Failure> {
    let model = scene.model_for(&Target::new(output, Format::Glb));
    let packed = pack_scene::run(&model, options, watcher)?;
    if let Some(path) = output {
        tristrip_io::replace_file(path, &packed.bytes)?;
    }
    Ok(PackedFile { packed, output: output.map(|path| path.display().to_string()) })
}

/// Packs a scene and returns a `tristrip.Packed`.
pub(crate) fn pack_object<'py>(
    py: Python<'py>,
    load: impl FnOnce() -> Result<Arc<SceneData>, Failure> + Send,
    options: pack_scene::Options,
    output: Option<&Path>,
    watching: Watching,
) -> PyResult<Bound<'py, PyAny>> {
    if let Some(path) = output
        && Format::from_path(path).is_some_and(|format| format != Format::Glb)
    {
        let found = path.display();
        return Err(Failure::Parameter(format!("output: found {found}, expected the extension .glb")).into());
    }
    let ended = watching.run(py, |watcher| pack_model(&*load()?, &options, output, watcher));
    let packed = ended?.result()?;
    let bytes = PyBytes::new(py, &packed.packed.bytes);
    result_class(py, "Packed")?.call1((report(py, &packed)?, bytes))
}

/// Returns a result class of `tristrip._streams`.
fn result_class<'py>(py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("tristrip._streams")?.getattr(name)
}

/// Pack a model as a progressive GLB: it renders from the first bytes and refines as the rest
/// arrives.
///
/// The file is a valid GLB, in which any viewer shows the base meshes. The chunks that follow
/// contain vertex splits, which refine the base meshes to the full meshes. Positions and attributes
/// are quantized; triangles keep their winding. The rest of the scene is kept: nodes, materials,
/// textures, skins and animations.
///
/// Args:
///     input: a file, the bytes of a file, or a scene.
///     output: the file to write, with the extension .glb. An existing file is replaced.
///     format: the input format by extension ("ply", "glb", …). By default the file name or the
///         content determines it.
///     eye: a viewpoint (x, y, z) in the scene. Parts that look largest from there are refined
///         first. The default is uniform refinement.
///     position_bits: the bits per coordinate, 4 to 16. The longest side of a mesh has
///         2**position_bits − 1 steps. The default is 14.
///     verify: whether to read the bytes back and verify that they have exactly the triangles of
///         the model.
///     progress: see `stripify`.
///
/// Returns:
///     The report and the bytes of the file.
///
/// Raises:
///     FileError: the input cannot be read, or the output cannot be written.
///     FormatError, LimitError: the input is invalid or exceeds the limits.
///     ParameterError: an option has an invalid value.
///     NotProvenError: verification failed, which is a bug in this package.
///
/// References:
///     Hoppe: Progressive Meshes, 1996; Pajarola, Rossignac: Compressed Progressive Meshes, 2000.
///         The compression was developed for this project.
///
/// >>> import tristrip
/// >>> square = b"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"
/// >>> packed = tristrip.pack(square, format="obj")
/// >>> packed.report["triangles"], packed.report["proven"], packed.bytes[:4]
/// (4, True, b'glTF')
#[pyfunction]
#[pyo3(
    signature = (input, output = None, **given),
    text_signature = "(input, output=None, *, format=None, eye=None, position_bits=None, verify=True, progress=None)"
)]
pub(crate) fn pack<'py>(
    py: Python<'py>,
    input: &Bound<'py, PyAny>,
    output: Option<PathBuf>,
    given: Option<Keywords<'_, 'py>>,
) -> PyResult<Bound<'py, PyAny>> {
    let arguments = Arguments::of(py, given)?;
    let format: Option<String> = arguments.extract("format")?;
    let (options, watching) = (pack_options(&arguments)?, arguments.watching()?);
    arguments.finish("pack")?;
    let (input, format) = (Input::of(input)?, format_of(format.as_deref())?);
    let source = input.source();
    pack_object(py, || source.scene(format), options, output.as_deref(), watching)
}

/// The report of `unpack`, with the keys of the JSON report of `tristrip unpack`.
#[derive(Debug, Serialize)]
struct UnpackedLevel {
    proven: Option<bool>,
    #[serde(flatten)]
    unpacked: unpack_stream::Outcome,
    output: Option<String>,
}

/// Decodes a level, and writes it if there is an output path.
fn unpack_source(
    source: Source<'_>,
    goal: StreamGoal,
    destination: Option<&Destination<'_>>,
    verify: bool,
    watcher: &Watcher,
) -> Result<UnpackedLevel, Failure> {
    let base_dir = source.path().and_then(Path::parent).map(Path::to_path_buf);
    let options = unpack_stream::Options::default().with_goal(goal).with_base_dir(base_dir);
    let mut unpacked = unpack_stream::run(&opened(source.bytes()?)?, &options, watcher)?;
    tristrip_io::embed_images(&mut unpacked.model, source.path())?;
    let Some(destination) = destination else {
        return Ok(UnpackedLevel { proven: None, unpacked, output: None });
    };
    let options = encode::Options::new(destination.target.format).with_layout(Layout::List);
    let drawings = vec![Drawing::Faces; unpacked.model.parts.len()];
    let encoded = encode::run(&unpacked.model, &drawings, &options.with_verify(verify), watcher);
    let encoded = encoded.map_err(|error| destination.unproven(error.into()))?;
    let written = destination.write(&encoded)?;
    unpacked.notes.extend(encoded.all_notes());
    unpacked.notes.extend(written.warnings);
    let output = destination.target.path.map(|path| path.display().to_string());
    Ok(UnpackedLevel { proven: verify.then_some(true), unpacked, output })
}

/// Opens a progressive GLB, which may be truncated.
fn opened(bytes: Vec<u8>) -> Result<ProgressiveGlb, Failure> {
    let found = if bytes.starts_with(b"glTF") { "a GLB without a stream" } else { "another file" };
    let none = || FileError::Format {
        at: "file".into(),
        found: found.into(),
        expected: "a progressive GLB; `pack` writes a plain GLB if a stream would not be smaller".into(),
    };
    Ok(ProgressiveGlb::open(bytes)?.ok_or_else(none)?)
}

/// Read a level of detail from a progressive GLB.
///
/// For a truncated or damaged file, the result contains everything before the error.
/// `report["ended_early"]` is then True, and a note has the reason.
///
/// Args:
///     input: a file, or the bytes of a file.
///     output: the file to write the level to. GLB and .gltf files keep the scene.
///     level: the number of collapses to undo, or a percentage such as "40%".
///     triangles: alternatively, the finest level with at most this many triangles in the refined
///         meshes.
///     bytes: alternatively, the level contained in this many bytes of the file. The default is the
///         full meshes.
///     to: the output format: "glb", "gltf", "ply" or "obj". By default the extension determines
///         it.
///     verify: whether to read the written file back and verify it.
///     progress: see `stripify`.
///
/// Returns:
///     The report, the arrays of the level with all parts in one mesh, and the level as a scene.
///
/// Raises:
///     FileError: a file cannot be read or written.
///     FormatError: the input is not a progressive GLB, or ends before its base meshes.
///     LimitError: the stream exceeds the decoder limits for its size.
///     ParameterError: the level does not exist, or more than one target is passed.
///
/// >>> import numpy, tristrip
/// >>> x, y = numpy.meshgrid(numpy.arange(30), numpy.arange(30))
/// >>> lines = [f"v {a} {b} {a * b % 3}" for a, b in zip(x.ravel(), y.ravel())]
/// >>> lines += [f"f {i + 1} {i + 2} {i + 32} {i + 31}" for i in range(869) if i % 30 != 29]
/// >>> packed = tristrip.pack("\n".join(lines).encode(), format="obj")
/// >>> half = tristrip.unpack(packed.bytes, triangles=800)
/// >>> 780 <= len(half.faces) <= 800, half.report["triangles_full"], half.report["ended_early"]
/// (True, 1682, False)
#[pyfunction]
#[pyo3(signature = (input, output = None, *, level = None, triangles = None, bytes = None, to = None, verify = true, progress = None))]
#[allow(clippy::too_many_arguments, reason = "keyword arguments of Python")]
pub(crate) fn unpack<'py>(
    py: Python<'py>,
    input: &Bound<'py, PyAny>,
    output: Option<PathBuf>,
    level: Option<&Bound<'py, PyAny>>,
    triangles: Option<Count>,
    bytes: Option<Count>,
    to: Option<&str>,
    verify: bool,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let goal = goal(level, triangles, bytes)?;
    let watching = Watching::new(py, progress, None, "raise")?;
    let input = Input::file(input)?;
    let file = |path| Destination::file(path, to, None);
    let destination = output.as_deref().map(file).transpose()?;
    let source = input.source();
    let ended = watching.run(py, |watcher| {
        let mut report = unpack_source(source, goal, destination.as_ref(), verify, watcher)?;
        let model = std::mem::take(&mut report.unpacked.model);
        Ok((join(model.clone())?.mesh, model, report))
    });
    let (mesh, model, unpacked) = ended?.result()?;
    let vertices = attributes::positions_of(py, &mesh)?;
    let faces = attributes::triangles_of(py, &mesh)?;
    let attributes = attributes::all(py, &mesh)?;
    let scene = Scene::new(SceneData::of_model(model));
    result_class(py, "Unpacked")?.call1((report(py, &unpacked)?, vertices, faces, attributes, scene))
}

/// Reads the target level.
fn goal(
    level: Option<&Bound<'_, PyAny>>,
    triangles: Option<Count>,
    bytes: Option<Count>,
) -> Result<StreamGoal, Failure> {
    match (level, triangles, bytes) {
        (None, None, None) => Ok(StreamGoal::Level(Level::Percent(100.0))),
        (Some(level), None, None) => Ok(StreamGoal::Level(level_of(level)?)),
        (None, Some(Count(triangles)), None) => Ok(StreamGoal::Triangles(triangles)),
        (None, None, Some(Count(bytes))) => Ok(StreamGoal::Bytes(bytes)),
        _ => Err(Failure::Parameter("level, triangles, bytes: found several, expected at most one".into())),
    }
}

/// Reads a level: a number of collapses, or a string with a percentage.
fn level_of(given: &Bound<'_, PyAny>) -> Result<Level, Failure> {
    let expected = "a number of collapses, or a percentage such as \"40%\"";
    let wrong =
        || Failure::option("level", given.repr().map_or_else(|_| "?".into(), |x| x.to_string()), expected);
    if given.is_instance_of::<PyString>() {
        return given.extract::<String>()?.parse().map_err(|_| wrong());
    }
    given.extract::<usize>().map(Level::Number).map_err(|_| wrong())
}

/// Return the contents of a progressive GLB and how its bits are distributed.
///
/// A truncated or damaged file is reported up to its last complete chunk, with a note.
///
/// Args:
///     input: a file, or the bytes of a file.
///
/// Returns:
///     A dictionary: "meshes", "vertices", "triangles" and "levels" of the full meshes,
///     "position_bits", "base_bytes" before the first chunk, "chunk_bytes", "bits_per_vertex",
///     "components" (a list: "name", "bits", "per_vertex"), "chunks" (a list: "mesh", "end" as a
///     file offset, "level", "triangles", "surface_error"), "notes".
///
/// Raises:
///     FileError: the file cannot be read.
///     FormatError: the input is not a progressive GLB, or ends before its base meshes.
///
/// >>> import numpy, tristrip
/// >>> x, y = numpy.meshgrid(numpy.arange(30), numpy.arange(30))
/// >>> lines = [f"v {a} {b} {a * b % 3}" for a, b in zip(x.ravel(), y.ravel())]
/// >>> lines += [f"f {i + 1} {i + 2} {i + 32} {i + 31}" for i in range(869) if i % 30 != 29]
/// >>> found = tristrip.inspect(tristrip.pack("\n".join(lines).encode(), format="obj").bytes)
/// >>> found["vertices"], found["chunks"][-1]["triangles"]
/// (900, 1682)
#[pyfunction]
#[pyo3(signature = (input))]
pub(crate) fn inspect<'py>(py: Python<'py>, input: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let input = Input::file(input)?;
    let source = input.source();
    let ended =
        Watching::default().run(py, |watcher| Ok(inspect_stream::run(&opened(source.bytes()?)?, watcher)?));
    report(py, &ended?.result()?)
}
