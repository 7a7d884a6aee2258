//! Changes to the vertices of a scene: other numbers, fewer or more of them, and accessors over the first of them for levels of detail.
//!
//! Each change returns a scene that is read and written as any other.

pub(crate) mod equal_vertices;
pub(crate) mod extend;
#[cfg(feature = "fs")]
pub(crate) mod images;
mod level_nodes;
pub(crate) mod levels;
pub(in crate::gltf) mod permute;
mod prefixes;
pub(crate) mod renumber;
mod shrink;
