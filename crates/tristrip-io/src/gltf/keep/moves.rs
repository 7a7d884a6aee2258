//! The bytes of the buffers: which stay, where they go, and the views that follow them.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::{Map, Value, json};

use super::free::Free;
use crate::error::Error;
use crate::gltf::buffer::Bytes;
use crate::gltf::document::{array, format_error, index, list_mut};

/// Some extensions ask for this alignment of buffer views; nothing in use asks for more.
pub(super) const ALIGNMENT: usize = 8;

/// Which bytes of the buffers stay, and where they go.
pub(super) struct Moves {
    /// The bytes of each buffer that go, ascending and apart, and how many have gone at the end of each.
    removed: Vec<Vec<(Range<usize>, usize)>>,
    /// Where each buffer starts in the one that all become.
    bases: Vec<usize>,
    /// Where the last of them ends.
    pub(super) end: usize,
}

impl Moves {
    pub(super) fn plan(root: &Map<String, Value>, buffers: &[Bytes], free: &Free) -> Result<Self, Error> {
        if free.bytes_named && buffers.len() > 1 {
            return Err(Error::Unsupported(
                "an extension names bytes of a buffer: several buffers cannot be joined into one".into(),
            ));
        }
        let mut kept: Vec<Vec<Range<usize>>> = vec![Vec::new(); buffers.len()];
        let mut freed = kept.clone();
        for (v, view) in array(root, "bufferViews")?.iter().enumerate() {
            let (buffer, range) = view_range(v, view, buffers)?;
            let sink = if free.views.contains(&v) { &mut freed } else { &mut kept };
            sink[buffer].push(range);
        }
        let mut moves = Self { removed: Vec::new(), bases: Vec::new(), end: 0 };
        for ((bytes, freed), kept) in buffers.iter().zip(freed).zip(kept) {
            let gone = if free.bytes_named { Vec::new() } else { subtract(merge(freed), &merge(kept)) };
            let mut total = 0;
            let removed = gone.into_iter().map(|range| {
                total += range.len();
                (range, total)
            });
            moves.removed.push(removed.collect());
            moves.bases.push(moves.end.next_multiple_of(ALIGNMENT));
            moves.end = moves.end.next_multiple_of(ALIGNMENT) + bytes.len() - total;
        }
        Ok(moves)
    }

    /// Gives the place where new bytes start.
    pub(super) fn new_start(&self) -> usize {
        self.end.next_multiple_of(ALIGNMENT)
    }

    /// Moves all views; `new` has the offsets of new ones within the new bytes.
    pub(super) fn apply(
        &self,
        root: &mut Map<String, Value>,
        new: &BTreeMap<usize, usize>,
    ) -> Result<(), Error> {
        if !root.contains_key("bufferViews") {
            return Ok(());
        }
        for (v, view) in list_mut(root, "bufferViews")?.iter_mut().enumerate() {
            let Value::Object(members) = view else { continue };
            let offset = members.get("byteOffset").and_then(index).unwrap_or(0);
            let moved = if let Some(start) = new.get(&v) {
                self.new_start() + start
            } else {
                let buffer = members.get("buffer").and_then(index).unwrap_or(0);
                if buffer != 0 {
                    members.insert("buffer".into(), 0.into());
                }
                let Some((removed, base)) = self.removed.get(buffer).zip(self.bases.get(buffer)) else {
                    continue;
                };
                let before = removed.partition_point(|(gone, _)| gone.end <= offset);
                base + offset - before.checked_sub(1).map_or(0, |last| removed[last].1)
            };
            if moved != offset {
                members.insert("byteOffset".into(), moved.into());
            }
        }
        Ok(())
    }

    /// Gives the bytes that stay, each buffer at its base, and the new ones after them.
    pub(super) fn pieces<'a>(&self, buffers: &'a [Bytes], new: &'a [u8]) -> Vec<&'a [u8]> {
        const PADDING: &[u8] = &[0; ALIGNMENT];
        let mut pieces = Vec::new();
        let mut written = 0;
        let mut push = |piece: &'a [u8]| {
            written += piece.len();
            pieces.push(piece);
            written
        };
        for ((bytes, removed), &base) in buffers.iter().zip(&self.removed).zip(&self.bases) {
            let bytes = bytes.as_slice();
            let before = push(&[]);
            push(&PADDING[..base - before]);
            let mut at = 0;
            for (gone, _) in removed {
                push(&bytes[at..gone.start]);
                at = gone.end;
            }
            push(&bytes[at..]);
        }
        if !new.is_empty() {
            push(&PADDING[..self.new_start() - self.end]);
            push(new);
        }
        pieces
    }
}

/// Gives a view's buffer and range; reading has checked both.
fn view_range(v: usize, view: &Value, buffers: &[Bytes]) -> Result<(usize, Range<usize>), Error> {
    let field = |name| view.get(name).and_then(index);
    let (buffer, start, length) =
        (field("buffer").unwrap_or(0), field("byteOffset").unwrap_or(0), field("byteLength").unwrap_or(0));
    let fits =
        buffers.get(buffer).is_some_and(|b| start.checked_add(length).is_some_and(|end| end <= b.len()));
    if fits {
        return Ok((buffer, start..start + length));
    }
    Err(format_error(format!("bufferViews[{v}]"), "a range outside of its buffer", "one within"))
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

/// Takes `kept` away from `freed`, both sorted and apart, and shrinks what is left to the alignment.
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

/// Makes all buffers one of a length; none where there are no bytes.
pub(super) fn set_buffer(root: &mut Map<String, Value>, length: usize) -> Result<(), Error> {
    if length == 0 && !root.contains_key("buffers") {
        return Ok(());
    }
    let buffers = list_mut(root, "buffers")?;
    buffers.truncate(1);
    match buffers.first_mut() {
        Some(Value::Object(buffer)) => {
            if buffer.get("byteLength").and_then(index) != Some(length) {
                buffer.insert("byteLength".into(), length.into());
            }
        }
        _ => buffers.push(json!({ "byteLength": length })),
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn goes_what_is_free_and_not_kept(
            free in prop::collection::vec((0usize..200, 1usize..60), 0..8),
            keep in prop::collection::vec((0usize..200, 1usize..30), 0..8),
        ) {
            let ranges = |list: &[(usize, usize)]| list.iter().map(|&(s, n)| s..s + n).collect::<Vec<_>>();
            let (free, keep) = (ranges(&free), ranges(&keep));
            let gone = subtract(merge(free.clone()), &merge(keep.clone()));
            // Eight bytes at a multiple of eight go if each of them is free, and none is kept.
            let may_go = |byte: usize| free.iter().any(|r| r.contains(&byte)) && !keep.iter().any(|r| r.contains(&byte));
            for start in (0..300).step_by(ALIGNMENT) {
                let all = (start..start + ALIGNMENT).all(may_go);
                for byte in start..start + ALIGNMENT {
                    prop_assert_eq!(gone.iter().any(|r| r.contains(&byte)), all, "{}", byte);
                }
            }
            prop_assert!(gone.windows(2).all(|w| w[0].end <= w[1].start));
        }
    }
}
