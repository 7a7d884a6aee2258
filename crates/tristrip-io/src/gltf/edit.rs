//! Edits the vertices of a scene: renumbers, removes and adds vertices, and builds accessors over
//! the first values of other accessors for levels of detail.
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
