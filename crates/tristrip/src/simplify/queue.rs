//! A queue of numbered items by cost: the cheapest first, of equal ones the lowest number, so that the order does not depend on the
//! history of the queue. Costs may change while an item waits.
//!
//! # Complexity
//! A heap with four children per node: O(log n) per change. 12 bytes per item.

use crate::ids::OptionalId;

const CHILDREN: usize = 4;

#[derive(Debug, Clone, Copy)]
struct CostEntry {
    cost: f32,
    item: u32,
}

impl CostEntry {
    fn is_before(self, other: Self) -> bool {
        self.cost < other.cost || self.cost.total_cmp(&other.cost).is_eq() && self.item < other.item
    }
}

#[derive(Debug)]
pub(super) struct CostQueue {
    /// The index of each waiting item in the heap.
    slots: Vec<OptionalId>,
    heap: Vec<CostEntry>,
}

impl CostQueue {
    /// Creates an empty queue for items numbered below a count.
    pub(super) fn new(count: usize) -> Self {
        Self { slots: vec![OptionalId::NONE; count], heap: Vec::with_capacity(count) }
    }

    /// Returns the cheapest item.
    pub(super) fn first(&self) -> Option<u32> {
        self.heap.first().map(|entry| entry.item)
    }

    /// Returns the cost of an item that waits.
    pub(super) fn cost(&self, item: u32) -> Option<f32> {
        self.slots[item as usize].get().map(|slot| self.heap[slot as usize].cost)
    }

    /// Inserts an item, or changes its cost.
    pub(super) fn set(&mut self, item: u32, cost: f32) {
        let entry = CostEntry { cost, item };
        match self.slots[item as usize].get() {
            None => {
                self.heap.push(entry);
                self.rise(self.heap.len() - 1, entry);
            }
            Some(slot) if entry.is_before(self.heap[slot as usize]) => self.rise(slot as usize, entry),
            Some(slot) => self.sink(slot as usize, entry),
        }
    }

    /// Removes an item, if it waits.
    pub(super) fn remove(&mut self, item: u32) {
        let slot = std::mem::replace(&mut self.slots[item as usize], OptionalId::NONE);
        let Some(slot) = slot.get().map(|slot| slot as usize) else { return };
        let removed = self.heap.swap_remove(slot);
        if let Some(&moved) = self.heap.get(slot) {
            if moved.is_before(removed) {
                self.rise(slot, moved);
            } else {
                self.sink(slot, moved);
            }
        }
    }

    fn put(&mut self, slot: usize, entry: CostEntry) {
        self.heap[slot] = entry;
        self.slots[entry.item as usize] = OptionalId::some(slot as u32);
    }

    fn rise(&mut self, mut slot: usize, entry: CostEntry) {
        while slot > 0 {
            let parent = (slot - 1) / CHILDREN;
            if !entry.is_before(self.heap[parent]) {
                break;
            }
            self.put(slot, self.heap[parent]);
            slot = parent;
        }
        self.put(slot, entry);
    }

    fn sink(&mut self, mut slot: usize, entry: CostEntry) {
        loop {
            let first = CHILDREN * slot + 1;
            let end = (first + CHILDREN).min(self.heap.len());
            let Some(children) = self.heap.get(first..end).filter(|children| !children.is_empty()) else {
                break;
            };
            let mut least = 0;
            for child in 1..children.len() {
                if children[child].is_before(children[least]) {
                    least = child;
                }
            }
            if !children[least].is_before(entry) {
                break;
            }
            self.put(slot, children[least]);
            slot = first + least;
        }
        self.put(slot, entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn returns_the_least_cost_and_then_the_lowest_number(
            changes in prop::collection::vec((0..20_u32, prop::option::of(0..6_u8)), 0..200),
        ) {
            let mut queue = CostQueue::new(20);
            let mut oracle = std::collections::BTreeMap::new();
            for (item, cost) in changes {
                if let Some(cost) = cost {
                    queue.set(item, f32::from(cost));
                    oracle.insert(item, cost);
                } else {
                    queue.remove(item);
                    oracle.remove(&item);
                }
                let least = oracle.iter().min_by_key(|&(&item, &cost)| (cost, item)).map(|(&item, _)| item);
                prop_assert_eq!(queue.first(), least);
                prop_assert_eq!(queue.cost(item), oracle.get(&item).map(|&cost| f32::from(cost)));
            }
        }
    }
}
