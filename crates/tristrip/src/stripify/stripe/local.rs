//! The local algorithms: a strip continues to the neighbour that has the fewest neighbours.
//!
//! # Algorithm
//! 1. A strip starts at a free face with the fewest free neighbours.
//! 2. It continues with a free neighbour of its end that has the fewest free neighbours. If there
//!    are several such neighbours, the tie rule chooses one. Unless polygons are cut in advance,
//!    all edges of the polygon are candidates.
//! 3. At a dead end the strip is reversed and grows from its start.
//!
//! [`StripRules::PUBLISHED`] is this algorithm. This library's own rules send fewer vertices:
//! - [`StripRules::absorbs_rests`]: the remainder of a polygon joins the strip if it would keep
//!   fewer than two free neighbours. A triangle with one remaining neighbour ends a strip. A
//!   triangle without neighbours is a strip and costs three vertices, while a swap costs one.
//! - [`Ties::FewestSwaps`]: if all exits need swaps, one with the fewest swaps is chosen.
//! - [`ExitRule::FewSwaps`]: swaps are weighted in the choice.
//! - [`TurnDiagonals::Together`]: whether an exit needs a swap depends on the best order of turns
//!   in all polygons passed so far, not on orders that were fixed polygon by polygon.
//!
//! # References
//! Section 3.1 of the paper; see [`super`].
//!
//! # Complexity
//! O(n) for triangles and for whole polygons, O(n log n) in the worst case where parts are cut out.

use super::polygon_triangulator::{StripFace, StripSink};
use super::queue::QueueOrder;
use super::remaining_faces::{REACH, RemainingFaces};
use super::turn_sequence::{A, B, LeastSwaps, TurnCounts, TurnDiagonals};
use crate::random::Random;
use crate::stripify::{LastTie, Ties};

/// How many more neighbours an exit may lead to before a swap is preferred, under
/// [`ExitRule::FewSwaps`]. Over eight polygon models 2 and 3 send 0.4 % fewer vertices than 1.
const SWAP_WEIGHT: u32 = 2;

/// How the exit of a strip is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ExitRule {
    /// Lowest adjacency. The inner rule breaks ties.
    Adjacency(Ties),
    /// Lowest sum of adjacency and weighted swaps. Ties go to the exit whose face has neighbours of
    /// the highest adjacency.
    FewSwaps,
}

/// The rules by which strips are built.
#[derive(Debug, Clone, Copy)]
pub(super) struct StripRules {
    pub(super) exit: ExitRule,
    /// Which exit is chosen if the look-ahead leaves several.
    pub(super) last_tie: LastTie,
    pub(super) diagonals: TurnDiagonals,
    /// Where a strip starts, among the faces with the fewest neighbours.
    pub(super) starts: QueueOrder,
    /// Whether the remainder of a polygon joins the strip if it would keep fewer than two free
    /// neighbours.
    pub(super) absorbs_rests: bool,
}

impl StripRules {
    /// The algorithm of the paper with its sequential ties.
    pub(super) const PUBLISHED: Self = Self {
        exit: ExitRule::Adjacency(Ties::Sequential),
        last_tie: LastTie::Last,
        diagonals: TurnDiagonals::Passing,
        starts: QueueOrder::FirstIn,
        absorbs_rests: false,
    };

    /// Returns the rules with other ties.
    pub(super) fn with_ties(self, ties: Ties) -> Self {
        Self { exit: ExitRule::Adjacency(ties), ..self }
    }
}

/// Which faces a strip along a path takes in addition to the faces of the path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PathEnds {
    /// None.
    Fixed,
    /// The faces to which they grow at both ends.
    Growing,
}

/// Builds strips from the remaining faces.
#[derive(Debug)]
pub(super) struct LocalStripper<'a> {
    remaining: RemainingFaces<'a>,
    rules: StripRules,
    random: Random,
    strip: Vec<StripFace>,
    /// The swaps up to the entry of the strip's last face.
    swaps: LeastSwaps,
    /// The side of the strip's last turn: the turn that it needed fewer of.
    side: Option<usize>,
    tied: Vec<ExitCandidate>,
}

/// An exit from the end of a strip.
#[derive(Debug, Clone, Copy)]
struct ExitCandidate {
    half_edge: u32,
    /// The number of corners from the entry to the exit in the face.
    offset: u32,
    counts: TurnCounts,
    rests: [bool; 2],
    next_entry: u32,
    next_face: u32,
}

impl<'a> LocalStripper<'a> {
    pub(super) fn new(remaining: RemainingFaces<'a>, rules: StripRules, seed: u64) -> Self {
        Self {
            remaining,
            rules,
            random: Random::new(seed),
            strip: Vec::new(),
            swaps: LeastSwaps::FREE,
            side: None,
            tied: Vec::new(),
        }
    }

    /// Builds strips from all remaining faces.
    pub(super) fn strip_all(&mut self, sink: &mut impl StripSink) {
        while let Some(face) = self.remaining.fewest_neighbours() {
            self.strip.clear();
            self.enter(face, None);
            self.recount_swaps();
            self.grow_both_ends();
            self.finish_strip(sink);
        }
    }

    /// Builds strips along paths through whole faces. A path is a list of half-edges that lead from
    /// one face to the next, plus one more. Faces that are already in a strip divide a path.
    /// Sections of fewer than `min_length` faces are skipped. If strips grow, they grow after the
    /// faces of all sections have been taken.
    pub(super) fn strip_along(
        &mut self,
        paths: &[Vec<u32>],
        min_length: usize,
        ends: PathEnds,
        sink: &mut impl StripSink,
    ) {
        let mut sections = Vec::new();
        for path in paths {
            let free_or_taken = path.chunk_by(|&a, &b| self.is_untouched_at(a) == self.is_untouched_at(b));
            sections.extend(
                free_or_taken
                    .filter(|section| section.len() >= min_length && self.is_untouched_at(section[0])),
            );
        }
        for &exit in sections.iter().copied().flatten() {
            self.remaining.take(self.remaining.original_face(exit));
        }
        for section in sections {
            self.strip.clear();
            let mut entry = None;
            for (i, &exit) in section.iter().enumerate() {
                let exit_or_end = (i + 1 < section.len()).then_some(exit);
                let counts = entry.map_or([0; 2], |entry| self.counts_between(entry, exit));
                let face = self.remaining.original_face(exit);
                self.strip.push(StripFace { face, entry, exit: exit_or_end, counts, rests: [false; 2] });
                if let (Some(entry), Some(exit)) = (entry, exit_or_end)
                    && self.remaining.is_partial()
                {
                    self.remaining.cut(face, [entry, exit], counts[A] + 1, [false; 2]);
                }
                entry = self.remaining.twin(exit);
            }
            self.recount_swaps();
            if ends == PathEnds::Growing {
                self.grow_both_ends();
            }
            self.finish_strip(sink);
        }
    }

    /// Returns whether the face of a half-edge is whole and in no strip.
    fn is_untouched_at(&self, half_edge: u32) -> bool {
        self.remaining.is_untouched(self.remaining.original_face(half_edge))
    }

    /// Counts the turns from an entry to an exit of a whole face.
    fn counts_between(&self, entry: u32, exit: u32) -> TurnCounts {
        let size = self.remaining.size(self.remaining.original_face(exit));
        let mut corner = self.remaining.next(entry);
        let mut offset = 1;
        while corner != exit && offset + 1 < size {
            corner = self.remaining.next(corner);
            offset += 1;
        }
        [offset - 1, size - 1 - offset]
    }

    fn grow_both_ends(&mut self) {
        self.grow();
        self.reverse();
        self.grow();
    }

    /// Passes the strip to the sink.
    fn finish_strip(&mut self, sink: &mut impl StripSink) {
        sink.receive(&self.strip, &self.remaining);
        if self.remaining.is_partial() {
            let ends = [self.strip.first(), self.strip.last()];
            ends.into_iter().flatten().for_each(|end| self.remaining.finish(end.face));
        }
    }

    /// Extends the strip as far as possible.
    fn grow(&mut self) {
        while let Some(exit) = self.choose_exit() {
            self.leave(exit);
            self.enter(exit.next_face, Some(exit.next_entry));
        }
    }

    /// Adds a face to the end of the strip.
    fn enter(&mut self, face: u32, entry: Option<u32>) {
        self.remaining.take(face);
        self.strip.push(StripFace { face, entry, exit: None, counts: [0; 2], rests: [false; 2] });
    }

    /// Leaves the strip's last face.
    fn leave(&mut self, exit: ExitCandidate) {
        let Some(last) = self.strip.last_mut() else { return };
        last.exit = Some(exit.half_edge);
        if let Some(entry) = last.entry {
            (last.counts, last.rests) = (exit.counts, exit.rests);
            if self.remaining.is_partial() {
                self.remaining.cut(last.face, [entry, exit.half_edge], exit.offset, exit.rests);
            }
            self.count_face(exit.counts);
        }
    }

    /// Adds a face that the strip has passed to the swaps, and stores the strip's side.
    fn count_face(&mut self, counts: TurnCounts) {
        self.swaps = self.swaps.passing(counts, self.rules.diagonals);
        if counts[A] != counts[B] {
            self.side = Some(usize::from(counts[B] < counts[A]));
        }
    }

    /// Reverses the strip so that it can grow from its start.
    fn reverse(&mut self) {
        self.strip.reverse();
        for face in &mut self.strip {
            (face.entry, face.exit) = (face.exit, face.entry);
            face.counts.swap(A, B);
            face.rests.swap(A, B);
        }
        self.recount_swaps();
    }

    /// Counts the swaps of the whole strip, starting at its first face.
    fn recount_swaps(&mut self) {
        (self.swaps, self.side) = (LeastSwaps::FREE, None);
        for i in 1..self.strip.len().saturating_sub(1) {
            self.count_face(self.strip[i].counts);
        }
    }

    /// Chooses the exit from the strip's last face.
    fn choose_exit(&mut self) -> Option<ExitCandidate> {
        let StripFace { face, entry, .. } = *self.strip.last()?;
        self.list_exits(face, entry);
        match self.rules.exit {
            _ if self.tied.len() < 2 => self.tied.first().copied(),
            ExitRule::FewSwaps => self.tied.iter().max_by_key(|exit| self.look_ahead(exit)).copied(),
            ExitRule::Adjacency(Ties::Arbitrary) => self.tied.first().copied(),
            ExitRule::Adjacency(Ties::LookAhead) => match self.rules.last_tie {
                LastTie::First => self.tied.iter().min_by_key(|exit| self.look_ahead(exit)).copied(),
                LastTie::Last => self.tied.iter().rev().min_by_key(|exit| self.look_ahead(exit)).copied(),
            },
            ExitRule::Adjacency(Ties::Alternate) => {
                self.tied.iter().min_by_key(|exit| self.turns_to_last_side(exit)).copied()
            }
            ExitRule::Adjacency(Ties::Random) => self.pick(),
            ExitRule::Adjacency(ties @ (Ties::Sequential | Ties::FewestSwaps)) => {
                let swaps = |exit: &ExitCandidate| self.swaps.through(exit.counts).least();
                if entry.is_some() {
                    let least = self.tied.iter().map(swaps).min()?;
                    if ties == Ties::FewestSwaps || least == self.swaps.least() {
                        let mut tied = std::mem::take(&mut self.tied);
                        tied.retain(|exit| swaps(exit) == least);
                        self.tied = tied;
                    }
                }
                self.pick()
            }
        }
    }

    /// Lists the best exits in order around the face.
    fn list_exits(&mut self, face: u32, entry: Option<u32>) {
        self.tied.clear();
        let size = self.remaining.size(face);
        let (mut corner, first) = match entry {
            Some(entry) => (self.remaining.next(entry), 1),
            None => (self.remaining.corner(face), 0),
        };
        let reach = if self.remaining.is_partial() { REACH.min(size) } else { size };
        let mut least = u32::MAX;
        for offset in first..size.min(first + reach) {
            self.consider(corner, offset, (entry, size), &mut least);
            corner = self.remaining.next(corner);
        }
        let mut corner = entry.unwrap_or_else(|| self.remaining.corner(face));
        for offset in (first + reach..size).rev().take(reach as usize) {
            corner = self.remaining.previous(corner);
            self.consider(corner, offset, (entry, size), &mut least);
        }
    }

    /// Adds an exit to the list unless an earlier one is better.
    #[inline]
    fn consider(&mut self, half_edge: u32, offset: u32, (entry, size): (Option<u32>, u32), least: &mut u32) {
        let Some((next_entry, next_face)) = self.remaining.across(half_edge) else { return };
        let mut weight = self.remaining.adjacency(next_face);
        let mut exit =
            ExitCandidate { half_edge, offset, counts: [0; 2], rests: [false; 2], next_entry, next_face };
        if weight > *least {
            return;
        }
        if let Some(entry) = entry {
            self.set_counts(&mut exit, entry, size);
            if self.rules.exit == ExitRule::FewSwaps {
                weight += SWAP_WEIGHT * (self.swaps.through(exit.counts).least() - self.swaps.least());
            }
        }
        if weight < *least {
            *least = weight;
            self.tied.clear();
        }
        if weight == *least {
            self.tied.push(exit);
        }
    }

    /// Determines which part of a face a strip takes between an entry and an exit.
    fn set_counts(&self, exit: &mut ExitCandidate, entry: u32, size: u32) {
        exit.counts = [exit.offset - 1, size - 1 - exit.offset];
        if self.remaining.is_partial() {
            let firsts = [self.remaining.next(entry), self.remaining.next(exit.half_edge)];
            for side in [A, B] {
                let edge_count = exit.counts[side];
                exit.rests[side] = edge_count > 1
                    && (!self.rules.absorbs_rests
                        || self.remaining.has_two_neighbours(firsts[side], edge_count));
                if exit.rests[side] {
                    exit.counts[side] = 1;
                }
            }
        }
    }

    /// Chooses a random one of the tied exits.
    fn pick(&mut self) -> Option<ExitCandidate> {
        let draw = u128::from(self.random.next_u64()) * self.tied.len() as u128;
        self.tied.get((draw >> 64) as usize).copied()
    }

    /// Returns the lowest adjacency of the faces after the one that an exit leads to.
    fn look_ahead(&self, exit: &ExitCandidate) -> u32 {
        let mut corner = exit.next_entry;
        let mut least = u32::MAX;
        for _ in 1..self.remaining.size(exit.next_face).min(2 * REACH) {
            corner = self.remaining.next(corner);
            if let Some((_, face)) = self.remaining.across(corner) {
                least = least.min(self.remaining.adjacency(face));
            }
        }
        least
    }

    /// Returns how far an exit turns to the side of the strip's last turn.
    fn turns_to_last_side(&self, exit: &ExitCandidate) -> i64 {
        let [a, b] = exit.counts.map(i64::from);
        match self.side {
            Some(A) => b - a,
            Some(_) => a - b,
            None => 0,
        }
    }
}
