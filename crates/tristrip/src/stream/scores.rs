//! Choices by scores: each feature of a choice adds to its score, and the probability of a choice is in proportion to the exponential of its score.
//!
//! # Algorithm
//! After a choice, each score moves by the difference of what was chosen and its probability: the gradient of the bits that the choice took. A
//! decision is a choice between a score and 0.
//!
//! Scores are integers, in units of 1/65536 of a natural logarithm.
//!
//! # Complexity
//! O(1) per feature.
//!
//! # References
//! `McFadden`: *Conditional Logit Analysis of Qualitative Choice Behavior*, 1974.

use super::range_coder::{BitCoder, WHOLE};

/// Falls by one part in 32 of a natural logarithm: 2²⁴ e^(−k / 32), rounded down at each step.
pub(super) const FALLS: [u32; 256] = {
    let mut falls = [1 << 24; 256];
    let mut k = 1;
    while k < falls.len() {
        falls[k] = ((falls[k - 1] as u64 * 63520) >> 16) as u32;
        k += 1;
    }
    falls
};

/// The shares of [`WHOLE`] of a decision whose score is less than 0.
const LESS: [u16; 256] = {
    let mut less = [0; 256];
    let mut k = 0;
    while k < less.len() {
        less[k] = (((FALLS[k] as u64) << 16) / (FALLS[k] as u64 + (1 << 24))) as u16;
        k += 1;
    }
    less
};

/// Where in [`FALLS`] a difference of scores is.
#[inline]
pub(super) fn place_of(difference: u32) -> usize {
    (difference >> 11).min(255) as usize
}

/// The largest score.
const MOST_SCORE: i32 = 1 << 21;

/// Moves a score by an error in 1/65536, at a rate in 1/128.
#[inline]
pub(super) fn learn(score: &mut i32, error: i32, rate: i32) {
    *score = (*score + ((error * rate) >> 7)).clamp(-MOST_SCORE, MOST_SCORE);
}

/// How fast the scores of decisions move.
const DECISION_RATE: i32 = 10;

/// The scores of one kind of decision, which has some features.
#[derive(Debug, Clone)]
pub(super) struct Scores {
    scores: Vec<i32>,
}

impl Scores {
    pub(super) fn new(size: usize) -> Self {
        Self { scores: vec![0; size] }
    }

    /// Codes a decision with some features, each less than the number of scores.
    #[inline]
    pub(super) fn code<C: BitCoder, const N: usize>(
        &mut self,
        coder: &mut C,
        features: [usize; N],
        bit: bool,
    ) -> bool {
        let mut sum = 0;
        for feature in features {
            sum += self.scores[feature];
        }
        let less = LESS[place_of(sum.unsigned_abs())].into();
        let share = if sum < 0 { less } else { WHOLE - less };
        let bit = coder.code(share, bit);
        let error = if bit { WHOLE.cast_signed() } else { 0 } - share.cast_signed();
        for feature in features {
            learn(&mut self.scores[feature], error, DECISION_RATE);
        }
        bit
    }
}
