//! glTF 2.0 and GLB: reads the triangles of a scene and writes them back as strips, leaving the
//! rest of the document unchanged.
//!
//! A document is stored as JSON values with their source text, and the bytes of its buffers.
//! Reading copies positions, indices and attributes out of it; writing replaces its indices.
//!
//! ```text
//! file ─▶ JSON and buffers ─▶ decompressed buffers ─▶ accessors ─▶ parts
//!              │                                                    │ strips
//!  GLB ◀─ the document with new indices (or a new document, for a model without a scene)
//! ```
//!
//! # Algorithm
//! Reading: each primitive of triangles, strips or fans becomes one part, in the order of meshes
//! and primitives. Strips and fans are expanded in drawing order and keep their winding. Primitives
//! that use the same `POSITION` accessor share one array, which is checked once; primitives with
//! the same set of attributes share all attribute arrays.
//!
//! Buffer views compressed by meshoptimizer are decompressed first, and the extension is removed: a
//! written GLB stores these bytes uncompressed.
//!
//! Writing a model that has a scene: only `indices` and `mode` of its primitives change. A new
//! index accessor replaces the old one in place if nothing else refers to the old one, so no index
//! in the document changes its meaning. The old bytes are then removed from the buffer. Otherwise
//! the accessor and its bytes are appended. Any integer inside an extension or extras counts as a
//! possible reference. All buffers are merged into one.
//!
//! [`reorder`](crate::reorder()) and [`with_triangles`](crate::with_triangles) change the scene
//! before it is written: they move vertex values within their accessors and remove the values of
//! unused vertices.
//!
//! The reader accepts more than the specification allows: it does not check alignment, and it
//! treats the highest index as a restart whether or not the extension is declared, as graphics APIs
//! do.
//!
//! # The restart layout
//! The layout follows the draft `KHR_mesh_primitive_restart` of
//! <https://github.com/KhronosGroup/glTF/pull/2569> as of 2026. The highest value of the index type
//! restarts line loops, line strips, triangle strips and triangle fans. The name is listed in
//! `extensionsUsed` and `extensionsRequired`; meshes and primitives get no extension object. The
//! older extension `EXT_mesh_primitive_restart` describes groups of primitives in an object of the
//! mesh. The reader reads these primitives one by one.
//!
//! # References
//! The Khronos Group: *glTF 2.0 Specification*, 2021. P. Connelly, D. `McCurdy`:
//! *`KHR_mesh_primitive_restart`*, draft, 2026.
//!
//! # Complexity
//! Linear time. Memory: one copy of the file's bytes, 12 bytes per vertex for each `POSITION`
//! accessor, 12 bytes per triangle, and the other attributes at their stored width. Primitives with
//! the same indices are decoded once.
//!
//! Memory and time are bounded by the file size. Compressed buffer views decompress to at most 8
//! MiB plus 32 times the size of the buffers. Positions and indices decode to at most 1 MiB plus 16
//! times that size, other attributes to at most 64 MiB plus 4 times that size. Each index array may
//! be drawn 16 times on average, plus 2^18 triangles in total.

pub(crate) mod document;
pub(crate) mod edit;
mod pack;
pub(crate) mod read;
mod stream;
mod write;

use self::document::json::{Members, Value};
use tristrip::Layout;

use crate::error::Error;
use crate::model::{Drawing, Model};

#[cfg(not(feature = "fs"))]
pub(crate) use document::buffer::NoBufferFiles as BufferFiles;
#[cfg(feature = "fs")]
pub(crate) use document::buffer_files::BufferFiles;
pub use document::scene::Scene;
pub use pack::{Rounding, pack};
pub use read::appearance::{Appearance, Image, Instance, Material, Texture, Wrap};
pub use read::placements::Placement;
pub use read::pose::{MorphReader, Skin};
pub(crate) use read::read_with_files;
pub use read::{read, read_separate, with_scene};
pub use stream::arriving::{ArrivalLimits, ArrivingGlb};
pub use stream::progressive::{ChunkRange, ProgressiveGlb, WrittenGlb, read_base, write_progressive};
pub use stream::refine::{StreamMeshes, StreamedPart};
pub(crate) use write::build::losses;
pub use write::separate::{SeparateFiles, separate};

/// Returns whether a model's document contains vertex data that is not in the meshes of its parts:
/// morph targets and attributes that were not decoded. Vertices that are equal in the meshes may
/// differ in this data.
/// ```
/// let json = br#"{"asset":{"version":"2.0"}}"#;
/// let model = tristrip_io::gltf::read(json.to_vec(), None)?;
/// assert!(!tristrip_io::gltf::has_unread_vertex_values(&model));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn has_unread_vertex_values(model: &Model) -> bool {
    unread_vertex_values(model).contains(&true)
}

/// Returns, for each part, whether the document contains vertex data that is not in its mesh. See
/// [`has_unread_vertex_values`].
///
/// ```
/// use tristrip_io::{Format, gltf, read};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// assert_eq!(gltf::unread_vertex_values(&model), [false]);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn unread_vertex_values(model: &Model) -> Vec<bool> {
    let Some(scene) = &model.scene else { return vec![false; model.parts.len()] };
    let meshes = document::array(&scene.document.root, "meshes").unwrap_or_default();
    let is_unread = |(source, part): (&document::scene::PrimitiveRef, &crate::model::Part)| {
        let Some(mesh) = meshes.get(source.mesh) else { return false };
        document::items(mesh, "primitives").get(source.primitive).is_some_and(|primitive| {
            let attributes = primitive.get("attributes").and_then(Value::as_object).map_or(0, Members::len);
            // `POSITION` is an attribute of the primitive, but not of the mesh.
            !document::items(primitive, "targets").is_empty() || attributes > part.mesh.attributes().len() + 1
        })
    };
    scene.primitives.iter().zip(&model.parts).map(is_unread).collect()
}

/// Writes a GLB with one drawing per part, in order.
///
/// With a scene, the document is written as it was read, except for the indices and modes of its
/// triangle primitives ([`Drawing::Faces`] leaves a triangle list unchanged). Without a scene, it
/// builds a minimal document: one mesh and node per run of parts with the same name, one primitive
/// per part, one material per name.
///
/// The index type is the smallest that can store the indices without using its highest value.
/// Strips of fewer than three vertices are dropped. A drawing without triangles becomes one
/// degenerate triangle, because glTF has no empty index buffers. [`Layout::Restart`] declares the
/// draft extension only if a restart occurs.
pub(crate) fn write_glb(model: &Model, drawings: &[Drawing<'_>], layout: Layout) -> Result<Vec<u8>, Error> {
    model.check_drawings(drawings)?;
    match &model.scene {
        Some(scene) => write::keep::draw(scene, model, drawings, layout)?.write(),
        None => write::build::build(model, drawings, layout).write(),
    }
}
