//! Progressive GLB: base meshes, followed by a stream of chunks that refines them
//! (`docs/formats/progressive-glb.md`).
//!
//! `progressive` writes and opens files, `refine` replaces the base meshes of a document when it is
//! read, and `arriving` decodes a file while it downloads.

pub(in crate::gltf) mod arriving;
pub(in crate::gltf) mod progressive;
pub(in crate::gltf) mod refine;
