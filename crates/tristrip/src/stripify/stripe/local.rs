//! The local algorithms: a strip goes on to the neighbour that has the fewest neighbours itself.
//!
//! # Algorithm
//! 1. A strip starts at a free piece with the fewest free neighbours.
//! 2. It goes on to a free neighbour of the strip's end that has the fewest free neighbours; of several that have, the rule for
//!    ties takes one. Where polygons are not cut beforehand, the choice is among all edges of the polygon.
//! 3. When it is stuck it is turned around, and grows from its start.
//! 4. Where polygons are cut, a part that would keep fewer than two free neighbours is not left behind: it goes into the strip.
//!
//! Two departures from the paper. Step 4 is ours: a triangle with one neighbour left ends a strip, with none it is one, and costs
//! three vertices where a swap costs one. And whether a way needs a swap is asked of the best order of turns in all polygons
//! passed so far, not of one that was settled at each of them; see [`super::letters`].
//!
//! # References
//! Section 3.1 of the paper; see [`super`].
//!
//! # Complexity
//! O(n) for triangles and for whole polygons, O(n log n) at worst where parts are cut out.

use super::letters::{A, B, Counts, Swaps};
use super::pieces::{Pieces, REACH};
use super::weave::{Sink, Step};
use crate::stripify::Ties;

/// How many neighbours a way may lead to more, before a swap is preferred, where a strip is reluctant to swap. Over eight
/// polygon models 2 and 3 send 0.4 % fewer vertices than 1.
const SWAP_WEIGHT: u32 = 2;

/// Which way a strip goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rule {
    /// Least adjacency; the rule says what is done about ties.
    Adjacency(Ties),
    /// Least sum of adjacency and weighted swaps; of ties, the way after which there are the most.
    Reluctant,
}

/// Makes strips by walking over pieces.
#[derive(Debug)]
pub(super) struct Walker<'a> {
    pieces: Pieces<'a>,
    rule: Rule,
    random: SplitMix,
    strip: Vec<Step>,
    /// The swaps up to the entry of the strip's last piece.
    swaps: Swaps,
    /// The side to which the strip turned last: the letter of which it needed fewer.
    side: Option<usize>,
    tied: Vec<Exit>,
}

/// A way on from the end of a strip.
#[derive(Debug, Clone, Copy)]
struct Exit {
    half_edge: u32,
    /// The corner's place after the entry in its piece.
    place: u32,
    counts: Counts,
    rests: [bool; 2],
    entry: u32,
    piece: u32,
}

impl<'a> Walker<'a> {
    pub(super) fn new(pieces: Pieces<'a>, rule: Rule, seed: u64) -> Self {
        Self {
            pieces,
            rule,
            random: SplitMix(seed),
            strip: Vec::new(),
            swaps: Swaps::FREE,
            side: None,
            tied: Vec::new(),
        }
    }

    /// Makes strips of all that is left.
    pub(super) fn run(&mut self, sink: &mut impl Sink) {
        while let Some(piece) = self.pieces.fewest_neighbours() {
            self.strip.clear();
            self.enter(piece, None);
            self.turned();
            self.finish_strip(sink);
        }
    }

    /// Makes strips along ways through whole pieces, each given by the half-edges that lead from one piece to the next and one
    /// more. What is in a strip already divides a way; parts of fewer than `shortest` pieces are left. The strips grow at both
    /// ends, when all parts have been taken.
    pub(super) fn follow(&mut self, ways: &[Vec<u32>], shortest: usize, sink: &mut impl Sink) {
        let mut parts = Vec::new();
        for way in ways {
            let free_or_not = way.chunk_by(|&a, &b| self.is_free_at(a) == self.is_free_at(b));
            parts.extend(free_or_not.filter(|part| part.len() >= shortest && self.is_free_at(part[0])));
        }
        for &exit in parts.iter().copied().flatten() {
            self.pieces.take(self.pieces.face(exit));
        }
        for part in parts {
            self.strip.clear();
            let mut entry = None;
            for (i, &exit) in part.iter().enumerate() {
                let exit_or_end = (i + 1 < part.len()).then_some(exit);
                let counts = entry.map_or([0; 2], |entry| self.counts_between(entry, exit));
                let piece = self.pieces.face(exit);
                self.strip.push(Step { piece, entry, exit: exit_or_end, counts, rests: [false; 2] });
                if let (Some(entry), Some(exit)) = (entry, exit_or_end)
                    && self.pieces.partial()
                {
                    self.pieces.cut(piece, [entry, exit], counts[A] + 1, [false; 2]);
                }
                entry = self.pieces.twin(exit);
            }
            self.turned();
            self.finish_strip(sink);
        }
    }

    /// Tells whether a half-edge's face is whole and in no strip.
    fn is_free_at(&self, half_edge: u32) -> bool {
        self.pieces.is_untouched(self.pieces.face(half_edge))
    }

    /// Counts the letters from an entry to an exit of a whole piece.
    fn counts_between(&self, entry: u32, exit: u32) -> Counts {
        let size = self.pieces.size(self.pieces.face(exit));
        let mut corner = self.pieces.next(entry);
        let mut place = 1;
        while corner != exit && place + 1 < size {
            corner = self.pieces.next(corner);
            place += 1;
        }
        [place - 1, size - 1 - place]
    }

    /// Lets the strip grow at both ends, and hands it on.
    fn finish_strip(&mut self, sink: &mut impl Sink) {
        self.grow();
        self.turn_around();
        self.grow();
        sink.take(&self.strip, &self.pieces);
        if self.pieces.partial() {
            let ends = [self.strip.first(), self.strip.last()];
            ends.into_iter().flatten().for_each(|step| self.pieces.finish(step.piece));
        }
    }

    /// Lets the strip go on for as long as it can.
    fn grow(&mut self) {
        while let Some(exit) = self.choose() {
            self.leave(exit);
            self.enter(exit.piece, Some(exit.entry));
        }
    }

    fn enter(&mut self, piece: u32, entry: Option<u32>) {
        self.pieces.take(piece);
        self.strip.push(Step { piece, entry, exit: None, counts: [0; 2], rests: [false; 2] });
    }

    /// Leaves the strip's last piece.
    fn leave(&mut self, exit: Exit) {
        let Some(step) = self.strip.last_mut() else { return };
        step.exit = Some(exit.half_edge);
        if let Some(entry) = step.entry {
            (step.counts, step.rests) = (exit.counts, exit.rests);
            if self.pieces.partial() {
                self.pieces.cut(step.piece, [entry, exit.half_edge], exit.place, exit.rests);
            }
            self.pass(exit.counts);
        }
    }

    /// Keeps account of a piece that the strip has passed.
    fn pass(&mut self, counts: Counts) {
        self.swaps = self.swaps.through(counts);
        if counts[A] != counts[B] {
            self.side = Some(usize::from(counts[B] < counts[A]));
        }
    }

    /// Turns the strip around, so that it may grow from its start.
    fn turn_around(&mut self) {
        self.strip.reverse();
        for step in &mut self.strip {
            (step.entry, step.exit) = (step.exit, step.entry);
            step.counts.swap(A, B);
            step.rests.swap(A, B);
        }
        self.turned();
    }

    /// Takes account of all pieces of the strip, from the first on.
    fn turned(&mut self) {
        (self.swaps, self.side) = (Swaps::FREE, None);
        for i in 1..self.strip.len().saturating_sub(1) {
            self.pass(self.strip[i].counts);
        }
    }

    /// Chooses the way on.
    fn choose(&mut self) -> Option<Exit> {
        let Step { piece, entry, .. } = *self.strip.last()?;
        self.list_exits(piece, entry);
        match self.rule {
            _ if self.tied.len() < 2 => self.tied.first().copied(),
            Rule::Reluctant => self.tied.iter().max_by_key(|exit| self.look_ahead(exit)).copied(),
            Rule::Adjacency(Ties::Arbitrary) => self.tied.first().copied(),
            // Of those that are still equal the last; with the first, sgi sends 1.5 % more vertices for power lines.
            Rule::Adjacency(Ties::LookAhead) => {
                self.tied.iter().rev().min_by_key(|exit| self.look_ahead(exit)).copied()
            }
            Rule::Adjacency(Ties::Alternate) => {
                self.tied.iter().min_by_key(|exit| self.same_side(exit)).copied()
            }
            Rule::Adjacency(Ties::Random) => self.pick(),
            Rule::Adjacency(Ties::Sequential) => {
                let swaps = |exit: &Exit| self.swaps.through(exit.counts).least();
                if entry.is_some() {
                    let least = self.tied.iter().map(swaps).min()?;
                    let mut tied = std::mem::take(&mut self.tied);
                    tied.retain(|exit| swaps(exit) == least);
                    self.tied = tied;
                }
                self.pick()
            }
        }
    }

    /// Lists the best ways on, in order around the piece.
    fn list_exits(&mut self, piece: u32, entry: Option<u32>) {
        self.tied.clear();
        let size = self.pieces.size(piece);
        let (mut corner, first) = match entry {
            Some(entry) => (self.pieces.next(entry), 1),
            None => (self.pieces.corner(piece), 0),
        };
        let reach = if self.pieces.partial() { REACH.min(size) } else { size };
        let mut least = u32::MAX;
        for place in first..size.min(first + reach) {
            self.consider(corner, place, (entry, size), &mut least);
            corner = self.pieces.next(corner);
        }
        let mut corner = entry.unwrap_or_else(|| self.pieces.corner(piece));
        for place in (first + reach..size).rev().take(reach as usize) {
            corner = self.pieces.previous(corner);
            self.consider(corner, place, (entry, size), &mut least);
        }
    }

    /// Puts a way on the list, if no way seen so far is better.
    #[inline]
    fn consider(&mut self, half_edge: u32, place: u32, (from, size): (Option<u32>, u32), least: &mut u32) {
        let Some((entry, piece)) = self.pieces.across(half_edge) else { return };
        let mut weight = self.pieces.adjacency(piece);
        let mut exit = Exit { half_edge, place, counts: [0; 2], rests: [false; 2], entry, piece };
        if weight > *least {
            return;
        }
        if let Some(from) = from {
            self.divide(&mut exit, from, size);
            if self.rule == Rule::Reluctant {
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

    /// Says what of a piece a strip takes on a way through it: step 4.
    fn divide(&self, exit: &mut Exit, entry: u32, size: u32) {
        exit.counts = [exit.place - 1, size - 1 - exit.place];
        if self.pieces.partial() {
            let firsts = [self.pieces.next(entry), self.pieces.next(exit.half_edge)];
            for side in [A, B] {
                let edges = exit.counts[side];
                exit.rests[side] = edges > 1 && self.pieces.has_two_neighbours(firsts[side], edges);
                if exit.rests[side] {
                    exit.counts[side] = 1;
                }
            }
        }
    }

    /// Takes one of the tied ways at random.
    fn pick(&mut self) -> Option<Exit> {
        let i = self.random.below(self.tied.len());
        self.tied.get(i).copied()
    }

    /// Gives the least adjacency of the pieces after the one that a way leads to.
    fn look_ahead(&self, exit: &Exit) -> u32 {
        let mut corner = exit.entry;
        let mut least = u32::MAX;
        for _ in 1..self.pieces.size(exit.piece).min(2 * REACH) {
            corner = self.pieces.next(corner);
            if let Some((_, piece)) = self.pieces.across(corner) {
                least = least.min(self.pieces.adjacency(piece));
            }
        }
        least
    }

    /// Says how far a way turns to the side to which the strip turned last.
    fn same_side(&self, exit: &Exit) -> i64 {
        let [a, b] = exit.counts.map(i64::from);
        match self.side {
            Some(A) => b - a,
            Some(_) => a - b,
            None => 0,
        }
    }
}

/// The generator of Steele, Lea and Flood, 2014: the same numbers on every machine.
#[derive(Debug)]
struct SplitMix(u64);

impl SplitMix {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        ((u128::from(z) * n as u128) >> 64) as usize
    }
}
