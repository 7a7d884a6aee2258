//! Codes which fans a batch splits, and which of their corners move.
//!
//! # Algorithm
//! In each batch, triangles that a split has moved or added are *used*; the others are *free*. No
//! other split of the batch moves used triangles. For each fan, in the order of the batch:
//!
//! 1. Is there another split? Features: the valence and the number of free corners, the age of the
//!    fan, and its distance from the mean of its neighbours. The distance is a measure of
//!    curvature, and curved regions are split more often. None of these features reads the
//!    surrounding fans.
//! 2. For an open fan: is a triangle only added at an end, and at which one?
//! 3. The number of corners that move, given the valence and the longest run of free corners. The
//!    shape of the fan hardly predicts this number.
//! 4. The first corner that moves, as one choice among all corners that start a long enough free
//!    run. Each edge of the fan is the first or the last edge of the run, within it, or outside.
//!    The features of an edge are its length relative to the other edges and the valence at its
//!    other end. The length matters because edges that are not in the finer mesh are long.
//! 5. For corners at the end of an open fan: is there a triangle beyond the end?
//!
//! # Complexity
//! O(1) for a mark, O(n) for a split of a fan with n corners.
//!
//! # References
//! Pajarola, Rossignac: *Compressed Progressive Meshes*, 2000 (batches of splits, and marks of
//! split vertices).

use super::fans::{SurfaceFan, square_distance};
use super::surface::{MAX_CORNERS, Ring, Split, StreamSurface};
use crate::entropy::numbers::logarithm;
use crate::entropy::range_coder::{BitCoder, WHOLE, code_bits};
use crate::entropy::scores::{Scores, weight_of};
use crate::entropy::slots::Simple;

/// The features of a mark. The first combines the valence, the free corners, and whether the fan is
/// open and was split in this batch. The others are its age and its distance from the mean.
const AGES: usize = 16 * 8 * 4;
const DISTANCES: usize = AGES + 8;
const MARK_FEATURES: usize = DISTANCES + 32;

/// The role of an edge of a fan in a run of corners: its first edge, one within, or its last one.
/// `Roles` has a fourth, unused score, so the size of a row is a power of two.
const FIRST: usize = 0;
const WITHIN: usize = 1;
const LAST: usize = 2;
type Roles = [i32; 4];
/// The features of an edge: its length, and the valence at its other end or [`BORDER`].
const LENGTHS: usize = 16;
const VALENCES: usize = 16;
const BORDER: u8 = 0;
/// The learning rate of the scores of runs: they move by 2⁻⁴ of an error.
const RUN_RATE: i32 = 4;
/// In fans with more corners, runs are not chosen by scores.
const MAX_CHOICES: usize = 15;
/// The maximum number of edges of such a fan. Arrays of this size can be indexed by any four bits.
const EDGES: usize = MAX_CHOICES + 1;

/// The models of splits.
#[derive(Debug, Clone)]
pub(super) struct SplitModel {
    marks: Scores,
    sides: Simple,
    counts: Simple,
    lengths: [Roles; LENGTHS],
    valences: [Roles; VALENCES],
}

impl SplitModel {
    pub(super) fn new() -> Self {
        Self {
            marks: Scores::new(MARK_FEATURES),
            sides: Simple::new(4),
            counts: Simple::new(16 * 16 * 16),
            lengths: [[0; 4]; LENGTHS],
            valences: [[0; 4]; VALENCES],
        }
    }

    /// Codes whether a fan is split, after `done` splits in this batch.
    #[inline]
    pub(super) fn code_mark<C: BitCoder>(
        &mut self,
        coder: &mut C,
        fan: &SurfaceFan,
        batch: u32,
        done: usize,
        bit: bool,
    ) -> bool {
        let (open, count) = (usize::from(fan.is_open), usize::from(fan.count));
        let free = count.saturating_sub(open + fan.used(batch) as usize);
        if !(2..=MAX_CORNERS).contains(&count) || free == 0 && !fan.is_open {
            return false;
        }
        let [x, y, z] = fan.laplacian().map(|x| u64::from(x.unsigned_abs()));
        let distance = (logarithm(x + y + z + 1) - logarithm(fan.count.into())) >> 2;
        let age = (batch as u8).wrapping_sub(fan.born).min(7);
        let features = [
            (count.min(15) * 8 + free.min(7)) * 4 + done.min(1) * 2 + open,
            AGES + usize::from(age),
            DISTANCES + (distance + 4).clamp(0, 31).cast_unsigned() as usize,
        ];
        self.marks.code(coder, features, bit)
    }

    /// Codes which corners of a fan move. `to_encode` is the split to encode.
    pub(super) fn code_split<C: BitCoder>(
        &mut self,
        coder: &mut C,
        (surface, fans, batch): (&StreamSurface, &[SurfaceFan], u32),
        (fan, ring): (u32, &Ring),
        to_encode: Option<Split>,
    ) -> Split {
        let (n, is_open) = (ring.corners().len(), ring.is_open);
        let is_free = |i: usize| surface.mark(ring.corners()[i]) != batch;
        let can_move = if n > MAX_CHOICES { (0..n).any(is_free) } else { ring.free != 0 };
        if is_open {
            let moves_none = to_encode.is_some_and(|split| split.count == 0);
            if !can_move || self.sides.code(coder, 0, moves_none) {
                let at_start = self.sides.code(coder, 1, to_encode.is_some_and(|split| split.start == 0));
                let start = if at_start { 0 } else { n };
                return Split { start, count: 0, is_open, adds: [!at_start, at_start] };
            }
        }
        let run = to_encode.map_or([0, 1], |split| [split.start, split.count]);
        let [start, count] = match () {
            () if !can_move => [0, 1],
            () if n > MAX_CHOICES => code_plain(coder, is_free, (n, is_open), run),
            () => self.code_run(coder, fans, (fan, ring), run),
        };
        let mut adds = [true; 2];
        if is_open && start == 0 {
            adds[0] = self.sides.code(coder, 2, to_encode.is_some_and(|split| split.adds[0]));
        }
        if is_open && start + count == n && adds[0] {
            adds[1] = self.sides.code(coder, 3, to_encode.is_some_and(|split| split.adds[1]));
        }
        Split { start, count, is_open, adds }
    }

    /// Codes a run of free corners. Returns its first corner and the number of corners.
    #[inline]
    fn code_run<C: BitCoder>(
        &mut self,
        coder: &mut C,
        fans: &[SurfaceFan],
        (fan, ring): (u32, &Ring),
        [start_to_encode, count_to_encode]: [usize; 2],
    ) -> [usize; 2] {
        // 1. The starts of runs of each length, as bits. Around a closed fan a run cannot contain
        //    all corners.
        let (n, is_open) = (ring.corners().len().min(MAX_CHOICES), ring.is_open);
        let twice = if is_open { ring.free } else { ring.free | ring.free << n };
        let largest = if is_open { n } else { (n - 1).max(1) };
        let (mut starts, mut longest) = ([ring.free; EDGES], 1);
        while longest < largest && starts[longest] & twice >> longest != 0 {
            starts[longest + 1] = starts[longest] & twice >> longest;
            longest += 1;
        }
        // 2. The number of corners.
        let mut count = 1;
        if longest > 1 {
            let (context, bits) = (16 * n + longest, if n <= 8 { 3 } else { 4 });
            let to_encode = count_to_encode.saturating_sub(1).min(15);
            count = (self.counts.code_number(coder, context, bits, to_encode) + 1).min(longest);
        }
        [self.code_start(coder, fans, (fan, ring), (starts[count], count), start_to_encode), count]
    }

    /// Codes the first corner of a run. The bits of `starts` are the possible first corners.
    #[inline]
    fn code_start<C: BitCoder>(
        &mut self,
        coder: &mut C,
        fans: &[SurfaceFan],
        (fan, ring): (u32, &Ring),
        (mut starts, count): (u32, usize),
        start_to_encode: usize,
    ) -> usize {
        if starts.is_power_of_two() {
            return starts.trailing_zeros() as usize;
        }
        // 1. The score of each run: its first edge, the edges within, and the last edge. Around a
        //    closed fan, edges are listed twice.
        let (n, is_open) = (ring.corners().len().min(MAX_CHOICES), ring.is_open);
        let edge_count = if is_open { n + 1 } else { n };
        let features = edge_features(fans, fan, ring, edge_count);
        let (mut firsts, mut ends, mut within) = ([0_i32; EDGES], [0_i32; 2 * EDGES], 0_i32);
        for i in 0..edge_count {
            let [length, valence] = self.rows(features[i]).map(|row| *row);
            ends[i] = within.wrapping_add(length[LAST]).wrapping_add(valence[LAST]);
            within = within.wrapping_add(length[WITHIN]).wrapping_add(valence[WITHIN]);
            firsts[i] = length[FIRST].wrapping_add(valence[FIRST]).wrapping_sub(within);
        }
        if !is_open {
            (0..count).for_each(|i| ends[n + i] = ends[i].wrapping_add(within));
        }
        let (mut choices, mut scores, mut number, mut most) = ([0_u8; EDGES], [0_i32; EDGES], 0, i32::MIN);
        while starts != 0 {
            let i = starts.trailing_zeros() as usize & (EDGES - 1);
            starts &= starts - 1;
            let score = firsts[i].wrapping_add(ends[i + count]);
            (choices[number], scores[number]) = (i as u8, score);
            most = most.max(score);
            number = (number + 1) & (EDGES - 1);
        }
        // 2. Their probabilities.
        let (mut shares, mut all) = ([0; EDGES], 0);
        for c in 0..number {
            shares[c] = weight_of(most.wrapping_sub(scores[c]).cast_unsigned());
            all += shares[c];
        }
        let unit = u32::MAX / all;
        // If the start to encode is not among them, another one is coded; the encoder checks this.
        let (mut to_encode, mut sum) = (0, 0);
        for c in 0..number {
            shares[c] = (shares[c] * unit) >> 16;
            if usize::from(choices[c]) == start_to_encode {
                to_encode = sum;
            }
            sum += shares[c];
        }
        // 3. The choice. The last one gets what rounding has left over.
        let part = coder.seek(16, to_encode);
        let (mut choice, mut passed, mut sum) = (0, 0, 0);
        for c in 0..number - 1 {
            sum += shares[c];
            (choice, passed) = if part >= sum { (c + 1, sum) } else { (choice, passed) };
        }
        coder.take(passed, if choice + 1 < number { shares[choice] } else { WHOLE - passed });
        // 4. The errors of all corners, repeated before the first one.
        let mut errors = [0_i32; 2 * EDGES];
        for c in 0..number {
            let error = (i32::from(c == choice) << 16) - shares[c].cast_signed();
            errors[EDGES + usize::from(choices[c] & 15)] = error >> RUN_RATE;
        }
        if !is_open {
            (1..=count).for_each(|by| errors[EDGES - by] = errors[EDGES + n - by]);
        }
        self.learn_start(&features[..edge_count], &errors, count);
        choices[choice].into()
    }

    /// Learns from the errors of all starts of runs, from `errors[EDGES]` on. An edge is within the
    /// runs that began before it and have not ended.
    #[inline]
    fn learn_start(&mut self, features: &[[u8; 2]], errors: &[i32; 2 * EDGES], count: usize) {
        let (firsts, lasts) = (&errors[EDGES..], &errors[EDGES - count..]);
        let mut within: i32 = lasts[1..count].iter().sum();
        for (i, &features) in features.iter().enumerate() {
            let error = [firsts[i], within, lasts[i], 0];
            for row in self.rows(features) {
                for role in 0..4 {
                    row[role] = row[role].wrapping_add(error[role]);
                }
            }
            within += firsts[i] - lasts[i + 1];
        }
    }

    /// Returns the scores of the features of an edge.
    #[inline]
    fn rows(&mut self, [length, valence]: [u8; 2]) -> [&mut Roles; 2] {
        [&mut self.lengths[usize::from(length & 15)], &mut self.valences[usize::from(valence & 15)]]
    }
}

/// Computes the features of the edges of a fan.
#[inline]
fn edge_features(fans: &[SurfaceFan], fan: u32, ring: &Ring, edge_count: usize) -> [[u8; 2]; EDGES] {
    let (mut features, mut lengths, mut sum) = ([[0; 2]; EDGES], [0; EDGES], 1);
    let center = fans[fan as usize].place();
    for ((feature, length), &other) in features.iter_mut().zip(&mut lengths).zip(&ring.around()[..edge_count])
    {
        let fan = &fans[other as usize];
        let square = square_distance(fan.place(), center) + 1;
        sum += square;
        *length = logarithm(square);
        feature[1] = fan.count.min(15) as u8;
    }
    let mean = logarithm(sum) - logarithm(edge_count as u64);
    for (feature, length) in features.iter_mut().zip(lengths).take(edge_count) {
        let length = ((5 * (length - mean)) >> 4) + 8;
        feature[0] = length.clamp(0, 15).cast_unsigned() as u8;
    }
    if ring.is_open {
        (features[0][1], features[edge_count - 1][1]) = (BORDER, BORDER);
    }
    features
}

/// Codes a run of free corners in a fan with many corners.
fn code_plain<C: BitCoder>(
    coder: &mut C,
    is_free: impl Fn(usize) -> bool,
    (n, is_open): (usize, bool),
    [start, count]: [usize; 2],
) -> [usize; 2] {
    let choose = |coder: &mut C, number: usize, to_encode: usize| {
        let bits = usize::BITS - (number - 1).leading_zeros();
        code_bits(coder, bits, to_encode as u32) as usize % number
    };
    let free: Vec<usize> = (0..n).filter(|&i| is_free(i)).collect();
    let to_encode = free.iter().position(|&i| i == start).unwrap_or(0);
    let start = free[choose(coder, free.len(), to_encode)];
    let largest = if is_open { n - start } else { (n - 1).max(1) };
    let run = (1..largest).find(|&i| !is_free((start + i) % n)).unwrap_or(largest);
    [start, 1 + choose(coder, run, count.saturating_sub(1))]
}
