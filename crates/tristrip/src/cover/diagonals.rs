//! The diagonals that cut polygons into triangles, for searches that flip them.
//!
//! ```text
//!   d ───── c        d ───── c      a flip moves the two triangles at a diagonal, which are not linked, one corner further
//!   │ u   ╱ │        │ ╲   t │      around; four flips restore the initial state
//!   │   ╱   │   ─▶   │   ╲   │
//!   │ ╱   t │        │ u   ╲ │
//!   a ───── b        a ───── b
//! ```
//! Polygons are convex, or cut in advance so that they can be treated as convex, so every diagonal is valid.
//!
//! # Complexity
//! O(1) per flip; 13 bytes per triangle, nothing if every face is a triangle.

use crate::dual::Triangulation;
use crate::mesh::Faces;

/// The triangles that polygons are cut into.
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

    /// Returns the vertices of each triangle; `None` if no polygon is cut.
    pub(super) fn corners(&self) -> Option<&[u32]> {
        (!self.edges.is_empty()).then_some(&self.corners)
    }
}

/// Converts the number of a half-edge from 4 t + e, as paths number it, to 3 t + e, as the dual graph does.
#[inline]
pub(super) fn to_graph_half_edge(h: u32) -> u32 {
    h / 4 * 3 + h % 4
}

/// Converts the number of a half-edge from 3 t + e, as the dual graph numbers it, to 4 t + e, as paths do.
#[inline]
pub(super) fn to_path_half_edge(h: u32) -> u32 {
    h / 3 * 4 + h % 3
}
