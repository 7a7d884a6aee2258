//! The order of collapses that were found in another one.
//!
//! Two collapses whose points have no neighbour in common do not touch each other: they give the same in either order. All others keep
//! their order. Each collapse gets a key, its price or the largest key of those before it that had one of its points as a neighbour, whichever is
//! more; sorted by key, and of equal keys in the order in which they were found, each comes after all that it depends on.

use crate::collapse::CollapseSequence;

/// The keys of the collapses of a sequence.
#[derive(Debug)]
pub(super) struct CollapseOrder {
    keys: Vec<f32>,
    /// The largest key of a collapse that had this point as a neighbour.
    latest: Vec<f32>,
    /// The largest key.
    greatest: f32,
}

impl CollapseOrder {
    pub(super) fn new(point_count: usize) -> Self {
        Self { keys: Vec::new(), latest: vec![0.0; point_count], greatest: 0.0 }
    }

    /// Adds the collapse of a point with its price, at least 0; the neighbours include the point that it goes to.
    pub(super) fn push(&mut self, price: f32, point: u32, neighbours: &[u32]) {
        let key = neighbours.iter().map(|&p| self.latest[p as usize]).fold(price, f32::max);
        let key = key.max(self.latest[point as usize]);
        neighbours.iter().for_each(|&p| self.latest[p as usize] = key);
        self.greatest = self.greatest.max(key);
        self.keys.push(key);
    }

    /// Returns the largest key, 0 without any.
    pub(super) fn greatest(&self) -> f32 {
        self.greatest
    }

    /// Sorts the collapses of a sequence, and removes those after the first level of at most `triangle_count` triangles. Returns the keys
    /// of those that are left, ascending.
    pub(super) fn apply(self, triangle_count: usize, sequence: &mut CollapseSequence) -> Vec<f32> {
        // The bits of numbers from 0 on have the order of the numbers.
        let mut order: Vec<(u32, u32)> = self.keys.iter().map(|key| key.to_bits()).zip(0..).collect();
        order.sort_unstable();
        let numbers: Vec<u32> = order.iter().map(|&(_, number)| number).collect();
        sequence.reorder(&numbers, triangle_count);
        order.iter().take(sequence.len()).map(|&(bits, _)| f32::from_bits(bits)).collect()
    }
}
