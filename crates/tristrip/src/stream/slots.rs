//! Probabilities of decisions, learned while coding.
//!
//! # Algorithm
//! Each context has a slot with a probability and a count. After a decision the probability moves towards it by one part in count + 1.5, and the count
//! grows up to a limit: at first the slot is the mean of what it has seen, later it follows changes.
//!
//! Everything is an integer of at most 32 bits: probabilities of 22 bits in slots and 16 bits for the coder.
//!
//! # Complexity
//! O(1) per decision; 4 bytes per slot.

use super::range_coder::{BitCoder, WHOLE};

/// A slot counts up to this.
const MOST_COUNT: u32 = 250;

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
    let change = (((target - share) >> 6) * i32::from(RATES[(count as usize).min(RATES.len() - 1)])) >> 9;
    *slot = (share + change).cast_unsigned() << 10 | (count + u32::from(count < MOST_COUNT));
}

/// A decision with a probability in each of some contexts.
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
        code_slot(coder, &mut self.slots[context], bit)
    }

    /// Codes a number of less than 16 by four decisions, the highest bit first, with the slots of a context; each context has 16.
    #[inline]
    pub(super) fn code_symbol<C: BitCoder>(&mut self, coder: &mut C, context: usize, symbol: usize) -> usize {
        let Some(slots) = self.slots[16 * context..].first_chunk_mut::<16>() else { return 0 };
        let mut node = 1;
        for i in [3, 2, 1, 0] {
            let bit = code_slot(coder, &mut slots[node & 15], symbol >> i & 1 != 0);
            node = 2 * node + usize::from(bit);
        }
        node - 16
    }
}

#[inline]
fn code_slot<C: BitCoder>(coder: &mut C, slot: &mut u32, bit: bool) -> bool {
    let share = (*slot >> 16).clamp(32, WHOLE - 32);
    let bit = coder.code(share, bit);
    learn(slot, bit);
    bit
}
