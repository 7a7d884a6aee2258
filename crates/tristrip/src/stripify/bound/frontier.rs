//! The least number of path ends in a small piece of a graph, exactly: over all ways to lay paths through it, edges that leave the piece
//! being free to use.
//!
//! # Algorithm
//! Triangles are added one by one, in an order that keeps the *frontier* short: those added that still have a neighbour to come. All
//! that the rest needs to know of the paths laid so far is, for each triangle of the frontier, whether it can take another link
//! and where the path that ends there ends on its other side. For each such state the least number of ends so far is kept.
//!
//! ```text
//!   ● ━ ●│○           frontier: a, c, e; a and e are the two ends of one path and must not be linked to each other,
//!   ┃   a│            c can take no more.
//!   ● ━ ●│○
//!   ●━┛ c│
//!   ┗━━━●│○
//!       e│
//! ```
//!
//! # References
//! Held, Karp: *A dynamic programming approach to sequencing problems*, 1962; Sekine, Imai, Tani: *Computing the Tutte
//! polynomial of a graph of moderate size*, 1995 (frontiers); Knuth: *The Art of Computer Programming* 4A, 2011, section 7.1.4, exercise 225
//! (simple paths).
//!
//! # Complexity
//! O(n · states) time and 32 bytes a state; the states are limited, and grow about as 4 to the power of the frontier.

use super::NONE;

/// A triangle of a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    /// Its neighbours in the piece, `NONE` behind the last.
    pub(super) neighbours: [u32; 3],
    /// Edges that leave the piece.
    pub(super) outward: u8,
    /// Whether a path ends here from elsewhere, so that only one more link can be taken.
    pub(super) is_taken: bool,
}

/// Bits of a slot in a state.
const BITS: u32 = 5;
/// Slots of a state.
const SLOTS: usize = WIDEST + 1;
/// The longest frontier that is tried: one more slot is in use for a moment. Of longer ones few have less than a million states.
const WIDEST: usize = 16;
/// A triangle that can take no more link. Lower values name the slot of the path's other end.
const FULL: u8 = 31;
/// A triangle whose path ends elsewhere for good.
const LOOSE: u8 = 30;

/// Where the path of each triangle of the frontier ends, packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct State(u128);

impl State {
    fn get(self, slot: u8) -> u8 {
        (self.0 >> (BITS * u32::from(slot))) as u8 & FULL
    }

    fn set(&mut self, slot: u8, end: u8) {
        let shift = BITS * u32::from(slot);
        self.0 = self.0 & !(u128::from(FULL) << shift) | u128::from(end) << shift;
    }

    /// Links two triangles, unless one of them is full or they are the ends of one path.
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

    /// Takes a triangle out of the frontier and counts the ends that it keeps.
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

/// Counts the least ends of paths in a piece, not those at edges that are taken already nor those beyond edges that leave it; `None`
/// where that takes more than so many states at once, or more in all than are left.
pub(super) fn least_ends(nodes: &[Node], states_at_once: usize, states_left: &mut u64) -> Option<usize> {
    let order = order(nodes)?;
    let mut place = vec![0; nodes.len()];
    order.iter().enumerate().for_each(|(i, &node)| place[node as usize] = i);
    let around = |node: u32| nodes[node as usize].neighbours.into_iter().take_while(|&other| other != NONE);
    let last_needed =
        |node: u32| around(node).map(|other| place[other as usize]).fold(place[node as usize], usize::max);
    let mut slot_of = vec![0_u8; nodes.len()];
    let mut free: Vec<u8> = (0..SLOTS as u8).rev().collect();
    let mut frontier: Vec<u32> = Vec::new();
    let mut states = vec![(State(0), 0_u16)];
    let mut grown: Vec<(State, u16)> = Vec::new();
    for (now, &node) in order.iter().enumerate() {
        let slot = free.pop()?;
        slot_of[node as usize] = slot;
        frontier.push(node);
        let (done, kept): (Vec<u32>, Vec<u32>) = frontier.iter().partition(|&&n| last_needed(n) == now);
        frontier = kept;
        let before: Vec<u8> = around(node)
            .filter(|&other| place[other as usize] < now)
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

/// Orders the nodes so that few are waiting for a neighbour at any time: from a node far out, always the one that adds least.
/// `None` where that are more than [`WIDEST`].
fn order(nodes: &[Node]) -> Option<Vec<u32>> {
    let around = |node: u32| nodes[node as usize].neighbours.into_iter().take_while(|&other| other != NONE);
    let mut order: Vec<u32> = Vec::with_capacity(nodes.len());
    let mut width = 0;
    let mut seen = vec![false; nodes.len()];
    for first in 0..nodes.len() as u32 {
        if seen[first as usize] {
            continue;
        }
        // The last node of a breadth-first search lies far out.
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
        let mut waiting = vec![start];
        while !waiting.is_empty() {
            let open = |node: u32| around(node).filter(|&other| !seen[other as usize]).count();
            // What a node adds to the frontier, and 3.
            let growth = |node: u32| {
                let closes = around(node).filter(|&other| seen[other as usize] && open(other) == 1).count();
                usize::from(open(node) > 0) + 3 - closes
            };
            let best = (0..waiting.len()).min_by_key(|&i| growth(waiting[i])).unwrap_or(0);
            width = width + growth(waiting[best]) - 3;
            if width > WIDEST {
                return None;
            }
            let node = waiting.remove(best);
            seen[node as usize] = true;
            order.push(node);
            for other in around(node) {
                if !seen[other as usize] && !waiting.contains(&other) {
                    waiting.push(other);
                }
            }
        }
    }
    Some(order)
}
