//! Numbers as decisions: the size as a bucket, found outward from the bucket that is usual for numbers of this scale, then the sign, then the rest.
//!
//! Buckets have the bounds 0, 1, 2, 3, 4, 6, 8, 12, 16, 24, … : the bucket of a size is the whole part of twice its logarithm. How large numbers
//! of a scale are is learned: the middle of each scale follows what has been coded.

use super::mixing::{INPUTS, Mixed, Simple, code_bits};
use super::range_coder::BitCoder;

/// The scales: twice the binary logarithm of a square, so that one step is a quarter of an octave.
const SCALES: usize = 96;
/// The steps away from the usual bucket that have contexts of their own; the first goes down or up from it.
const STEPS: usize = 32;
const FIRST_STEP: usize = 16;
/// The largest bucket.
const MOST_BUCKET: usize = 59;

/// Returns twice the binary logarithm, roughly: the bucket of a size.
#[inline]
pub(super) fn halves(x: u64) -> usize {
    if x < 2 {
        return x as usize;
    }
    let bits = x.ilog2();
    (2 * bits) as usize + (x >> (bits - 1) & 1) as usize
}

/// The context of a number.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct NumberContext {
    /// Which of the numbers that belong together it is.
    pub(super) axis: usize,
    /// Twice the binary logarithm of the square of what it is expected to be.
    pub(super) scale: usize,
    /// What else is known, each less than the number of contexts of the model.
    pub(super) contexts: [usize; INPUTS - 1],
}

/// The model of numbers of one kind.
#[derive(Debug, Clone)]
pub(super) struct NumberModel {
    context_count: usize,
    /// The usual bucket of each axis and scale, in 1/16.
    middles: Vec<i32>,
    buckets: Mixed,
    signs: Simple,
    halves: Simple,
}

impl NumberModel {
    pub(super) fn new(axes: usize, context_count: usize) -> Self {
        let mut sizes = [axes * STEPS * context_count; INPUTS];
        sizes[0] = axes * SCALES * STEPS;
        let middle = |scale: usize| (scale as u32 * 8).saturating_sub(32).cast_signed();
        Self {
            context_count,
            middles: (0..axes * SCALES).map(|i| middle(i % SCALES)).collect(),
            buckets: Mixed::new(sizes, axes * STEPS),
            signs: Simple::new(axes),
            halves: Simple::new(MOST_BUCKET + 1),
        }
    }

    /// Codes a number. Also returns how many buckets it is above what is usual.
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        context: NumberContext,
        number: i32,
    ) -> (i32, i32) {
        let NumberContext { axis, scale, contexts } = context;
        let of_scale = axis * SCALES + scale.min(SCALES - 1);
        let middle = &mut self.middles[of_scale];
        let usual = ((*middle + 8) >> 4).cast_unsigned() as usize;
        let size = number.unsigned_abs();
        let wanted = halves(size.into());
        // 1. The bucket, upwards or downwards from the usual one.
        let mut decide = |step: usize, bit: bool| {
            let mut slots = [of_scale * STEPS + step; INPUTS];
            // The steps of a context lie together.
            for (slot, context) in slots[1..].iter_mut().zip(contexts) {
                *slot = (axis * self.context_count + context) * STEPS + step;
            }
            self.buckets.code(coder, slots, axis * STEPS + step, bit)
        };
        let mut bucket = usual;
        if usual == 0 || decide(FIRST_STEP, wanted >= usual) {
            while bucket < MOST_BUCKET
                && decide((FIRST_STEP + 1 + bucket - usual).min(STEPS - 1), wanted > bucket)
            {
                bucket += 1;
            }
        } else {
            bucket -= 1;
            while bucket > 0
                && decide(FIRST_STEP - 1 - (usual - 1 - bucket).min(FIRST_STEP - 1), wanted < bucket)
            {
                bucket -= 1;
            }
        }
        let [found, expected] = [bucket, usual].map(|bucket| (bucket as u32).cast_signed());
        *middle += (found * 16 - *middle) >> 4;
        let above = found - expected;
        if bucket == 0 {
            return (0, above);
        }
        // 2. The sign, and the place within the bucket.
        let is_negative = self.signs.code(coder, axis, number < 0);
        let size = if bucket < 4 {
            bucket as u32
        } else {
            let rest = bucket as u32 / 2 - 2;
            let least = (2 | bucket as u32 & 1) << (rest + 1);
            let high = self.halves.code(coder, bucket, size >> rest & 1 != 0);
            least | u32::from(high) << rest | code_bits(coder, rest, size)
        };
        let size = size.cast_signed();
        (if is_negative { -size } else { size }, above)
    }
}

/// Codes a number that is usually small, below 2²⁴, with a model of 32 decisions.
pub(super) fn code_small<C: BitCoder>(coder: &mut C, model: &mut Simple, number: u32) -> u32 {
    let wanted = 32 - (number + 1).leading_zeros();
    let mut bits = 1;
    while bits < 25 && model.code(coder, bits as usize, wanted > bits) {
        bits += 1;
    }
    (1 << (bits - 1) | code_bits(coder, bits - 1, number + 1)) - 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stream::range_coder::{RangeDecoder, RangeEncoder};
    use proptest::prelude::*;

    /// Numbers of any size up to those of the largest bucket.
    fn number() -> impl Strategy<Value = i32> {
        let most = (3 << 28) + (1 << 28) - 1;
        prop_oneof![-10..10_i32, -1000..1000_i32, -most..=most, Just(most), Just(-most)]
    }

    fn context() -> impl Strategy<Value = NumberContext> {
        (0..3_usize, 0..200_usize, prop::array::uniform5(0..7_usize))
            .prop_map(|(axis, scale, contexts)| NumberContext { axis, scale, contexts })
    }

    proptest! {
        #[test]
        fn numbers_are_read_back(numbers in prop::collection::vec((context(), number()), 0..200)) {
            let (mut model, mut encoder) = (NumberModel::new(3, 7), RangeEncoder::new());
            let written: Vec<_> =
                numbers.iter().map(|&(context, number)| model.code(&mut encoder, context, number)).collect();
            let bytes = encoder.finish();
            let (mut model, mut decoder) = (NumberModel::new(3, 7), RangeDecoder::new(&bytes));
            for (&(context, number), written) in numbers.iter().zip(written) {
                prop_assert_eq!(written.0, number);
                prop_assert_eq!(model.code(&mut decoder, context, 0), written);
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
        let buckets: Vec<usize> = [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 12, 15, 16].map(halves).into();
        assert_eq!(buckets, [0, 1, 2, 3, 4, 4, 5, 5, 6, 6, 7, 7, 8]);
        assert_eq!(halves(u64::MAX), 127);
    }
}
