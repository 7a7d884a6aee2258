//! Shared byte ranges, and byte ranges that are removed from a buffer.
//!
//! ```text
//! kept     ████████        ████          ██████████
//! freed          ░░░░░░░░░░░░░░░░░░░░░░░░░░░░░░
//! removed            ░░░░      ░░░░░░░░            freed, not kept; a multiple of the alignment
//! ```

use std::ops::Range;
use std::sync::Arc;

/// A shared range of bytes; cloning does not copy them.
#[derive(Clone, Default)]
pub(in crate::gltf) struct SharedBytes {
    pub(in crate::gltf) owner: Arc<Vec<u8>>,
    pub(in crate::gltf) range: Range<usize>,
}

impl SharedBytes {
    pub(in crate::gltf) fn as_slice(&self) -> &[u8] {
        &self.owner[self.range.clone()]
    }

    pub(in crate::gltf) fn len(&self) -> usize {
        self.range.len()
    }
}

impl From<Vec<u8>> for SharedBytes {
    fn from(bytes: Vec<u8>) -> Self {
        let (owner, range) = whole_of(Arc::new(bytes));
        Self { owner, range }
    }
}

impl std::fmt::Debug for SharedBytes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "SharedBytes({})", self.len())
    }
}

/// Returns all bytes of an owner.
pub(in crate::gltf) fn whole_of(owner: Arc<Vec<u8>>) -> (Arc<Vec<u8>>, Range<usize>) {
    let range = 0..owner.len();
    (owner, range)
}

/// The largest alignment of buffer views that a known extension requires. Bytes are removed in
/// multiples of it, which preserves the alignment of the rest.
pub(in crate::gltf) const ALIGNMENT: usize = 8;

/// The byte ranges to remove from a buffer, ascending and disjoint, each with the number of bytes
/// removed up to its end.
#[derive(Default)]
pub(in crate::gltf) struct RemovedBytes(Vec<(Range<usize>, usize)>);

impl RemovedBytes {
    /// Plans the removal of bytes that are in `freed` and not in `kept`; the ranges may overlap and
    /// be in any order.
    pub(in crate::gltf) fn plan(freed: Vec<Range<usize>>, kept: Vec<Range<usize>>) -> Self {
        let mut total = 0;
        let removed = subtract(merge(freed), &merge(kept)).into_iter().map(|range| {
            total += range.len();
            (range, total)
        });
        Self(removed.collect())
    }

    /// Returns the number of bytes that are removed.
    pub(in crate::gltf) fn total(&self) -> usize {
        self.0.last().map_or(0, |(_, total)| *total)
    }

    /// Returns the new offset of a byte. For a removed byte, this is the offset of the next
    /// remaining byte.
    pub(in crate::gltf) fn moved(&self, offset: usize) -> usize {
        let before = self.0.partition_point(|(range, _)| range.end <= offset);
        let removed = before.checked_sub(1).map_or(0, |last| self.0[last].1);
        let inside = self.0.get(before).map_or(0, |(range, _)| offset.saturating_sub(range.start));
        offset - removed - inside
    }

    /// Iterates over the remaining bytes.
    pub(in crate::gltf) fn slices<'a>(&self, bytes: &'a [u8]) -> impl Iterator<Item = &'a [u8]> {
        let starts = std::iter::once(0).chain(self.0.iter().map(|(range, _)| range.end));
        let ends = self.0.iter().map(|(range, _)| range.start).chain([bytes.len()]);
        starts.zip(ends).map(|(start, end)| &bytes[start..end])
    }
}

/// Sorts ranges and joins those that touch or overlap.
fn merge(mut ranges: Vec<Range<usize>>) -> Vec<Range<usize>> {
    ranges.sort_unstable_by_key(|r| r.start);
    let mut out: Vec<Range<usize>> = Vec::with_capacity(ranges.len());
    for range in ranges {
        match out.last_mut() {
            Some(last) if range.start <= last.end => last.end = last.end.max(range.end),
            _ => out.push(range),
        }
    }
    out
}

/// Subtracts `kept` from `freed`, both sorted and disjoint, and shrinks the resulting ranges to the
/// alignment.
fn subtract(freed: Vec<Range<usize>>, kept: &[Range<usize>]) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut push = |start: usize, end: usize| {
        let (start, end) = (start.next_multiple_of(ALIGNMENT), end / ALIGNMENT * ALIGNMENT);
        if start < end {
            out.push(start..end);
        }
    };
    let mut next = 0;
    for range in freed {
        let mut start = range.start;
        while let Some(keep) = kept.get(next).filter(|keep| keep.start < range.end) {
            push(start, keep.start.max(start));
            start = start.max(keep.end);
            if keep.end > range.end {
                break;
            }
            next += 1;
        }
        push(start, range.end.max(start));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn removes_exactly_what_is_free_and_not_kept(
            free in prop::collection::vec((0usize..200, 1usize..60), 0..8),
            keep in prop::collection::vec((0usize..200, 1usize..30), 0..8),
        ) {
            let ranges = |list: &[(usize, usize)]| list.iter().map(|&(s, n)| s..s + n).collect::<Vec<_>>();
            let (free, keep) = (ranges(&free), ranges(&keep));
            let removed = RemovedBytes::plan(free.clone(), keep.clone());
            // Eight bytes at a multiple of eight are removed if all of them are free and none is
            // kept.
            let is_removable = |byte: usize| free.iter().any(|r| r.contains(&byte)) && !keep.iter().any(|r| r.contains(&byte));
            let bytes: Vec<u8> = (0..=255).chain(0..45).collect();
            let stays: Vec<usize> = (0..bytes.len())
                .filter(|byte| !(0..ALIGNMENT).all(|i| is_removable(byte / ALIGNMENT * ALIGNMENT + i)))
                .collect();
            let left: Vec<u8> = stays.iter().map(|&byte| bytes[byte]).collect();
            prop_assert_eq!(removed.slices(&bytes).collect::<Vec<_>>().concat(), left);
            prop_assert_eq!(removed.total(), bytes.len() - stays.len());
            for byte in 0..=bytes.len() {
                prop_assert_eq!(removed.moved(byte), stays.partition_point(|&stay| stay < byte));
            }
        }
    }
}
