//! The class `Scene`. Its methods are in the parent module.

use std::sync::Arc;

use pyo3::prelude::*;

use super::data::SceneData;

/// A model of any format: parts with attributes and materials. For glTF, the rest of the scene is
/// kept.
///
/// Created by `load`, `Scene.from_bytes`, `Scene.from_arrays` and `Scene.from_parts`. A scene is
/// immutable and does not depend on its file.
///
/// >>> import tristrip
/// >>> scene = tristrip.Scene.from_bytes(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
/// >>> scene
/// Scene(OBJ, 1 part, 2 faces, 4 vertices)
/// >>> scene.strip().metrics()["indices_restart"]
/// 4
#[pyclass(frozen, module = "tristrip")]
#[derive(Debug)]
pub(crate) struct Scene {
    pub(crate) data: Arc<SceneData>,
}

impl Scene {
    /// Wraps the data of a scene.
    pub(crate) fn new(data: SceneData) -> Self {
        Self { data: Arc::new(data) }
    }
}
