//! A queue of numbered things by cost: the cheapest first, of equal ones the lowest number, so that the order never depends on how
//! the queue came to be. Costs may change while a thing waits.
//!
//! # Complexity
//! A heap of four children a node: O(log n) a change. 12 bytes a thing.

const NONE: u32 = u32::MAX;
const CHILDREN: usize = 4;

#[derive(Debug)]
pub(super) struct Queue {
    costs: Vec<f32>,
    /// Where each thing stands in the heap.
    places: Vec<u32>,
    heap: Vec<u32>,
}

impl Queue {
    /// Makes an empty queue for things numbered below a count.
    pub(super) fn new(count: usize) -> Self {
        Self { costs: vec![0.0; count], places: vec![NONE; count], heap: Vec::with_capacity(count) }
    }

    /// Gives the cheapest.
    pub(super) fn first(&self) -> Option<u32> {
        self.heap.first().copied()
    }

    /// Gives the cost of one that waits.
    pub(super) fn cost(&self, thing: u32) -> Option<f32> {
        (self.places[thing as usize] != NONE).then(|| self.costs[thing as usize])
    }

    /// Puts one in, or changes its cost.
    pub(super) fn set(&mut self, thing: u32, cost: f32) {
        let place = self.places[thing as usize];
        let was = std::mem::replace(&mut self.costs[thing as usize], cost);
        if place == NONE {
            self.heap.push(thing);
            self.rise(self.heap.len() - 1, thing);
        } else if cost < was {
            self.rise(place as usize, thing);
        } else {
            self.sink(place as usize, thing);
        }
    }

    /// Takes one out, if it waits.
    pub(super) fn remove(&mut self, thing: u32) {
        let place = std::mem::replace(&mut self.places[thing as usize], NONE);
        if place == NONE {
            return;
        }
        let last = self.heap.pop().unwrap_or(thing);
        if last != thing {
            self.rise(place as usize, last);
            self.sink(self.places[last as usize] as usize, last);
        }
    }

    fn is_before(&self, a: u32, b: u32) -> bool {
        let (x, y) = (self.costs[a as usize], self.costs[b as usize]);
        x < y || x.total_cmp(&y).is_eq() && a < b
    }

    fn put(&mut self, place: usize, thing: u32) {
        self.heap[place] = thing;
        self.places[thing as usize] = place as u32;
    }

    fn rise(&mut self, mut place: usize, thing: u32) {
        while place > 0 {
            let parent = (place - 1) / CHILDREN;
            if !self.is_before(thing, self.heap[parent]) {
                break;
            }
            self.put(place, self.heap[parent]);
            place = parent;
        }
        self.put(place, thing);
    }

    fn sink(&mut self, mut place: usize, thing: u32) {
        loop {
            let first = CHILDREN * place + 1;
            if first >= self.heap.len() {
                break;
            }
            let mut least = first;
            for child in first + 1..(first + CHILDREN).min(self.heap.len()) {
                if self.is_before(self.heap[child], self.heap[least]) {
                    least = child;
                }
            }
            if !self.is_before(self.heap[least], thing) {
                break;
            }
            self.put(place, self.heap[least]);
            place = least;
        }
        self.put(place, thing);
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
