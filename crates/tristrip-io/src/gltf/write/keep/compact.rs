//! Compacts the buffers: removes bytes, computes new offsets, and updates buffer views.

use std::collections::BTreeMap;
use std::ops::Range;

use serde_json::json;

use super::unused::UnusedEntries;
use crate::error::Error;
use crate::gltf::document::buffer::view_range;
use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::byte_ranges::{ALIGNMENT, RemovedBytes};
use crate::gltf::document::json::Members;
use crate::gltf::document::{array, entries_mut, index, list_mut};

/// A plan to merge all buffers into one without unused bytes.
pub(in crate::gltf) struct BufferCompaction {
    /// The removed bytes of each buffer.
    removed: Vec<RemovedBytes>,
    /// The offset of each buffer in the merged one.
    bases: Vec<usize>,
    /// The end of the last buffer in the merged one.
    pub(in crate::gltf) end: usize,
}

impl BufferCompaction {
    /// Plans the compaction: removes the bytes of unused views, except those that another view
    /// uses.
    pub(super) fn plan(
        root: &Members,
        buffers: &[SharedBytes],
        unused: &UnusedEntries,
    ) -> Result<Self, Error> {
        if unused.bytes_named && buffers.len() > 1 {
            return Err(Error::Unsupported(
                "an extension refers to bytes of a buffer: several buffers cannot be merged into one".into(),
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

    /// Plans the removal of `freed` byte ranges, except for `kept` bytes.
    pub(in crate::gltf) fn without(
        buffers: &[SharedBytes],
        freed: Vec<Vec<Range<usize>>>,
        kept: Vec<Vec<Range<usize>>>,
    ) -> Self {
        let mut out = Self { removed: Vec::new(), bases: Vec::new(), end: 0 };
        for ((bytes, freed), kept) in buffers.iter().zip(freed).zip(kept) {
            let removed = RemovedBytes::plan(freed, kept);
            out.bases.push(out.end.next_multiple_of(ALIGNMENT));
            out.end = out.end.next_multiple_of(ALIGNMENT) + bytes.len() - removed.total();
            out.removed.push(removed);
        }
        out
    }

    /// Returns the offset of the new bytes.
    pub(in crate::gltf) fn new_start(&self) -> usize {
        self.end.next_multiple_of(ALIGNMENT)
    }

    /// Updates the offsets of all views. `new` has the offsets of new views within the new bytes.
    pub(in crate::gltf) fn apply(
        &self,
        root: &mut Members,
        new: &BTreeMap<usize, usize>,
    ) -> Result<(), Error> {
        if !root.contains_key("bufferViews") {
            return Ok(());
        }
        for (v, view) in entries_mut(root, "bufferViews")?.iter_mut().enumerate() {
            let field = |name| view.get(name).and_then(index).unwrap_or(0);
            let (buffer, offset) = (field("buffer"), field("byteOffset"));
            let moved = if let Some(start) = new.get(&v) {
                self.new_start() + start
            } else {
                let Some((removed, base)) = self.removed.get(buffer).zip(self.bases.get(buffer)) else {
                    continue;
                };
                base + removed.moved(offset)
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

    /// Returns the merged buffer as slices: the remaining bytes, each buffer at its base, then the
    /// new bytes.
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
            for slice in removed.slices(bytes) {
                push(slice);
            }
        }
        if !new.is_empty() {
            push(&PADDING[..self.new_start() - self.end]);
            push(new);
        }
        slices
    }
}

/// Replaces all buffers by one of a given length, or by none if the length is 0.
pub(in crate::gltf) fn set_buffer(root: &mut Members, length: usize) -> Result<(), Error> {
    if length == 0 {
        // No view can refer to an empty buffer, and a reader would expect its bytes.
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
