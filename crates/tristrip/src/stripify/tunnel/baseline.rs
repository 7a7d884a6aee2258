//! The tunnelling operator, kept plain: every alternating path, the shortest first. It is what the faster searches are held against.
//!
//! # Algorithm
//! 1. Set the length to 1.
//! 2. From each terminal in turn, follow every alternating path of at most that length: over a red edge to a triangle `v`, then
//!    over one of the black edges of `v`, and so on. No edge is taken twice.
//! 3. Where a red edge leads to a terminal and no loop would be left, complement the path, and go on from that terminal.
//! 4. When no terminal has a tunnel of that length, try the next odd one, up to the limit, if some path is that long.
//!
//! When it ends there is no tunnel up to the limit: none of any kind, for a loop that a path closes and opens again later is no
//! obstacle here. The rules of Stewart, and of Porcu and Scateni, forbid that; they are conditions on a path's every step, while
//! this looks at the pieces that it leaves in the end.
//!
//! # Complexity
//! The paths of a length grow as its exponential: two for each black edge.

use super::ids::{Ids, NONE, Pieces, Step};
use super::{Searched, Tally};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};

/// Joins paths of a cover by tunnels, until none of at most this length is left or the watch says so.
pub(super) fn join(graph: &DualGraph, cover: &mut PathCover, length: u32, tally: &mut Tally<'_>) {
    let mut ids = Ids::new(graph, cover);
    let mut search = Search::default();
    let mut limit = 1_u32;
    while limit <= length {
        let (mut found, mut cut_short) = (false, false);
        for t in 0..cover.len() as u32 {
            while cover.degree(FaceId(t)) < 2 {
                let searched = search.tunnel(graph, cover, &ids, t, limit, tally);
                cut_short |= search.was_cut_short;
                match searched {
                    Searched::Stopped => return,
                    Searched::Nothing => break,
                    Searched::Found => tally.accesses += ids.complement(graph, cover, &search.steps),
                }
                found = true;
            }
        }
        // A tunnel that was complemented may have opened a shorter one, which the next round at this limit finds. Where no path
        // came to the limit, a longer one finds nothing else.
        if !found {
            if !cut_short {
                return;
            }
            limit = limit.saturating_add(2);
        }
    }
}

/// Tells whether an edge leads to a triangle, over which no path passes.
#[inline]
pub(super) fn is_red(graph: &DualGraph, cover: &PathCover, half_edge: u32) -> bool {
    graph.twins()[half_edge as usize] != NONE && !cover.is_linked(HalfEdge(half_edge))
}

/// A search from one terminal.
#[derive(Debug, Default)]
pub(super) struct Search {
    pieces: Pieces,
    /// The tunnel so far; found, it ends with a red edge.
    pub(super) steps: Vec<Step>,
    /// The ways that are still to be tried, each with the steps before it.
    ways: Vec<(usize, Step)>,
    /// Whether a path was not followed because of the limit.
    was_cut_short: bool,
}

impl Search {
    /// Looks for a tunnel of at most `limit` edges from a terminal.
    pub(super) fn tunnel(
        &mut self,
        graph: &DualGraph,
        cover: &PathCover,
        ids: &Ids,
        terminal: u32,
        limit: u32,
        tally: &mut Tally<'_>,
    ) -> Searched {
        self.pieces.begin(ids, terminal);
        self.steps.clear();
        self.ways.clear();
        self.was_cut_short = false;
        self.push_ways(graph, cover, terminal);
        while let Some((depth, step)) = self.ways.pop() {
            if !tally.count(cover) {
                return Searched::Stopped;
            }
            while self.steps.len() > depth {
                self.steps.pop();
                self.pieces.undo();
            }
            let v = graph.twins()[step.red as usize] / 3;
            if step.black == NONE {
                if self.pieces.may_end_at(ids, v) {
                    self.steps.push(step);
                    return Searched::Found;
                }
                continue;
            }
            let b = graph.twins()[step.black as usize] / 3;
            // A path of n steps has 2 n edges, and one more at its end.
            if 2 * depth as u64 + 3 > u64::from(limit) {
                self.was_cut_short = true;
            } else if self.pieces.step(ids, v, b) {
                self.steps.push(step);
                self.push_ways(graph, cover, b);
            }
        }
        Searched::Nothing
    }

    /// Notes the ways on from a triangle.
    fn push_ways(&mut self, graph: &DualGraph, cover: &PathCover, from: u32) {
        let depth = self.steps.len();
        for red in (3 * from..3 * from + 3).filter(|&h| is_red(graph, cover, h)) {
            let twin = graph.twins()[red as usize];
            if self.steps.iter().any(|step| step.red == red || step.red == twin) {
                continue;
            }
            let v = FaceId(twin / 3);
            for black in cover.edges(v).into_iter().flatten() {
                self.ways.push((depth, Step { red, black: black.0 }));
            }
            if cover.degree(v) < 2 {
                self.ways.push((depth, Step { red, black: NONE }));
            }
        }
    }
}
