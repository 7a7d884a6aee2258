//! Compressed sparse rows: items grouped by key, built by a counting sort and stored in two arrays.
//!
//! ```text
//! keys    2 0 2 1          ends   1 2 4        row 0: items 1
//! items   0 1 2 3          items  1 3 0 2      row 1: items 3      row 2: items 0 2
//! ```
//! # Complexity
//! O(items + keys) time. 4 bytes per key, plus the items, which take 4 bytes each if they are
//! indices.

/// Items grouped by key. The order within a group is kept.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Csr<T = u32> {
    ends: Vec<u32>,
    items: Vec<T>,
}

impl Csr {
    /// Groups the items 0, 1, 2 … by their keys, which must be below `key_count`.
    pub(crate) fn group(keys: impl Iterator<Item = u32> + Clone, key_count: usize) -> Self {
        Self::group_items(keys.zip(0..), key_count)
    }

    /// Replaces every item. The order within the rows stays the same.
    pub(crate) fn map_items(&mut self, replacement: impl Fn(u32) -> u32) {
        self.items.iter_mut().for_each(|item| *item = replacement(*item));
    }

    /// Sorts the items of every row by a comparison.
    pub(crate) fn sort_rows(&mut self, mut compare: impl FnMut(u32, u32) -> std::cmp::Ordering) {
        let mut start = 0;
        for &end in &self.ends {
            self.items[start..end as usize].sort_unstable_by(|&a, &b| compare(a, b));
            start = end as usize;
        }
    }
}

impl<T: Copy + Default> Csr<T> {
    /// Groups items by their keys, which must be below `key_count`.
    pub fn group_items(keyed: impl Iterator<Item = (u32, T)> + Clone, key_count: usize) -> Self {
        // During the loop, `ends[key]` moves from the start of the key's row to its end.
        let mut ends = vec![0_u32; key_count];
        keyed.clone().for_each(|(key, _)| ends[key as usize] += 1);
        let mut total = 0;
        for end in &mut ends {
            total += std::mem::replace(end, total);
        }
        let mut items = vec![T::default(); total as usize];
        keyed.for_each(|(key, item)| {
            let slot = &mut ends[key as usize];
            items[*slot as usize] = item;
            *slot += 1;
        });
        Self { ends, items }
    }

    /// Returns the range of a key's items within all items.
    #[inline]
    pub(crate) fn range(&self, key: u32) -> std::ops::Range<usize> {
        let start = if key == 0 { 0 } else { self.ends[key as usize - 1] };
        start as usize..self.ends[key as usize] as usize
    }

    /// Counts the keys.
    #[inline]
    pub(crate) fn key_count(&self) -> usize {
        self.ends.len()
    }

    /// Counts the items of all rows.
    pub fn item_count(&self) -> usize {
        self.items.len()
    }

    /// Returns the items of a key, in order.
    #[inline]
    pub fn row(&self, key: u32) -> &[T] {
        &self.items[self.range(key)]
    }

    /// Returns the items of a key for modification.
    #[inline]
    pub(crate) fn row_mut(&mut self, key: u32) -> &mut [T] {
        let range = self.range(key);
        &mut self.items[range]
    }

    /// Iterates over the rows in key order.
    #[inline]
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &[T]> + Clone {
        let mut start = 0;
        self.ends
            .iter()
            .map(move |&end| &self.items[std::mem::replace(&mut start, end as usize)..end as usize])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rows_are_the_items_of_their_keys(keys in prop::collection::vec(0..9_u32, 0..50)) {
            let csr = Csr::group(keys.iter().copied(), 9);
            for key in 0..9 {
                let expected: Vec<u32> = (0..).zip(&keys).filter_map(|(i, &k)| (k == key).then_some(i)).collect();
                prop_assert_eq!(csr.row(key), expected);
            }
            prop_assert!(csr.rows().eq((0..9).map(|key| csr.row(key))));
            prop_assert_eq!(csr.key_count(), 9);
            let mut shifted = csr.clone();
            shifted.map_items(|item| item + 1);
            prop_assert!((0..9).all(|key| shifted.row(key).iter().map(|item| item - 1).eq(csr.row(key).iter().copied())));
            let mut falling = csr.clone();
            falling.sort_rows(|a, b| b.cmp(&a));
            prop_assert!((0..9).all(|key| falling.row(key).iter().rev().eq(csr.row(key))));
        }
    }
}
