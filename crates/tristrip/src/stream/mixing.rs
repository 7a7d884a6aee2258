//! Probabilities of decisions, learned while coding: several contexts each have an opinion, and weights that are learned too mix them.
//!
//! ```text
//! context 0 ─▶ probability ─▶ logit ─ × weight 0 ─┐
//! context 1 ─▶ probability ─▶ logit ─ × weight 1 ─┼─▶ sum ─▶ probability ─▶ range coder
//! …                                               ┘
//! ```
//! # Algorithm
//! 1. Each context has a slot with a probability and a count. After a decision the probability moves towards it by one part in count + 1.5, and
//!    the count grows up to a limit: at first the slot is the mean of what it has seen, later it follows changes.
//! 2. The logits, ln(p / (1 − p)), are summed with the weights of a set; the sum is the logit of the mixed probability.
//! 3. Each weight moves by the error of the mixed probability times its logit: the gradient of the bits that the decision took.
//!
//! Everything is an integer of at most 32 bits: probabilities of 22 bits in slots and 16 bits for the coder, logits in units of 1/256, weights in units of 2⁻¹⁴.
//!
//! # Complexity
//! O(1) per decision and input; 4 bytes per slot.
//!
//! # References
//! Mahoney: *Adaptive Weighing of Context Models for Lossless Data Compression*, 2005.

use super::range_coder::{BitCoder, WHOLE};

/// The shares of [`WHOLE`] that belong to the logits 0, 1/4, 1/2, … 8.
const SHARES: [i32; 33] = [
    32768, 36843, 40793, 44511, 47911, 50941, 53581, 55834, 57724, 59287, 60565, 61598, 62428, 63090, 63615,
    64030, 64357, 64614, 64816, 64974, 65097, 65194, 65269, 65328, 65374, 65410, 65438, 65459, 65476, 65489,
    65500, 65508, 65514,
];

/// The largest logit, in units of 1/256.
const MOST_LOGIT: i32 = 2047;

/// A slot counts up to this.
const MOST_COUNT: u32 = 250;

/// The largest weight, in units of 2⁻¹⁴.
const MOST_WEIGHT: i32 = (1 << 17) - 1;

/// The contexts of each decision.
pub(super) const INPUTS: usize = 6;

/// Returns the probability of a logit.
const fn share_of(logit: i32) -> i32 {
    let size = if logit < 0 { -logit } else { logit };
    let (at, rest) = ((size >> 6).cast_unsigned() as usize, size & 63);
    let next = if at < 32 { SHARES[at + 1] } else { SHARES[32] };
    let share = SHARES[at] + (((next - SHARES[at]) * rest) >> 6);
    if logit < 0 { WHOLE.cast_signed() - share } else { share }
}

/// The logit of each probability of 12 bits.
const LOGITS: [i16; 4096] = {
    let mut logits = [0; 4096];
    let (mut logit, mut share) = (-MOST_LOGIT, 0);
    while share < 4096 {
        while logit < MOST_LOGIT && share_of(logit) < (share << 4) + 8 {
            logit += 1;
        }
        logits[share.cast_unsigned() as usize] = logit as i16;
        share += 1;
    }
    logits
};

/// 2¹⁵ / (count + 1.5).
const RATES: [u16; MOST_COUNT as usize + 1] = {
    let mut rates = [0; MOST_COUNT as usize + 1];
    let mut count = 0;
    while count < rates.len() {
        rates[count] = (65536 / (2 * count + 3)) as u16;
        count += 1;
    }
    rates
};

/// A slot: a probability of 22 bits above a count of 10 bits.
const NEW_SLOT: u32 = 1 << 31;

#[inline]
fn learn(slot: &mut u32, bit: bool) {
    let (share, count) = ((*slot >> 10).cast_signed(), *slot & 1023);
    let target = if bit { (1 << 22) - 1 } else { 0 };
    let change = (((target - share) >> 6) * i32::from(RATES[count as usize])) >> 9;
    *slot = (share + change).cast_unsigned() << 10 | (count + u32::from(count < MOST_COUNT));
}

/// The model of one kind of decision.
#[derive(Debug, Clone)]
pub(super) struct Mixed {
    /// The slots of all inputs, one after the other.
    slots: Vec<u32>,
    starts: [usize; INPUTS],
    weights: Vec<[i32; INPUTS]>,
}

impl Mixed {
    /// Creates the slots of each input, and sets of weights.
    pub(super) fn new(sizes: [usize; INPUTS], sets: usize) -> Self {
        let weight = (13 << 14) / (10 * (INPUTS as u32).cast_signed());
        let mut total = 0;
        let starts = sizes.map(|size| {
            total += size;
            total - size
        });
        Self { slots: vec![NEW_SLOT; total], starts, weights: vec![[weight; INPUTS]; sets] }
    }

    /// Codes a decision in its contexts, each less than the number of slots of its input, with a set of weights.
    #[inline]
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        contexts: [usize; INPUTS],
        set: usize,
        bit: bool,
    ) -> bool {
        let weights = &mut self.weights[set];
        let mut places = contexts;
        let mut logits = [0; INPUTS];
        let mut sum = 0;
        for i in 0..INPUTS {
            places[i] += self.starts[i];
            logits[i] = i32::from(LOGITS[(self.slots[places[i]] >> 20) as usize]);
            sum += (logits[i] * weights[i]) >> 7;
        }
        let share = share_of((sum >> 7).clamp(-MOST_LOGIT, MOST_LOGIT));
        let bit = coder.code(share.cast_unsigned(), bit);
        let error = if bit { WHOLE.cast_signed() - share } else { -share };
        for i in 0..INPUTS {
            let change = (error * logits[i] + (1 << 16)) >> 17;
            weights[i] = (weights[i] + change).clamp(-MOST_WEIGHT, MOST_WEIGHT);
            learn(&mut self.slots[places[i]], bit);
        }
        bit
    }
}

/// A decision with a probability in each of some contexts, without mixing.
#[derive(Debug, Clone)]
pub(super) struct Simple {
    slots: Vec<u32>,
}

impl Simple {
    pub(super) fn new(size: usize) -> Self {
        Self { slots: vec![NEW_SLOT; size] }
    }

    /// Codes a decision in a context, which is less than the number of slots.
    #[inline]
    pub(super) fn code<C: BitCoder>(&mut self, coder: &mut C, context: usize, bit: bool) -> bool {
        let slot = &mut self.slots[context];
        let share = (*slot >> 16).clamp(32, WHOLE - 32);
        let bit = coder.code(share, bit);
        learn(slot, bit);
        bit
    }
}

/// Codes the lowest bits of a number, each as likely as not, the highest first.
pub(super) fn code_bits<C: BitCoder>(coder: &mut C, count: u32, number: u32) -> u32 {
    (0..count).rev().fold(0, |read, i| {
        let bit = coder.code(WHOLE / 2, number >> i & 1 != 0);
        read << 1 | u32::from(bit)
    })
}
