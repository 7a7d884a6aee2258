//! Functions on whole files: read, verify, convert.

use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::checks;
use super::class::Scene;
use super::data::SceneData;
use super::output::format_of;
use super::saving::save;
use crate::arrays::type_name;
use crate::errors::Failure;
use crate::work::Watching;

/// Read a scene from an OBJ, PLY, OFF, STL, glTF or GLB file, with its materials and images.
///
/// Args:
///     path: the file.
///     format: "obj", "ply", "off", "stl", "gltf" or "glb". By default the extension determines it,
///         or the content if the extension is unknown.
///
/// Returns:
///     The scene, which no longer depends on the file. Its `notes` report dropped or changed data.
///
/// Raises:
///     FileError: the file, or a buffer that it refers to, cannot be read.
///     FormatError: the bytes do not conform to the format.
///     LimitError: the file declares a size above the limits.
///     MeshError: positions are not finite.
///     ParameterError: the format is unknown, or the file requires an unsupported extension.
///
/// >>> import tristrip
/// >>> tristrip.load("no/such/file.ply")
/// Traceback (most recent call last):
/// tristrip.FileError: [Errno 2] No such file or directory: 'no/such/file.ply'
#[pyfunction]
#[pyo3(signature = (path, format = None))]
pub(crate) fn load(py: Python<'_>, path: PathBuf, format: Option<&str>) -> PyResult<Scene> {
    let format = format.map(format_of).transpose()?;
    let read = Watching::default().run(py, |_| SceneData::read(&path, format));
    Ok(Scene::new(read?.result()?))
}

/// Verify that a file or scene draws every face of another exactly once, with its original winding.
///
/// Args:
///     source: the scene with the expected faces, or the path of a file.
///     result: the scene to verify, or the path of a file.
///
/// Returns:
///     A dictionary; see `Scene.verify`.
///
/// Raises:
///     NotProvenError: they draw different faces; the attribute `difference` has the details.
///     FileError, FormatError, LimitError: see `load`.
#[pyfunction]
pub(crate) fn verify<'py>(
    py: Python<'py>,
    source: &Bound<'py, PyAny>,
    result: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyDict>> {
    let (source, result) = (loaded(source)?, loaded(result)?);
    checks::prove(py, &source, &result)
}

/// Convert a file to another format or strip layout, without building strips.
///
/// Args:
///     input: the path of the input file.
///     output: the path of the output file; see `Scene.save`.
///     format: the input format; see `load`.
///     to: the output format: "glb", "gltf", "ply" or "obj". By default the extension determines
///         it.
///     layout, verify: see `Scene.save`.
///
/// Returns:
///     A dictionary; see `Scene.save`.
///
/// Raises:
///     FileError, FormatError, LimitError, MeshError, ParameterError: see `load`.
///     NotProvenError: the bytes do not draw the input; nothing was written.
#[pyfunction]
#[pyo3(signature = (input, output, *, format = None, to = None, layout = None, verify = true))]
pub(crate) fn convert<'py>(
    py: Python<'py>,
    input: PathBuf,
    output: PathBuf,
    format: Option<&str>,
    to: Option<&str>,
    layout: Option<&str>,
    verify: bool,
) -> PyResult<Bound<'py, PyDict>> {
    save(py, &load(py, input, format)?.data, &output, to, layout, verify)
}

/// Takes a scene, or reads a file.
pub(crate) fn loaded(given: &Bound<'_, PyAny>) -> PyResult<Arc<SceneData>> {
    if let Ok(scene) = given.cast::<Scene>() {
        return Ok(Arc::clone(&scene.get().data));
    }
    let Ok(path) = given.extract::<PathBuf>() else {
        let found = type_name(given);
        return Err(Failure::Type(format!("found {found}, expected a scene or the path of a file")).into());
    };
    Ok(load(given.py(), path, None)?.data)
}
