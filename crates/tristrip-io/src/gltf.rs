//! glTF 2.0 and GLB.

use std::path::Path;

use tristrip::Layout;

use crate::{Drawing, Error, Model};

/// A glTF document: everything around the parts, kept as it was read.
#[derive(Debug, Clone, Default)]
pub struct Scene {}

/// Reads a glTF or GLB file; `base_dir` is where its external buffers lie.
///
/// # Errors
/// Not written yet.
pub fn read(_bytes: &[u8], _base_dir: Option<&Path>) -> Result<Model, Error> {
    Err(Error::Unsupported("glTF cannot be read yet".into()))
}

/// Writes a GLB file.
///
/// # Errors
/// Not written yet.
pub fn write_glb(_model: &Model, _drawings: &[Drawing], _layout: Layout) -> Result<Vec<u8>, Error> {
    Err(Error::Unsupported("GLB cannot be written yet".into()))
}
