//! The states of one strip. State 0 is the full mesh, and each collapse that changes the strip
//! leads to the next state.
//!
//! The multiresolution strip models are built strip by strip: the states of a strip are replayed in
//! order, and the changes between them are stored.

use super::shortened::{NONE, SlotEdit};

/// A strip at one of its states.
#[derive(Debug, Default)]
pub struct StripState {
    /// The vertex of each slot; [`NONE`] if it is removed.
    pub vertices: Vec<u32>,
    previous: Vec<u32>,
    next: Vec<u32>,
    first: u32,
}

impl StripState {
    /// Sets the strip to its state at the full mesh.
    pub fn start(&mut self, strip: &[u32]) {
        let len = strip.len() as u32;
        self.vertices.clear();
        self.vertices.extend_from_slice(strip);
        self.previous.clear();
        self.previous.extend((0..len).map(|slot| slot.wrapping_sub(1)));
        self.next.clear();
        self.next.extend((1..len).chain([NONE]).take(strip.len()));
        self.first = if len == 0 { NONE } else { 0 };
    }

    /// Changes a slot that is not removed yet.
    pub fn apply(&mut self, edit: SlotEdit) {
        if edit.vertex != NONE {
            self.vertices[edit.slot as usize] = edit.vertex;
            return;
        }
        let (previous, next) = (self.previous[edit.slot as usize], self.next[edit.slot as usize]);
        match previous {
            NONE => self.first = next,
            previous => self.next[previous as usize] = next,
        }
        if next != NONE {
            self.previous[next as usize] = previous;
        }
        self.vertices[edit.slot as usize] = NONE;
    }

    /// Returns the slot of the first vertex, or [`NONE`].
    pub(crate) fn first(&self) -> u32 {
        self.first
    }

    /// Returns the slot after a slot, or [`NONE`].
    pub(crate) fn next(&self, slot: u32) -> u32 {
        self.next[slot as usize]
    }

    /// Returns the nearest slot before a slot that is not removed, or [`NONE`]. The given slot may
    /// be removed.
    pub(crate) fn before(&self, slot: u32) -> u32 {
        let mut slot = self.previous[slot as usize];
        while slot != NONE && self.vertices[slot as usize] == NONE {
            slot = self.previous[slot as usize];
        }
        slot
    }
}
