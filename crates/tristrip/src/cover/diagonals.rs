//! The diagonals of the polygons, for searches that flip them.
//!
//! ```text
//!   d ───── c        d ───── c      a flip rotates the two triangles at a diagonal by one corner
//!   │ u   ╱ │        │ ╲   t │      (they must not be linked); four flips restore the start
//!   │   ╱   │   ─▶   │   ╲   │
//!   │ ╱   t │        │ u   ╲ │
//!   a ───── b        a ───── b
//! ```
//! Every diagonal is valid, because prepared polygons can be treated as convex.
//!
//! # Complexity
//! O(1) per flip. 13 bytes per triangle, or nothing if every face is a triangle.

use crate::dual::Triangulation;
use crate::mesh::Faces;

/// The triangles of the polygons.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Diagonals {
    /// The vertices of each triangle.
    pub(super) corners: Vec<u32>,
    /// The edges of each triangle that are diagonals, one bit per edge.
    pub(super) edges: Vec<u8>,
}

impl Diagonals {
    pub(super) fn new(faces: &Faces, triangulation: &Triangulation<'_>) -> Self {
        if faces.as_triangles().is_some() {
            return Self::default();
        }
        let mut edges = vec![0; triangulation.triangle_count()];
        let mut first = 0;
        for polygon in faces.iter() {
            let end = first + polygon.len() as u32 - 2;
            for h in 3 * first..3 * end {
                if triangulation.graph().twin_of(h).is_some_and(|twin| (first..end).contains(&(twin / 3))) {
                    edges[h as usize / 3] |= 1 << (h % 3);
                }
            }
            first = end;
        }
        Self { corners: triangulation.triangles().to_vec(), edges }
    }

    /// Returns the vertices of each triangle, or `None` if every face is a triangle.
    pub(super) fn corners(&self) -> Option<&[u32]> {
        (!self.edges.is_empty()).then_some(&self.corners)
    }
}

/// Converts a half-edge index of the paths, 4 t + e, to the index in the dual graph, 3 t + e.
#[inline]
pub(super) fn to_graph_half_edge(h: u32) -> u32 {
    h / 4 * 3 + h % 4
}

/// Converts a half-edge index of the dual graph, 3 t + e, to the index in the paths, 4 t + e.
#[inline]
pub(super) fn to_path_half_edge(h: u32) -> u32 {
    h / 3 * 4 + h % 3
}
