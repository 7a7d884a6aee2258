//! Distances over shared edges to a nearby goal, by breadth-first search. These distances guide one
//! end of a path to another.

use crate::dual::DualGraph;
use crate::random::Random;

/// A distance value: not reached by the last search.
const UNREACHED: u32 = u32::MAX;

/// Distances in edges to the goal of the last search, and the triangles that it reached.
#[derive(Debug)]
pub(super) struct DistanceMap<'a> {
    graph: &'a DualGraph,
    distances: Vec<u32>,
    reached: Vec<u32>,
}

impl<'a> DistanceMap<'a> {
    pub(super) fn new(graph: &'a DualGraph) -> Self {
        Self { graph, distances: vec![UNREACHED; graph.face_count()], reached: Vec::new() }
    }

    /// Returns the distance of a triangle from the goal, or `None` if the search did not reach it.
    pub(super) fn distance(&self, t: u32) -> Option<u32> {
        let distance = self.distances[t as usize];
        (distance != UNREACHED).then_some(distance)
    }

    /// Counts the triangles that the last search reached.
    pub(super) fn reached_count(&self) -> usize {
        self.reached.len()
    }

    /// Searches from `goal` until it reaches a triangle for which `stop` returns `true`, and
    /// returns that triangle.
    pub(super) fn search_from(&mut self, goal: u32, mut stop: impl FnMut(u32) -> bool) -> Option<u32> {
        for &t in &self.reached {
            self.distances[t as usize] = UNREACHED;
        }
        self.reached.clear();
        self.reached.push(goal);
        self.distances[goal as usize] = 0;
        let mut next = 0;
        while let Some(&t) = self.reached.get(next) {
            next += 1;
            let distance = self.distances[t as usize] + 1;
            for neighbour in (3 * t..3 * t + 3).filter_map(|h| self.graph.twin_of(h)).map(|twin| twin / 3) {
                if self.distances[neighbour as usize] != UNREACHED {
                    continue;
                }
                self.distances[neighbour as usize] = distance;
                self.reached.push(neighbour);
                if stop(neighbour) {
                    return Some(neighbour);
                }
            }
        }
        None
    }

    /// Moves at most `steps` steps toward the goal, but not into it. Chooses at random among
    /// shortest ways.
    pub(super) fn toward_goal(&self, mut t: u32, steps: usize, random: &mut Random) -> u32 {
        for _ in 0..steps {
            let distance = self.distances[t as usize];
            if distance <= 1 {
                break;
            }
            let first = random.below(3) as u32;
            let neighbours =
                (first..first + 3).filter_map(|edge| self.graph.twin_of(3 * t + edge % 3)).map(|h| h / 3);
            let nearer = neighbours.into_iter().find(|&n| self.distances[n as usize] < distance);
            t = nearer.unwrap_or(t);
        }
        t
    }
}
