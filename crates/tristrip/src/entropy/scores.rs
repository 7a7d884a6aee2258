//! Choices by scores: each feature of a choice adds to its score, and the probability of a choice
//! is proportional to the exponential of its score.
//!
//! # Algorithm
//! After a choice, each score moves by the difference between the outcome and its probability. This
//! is the gradient of the number of bits spent on the choice. A decision is a choice between a
//! score and 0.
//!
//! Scores are integers modulo 2³², in units of 1/65536 of a natural logarithm.
//!
//! # Complexity
//! O(1) per feature.
//!
//! # References
//! `McFadden`: *Conditional Logit Analysis of Qualitative Choice Behavior*, 1974.

use super::range_coder::{BitCoder, WHOLE};

/// Exponentials in steps of 1/32 of a natural logarithm: 2²⁴ e^(−k / 32), rounded down at each
/// step.
const FALLS: [u32; 256] = {
    let mut falls = [1 << 24; 256];
    let mut k = 1;
    while k < falls.len() {
        falls[k] = ((falls[k - 1] as u64 * 63520) >> 16) as u32;
        k += 1;
    }
    falls
};

/// `FALLS` scaled to 4096 for the first.
const WEIGHTS: [u16; 256] = {
    let mut weights = [0; 256];
    let mut k = 0;
    while k < weights.len() {
        weights[k] = (FALLS[k] >> 12) as u16;
        k += 1;
    }
    weights
};

/// The probabilities of a decision as shares of [`WHOLE`], by score in steps of 1/32 of a natural
/// logarithm. The first half is for negative scores.
const SHARES: [u16; 512] = {
    let mut shares = [0; 512];
    let mut k = 0;
    while k < 256 {
        let less = ((FALLS[k] as u64) << 16) / (FALLS[k] as u64 + (1 << 24));
        shares[255 - k] = less as u16;
        shares[256 + k] = (WHOLE as u64 - less) as u16;
        k += 1;
    }
    shares
};

/// Returns the weight of a choice, from 1 to 4096, given the difference of its score from the
/// largest.
#[inline]
pub(crate) fn weight_of(difference: u32) -> u32 {
    WEIGHTS[(difference >> 11).min(255) as usize].into()
}

/// The learning rate of decisions: scores move by 2⁻⁴ of an error.
const DECISION_RATE: i32 = 4;

/// The scores of the features of one kind of decision.
#[derive(Debug, Clone)]
pub(crate) struct Scores {
    scores: Vec<i32>,
}

impl Scores {
    pub(crate) fn new(size: usize) -> Self {
        Self { scores: vec![0; size] }
    }

    /// Codes a decision with some features, each an index into the scores.
    #[inline]
    pub(crate) fn code<C: BitCoder, const N: usize>(
        &mut self,
        coder: &mut C,
        features: [usize; N],
        bit: bool,
    ) -> bool {
        let sum = features.iter().fold(0, |sum: i32, &feature| sum.wrapping_add(self.scores[feature]));
        let place = ((sum >> 11) + 256).clamp(0, 511);
        let share: u32 = SHARES[place.cast_unsigned() as usize].into();
        let bit = coder.code(share, bit);
        let error = (i32::from(bit) << 16) - share.cast_signed();
        for feature in features {
            self.scores[feature] = self.scores[feature].wrapping_add(error >> DECISION_RATE);
        }
        bit
    }
}
