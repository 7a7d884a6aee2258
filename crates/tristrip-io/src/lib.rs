//! Reads and writes the mesh files that tristrip processes.
//!
//! | format | read | written |
//! |---|---|---|
//! | OBJ | polygons, groups, materials, seams | faces, materials |
//! | PLY | ascii, little and big endian, polygons, `tristrips` | faces, `tristrips` |
//! | OFF | polygons | – |
//! | STL | ascii, binary; equal positions welded | – |
//! | glTF 2.0, GLB | triangles, strips, fans; sparse or compressed data | GLB, with the scene |
//!
//! The glTF reader supports restarts, quantization, and compression by meshoptimizer and Draco.
//! [`gltf::separate`](gltf::separate()) splits a GLB into a `.gltf` and its buffer.
//!
//! The module [`tlod`] reads and writes view-dependent level-of-detail models.
//!
//! Every input is treated as untrusted. A reader never panics and allocates memory in proportion to
//! the input size, never to a declared count. Its errors report the position in the file, what was
//! found and what was expected. A reader counts dropped data in [`Model::notes`]; [`losses`] lists
//! what a writer cannot store.
//!
//! Only the feature `fs`, enabled by default, accesses the file system. Without it, the crate reads
//! and writes bytes in memory and compiles for `wasm32-unknown-unknown`.
//!
//! ```
//! use tristrip_io::{Drawing, Format, read, write};
//! let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
//! let ply = write(&model, &[Drawing::Faces], Format::Ply, tristrip::Layout::List)?;
//! assert_eq!(read(&ply, Format::Ply)?.parts[0].mesh, model.parts[0].mesh);
//! # Ok::<(), tristrip_io::Error>(())
//! ```
#![forbid(unsafe_code)]

mod any_format;
mod edit;
mod error;
mod format;
pub mod gltf;
mod join;
mod le_bytes;
mod materials;
mod model;
mod obj;
mod off;
#[cfg(feature = "fs")]
mod path;
mod ply;
mod polygons;
mod stl;
mod text;
pub mod tlod;

pub use any_format::{losses, material_losses, plain_materials, read, read_shared, write};
pub use edit::levels::{LeveledModel, PartLevel, SceneLevels, in_level_order};
pub use edit::new_values::{NewValues, NewVertices};
pub use edit::new_vertices::{Extended, fixed_vertices, with_new_vertices};
pub use edit::redraw::{KeptVertices, Redrawn, merge_equal_vertices, with_triangles};
pub use edit::reorder::{Reordered, reorder};
pub use edit::vertex_group::VertexGroup;
pub use error::{Error, system_message};
pub use format::Format;
#[cfg(feature = "fs")]
pub use gltf::edit::images::EmbeddedImages;
pub use materials::{Materials, PlainMaterial, SideFile};
pub use model::{Drawing, Model, Part, StoredStrips};
#[cfg(feature = "fs")]
pub use path::{
    ReadFile, embed_images, load_materials, read_beside, read_file, read_path, replace_file, write_path,
};
