//! A path cover that knows its cost and the ends of its paths, for searches that change it at its ends.
//!
//! ```text
//!   e ━━ ∙ ━━ t ┄┄ u ━━ ∙ ━━ f       each end knows the other end of its path: joining t–u pairs e with f,
//!                                    cutting t–u pairs e with t and u with f
//! ```
//! There are two changes, *join* and *cut*, and each tells exactly by how much the cost rises: by the swaps on the link itself and
//! on the links next to it, by a strip's price, and by the repeats at the starts of the paths that it touches. Anything else
//! is made of them, and undone by them in the opposite order.
//!
//! # Complexity
//! 16 bytes and a bit a triangle. A join takes O(1); a cut as many steps as there are to the nearer end of its path.

mod dynamic;
mod flips;

use super::PathCover;
use super::diagonals::{Diagonals, by_threes};
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::mesh::Faces;

/// No twin.
pub(crate) const NONE: u32 = u32::MAX;
/// Bits of a node's state that say over which of its edges it is linked; the others are its partner.
const EDGES: u32 = 7;
/// More triangles than this cannot be numbered beside the edges.
pub(crate) const TRIANGLE_LIMIT: usize = 1 << 29;

/// A triangle. Half-edges are numbered by fours here: edge e of triangle t is 4 t + e.
#[derive(Debug, Clone, Copy)]
struct Node {
    twins: [u32; 3],
    /// The edges over which it is linked and, at an end, the other end of its path.
    state: u32,
}

/// Prices, in indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Prices {
    pub(crate) strip: i32,
    pub(crate) swap: i32,
}

/// Paths over triangles, and what they cost.
#[derive(Debug, Clone)]
pub(crate) struct Paths {
    nodes: Vec<Node>,
    diagonals: Diagonals,
    /// A bit for each triangle that is linked over fewer than two edges.
    ends: Vec<u64>,
    prices: Prices,
    strips: usize,
    /// What the strips cost beyond one index a triangle.
    cost: i64,
}

/// Which side a triangle that is linked over the edges of a mask (3 bits) and entered over an edge (2 bits) turns to: 1 where it
/// goes on over the next edge, 2 for the previous one, 0 where it does not go on.
const TURNS: [u8; 32] = {
    let mut turns = [0; 32];
    let mut edge = 0;
    while edge < 3 {
        let next = (edge + 1) % 3;
        let previous = (edge + 2) % 3;
        turns[(1 << edge | 1 << next) << 2 | edge] = 1;
        turns[(1 << edge | 1 << previous) << 2 | edge] = 2;
        edge += 1;
    }
    turns
};

/// Gives the turn of a triangle linked over a mask of edges and entered over one of them.
#[inline]
pub(crate) fn turn(mask: u32, edge: u32) -> u8 {
    TURNS[((mask & EDGES) << 2 | edge & 3) as usize]
}

/// Tells whether the turns on the two sides of a link, each seen from the link, make a swap: a walk over it turns to one side twice.
#[inline]
pub(crate) fn is_swap(here: u8, there: u8) -> i32 {
    i32::from(here ^ there == 3)
}

impl Paths {
    /// Takes over a cover of a triangulation of faces.
    pub(crate) fn new(
        faces: &Faces,
        triangulation: &Triangulation<'_>,
        cover: &PathCover,
        prices: Prices,
    ) -> Self {
        let by_fours = |h: &u32| if *h == NONE { NONE } else { h / 3 * 4 + h % 3 };
        let nodes = triangulation
            .graph()
            .twins()
            .chunks_exact(3)
            .map(|t| Node { twins: [by_fours(&t[0]), by_fours(&t[1]), by_fours(&t[2])], state: 0 });
        let mut paths = Self {
            nodes: nodes.collect(),
            diagonals: Diagonals::new(faces, triangulation),
            ends: vec![0; cover.len() / 64 + 1],
            prices,
            strips: 0,
            cost: 0,
        };
        for t in 0..cover.len() as u32 {
            let (first, second) = cover.packed_edges(t);
            paths.nodes[t as usize].state = (1 << first | 1 << second) & EDGES;
            if first == 3 || second == 3 {
                paths.ends[t as usize / 64] |= 1 << (t % 64);
            }
        }
        paths.pair_ends();
        paths
    }

    /// Finds the partners and the cost.
    fn pair_ends(&mut self) {
        (0..self.nodes.len() as u32).for_each(|t| self.set_partner(t, t));
        let mut swaps = 0;
        for t in 0..self.nodes.len() as u32 {
            if self.degree(t) == 2 || self.partner(t) != t {
                continue;
            }
            let mut end = t;
            let mut edge = self.mask(t).trailing_zeros();
            while edge < 3 {
                let link = 4 * end + edge;
                swaps += self.swap_at(link);
                let twin = self.twin(link);
                end = twin / 4;
                edge = (self.mask(end) & !(1 << (twin % 4))).trailing_zeros();
            }
            swaps += self.start_swap(t, end);
            self.set_partner(t, end);
            self.set_partner(end, t);
            self.strips += 1;
        }
        self.cost = self.strips.cast_signed() as i64 * i64::from(self.prices.strip)
            + i64::from(swaps) * i64::from(self.prices.swap);
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes.len()
    }

    /// What the strips cost beyond one index a triangle.
    pub(crate) fn cost(&self) -> i64 {
        self.cost
    }

    pub(crate) fn strip_count(&self) -> usize {
        self.strips
    }

    pub(crate) fn prices(&self) -> Prices {
        self.prices
    }

    /// Ends among 64 triangles, a bit each.
    #[inline]
    pub(crate) fn ends_of(&self, block: usize) -> u64 {
        self.ends[block]
    }

    /// The edges over which a triangle is linked, a bit each.
    #[inline]
    pub(crate) fn mask(&self, t: u32) -> u32 {
        self.nodes[t as usize].state & EDGES
    }

    #[inline]
    pub(crate) fn degree(&self, t: u32) -> u32 {
        self.mask(t).count_ones()
    }

    /// The other end of the path that ends at a triangle.
    #[inline]
    pub(crate) fn partner(&self, end: u32) -> u32 {
        self.nodes[end as usize].state >> 3
    }

    #[inline]
    pub(crate) fn twin(&self, half_edge: u32) -> u32 {
        self.nodes[half_edge as usize / 4].twins[half_edge as usize % 4]
    }

    #[inline]
    fn set_partner(&mut self, end: u32, other: u32) {
        let state = &mut self.nodes[end as usize].state;
        *state = *state & EDGES | other << 3;
    }

    /// The swap on a link.
    #[inline]
    fn swap_at(&self, link: u32) -> i32 {
        let twin = self.twin(link);
        is_swap(turn(self.mask(link / 4), link % 4), turn(self.mask(twin / 4), twin % 4))
    }

    /// The swap on the other link of the triangle that a link leaves.
    #[inline]
    fn swap_behind(&self, link: u32) -> i32 {
        let behind = (self.mask(link / 4) & !(1 << (link % 4))).trailing_zeros();
        if behind < 3 { self.swap_at(link & !3 | behind) } else { 0 }
    }

    /// Tells whether a strip from this end begins with the turn that takes a swap.
    #[inline]
    fn begins_wrong(&self, end: u32) -> bool {
        let edge = self.mask(end).trailing_zeros();
        if edge > 2 {
            return false;
        }
        let twin = self.nodes[end as usize].twins[edge as usize];
        turn(self.mask(twin / 4), twin % 4) == 1
    }

    /// The swap at the start of the path between two ends.
    #[inline]
    pub(crate) fn start_swap(&self, end: u32, other: u32) -> i32 {
        i32::from(self.begins_wrong(end) && self.begins_wrong(other))
    }

    /// Links two ends of different paths. Returns by how much the cost rises; `None` where it would close a path.
    #[inline]
    pub(crate) fn join(&mut self, link: u32) -> Option<i32> {
        let twin = self.twin(link);
        let (t, u) = (link / 4, twin / 4);
        let (e, f) = (self.partner(t), self.partner(u));
        debug_assert!(self.degree(t) < 2 && self.degree(u) < 2);
        if e == u {
            return None;
        }
        let before = self.start_swap(e, t) + self.start_swap(u, f);
        self.flip(link, twin);
        self.set_partner(e, f);
        self.set_partner(f, e);
        let after =
            self.swap_at(link) + self.swap_behind(link) + self.swap_behind(twin) + self.start_swap(e, f);
        let rise = (after - before) * self.prices.swap - self.prices.strip;
        self.strips -= 1;
        self.cost += i64::from(rise);
        Some(rise)
    }

    /// Takes a link away. Returns by how much the cost rises.
    #[inline]
    pub(crate) fn cut(&mut self, link: u32) -> i32 {
        let twin = self.twin(link);
        let (t, u) = (link / 4, twin / 4);
        debug_assert!(self.mask(t) >> (link % 4) & 1 == 1);
        let (e, f) = self.ends_beyond(link, twin);
        let before =
            self.swap_at(link) + self.swap_behind(link) + self.swap_behind(twin) + self.start_swap(e, f);
        self.flip(link, twin);
        self.set_partner(e, t);
        self.set_partner(t, e);
        self.set_partner(f, u);
        self.set_partner(u, f);
        let after = self.start_swap(e, t) + self.start_swap(u, f);
        let rise = (after - before) * self.prices.swap + self.prices.strip;
        self.strips += 1;
        self.cost += i64::from(rise);
        rise
    }

    /// By how much a cut raises the cost, but for the repeats at the starts of paths.
    #[inline]
    pub(crate) fn cut_rise(&self, link: u32) -> i32 {
        let swaps = self.swap_at(link) + self.swap_behind(link) + self.swap_behind(self.twin(link));
        self.prices.strip - swaps * self.prices.swap
    }

    /// By how much it raises the cost to cut a triangle's link and to link it over `link`'s twin instead, but for the repeats at the
    /// starts of paths. The link begins at an end, and the cut at the triangle across.
    #[inline]
    pub(crate) fn graft_rise(&self, link: u32, cut: u32) -> i32 {
        let (twin, cut_twin) = (self.twin(link), self.twin(cut));
        let (w, v, a) = (link / 4, cut / 4, cut_twin / 4);
        let mask_v = self.mask(v);
        let kept = (mask_v & !(1 << (cut % 4))).trailing_zeros();
        let kept_twin = self.twin(4 * v + kept);
        let beyond_kept = turn(self.mask(kept_twin / 4), kept_twin % 4);
        let before =
            is_swap(turn(mask_v, kept), beyond_kept) + self.swap_at(cut) + self.swap_behind(cut_twin);
        let (mask_w, new_v) = (self.mask(w), 1 << (twin % 4) | 1 << kept);
        let new_w = mask_w | 1 << (link % 4);
        let inner = mask_w.trailing_zeros();
        let mut after =
            is_swap(turn(new_v, kept), beyond_kept) + is_swap(turn(new_w, link % 4), turn(new_v, twin % 4));
        if inner < 3 {
            let twin = self.twin(4 * w + inner);
            // Past the new end nothing turns.
            if twin / 4 != a {
                after += is_swap(turn(new_w, inner), turn(self.mask(twin / 4), twin % 4));
            }
        }
        (after - before) * self.prices.swap
    }

    /// Links or unlinks two triangles.
    #[inline]
    fn flip(&mut self, link: u32, twin: u32) {
        for h in [link, twin] {
            let t = h / 4;
            self.nodes[t as usize].state ^= 1 << (h % 4);
            let is_end = u64::from(self.degree(t) < 2);
            let ends = &mut self.ends[t as usize / 64];
            *ends = *ends & !(1 << (t % 64)) | is_end << (t % 64);
        }
    }

    /// The end on the side of `link` and the one on the side of `twin`: walks both ways at once, to the nearer of the two.
    #[inline]
    fn ends_beyond(&self, link: u32, twin: u32) -> (u32, u32) {
        let (mut here, mut there) = (link, twin);
        loop {
            let (t, u) = (here / 4, there / 4);
            let on_here = self.mask(t) & !(1 << (here % 4));
            if on_here == 0 {
                return (t, self.partner(t));
            }
            let on_there = self.mask(u) & !(1 << (there % 4));
            if on_there == 0 {
                return (self.partner(u), u);
            }
            here = self.nodes[t as usize].twins[on_here.trailing_zeros() as usize];
            there = self.nodes[u as usize].twins[on_there.trailing_zeros() as usize];
        }
    }

    /// Returns the triangulation and the cover of the paths; the triangulation is the one that they were made from, which stays where there are no polygons.
    pub(crate) fn to_parts<'a>(&self, triangulation: &Triangulation<'a>) -> (Triangulation<'a>, PathCover) {
        let triangulation = match self.diagonals.corners() {
            None => triangulation.clone(),
            Some(corners) => {
                let twins = self.nodes.iter().flat_map(|node| node.twins).map(by_threes).collect();
                Triangulation::from_parts(corners.to_vec(), DualGraph::from_triangle_twins(twins))
            }
        };
        (triangulation, self.to_cover())
    }

    /// The paths as a cover.
    fn to_cover(&self) -> PathCover {
        let mut cover = PathCover::isolated(self.len());
        for t in 0..self.len() as u32 {
            for e in 0..3 {
                let twin = self.nodes[t as usize].twins[e as usize];
                if self.mask(t) >> e & 1 == 1 && 4 * t + e < twin {
                    cover.link_unchecked(3 * t + e, by_threes(twin));
                }
            }
        }
        cover
    }
}
