//! Which fans a batch splits, and which of their corners move.
//!
//! # Algorithm
//! In each batch, triangles that a split has moved or added are *used*: no other split of the batch moves them. For each fan, in the order of their numbers:
//!
//! 1. Is there a (further) split? Features: the valence and the used corners, the age of the fan, and how far it is from the mean of its neighbours, as
//!    a split tells what a curved surface lacks. None of them needs a look at the fans around.
//! 2. An open fan: is a triangle only added at its end, and at which one?
//! 3. The corners that move, as one choice among all runs of free corners. An edge of the fan is the first of a run, the last, within, or not of it. Its
//!    features are its length, compared with the other edges and with the line between its neighbours, and the valence at its other end: edges that are
//!    not of the finer mesh are long.
//! 4. Corners at the end of an open fan: is there a triangle beyond?
//!
//! # References
//! Pajarola, Rossignac: *Compressed Progressive Meshes*, 2000 (batches of splits, and marks of what splits).

use super::numbers::logarithm;
use super::places::{Place, square_distance};
use super::range_coder::{BitCoder, code_bits};
use super::scores::{FALLS, Scores, learn, place_of};
use super::slots::Simple;
use super::surface::{MOST_CORNERS, NONE, Split, Surface};

/// What is known of a fan. Two of them have room in a cache line: most of the time of decoding goes by while they are fetched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub(super) struct Fan {
    /// Its position, in steps of the current precision.
    place: [u16; 3],
    /// The number of fans around, modulo 2¹⁶, and the sum of their positions, modulo 2³².
    pub(super) count: u16,
    sum: [i32; 3],
    /// The fan that a batch visits after this one, or none.
    pub(super) next: u32,
    /// The batches in which it arose and was last split, modulo 2⁸; 0 for the base mesh.
    pub(super) born: u8,
    pub(super) split: u8,
    /// The corners that the batch has used, at most 255.
    pub(super) used: u8,
    pub(super) is_open: bool,
}

impl Fan {
    /// Creates a fan of a batch with none around.
    #[inline]
    pub(super) fn new(place: Place, batch: u32, is_open: bool) -> Self {
        let mut fan = Self {
            place: [0; 3],
            count: 0,
            sum: [0; 3],
            next: NONE,
            born: batch as u8,
            split: batch as u8,
            used: 0,
            is_open,
        };
        fan.set_place(place);
        fan
    }

    #[inline]
    pub(super) fn place(&self) -> Place {
        let [x, y, z] = self.place;
        [x.into(), y.into(), z.into()]
    }

    #[inline]
    pub(super) fn set_place(&mut self, place: Place) {
        for j in 0..3 {
            self.place[j] = place[j].cast_unsigned() as u16;
        }
    }

    /// Forgets the fans around.
    pub(super) fn clear(&mut self) {
        (self.sum, self.count) = ([0; 3], 0);
    }

    #[inline]
    pub(super) fn add(&mut self, place: Place) {
        for j in 0..3 {
            self.sum[j] = self.sum[j].wrapping_add(place[j]);
        }
        self.count = self.count.wrapping_add(1);
    }

    #[inline]
    pub(super) fn remove(&mut self, place: Place) {
        for j in 0..3 {
            self.sum[j] = self.sum[j].wrapping_sub(place[j]);
        }
        self.count = self.count.wrapping_sub(1);
    }

    /// Returns how far the position is from the mean of those around, times their number.
    #[inline]
    pub(super) fn laplacian(&self) -> Place {
        let mut laplacian = [0; 3];
        for j in 0..3 {
            laplacian[j] = i32::from(self.place[j]).wrapping_mul(self.count.into()).wrapping_sub(self.sum[j]);
        }
        laplacian
    }
}

/// The features of a mark: valence, used corners, whether the fan is open and has been split in this batch; ages; distance from the mean.
const AGES: usize = 16 * 8 * 4;
const DISTANCES: usize = AGES + 8 * 8;
const MARK_FEATURES: usize = DISTANCES + 32;

/// What an edge of a fan is to a run of corners: its first edge, one within, or its last one. Scores have one more, which is not used, so that rows have a power of two.
const FIRST: usize = 0;
const WITHIN: usize = 1;
const LAST: usize = 2;
type Roles = [i32; 4];
/// The features of an edge: its shape, and the valence at its other end; and those of the number of corners.
const SHAPES: usize = 9 * 16;
const VALENCES: usize = 8 * 8;
const COUNTS: usize = 8 * 32;
/// How fast the scores of runs move, in 1/128.
const RUN_RATE: i32 = 5;
/// So many runs are all learned from, of later ones one in four: that takes a fifth less time, and 0.04 bits more per vertex.
const LEARNED_RUNS: u32 = 1 << 11;
/// A fan of more corners has no choices by scores: they would take time in proportion to the square.
const MOST_CHOICES: usize = 24;

/// The models of splits.
#[derive(Debug, Clone)]
pub(super) struct SplitModel {
    marks: Scores,
    sides: Simple,
    shapes: Vec<Roles>,
    valences: Vec<Roles>,
    counts: Vec<i32>,
    /// The mean of the logarithm of the distances of fans from the mean of those around, in 1/256 of 1/8.
    usual: i32,
    edges: Edges,
    /// The runs that were coded.
    run_count: u32,
    /// The scores of all runs of a fan, then their weights.
    weights: Vec<i32>,
}

/// The features of the edges of a fan.
#[derive(Debug, Clone, Default)]
struct Edges {
    shapes: [usize; 32],
    valences: [usize; 32],
}

/// A fan with its corners, and the fans at the other ends of its edges: one more than the corners.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ring<'a> {
    pub(super) fan: u32,
    pub(super) corners: &'a [u32],
    pub(super) around: &'a [u32],
    pub(super) is_open: bool,
}

impl SplitModel {
    pub(super) fn new() -> Self {
        Self {
            marks: Scores::new(MARK_FEATURES),
            sides: Simple::new(4),
            shapes: vec![Roles::default(); SHAPES],
            valences: vec![Roles::default(); VALENCES],
            counts: vec![0; COUNTS],
            usual: 0,
            edges: Edges::default(),
            run_count: 0,
            weights: vec![0; MOST_CHOICES * MOST_CHOICES],
        }
    }

    /// Codes whether a fan is split, after `done` splits in this batch.
    #[inline]
    pub(super) fn code_mark<C: BitCoder>(
        &mut self,
        coder: &mut C,
        fan: &Fan,
        batch: u32,
        done: usize,
        bit: bool,
    ) -> bool {
        let open = usize::from(fan.is_open);
        let n = (fan.count as usize).saturating_sub(open);
        let used = fan.used as usize;
        if n + open < 2 || n > MOST_CORNERS || used >= n && !fan.is_open {
            return false;
        }
        let [x, y, z] = fan.laplacian().map(|x| u64::from(x.unsigned_abs()));
        let distance = logarithm(x + y + z + 1) - logarithm(fan.count.into());
        let since = |other: u8| usize::from((batch as u8).wrapping_sub(other).min(7));
        let (age, quiet) = (since(fan.born), since(fan.split));
        let usual = &mut self.usual;
        let relative = ((distance - (*usual >> 8)) >> 1) + 16;
        *usual += (distance * 256 - *usual) >> 7;
        let features = [
            (n.min(15) * 8 + used.min(7)) * 4 + done.min(1) * 2 + open,
            AGES + age * 8 + quiet,
            DISTANCES + relative.clamp(0, 31).cast_unsigned() as usize,
        ];
        self.marks.code(coder, features, bit)
    }

    /// Codes which corners of a fan move. `wanted` is the split to be encoded.
    pub(super) fn code_split<C: BitCoder>(
        &mut self,
        coder: &mut C,
        (surface, fans, batch): (&Surface, &[Fan], u32),
        ring: Ring<'_>,
        wanted: Option<Split>,
    ) -> Split {
        let (n, is_open) = (ring.corners.len(), ring.is_open);
        let is_free = |i: usize| surface.mark(ring.corners[i]) != batch;
        let can_move = (0..n).any(is_free);
        if is_open {
            let moves_none = wanted.is_some_and(|split| split.count == 0);
            if !can_move || self.sides.code(coder, 0, moves_none) {
                let at_start = self.sides.code(coder, 1, wanted.is_some_and(|split| split.start == 0));
                let start = if at_start { 0 } else { n };
                return Split { start, count: 0, is_open, adds: [!at_start, at_start] };
            }
        }
        let run = wanted.map_or([0, 1], |split| [split.start, split.count]);
        let [start, count] = match () {
            () if !can_move => [0, 1],
            () if n > MOST_CHOICES => code_plain(coder, is_free, (n, is_open), run),
            () => {
                self.look_around(fans, &ring);
                self.code_run(coder, is_free, (n, is_open), run)
            }
        };
        let mut adds = [true; 2];
        if is_open && start == 0 {
            adds[0] = self.sides.code(coder, 2, wanted.is_some_and(|split| split.adds[0]));
        }
        if is_open && start + count == n && adds[0] {
            adds[1] = self.sides.code(coder, 3, wanted.is_some_and(|split| split.adds[1]));
        }
        Split { start, count, is_open, adds }
    }

    /// Finds the features of the edges of a fan.
    #[inline]
    fn look_around(&mut self, fans: &[Fan], ring: &Ring<'_>) {
        let center = fans[ring.fan as usize].place();
        let n = ring.corners.len();
        let edge_count = if ring.is_open { n + 1 } else { n };
        let of_ring = n.clamp(4, 11) - 4;
        let of = |i: usize| &fans[ring.around[i] as usize];
        let (mut before, mut at, mut count) = (of(n - 1).place(), of(0).place(), of(0).count);
        let mut lengths = [0; 32];
        let mut sum = 0;
        for i in 0..edge_count.min(32) {
            let next = of((i + 1).min(n));
            let after = next.place();
            let square = square_distance(at, center);
            sum += square;
            let length = logarithm(square);
            lengths[i] = length;
            let across = logarithm(square_distance(before, after));
            let is_border = ring.is_open && (i == 0 || i == n);
            let chord = if is_border { 8 } else { ((length - across + 16) >> 2).clamp(0, 7) };
            self.edges.shapes[i] = chord.cast_unsigned() as usize * 16;
            self.edges.valences[i] = (usize::from(count.clamp(3, 10)) - 3) * 8 + of_ring;
            (before, at, count) = (at, after, next.count);
        }
        let mean = logarithm(sum) - logarithm(edge_count as u64);
        for (shape, length) in self.edges.shapes.iter_mut().zip(lengths).take(edge_count) {
            let relative = ((5 * (length - mean)) >> 4) + 8;
            *shape += relative.clamp(0, 15).cast_unsigned() as usize;
        }
    }

    /// Codes a run of free corners: the first one, and their number.
    #[inline]
    fn code_run<C: BitCoder>(
        &mut self,
        coder: &mut C,
        is_free: impl Fn(usize) -> bool,
        (n, is_open): (usize, bool),
        wanted: [usize; 2],
    ) -> [usize; 2] {
        // 1. The scores of a run are those of its first edge, of the edges within, of the last edge, and of its length. Around a closed fan,
        //    edges are counted twice.
        let edge_count = if is_open { n + 1 } else { n };
        let (mut firsts, mut ends, mut within) = ([0; 64], [0; 64], 0);
        for i in 0..edge_count.min(32) {
            let (shape, valence) =
                (&self.shapes[self.edges.shapes[i]], &self.valences[self.edges.valences[i]]);
            ends[i] = within + shape[LAST] + valence[LAST];
            within += shape[WITHIN] + valence[WITHIN];
            firsts[i] = shape[FIRST] + valence[FIRST] - within;
        }
        if !is_open {
            (0..n.min(32)).for_each(|i| ends[n + i] = ends[i] + within);
        }
        let (mut lengths, mut run) = ([0; 32], 0);
        for turn in if is_open { 0..1 } else { 0..2 } {
            for i in (0..n.min(32)).rev() {
                run = if is_free(i) { run + 1 } else { 0 };
                lengths[i] = if turn == 1 { run.min((n - 1).max(1)) } else { run };
            }
        }
        let counts = &mut self.counts[32 * (n.clamp(4, 11) - 4)..][..32];
        let (mut number, mut most) = (0, i32::MIN);
        for i in 0..n.min(32) {
            let length = lengths[i];
            let runs = &mut self.weights[number..number + length];
            for ((run, end), count) in runs.iter_mut().zip(&ends[i + 1..]).zip(&counts[1..]) {
                *run = firsts[i] + end + count;
                most = most.max(*run);
            }
            number += length;
        }
        self.run_count = self.run_count.wrapping_add(1);
        let learns = self.run_count <= LEARNED_RUNS || self.run_count.is_multiple_of(4);
        // 2. Their weights, and the sums of those with a first edge, with a last one, and with a number of corners.
        let (mut of_firsts, mut of_ends, mut of_counts) = ([0; 32], [0; 64], [0; 32]);
        let (mut all, mut part, mut at) = (0, 0, 0);
        for i in 0..n.min(32) {
            let before = all;
            let runs = &mut self.weights[at..at + lengths[i]];
            for run in &mut *runs {
                *run = (FALLS[place_of((most - *run).cast_unsigned())] >> 12).cast_signed();
                all += *run;
            }
            of_firsts[i] = all - before;
            at += lengths[i];
            if i == wanted[0] {
                part = before + runs.iter().take(wanted[1].saturating_sub(1)).sum::<i32>();
            }
            if learns {
                let of_runs = of_ends[i + 1..].iter_mut().zip(&mut of_counts[1..]);
                for (run, (end, count)) in runs.iter().zip(of_runs) {
                    *end += run;
                    *count += run;
                }
            }
        }
        // 3. The choice.
        // A run that is not among them is another one, which the encoder notices.
        let part = part.min(all - 1);
        let part = coder.seek(all.cast_unsigned(), part.cast_unsigned()).cast_signed();
        let (mut start, mut passed, mut at) = (0, 0, 0);
        while part >= passed + of_firsts[start] {
            passed += of_firsts[start];
            at += lengths[start];
            start += 1;
        }
        let mut count = 1;
        while part >= passed + self.weights[at] {
            passed += self.weights[at];
            at += 1;
            count += 1;
        }
        coder.take(passed.cast_unsigned(), self.weights[at].cast_unsigned());
        if !learns {
            return [start, count];
        }
        // 4. Learn. An edge is within the runs that have begun before it and not ended.
        let unit = u32::MAX / all.cast_unsigned();
        let share = |weight: i32| ((weight.cast_unsigned() * unit) >> 16).cast_signed();
        let mut open = if is_open { 0 } else { all - of_ends[..n].iter().sum::<i32>() };
        for i in 0..edge_count.min(32) {
            let mut roles = [of_firsts[i], 0, of_ends[i], 0];
            if !is_open {
                roles[LAST] += of_ends[n + i];
            }
            open -= roles[LAST];
            roles[WITHIN] = open;
            open += roles[FIRST];
            let is = |role: bool| i32::from(role) << 16;
            let steps = match i.checked_sub(start) {
                Some(steps) => steps,
                None if is_open => usize::MAX,
                None => i + n - start,
            };
            let is_within = steps > 0 && steps < count;
            let errors = [
                is(i == start) - share(roles[FIRST]),
                is(is_within) - share(roles[WITHIN]),
                is(steps == count) - share(roles[LAST]),
                0,
            ];
            let rows = [&mut self.shapes[self.edges.shapes[i]], &mut self.valences[self.edges.valences[i]]];
            for row in rows {
                for role in 0..4 {
                    learn(&mut row[role], errors[role], RUN_RATE);
                }
            }
        }
        for i in 1..=n.min(31) {
            let error = if i == count { 1 << 16 } else { 0 } - share(of_counts[i]);
            learn(&mut counts[i], error, RUN_RATE);
        }
        [start, count]
    }
}

/// Codes a run of free corners where there are many.
fn code_plain<C: BitCoder>(
    coder: &mut C,
    is_free: impl Fn(usize) -> bool,
    (n, is_open): (usize, bool),
    [start, count]: [usize; 2],
) -> [usize; 2] {
    let choose = |coder: &mut C, number: usize, wanted: usize| {
        let bits = usize::BITS - (number - 1).leading_zeros();
        code_bits(coder, bits, wanted as u32) as usize % number
    };
    let free: Vec<usize> = (0..n).filter(|&i| is_free(i)).collect();
    let wanted = free.iter().position(|&i| i == start).unwrap_or(0);
    let start = free[choose(coder, free.len(), wanted)];
    let largest = if is_open { n - start } else { (n - 1).max(1) };
    let run = (1..largest).find(|&i| !is_free((start + i) % n)).unwrap_or(largest);
    [start, 1 + choose(coder, run, count.saturating_sub(1))]
}
