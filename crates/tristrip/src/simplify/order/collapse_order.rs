//! Sorts the collapses of a pass, which are not found in the order of their prices.
//!
//! Two collapses whose points have no common neighbour are independent: either order gives the same
//! result. All others keep their order. Each collapse gets a key. It is the maximum of its price
//! and the keys of the earlier collapses of the pass that share a neighbour with it. Collapses are
//! sorted by key; equal keys keep the order in which they were found. Each collapse then follows
//! all collapses that it depends on.
//!
//! The passes are concatenated. The collapses that lead to a triangle count are therefore a prefix
//! of the collapses that lead to any smaller count, no matter when a simplification stops.

use crate::collapse::CollapseSequence;

/// The position of a collapse: the pass, and the key within it.
#[derive(Debug, Clone, Copy)]
struct PassPosition {
    pass: u32,
    key: f32,
}

/// The order of the collapses of a sequence.
#[derive(Debug)]
pub(crate) struct CollapseOrder {
    places: Vec<PassPosition>,
    /// For each point, the position of the last collapse that had it as a neighbour.
    latest: Vec<PassPosition>,
    /// The largest key.
    greatest: f32,
}

impl CollapseOrder {
    pub(crate) fn new(point_count: usize) -> Self {
        Self {
            places: Vec::new(),
            latest: vec![PassPosition { pass: 0, key: 0.0 }; point_count],
            greatest: 0.0,
        }
    }

    /// Adds a collapse of a pass, counted from 1, with a price of at least 0. The neighbours
    /// include the kept point.
    pub(crate) fn push(&mut self, pass: u32, price: f32, neighbours: &[u32]) {
        let of_pass =
            neighbours.iter().map(|&p| self.latest[p as usize]).filter(|latest| latest.pass == pass);
        let key = of_pass.map(|latest| latest.key).fold(price, f32::max);
        let place = PassPosition { pass, key };
        neighbours.iter().for_each(|&p| self.latest[p as usize] = place);
        self.greatest = self.greatest.max(key);
        self.places.push(place);
    }

    /// Returns the largest key, or 0 if there are none.
    pub(crate) fn greatest(&self) -> f32 {
        self.greatest
    }

    /// Sorts the collapses of a sequence, and removes those after the first level with at most
    /// `triangle_count` triangles. Returns the maximum key so far for each remaining collapse.
    pub(crate) fn apply(self, triangle_count: usize, sequence: &mut CollapseSequence) -> Vec<f32> {
        // The bit patterns of non-negative floats are ordered like their values.
        let rank = |place: &PassPosition| u64::from(place.pass) << 32 | u64::from(place.key.to_bits());
        let mut order: Vec<(u64, u32)> = self.places.iter().map(rank).zip(0..).collect();
        order.sort_unstable();
        let numbers: Vec<u32> = order.into_iter().map(|(_, number)| number).collect();
        sequence.reorder(&numbers, triangle_count);
        let mut greatest = 0.0_f32;
        let so_far = numbers[..sequence.len()].iter().map(|&number| {
            greatest = greatest.max(self.places[number as usize].key);
            greatest
        });
        so_far.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collapse::Rename;

    #[test]
    fn collapses_are_sorted_within_a_pass_and_after_those_they_depend_on() {
        // Five separate triangles; each collapse drops one.
        let mut sequence = CollapseSequence::new(15, (0..15).collect()).unwrap();
        let mut order = CollapseOrder::new(10);
        let found =
            [(1, 3.0, [0, 1]), (1, 1.0, [1, 2]), (1, 2.0, [3, 4]), (2, 0.5, [1, 5]), (2, 0.25, [6, 7])];
        for (number, (pass, price, neighbours)) in (0..).zip(found) {
            order.push(pass, price, &neighbours);
            sequence.push(&[Rename { removed: 3 * number, kept: 3 * number + 1 }], &[number], price);
        }
        assert_eq!(order.greatest().to_bits(), 3.0_f32.to_bits());
        let costs = order.apply(1, &mut sequence);
        let dropped: Vec<u32> = sequence.iter().flat_map(|collapse| collapse.dropped).copied().collect();
        assert_eq!(dropped, [2, 0, 1, 4]);
        assert_eq!(costs, [2.0, 3.0, 3.0, 3.0]);
    }
}
