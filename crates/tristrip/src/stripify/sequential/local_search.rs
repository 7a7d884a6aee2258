//! Local search at the ends of strips: small moves that lower the cost of a cover.
//!
//! ```text
//!   w ┄┄ v ━━ a ┄┄ x      cut v–a, link w–v, and link a–x too if it saves a strip
//!        ┃    ┃
//!        b    c           *join*: v is an end; nothing is cut
//!                         *rotation*: a is an end instead of w; as many strips, fewer swaps
//!                         *tunnel*: a has a neighbour x that is an end: one strip fewer
//! ```
//! # Algorithm
//! The ends w are processed in the order of their triangles. All joins, rotations and tunnels of
//! length three that start at w are priced by the swaps on the surrounding links and the strips
//! that they save. The cheapest move that leaves all paths open is applied if it lowers the cost.
//! Then the new end is processed. The part that a move cuts off contains an end of a path. The path
//! remains open if the part is linked to a different end. This is certain if the part and that end
//! were on different initial strips that no move has mixed since. Otherwise the search walks along
//! the part to find its end. Beyond a limit of steps, the end counts as unknown and the move is
//! rejected.
//!
//! The tunnel is the operator of Stewart (2001). The rotation of Pósa (1976) is extended to two
//! paths.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001;
//! Porcu, Scateni: *An Iterative Stripification Algorithm Based on Dual Graph Operations*, 2003.
//!
//! # Complexity
//! O(ends · walk limit) time. 4 bytes per triangle for its initial strip, and 4 per strip.

use super::edge::next;
use super::policy::STRIP_COST;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::random::Random;
use crate::strip::OPEN;
use crate::union_find::UnionFind;

/// Maximum number of steps of a walk to the end of a path, beyond which a move is rejected. Tuned
/// on bunny, horse and armadillo: 64 costs 0.2 % more indices, and 1024 saves less than 0.1 %.
const WALK_LIMIT: u32 = 256;

/// The seed of the choices between equal moves.
const SEED: u64 = 0;

/// Applies moves until none lowers the cost at any end. `strip_of` is the path of each triangle.
/// Then runs plateau passes, which also apply zero-gain moves and choose at random among equal
/// ones. Returns the reduction of the cost according to the prices of the moves. If the two parts
/// that a tunnel links are neighbours, one link is priced as before the move, and the tunnel may
/// save one less.
pub(super) fn improve(
    graph: &DualGraph,
    cover: &mut PathCover,
    strip_of: Vec<u32>,
    plateau_passes: u32,
) -> u64 {
    let strip_count = strip_of.iter().max().map_or(0, |&s| s as usize + 1);
    let mixed = UnionFind::new(strip_count);
    let mut search = EndSearch { graph, cover, strip_of, mixed, random: Random::new(SEED) };
    let mut saved = 0;
    for pass in 0..=plateau_passes {
        for t in 0..search.cover.len() as u32 {
            let mut end = t;
            let mut highest_price = if pass == 0 { -1 } else { 0 };
            while search.is_end(end) {
                let Some(best) = search.best_move(end, highest_price) else { break };
                highest_price = -1;
                saved += u64::from(best.price.unsigned_abs());
                match search.apply(&best) {
                    Some(new_end) => end = new_end,
                    None => break,
                }
            }
        }
    }
    saved
}

/// One move: cuts a path at edge `cut`, then links across `link` and across `join`.
#[derive(Debug, Clone, Copy)]
struct StripMove {
    link: u32,
    cut: Option<u32>,
    join: Option<u32>,
    /// The increase of the cost.
    price: i32,
}

struct EndSearch<'a> {
    graph: &'a DualGraph,
    cover: &'a mut PathCover,
    /// The initial strip of each triangle.
    strip_of: Vec<u32>,
    /// Strips that moves have mixed. Triangles whose strips are in different sets are on different
    /// paths.
    mixed: UnionFind,
    random: Random,
}

impl EndSearch<'_> {
    /// Returns the edges over which a triangle is linked.
    #[inline]
    fn edges(&self, t: u32) -> (u32, u32) {
        self.cover.packed_edges(t)
    }

    #[inline]
    fn is_end(&self, t: u32) -> bool {
        let (a, b) = self.edges(t);
        a == OPEN || b == OPEN
    }

    /// Returns the edge over which an end is linked, or `OPEN` for an isolated triangle.
    #[inline]
    fn linked_edge(&self, end: u32) -> u32 {
        let (a, b) = self.edges(end);
        if a == OPEN { b } else { a }
    }

    /// Returns the other edge over which a triangle is linked.
    #[inline]
    fn other(&self, t: u32, edge: u32) -> u32 {
        let (a, b) = self.edges(t);
        if a == edge { b } else { a }
    }

    /// Returns the twin of a half-edge that must have one, because a link or a move crosses it.
    #[inline]
    fn across(&self, half_edge: u32) -> u32 {
        self.graph.twins()[half_edge as usize]
    }

    /// Returns the number of swaps on a link: 1 if the path makes the same turn in both triangles,
    /// otherwise 0. `here` and `there` are the other linked edges of the two triangles.
    #[inline]
    fn swap(&self, link: u32, here: u32, there: u32) -> i32 {
        if here == OPEN || there == OPEN {
            return 0;
        }
        let entry = self.across(link) % 3;
        i32::from((link % 3 == next(here)) == (there == next(entry)))
    }

    /// Returns the number of swaps on the link of `t` over `edge` if the other linked edge of `t`
    /// were `other`.
    #[inline]
    fn swap_with(&self, t: u32, edge: u32, other: u32) -> i32 {
        if edge == OPEN {
            return 0;
        }
        let link = 3 * t + edge;
        let twin = self.across(link);
        self.swap(link, other, self.other(twin / 3, twin % 3))
    }

    /// Returns the end of the path that leaves `t` over `edge`. Returns `t` itself if `edge` is
    /// `OPEN`, and `None` beyond the walk limit.
    #[inline]
    fn end_beyond(&self, mut t: u32, mut edge: u32) -> Option<u32> {
        for _ in 0..WALK_LIMIT {
            if edge == OPEN {
                return Some(t);
            }
            let twin = self.across(3 * t + edge);
            t = twin / 3;
            edge = self.other(t, twin % 3);
        }
        None
    }

    /// Returns the set of mixed strips of a triangle.
    #[inline]
    fn root(&mut self, t: u32) -> u32 {
        self.mixed.find(self.strip_of[t as usize])
    }

    /// Returns the cheapest move at an end that costs at most `highest_price` and leaves every path
    /// open.
    fn best_move(&mut self, w: u32, highest_price: i32) -> Option<StripMove> {
        let inner_w = self.linked_edge(w);
        let root_w = self.root(w);
        let mut best: Option<StripMove> = None;
        let mut best_price = highest_price + 1;
        let mut equals = 0;
        for edge_w in (0..3).filter(|&e| e != inner_w) {
            let link = 3 * w + edge_w;
            let Some(twin) = self.graph.twin_of(link) else { continue };
            let (v, edge_v) = (twin / 3, twin % 3);
            let at_w = self.swap_with(w, inner_w, edge_w);
            if self.is_end(v) {
                let inner_v = self.linked_edge(v);
                let price = at_w + self.swap(link, inner_w, inner_v) + self.swap_with(v, inner_v, edge_v)
                    - STRIP_COST.cast_signed();
                let on_other_path = |this: &mut Self| this.root(v) != root_w;
                if self.beats(price, best_price, highest_price, &mut equals)
                    && (on_other_path(self) || self.end_beyond(w, inner_w).is_some_and(|end| end != v))
                {
                    best = Some(StripMove { link, cut: None, join: None, price });
                    best_price = price;
                }
                continue;
            }
            let (first, second) = self.edges(v);
            for (cut_edge, kept) in [(first, second), (second, first)] {
                let cut = 3 * v + cut_edge;
                let (a, edge_a) = (self.across(cut) / 3, self.across(cut) % 3);
                let beyond_a = self.other(a, edge_a);
                let before = self.swap_with(v, kept, cut_edge)
                    + self.swap(cut, kept, beyond_a)
                    + self.swap_with(a, beyond_a, edge_a);
                let rotated =
                    at_w + self.swap(link, inner_w, kept) + self.swap_with(v, kept, edge_v) - before;
                // Linking to `a` itself is impossible: no edge would be left to leave it.
                if a == w {
                    continue;
                }
                if self.beats(rotated, best_price, highest_price, &mut equals)
                    && (self.root(v) != root_w || self.end_beyond(v, kept).is_some_and(|end| end != w))
                {
                    best = Some(StripMove { link, cut: Some(cut), join: None, price: rotated });
                    best_price = rotated;
                }
                for edge_x in (0..3).filter(|&e| e != edge_a && e != beyond_a) {
                    let join = 3 * a + edge_x;
                    let Some(twin) = self.graph.twin_of(join) else { continue };
                    let (x, entry) = (twin / 3, twin % 3);
                    if !self.is_end(x) || x == w {
                        continue;
                    }
                    let inner_x = self.linked_edge(x);
                    let price = rotated
                        + self.swap_with(a, beyond_a, edge_x)
                        + self.swap(join, beyond_a, inner_x)
                        + self.swap_with(x, inner_x, entry)
                        - STRIP_COST.cast_signed();
                    if self.beats(price, best_price, highest_price, &mut equals)
                        && self.tunnel_is_open(w, (v, kept), (a, beyond_a), x)
                    {
                        best = Some(StripMove { link, cut: Some(cut), join: Some(join), price });
                        best_price = price;
                    }
                }
            }
        }
        best
    }

    /// Returns whether a price is lower than the best. A price equal to the best is accepted at
    /// random if equal prices are allowed.
    #[inline]
    fn beats(&mut self, price: i32, best: i32, highest: i32, equals: &mut usize) -> bool {
        if price < best || highest < 0 {
            *equals = 1;
            return price < best;
        }
        if price > best.min(highest) {
            return false;
        }
        *equals += 1;
        self.random.below(*equals) == 0
    }

    /// Returns whether a tunnel closes no path. The cut between v and a leaves two parts of a path,
    /// one with v and one with a.
    fn tunnel_is_open(&mut self, w: u32, v: (u32, u32), a: (u32, u32), x: u32) -> bool {
        let root_v = self.root(v.0);
        if self.root(w) != root_v && self.root(x) != root_v {
            return true;
        }
        let (Some(end_v), Some(end_a)) = (self.end_beyond(v.0, v.1), self.end_beyond(a.0, a.1)) else {
            return false;
        };
        // w–v closes the part of v, a–x closes the part of a, or both together close what was one
        // path.
        end_v != w && end_a != x && !(end_a == w && end_v == x)
    }

    /// Applies a move. Returns the new end, if there is one.
    fn apply(&mut self, strip_move: &StripMove) -> Option<u32> {
        let StripMove { link, cut, join, .. } = *strip_move;
        for half_edge in [join, cut, Some(link)].into_iter().flatten() {
            let there = self.across(half_edge) / 3;
            self.mixed.unite(self.strip_of[there as usize], self.strip_of[link as usize / 3]);
        }
        let mut new_end = None;
        if let Some(cut) = cut {
            let twin = self.across(cut);
            self.cover.cut_unchecked(cut, twin);
            new_end = Some(twin / 3);
        }
        self.cover.link_unchecked(link, self.across(link));
        if let Some(join) = join {
            self.cover.link_unchecked(join, self.across(join));
            new_end = None;
        }
        new_end
    }
}
