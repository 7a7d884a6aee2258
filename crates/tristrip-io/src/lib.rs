//! Reads and writes the mesh files that tristrip works on.
//!
//! | format | read | written |
//! |---|---|---|
//! | OBJ | polygons, groups, materials, seams | faces, materials |
//! | PLY | ascii, little and big endian, polygons, `tristrips` | faces, `tristrips` |
//! | OFF | polygons | – |
//! | STL | ascii, binary; equal positions welded | – |
//! | glTF 2.0, GLB | all triangle modes, sparse accessors, restart, quantization, meshopt compression | GLB, with the scene; two files by [`gltf::separate`](gltf::separate()) |
//!
//! The module [`tlod`] reads and writes models of which each view has its own detail.
//!
//! Every input is treated as hostile: a reader never panics, and allocates in proportion to the bytes that it was given,
//! never to a count that they state. Its errors name the position in the file, what was found and what was expected. A
//! reader counts what it drops in [`Model::notes`]; [`losses`] lists what a writer has to drop.
//!
//! Files are touched only under the feature `fs`, which is on by default. Without it, bytes are read and written, and the crate
//! compiles for `wasm32-unknown-unknown`.
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
mod error;
mod format;
pub mod gltf;
mod join;
mod le_bytes;
mod levels;
mod materials;
mod model;
mod new_values;
mod new_vertices;
mod obj;
mod off;
#[cfg(feature = "fs")]
mod path;
mod ply;
mod polygons;
mod redraw;
mod reorder;
mod shared_vertices;
mod stl;
mod text;
pub mod tlod;
mod vertex_group;

pub use any_format::{losses, material_losses, plain_materials, read, read_shared, write};
pub use error::{Error, system_message};
pub use format::Format;
#[cfg(feature = "fs")]
pub use gltf::images::EmbeddedImages;
pub use levels::{LeveledModel, PartLevel, SceneLevels, in_level_order};
pub use materials::{Materials, PlainMaterial, SideFile};
pub use model::{Drawing, Model, Part, StoredStrips};
pub use new_values::{NewValues, NewVertices};
pub use new_vertices::{Extended, fixed_vertices, with_new_vertices};
#[cfg(feature = "fs")]
pub use path::{
    ReadFile, embed_images, load_materials, read_beside, read_file, read_path, replace_file, write_path,
};
pub use redraw::{KeptVertices, Redrawn, merge_equal_vertices, with_triangles};
pub use reorder::{Reordered, reorder};
pub use vertex_group::VertexGroup;
