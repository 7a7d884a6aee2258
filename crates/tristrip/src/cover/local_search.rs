//! Local search on a cover: short chains of moves that may pass through more expensive covers but never end in one.
//!
//! ```text
//!   ━ a ━ b ━ c ━        cut a–b, one index more; rotate b over to d and join a with e, one index fewer than before
//!     ┊   ┊
//!     e   d ━ f ━        a chain that ends more expensive than it began is undone in reverse order
//! ```
//! Annealing passes over a rise by chance and repairs the damage while it cools. If little has changed since a good cover, as near a
//! collapse, a chain gains more in the same time: it continues where it has cut, and failed attempts leave no trace.
//!
//! # Algorithm
//! 1. Start at the end of a path, or at the two ends that a cut between two triangles creates.
//! 2. Change one of the ends by a join or a rotation, at random, while the cost stays within [`LocalSearch::improve_at`]'s limit above
//!    the start.
//! 3. Stop when the cost is below the start, no end is left, or after a number of moves; undo everything if the cost is higher.
//!
//! A chain that ends at the cost at which it began is kept, so ends move until they meet.
//!
//! # Complexity
//! A few moves per chain, each in O(length of the paths that it cuts).

use super::moves::{EndMove, Join, move_end};
use super::priced::PricedPaths;
use crate::random::Random;

/// Moves of a chain after its cut. Tuned on the bunny at all of its levels: 2 leaves more expensive covers, 8 takes longer for the same.
const DEPTH: u32 = 4;

/// Improves covers by chains of moves, and records what to undo.
#[derive(Debug, Clone)]
pub(crate) struct LocalSearch {
    random: Random,
    applied: Vec<AppliedMove>,
}

/// An elementary move, by its half-edge.
#[derive(Debug, Clone, Copy)]
enum AppliedMove {
    Joined(Join),
    Cut(u32),
}

impl LocalSearch {
    pub(crate) fn new(seed: u64) -> Self {
        Self { random: Random::new(seed), applied: Vec::new() }
    }

    /// Tries one chain of moves from a triangle. Within the chain the cost may rise by less than a strip's price; after it the cost has
    /// not risen.
    pub(crate) fn improve_at(&mut self, paths: &mut PricedPaths, t: u32) {
        let start = paths.cost();
        let highest = start + i64::from(paths.prices().strip - 1);
        self.applied.clear();
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
                None // a move of the other end has linked this one
            } else {
                Some(move_end(paths, ends[chosen], draw, (highest - paths.cost()) as i32))
            };
            match change {
                Some(EndMove::Refused) => continue,
                Some(EndMove::Rotated { cut, join, end }) => {
                    self.applied.extend([AppliedMove::Cut(cut), AppliedMove::Joined(join)]);
                    ends[chosen] = end;
                    continue;
                }
                Some(EndMove::Joined(join)) => self.applied.push(AppliedMove::Joined(join)),
                None => {}
            }
            ends[chosen] = ends[count - 1];
            count -= 1;
        }
        if paths.cost() > start {
            self.undo(paths);
        }
    }

    /// Cuts a link of a triangle inside a path, over an edge chosen at random. Returns the end beyond; `None` if there is no link, the cut
    /// is too expensive, or the ends are too far.
    fn open(&mut self, paths: &mut PricedPaths, t: u32, highest: i64) -> Option<u32> {
        let link = 4 * t + self.random.below(3) as u32;
        if paths.mask(t) >> (link % 4) & 1 == 0 || paths.cost() + i64::from(paths.cut_rise(link)) > highest {
            return None;
        }
        paths.try_cut(link)?;
        self.applied.push(AppliedMove::Cut(link));
        Some(paths.across(link) / 4)
    }

    fn undo(&mut self, paths: &mut PricedPaths) {
        for applied in self.applied.drain(..).rev() {
            match applied {
                AppliedMove::Joined(join) => join.undo(paths),
                AppliedMove::Cut(link) => _ = paths.join(link),
            }
        }
    }
}
