//! Compaction of the buffers: which bytes stay, their new offsets, and the buffer views that change with them.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::json;

use super::unused::UnusedEntries;
use crate::error::Error;
use crate::gltf::document::{array, index, list_mut};
use crate::gltf::json::{Members, Value};
use crate::gltf::shared_bytes::SharedBytes;

/// The largest alignment of buffer views that a known extension requires.
pub(in crate::gltf) const ALIGNMENT: usize = 8;

/// The joining of all buffers into one, without the bytes that nothing uses.
pub(in crate::gltf) struct BufferCompaction {
    /// The byte ranges that are removed from each buffer, ascending and disjoint, each with the number of bytes removed up
    /// to its end.
    removed: Vec<Vec<(Range<usize>, usize)>>,
    /// The offset of each buffer in the joined one.
    bases: Vec<usize>,
    /// The end of the last buffer in the joined one.
    pub(in crate::gltf) end: usize,
}

impl BufferCompaction {
    /// Plans the compaction: the bytes of unused views are removed, except those that another view uses.
    pub(super) fn plan(
        root: &Members,
        buffers: &[SharedBytes],
        unused: &UnusedEntries,
    ) -> Result<Self, Error> {
        if unused.bytes_named && buffers.len() > 1 {
            return Err(Error::Unsupported(
                "an extension names bytes of a buffer: several buffers cannot be joined into one".into(),
            ));
        }
        let mut kept: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
        let mut freed = kept.clone();
        for (v, view) in array(root, "bufferViews")?.iter().enumerate() {
            let (buffer, range) = view_range(v, view, buffers)?;
            let sink = if unused.views.contains(&v) { &mut freed } else { &mut kept };
            sink[buffer].push(range);
        }
        if unused.bytes_named {
            freed.iter_mut().for_each(Vec::clear);
        }
        Ok(Self::without(buffers, freed, kept))
    }

    /// Plans the removal of byte ranges of each buffer, except for bytes that are kept.
    pub(in crate::gltf) fn without(
        buffers: &[SharedBytes],
        freed: Vec<Vec<Range<usize>>>,
        kept: Vec<Vec<Range<usize>>>,
    ) -> Self {
        let mut out = Self { removed: Vec::new(), bases: Vec::new(), end: 0 };
        for ((bytes, freed), kept) in buffers.iter().zip(freed).zip(kept) {
            let mut total = 0;
            let removed = subtract(merge(freed), &merge(kept)).into_iter().map(|range| {
                total += range.len();
                (range, total)
            });
            out.removed.push(removed.collect());
            out.bases.push(out.end.next_multiple_of(ALIGNMENT));
            out.end = out.end.next_multiple_of(ALIGNMENT) + bytes.len() - total;
        }
        out
    }

    /// Returns the offset at which the new bytes start.
    pub(in crate::gltf) fn new_start(&self) -> usize {
        self.end.next_multiple_of(ALIGNMENT)
    }

    /// Updates the offsets of all views; `new` has the offsets of new views within the new bytes.
    pub(in crate::gltf) fn apply(
        &self,
        root: &mut Members,
        new: &BTreeMap<usize, usize>,
    ) -> Result<(), Error> {
        if !root.contains_key("bufferViews") {
            return Ok(());
        }
        for (v, view) in list_mut(root, "bufferViews")?.iter_mut().enumerate() {
            let field = |name| view.get(name).and_then(index).unwrap_or(0);
            let (buffer, offset) = (field("buffer"), field("byteOffset"));
            let moved = if let Some(start) = new.get(&v) {
                self.new_start() + start
            } else {
                let Some((removed, base)) = self.removed.get(buffer).zip(self.bases.get(buffer)) else {
                    continue;
                };
                let before = removed.partition_point(|(range, _)| range.end <= offset);
                base + offset - before.checked_sub(1).map_or(0, |last| removed[last].1)
            };
            let changes = [("buffer", buffer, 0), ("byteOffset", offset, moved)];
            for (name, _, new) in changes.into_iter().filter(|(_, old, new)| old != new) {
                if let Some(members) = view.as_object_mut() {
                    members.insert(name, new);
                }
            }
        }
        Ok(())
    }

    /// Returns the bytes of the joined buffer as slices: those that stay, each buffer at its base, then the new ones.
    pub(in crate::gltf) fn slices<'a>(&self, buffers: &'a [SharedBytes], new: &'a [u8]) -> Vec<&'a [u8]> {
        const PADDING: &[u8] = &[0; ALIGNMENT];
        let mut slices = Vec::new();
        let mut written = 0;
        let mut push = |slice: &'a [u8]| {
            written += slice.len();
            slices.push(slice);
            written
        };
        for ((bytes, removed), &base) in buffers.iter().zip(&self.removed).zip(&self.bases) {
            let bytes = bytes.as_slice();
            let before = push(&[]);
            push(&PADDING[..base - before]);
            let mut at = 0;
            for (range, _) in removed {
                push(&bytes[at..range.start]);
                at = range.end;
            }
            push(&bytes[at..]);
        }
        if !new.is_empty() {
            push(&PADDING[..self.new_start() - self.end]);
            push(new);
        }
        slices
    }
}

/// Returns a view's buffer and byte range; the reader has checked both.
pub(in crate::gltf) fn view_range(
    v: usize,
    view: &Value,
    buffers: &[SharedBytes],
) -> Result<(usize, Range<usize>), Error> {
    let field = |name| view.get(name).and_then(index);
    let (buffer, start, length) =
        (field("buffer").unwrap_or(0), field("byteOffset").unwrap_or(0), field("byteLength").unwrap_or(0));
    let fits =
        buffers.get(buffer).is_some_and(|b| start.checked_add(length).is_some_and(|end| end <= b.len()));
    if fits {
        return Ok((buffer, start..start + length));
    }
    Err(Error::format(format!("bufferViews[{v}]"), "a range outside its buffer", "a range inside it"))
}

/// Sorts ranges and joins those that touch.
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

/// Subtracts `kept` from `freed`, both sorted and disjoint, and shrinks the resulting ranges to the alignment.
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

/// Replaces all buffers by one of a length; by none where there are no bytes.
pub(in crate::gltf) fn set_buffer(root: &mut Members, length: usize) -> Result<(), Error> {
    if length == 0 {
        // No view can name an empty buffer, and a reader would look for its bytes.
        root.remove("buffers");
        return Ok(());
    }
    let buffers = list_mut(root, "buffers")?;
    buffers.truncate(1);
    match buffers.first_mut() {
        None => buffers.push(json!({ "byteLength": length }).into()),
        Some(buffer) if buffer.get("byteLength").and_then(index) == Some(length) => {}
        Some(buffer) => {
            if let Some(members) = buffer.as_object_mut() {
                members.insert("byteLength", length);
            }
        }
    }
    Ok(())
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
            let removed = subtract(merge(free.clone()), &merge(keep.clone()));
            // Eight bytes at a multiple of eight are removed if each of them is free and none is kept.
            let is_removable = |byte: usize| free.iter().any(|r| r.contains(&byte)) && !keep.iter().any(|r| r.contains(&byte));
            for start in (0..300).step_by(ALIGNMENT) {
                let all = (start..start + ALIGNMENT).all(is_removable);
                for byte in start..start + ALIGNMENT {
                    prop_assert_eq!(removed.iter().any(|r| r.contains(&byte)), all, "{}", byte);
                }
            }
            prop_assert!(removed.windows(2).all(|w| w[0].end <= w[1].start));
        }
    }
}
