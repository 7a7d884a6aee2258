//! A path cover that keeps its cost and the ends of its paths up to date. Searches that change the
//! cover at path ends use it.
//!
//! ```text
//!   e ━━ ∙ ━━ t ┄┄ u ━━ ∙ ━━ f       each end stores the other end of its path. Joining t–u
//!                                    pairs e with f; cutting it pairs e with t and u with f.
//! ```
//! There are two elementary moves, *join* and *cut*. Each returns the exact cost increase. The
//! increase includes the swaps on the link and on the adjacent links, the price of a strip, and the
//! repeats at the starts of the affected paths. All other moves are composed of these two, and are
//! undone by the inverse moves in reverse order.
//!
//! A cut walks to the nearer end of its path. This walk is long if one strip covers the whole mesh.
//! A search therefore limits the total number of steps of its walks. Once these steps are used up,
//! the search can cut only near the ends of paths.
//!
//! # Complexity
//! 16 bytes and one bit per triangle. A join takes O(1), and so does undoing it. A cut takes as
//! many steps as the distance to the nearer end of its path.

mod dynamic;
mod flips;

use super::PathCover;
use super::diagonals::{Diagonals, to_graph_half_edge, to_path_half_edge};
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::mesh::Faces;

/// Marks a half-edge without a twin, in the packed nodes only: [`PricedPaths::twin`] returns an
/// `Option`.
const NO_TWIN: u32 = u32::MAX;
/// The bits of a node's state that store the linked edges. The other bits store its partner.
const EDGES: u32 = 7;
/// Steps that a walk may always take.
const SHORT_WALK: u64 = 16;
/// Maximum number of triangles: a triangle's index and its edges share 32 bits.
pub(crate) const TRIANGLE_LIMIT: usize = 1 << 29;

/// A triangle. Half-edges have stride 4 here: edge e of triangle t is 4 t + e.
#[derive(Debug, Clone, Copy)]
struct PathNode {
    twins: [u32; 3],
    /// The linked edges and, at an end, the other end of the path.
    state: u32,
}

/// The prices of a strip and of a swap, in indices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct StripPrices {
    pub(crate) strip: i32,
    pub(crate) swap: i32,
}

/// Paths over triangles and their cost.
#[derive(Debug, Clone)]
pub(crate) struct PricedPaths {
    nodes: Vec<PathNode>,
    diagonals: Diagonals,
    /// One bit per triangle: whether it is linked over fewer than two edges.
    ends: Vec<u64>,
    prices: StripPrices,
    strips: usize,
    /// The cost of the strips in addition to one index per triangle.
    cost: i64,
    /// Remaining steps of the walks of a search.
    walk_steps: u64,
}

/// The turn of a path in a triangle, by the mask of its linked edges (3 bits) and the edge of entry
/// (2 bits): 1 if the path leaves over the next edge, 2 for the previous edge, 0 if it ends.
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

/// Returns the turn of a path that enters a triangle over `edge`. `mask` contains the linked edges
/// of the triangle.
#[inline]
pub(crate) fn turn(mask: u32, edge: u32) -> u8 {
    TURNS[((mask & EDGES) << 2 | edge & 3) as usize]
}

/// Returns 1 if a path across a link needs a swap, otherwise 0. `here` and `there` are the turns on
/// the two sides of the link, each seen from the link. A path needs a swap if it turns left twice
/// or right twice in a row.
#[inline]
pub(crate) fn is_swap(here: u8, there: u8) -> i32 {
    i32::from(here ^ there == 3)
}

impl PricedPaths {
    /// Returns the size of the paths in memory, in bytes, without diagonals; triangle meshes have
    /// none.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.ends[..])
    }

    /// Creates the paths of a cover.
    pub(crate) fn new(
        faces: &Faces,
        triangulation: &Triangulation<'_>,
        cover: &PathCover,
        prices: StripPrices,
    ) -> Self {
        let graph = triangulation.graph();
        let twin = |h: u32| graph.twin_of(h).map_or(NO_TWIN, to_path_half_edge);
        let nodes = (0..graph.face_count() as u32)
            .map(|t| PathNode { twins: [twin(3 * t), twin(3 * t + 1), twin(3 * t + 2)], state: 0 });
        let mut paths = Self {
            nodes: nodes.collect(),
            diagonals: Diagonals::new(faces, triangulation),
            ends: vec![0; cover.len() / 64 + 1],
            prices,
            strips: 0,
            cost: 0,
            walk_steps: 0,
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

    /// Computes the partners and the cost.
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
                let twin = self.across(link);
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

    /// Returns the cost of the strips in addition to one index per triangle.
    pub(crate) fn cost(&self) -> i64 {
        self.cost
    }

    pub(crate) fn strip_count(&self) -> usize {
        self.strips
    }

    pub(crate) fn prices(&self) -> StripPrices {
        self.prices
    }

    /// Returns which of the 64 triangles of a block are ends, one bit per triangle.
    #[inline]
    pub(crate) fn ends_of(&self, block: usize) -> u64 {
        self.ends[block]
    }

    /// Returns the edges over which a triangle is linked, one bit per edge.
    #[inline]
    pub(crate) fn mask(&self, t: u32) -> u32 {
        self.nodes[t as usize].state & EDGES
    }

    #[inline]
    pub(crate) fn degree(&self, t: u32) -> u32 {
        self.mask(t).count_ones()
    }

    /// Returns whether a path crosses a half-edge.
    #[inline]
    pub(crate) fn is_linked(&self, half_edge: u32) -> bool {
        self.mask(half_edge / 4) >> (half_edge % 4) & 1 == 1
    }

    /// Returns the other end of the path that ends at a triangle.
    #[inline]
    pub(crate) fn partner(&self, end: u32) -> u32 {
        self.nodes[end as usize].state >> 3
    }

    /// Returns the twin of a half-edge, or `None` at a boundary.
    #[inline]
    pub(crate) fn twin(&self, half_edge: u32) -> Option<u32> {
        let twin = self.packed_twin(half_edge);
        (twin != NO_TWIN).then_some(twin)
    }

    /// Returns the twin of a half-edge that is not at a boundary: a link or a diagonal.
    #[inline]
    pub(crate) fn across(&self, half_edge: u32) -> u32 {
        let twin = self.packed_twin(half_edge);
        debug_assert_ne!(twin, NO_TWIN, "a boundary");
        twin
    }

    #[inline]
    fn packed_twin(&self, half_edge: u32) -> u32 {
        self.nodes[half_edge as usize / 4].twins[half_edge as usize % 4]
    }

    #[inline]
    fn set_partner(&mut self, end: u32, other: u32) {
        let state = &mut self.nodes[end as usize].state;
        *state = *state & EDGES | other << 3;
    }

    /// Returns the number of swaps on a link: 0 or 1.
    #[inline]
    fn swap_at(&self, link: u32) -> i32 {
        let twin = self.across(link);
        is_swap(turn(self.mask(link / 4), link % 4), turn(self.mask(twin / 4), twin % 4))
    }

    /// Returns the number of swaps, 0 or 1, on the other link of the triangle at which `link`
    /// starts.
    #[inline]
    fn swap_behind(&self, link: u32) -> i32 {
        let behind = (self.mask(link / 4) & !(1 << (link % 4))).trailing_zeros();
        if behind < 3 { self.swap_at(link & !3 | behind) } else { 0 }
    }

    /// Returns whether the first turn of a strip from this end requires a swap.
    #[inline]
    fn begins_with_swap(&self, end: u32) -> bool {
        let edge = self.mask(end).trailing_zeros();
        if edge > 2 {
            return false;
        }
        let twin = self.nodes[end as usize].twins[edge as usize];
        turn(self.mask(twin / 4), twin % 4) == 1
    }

    /// Returns the number of swaps, 0 or 1, at the start of the path between two ends.
    #[inline]
    pub(crate) fn start_swap(&self, end: u32, other: u32) -> i32 {
        i32::from(self.begins_with_swap(end) && self.begins_with_swap(other))
    }

    /// Links two ends of different paths. Returns the cost increase, or `None` if the link would
    /// close a path.
    #[inline]
    pub(crate) fn join(&mut self, link: u32) -> Option<i32> {
        let twin = self.across(link);
        let (t, u) = (link / 4, twin / 4);
        let (e, f) = (self.partner(t), self.partner(u));
        debug_assert!(self.degree(t) < 2 && self.degree(u) < 2);
        if e == u {
            return None;
        }
        let before = self.start_swap(e, t) + self.start_swap(u, f);
        self.toggle_link(link, twin);
        self.set_partner(e, f);
        self.set_partner(f, e);
        let after =
            self.swap_at(link) + self.swap_behind(link) + self.swap_behind(twin) + self.start_swap(e, f);
        let rise = (after - before) * self.prices.swap - self.prices.strip;
        self.strips -= 1;
        self.cost += i64::from(rise);
        Some(rise)
    }

    /// Sets the steps that the walks of a search may take in total.
    pub(crate) fn allow_walks(&mut self, steps: u64) {
        self.walk_steps = steps;
    }

    /// Adds steps to those that the walks of a search may still take, up to a maximum of `most`.
    pub(crate) fn allow_more_walks(&mut self, steps: u64, most: u64) {
        self.walk_steps = self.walk_steps.saturating_add(steps).min(most);
    }

    /// Returns the outer ends of the two paths that a join across `link` would link. The first end
    /// is on the side of `link`. [`PricedPaths::cut_between`] needs both ends to undo the join.
    #[inline]
    pub(crate) fn outer_ends(&self, link: u32) -> [u32; 2] {
        [link, self.across(link)].map(|h| self.partner(h / 4))
    }

    /// Removes a link. Returns the cost increase.
    #[inline]
    pub(crate) fn cut(&mut self, link: u32) -> i32 {
        let ends = self.ends_beyond(link, &mut u64::MAX.clone());
        ends.map_or(0, |ends| self.cut_between(link, ends))
    }

    /// Removes a link within the step limit of a search. Returns the cost increase, or `None` if
    /// both ends are too far away.
    #[inline]
    pub(crate) fn try_cut(&mut self, link: u32) -> Option<i32> {
        let mut steps = self.walk_steps.max(SHORT_WALK);
        let before = steps;
        let ends = self.ends_beyond(link, &mut steps);
        self.walk_steps = self.walk_steps.saturating_sub(before - steps);
        ends.map(|ends| self.cut_between(link, ends))
    }

    /// Removes a link between two known ends. The first end is on the side of `link`. Returns the
    /// cost increase.
    #[inline]
    pub(crate) fn cut_between(&mut self, link: u32, [e, f]: [u32; 2]) -> i32 {
        let twin = self.across(link);
        let (t, u) = (link / 4, twin / 4);
        debug_assert!(self.mask(t) >> (link % 4) & 1 == 1);
        let before =
            self.swap_at(link) + self.swap_behind(link) + self.swap_behind(twin) + self.start_swap(e, f);
        self.toggle_link(link, twin);
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

    /// Returns the cost increase of a cut, without the repeats at the starts of paths.
    #[inline]
    pub(crate) fn cut_rise(&self, link: u32) -> i32 {
        let swaps = self.swap_at(link) + self.swap_behind(link) + self.swap_behind(self.across(link));
        self.prices.strip - swaps * self.prices.swap
    }

    /// Returns the cost increase of a rotation that replaces a triangle's link over `cut` by a link
    /// over the twin of `link`, without the repeats at the starts of paths. `link` starts at an
    /// end, and `cut` starts at the triangle on the other side.
    #[inline]
    pub(crate) fn rotation_rise(&self, link: u32, cut: u32) -> i32 {
        let (twin, cut_twin) = (self.across(link), self.across(cut));
        let (w, v, a) = (link / 4, cut / 4, cut_twin / 4);
        let mask_v = self.mask(v);
        let kept = (mask_v & !(1 << (cut % 4))).trailing_zeros();
        let kept_twin = self.across(4 * v + kept);
        let beyond_kept = turn(self.mask(kept_twin / 4), kept_twin % 4);
        let before =
            is_swap(turn(mask_v, kept), beyond_kept) + self.swap_at(cut) + self.swap_behind(cut_twin);
        let (mask_w, new_v) = (self.mask(w), 1 << (twin % 4) | 1 << kept);
        let new_w = mask_w | 1 << (link % 4);
        let inner = mask_w.trailing_zeros();
        let mut after =
            is_swap(turn(new_v, kept), beyond_kept) + is_swap(turn(new_w, link % 4), turn(new_v, twin % 4));
        if inner < 3 {
            let twin = self.across(4 * w + inner);
            // The new end has no turn.
            if twin / 4 != a {
                after += is_swap(turn(new_w, inner), turn(self.mask(twin / 4), twin % 4));
            }
        }
        (after - before) * self.prices.swap
    }

    /// Links or unlinks two triangles.
    #[inline]
    fn toggle_link(&mut self, link: u32, twin: u32) {
        for h in [link, twin] {
            let t = h / 4;
            self.nodes[t as usize].state ^= 1 << (h % 4);
            let is_end = u64::from(self.degree(t) < 2);
            let ends = &mut self.ends[t as usize / 64];
            *ends = *ends & !(1 << (t % 64)) | is_end << (t % 64);
        }
    }

    /// Returns the path's end on the side of `link` and the end on the side of its twin. Walks in
    /// both directions at once up to the nearer end, and counts down the steps. Returns `None` if
    /// no steps are left.
    #[inline]
    fn ends_beyond(&self, link: u32, steps: &mut u64) -> Option<[u32; 2]> {
        let (mut here, mut there) = (link, self.across(link));
        loop {
            let (t, u) = (here / 4, there / 4);
            let on_here = self.mask(t) & !(1 << (here % 4));
            if on_here == 0 {
                return Some([t, self.partner(t)]);
            }
            let on_there = self.mask(u) & !(1 << (there % 4));
            if on_there == 0 {
                return Some([self.partner(u), u]);
            }
            *steps = steps.checked_sub(1)?;
            here = self.nodes[t as usize].twins[on_here.trailing_zeros() as usize];
            there = self.nodes[u as usize].twins[on_there.trailing_zeros() as usize];
        }
    }

    /// Returns the triangulation and the cover of the paths. Without polygons, the triangulation is
    /// the original one.
    pub(crate) fn to_parts<'a>(&self, triangulation: &Triangulation<'a>) -> (Triangulation<'a>, PathCover) {
        let triangulation = match self.diagonals.corners() {
            None => triangulation.clone(),
            Some(corners) => {
                let half_edges = (0..self.nodes.len() as u32).flat_map(|t| 4 * t..4 * t + 3);
                let twins = half_edges.map(|h| self.twin(h).map(to_graph_half_edge));
                Triangulation::from_parts(corners.to_vec(), DualGraph::of_triangle_twins(twins))
            }
        };
        (triangulation, self.to_cover())
    }

    /// Returns the paths as a cover.
    fn to_cover(&self) -> PathCover {
        let mut cover = PathCover::isolated(self.len());
        for t in 0..self.len() as u32 {
            for e in 0..3 {
                let is_linked = self.mask(t) >> e & 1 == 1;
                if is_linked && 4 * t + e < self.across(4 * t + e) {
                    cover.link_unchecked(3 * t + e, to_graph_half_edge(self.across(4 * t + e)));
                }
            }
        }
        cover
    }
}
