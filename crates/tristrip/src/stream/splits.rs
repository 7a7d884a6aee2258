//! Which fans a batch splits, and which of their corners move.
//!
//! # Algorithm
//! In each batch, triangles that a split has moved or added are *used*: no other split of the batch moves them. For each fan, in the order of their numbers:
//!
//! 1. Is there a (further) split? Contexts: the valence and the free corners, the age of the fan and of those around it, its size relative to the others,
//!    and how many of its edges are chords: longer than the line between their neighbours, as collapses leave them.
//! 2. An open fan: is a triangle only added at its end, and at which one?
//! 3. The first corner that moves: for each free corner but the last, is it this one?
//! 4. Do more corners move: for each next one, as long as it is free.
//! 5. Corners at the end of an open fan: is there a triangle beyond?
//!
//! Contexts of 3 and 4 are how long the edges on both sides are, compared with the others and with the lines across.
//!
//! # References
//! Pajarola, Rossignac: *Compressed Progressive Meshes*, 2000 (batches of splits, and marks of what splits).

use super::mixing::{INPUTS, Mixed, Simple};
use super::numbers::halves;
use super::places::{Place, Surprise, square_distance};
use super::range_coder::BitCoder;
use super::surface::{MOST_CORNERS, Split, Surface, next, previous};

/// What is known of a fan. Batches have numbers from 1.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(align(32))]
pub(super) struct Fan {
    /// Its position, in steps of the current precision.
    pub(super) place: Place,
    /// The batch in which the fan arose; 0 for the base mesh.
    pub(super) born: u32,
    /// The last batch that has split it.
    pub(super) split: u32,
    pub(super) surprise: Surprise,
}

/// The slots of each input.
const SLOTS: usize = 4096;

/// The models of splits.
#[derive(Debug, Clone)]
pub(super) struct SplitModel {
    marks: Mixed,
    starts: Mixed,
    runs: Mixed,
    sides: Simple,
    /// The mean of twice the logarithm of the squares of the sides around fans, in 1/256.
    usual_size: i32,
    /// The points around the fan, and the squares of their distances from it.
    rim: Vec<Place>,
    spokes: Vec<u64>,
}

/// What a batch knows.
pub(super) struct Batch<'a> {
    pub(super) surface: &'a Surface,
    pub(super) fans: &'a [Fan],
    pub(super) number: u32,
}

impl Batch<'_> {
    #[inline]
    fn is_free(&self, corner: u32) -> bool {
        self.surface.mark(corner) != self.number
    }

    /// Returns how long ago a fan at a corner arose and was split, 0 to 15.
    #[inline]
    fn age(&self, corner: u32) -> usize {
        let fan = self.fans[self.surface.fan(corner) as usize];
        ((self.number - fan.born).min(3) * 4 + (self.number - fan.split).min(3)) as usize
    }
}

impl SplitModel {
    pub(super) fn new() -> Self {
        let mixed = |sets| Mixed::new([SLOTS; INPUTS], sets);
        Self {
            marks: mixed(8),
            starts: mixed(8),
            runs: mixed(8),
            sides: Simple::new(4),
            usual_size: 0,
            rim: Vec::new(),
            spokes: Vec::new(),
        }
    }

    /// Collects the points around a fan.
    #[inline]
    fn look_around(&mut self, batch: &Batch<'_>, fan: u32, ring: &[u32]) {
        let center = batch.fans[fan as usize].place;
        let at = |corner: u32| batch.fans[batch.surface.fan(corner) as usize].place;
        self.rim.clear();
        self.rim.extend(ring.iter().map(|&corner| at(next(corner))));
        self.rim.extend(ring.last().map(|&corner| at(previous(corner))));
        self.spokes.clear();
        self.spokes.extend(self.rim.iter().map(|&point| square_distance(point, center)));
    }

    /// Codes whether a fan is split, after `done` splits in this batch.
    pub(super) fn code_mark<C: BitCoder>(
        &mut self,
        coder: &mut C,
        batch: &Batch<'_>,
        (fan, ring, is_open): (u32, &[u32], bool),
        done: usize,
        bit: bool,
    ) -> bool {
        let n = ring.len();
        let free = ring.iter().filter(|&&corner| batch.is_free(corner)).count();
        let least = if is_open { 1 } else { 2 };
        if n < least || n > MOST_CORNERS || free == 0 && !is_open {
            return false;
        }
        self.look_around(batch, fan, ring);
        // 1. The fans around.
        let (mut split, mut born, mut earlier, mut run, mut longest_run) = (0, 0, 0, 0_usize, 0);
        for &corner in ring {
            let other = batch.surface.fan(next(corner));
            let history = &batch.fans[other as usize];
            split += usize::from(history.split == batch.number);
            born += usize::from(history.born == batch.number);
            earlier += usize::from(other < fan);
            run = if batch.is_free(corner) { run + 1 } else { 0 };
            longest_run = longest_run.max(run);
        }
        // 2. Its size and its chords.
        let inner = if is_open { 1..n } else { 0..n };
        let is_chord = |&i: &usize| {
            let before = self.rim[if i == 0 { n - 1 } else { i - 1 }];
            self.spokes[i] > square_distance(before, self.rim[i + 1])
        };
        let chords = inner.filter(is_chord).count().min(7);
        let size = (halves(self.spokes[..n].iter().sum::<u64>() / n as u64) as u32).cast_signed();
        let relative = (size - (self.usual_size >> 8) + 8).clamp(0, 15).cast_unsigned() as usize;
        self.usual_size += (size * 256 - self.usual_size) >> 7;

        let history = &batch.fans[fan as usize];
        let age = (batch.number - history.born).min(7) as usize;
        let quiet = (batch.number - history.split).min(7) as usize;
        let (n, free, done, open) = (n.min(15), free.min(15), done.min(3), usize::from(is_open));
        let contexts = [
            (n * 16 + free) * 8 + done * 2 + open,
            (relative * 16 + free) * 8 + done * 2 + open,
            (chords * 16 + free) * 16 + n,
            (age * 8 + quiet) * 16 + free,
            (split.min(7) * 8 + born.min(7)) * 16 + free,
            (earlier.min(15) * 8 + longest_run.min(7)) * 8 + chords,
        ];
        self.marks.code(coder, contexts, done * 2 + open, bit)
    }

    /// Codes which corners of a fan move. `wanted` is the split to be encoded.
    pub(super) fn code_split<C: BitCoder>(
        &mut self,
        coder: &mut C,
        batch: &Batch<'_>,
        (fan, ring, is_open): (u32, &[u32], bool),
        wanted: Option<Split>,
    ) -> Split {
        let n = ring.len();
        if is_open {
            let moves_none = wanted.is_some_and(|split| split.count == 0);
            let can_move = ring.iter().any(|&corner| batch.is_free(corner));
            if !can_move || self.sides.code(coder, 0, moves_none) {
                let at_start = self.sides.code(coder, 1, wanted.is_some_and(|split| split.start == 0));
                let start = if at_start { 0 } else { n };
                return Split { start, count: 0, is_open, adds: [!at_start, at_start] };
            }
        }
        self.look_around(batch, fan, ring);
        let start = self.code_start(coder, batch, ring, is_open, wanted.map(|split| split.start));
        let count =
            self.code_count(coder, batch, ring, (start, is_open), wanted.map_or(0, |split| split.count));
        let mut adds = [true; 2];
        if is_open && start == 0 {
            adds[0] = self.sides.code(coder, 2, wanted.is_some_and(|split| split.adds[0]));
        }
        if is_open && start + count == n && adds[0] {
            adds[1] = self.sides.code(coder, 3, wanted.is_some_and(|split| split.adds[1]));
        }
        Split { start, count, is_open, adds }
    }

    /// Codes the first corner that moves; at least one is free.
    fn code_start<C: BitCoder>(
        &mut self,
        coder: &mut C,
        batch: &Batch<'_>,
        ring: &[u32],
        is_open: bool,
        wanted: Option<usize>,
    ) -> usize {
        let n = ring.len();
        let lengths = Lengths::new(&self.rim, &self.spokes, n, is_open);
        let mut left = ring.iter().filter(|&&corner| batch.is_free(corner)).count();
        let is_free = |i: Option<usize>| i.is_some_and(|i| batch.is_free(ring[i]));
        for i in (0..n).filter(|&i| batch.is_free(ring[i])) {
            left -= 1;
            if left == 0 {
                return i;
            }
            let before = if i == 0 { (!is_open).then_some(n - 1) } else { Some(i - 1) };
            let after = if i + 1 == n { (!is_open).then_some(0) } else { Some(i + 1) };
            let free = usize::from(is_free(before)) * 2 + usize::from(is_free(after));
            let [a, b] = [lengths.of_others(i), lengths.of_others(i + 1)];
            let [across_a, across_b] = [lengths.of_chord(i), lengths.of_chord(i + 1)];
            let [age_a, age_b] = [batch.age(next(ring[i])), batch.age(previous(ring[i]))];
            let contexts = [
                (across_a * 16 + across_b) * 4 + free,
                (a * 16 + b) * 4 + free,
                (i.min(15) * 16 + left.min(15)) * 4 + free,
                (age_a * 16 + age_b) * 4 + free,
                (across_a * 16 + a) * 4 + free,
                (n.min(15) * 16 + across_a) * 4 + free,
            ];
            if self.starts.code(coder, contexts, free + 4 * usize::from(is_open), wanted == Some(i)) {
                return i;
            }
        }
        0
    }

    /// Codes how many corners move.
    fn code_count<C: BitCoder>(
        &mut self,
        coder: &mut C,
        batch: &Batch<'_>,
        ring: &[u32],
        (start, is_open): (usize, bool),
        wanted: usize,
    ) -> usize {
        let n = ring.len();
        let lengths = Lengths::new(&self.rim, &self.spokes, n, is_open);
        // One corner of a closed fan stays.
        let most = if is_open { n - start } else { (n - 1).max(1) };
        for count in 1..most {
            let i = if start + count < n { start + count } else { start + count - n };
            if !batch.is_free(ring[i]) {
                return count;
            }
            let [a, b] = [lengths.of_others(i), lengths.of_others(i + 1)];
            let [across_a, across_b] = [lengths.of_chord(i), lengths.of_chord(i + 1)];
            let [age_a, age_b] = [batch.age(next(ring[i])), batch.age(previous(ring[i]))];
            let few = count.min(7);
            let contexts = [
                (across_a * 16 + across_b) * 8 + few,
                (a * 16 + b) * 8 + few,
                n.min(15) * 16 + count.min(15),
                (age_a * 16 + age_b) * 8 + few,
                (across_a * 16 + a) * 8 + (n - count).min(7),
                (across_a * 16 + lengths.of_chord(start)) * 8 + few,
            ];
            if !self.runs.code(coder, contexts, few, wanted > count) {
                return count;
            }
        }
        most
    }
}

/// The lengths of the edges around a fan, relative to others, as twice a logarithm.
struct Lengths<'a> {
    rim: &'a [Place],
    spokes: &'a [u64],
    mean: u64,
    count: usize,
    is_open: bool,
}

impl<'a> Lengths<'a> {
    fn new(rim: &'a [Place], spokes: &'a [u64], count: usize, is_open: bool) -> Self {
        Self { rim, spokes, mean: spokes[..count].iter().sum::<u64>() / count as u64 + 1, count, is_open }
    }

    /// Compares an edge with all edges of the fan: 0 to 15.
    #[inline]
    fn of_others(&self, i: usize) -> usize {
        halves(16 * self.spokes[i] / self.mean).min(15)
    }

    /// Compares an edge with the line between its neighbours: 0 to 15.
    #[inline]
    fn of_chord(&self, i: usize) -> usize {
        let i = if i == self.count && !self.is_open { 0 } else { i };
        if self.is_open && (i == 0 || i == self.count) {
            return 15;
        }
        let before = self.rim[if i == 0 { self.count - 1 } else { i - 1 }];
        let across = square_distance(before, self.rim[i + 1]) + 1;
        (halves(64 * self.spokes[i] / across) / 2).min(15)
    }
}
