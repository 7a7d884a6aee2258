//! Converts polygon meshes into render-ready triangle strips and verifies the result.
//!
//! Every stripification is a path cover of the mesh's dual graph. The nodes are triangles, the arcs
//! are shared edges, and each strip is a simple path. The modules follow the data flow, and each
//! imports only earlier ones:
//!
//! ```text
//! Mesh ─▶ PreparedFaces ─▶ DualGraph ─▶ StripPlan (triangulation + PathCover) ─▶ Strips ─▶ layout
//!   └──── triangles ────▶ simplify ─▶ CollapseSequence ─┬───────────────────┘
//!                                                       ├▶ lod ─▶ Strips of any level
//!                                                       └▶ stream ─▶ bytes of all levels
//! ```
//!
//! The library only computes. It reads no files, prints nothing, starts no threads (without the
//! `rayon` feature), and does not panic on any input.

#![forbid(unsafe_code)]

mod collapse;
mod cover;
mod csr;
mod dual;
mod effort;
mod entropy;
mod error;
mod ids;
mod index;
mod mesh;
mod names;
mod packed;
mod prepare;
#[cfg(feature = "serde")]
mod serialize;
mod setters;
mod strip;
pub mod union_find;
mod vector;

pub mod lod;
pub mod normals;
pub mod random;
pub mod simplify;
pub mod stream;
pub mod stripify;
pub mod text;
pub mod verify;
pub mod vertex_cache;

pub use collapse::{Collapse, CollapseSequence, Rename};
pub use cover::{CoverFault, PathCover};
pub use dual::{DualGraph, MeshReport, Triangulation};
pub use effort::Effort;
pub use error::{Error, MeshProblem};
pub use ids::{FaceId, HalfEdge, MAX_COUNT};
pub use index::Index;
pub use mesh::{
    Attribute, AttributeData, Faces, InterleavedPositions, Mesh, NearPositions, PositionIds, Positions,
    VertexWelds,
};
pub use prepare::{PreparedCounts, PreparedFaces};
pub use strip::{Cost, Layout, Metrics, Strips, VertexOrder, split_joined, strip_triangles};
pub use stripify::one_shot::{
    stripify, stripify_faces, stripify_indices, stripify_indices_watched, stripify_indices_with,
};
pub use stripify::options::{Method, StripifyOptions};
