//! Probabilities of decisions, learned while coding.
//!
//! # Algorithm
//! Each context has a slot with a probability and a count. After a decision, the probability moves
//! toward the outcome by 1 / (count + 1.5) of the difference, and the count increases up to a
//! limit. At first the probability is the mean of the past decisions; later it adapts to changes.
//!
//! All state is integer, at most 32 bits: probabilities have 24 bits in slots and 16 bits for the
//! coder.
//!
//! # Complexity
//! O(1) per decision; 4 bytes per slot.

use super::range_coder::BitCoder;

/// The maximum count of a slot.
const MAX_COUNT: u8 = 255;

/// 2¹⁵ / (count + 1.5).
const RATES: [u16; MAX_COUNT as usize + 1] = {
    let mut rates = [0; MAX_COUNT as usize + 1];
    let mut count = 0;
    while count < rates.len() {
        rates[count] = (65536 / (2 * count + 3)) as u16;
        count += 1;
    }
    rates
};

/// A new slot: a probability of 24 bits above a count of 8 bits.
const NEW_SLOT: u32 = 1 << 31;

#[inline]
fn learn(slot: &mut u32, bit: bool) {
    let count = *slot as u8;
    let target = i32::from(bit).wrapping_neg() & 0xFF_FFFF;
    let change = ((target - (*slot >> 8).cast_signed()) >> 8) * i32::from(RATES[usize::from(count)]);
    // 2⁻⁷ of the change, added above the count.
    *slot = slot.wrapping_add(change.cast_unsigned() << 1 & !0xFF) + u32::from(count < MAX_COUNT);
}

/// One kind of decision, with a probability per context.
#[derive(Debug, Clone)]
pub(crate) struct Simple {
    slots: Vec<u32>,
}

impl Simple {
    pub(crate) fn new(size: usize) -> Self {
        Self { slots: vec![NEW_SLOT; size] }
    }

    /// Codes a decision in a context, an index into the slots.
    #[inline]
    pub(crate) fn code<C: BitCoder>(&mut self, coder: &mut C, context: usize, bit: bool) -> bool {
        code_slot(coder, &mut self.slots[context], bit)
    }

    /// Codes a number of up to four bits as one decision per bit, highest bit first, with the slots
    /// of a context. Each context has 16 slots.
    #[inline]
    pub(crate) fn code_number<C: BitCoder>(
        &mut self,
        coder: &mut C,
        context: usize,
        bits: usize,
        number: usize,
    ) -> usize {
        let Some(slots) = self.slots[16 * context..].first_chunk_mut::<16>() else { return 0 };
        let mut node = 1;
        for i in (0..bits).rev() {
            let bit = code_slot(coder, &mut slots[node & 15], number >> i & 1 != 0);
            node = 2 * node + usize::from(bit);
        }
        node - (1 << bits)
    }
}

#[inline]
fn code_slot<C: BitCoder>(coder: &mut C, slot: &mut u32, bit: bool) -> bool {
    // The probability is never 0 or 1.
    let bit = coder.code(*slot >> 16 | 1, bit);
    learn(slot, bit);
    bit
}
