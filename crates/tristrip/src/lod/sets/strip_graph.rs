//! The graph of one strip over all its states, from which SETS is built.
//!
//! ```text
//! state 0  a b c d e f g h     nodes   a b c d e f g h
//! state 1  a b d d e f g h     visits  of d: 1 at state 0, 2 at state 1
//! ```
//! A node is a vertex that the strip has at any state. A walk visits it once per slot that contains
//! the vertex, and each visit leads to the vertex in the next slot.

use rustc_hash::FxHashMap;

use super::shortened::{NONE, SlotEdit};
use super::strip_states::StripState;

/// Replays one strip and tracks which nodes each state changes.
#[derive(Debug, Default)]
pub struct StripGraph {
    state: StripState,
    number_of: FxHashMap<u32, u32>,
    /// The vertex of each node.
    pub vertices: Vec<u32>,
    node_of_slot: Vec<u32>,
    /// The slots of each node, in arbitrary order. Entries after the nodes of the strip are kept to
    /// reuse their memory.
    slots: Vec<Vec<u32>>,
    /// The index of each slot in the list of its node.
    place_of_slot: Vec<u32>,
    /// The nodes whose visits or successors the last step changed, sorted and without duplicates.
    pub changed: Vec<u32>,
    /// The slots whose vertex or successor the last step changed, sorted and without duplicates.
    pub changed_slots: Vec<u32>,
}

impl StripGraph {
    /// Starts with a strip at the full mesh, with all its nodes and slots marked as changed.
    pub(crate) fn start(&mut self, strip: &[u32]) {
        self.state.start(strip);
        self.number_of.clear();
        self.vertices.clear();
        self.node_of_slot.clear();
        self.node_of_slot.resize(strip.len(), NONE);
        self.place_of_slot.clear();
        self.place_of_slot.resize(strip.len(), NONE);
        for (slot, &vertex) in (0..).zip(strip) {
            self.enter(slot, vertex);
        }
        self.changed.clear();
        self.changed.extend(0..self.vertices.len() as u32);
        self.changed_slots.clear();
        self.changed_slots.extend(0..strip.len() as u32);
    }

    /// Applies the edits of one step, which leads to the next state.
    pub(crate) fn step(&mut self, edits: &[SlotEdit]) {
        self.changed.clear();
        self.changed_slots.clear();
        for &edit in edits {
            let left = self.leave(edit.slot);
            self.changed.push(left);
            self.state.apply(edit);
            if edit.vertex != NONE {
                self.enter(edit.slot, edit.vertex);
                self.changed.push(self.node_of_slot[edit.slot as usize]);
            }
        }
        for edit in edits {
            let before = self.state.before(edit.slot);
            if before != NONE {
                self.changed.push(self.node_of_slot[before as usize]);
                self.changed_slots.push(before);
            }
            self.changed_slots.push(edit.slot);
        }
        for changed in [&mut self.changed, &mut self.changed_slots] {
            changed.sort_unstable();
            changed.dedup();
        }
    }

    /// Puts a vertex into a slot that is in no node's list.
    fn enter(&mut self, slot: u32, vertex: u32) {
        let new = self.vertices.len() as u32;
        let node = *self.number_of.entry(vertex).or_insert(new);
        if node == new {
            self.vertices.push(vertex);
            if self.slots.len() <= node as usize {
                self.slots.push(Vec::new());
            }
            self.slots[node as usize].clear();
        }
        let slots = &mut self.slots[node as usize];
        self.place_of_slot[slot as usize] = slots.len() as u32;
        slots.push(slot);
        self.node_of_slot[slot as usize] = node;
    }

    /// Removes a slot from its node's list and returns the node.
    fn leave(&mut self, slot: u32) -> u32 {
        let node = self.node_of_slot[slot as usize];
        let place = self.place_of_slot[slot as usize];
        let slots = &mut self.slots[node as usize];
        slots.swap_remove(place as usize);
        if let Some(&moved) = slots.get(place as usize) {
            self.place_of_slot[moved as usize] = place;
        }
        node
    }

    /// Returns the number of slots of the strip at the full mesh.
    pub fn slot_count(&self) -> usize {
        self.node_of_slot.len()
    }

    /// Returns the first node, or [`NONE`] if the strip is empty.
    pub(crate) fn first(&self) -> u32 {
        match self.state.first() {
            NONE => NONE,
            slot => self.node_of_slot[slot as usize],
        }
    }

    /// Returns the node in a slot and its successor, or [`NONE`] at the end; `None` for a removed
    /// slot.
    pub fn edge(&self, slot: u32) -> Option<[u32; 2]> {
        if self.state.vertices[slot as usize] == NONE {
            return None;
        }
        Some([self.node_of_slot[slot as usize], self.successor(slot)])
    }

    /// Returns the node after a slot that is not removed, or [`NONE`] at the end.
    fn successor(&self, slot: u32) -> u32 {
        match self.state.next(slot) {
            NONE => NONE,
            next => self.node_of_slot[next as usize],
        }
    }

    /// Replaces `successors` by the nodes that follow the visits of a node, in order, with [`NONE`]
    /// for the end.
    pub(crate) fn successors_to(&self, node: u32, successors: &mut Vec<u32>) {
        successors.clear();
        successors.extend_from_slice(&self.slots[node as usize]);
        successors.sort_unstable();
        successors.iter_mut().for_each(|slot| *slot = self.successor(*slot));
    }
}
