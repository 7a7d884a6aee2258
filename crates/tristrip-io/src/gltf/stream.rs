//! Progressive GLB: a stream of chunks behind base meshes (`docs/formats/progressive-glb.md`).
//!
//! `progressive` writes it and opens a file, `refine` replaces the base meshes of a document when it is read, and `arriving` decodes a
//! file that is still downloading.

pub(in crate::gltf) mod arriving;
pub(in crate::gltf) mod progressive;
pub(in crate::gltf) mod refine;
