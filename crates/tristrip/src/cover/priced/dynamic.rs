//! Insertion and removal of triangles and edges while the paths elsewhere stay: for meshes whose detail changes.
//!
//! The caller that changes the mesh cuts the links that lose their edge, sets the new twins of half-edges, and adds links as it
//! chooses.
//!
//! # Complexity
//! O(1) each.

use super::{NO_TWIN, PathNode, PricedPaths, StripPrices};
use crate::cover::diagonals::Diagonals;

const UNLINKED: PathNode = PathNode { twins: [NO_TWIN; 3], state: 0 };

impl PricedPaths {
    /// Allocates slots for triangles, all of them empty.
    pub(crate) fn empty(triangle_count: usize, prices: StripPrices) -> Self {
        Self {
            nodes: vec![UNLINKED; triangle_count],
            diagonals: Diagonals::default(),
            ends: vec![0; triangle_count / 64 + 1],
            prices,
            strips: 0,
            cost: 0,
            walk_steps: 0,
        }
    }

    /// Inserts a triangle into an empty slot, as a strip by itself without neighbours.
    pub(crate) fn insert_triangle(&mut self, t: u32) {
        self.nodes[t as usize] = UNLINKED;
        self.set_partner(t, t);
        self.ends[t as usize / 64] |= 1 << (t % 64);
        self.strips += 1;
        self.cost += i64::from(self.prices.strip);
    }

    /// Removes a triangle without links.
    pub(crate) fn remove_triangle(&mut self, t: u32) {
        debug_assert_eq!(self.mask(t), 0, "its links were not cut");
        self.nodes[t as usize] = UNLINKED;
        self.ends[t as usize / 64] &= !(1 << (t % 64));
        self.strips -= 1;
        self.cost -= i64::from(self.prices.strip);
    }

    /// Sets the twin of a half-edge that is not linked; the caller sets the twin's twin as well.
    pub(crate) fn set_twin(&mut self, half_edge: u32, twin: Option<u32>) {
        debug_assert_eq!(self.mask(half_edge / 4) >> (half_edge % 4) & 1, 0, "its link was not cut");
        self.nodes[half_edge as usize / 4].twins[half_edge as usize % 4] = twin.unwrap_or(NO_TWIN);
    }
}
