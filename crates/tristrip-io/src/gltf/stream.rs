//! Progressive GLB: a stream of chunks behind base meshes (`docs/formats/progressive-glb.md`).
//!
//! `progressive` writes and opens files, `refine` replaces the base meshes of a document on
//! reading, and `arriving` decodes a file while it downloads.

pub(in crate::gltf) mod arriving;
pub(in crate::gltf) mod progressive;
pub(in crate::gltf) mod refine;
