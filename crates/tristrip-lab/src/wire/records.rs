//! The splits that have arrived: their writes to the index map, and the previous entries.

use tristrip::Error;

/// The maximum number of renamed slots per entry of a map, over all splits. Meshes have about five.
const MAX_SLOTS_PER_ENTRY: usize = 256;

/// The splits in order of arrival, starting at the base mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct WireRecords {
    /// For each split, the end of its range of vertices.
    vertex_ends: Vec<u32>,
    /// The restored vertices.
    vertices: Vec<u32>,
    /// For each vertex, the end of its range of slots.
    slot_ends: Vec<u32>,
    slots: Vec<u32>,
    /// The entry of each slot before the split.
    coarse: Vec<u32>,
}

impl WireRecords {
    pub(super) fn len(&self) -> usize {
        self.vertex_ends.len()
    }

    /// Returns the memory in bytes.
    pub(super) fn memory(&self) -> usize {
        let lists = [&self.vertex_ends, &self.vertices, &self.slot_ends, &self.slots, &self.coarse];
        lists.map(|list| size_of_val(&list[..])).iter().sum()
    }

    /// Returns the number of vertices that the first splits restore.
    pub(super) fn vertex_count_of(&self, split_count: usize) -> usize {
        if split_count == 0 { 0 } else { self.vertex_ends[split_count - 1] as usize }
    }

    /// Writes the vertices of a split into their slots.
    pub(super) fn split(&self, number: usize, entries: &mut [u32]) {
        for i in range(&self.vertex_ends, number) {
            let slots = &self.slots[range(&self.slot_ends, i)];
            slots.iter().for_each(|&slot| entries[slot as usize] = self.vertices[i]);
        }
    }

    /// Restores the entries that the slots of a split had before.
    pub(super) fn collapse(&self, number: usize, entries: &mut [u32]) {
        // In reverse order: a slot that is written twice gets back its first entry.
        for i in range(&self.vertex_ends, number).rev() {
            let range = range(&self.slot_ends, i);
            for (&slot, &entry) in self.slots[range.clone()].iter().zip(&self.coarse[range]) {
                entries[slot as usize] = entry;
            }
        }
    }

    /// Adds a restored vertex to the open split, with its ascending slots and their previous
    /// entries.
    pub(super) fn push(&mut self, vertex: u32, written: impl Iterator<Item = (u32, u32)>) {
        self.vertices.push(vertex);
        for (slot, entry) in written {
            self.slots.push(slot);
            self.coarse.push(entry);
        }
        self.slot_ends.push(self.slots.len() as u32);
    }

    /// Ends a split. Fails if there are too many slots for a map of `entry_count` entries.
    pub(super) fn end(&mut self, entry_count: usize) -> Result<(), Error> {
        self.vertex_ends.push(self.vertices.len() as u32);
        let limit = entry_count.saturating_mul(MAX_SLOTS_PER_ENTRY).min(u32::MAX as usize);
        if self.slots.len() > limit {
            let (found, limit) = (self.slots.len() as u64, limit as u64);
            return Err(Error::LimitExceeded { what: "slots renamed by all collapses", found, limit });
        }
        Ok(())
    }
}

fn range(ends: &[u32], i: usize) -> std::ops::Range<usize> {
    if i == 0 { 0..ends[0] as usize } else { ends[i - 1] as usize..ends[i] as usize }
}
