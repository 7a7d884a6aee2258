//! Flips of the diagonals by which polygons are cut into triangles.

use super::{NONE, Paths};
use crate::cover::diagonals::by_threes;

impl Paths {
    /// The edges of a triangle that are diagonals, a bit each.
    #[inline]
    pub(crate) fn diagonals(&self, t: u32) -> u32 {
        self.diagonals.edges.get(t as usize).map_or(0, |&edges| u32::from(edges))
    }

    /// Tells whether there are polygons.
    pub(crate) fn has_diagonals(&self) -> bool {
        !self.diagonals.edges.is_empty()
    }

    /// The edges around the two triangles at a diagonal, in their winding: two of the triangle that the half-edge belongs to, then
    /// two of the other.
    #[inline]
    pub(crate) fn around(&self, diagonal: u32) -> [u32; 4] {
        let twin = self.twin(diagonal);
        let (a, c) = (after(diagonal), after(twin));
        [a, after(a), c, after(c)]
    }

    /// Turns a diagonal to the other two corners; the triangles on its sides must not be linked.
    pub(crate) fn turn_diagonal(&mut self, diagonal: u32) {
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
