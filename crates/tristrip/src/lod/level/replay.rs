//! Replay: the entries of an index map at a level, and the records that collapses and vertex splits
//! use to rename entries.

use super::index_map::RESTART;
use crate::error::Error;

/// The maximum number of renamed slots per entry of a map, over all collapses. Typical meshes have
/// about five; a malicious sequence can have as many as there are collapses.
pub(crate) const MAX_SLOTS_PER_ENTRY: usize = 256;

/// The effect of a vertex split: one vertex is written to some slots of the index map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SlotUpdate<'a> {
    /// The restored vertex.
    pub vertex: u32,
    /// The slots of the vertex in the index map, counted from 0, in ascending order.
    pub slots: &'a [u32],
}

/// The entries of a map at one level. Applying records moves the map to other levels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Replay {
    pub(crate) entries: Vec<u32>,
    pub(crate) level: usize,
}

impl Replay {
    pub(crate) fn refine(&mut self, records: &Records) -> bool {
        if self.level >= records.len() {
            return false;
        }
        records.split(records.number(self.level), &mut self.entries);
        self.level += 1;
        true
    }

    pub(crate) fn coarsen(&mut self, records: &Records) -> bool {
        if self.level == 0 {
            return false;
        }
        self.level -= 1;
        records.collapse(records.number(self.level), &mut self.entries);
        true
    }

    /// Moves to an existing level.
    pub(crate) fn go_to(&mut self, level: usize, records: &Records) {
        while self.level < level && self.refine(records) {}
        while self.level > level && self.coarsen(records) {}
    }
}

/// The slots and entries that each collapse writes. Models add collapses in order from the full
/// mesh to the base mesh, and look them up by level.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Records {
    /// The end of the vertices of each collapse.
    vertex_ends: Vec<u32>,
    /// The removed vertices.
    pub(crate) vertices: Vec<u32>,
    /// The end of the slots of each vertex.
    slot_ends: Vec<u32>,
    pub(crate) slots: Vec<u32>,
    /// The entry that the collapse writes into each slot.
    coarse: Vec<u32>,
}

impl Records {
    pub(crate) fn len(&self) -> usize {
        self.vertex_ends.len()
    }

    /// Returns the memory of the records in bytes.
    pub(crate) fn memory(&self) -> usize {
        let lists = [&self.vertex_ends, &self.vertices, &self.slot_ends, &self.slots, &self.coarse];
        lists.map(|list| size_of_val(&list[..])).iter().sum()
    }

    /// Returns the number of the collapse that leads to a level. The collapse of the full mesh is
    /// number 0.
    fn number(&self, level: usize) -> usize {
        self.len() - 1 - level
    }

    pub(crate) fn vertices_of(&self, level: usize) -> std::ops::Range<usize> {
        range(&self.vertex_ends, self.number(level))
    }

    /// Writes the vertices of a collapse into their slots. Collapses are numbered from 0 in the
    /// order in which they were added.
    pub(crate) fn split(&self, number: usize, entries: &mut [u32]) {
        for i in range(&self.vertex_ends, number) {
            let slots = &self.slots[range(&self.slot_ends, i)];
            slots.iter().for_each(|&slot| entries[slot as usize] = self.vertices[i]);
        }
    }

    /// Undoes [`Records::split`]: writes the coarse entries into the slots of a collapse.
    pub(crate) fn collapse(&self, number: usize, entries: &mut [u32]) {
        // In reverse order, so that a slot written twice gets its first entry back.
        for i in range(&self.vertex_ends, number).rev() {
            let range = range(&self.slot_ends, i);
            for (&slot, &entry) in self.slots[range.clone()].iter().zip(&self.coarse[range]) {
                entries[slot as usize] = entry;
            }
        }
    }

    /// Returns the updates of the split at `level`, which must be less than [`Records::len`].
    pub(crate) fn split_of(&self, level: usize) -> impl ExactSizeIterator<Item = SlotUpdate<'_>> {
        self.vertices_of(level)
            .map(|i| SlotUpdate { vertex: self.vertices[i], slots: &self.slots[range(&self.slot_ends, i)] })
    }

    /// Adds a removed vertex to the open collapse, with its slots in ascending order and the
    /// entries written into them.
    pub(crate) fn push(&mut self, vertex: u32, written: impl Iterator<Item = (u32, u32)>) {
        self.vertices.push(vertex);
        for (slot, entry) in written {
            self.slots.push(slot);
            self.coarse.push(entry);
        }
        self.slot_ends.push(self.slots.len() as u32);
    }

    /// Closes the open collapse. Fails if there are too many slots for a map of `entry_count`
    /// entries.
    pub(crate) fn end(&mut self, entry_count: usize) -> Result<(), Error> {
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

/// The slots of each vertex, as linked lists over the map.
#[derive(Debug)]
pub(crate) struct VertexSlots {
    /// The first slot of each vertex plus 1, or 0 if there is none.
    first: Vec<u32>,
    /// The slot after each slot in the list of its vertex, plus 1, or 0 at the end.
    next: Vec<u32>,
}

impl VertexSlots {
    /// Lists the slots for which `is_listed` holds.
    pub(crate) fn of(map: &[u32], vertex_count: usize, is_listed: impl Fn(usize) -> bool) -> Self {
        let mut slots = Self { first: vec![0; vertex_count], next: vec![0; map.len()] };
        for (slot, &vertex) in map.iter().enumerate().rev() {
            if vertex != RESTART && is_listed(slot) {
                slots.add(vertex, slot as u32);
            }
        }
        slots
    }

    pub(crate) fn add(&mut self, vertex: u32, slot: u32) {
        self.next[slot as usize] = std::mem::replace(&mut self.first[vertex as usize], slot + 1);
    }

    /// Removes all slots of a vertex and writes them to `taken` in ascending order.
    pub(crate) fn take(&mut self, vertex: u32, taken: &mut Vec<u32>) {
        taken.clear();
        let mut slot = std::mem::take(&mut self.first[vertex as usize]);
        while slot > 0 {
            taken.push(slot - 1);
            slot = self.next[slot as usize - 1];
        }
        taken.sort_unstable();
    }
}
