//! Polygon meshes into render-ready triangle strips, proven.
//!
//! Every stripification is a path cover of the mesh's dual graph: the nodes are triangles, the arcs are shared edges, and
//! each strip is a simple path. The stages follow the data, and each imports only those before it:
//!
//! ```text
//! Mesh ─▶ Surface ─▶ DualGraph ─▶ Plan (triangulation + PathCover) ─▶ Strips ─▶ layout
//!   └──── triangles ────▶ simplify ─▶ CollapseSequence ─┬──────────────┘
//!                                                       └▶ lod ─▶ Strips of any level
//! ```
//!
//! The library computes only: it reads no file, prints nothing, starts no thread (outside the `rayon` feature), and does not
//! panic on any input.

#![forbid(unsafe_code)]

pub mod cover;
pub mod dual;
pub mod error;
pub mod lod;
pub mod mesh;
pub mod simplify;
pub mod strip;
pub mod stripify;

pub use cover::PathCover;
pub use dual::{DualGraph, FaceId, HalfEdge};
pub use error::{Error, MeshProblem};
pub use mesh::{Attribute, AttributeData, Faces, Mesh, Surface};
pub use simplify::CollapseSequence;
pub use strip::{Layout, Strips};
pub use stripify::random;
pub use stripify::{FaceTriangulation, Method, Options, Patches, Ties, stripify};
