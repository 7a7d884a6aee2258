//! Inserts and removes triangles and edges without changing other paths, for meshes whose level of
//! detail changes.
//!
//! The caller changes the mesh: it cuts the links whose edges disappear, sets the new twins of
//! half-edges, and chooses the new links.
//!
//! # Complexity
//! O(1) per operation.

use super::{NO_TWIN, PathNode, PricedPaths, StripPrices};
use crate::cover::diagonals::Diagonals;

const UNLINKED: PathNode = PathNode { twins: [NO_TWIN; 3], state: 0 };

impl PricedPaths {
    /// Allocates empty slots for triangles.
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

    /// Allocates slots up to a number of triangles. The new slots are empty.
    pub(crate) fn grow(&mut self, triangle_count: usize) {
        self.nodes.resize(triangle_count, UNLINKED);
        self.ends.resize(triangle_count / 64 + 1, 0);
    }

    /// Inserts a triangle into an empty slot, as a strip of its own without neighbours.
    pub(crate) fn insert_triangle(&mut self, t: u32) {
        self.nodes[t as usize] = UNLINKED;
        self.set_partner(t, t);
        self.ends[t as usize / 64] |= 1 << (t % 64);
        self.strips += 1;
        self.cost += i64::from(self.prices.strip);
    }

    /// Inserts a triangle without links between the two triangles of a link. Its half-edge
    /// `sides[0]` becomes the twin of the link, and `sides[1]` the twin of the link's twin.
    pub(crate) fn insert_into_link(&mut self, link: u32, sides: [u32; 2]) {
        let twin = self.across(link);
        debug_assert_eq!(self.mask(sides[0] / 4), 0, "it has links");
        // Only the turn in the inserted triangle is new. The start of the path changes only if the
        // link is next to an end.
        let ends = match [link, twin].map(|h| self.degree(h / 4) < 2) {
            [true, _] => Some([link / 4, self.partner(link / 4)]),
            [false, true] => Some([self.partner(twin / 4), twin / 4]),
            [false, false] => None,
        };
        let start_swap = |paths: &Self| ends.map_or(0, |[e, f]| paths.start_swap(e, f));
        let before = self.swap_at(link) + start_swap(self);
        for (outer, inner) in [(link, sides[0]), (twin, sides[1])] {
            self.nodes[outer as usize / 4].twins[outer as usize % 4] = inner;
            self.nodes[inner as usize / 4].twins[inner as usize % 4] = outer;
            self.nodes[inner as usize / 4].state |= 1 << (inner % 4);
        }
        let t = sides[0] / 4;
        self.ends[t as usize / 64] &= !(1 << (t % 64));
        let after = self.swap_at(link) + self.swap_at(twin) + start_swap(self);
        self.strips -= 1;
        self.cost += i64::from((after - before) * self.prices.swap - self.prices.strip);
    }

    /// Joins a triangle to adjacent ends, each time over the edge that lowers the cost most, until
    /// every join would raise it.
    pub(crate) fn join_ends(&mut self, t: u32) {
        while self.degree(t) < 2 {
            let best = (4 * t..4 * t + 3).filter_map(|h| self.join_rise(h).map(|rise| (rise, h))).min();
            match best {
                Some((rise, h)) if rise <= 0 => _ = self.join(h),
                _ => break,
            }
        }
    }

    /// Returns the cost increase of a join over a half-edge of an end, or `None` if the join is
    /// impossible.
    fn join_rise(&mut self, h: u32) -> Option<i32> {
        let twin = self.twin(h)?;
        if self.is_linked(h) || self.degree(twin / 4) == 2 {
            return None;
        }
        let ends = self.outer_ends(h);
        let rise = self.join(h)?;
        self.cut_between(h, ends);
        Some(rise)
    }

    /// Removes a triangle without links.
    pub(crate) fn remove_triangle(&mut self, t: u32) {
        debug_assert_eq!(self.mask(t), 0, "its links were not cut");
        self.nodes[t as usize] = UNLINKED;
        self.ends[t as usize / 64] &= !(1 << (t % 64));
        self.strips -= 1;
        self.cost -= i64::from(self.prices.strip);
    }

    /// Sets the twin of a half-edge that is not linked. The caller sets the other side as well.
    pub(crate) fn set_twin(&mut self, half_edge: u32, twin: Option<u32>) {
        debug_assert_eq!(self.mask(half_edge / 4) >> (half_edge % 4) & 1, 0, "its link was not cut");
        self.nodes[half_edge as usize / 4].twins[half_edge as usize % 4] = twin.unwrap_or(NO_TWIN);
    }
}
