//! Local search on a cover by short chains of moves. The cost may rise within a chain but not over
//! the whole chain.
//!
//! ```text
//!   ━ a ━ b ━ c ━        cut a–b (one index more), rotate b to d, join a with e
//!     ┊   ┊              (one index fewer than before); a chain that raises the
//!     e   d ━ f ━        cost is undone in reverse order
//! ```
//! Annealing accepts cost increases at random and lowers the cost again as it cools. If only a
//! small part of a good cover has changed, for example near a collapse, chains lower the cost
//! further in the same time: a chain continues at its own cut, and failed attempts are undone.
//!
//! # Algorithm
//! 1. Start at the end of a path, or at the two ends created by a cut between two triangles.
//! 2. Change one of the ends by a random join or rotation, while the cost stays within the limit of
//!    [`LocalSearch::improve_at`] above the start.
//! 3. Stop when the cost is below the start, no end is left, or the maximum number of moves is
//!    reached. Undo all moves of the chain if the cost is higher.
//!
//! A chain whose cost is unchanged at its end is kept, so path ends move until they meet.
//!
//! # Complexity
//! A few moves per chain, each in O(length of the paths that it cuts).

use super::moves::{EndMove, Join, move_end};
use super::priced::PricedPaths;
use crate::random::Random;

/// Moves of a chain after its cut. Tuned on all levels of the bunny: 2 leaves more expensive
/// covers, and 8 takes longer without a gain.
const DEPTH: u32 = 4;

/// Improves covers by chains of moves, and records the moves to undo them.
#[derive(Debug, Clone)]
pub(crate) struct LocalSearch {
    random: Random,
    applied: Vec<AppliedMove>,
}

/// An elementary move and its half-edge.
#[derive(Debug, Clone, Copy)]
enum AppliedMove {
    Joined(Join),
    Cut(u32),
}

impl LocalSearch {
    pub(crate) fn new(seed: u64) -> Self {
        Self { random: Random::new(seed), applied: Vec::new() }
    }

    /// Tries one chain of moves from a triangle. Within the chain the cost may rise by less than
    /// the price of a strip; after it the cost is not higher than before.
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

    /// Cuts a link of a triangle inside a path at a random edge, and returns the new end on the
    /// other side. Returns `None` if there is no link, the cut is too expensive, or the ends of the
    /// path are too far away.
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
