//! A queue of numbered things by cost: the cheapest first, of equal ones the lowest number, so that the order never depends on how
//! the queue came to be. Costs may change while a thing waits.
//!
//! # Complexity
//! A heap of four children a node: O(log n) a change. 12 bytes a thing.

const NONE: u32 = u32::MAX;
const CHILDREN: usize = 4;

#[derive(Debug, Clone, Copy)]
struct Entry {
    cost: f32,
    thing: u32,
}

impl Entry {
    fn is_before(self, other: Self) -> bool {
        self.cost < other.cost || self.cost.total_cmp(&other.cost).is_eq() && self.thing < other.thing
    }
}

#[derive(Debug)]
pub(super) struct Queue {
    /// Where each thing stands in the heap.
    places: Vec<u32>,
    heap: Vec<Entry>,
}

impl Queue {
    /// Makes an empty queue for things numbered below a count.
    pub(super) fn new(count: usize) -> Self {
        Self { places: vec![NONE; count], heap: Vec::with_capacity(count) }
    }

    /// Gives the cheapest.
    pub(super) fn first(&self) -> Option<u32> {
        self.heap.first().map(|entry| entry.thing)
    }

    /// Gives the cost of one that waits.
    pub(super) fn cost(&self, thing: u32) -> Option<f32> {
        self.heap.get(self.places[thing as usize] as usize).map(|entry| entry.cost)
    }

    /// Puts one in, or changes its cost.
    pub(super) fn set(&mut self, thing: u32, cost: f32) {
        let (place, entry) = (self.places[thing as usize] as usize, Entry { cost, thing });
        match self.heap.get(place) {
            None => {
                self.heap.push(entry);
                self.rise(self.heap.len() - 1, entry);
            }
            Some(was) if entry.is_before(*was) => self.rise(place, entry),
            Some(_) => self.sink(place, entry),
        }
    }

    /// Takes one out, if it waits.
    pub(super) fn remove(&mut self, thing: u32) {
        let place = std::mem::replace(&mut self.places[thing as usize], NONE) as usize;
        if place >= self.heap.len() {
            return;
        }
        let gone = self.heap.swap_remove(place);
        if let Some(&moved) = self.heap.get(place) {
            if moved.is_before(gone) {
                self.rise(place, moved);
            } else {
                self.sink(place, moved);
            }
        }
    }

    fn put(&mut self, place: usize, entry: Entry) {
        self.heap[place] = entry;
        self.places[entry.thing as usize] = place as u32;
    }

    fn rise(&mut self, mut place: usize, entry: Entry) {
        while place > 0 {
            let parent = (place - 1) / CHILDREN;
            if !entry.is_before(self.heap[parent]) {
                break;
            }
            self.put(place, self.heap[parent]);
            place = parent;
        }
        self.put(place, entry);
    }

    fn sink(&mut self, mut place: usize, entry: Entry) {
        loop {
            let first = CHILDREN * place + 1;
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
            self.put(place, children[least]);
            place = first + least;
        }
        self.put(place, entry);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn gives_the_least_cost_and_then_the_least_number(
            changes in prop::collection::vec((0..20_u32, prop::option::of(0..6_u8)), 0..200),
        ) {
            let mut queue = Queue::new(20);
            let mut oracle = std::collections::BTreeMap::new();
            for (thing, cost) in changes {
                if let Some(cost) = cost {
                    queue.set(thing, f32::from(cost));
                    oracle.insert(thing, cost);
                } else {
                    queue.remove(thing);
                    oracle.remove(&thing);
                }
                let least = oracle.iter().min_by_key(|&(&thing, &cost)| (cost, thing)).map(|(&thing, _)| thing);
                prop_assert_eq!(queue.first(), least);
                prop_assert_eq!(queue.cost(thing), oracle.get(&thing).map(|&cost| f32::from(cost)));
            }
        }
    }
}
