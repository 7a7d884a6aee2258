//! Inputs of functions that accept a path, the bytes of a file, or a scene.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};
use tristrip_io::{Error as FileError, Format};

use crate::arrays::type_name;
use crate::errors::Failure;
use crate::scene::class::Scene;
use crate::scene::data::SceneData;
use crate::scene::output;

/// A file passed by the user.
pub(crate) enum Input<'py> {
    Path(PathBuf),
    Bytes(Bound<'py, PyBytes>),
    Scene(Arc<SceneData>),
}

impl<'py> Input<'py> {
    /// Reads a path (`str` or `os.PathLike`), an object with a buffer of bytes, or a scene.
    pub(crate) fn of(given: &Bound<'py, PyAny>) -> Result<Self, Failure> {
        if let Ok(scene) = given.cast::<Scene>() {
            return Ok(Self::Scene(Arc::clone(&scene.get().data)));
        }
        Self::file(given).map_err(|failure| match failure {
            Failure::Type(text) => Failure::Type(text + ", or a scene"),
            other => other,
        })
    }

    /// Reads a path or an object with a buffer of bytes.
    pub(crate) fn file(given: &Bound<'py, PyAny>) -> Result<Self, Failure> {
        if let Some(bytes) = bytes_of(given)? {
            return Ok(Self::Bytes(bytes));
        }
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Self::Path(path));
        }
        Err(Failure::Type(format!("input: found {}, expected a path or bytes", type_name(given))))
    }

    /// Returns a borrowed form that does not need the GIL.
    pub(crate) fn source(&self) -> Source<'_> {
        match self {
            Self::Path(path) => Source::Path(path),
            Self::Bytes(bytes) => Source::Bytes(bytes.as_bytes()),
            Self::Scene(scene) => Source::Scene(scene),
        }
    }
}

/// An input that can be used without the GIL.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    Path(&'a Path),
    Bytes(&'a [u8]),
    Scene(&'a Arc<SceneData>),
}

impl<'a> Source<'a> {
    /// Returns the path, if there is one.
    pub(crate) fn path(self) -> Option<&'a Path> {
        match self {
            Self::Path(path) => Some(path),
            Self::Bytes(_) => None,
            Self::Scene(scene) => scene.path(),
        }
    }

    /// Reads all bytes. A scene is encoded to the bytes of a file that can be read back.
    pub(crate) fn bytes(self) -> Result<Vec<u8>, Failure> {
        match self {
            Self::Path(path) => std::fs::read(path)
                .map_err(|source| FileError::Io { path: path.display().to_string(), source }.into()),
            Self::Bytes(bytes) => Ok(bytes.to_vec()),
            Self::Scene(scene) => Ok(scene.self_contained()?.0.to_vec()),
        }
    }

    /// Reads a scene. Without a format, the extension or the content selects it.
    pub(crate) fn scene(self, format: Option<Format>) -> Result<Arc<SceneData>, Failure> {
        match self {
            Self::Path(path) => Ok(Arc::new(SceneData::read(path, format)?)),
            Self::Bytes(bytes) => Ok(Arc::new(SceneData::of_bytes(bytes.to_vec(), format)?)),
            Self::Scene(scene) => Ok(Arc::clone(scene)),
        }
    }
}

/// Returns the bytes of an object with the buffer protocol; copies unless it is `bytes`. Returns
/// `None` for other objects, including `str`.
pub(crate) fn bytes_of<'py>(given: &Bound<'py, PyAny>) -> Result<Option<Bound<'py, PyBytes>>, Failure> {
    if let Ok(bytes) = given.cast::<PyBytes>() {
        return Ok(Some(bytes.clone()));
    }
    if given.is_instance_of::<PyString>() {
        return Ok(None);
    }
    let py = given.py();
    // Raises a TypeError for objects without a buffer.
    let Ok(view) = py.import("builtins")?.getattr("memoryview")?.call1((given,)) else { return Ok(None) };
    let copy = view.call_method0("tobytes")?;
    Ok(Some(copy.cast_into::<PyBytes>().map_err(PyErr::from)?))
}

/// Parses the name of a format, if there is one.
pub(crate) fn format_of(name: Option<&str>) -> Result<Option<Format>, Failure> {
    name.map(output::format_of).transpose()
}
