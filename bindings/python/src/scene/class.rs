//! The class of scenes; its methods are in the module above.

use std::sync::Arc;

use pyo3::prelude::*;

use super::data::SceneData;

/// A model of any format: parts with attributes and materials, and for glTF the scene around them, which is kept. Made by `load`, `Scene.from_bytes`,
/// `Scene.from_arrays` and `Scene.from_parts`. It never changes, and depends on no file.
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
    /// Takes over what a scene holds.
    pub(crate) fn new(data: SceneData) -> Self {
        Self { data: Arc::new(data) }
    }
}
