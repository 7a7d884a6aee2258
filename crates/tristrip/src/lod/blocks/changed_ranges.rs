//! Finds the ranges of a buffer to upload to the GPU, and merges them to a maximum number.

use std::ops::Range;

/// Slots that are uploaded together: 32 or 64 bytes, about the granularity of a memory transfer.
const BLOCK: usize = 16;

/// Tracks the blocks of a buffer that contain changed slots.
#[derive(Debug)]
pub(super) struct ChangedRanges {
    slot_count: usize,
    /// A bit per block.
    blocks: Vec<u64>,
}

impl ChangedRanges {
    /// Creates the state of a buffer with this many slots, all unchanged.
    pub(super) fn of(slot_count: usize) -> Self {
        Self { slot_count, blocks: vec![0; slot_count.div_ceil(BLOCK * u64::BITS as usize)] }
    }

    pub(super) fn mark(&mut self, slot: usize) {
        let block = slot / BLOCK;
        self.blocks[block / 64] |= 1 << (block % 64);
    }

    /// Returns at most `most` ranges, or one if `most` is 0, with the fewest unchanged slots
    /// between merged ranges.
    pub(super) fn ranges(&self, most: usize) -> Vec<Range<usize>> {
        let mut ranges: Vec<Range<usize>> = Vec::new();
        for (word, &bits) in self.blocks.iter().enumerate() {
            let mut bits = bits;
            while bits != 0 {
                let block = 64 * word + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let range = BLOCK * block..(BLOCK * (block + 1)).min(self.slot_count);
                match ranges.last_mut() {
                    Some(last) if last.end == range.start => last.end = range.end,
                    _ => ranges.push(range),
                }
            }
        }
        merge(ranges, most.max(1))
    }
}

/// Merges ascending ranges, smallest gaps first, until at most `most` remain.
fn merge(mut ranges: Vec<Range<usize>>, most: usize) -> Vec<Range<usize>> {
    let surplus = ranges.len().saturating_sub(most);
    if surplus == 0 {
        return ranges;
    }
    let gap = |i: usize| ranges[i + 1].start - ranges[i].end;
    let mut by_gap: Vec<usize> = (0..ranges.len() - 1).collect();
    by_gap.select_nth_unstable_by_key(surplus - 1, |&i| (gap(i), i));
    let mut is_closed = vec![false; ranges.len()];
    by_gap[..surplus].iter().for_each(|&i| is_closed[i] = true);
    let mut kept = 0;
    for i in 1..ranges.len() {
        if is_closed[i - 1] {
            ranges[kept].end = ranges[i].end;
        } else {
            kept += 1;
            ranges[kept] = ranges[i].clone();
        }
    }
    ranges.truncate(kept + 1);
    ranges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_with_the_least_between_them_are_merged() {
        let ranges = vec![0..1, 3..4, 5..6, 16..17];
        assert_eq!(merge(ranges.clone(), 4), ranges);
        assert_eq!(merge(ranges.clone(), 3), [0..1, 3..6, 16..17]);
        assert_eq!(merge(ranges.clone(), 2), [0..6, 16..17]);
        assert_eq!(merge(ranges, 1), vec![0..17; 1]);
        assert!(merge(Vec::new(), 1).is_empty());
    }

    #[test]
    fn blocks_next_to_each_other_are_one_range() {
        let mut changed = ChangedRanges::of(100);
        assert!(changed.ranges(0).is_empty());
        [99, 3, 17, 64].into_iter().for_each(|slot| changed.mark(slot));
        assert_eq!(changed.ranges(9), [0..32, 64..80, 96..100]);
        assert_eq!(changed.ranges(2), [0..32, 64..100]);
        assert_eq!(changed.ranges(0), vec![0..100; 1]);
    }
}
