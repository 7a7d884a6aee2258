//! The minimum number of path ends in a small subproblem of a graph, computed exactly over all its
//! path covers. Paths may leave the subproblem over any edge.
//!
//! # Algorithm
//! Triangles are added one by one. The order keeps the *frontier* short: the added triangles that
//! still have neighbours to be added. The remaining problem depends on the paths so far only
//! through the state of the frontier. For each triangle of the frontier, the state stores the other
//! end of the path that ends there, and whether the triangle can take another link. The minimum
//! number of ends is stored per state.
//!
//! ```text
//!   ● ━ ●│○           frontier: a, c, e; a and e are the two ends of one path and
//!   ┃   a│            must not be linked to each other; c can take no more links
//!   ● ━ ●│○
//!   ●━┛ c│
//!   ┗━━━●│○
//!       e│
//! ```
//!
//! # References
//! Held, Karp: *A dynamic programming approach to sequencing problems*, 1962; Sekine, Imai, Tani:
//! *Computing the Tutte polynomial of a graph of moderate size*, 1995 (frontiers); Knuth: *The Art
//! of Computer Programming* 4A, 2011, section 7.1.4, exercise 225 (simple paths).
//!
//! # Complexity
//! O(n · states) time and 32 bytes per state. The number of states is limited; it grows
//! approximately as 4 to the power of the frontier length.

use super::neighbours::Neighbours;

/// A triangle of a subproblem.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrontierNode {
    /// The neighbours of the triangle within the subproblem.
    pub(super) neighbours: Neighbours,
    /// Number of edges that leave the subproblem.
    pub(super) outward: u8,
    /// Whether a path from outside ends here, which leaves only one more link.
    pub(super) is_taken: bool,
}

/// Bits per slot of a state.
const BITS: u32 = 5;
/// Slots per state.
const SLOTS: usize = WIDEST + 1;
/// The longest frontier that is tried; one more slot is used temporarily. Few longer frontiers have
/// less than a million states.
const WIDEST: usize = 16;
/// Marks a triangle that can take no more links. Lower values are the slot of the other end of its
/// path.
const FULL: u8 = 31;
/// Marks a triangle whose path has its other end behind the frontier.
const LOOSE: u8 = 30;

/// The other ends of the paths of the frontier's triangles, packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct FrontierState(u128);

impl FrontierState {
    fn get(self, slot: u8) -> u8 {
        (self.0 >> (BITS * u32::from(slot))) as u8 & FULL
    }

    fn set(&mut self, slot: u8, end: u8) {
        let shift = BITS * u32::from(slot);
        self.0 = self.0 & !(u128::from(FULL) << shift) | u128::from(end) << shift;
    }

    /// Links two triangles. Returns `None` if one of them is full or both are ends of the same
    /// path.
    fn link(mut self, a: u8, b: u8) -> Option<Self> {
        let (end_a, end_b) = (self.get(a), self.get(b));
        if end_a == FULL || end_b == FULL || end_a == b {
            return None;
        }
        if end_a != a {
            self.set(a, FULL);
        }
        if end_b != b {
            self.set(b, FULL);
        }
        if end_a != LOOSE {
            self.set(end_a, end_b);
        }
        if end_b != LOOSE {
            self.set(end_b, end_a);
        }
        Some(self)
    }

    /// Removes a triangle from the frontier. Returns the number of path ends that remain at it.
    fn finish(&mut self, slot: u8, outward: u8) -> u8 {
        let end = self.get(slot);
        self.set(slot, 0);
        if end == FULL {
            return 0;
        }
        if end == slot {
            return 2_u8.saturating_sub(outward);
        }
        if end != LOOSE {
            self.set(end, LOOSE);
        }
        1_u8.saturating_sub(outward)
    }
}

/// Returns the minimum number of path ends in a subproblem, without ends at links from outside and
/// ends beyond edges that leave it. Returns `None` if this takes more than `states_at_once` states
/// at once, or more in total than `states_left`.
pub(super) fn least_ends(
    nodes: &[FrontierNode],
    states_at_once: usize,
    states_left: &mut u64,
) -> Option<usize> {
    let order = order(nodes)?;
    let mut rank = vec![0; nodes.len()];
    order.iter().enumerate().for_each(|(i, &node)| rank[node as usize] = i);
    let around = |node: u32| nodes[node as usize].neighbours.iter();
    let last_needed =
        |node: u32| around(node).map(|other| rank[other as usize]).fold(rank[node as usize], usize::max);
    let mut slot_of = vec![0_u8; nodes.len()];
    let mut free: Vec<u8> = (0..SLOTS as u8).rev().collect();
    let mut frontier: Vec<u32> = Vec::new();
    let mut states = vec![(FrontierState(0), 0_u16)];
    let mut grown: Vec<(FrontierState, u16)> = Vec::new();
    for (now, &node) in order.iter().enumerate() {
        let slot = free.pop()?;
        slot_of[node as usize] = slot;
        frontier.push(node);
        let (done, kept): (Vec<u32>, Vec<u32>) = frontier.iter().partition(|&&n| last_needed(n) == now);
        frontier = kept;
        let before: Vec<u8> = around(node)
            .filter(|&other| rank[other as usize] < now)
            .map(|other| slot_of[other as usize])
            .collect();
        grown.clear();
        for &(state, ends) in &states {
            let mut state = state;
            state.set(slot, if nodes[node as usize].is_taken { LOOSE } else { slot });
            let first = grown.len();
            grown.push((state, ends));
            for &other in &before {
                for i in first..grown.len() {
                    if let Some(linked) = grown[i].0.link(slot, other) {
                        grown.push((linked, ends));
                    }
                }
            }
            for (state, ends) in &mut grown[first..] {
                for &node in &done {
                    *ends += u16::from(state.finish(slot_of[node as usize], nodes[node as usize].outward));
                }
            }
        }
        free.extend(done.iter().map(|&node| slot_of[node as usize]));
        grown.sort_unstable();
        grown.dedup_by_key(|(state, _)| *state);
        std::mem::swap(&mut states, &mut grown);
        *states_left = states_left.saturating_sub(states.len() as u64);
        if states.len() > states_at_once || *states_left == 0 {
            return None;
        }
    }
    states.first().map(|&(_, ends)| usize::from(ends))
}

/// Orders the nodes to keep the frontier short: starts at a peripheral node and always adds the
/// node with the smallest growth. Returns `None` if the frontier exceeds [`WIDEST`].
fn order(nodes: &[FrontierNode]) -> Option<Vec<u32>> {
    let around = |node: u32| nodes[node as usize].neighbours.iter();
    let mut order: Vec<u32> = Vec::with_capacity(nodes.len());
    let mut width = 0;
    let mut seen = vec![false; nodes.len()];
    for first in 0..nodes.len() as u32 {
        if seen[first as usize] {
            continue;
        }
        // The last node of a breadth-first search is peripheral.
        let begin = order.len();
        seen[first as usize] = true;
        order.push(first);
        let mut head = begin;
        while let Some(&node) = order.get(head) {
            head += 1;
            for other in around(node) {
                if !std::mem::replace(&mut seen[other as usize], true) {
                    order.push(other);
                }
            }
        }
        let start = order.last().copied().unwrap_or(first);
        order[begin..].iter().for_each(|&node| seen[node as usize] = false);
        order.truncate(begin);
        let mut candidates = vec![start];
        while !candidates.is_empty() {
            let open = |node: u32| around(node).filter(|&other| !seen[other as usize]).count();
            // The growth of the frontier by a node, plus 3.
            let growth = |node: u32| {
                let closes = around(node).filter(|&other| seen[other as usize] && open(other) == 1).count();
                usize::from(open(node) > 0) + 3 - closes
            };
            let best = (0..candidates.len()).min_by_key(|&i| growth(candidates[i])).unwrap_or(0);
            width = width + growth(candidates[best]) - 3;
            if width > WIDEST {
                return None;
            }
            let node = candidates.remove(best);
            seen[node as usize] = true;
            order.push(node);
            for other in around(node) {
                if !seen[other as usize] && !candidates.contains(&other) {
                    candidates.push(other);
                }
            }
        }
    }
    Some(order)
}
