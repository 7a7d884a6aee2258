//! Triangles that come and go, and edges that change sides, while the paths elsewhere stay: for meshes whose detail changes.
//!
//! Whoever changes the mesh cuts the links that lose their edge, says what the edges lead to now, and links again what it likes.
//!
//! # Complexity
//! O(1) each.

use super::{NONE, Node, Paths, Prices};
use crate::cover::diagonals::Diagonals;

impl Paths {
    /// Makes room for triangles, none of which is there yet.
    pub(crate) fn empty(triangle_count: usize, prices: Prices) -> Self {
        Self {
            nodes: vec![Node { twins: [NONE; 3], state: 0 }; triangle_count],
            diagonals: Diagonals::default(),
            ends: vec![0; triangle_count / 64 + 1],
            prices,
            strips: 0,
            cost: 0,
        }
    }

    /// Puts in a triangle that is not there, a strip by itself beside nothing.
    pub(crate) fn put_in(&mut self, t: u32) {
        self.nodes[t as usize] = Node { twins: [NONE; 3], state: 0 };
        self.set_partner(t, t);
        self.ends[t as usize / 64] |= 1 << (t % 64);
        self.strips += 1;
        self.cost += i64::from(self.prices.strip);
    }

    /// Takes out a triangle without links.
    pub(crate) fn take_out(&mut self, t: u32) {
        debug_assert_eq!(self.mask(t), 0, "its links were not cut");
        self.nodes[t as usize] = Node { twins: [NONE; 3], state: 0 };
        self.ends[t as usize / 64] &= !(1 << (t % 64));
        self.strips -= 1;
        self.cost -= i64::from(self.prices.strip);
    }

    /// Sets the other side of a half-edge over which there is no link; the other side is to be told as well.
    pub(crate) fn set_twin(&mut self, half_edge: u32, twin: u32) {
        debug_assert_eq!(self.mask(half_edge / 4) >> (half_edge % 4) & 1, 0, "its link was not cut");
        self.nodes[half_edge as usize / 4].twins[half_edge as usize % 4] = twin;
    }
}
