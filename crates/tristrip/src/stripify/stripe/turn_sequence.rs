//! Turn sequences: how a strip turns, and which order of turns inside polygons costs the fewest
//! swaps.
//!
//! A strip runs between two chains of vertices, A and B. Each triangle advances on one of these
//! chains. This choice is its *turn*. Two consecutive equal turns need a swap. A polygon determines
//! only the number of turns of each kind between its entry and its exit, not their order.
//!
//! ```text
//!         b'─────b''         entry b → a; chain A: a, a'; chain B: b, b', b''
//!        ╱      ╱            one A and two B between the entry and the exit a' → b'':
//!       b ──▶ a ── a'           the order B A B needs no swap
//! ```
//!
//! # Algorithm
//! The minimum number of swaps up to an edge, for either last turn, follows from the values at the
//! previous edge (Viterbi 1967). The cost of every exit is therefore known at each face, and the
//! orders of turns in all polygons are chosen together at the end of the strip.
//!
//! # Complexity
//! O(1) per face.

/// The turn of a triangle that advances on chain A, the chain on the side of the entry's head.
pub(super) const A: usize = 0;
/// The turn of a triangle that advances on chain B.
pub(super) const B: usize = 1;

/// The numbers of triangles that advance on chain A and on chain B.
pub(super) type TurnCounts = [u32; 2];

/// When the order of the turns inside polygons is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum TurnDiagonals {
    /// At each polygon when the strip passes it, with the fewest swaps so far.
    Passing,
    /// For all polygons of a strip together, with the fewest swaps in the whole strip.
    Together,
}

/// The swaps of an impossible order. Small enough to be added to without overflow.
const IMPOSSIBLE: u32 = u32::MAX / 4;

/// The minimum number of swaps so far, by last turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LeastSwaps(pub(super) [u32; 2]);

impl LeastSwaps {
    /// The swaps at the exit of a strip's first face, where any order is possible.
    pub(super) const FREE: Self = Self([0, 0]);

    /// Returns the swaps at the exit of a face, given its counts and the swaps at its entry.
    pub(super) fn through(self, counts: TurnCounts) -> Self {
        Self([A, B].map(|last| {
            [A, B]
                .map(|before| self.0[before] + least_swaps(counts, before, last))
                .into_iter()
                .fold(IMPOSSIBLE, u32::min)
        }))
    }

    /// Returns the swaps at the exit of a face like [`Self::through`], restricted to the orders
    /// that `diagonals` leaves open.
    pub(super) fn passing(self, counts: TurnCounts, diagonals: TurnDiagonals) -> Self {
        let mut swaps = self.through(counts);
        if diagonals == TurnDiagonals::Passing {
            swaps.0[1 - swaps.best_turn()] = IMPOSSIBLE;
        }
        swaps
    }

    /// Returns the smaller of the two numbers.
    pub(super) fn least(self) -> u32 {
        self.0[A].min(self.0[B])
    }

    /// Returns the last turn with the smaller number.
    pub(super) fn best_turn(self) -> usize {
        usize::from(self.0[B] < self.0[A])
    }
}

/// Counts the runs of each turn in the order with the most runs, given the first and last turn.
fn run_counts(counts: TurnCounts, first: usize, last: usize) -> Option<TurnCounts> {
    let other = 1 - first;
    let mut runs = [0; 2];
    if first == last {
        runs[other] = counts[other].min(counts[first].checked_sub(1)?);
        runs[first] = runs[other] + 1;
    } else {
        runs = [counts[A].min(counts[B]); 2];
    }
    // Every turn that occurs makes at least one run.
    let is_possible = [A, B].iter().all(|&x| (counts[x] == 0) == (runs[x] == 0));
    (is_possible && runs[last] > 0).then_some(runs)
}

/// Returns the first turn and the swaps of the best order that follows the turn `before` and ends
/// in `last`.
fn best_order(counts: TurnCounts, before: usize, last: usize) -> Option<(usize, u32)> {
    // The turn that needs no swap is tried first.
    [1 - before, before]
        .into_iter()
        .filter_map(|first| {
            let runs = run_counts(counts, first, last)?;
            Some((first, counts[A] + counts[B] - runs[A] - runs[B] + u32::from(first == before)))
        })
        .min_by_key(|&(_, swaps)| swaps)
}

/// Counts the swaps of the best order of turns that follows the turn `before` and ends in `last`.
pub(super) fn least_swaps(counts: TurnCounts, before: usize, last: usize) -> u32 {
    best_order(counts, before, last).map_or(IMPOSSIBLE, |(_, swaps)| swaps)
}

/// Appends the best order of turns that follows the turn `before` and ends in `last`.
pub(super) fn append_turns(counts: TurnCounts, before: usize, last: usize, out: &mut Vec<usize>) {
    let Some((first, _)) = best_order(counts, before, last) else { return };
    let Some(runs) = run_counts(counts, first, last) else { return };
    // Turns that do not alternate are added to the first run of their kind.
    let mut surplus = [counts[A] - runs[A], counts[B] - runs[B]];
    let mut turn = first;
    for _ in 0..runs[A] + runs[B] {
        out.extend(std::iter::repeat_n(turn, 1 + std::mem::take(&mut surplus[turn]) as usize));
        turn = 1 - turn;
    }
}

/// Counts the turns of an alternating order of `length` turns that starts with `first`.
pub(super) fn alternating_counts(length: u32, first: usize) -> TurnCounts {
    let mut counts = [length / 2; 2];
    counts[first] += length % 2;
    counts
}

/// Returns the last of `length` turns that alternate after the turn `before`, or `before` for
/// length 0.
pub(super) fn alternate(before: usize, length: u32) -> usize {
    if length.is_multiple_of(2) { before } else { 1 - before }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn count_swaps(turns: &[usize]) -> u32 {
        turns.windows(2).filter(|w| w[0] == w[1]).count() as u32
    }

    /// Tries every order of the turns.
    fn naive_least_swaps(counts: TurnCounts, before: usize, last: usize) -> u32 {
        let length = counts[A] + counts[B];
        let orders = (0..1_u32 << length).filter(|bits| bits.count_ones() == counts[B]).map(|bits| {
            std::iter::once(before).chain((0..length).map(|i| (bits >> i & 1) as usize)).collect::<Vec<_>>()
        });
        let possible = orders.filter(|order| order.len() > 1 && order.last() == Some(&last));
        possible.map(|order| count_swaps(&order)).min().unwrap_or(IMPOSSIBLE)
    }

    #[test]
    fn appends_the_order_with_the_fewest_swaps() {
        for case in 0..6 * 6 * 4 {
            let (counts, before, last) =
                ([case / 4 % 6, case / 24], case as usize % 2, case as usize / 2 % 2);
            let expected = naive_least_swaps(counts, before, last);
            assert_eq!(least_swaps(counts, before, last), expected, "{counts:?} {before} {last}");
            let mut turns = vec![before];
            append_turns(counts, before, last, &mut turns);
            if expected == IMPOSSIBLE {
                assert_eq!(turns, [before]);
            } else {
                assert_eq!((count_swaps(&turns), turns.last()), (expected, Some(&last)));
                assert_eq!([A, B].map(|x| turns[1..].iter().filter(|&&t| t == x).count() as u32), counts);
            }
        }
    }
}
