//! glTF 2.0 and GLB: reads the triangles of a scene, and writes them back as strips without touching the rest of it.
//!
//! A document is kept as JSON values, in the order and with the digits that were read, next to the bytes of its buffers;
//! reading takes copies of positions, indices and attributes out of it, and writing puts new indices into it.
//!
//! ```text
//! bytes ─ container ─▶ JSON, BIN ─ buffer ─▶ buffers ─ accessor ─ read ─▶ parts
//!                                                │                          │ strips
//!                          GLB ◀─ container ◀─ keep (or build, without a scene) ◀─ index
//! ```
//!
//! # Algorithm
//! Reading: every primitive of triangles, strips or fans becomes one part, in the order of meshes and primitives. Strips and
//! fans are unpacked in order and wound as they are drawn. Primitives over one `POSITION` accessor share one array, which is
//! checked once, and those that have all attributes in common share them all.
//!
//! Writing, where the model has a scene: only `indices` and `mode` of its primitives change. A new index accessor takes the
//! place of the old one where nobody else refers to that, so that no number in the document changes its meaning, and the
//! old bytes leave the buffer; else accessor and bytes are added at the end. Any whole number inside of an extension or of
//! extras is taken for a possible reference. All buffers become one.
//!
//! Departures from the letter of the specification, all of them on the side of reading more: alignment is not asked for,
//! and a restart index counts as one whether or not the extension is declared, as graphics interfaces treat it.
//!
//! # The restart layout
//! Follows the draft `KHR_mesh_primitive_restart` of <https://github.com/KhronosGroup/glTF/pull/2569> as of 2026: the highest
//! value of the index type restarts line loops, line strips, triangle strips and triangle fans; the name stands in
//! `extensionsUsed` and `extensionsRequired`; no object is added to meshes or primitives. The older, merged
//! `EXT_mesh_primitive_restart` describes groups of primitives in an object of the mesh; its primitives are read one by one.
//!
//! # References
//! The Khronos Group: *glTF 2.0 Specification*, 2021. P. Connelly, D. `McCurdy`: *`KHR_mesh_primitive_restart`*, draft, 2026.
//!
//! # Complexity
//! Linear time. The file's bytes are kept once, beside 12 bytes a vertex for each `POSITION` accessor, 12 bytes a triangle,
//! and the other attributes in their own width. What is decoded is bounded by [`DECODED_LIMIT`].

mod accessor;
mod buffer;
mod build;
mod container;
mod document;
mod index;
mod keep;
mod read;
pub(crate) mod reorder;

use serde_json::{Map, Value};
use tristrip::Layout;

use crate::error::Error;
use crate::model::{Drawing, Model};

pub use build::losses;
pub use read::read;

/// The bytes that positions and indices of any file may take when decoded; 16 for each byte of its buffers come on top.
pub const DECODED_LIMIT: u64 = 64 << 20;

/// The most values that the JSON of a document may have.
pub const JSON_VALUE_LIMIT: u64 = 4 << 20;

/// The extension that allows the restart index.
const RESTART_EXTENSION: &str = "KHR_mesh_primitive_restart";

const TRIANGLES: u64 = 4;
const TRIANGLE_STRIP: u64 = 5;
const TRIANGLE_FAN: u64 = 6;

/// A glTF document: everything around the parts, kept as it was read.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    /// The JSON, with the `uri` of each buffer taken out.
    root: Map<String, Value>,
    /// The bytes of each buffer, `byteLength` of them.
    buffers: Vec<buffer::Bytes>,
    /// Where each part of the model stands, in order.
    primitives: Vec<PrimitiveAt>,
}

impl Scene {
    /// Says in words what the document holds beside the parts, with counts: a format without scenes cannot keep it.
    ///
    /// ```
    /// let json = br#"{"asset":{"version":"2.0"},"nodes":[{"scale":[2,2,2]}],"cameras":[{}]}"#;
    /// let model = tristrip_io::gltf::read(json.to_vec(), None)?;
    /// let scene = model.scene.unwrap_or_default();
    /// assert_eq!(scene.beyond_parts(), ["nodes with a transform: 1", "cameras: 1"]);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn beyond_parts(&self) -> Vec<String> {
        let list = |name| document::array(&self.root, name).unwrap_or_default();
        let placed = |node: &&Value| {
            ["matrix", "translation", "rotation", "scale"].iter().any(|key| node.get(*key).is_some())
        };
        let primitives = || list("meshes").iter().flat_map(|mesh| document::items(mesh, "primitives"));
        let of_triangles =
            |p: &&Value| p.get("mode").and_then(document::whole).is_none_or(|mode| mode >= TRIANGLES);
        let counts = [
            (list("nodes").iter().filter(placed).count(), "nodes with a transform"),
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
}

impl Scene {
    /// Checks that there are as many parts as the scene had when it was read.
    fn check_part_count(&self, found: usize) -> Result<(), Error> {
        let expected = self.primitives.len();
        if found == expected {
            return Ok(());
        }
        let message = format!("parts: found {found}, expected {expected} as in the scene that was read");
        Err(Error::Unsupported(message))
    }
}

/// Tells whether a model's document has values for vertices that the meshes of its parts do not hold: morph targets, and
/// attributes that were not decoded. Vertices that look the same there need not be the same.
///
/// ```
/// let json = br#"{"asset":{"version":"2.0"}}"#;
/// assert!(!tristrip_io::gltf::has_unread_vertex_values(&tristrip_io::gltf::read(json.to_vec(), None)?));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn has_unread_vertex_values(model: &Model) -> bool {
    let Some(scene) = &model.scene else { return false };
    let meshes = document::array(&scene.root, "meshes").unwrap_or_default();
    scene.primitives.iter().zip(&model.parts).any(|(at, part)| {
        let Some(mesh) = meshes.get(at.mesh) else { return false };
        document::items(mesh, "primitives").get(at.primitive).is_some_and(|primitive| {
            let attributes = primitive.get("attributes").and_then(Value::as_object).map_or(0, Map::len);
            // The position is an attribute of the primitive, and none of the mesh.
            !document::items(primitive, "targets").is_empty() || attributes > part.mesh.attributes().len() + 1
        })
    })
}

/// The place of a part in the document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct PrimitiveAt {
    mesh: usize,
    primitive: usize,
    mode: u64,
}

/// Writes a GLB with one drawing for each part, in order.
///
/// With a scene, the document is the one that was read: only the indices and modes of its triangle primitives change
/// ([`Drawing::Faces`] leaves a triangle list alone). Without one, a minimal document is made: a mesh and node for each
/// run of parts of one name, a primitive a part, a material a name. [`losses`] tells what such a document cannot hold.
///
/// The index type is the smallest in which no index takes the highest value. Strips of fewer than three vertices are
/// left out; a drawing without any triangle becomes one degenerate triangle, because glTF has no empty index buffers.
/// [`Layout::Restart`] declares the draft extension only where there is a restart.
///
/// # Errors
/// The drawings do not fit the parts, a strip names a vertex that does not exist, or the result exceeds 4 GiB.
///
/// ```
/// use tristrip::{Faces, Layout, Mesh};
/// use tristrip_io::{Drawing, Model, Part, gltf};
/// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
/// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
/// let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
/// let mut strips = tristrip::Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// let glb = gltf::write_glb(&model, &[Drawing::Strips(&strips)], Layout::Degenerate)?;
/// assert_eq!(gltf::read(glb, None)?.parts[0].mesh.faces(), model.parts[0].mesh.faces());
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn write_glb(model: &Model, drawings: &[Drawing<'_>], layout: Layout) -> Result<Vec<u8>, Error> {
    if drawings.len() != model.parts.len() {
        return Err(Error::Unsupported(format!(
            "drawings: found {}, expected {}: one for each part",
            drawings.len(),
            model.parts.len()
        )));
    }
    match &model.scene {
        Some(scene) => keep::write(scene, model, drawings, layout),
        None => build::write(model, drawings, layout),
    }
}
