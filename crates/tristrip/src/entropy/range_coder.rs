//! A range coder: converts decisions and choices with known probabilities to bytes, and back.
//!
//! A 32-bit range is split in proportion to the probability of each decision. When the range
//! becomes small, its top bytes are written. The same coder is used throughout the project. All
//! arithmetic is integer, so other implementations produce the same bytes.
//!
//! # Complexity
//! O(1) per decision; O(n) memory for n bytes.
//!
//! # References
//! Martin: *Range encoding: an algorithm for removing redundancy from a digitised message*, 1979.

/// The denominator of probabilities.
pub(crate) const WHOLE: u32 = 1 << 16;

/// The minimum range.
const MIN_RANGE: u32 = 1 << 24;

/// The maximum number of trailing zero bytes that are left out.
const MAX_TRIMMED: usize = 4;

/// An encoder or decoder. Code written against this trait serves both directions.
pub(crate) trait BitCoder {
    /// Codes a decision that is true with probability `probability` / [`WHOLE`], strictly between 0
    /// and 1. A decoder ignores `bit`. Returns the decision.
    fn code(&mut self, probability: u32, bit: bool) -> bool;

    /// Splits the range into 2^`bits` equal parts, at most 2¹⁶. Returns `part`, or, in a decoder,
    /// the part that was encoded. Call [`take`](Self::take) next.
    fn seek(&mut self, bits: u32, part: u32) -> u32;

    /// Takes `size` parts from `start`, which include the part of [`seek`](Self::seek).
    fn take(&mut self, start: u32, size: u32);

    /// Returns whether more bytes were read than exist. No encoder wrote what is decoded from then
    /// on.
    fn is_past_end(&self) -> bool {
        false
    }

    /// Returns the bits of all decisions so far.
    fn bits(&self) -> f64 {
        0.0
    }
}

/// A coder without output, for passes that only train models.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Rehearsal;

impl BitCoder for Rehearsal {
    #[inline]
    fn code(&mut self, _: u32, bit: bool) -> bool {
        bit
    }

    #[inline]
    fn seek(&mut self, _: u32, part: u32) -> u32 {
        part
    }

    #[inline]
    fn take(&mut self, _: u32, _: u32) {}
}

/// Codes the lowest `count` bits of a number, at most 32, with equal probabilities.
#[inline]
pub(crate) fn code_bits<C: BitCoder>(coder: &mut C, count: u32, number: u32) -> u32 {
    if count > 16 {
        let high = code_bits(coder, count - 16, number >> 16);
        return high << 16 | code_bits(coder, 16, number);
    }
    let number = coder.seek(count, number & ((1 << count) - 1));
    coder.take(number, 1);
    number
}

/// Encodes decisions as bytes.
#[derive(Debug, Clone)]
pub(crate) struct RangeEncoder {
    low: u64,
    range: u32,
    bytes: Vec<u8>,
}

impl RangeEncoder {
    pub(crate) fn new() -> Self {
        Self { low: 0, range: u32::MAX, bytes: Vec::new() }
    }

    /// Returns an upper bound of the number of bytes so far.
    pub(crate) fn len(&self) -> usize {
        self.bytes.len() + 4
    }

    #[inline]
    fn add(&mut self, start: u32) {
        self.low += u64::from(start);
        if self.low > u64::from(u32::MAX) {
            self.carry();
        }
    }

    #[inline]
    fn normalize(&mut self) {
        while self.range < MIN_RANGE {
            self.push_top_byte();
            self.range <<= 8;
        }
    }

    fn push_top_byte(&mut self) {
        self.bytes.push((self.low >> 24) as u8);
        self.low = (self.low << 8) & u64::from(u32::MAX);
    }

    /// Propagates a carry into the bytes written.
    fn carry(&mut self) {
        for byte in self.bytes.iter_mut().rev() {
            *byte = byte.wrapping_add(1);
            if *byte != 0 {
                break;
            }
        }
        self.low &= u64::from(u32::MAX);
    }

    /// Ends the bytes with as few as identify all decisions, given that zeros follow.
    pub(crate) fn finish(mut self) -> Vec<u8> {
        let most = self.low + u64::from(self.range - 1);
        let value = (0..32).rev().map(|zeros| most >> zeros << zeros).find(|&value| value >= self.low);
        self.low = value.unwrap_or(most);
        if self.low > u64::from(u32::MAX) {
            self.carry();
        }
        (0..4).for_each(|_| self.push_top_byte());
        let zeros = self.bytes.iter().rev().take(MAX_TRIMMED).take_while(|&&byte| byte == 0).count();
        self.bytes.truncate(self.bytes.len() - zeros);
        self.bytes
    }
}

impl BitCoder for RangeEncoder {
    #[inline]
    fn code(&mut self, probability: u32, bit: bool) -> bool {
        let bound = (self.range >> 16) * probability;
        if bit {
            self.range = bound;
        } else {
            self.range -= bound;
            self.add(bound);
        }
        self.normalize();
        bit
    }

    #[inline]
    fn seek(&mut self, bits: u32, part: u32) -> u32 {
        self.range >>= bits;
        part
    }

    #[inline]
    fn take(&mut self, start: u32, size: u32) {
        self.add(self.range * start);
        self.range *= size;
        self.normalize();
    }
}

/// Decodes decisions. Reads zeros after the end of the bytes.
#[derive(Debug, Clone)]
pub(crate) struct RangeDecoder<'a> {
    bytes: &'a [u8],
    at: usize,
    range: u32,
    code: u32,
}

impl<'a> RangeDecoder<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self { bytes, at: 0, range: u32::MAX, code: 0 };
        (0..4).for_each(|_| decoder.code = decoder.code << 8 | decoder.next_byte());
        decoder
    }

    #[inline]
    fn next_byte(&mut self) -> u32 {
        let byte = self.bytes.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        byte.into()
    }

    #[inline]
    fn normalize(&mut self) {
        while self.range < MIN_RANGE {
            self.code = self.code << 8 | self.next_byte();
            self.range <<= 8;
        }
    }
}

impl BitCoder for RangeDecoder<'_> {
    #[inline]
    fn code(&mut self, probability: u32, _: bool) -> bool {
        let bound = (self.range >> 16) * probability;
        let bit = self.code < bound;
        // The decision is unpredictable, so a branch would be expensive.
        let no = u32::from(bit).wrapping_sub(1);
        self.code -= bound & no;
        self.range = (self.range & no).wrapping_add((bound ^ no).wrapping_sub(no));
        self.normalize();
        bit
    }

    #[inline]
    fn seek(&mut self, bits: u32, _: u32) -> u32 {
        self.range >>= bits;
        (self.code / self.range).min((1 << bits) - 1)
    }

    #[inline]
    fn take(&mut self, start: u32, size: u32) {
        self.code -= start * self.range;
        self.range *= size;
        self.normalize();
    }

    fn bits(&self) -> f64 {
        8.0 * self.at as f64 - libm::log2(self.range.into())
    }

    fn is_past_end(&self) -> bool {
        self.at > self.bytes.len() + MAX_TRIMMED
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Encodes decisions, each with its probability.
    fn encoded(decisions: &[(u32, bool)]) -> (Vec<u8>, usize) {
        let mut encoder = RangeEncoder::new();
        for &(probability, bit) in decisions {
            assert_eq!(encoder.code(probability, bit), bit);
        }
        let bound = encoder.len();
        (encoder.finish(), bound)
    }

    /// Generates probabilities, often the smallest and the largest.
    fn probability() -> impl Strategy<Value = u32> {
        prop_oneof![1..WHOLE, Just(1), Just(WHOLE - 1), Just(WHOLE / 2), WHOLE - 40..WHOLE]
    }

    proptest! {
        #[test]
        fn choices_are_read_back(choices in prop::collection::vec((0..=16_u32, any::<[u32; 3]>()), 0..400)) {
            // One of a number of parts, within a run of them.
            let choice = |&(bits, [part, before, after]): &(u32, [u32; 3])| {
                let (total, part) = (1 << bits, part % (1 << bits));
                let start = part - before % (part + 1);
                (bits, part, start, part - start + 1 + after % (total - part))
            };
            let mut encoder = RangeEncoder::new();
            for (bits, part, start, size) in choices.iter().map(choice) {
                assert_eq!(encoder.seek(bits, part), part);
                encoder.take(start, size);
                code_bits(&mut encoder, part % 33, part.wrapping_mul(bits + 54321));
            }
            let bytes = encoder.finish();
            let mut decoder = RangeDecoder::new(&bytes);
            for (bits, part, start, size) in choices.iter().map(choice) {
                let found = decoder.seek(bits, 0);
                prop_assert!((start..start + size).contains(&found));
                decoder.take(start, size);
                let bits = u64::from(part.wrapping_mul(bits + 54321)) & ((1 << (part % 33)) - 1);
                prop_assert_eq!(u64::from(code_bits(&mut decoder, part % 33, 0)), bits);
            }
            prop_assert!(!decoder.is_past_end());
        }

        #[test]
        fn decisions_are_read_back(decisions in prop::collection::vec((probability(), any::<bool>()), 0..400)) {
            let (bytes, bound) = encoded(&decisions);
            prop_assert!(bytes.len() <= bound);
            let mut decoder = RangeDecoder::new(&bytes);
            for &(probability, bit) in &decisions {
                prop_assert_eq!(decoder.code(probability, !bit), bit);
            }
            prop_assert!(!decoder.is_past_end());
        }

        #[test]
        fn bits_are_those_of_the_probabilities(decisions in prop::collection::vec((probability(), any::<bool>()), 0..400)) {
            let share = |&(p, bit): &(u32, bool)| f64::from(if bit { p } else { WHOLE - p }) / f64::from(WHOLE);
            let ideal: f64 = decisions.iter().map(|decision| -libm::log2(share(decision))).sum();
            let (bytes, _) = encoded(&decisions);
            // A range of at least 24 bits is split into 16-bit shares.
            prop_assert!((bytes.len() * 8) as f64 <= ideal * 1.01 + 0.01 * decisions.len() as f64 + 16.0);
        }
    }

    #[test]
    fn a_carry_runs_through_bytes_of_ones() {
        // Unlikely decisions at the top of the range, then one that carries.
        let mut decisions = vec![(WHOLE - 1, false); 3];
        decisions.extend(vec![(WHOLE / 2, false); 100]);
        decisions.extend(vec![(1, true), (WHOLE - 1, false)]);
        let (bytes, _) = encoded(&decisions);
        assert!(bytes.windows(4).any(|bytes| bytes == [0xFF; 4]));
        let mut decoder = RangeDecoder::new(&bytes);
        assert!(decisions.iter().all(|&(probability, bit)| decoder.code(probability, true) == bit));
    }

    #[test]
    fn more_than_there_is_is_noticed() {
        let mut decoder = RangeDecoder::new(&[]);
        assert!(!decoder.is_past_end());
        let count = (0..100).take_while(|_| decoder.code(WHOLE / 2, false) && !decoder.is_past_end()).count();
        assert!(count <= 8, "{count}");
    }
}
