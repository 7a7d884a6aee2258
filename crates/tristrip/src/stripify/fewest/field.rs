//! How far it is over shared edges to a goal nearby: what leads an end to another one.

use crate::random::Random;

const NONE: u32 = u32::MAX;

/// Distances in edges to the last goal, as far as they are known; and the triangles that have one.
#[derive(Debug)]
pub(super) struct Field<'a> {
    twins: &'a [u32],
    distance: Vec<u32>,
    reached: Vec<u32>,
}

impl<'a> Field<'a> {
    pub(super) fn new(twins: &'a [u32]) -> Self {
        Self { twins, distance: vec![NONE; twins.len() / 3], reached: Vec::new() }
    }

    /// The distance of a triangle from the goal; the greatest number where it is not known.
    pub(super) fn distance(&self, t: u32) -> u32 {
        self.distance[t as usize]
    }

    /// Counts the triangles whose distance is known.
    pub(super) fn reached_count(&self) -> usize {
        self.reached.len()
    }

    /// Finds the distances from `goal` outward until a triangle is reached that `stop` holds for, and gives it.
    pub(super) fn spread(&mut self, goal: u32, mut stop: impl FnMut(u32) -> bool) -> Option<u32> {
        for &t in &self.reached {
            self.distance[t as usize] = NONE;
        }
        self.reached.clear();
        self.reached.push(goal);
        self.distance[goal as usize] = 0;
        let mut next = 0;
        while let Some(&t) = self.reached.get(next) {
            next += 1;
            for &twin in &self.twins[3 * t as usize..3 * t as usize + 3] {
                let neighbour = twin / 3;
                if twin == NONE || self.distance[neighbour as usize] != NONE {
                    continue;
                }
                self.distance[neighbour as usize] = self.distance[t as usize] + 1;
                self.reached.push(neighbour);
                if stop(neighbour) {
                    return Some(neighbour);
                }
            }
        }
        None
    }

    /// Goes so many steps toward the goal, not quite to it, of equal ways by lot.
    pub(super) fn toward(&self, mut t: u32, steps: usize, random: &mut Random) -> u32 {
        for _ in 0..steps {
            if self.distance(t) <= 1 {
                break;
            }
            let first = random.below(3);
            let around = (first..first + 3).map(|edge| self.twins[3 * t as usize + edge % 3]);
            let nearer =
                around.filter(|&h| h != NONE).map(|h| h / 3).find(|&n| self.distance(n) < self.distance(t));
            t = nearer.unwrap_or(t);
        }
        t
    }
}
