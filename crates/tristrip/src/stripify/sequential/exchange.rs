//! Exchanges at the ends of strips: small changes of a cover, each of which lowers its cost.
//!
//! ```text
//!   w ┄┄ v ━━ a ┄┄ x      cut v–a, link w–v, and where it pays link a–x, too
//!        ┃    ┃
//!        b    c           *join*: v is an end, nothing is cut
//!                         *graft*: a is the new end in place of w; as many strips, fewer swaps
//!                         *tunnel*: a finds an end x: one strip fewer
//! ```
//! # Algorithm
//! Each end w is taken in the order of the triangles. All joins, grafts and tunnels of length three that begin there are priced
//! by the swaps on the links around them and by the strips that they save; the cheapest that keeps all paths open is done if it
//! lowers the cost, and the new end is taken next. A path stays open when the end that a piece leads to is not the one
//! that it is linked with. That is sure where the two were on strips that no exchange has mixed since; else it is found by walking
//! there, and ends farther than a limit count as unknown, so that the exchange is left.
//!
//! The tunnel is that of Stewart (2001); a graft is a rotation of Pósa (1976), also between two paths.
//!
//! # References
//! Stewart: *Tunneling for Triangle Strips in Continuous Level-of-Detail Meshes*, 2001;
//! Porcu, Scateni: *An Iterative Stripification Algorithm Based on Dual Graph Operations*, 2003.
//!
//! # Complexity
//! O(ends · walk limit) time; 4 bytes a triangle for the strip that it was on at first, and 4 a strip.

use super::{NONE, STRIP, next};
use crate::cover::PathCover;
use crate::dual::DualGraph;

/// Steps along a path to find its end, after which an exchange is left. Tuned on bunny, horse and armadillo: 64 costs 0.2 % more
/// indices, 1024 gains less than 0.1 %.
const WALK_LIMIT: u32 = 256;
/// No edge, where the edge of a triangle is named.
const OPEN: u32 = 3;

/// Does exchanges until none at an end lowers the cost; `strip_of` gives the path of each triangle. After that it goes over
/// the ends `drifts` times more, also doing exchanges that leave the cost as it is, of equals one at random. Returns by how
/// much the cost fell, as the exchanges were priced: where the pieces that a tunnel links are neighbours, one link is priced as it
/// was before, so that the tunnel may save one less.
pub(crate) fn improve(graph: &DualGraph, cover: &mut PathCover, strip_of: Vec<u32>, drifts: u32) -> u64 {
    let strip_count = strip_of.iter().max().map_or(0, |&s| s + 1);
    let parent = (0..strip_count).collect();
    let mut exchanger =
        Exchanger { twins: graph.twins(), cover, strip_of, parent, random: 0x9e37_79b9_7f4a_7c15 };
    let mut saved = 0;
    for drift in 0..=drifts {
        for t in 0..exchanger.cover.len() as u32 {
            let mut end = t;
            let mut highest_price = if drift == 0 { -1 } else { 0 };
            while exchanger.is_end(end) {
                let Some(exchange) = exchanger.best_at(end, highest_price) else { break };
                highest_price = -1;
                saved += u64::from(exchange.price.unsigned_abs());
                match exchanger.apply(&exchange) {
                    Some(new_end) => end = new_end,
                    None => break,
                }
            }
        }
    }
    saved
}

/// One change: link over `link`; before, cut over `cut`; after, link over `join`.
#[derive(Debug, Clone, Copy)]
struct Exchange {
    link: u32,
    cut: Option<u32>,
    join: Option<u32>,
    /// By how much the cost rises.
    price: i32,
}

struct Exchanger<'a> {
    twins: &'a [u32],
    cover: &'a mut PathCover,
    /// The strip that each triangle was on at first.
    strip_of: Vec<u32>,
    /// Strips that exchanges have mixed: triangles whose strips have different roots are on different paths.
    parent: Vec<u32>,
    /// State of a xorshift generator.
    random: u64,
}

impl Exchanger<'_> {
    /// The edges over which a triangle is linked.
    #[inline]
    fn edges(&self, t: u32) -> (u32, u32) {
        self.cover.packed_edges(t)
    }

    #[inline]
    fn is_end(&self, t: u32) -> bool {
        let (a, b) = self.edges(t);
        a == OPEN || b == OPEN
    }

    /// The one edge over which an end is linked, or `OPEN`.
    #[inline]
    fn inner(&self, end: u32) -> u32 {
        let (a, b) = self.edges(end);
        if a == OPEN { b } else { a }
    }

    /// The other edge over which a triangle is linked.
    #[inline]
    fn other(&self, t: u32, edge: u32) -> u32 {
        let (a, b) = self.edges(t);
        if a == edge { b } else { a }
    }

    /// The swap on a link: 1 where the two triangles turn to the same side, each given its edge other than the link.
    #[inline]
    fn swap(&self, link: u32, here: u32, there: u32) -> i32 {
        if here == OPEN || there == OPEN {
            return 0;
        }
        let entry = self.twins[link as usize] % 3;
        i32::from((link % 3 == next(here)) == (there == next(entry)))
    }

    /// The swap on the link of `t` over `edge`, were `other` its other edge.
    #[inline]
    fn swap_with(&self, t: u32, edge: u32, other: u32) -> i32 {
        if edge == OPEN {
            return 0;
        }
        let link = 3 * t + edge;
        let twin = self.twins[link as usize];
        self.swap(link, other, self.other(twin / 3, twin % 3))
    }

    /// The end of the path that leaves `t` over `edge`; `t` itself where it does not go on. `None` where it is too far.
    #[inline]
    fn end_beyond(&self, mut t: u32, mut edge: u32) -> Option<u32> {
        for _ in 0..WALK_LIMIT {
            if edge == OPEN {
                return Some(t);
            }
            let twin = self.twins[(3 * t + edge) as usize];
            t = twin / 3;
            edge = self.other(t, twin % 3);
        }
        None
    }

    /// The root of a triangle's strip.
    #[inline]
    fn root(&mut self, t: u32) -> u32 {
        let mut strip = self.strip_of[t as usize];
        while self.parent[strip as usize] != strip {
            let up = self.parent[self.parent[strip as usize] as usize];
            self.parent[strip as usize] = up;
            strip = up;
        }
        strip
    }

    /// The cheapest exchange at an end, of those that lower the cost and keep every path open.
    fn best_at(&mut self, w: u32, highest_price: i32) -> Option<Exchange> {
        let inner_w = self.inner(w);
        let root_w = self.root(w);
        let mut best: Option<Exchange> = None;
        let mut best_price = highest_price + 1;
        let mut equals = 0;
        for edge_w in (0..3).filter(|&e| e != inner_w) {
            let link = 3 * w + edge_w;
            let twin = self.twins[link as usize];
            if twin == NONE {
                continue;
            }
            let (v, edge_v) = (twin / 3, twin % 3);
            let at_w = self.swap_with(w, inner_w, edge_w);
            if self.is_end(v) {
                let inner_v = self.inner(v);
                let price = at_w + self.swap(link, inner_w, inner_v) + self.swap_with(v, inner_v, edge_v)
                    - STRIP.cast_signed();
                let apart = |this: &mut Self| this.root(v) != root_w;
                if self.beats(price, best_price, highest_price, &mut equals)
                    && (apart(self) || self.end_beyond(w, inner_w).is_some_and(|end| end != v))
                {
                    best = Some(Exchange { link, cut: None, join: None, price });
                    best_price = price;
                }
                continue;
            }
            let (first, second) = self.edges(v);
            for (cut_edge, kept) in [(first, second), (second, first)] {
                let cut = 3 * v + cut_edge;
                let (a, edge_a) = (self.twins[cut as usize] / 3, self.twins[cut as usize] % 3);
                let beyond_a = self.other(a, edge_a);
                let before = self.swap_with(v, kept, cut_edge)
                    + self.swap(cut, kept, beyond_a)
                    + self.swap_with(a, beyond_a, edge_a);
                let grafted =
                    at_w + self.swap(link, inner_w, kept) + self.swap_with(v, kept, edge_v) - before;
                // `a` itself cannot be linked with: it would have nothing left to leave over.
                if a == w {
                    continue;
                }
                if self.beats(grafted, best_price, highest_price, &mut equals)
                    && (self.root(v) != root_w || self.end_beyond(v, kept).is_some_and(|end| end != w))
                {
                    best = Some(Exchange { link, cut: Some(cut), join: None, price: grafted });
                    best_price = grafted;
                }
                for edge_x in (0..3).filter(|&e| e != edge_a && e != beyond_a) {
                    let join = 3 * a + edge_x;
                    let twin = self.twins[join as usize];
                    if twin == NONE || !self.is_end(twin / 3) || twin / 3 == w {
                        continue;
                    }
                    let (x, entry) = (twin / 3, twin % 3);
                    let inner_x = self.inner(x);
                    let price = grafted
                        + self.swap_with(a, beyond_a, edge_x)
                        + self.swap(join, beyond_a, inner_x)
                        + self.swap_with(x, inner_x, entry)
                        - STRIP.cast_signed();
                    if self.beats(price, best_price, highest_price, &mut equals)
                        && self.tunnel_is_open(w, (v, kept), (a, beyond_a), x)
                    {
                        best = Some(Exchange { link, cut: Some(cut), join: Some(join), price });
                        best_price = price;
                    }
                }
            }
        }
        best
    }

    /// Tells whether a price is lower than the best, or as low as it and drawn by lot where prices may be equal.
    #[inline]
    fn beats(&mut self, price: i32, best: i32, highest: i32, equals: &mut u64) -> bool {
        if price < best || highest < 0 {
            *equals = 1;
            return price < best;
        }
        if price > best.min(highest) {
            return false;
        }
        *equals += 1;
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        self.random.is_multiple_of(*equals)
    }

    /// Tells whether a tunnel closes no path: v's piece and a's piece are what the cut between them leaves.
    fn tunnel_is_open(&mut self, w: u32, v: (u32, u32), a: (u32, u32), x: u32) -> bool {
        let root_v = self.root(v.0);
        if self.root(w) != root_v && self.root(x) != root_v {
            return true;
        }
        let (Some(end_v), Some(end_a)) = (self.end_beyond(v.0, v.1), self.end_beyond(a.0, a.1)) else {
            return false;
        };
        // w–v closes v's piece, a–x closes a's piece, or both together close the one path that there was.
        end_v != w && end_a != x && !(end_a == w && end_v == x)
    }

    /// Does an exchange. Gives the new end, if there is one.
    fn apply(&mut self, exchange: &Exchange) -> Option<u32> {
        let touched = [exchange.join, exchange.cut].into_iter().flatten().map(|h| self.twins[h as usize] / 3);
        for t in touched.chain([self.twins[exchange.link as usize] / 3]) {
            let (a, b) = (self.root(t), self.root(exchange.link / 3));
            self.parent[a.max(b) as usize] = a.min(b);
        }
        let mut new_end = None;
        if let Some(cut) = exchange.cut {
            let twin = self.twins[cut as usize];
            self.cover.cut_unchecked(cut, twin);
            new_end = Some(twin / 3);
        }
        self.cover.link_unchecked(exchange.link, self.twins[exchange.link as usize]);
        if let Some(join) = exchange.join {
            self.cover.link_unchecked(join, self.twins[join as usize]);
            new_end = None;
        }
        new_end
    }
}
