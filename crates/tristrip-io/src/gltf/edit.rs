//! Changes to the vertices of a scene: renumbering, removal, added vertices, and accessors over
//! their first values for levels of detail.
//!
//! Each change returns a scene that can be read and written like any other.

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
