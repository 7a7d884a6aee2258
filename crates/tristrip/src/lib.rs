//! Converts polygon meshes into render-ready triangle strips, with a proof.
//!
//! Every stripification is a path cover of the mesh's dual graph: the nodes are triangles, the arcs are shared edges, and
//! each strip is a simple path. The stages follow the data flow, and each imports only earlier ones:
//!
//! ```text
//! Mesh ─▶ PreparedFaces ─▶ DualGraph ─▶ StripPlan (triangulation + PathCover) ─▶ Strips ─▶ layout
//!   └──── triangles ────▶ simplify ─▶ CollapseSequence ─┬───────────────────┘
//!                                                       └▶ lod ─▶ Strips of any level
//! ```
//!
//! The library only computes: it reads no files, prints nothing, starts no threads (without the `rayon` feature), and does not
//! panic on any input.

#![forbid(unsafe_code)]

mod csr;
mod effort;
mod ids;
mod index;
mod names;
#[cfg(feature = "serde")]
mod serialize;
mod union_find;
mod vector;

pub mod collapse;
pub mod cover;
pub mod dual;
pub mod error;
pub mod lod;
pub mod mesh;
pub mod prepare;
pub mod random;
pub mod simplify;
pub mod strip;
pub mod stripify;
pub mod verify;
pub mod vertex_cache;

pub use collapse::CollapseSequence;
pub use cover::PathCover;
pub use dual::DualGraph;
pub use error::{Error, MeshProblem};
pub use ids::{FaceId, HalfEdge};
pub use index::Index;
pub use mesh::{Attribute, AttributeData, Faces, Mesh};
pub use prepare::PreparedFaces;
pub use strip::{Layout, Strips};
pub use stripify::{
    FaceTriangulation, Method, Patches, StripifyOptions, Ties, stripify, stripify_indices,
    stripify_indices_with,
};
