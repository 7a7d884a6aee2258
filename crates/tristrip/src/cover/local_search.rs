//! Dives: short chains of changes that may pass through dearer covers, but never end in one.
//!
//! ```text
//!   ━ a ━ b ━ c ━        cut a–b, an index dearer; graft b over to d and join a with e, an index cheaper than before
//!     ┊   ┊
//!     e   d ━ f ━        what ends dearer than it began is undone, in the opposite order
//! ```
//! An annealing finds the way over a rise by chance, and mends what it has spoiled while it cools. Where little has changed since a
//! good cover, as beside a collapse, a dive gains more in the same time: it goes on from where it has cut, and forgets what failed.
//!
//! # Algorithm
//! 1. From the end of a path, or from the two ends that a cut between two triangles makes,
//! 2. change one of the ends by a join or a graft, at random, while the cost is not more than [`Diver::dive`]'s limit above the beginning;
//! 3. stop where it is cheaper than in the beginning, no end is left, or after some changes; undo all if it is dearer.
//!
//! A dive that ends as dear as it began is kept: so ends wander until they meet.
//!
//! # Complexity
//! A few changes each, in O(length of the paths that they cut).

use super::moves::{Change, change_end};
use super::priced::Paths;
use crate::random::Random;

/// Changes of a dive after its cut. Tuned on the bunny at all of its levels: 2 leaves covers dearer, 8 takes longer for the same.
const DEPTH: u32 = 4;

/// Dives, and remembers what to undo.
#[derive(Debug, Clone)]
pub(crate) struct Diver {
    random: Random,
    done: Vec<Done>,
}

/// A change, by its half-edge.
#[derive(Debug, Clone, Copy)]
enum Done {
    Joined(u32),
    Cut(u32),
}

impl Diver {
    pub(crate) fn new(seed: u64) -> Self {
        Self { random: Random::new(seed), done: Vec::new() }
    }

    /// Dives from a triangle. On the way the cost may rise by less than a strip's price; in the end it has not risen.
    pub(crate) fn dive(&mut self, paths: &mut Paths, t: u32) {
        let start = paths.cost();
        let highest = start + i64::from(paths.prices().strip - 1);
        self.done.clear();
        let (mut ends, mut count) = ([t, t], 1);
        if paths.degree(t) == 2 {
            let Some(other) = self.open(paths, t, highest) else { return };
            (ends[1], count) = (other, 2);
        }
        for _ in 0..DEPTH {
            if count == 0 || paths.cost() < start {
                break;
            }
            let draw = self.random.next_u64();
            let chosen = draw as usize & (count - 1);
            let change = if paths.degree(ends[chosen]) == 2 {
                None // the other end has been led to this one
            } else {
                Some(change_end(paths, ends[chosen], draw, (highest - paths.cost()) as i32))
            };
            match change {
                Some(Change::Refused) => continue,
                Some(Change::Grafted { link, cut, end }) => {
                    self.done.extend([Done::Cut(cut), Done::Joined(link)]);
                    ends[chosen] = end;
                    continue;
                }
                Some(Change::Joined(link)) => self.done.push(Done::Joined(link)),
                None => {}
            }
            ends[chosen] = ends[count - 1];
            count -= 1;
        }
        if paths.cost() > start {
            self.undo(paths);
        }
    }

    /// Cuts a link of a triangle inside a path, over an edge at random. Returns the end beyond; `None` where there is no link or the cut is
    /// too dear.
    fn open(&mut self, paths: &mut Paths, t: u32, highest: i64) -> Option<u32> {
        let link = 4 * t + self.random.below(3) as u32;
        if paths.mask(t) >> (link % 4) & 1 == 0 || paths.cost() + i64::from(paths.cut_rise(link)) > highest {
            return None;
        }
        paths.cut(link);
        self.done.push(Done::Cut(link));
        Some(paths.twin(link) / 4)
    }

    fn undo(&mut self, paths: &mut Paths) {
        for done in self.done.drain(..).rev() {
            match done {
                Done::Joined(link) => _ = paths.cut(link),
                Done::Cut(link) => _ = paths.join(link),
            }
        }
    }
}
