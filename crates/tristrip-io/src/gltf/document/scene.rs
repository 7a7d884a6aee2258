//! The glTF document that the parts of a model were read from.

use std::path::PathBuf;

use crate::gltf::document::json::Value;

use crate::error::Error;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::spec::TRIANGLES;
use crate::gltf::document::{Document, array, items, whole};

/// A glTF document: all data except the parts, as it was read.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The JSON, with the `uri` of each buffer removed.
    pub(in crate::gltf) document: Document,
    /// The bytes of each buffer, cut to `byteLength`.
    pub(in crate::gltf) buffers: Vec<SharedBytes>,
    /// The primitive of each part of the model, in order.
    pub(in crate::gltf) primitives: Vec<PrimitiveRef>,
    /// The directories in which files of the document are looked up.
    pub(in crate::gltf) folders: Vec<PathBuf>,
}

/// The primitive of the document that a part was read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::gltf) struct PrimitiveRef {
    pub(in crate::gltf) mesh: usize,
    pub(in crate::gltf) primitive: usize,
    pub(in crate::gltf) mode: u64,
    /// Whether the part's faces differ from its indices in the document, so the indices must be
    /// replaced.
    pub(in crate::gltf) is_redrawn: bool,
}

impl Scene {
    /// Lists the contents of the document, except the parts, with counts. Formats without scenes
    /// cannot store them.
    ///
    /// ```
    /// let json = br#"{"asset":{"version":"2.0"},"nodes":[{"scale":[2,2,2]}],"cameras":[{}]}"#;
    /// let model = tristrip_io::gltf::read(json.to_vec(), None)?;
    /// let scene = model.scene.unwrap_or_default();
    /// assert_eq!(scene.beyond_parts(), ["nodes with a transform: 1", "cameras: 1"]);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn beyond_parts(&self) -> Vec<String> {
        let list = |name| array(&self.document.root, name).unwrap_or_default();
        let is_transformed = |node: &&Value| {
            ["matrix", "translation", "rotation", "scale"].iter().any(|key| node.get(key).is_some())
        };
        let primitives = || list("meshes").iter().flat_map(|mesh| items(mesh, "primitives"));
        let of_triangles = |p: &&Value| p.get("mode").and_then(whole).is_none_or(|mode| mode >= TRIANGLES);
        let counts = [
            (list("nodes").iter().filter(is_transformed).count(), "nodes with a transform"),
            (primitives().filter(|p| !of_triangles(p)).count(), "primitives of points or lines"),
            (primitives().filter(|p| p.get("targets").is_some()).count(), "primitives with morph targets"),
            (list("skins").len(), "skins"),
            (list("animations").len(), "animations"),
            (list("textures").len(), "textures"),
            (list("cameras").len(), "cameras"),
        ];
        counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{what}: {count}"))
            .collect()
    }

    /// Marks the indices of all parts for replacement on write, and removes white space from the
    /// JSON.
    pub(crate) fn redrawn(mut self) -> Result<Self, Error> {
        self.primitives.iter_mut().for_each(|primitive| primitive.is_redrawn = true);
        Ok(Self { document: self.document.without_spaces()?, ..self })
    }

    /// Checks that the number of parts is the same as when the scene was read.
    pub(in crate::gltf) fn check_part_count(&self, found: usize) -> Result<(), Error> {
        let expected = self.primitives.len();
        if found == expected {
            return Ok(());
        }
        let message = format!("parts: found {found}, expected {expected} as in the scene that was read");
        Err(Error::Unsupported(message))
    }
}
