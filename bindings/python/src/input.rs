//! Inputs of functions that take a file: its path, or its bytes.

use std::path::{Path, PathBuf};

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyString};
use tristrip_io::{Error as FileError, Format, Model};

use crate::errors::Failure;

/// A file as given by a user.
pub(crate) enum Input<'py> {
    Path(PathBuf),
    Bytes(Bound<'py, PyBytes>),
}

impl<'py> Input<'py> {
    /// Reads a path (`str` or `os.PathLike`), or an object with bytes.
    pub(crate) fn of(given: &Bound<'py, PyAny>) -> Result<Self, Failure> {
        if let Some(bytes) = bytes_of(given)? {
            return Ok(Self::Bytes(bytes));
        }
        if let Ok(path) = given.extract::<PathBuf>() {
            return Ok(Self::Path(path));
        }
        let found = given.get_type().name()?;
        Err(Failure::Type(format!("input: found {found}, expected a path or bytes")))
    }

    /// Returns what does not need the interpreter.
    pub(crate) fn source(&self) -> Source<'_> {
        match self {
            Self::Path(path) => Source::Path(path),
            Self::Bytes(bytes) => Source::Bytes(bytes.as_bytes()),
        }
    }
}

/// A file as the code below needs it.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    Path(&'a Path),
    Bytes(&'a [u8]),
}

impl<'a> Source<'a> {
    /// Returns the path, if there is one.
    pub(crate) fn path(self) -> Option<&'a Path> {
        match self {
            Self::Path(path) => Some(path),
            Self::Bytes(_) => None,
        }
    }

    /// Reads all bytes.
    pub(crate) fn bytes(self) -> Result<Vec<u8>, Failure> {
        match self {
            Self::Path(path) => std::fs::read(path).map_err(|source| system(path, source)),
            Self::Bytes(bytes) => Ok(bytes.to_vec()),
        }
    }

    /// Reads a model, in a format or else in that of the extension or of the content.
    pub(crate) fn model(self, format: Option<Format>) -> Result<Model, Failure> {
        match (self, format) {
            (Self::Path(path), None) => Ok(tristrip_io::read_path(path)?),
            (Self::Path(_), Some(format)) => Ok(tristrip_io::read(&self.bytes()?, format)?),
            (Self::Bytes(bytes), format) => {
                Ok(tristrip_io::read(bytes, format.unwrap_or_else(|| Format::from_bytes(bytes)))?)
            }
        }
    }
}

/// Returns the bytes of an object that has some: those of `bytes` itself, or a copy of the others. Text has none.
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

/// Reads the name of a format, which is a file name extension.
pub(crate) fn format_of(name: Option<&str>) -> Result<Option<Format>, Failure> {
    let Some(name) = name else { return Ok(None) };
    let found = Format::ALL.into_iter().find(|format| format.extension() == name);
    let expected = "'obj', 'ply', 'off', 'stl', 'gltf' or 'glb'";
    found.map(Some).ok_or_else(|| Failure::option("format", format!("{name:?}"), expected))
}

fn system(path: &Path, source: std::io::Error) -> Failure {
    FileError::Io { path: path.display().to_string(), source }.into()
}
