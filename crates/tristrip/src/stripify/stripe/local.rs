//! The local algorithms: a strip goes on to the neighbour that has the fewest neighbours itself.
//!
//! # Algorithm
//! 1. A strip starts at a free piece with the fewest free neighbours.
//! 2. It goes on to a free neighbour of the strip's end that has the fewest free neighbours; of several that have, the rule for
//!    ties takes one. Where polygons are not cut beforehand, the choice is among all edges of the polygon.
//! 3. When it is stuck it is turned around, and grows from its start.
//!
//! # References
//! See [`super`].
//!
//! # Complexity
//! O(n) for triangles and for whole polygons, O(n log n) at worst where parts are cut out.

use super::letters::{A, B, Counts, Swaps};
use super::pieces::{Pieces, REACH};
use super::weave::{Sink, Step};
use crate::stripify::Ties;

/// Makes strips by walking over pieces.
#[derive(Debug)]
pub(super) struct Walker<'a> {
    pieces: Pieces<'a>,
    ties: Ties,
    random: SplitMix,
    strip: Vec<Step>,
    swaps: Swaps,
    /// The side to which the strip turned last, as the letter of which fewer were needed.
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
    entry: u32,
    piece: u32,
}

impl<'a> Walker<'a> {
    pub(super) fn new(pieces: Pieces<'a>, ties: Ties, seed: u64) -> Self {
        Self {
            pieces,
            ties,
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
            self.begin(piece);
            self.grow();
            self.turn_around();
            self.grow();
            self.end(sink);
        }
    }

    /// Begins a strip.
    pub(super) fn begin(&mut self, piece: u32) {
        self.strip.clear();
        self.swaps = Swaps::FREE;
        self.side = None;
        self.enter(piece, None);
    }

    /// Keeps the faces of these half-edges for strips that will follow given ways.
    pub(super) fn reserve(&mut self, half_edges: impl Iterator<Item = u32>) {
        half_edges.for_each(|h| self.pieces.take_of(h));
    }

    /// Begins a strip that leaves its pieces across these half-edges, and ends before the last of them. The pieces must
    /// have been reserved.
    pub(super) fn follow(&mut self, exits: impl Iterator<Item = u32>) {
        self.strip.clear();
        self.swaps = Swaps::FREE;
        self.side = None;
        let mut entry = None;
        let mut exits = exits.peekable();
        while let Some(exit) = exits.next() {
            let piece = self.pieces.face(exit);
            let going_on = exits.peek().is_some();
            let mut step = Step { piece, entry, exit: going_on.then_some(exit), counts: [0; 2] };
            if let Some(entry) = entry {
                let mut place = 1;
                let mut corner = self.pieces.next(entry);
                while corner != exit { place += 1; corner = self.pieces.next(corner); if place > 4 { break } }
                step.counts = [place - 1, self.pieces.size(piece) - 1 - place];
                if going_on { self.swaps = self.swaps.through(step.counts); }
            }
            self.strip.push(step);
            entry = self.pieces.twin(exit);
        }
    }

    fn enter(&mut self, piece: u32, entry: Option<u32>) {
        self.pieces.take(piece);
        self.strip.push(Step { piece, entry, exit: None, counts: [0; 2] });
    }

    /// Lets the strip go on for as long as it can.
    pub(super) fn grow(&mut self) {
        while let Some(exit) = self.choose() {
            self.leave(exit);
        }
    }

    /// Leaves the strip's last piece.
    fn leave(&mut self, exit: Exit) {
        let Some(step) = self.strip.last_mut() else { return };
        (step.exit, step.counts) = (Some(exit.half_edge), exit.counts);
        if let Some(entry) = step.entry {
            self.swaps = self.swaps.through(exit.counts);
            if self.pieces.partial() {
                self.pieces.cut(step.piece, entry, exit.half_edge, exit.place);
            }
            if exit.counts[A] != exit.counts[B] {
                self.side = Some(usize::from(exit.counts[B] < exit.counts[A]));
            }
        }
        self.enter(exit.piece, Some(exit.entry));
    }

    /// Turns the strip around, so that it may grow from its start.
    pub(super) fn turn_around(&mut self) {
        self.strip.reverse();
        for step in &mut self.strip {
            (step.entry, step.exit) = (step.exit, step.entry);
            step.counts.swap(A, B);
        }
        self.swaps = Swaps::FREE;
        self.side = None;
        if let [_, inner @ .., _] = self.strip.as_slice() {
            for step in inner {
                self.swaps = self.swaps.through(step.counts);
                if step.counts[A] != step.counts[B] {
                    self.side = Some(usize::from(step.counts[B] < step.counts[A]));
                }
            }
        }
    }

    /// Ends the strip.
    pub(super) fn end(&mut self, sink: &mut impl Sink) {
        sink.take(&self.strip, &self.pieces);
        if self.pieces.partial() {
            let ends = [self.strip.first(), self.strip.last()];
            ends.into_iter().flatten().for_each(|step| self.pieces.finish(step.piece));
        }
    }

    /// Chooses the way on, by adjacency first and the rule for ties next.
    fn choose(&mut self) -> Option<Exit> {
        let step = self.strip.last()?;
        self.list_exits(step.piece, step.entry);
        match self.tied.as_slice() {
            [] | [_] => self.tied.first().copied(),
            _ => self.break_tie(),
        }
    }

    /// Lists the ways on to pieces of least adjacency, in order around the piece.
    fn list_exits(&mut self, piece: u32, entry: Option<u32>) {
        self.tied.clear();
        let size = self.pieces.size(piece);
        let (mut corner, first) = match entry {
            Some(entry) => (self.pieces.next(entry), 1),
            None => (self.pieces.corner(piece), 0),
        };
        let reach = if self.pieces.partial() { REACH } else { size };
        let mut least = u32::MAX;
        for place in first..size.min(first + reach) {
            self.consider(corner, place, size, &mut least);
            corner = self.pieces.next(corner);
        }
        if size > first + reach {
            let mut corner = entry.unwrap_or_else(|| self.pieces.corner(piece));
            for place in (first + reach..size).rev().take(reach as usize) {
                corner = self.pieces.previous(corner);
                self.consider(corner, place, size, &mut least);
            }
        }
    }

    #[inline]
    fn consider(&mut self, half_edge: u32, place: u32, size: u32, least: &mut u32) {
        let Some((entry, piece)) = self.pieces.across(half_edge) else { return };
        let adjacency = self.pieces.adjacency(piece);
        if adjacency > *least {
            return;
        }
        if adjacency < *least {
            *least = adjacency;
            self.tied.clear();
        }
        let (a, b) = (place.saturating_sub(1), size - 1 - place);
        let counts = if self.pieces.partial() { [a.min(1), b.min(1)] } else { [a, b] };
        self.tied.push(Exit { half_edge, place, counts, entry, piece });
    }

    fn break_tie(&mut self) -> Option<Exit> {
        match self.ties {
            Ties::Arbitrary => self.tied.first().copied(),
            Ties::LookAhead => self.tied.iter().min_by_key(|exit| self.look_ahead(exit)).copied(),
            Ties::Alternate => self.tied.iter().min_by_key(|exit| self.same_side(exit)).copied(),
            Ties::Random => self.pick(),
            Ties::Sequential => {
                let swaps = |exit: &Exit| self.swaps.through(exit.counts).least();
                if self.strip.len() == 1 {
                    return self.pick();
                }
                let least = self.tied.iter().map(swaps).min()?;
                let mut i = 0;
                while i < self.tied.len() {
                    if swaps(&self.tied[i]) > least {
                        self.tied.remove(i);
                    } else {
                        i += 1;
                    }
                }
                self.pick()
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
            Some(B) => a - b,
            _ => 0,
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
