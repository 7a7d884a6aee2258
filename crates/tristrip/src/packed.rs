//! Numbers packed into the number of bits that the largest one needs.
//!
//! # Complexity
//! Reading a number takes constant time.

use std::ops::Range;

/// Returns the number of bits needed for numbers from 0 to `largest`.
pub fn bits_for(largest: u32) -> u32 {
    u32::BITS - largest.leading_zeros()
}

/// Number of bytes read at once.
const READ: usize = size_of::<u64>();

/// Packed numbers of any widths.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Packed {
    /// The bytes of the numbers, and padding that reading the last number may reach.
    bytes: Vec<u8>,
    bit_count: usize,
}

impl Packed {
    /// Appends a number of at most `bits` bits.
    pub fn push(&mut self, number: u32, bits: u32) {
        debug_assert!(bits == 32 || number >> bits == 0, "{number} does not fit {bits} bits");
        let (byte, shift) = (self.bit_count / 8, self.bit_count % 8);
        self.bit_count += bits as usize;
        self.bytes.resize(self.bit_count / 8 + READ, 0);
        let shifted = u64::from(number) << shift;
        for (byte, part) in self.bytes[byte..].iter_mut().zip(shifted.to_le_bytes()) {
            *byte |= part;
        }
    }

    /// Counts the bits of all numbers.
    pub(crate) fn bit_count(&self) -> usize {
        self.bit_count
    }

    /// Returns the number of width `bits` that starts at bit `bit`.
    #[inline]
    pub fn get(&self, bit: usize, bits: u32) -> u32 {
        low_bits(self.word_at(bit), bits)
    }

    /// Returns at least 57 bits, starting at a bit.
    #[inline]
    fn word_at(&self, bit: usize) -> u64 {
        let bytes = self.bytes.get(bit / 8..).and_then(<[u8]>::first_chunk);
        bytes.map_or(0, |&bytes| u64::from_le_bytes(bytes)) >> (bit % 8)
    }

    /// Reads numbers of width `bits` from bit `start` on, converts them, and fills the target.
    #[inline]
    pub(crate) fn unpack<T>(&self, start: usize, bits: u32, target: &mut [T], convert: impl Fn(u32) -> T) {
        match bits {
            0..=14 => self.unpack_by::<4, T>(start, bits, target, convert),
            15..=19 => self.unpack_by::<3, T>(start, bits, target, convert),
            20..=28 => self.unpack_by::<2, T>(start, bits, target, convert),
            _ => self.unpack_by::<1, T>(start, bits, target, convert),
        }
    }

    /// Implements [`Packed::unpack`] by reading N numbers at once. They have at most 57 bits in
    /// total.
    #[inline]
    fn unpack_by<const N: usize, T>(
        &self,
        start: usize,
        bits: u32,
        target: &mut [T],
        convert: impl Fn(u32) -> T,
    ) {
        let mut bit = start;
        let (groups, rest) = target.as_chunks_mut::<N>();
        for group in groups {
            let mut word = self.word_at(bit);
            for place in group {
                *place = convert(low_bits(word, bits));
                word >>= bits;
            }
            bit += N * bits as usize;
        }
        for place in rest {
            *place = convert(self.get(bit, bits));
            bit += bits as usize;
        }
    }

    /// Returns two consecutive numbers.
    #[inline]
    pub fn get_pair(&self, bit: usize, bits: [u32; 2]) -> [u32; 2] {
        [self.get(bit, bits[0]), self.get(bit + bits[0] as usize, bits[1])]
    }

    /// Returns the size in memory, in bytes.
    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.bytes[..])
    }
}

#[inline]
fn low_bits(word: u64, bits: u32) -> u32 {
    (word & ((1 << bits) - 1)) as u32
}

/// Numbers of one width within packed numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PackedRow<'a> {
    packed: &'a Packed,
    start: usize,
    bits: u32,
}

impl<'a> PackedRow<'a> {
    /// Returns the numbers of width `bits` from bit `start` on.
    pub fn new(packed: &'a Packed, start: usize, bits: u32) -> Self {
        Self { packed, start, bits }
    }

    /// Returns a number by position.
    #[inline]
    pub fn get(&self, i: u32) -> u32 {
        self.packed.get(self.start + i as usize * self.bits as usize, self.bits)
    }

    /// Returns the first position in `from..end` whose number is at least `least`, or `end`. The
    /// numbers must be ascending.
    #[inline]
    pub(crate) fn first_at_least(&self, from: u32, end: u32, least: u32) -> u32 {
        let (mut low, mut high) = (from, end);
        while low < high {
            let middle = low.midpoint(high);
            if self.get(middle) < least { low = middle + 1 } else { high = middle }
        }
        low
    }
}

/// Compressed sparse rows, packed into as few bits as needed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct PackedRows {
    ends: Packed,
    items: Packed,
    end_bits: u32,
    item_bits: u32,
    item_count: u32,
}

impl PackedRows {
    /// Creates empty rows for `item_count` items in total, none larger than `largest`.
    pub(crate) fn of_items(item_count: usize, largest: u32) -> Self {
        Self { end_bits: bits_for(item_count as u32), item_bits: bits_for(largest), ..Self::default() }
    }

    /// Packs rows.
    pub(crate) fn of<'a>(rows: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let (mut count, mut largest) = (0, 0);
        for row in rows.clone() {
            count += row.len();
            largest = row.iter().copied().fold(largest, u32::max);
        }
        let mut packed = Self::of_items(count, largest);
        for row in rows {
            row.iter().for_each(|&item| packed.push(item));
            packed.end_row();
        }
        packed
    }

    /// Appends an item to the open row.
    pub(crate) fn push(&mut self, item: u32) {
        self.items.push(item, self.item_bits);
        self.item_count += 1;
    }

    /// Ends the open row.
    pub(crate) fn end_row(&mut self) {
        self.ends.push(self.item_count, self.end_bits);
    }

    pub(crate) fn item_count(&self) -> usize {
        self.item_count as usize
    }

    /// Returns the range of consecutive rows among all items.
    #[inline]
    pub(crate) fn range(&self, rows: Range<u32>) -> Range<u32> {
        let end = |row: u32| match row {
            0 => 0,
            row => self.ends.get((row as usize - 1) * self.end_bits as usize, self.end_bits),
        };
        end(rows.start)..end(rows.end)
    }

    /// Returns an item by position among all items.
    #[inline]
    pub(crate) fn item(&self, position: u32) -> u32 {
        self.items.get(position as usize * self.item_bits as usize, self.item_bits)
    }

    /// Iterates over the items of consecutive rows.
    #[inline]
    pub(crate) fn rows(&self, rows: Range<u32>) -> impl Iterator<Item = u32> {
        self.range(rows).map(|position| self.item(position))
    }

    /// Iterates over the items of a row.
    #[inline]
    pub(crate) fn row(&self, row: u32) -> impl Iterator<Item = u32> {
        self.rows(row..row + 1)
    }

    /// Returns the size in memory, in bytes.
    pub(crate) fn memory(&self) -> usize {
        self.ends.memory() + self.items.memory()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_are_returned_as_they_were_pushed(numbers in prop::collection::vec((any::<u32>(), 0..=32_u32), 0..99)) {
            let mut packed = Packed::default();
            let mut starts = Vec::new();
            let cut = |number: u32, bits: u32| (u64::from(number) & ((1 << bits) - 1)) as u32;
            for &(number, bits) in &numbers {
                starts.push(packed.bit_count());
                packed.push(cut(number, bits), bits);
            }
            for (&(number, bits), &start) in numbers.iter().zip(&starts) {
                prop_assert_eq!(packed.get(start, bits), cut(number, bits));
            }
            for (pair, &start) in numbers.windows(2).zip(&starts) {
                let expected = [0, 1].map(|i| cut(pair[i].0, pair[i].1));
                prop_assert_eq!(packed.get_pair(start, [pair[0].1, pair[1].1]), expected);
            }
        }

        #[test]
        fn rows_are_unpacked(start in 0..70_u32, bits in 0..=32_u32, numbers in prop::collection::vec(any::<u32>(), 0..40)) {
            let mut packed = Packed::default();
            (0..start).for_each(|_| packed.push(1, 1));
            let cut = |number: u32| (u64::from(number) & ((1 << bits) - 1)) as u32;
            numbers.iter().for_each(|&number| packed.push(cut(number), bits));
            let mut target = vec![0; numbers.len()];
            packed.unpack(start as usize, bits, &mut target, |number| number);
            prop_assert_eq!(target, numbers.into_iter().map(cut).collect::<Vec<_>>());
        }

        #[test]
        fn rows_are_searched(mut numbers in prop::collection::vec(0..40_u32, 0..30), least in 0..50_u32) {
            numbers.sort_unstable();
            let bits = bits_for(39);
            let mut packed = Packed::default();
            packed.push(5, 3);
            numbers.iter().for_each(|&number| packed.push(number, bits));
            let row = PackedRow::new(&packed, 3, bits);
            let expected = numbers.partition_point(|&number| number < least);
            prop_assert_eq!(row.first_at_least(0, numbers.len() as u32, least), expected as u32);
        }
    }

    proptest! {
        #[test]
        fn packed_rows_are_returned(rows in prop::collection::vec(prop::collection::vec(any::<u32>(), 0..5), 0..20)) {
            let packed = PackedRows::of(rows.iter().map(|row| &row[..]));
            prop_assert_eq!(packed.item_count(), rows.concat().len());
            for (number, row) in (0..).zip(&rows) {
                prop_assert_eq!(&packed.row(number).collect::<Vec<_>>(), row);
            }
            prop_assert_eq!(packed.rows(0..rows.len() as u32).collect::<Vec<_>>(), rows.concat());
        }
    }

    #[test]
    fn widths_are_the_least() {
        assert_eq!([0, 1, 2, 3, 4, u32::MAX].map(bits_for), [0, 1, 2, 2, 3, 32]);
    }
}
