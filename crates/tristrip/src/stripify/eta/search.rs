//! A depth-first search from one terminal, for the method `eta`. It follows alternating paths that
//! close no loop.

use super::tagged_strips::{TagLink, TaggedStrips, UndoStep};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge, OptionalId};
use crate::random::Random;
use crate::stripify::tunnel::accesses::{AccessCounter, SearchOutcome};
use crate::stripify::tunnel::path_tags::TunnelStep;

/// Limits after which a search ends without a tunnel.
#[derive(Debug, Clone, Copy)]
pub(super) struct SearchLimits {
    /// Maximum length of a tunnel, in edges.
    pub(super) length: u32,
    /// Maximum number of triangles that the paths visit.
    pub(super) threshold: u32,
    /// Maximum number of node accesses, including those by identifiers.
    pub(super) accesses: u64,
}

/// A search from one terminal.
#[derive(Debug, Default)]
pub(super) struct EtaSearch {
    /// The tunnel so far, and the data to undo each step.
    steps: Vec<TunnelStep>,
    undo_steps: Vec<UndoStep>,
    /// The steps to try, each with the number of steps before it.
    candidates: Vec<(usize, TunnelStep)>,
    /// The possible steps from the tip.
    next: Vec<TunnelStep>,
    /// Whether a path was not followed because of the length or the threshold.
    pub(super) was_cut_short: bool,
}

impl EtaSearch {
    /// Returns the tunnel that was found.
    pub(super) fn tunnel(&self) -> &[TunnelStep] {
        &self.steps
    }

    /// Searches for a tunnel. If one is found the strips are complemented, otherwise they are
    /// restored. Returns `None` and restores the strips if the search takes more accesses than the
    /// limit.
    pub(super) fn find(
        &mut self,
        (graph, cover): (&DualGraph, &PathCover),
        strips: &mut TaggedStrips,
        terminal: u32,
        limits: SearchLimits,
        random: &mut Random,
        counter: &mut AccessCounter<'_>,
    ) -> Option<SearchOutcome> {
        self.steps.clear();
        self.undo_steps.clear();
        self.candidates.clear();
        self.add_candidates((graph, cover), strips, terminal, limits.length, random);
        let (mut stepped_on, start) = (0, counter.accesses());
        let outcome = loop {
            if counter.accesses() - start > limits.accesses {
                break None;
            }
            let Some((depth, step)) = self.candidates.pop() else {
                break Some(SearchOutcome::NotFound);
            };
            if stepped_on >= limits.threshold {
                self.was_cut_short = true;
                break Some(SearchOutcome::NotFound);
            }
            stepped_on += 1;
            if !counter.count(cover) {
                break Some(SearchOutcome::Stopped);
            }
            self.back_to(depth, graph, strips);
            let Some(black) = step.black.get() else {
                strips.end(graph, step.red);
                self.steps.push(step);
                break Some(SearchOutcome::Found);
            };
            if let (Some(undo), Some(b)) = (strips.step(graph, step), graph.twin_of(black)) {
                self.steps.push(step);
                self.undo_steps.push(undo);
                self.add_candidates((graph, cover), strips, b / 3, limits.length, random);
            }
            counter.add(strips.take_accesses());
        };
        if outcome != Some(SearchOutcome::Found) {
            self.back_to(0, graph, strips);
        }
        counter.add(strips.take_accesses());
        outcome
    }

    /// Undoes the steps after the first `depth`.
    fn back_to(&mut self, depth: usize, graph: &DualGraph, strips: &mut TaggedStrips) {
        self.steps.truncate(depth);
        for undo in self.undo_steps.drain(depth..).rev() {
            strips.undo(graph, undo);
        }
    }

    /// Adds the possible steps from the tip. An end of the tunnel is tried first, the others in
    /// random order.
    fn add_candidates(
        &mut self,
        (graph, cover): (&DualGraph, &PathCover),
        strips: &TaggedStrips,
        tip: u32,
        length: u32,
        random: &mut Random,
    ) {
        self.next.clear();
        // A path of n steps has 2 n edges, and one more at its end.
        let edges = 2 * self.steps.len() as u64 + 1;
        if edges > u64::from(length) {
            self.was_cut_short = true;
            return;
        }
        let links = strips.links(tip);
        let red = (3 * tip..3 * tip + 3)
            .filter(|&h| !cover.is_linked(HalfEdge(h)) && !links.contains(&TagLink::Black(h)));
        for (red, twin) in red.filter_map(|h| Some((h, graph.twin_of(h)?))) {
            if strips.may_end(tip, twin / 3) {
                self.candidates.push((self.steps.len(), TunnelStep { red, black: OptionalId::NONE }));
                return;
            }
            if edges + 2 > u64::from(length) {
                self.was_cut_short = true;
            } else {
                let links = strips.links(twin / 3);
                let black = cover.edges(FaceId(twin / 3)).into_iter().flatten();
                let black = black.filter(|h| links.contains(&TagLink::Black(h.0)));
                self.next.extend(black.map(|h| TunnelStep { red, black: OptionalId::some(h.0) }));
            }
        }
        for i in (1..self.next.len()).rev() {
            self.next.swap(i, random.below(i + 1));
        }
        let depth = self.steps.len();
        self.candidates.extend(self.next.iter().map(|&step| (depth, step)));
    }
}
