//! The diagonals by which polygons are cut into triangles, for searches that cut them anew.
//!
//! ```text
//!   d ───── c        d ───── c      the triangles on the two sides of a diagonal, without links, go around by one corner:
//!   │ u   ╱ │        │ ╲   t │      four times bring them back to where they were
//!   │   ╱   │   ─▶   │   ╲   │
//!   │ ╱   t │        │ u   ╲ │
//!   a ───── b        a ───── b
//! ```
//! Polygons are convex, or cut so that they may be taken for such, and any diagonal is as good as any other.
//!
//! # Complexity
//! O(1) a turn; 13 bytes a triangle, nothing where every face is a triangle.

use super::{NONE, Paths};
use crate::mesh::{Faces, Triangulation};

/// How polygons are cut.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Diagonals {
    /// The vertices of each triangle.
    corners: Vec<u32>,
    /// The edges of each triangle that are diagonals, a bit each.
    edges: Vec<u8>,
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
                let twin = triangulation.graph().twins()[h as usize];
                if twin != NONE && (first..end).contains(&(twin / 3)) {
                    edges[h as usize / 3] |= 1 << (h % 3);
                }
            }
            first = end;
        }
        Self { corners: triangulation.triangles().to_vec(), edges }
    }

    /// Gives the vertices of each triangle; `None` where no polygon is cut.
    pub(super) fn corners(&self) -> Option<&[u32]> {
        (!self.edges.is_empty()).then_some(&self.corners)
    }
}

impl Paths {
    /// The edges of a triangle that are diagonals, a bit each.
    #[inline]
    pub(in super::super) fn diagonals(&self, t: u32) -> u32 {
        self.diagonals.edges.get(t as usize).map_or(0, |&edges| u32::from(edges))
    }

    /// Tells whether there are polygons.
    pub(in super::super) fn has_diagonals(&self) -> bool {
        !self.diagonals.edges.is_empty()
    }

    /// The edges around the two triangles at a diagonal, in their winding: two of the triangle that the half-edge belongs to, then
    /// two of the other.
    #[inline]
    pub(in super::super) fn around(&self, diagonal: u32) -> [u32; 4] {
        let twin = self.twin(diagonal);
        let (a, c) = (after(diagonal), after(twin));
        [a, after(a), c, after(c)]
    }

    /// Turns a diagonal to the other two corners; the triangles on its sides must not be linked.
    pub(in super::super) fn turn_diagonal(&mut self, diagonal: u32) {
        let around = self.around(diagonal);
        let outside = around.map(|h| self.twin(h));
        let is_diagonal = around.map(|h| self.diagonals.edges[h as usize / 4] >> (h % 4) & 1);
        let corners = around.map(|h| self.diagonals.corners[by_threes(h) as usize]);
        for (i, h) in around.into_iter().enumerate() {
            let from = (i + 1) % 4;
            self.set_twins(h, outside[from]);
            let edges = &mut self.diagonals.edges[h as usize / 4];
            *edges = *edges & !(1 << (h % 4)) | is_diagonal[from] << (h % 4);
            self.diagonals.corners[by_threes(h) as usize] = corners[from];
        }
        let twin = self.twin(diagonal);
        self.diagonals.corners[by_threes(diagonal) as usize] = corners[3];
        self.diagonals.corners[by_threes(twin) as usize] = corners[1];
    }

    fn set_twins(&mut self, h: u32, twin: u32) {
        self.nodes[h as usize / 4].twins[h as usize % 4] = twin;
        if twin != NONE {
            self.nodes[twin as usize / 4].twins[twin as usize % 4] = h;
        }
    }
}

/// The half-edge after one in its triangle.
#[inline]
fn after(h: u32) -> u32 {
    if h % 4 == 2 { h - 2 } else { h + 1 }
}

/// The number of a half-edge as the dual graph counts.
#[inline]
pub(super) fn by_threes(h: u32) -> u32 {
    if h == NONE { NONE } else { h / 4 * 3 + h % 4 }
}
