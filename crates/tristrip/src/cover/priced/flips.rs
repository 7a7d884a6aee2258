//! Flips of the diagonals of polygons.

use super::PricedPaths;
use crate::cover::diagonals::to_graph_half_edge;

impl PricedPaths {
    /// Returns the edges of a triangle that are diagonals, one bit per edge.
    #[inline]
    pub(crate) fn diagonals(&self, t: u32) -> u32 {
        self.diagonals.edges.get(t as usize).map_or(0, |&edges| u32::from(edges))
    }

    /// Returns whether there are polygons.
    pub(crate) fn has_diagonals(&self) -> bool {
        !self.diagonals.edges.is_empty()
    }

    /// Returns the four edges around the two triangles at a diagonal, in winding order: first two
    /// edges of the triangle at the half-edge, then two edges of the other triangle.
    #[inline]
    pub(crate) fn around(&self, diagonal: u32) -> [u32; 4] {
        let twin = self.across(diagonal);
        let (a, c) = (next_in_triangle(diagonal), next_in_triangle(twin));
        [a, next_in_triangle(a), c, next_in_triangle(c)]
    }

    /// Flips a diagonal to the other two corners. The triangles on its sides must not be linked.
    pub(crate) fn flip_diagonal(&mut self, diagonal: u32) {
        let around = self.around(diagonal);
        let outside = around.map(|h| self.twin(h));
        let is_diagonal = around.map(|h| self.diagonals.edges[h as usize / 4] >> (h % 4) & 1);
        let corners = around.map(|h| self.diagonals.corners[to_graph_half_edge(h) as usize]);
        for (i, h) in around.into_iter().enumerate() {
            let from = (i + 1) % 4;
            self.set_both_twins(h, outside[from]);
            let edges = &mut self.diagonals.edges[h as usize / 4];
            *edges = *edges & !(1 << (h % 4)) | is_diagonal[from] << (h % 4);
            self.diagonals.corners[to_graph_half_edge(h) as usize] = corners[from];
        }
        let twin = self.across(diagonal);
        self.diagonals.corners[to_graph_half_edge(diagonal) as usize] = corners[3];
        self.diagonals.corners[to_graph_half_edge(twin) as usize] = corners[1];
    }

    fn set_both_twins(&mut self, h: u32, twin: Option<u32>) {
        self.set_twin(h, twin);
        if let Some(twin) = twin {
            self.set_twin(twin, Some(h));
        }
    }
}

/// Returns the next half-edge of the triangle.
#[inline]
fn next_in_triangle(h: u32) -> u32 {
    if h % 4 == 2 { h - 2 } else { h + 1 }
}
