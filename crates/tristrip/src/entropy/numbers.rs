//! Codes integers as decisions. One of sixteen symbols codes the bucket of the size, relative to
//! the expected bucket. The position within the bucket and the sign are coded next.
//!
//! The buckets start at 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, …. The bucket of a size is the integer
//! part of twice its binary logarithm.
//!
//! # Algorithm
//! The *level*, the logarithm of the expected size, is a weighted sum of features. The weights are
//! updated by gradient descent on the squared error.
//!
//! # References
//! Widrow, Hoff: *Adaptive Switching Circuits*, 1960 (the weights).

use super::range_coder::{BitCoder, code_bits};
use super::slots::Simple;

/// The number of levels with their own symbols, in quarters of an octave, starting at −2.
const CONTEXTS: u32 = 80;
/// The symbol of the expected bucket.
const MIDDLE: i32 = 9;
/// The last symbol. After the first and the last symbol, the distance to the actual bucket is
/// coded.
const LAST: i32 = 15;
/// The largest bucket.
const MAX_BUCKET: i32 = 59;

/// Returns the binary logarithm of a number from 1 to 2⁵³ − 1, in units of 1/8, linearly
/// interpolated between powers of two. The result is read from the exponent and the first mantissa
/// bits of the number as a float.
#[inline]
pub(crate) fn logarithm(x: u64) -> i32 {
    ((x.cast_signed() as f64).to_bits() >> 49) as i32 - 8 * 1023
}

/// Returns the bucket of a size: about twice its binary logarithm.
#[inline]
fn bucket_of(x: u32) -> i32 {
    if x < 2 { x.cast_signed() } else { logarithm(x.into()) >> 2 }
}

/// Predicts the levels of one kind of number, in 1/16 of an octave, from `N` features that have
/// about the same unit.
#[derive(Debug, Clone)]
pub(crate) struct NumberLevel<const N: usize> {
    weights: [i32; N],
}

impl<const N: usize> NumberLevel<N> {
    /// Creates a predictor with weights in 1/65536.
    pub(crate) fn new(weights: [i32; N]) -> Self {
        Self { weights }
    }

    #[inline]
    pub(crate) fn expect(&self, features: [i32; N]) -> i32 {
        let mut sum = 0_i32;
        for i in 0..N {
            sum = sum.wrapping_add(self.weights[i].wrapping_mul(features[i]));
        }
        sum >> 16
    }

    /// Learns from the error of a predicted level. Features are less than 1024; weights wrap modulo
    /// 2³².
    #[inline]
    pub(crate) fn learn(&mut self, features: [i32; N], error: i32) {
        let error = error.clamp(-32, 32);
        for i in 0..N {
            self.weights[i] = self.weights[i].wrapping_add((error * features[i]) >> 3);
        }
    }
}

/// The model of one kind of number.
#[derive(Debug, Clone)]
pub(crate) struct NumberModel {
    symbols: Simple,
    escapes: Simple,
}

impl NumberModel {
    /// Creates a model with separate statistics for each of some sets of numbers.
    pub(crate) fn new(sets: usize) -> Self {
        Self { symbols: Simple::new(16 * CONTEXTS as usize * sets), escapes: Simple::new(32) }
    }

    /// Codes a number with the statistics of a set. Returns the number, and the difference between
    /// its level and the expected level.
    #[inline]
    pub(crate) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        set: usize,
        level: i32,
        number: i32,
    ) -> (i32, i32) {
        let usual = (level >> 3).clamp(0, MAX_BUCKET);
        let context =
            (level.wrapping_add(32) >> 2).clamp(0, CONTEXTS.cast_signed() - 1).cast_unsigned() as usize;
        let size = number.unsigned_abs();
        let to_encode = bucket_of(size);
        // 1. The bucket.
        let symbol = (to_encode - usual + MIDDLE).clamp(0, LAST).cast_unsigned() as usize;
        let symbol = self.symbols.code_number(coder, set * CONTEXTS as usize + context, 4, symbol);
        let of_symbol = (symbol as u32).cast_signed();
        let mut bucket = usual - MIDDLE + of_symbol;
        if symbol == 0 && bucket > 0 {
            bucket -= code_small(coder, &mut self.escapes, (bucket - to_encode).max(0).cast_unsigned())
                .cast_signed();
        } else if of_symbol == LAST {
            bucket += code_small(coder, &mut self.escapes, (to_encode - bucket).max(0).cast_unsigned())
                .cast_signed();
        }
        let bucket = bucket.clamp(0, MAX_BUCKET).cast_unsigned();
        if bucket == 0 {
            return (0, (-16_i32).wrapping_sub(level));
        }
        // 2. The position within the bucket, and the sign.
        let rest = (bucket >> 1).max(1) - 1;
        let least = ((2 | bucket & 1) << rest) >> u32::from(bucket < 2);
        let low = size & ((1 << rest) - 1);
        let read = code_bits(coder, rest + 1, 2 * low + u32::from(number < 0));
        let size = least | read >> 1;
        let error = (2 * logarithm(2 * u64::from(size) + 1) - 16).wrapping_sub(level);
        let size = size.cast_signed();
        (if read & 1 != 0 { -size } else { size }, error)
    }
}

/// Codes a number below 2²⁴ that is usually small, with a model of 32 decisions.
pub(crate) fn code_small<C: BitCoder>(coder: &mut C, model: &mut Simple, number: u32) -> u32 {
    let to_encode = 32 - (number + 1).leading_zeros();
    let mut bits = 1;
    while bits < 25 && model.code(coder, bits as usize, to_encode > bits) {
        bits += 1;
    }
    (1 << (bits - 1) | code_bits(coder, bits - 1, number + 1)) - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::entropy::range_coder::{RangeDecoder, RangeEncoder};
    use proptest::prelude::*;

    /// Generates numbers of any size up to the largest bucket.
    fn number() -> impl Strategy<Value = i32> {
        let most = (3 << 28) + (1 << 28) - 1;
        prop_oneof![-10..10_i32, -1000..1000_i32, -most..=most, Just(most), Just(-most)]
    }

    proptest! {
        #[test]
        fn numbers_are_read_back(numbers in prop::collection::vec((0..3_usize, -100..1000_i32, number()), 0..200)) {
            let (mut model, mut encoder) = (NumberModel::new(3), RangeEncoder::new());
            let written: Vec<_> =
                numbers.iter().map(|&(set, level, number)| model.code(&mut encoder, set, level, number)).collect();
            let bytes = encoder.finish();
            let (mut model, mut decoder) = (NumberModel::new(3), RangeDecoder::new(&bytes));
            for (&(set, level, number), written) in numbers.iter().zip(written) {
                prop_assert_eq!(written.0, number);
                prop_assert_eq!(model.code(&mut decoder, set, level, 0), written);
            }
            prop_assert!(!decoder.is_past_end());
        }

        #[test]
        fn small_numbers_are_read_back(numbers in prop::collection::vec(prop_oneof![0..9_u32, 0..(1 << 24) - 1_u32], 0..200)) {
            let (mut model, mut encoder) = (Simple::new(32), RangeEncoder::new());
            for &number in &numbers {
                prop_assert_eq!(code_small(&mut encoder, &mut model, number), number);
            }
            let bytes = encoder.finish();
            let (mut model, mut decoder) = (Simple::new(32), RangeDecoder::new(&bytes));
            for &number in &numbers {
                prop_assert_eq!(code_small(&mut decoder, &mut model, 0), number);
            }
        }
    }

    #[test]
    fn buckets_are_twice_a_logarithm() {
        let buckets = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 15, 16].map(bucket_of);
        assert_eq!(buckets, [0, 1, 2, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8]);
        assert_eq!([1, 2, 3, 15, 16, (1 << 53) - 1].map(logarithm), [0, 8, 12, 31, 32, 423]);
    }
}
