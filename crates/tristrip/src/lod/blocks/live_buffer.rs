//! Applies the collapses below a key to the index buffer of the key, and finds the slots that each
//! collapse writes.
//!
//! ```text
//! strip         a b c d e f g h
//! d, e, f → c   a b c c c c g h     a b c and c g h are drawn
//! written       a b c ⟂ ⟂ c g h     the slots between them are restarts: two vertices fewer
//! ```
//! # Algorithm
//! A collapse writes the kept vertex into the slots of the removed one. Then the consecutive
//! degenerate triangles around each of these slots are examined. Slots between the remaining
//! triangles on both sides, or up to an end of the strip, become restarts if they are not needed.
//! The remaining part begins at an even position of the original strip, which preserves the winding
//! of all triangles. If it would begin at an odd position, the slot before it is kept.
//!
//! # Complexity
//! A constant number of steps per renamed slot: a run of degenerate triangles is overwritten the
//! first time it is examined, so runs remain short.

use crate::collapse::Rename;
use crate::lod::level::index_map::RESTART;
use crate::lod::level::replay::VertexSlots;
use crate::mesh::is_degenerate;

/// A write into a slot by a collapse, ordered by the overwritten entry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Change {
    pub(super) fine: u32,
    pub(super) coarse: u32,
    pub(super) slot: u32,
}

/// The entries of the buffer after the last applied collapse.
#[derive(Debug)]
pub(super) struct LiveBuffer {
    entries: Vec<u32>,
    /// The slots of each vertex, including those that have become restarts.
    of_vertex: VertexSlots,
    /// For each slot, whether the triangle that begins there has reversed winding.
    is_odd: Vec<bool>,
    taken: Vec<u32>,
    /// The slots written by a collapse, with their previous entries.
    written: Vec<(u32, u32)>,
    changes: Vec<Change>,
}

impl LiveBuffer {
    /// Starts with an index map. The buffer has at least one slot.
    pub(super) fn new(mut entries: Vec<u32>, vertex_count: usize) -> Self {
        if entries.is_empty() {
            entries.push(RESTART);
        }
        let mut is_odd = Vec::with_capacity(entries.len());
        let mut next = false;
        for &entry in &entries {
            is_odd.push(next);
            next = entry != RESTART && !next;
        }
        Self {
            of_vertex: VertexSlots::of(&entries, vertex_count, |_| true),
            entries,
            is_odd,
            taken: Vec::new(),
            written: Vec::new(),
            changes: Vec::new(),
        }
    }

    pub(super) fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// Applies a collapse and returns what it writes. At least one slot is returned, even if its
    /// entry does not change.
    pub(super) fn collapse(&mut self, renames: &[Rename]) -> &[Change] {
        self.written.clear();
        for &Rename { removed, kept } in renames {
            self.of_vertex.take(removed, &mut self.taken);
            self.taken.retain(|&slot| self.entries[slot as usize] == removed);
            for &slot in &self.taken {
                self.written.push((slot, removed));
                self.entries[slot as usize] = kept;
                self.of_vertex.add(kept, slot);
            }
        }
        for i in 0..self.written.len() {
            let slot = self.written[i].0 as usize;
            (slot.saturating_sub(2)..=slot).for_each(|first| self.clear_around(first));
        }
        // The first entry recorded for a slot is the one before the collapse.
        self.written.sort_by_key(|&(slot, _)| slot);
        self.written.dedup_by_key(|&mut (slot, _)| slot);
        if self.written.is_empty() {
            self.written.push((0, self.entries[0]));
        }
        let coarse = |slot: u32| self.entries[slot as usize];
        let changes = self.written.iter().map(|&(slot, fine)| Change { fine, coarse: coarse(slot), slot });
        self.changes.clear();
        self.changes.extend(changes);
        self.changes.sort_unstable();
        &self.changes
    }

    /// Returns whether a triangle begins at a slot, degenerate or not.
    fn is_inside(&self, first: usize) -> bool {
        self.entries
            .get(first..first + 3)
            .is_some_and(|entries| entries.iter().all(|&entry| entry != RESTART))
    }

    /// Returns whether the triangle that begins at a slot is drawn.
    fn is_drawn(&self, first: usize) -> bool {
        let [a, b, c] = [first, first + 1, first + 2].map(|slot| self.entries[slot]);
        !is_degenerate([a, b, c])
    }

    /// Overwrites superfluous slots around the triangle that begins at a slot, if it is degenerate.
    fn clear_around(&mut self, first: usize) {
        if !self.is_inside(first) || self.is_drawn(first) {
            return;
        }
        let (mut start, mut end) = (first, first + 1);
        while start > 0 && self.is_inside(start - 1) && !self.is_drawn(start - 1) {
            start -= 1;
        }
        while self.is_inside(end) && !self.is_drawn(end) {
            end += 1;
        }
        // The triangles from `start` to `end` are degenerate.
        let has_before = start > 0 && self.is_inside(start - 1);
        let from = if has_before { start + 2 } else { start };
        let to = if self.is_inside(end) { end - usize::from(self.is_odd[end]) } else { end + 2 };
        for slot in from..to {
            self.written.push((slot as u32, self.entries[slot]));
            self.entries[slot] = RESTART;
        }
    }
}
