//! Polygon meshes into render-ready triangle strips, proven.
//!
//! Every stripification is a path cover of the mesh's dual graph: the nodes are triangles, the arcs are shared edges, and
//! each strip is a simple path. The stages follow the data, and each imports only those before it:
//!
//! ```text
//! Mesh ─▶ Surface ─▶ DualGraph ─▶ Plan (triangulation + PathCover) ─▶ Strips ─▶ layout
//! ```
//!
//! The library computes only: it reads no file, prints nothing, starts no thread (outside the `rayon` feature), and does not
//! panic on any input.

#![forbid(unsafe_code)]

pub mod error;
pub mod mesh;
pub mod strip;

pub use error::{Error, MeshProblem};
pub use mesh::{Attribute, AttributeData, Faces, Mesh};
pub use strip::{Layout, Strips};
