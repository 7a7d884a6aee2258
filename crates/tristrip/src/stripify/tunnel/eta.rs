//! The enhanced tunnelling algorithm: tunnels of hundreds of edges, found in a part of the graph that is made for each search.
//!
//! # Algorithm
//! The numbers are those of the paper's section 4.1.
//!
//! 1. *The length k.* It grows, 3, 7, 15 …; a length is gone over again while it joins many strips.
//! 2. *A terminal*, in an order drawn by lot.
//! 3. *Its k-star*: the triangles that alternating paths of k edges from it come to, and of these the distances, along
//!    alternating paths, to the terminals of other strips. No terminal, no search.
//! 4. *Temporary edges* for the strips that leave the star and come back: none are made, see below.
//! 5. *Tunnelling*, depth first, any length up to k: at each step the way of the least distance first, of equals one by lot. The
//!    forecast of section 4.2 ends a search after so many accesses to nodes.
//! 6. *Complement*, if a tunnel was found, and only then write identifiers.
//! 7. *The next terminal.*
//!
//! When lengths of some dozens find few, the greatest is taken, and terminals *move*: of a search that fails, the part that came
//! nearest to another terminal is complemented, which makes a triangle there the terminal in place of the first, with as many
//! strips as before. It ends when that has led to nothing for a while, or when no star holds a terminal of another strip.
//!
//! ```text
//!   w ┄┄ v ━━ b ┄ … ┄ x        w ━━ v    b ┄ … ┄ x        b is the new terminal, and nearer to x
//! ```
//! # Departures
//! - The star is that of alternating paths, which no tunnel leaves: the one of the paper holds triangles that none comes to. It ends a
//!   few steps beyond the nearest terminal, which keeps it small while there are many.
//! - The paper bridges what lies outside the star by temporary edges, so that tags need not be written there. Here no search writes
//!   tags: a piece of a strip is an interval of positions, whether it lies in the star or not (see the module `ids`).
//! - A loop may be closed if the path opens it again later, one at a time. Within one long strip the rule against loops leaves a
//!   single way at each step, and nothing to search: by that rule horse stays at 2 to 7 strips, without it it comes to 1.
//! - The order of the ways, which the paper leaves open; terminals that move.
//!
//! # References
//! Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*, 2006; Pósa: *Hamiltonian
//! circuits in random graphs*, 1976 (moving an end).
//!
//! # Complexity
//! A search takes O(star + threshold · length) time. At most 36 bytes a
//! triangle, beside the cover and the dual graph.

use super::ids::{Ids, NONE, Pieces, Step};
use super::star::{Place, Star};
use super::{Searched, Tally};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;
use crate::random::Random;
use crate::stripify::EtaOptions;

/// A length is gone over again if it has joined at least one in so many strips.
const MANY: usize = 20;
/// The length after which terminals move, and all lengths are tried at once. Tuned on bunny and dragon: more comes to more strips.
const MOVE_FROM: u32 = 63;
/// Passes that move terminals and join nothing, after which the search ends. Tuned on horse: 20 leave it at 3 strips for one seed
/// in twelve.
const PATIENCE: u32 = 40;
/// Of these, every so many begins with all terminals, the others with those that had a terminal of another strip in their star.
const FULL: u32 = 5;
/// Loops that may be closed at a time while terminals move; before, none. Tuned on bunny and horse: two lose the way.
const LOOPS: u32 = 1;

/// Joins paths of a cover until no more are found or the watch says so.
pub(super) fn join(
    graph: &DualGraph,
    cover: &mut PathCover,
    options: EtaOptions,
    seed: u64,
    tally: &mut Tally<'_>,
) {
    let least = graph.components().1;
    let mut eta = Eta {
        ids: Ids::new(graph, cover),
        star: Star::default(),
        search: Search::default(),
        random: Random::new(seed),
        graph,
        cover,
    };
    let mut limit = options.length().min(3);
    let (mut is_moving, mut fruitless) = (false, 0);
    let mut terminals = Vec::new();
    while eta.cover.path_count() > least && fruitless < PATIENCE {
        let before = eta.cover.path_count();
        let is_full = fruitless % FULL == 0;
        if is_full {
            eta.find_terminals(&mut terminals);
        }
        let limits =
            Limits { limit, threshold: options.threshold(), loops: if is_moving { LOOPS } else { 0 } };
        if !eta.pass(&mut terminals, limits, is_moving, tally) {
            return;
        }
        let found = before - eta.cover.path_count();
        if is_moving {
            fruitless = if found == 0 { fruitless + 1 } else { 1 };
            if is_full && terminals.is_empty() {
                return;
            }
        } else if MANY * found < before {
            is_moving = limit >= options.length().min(MOVE_FROM);
            limit = if is_moving { options.length() } else { (2 * limit + 1).min(options.length()) };
        }
    }
}

/// The state of the method.
struct Eta<'a> {
    graph: &'a DualGraph,
    cover: &'a mut PathCover,
    ids: Ids,
    star: Star,
    search: Search,
    random: Random,
}

impl Eta<'_> {
    /// Finds the terminals.
    fn find_terminals(&self, terminals: &mut Vec<u32>) {
        terminals.clear();
        terminals.extend((0..self.cover.len() as u32).filter(|&t| self.cover.degree(FaceId(t)) < 2));
    }

    /// Searches from terminals, from those that find something again, and leaves those that might find something another time.
    /// Returns whether to go on.
    fn pass(
        &mut self,
        terminals: &mut Vec<u32>,
        limits: Limits,
        is_moving: bool,
        tally: &mut Tally<'_>,
    ) -> bool {
        for i in (1..terminals.len()).rev() {
            terminals.swap(i, self.random.below(i + 1));
        }
        let mut left = 0;
        for i in 0..terminals.len() {
            let mut t = terminals[i];
            while self.cover.degree(FaceId(t)) < 2 {
                let place = Place { graph: self.graph, cover: self.cover, ids: &self.ids };
                if !self.star.find(&place, t, limits.limit, tally) {
                    break;
                }
                match self.search.tunnel(&place, &self.star, t, limits, &mut self.random, tally) {
                    Searched::Stopped => return false,
                    Searched::Found => {
                        self.ids.complement(self.graph, self.cover, &self.search.steps);
                    }
                    Searched::Nothing => {
                        if is_moving {
                            self.ids.complement(self.graph, self.cover, &self.search.nearest);
                            if let Some(step) = self.search.nearest.last() {
                                t = self.graph.twins()[step.black as usize] / 3;
                            }
                        }
                        terminals[left] = t;
                        left += 1;
                        break;
                    }
                }
            }
            if !tally.go_on(self.cover) {
                return false;
            }
        }
        terminals.truncate(left);
        true
    }
}

/// How far a search goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// The longest tunnel.
    pub(super) limit: u32,
    /// Accesses to nodes.
    pub(super) threshold: u32,
    /// Loops that may be closed at a time.
    pub(super) loops: u32,
}

/// A search from one terminal.
#[derive(Debug, Default)]
pub(super) struct Search {
    pieces: Pieces,
    /// The tunnel so far; found, it ends with a red edge.
    pub(super) steps: Vec<Step>,
    /// The part of a tunnel, without a loop, that came nearest to a terminal.
    nearest: Vec<Step>,
    /// The ways that are still to be tried, each with the steps before it.
    ways: Vec<(usize, Step)>,
    /// The ways on from a triangle: the distance, a lot, and the way.
    sorted: Vec<(u32, u64, Step)>,
}

impl Search {
    /// Looks for a tunnel from a terminal.
    pub(super) fn tunnel(
        &mut self,
        place: &Place<'_>,
        star: &Star,
        terminal: u32,
        limits: Limits,
        random: &mut Random,
        tally: &mut Tally<'_>,
    ) -> Searched {
        self.pieces.begin(place.ids, terminal);
        self.steps.clear();
        self.nearest.clear();
        self.ways.clear();
        self.push_ways(place, star, terminal, limits.limit, random);
        let mut nearest = u32::MAX;
        for _ in 0..limits.threshold {
            let Some((depth, step)) = self.ways.pop() else { break };
            if !tally.count(place.cover) {
                return Searched::Stopped;
            }
            while self.steps.len() > depth {
                self.steps.pop();
                self.pieces.undo();
            }
            let v = place.across(step.red);
            if step.black == NONE {
                if self.pieces.may_end_at(place.ids, v) {
                    self.steps.push(step);
                    return Searched::Found;
                }
                continue;
            }
            let b = place.across(step.black);
            if !self.pieces.step(place.ids, v, b) {
                continue;
            }
            if self.pieces.loops() > limits.loops {
                self.pieces.undo();
                continue;
            }
            self.steps.push(step);
            if let Some(distance) = star.distance(b).filter(|&d| d < nearest && self.pieces.loops() == 0) {
                nearest = distance;
                self.nearest.clone_from(&self.steps);
            }
            self.push_ways(place, star, b, limits.limit, random);
        }
        Searched::Nothing
    }

    /// Notes the ways on from a triangle, the best last.
    fn push_ways(&mut self, place: &Place<'_>, star: &Star, from: u32, limit: u32, random: &mut Random) {
        let depth = self.steps.len();
        self.sorted.clear();
        for (red, v) in place.reds(from) {
            let twin = place.graph.twins()[red as usize];
            if self.steps.iter().any(|step| step.red == red || step.red == twin) {
                continue;
            }
            for (black, b) in place.blacks(v) {
                if let Some(distance) = star.distance(b)
                    && 2 * (depth as u64 + 1) + u64::from(distance) <= u64::from(limit)
                {
                    self.sorted.push((distance, random.next_u64(), Step { red, black }));
                }
            }
            if place.is_terminal(v) {
                self.sorted.push((0, random.next_u64(), Step { red, black: NONE }));
            }
        }
        self.sorted.sort_unstable_by_key(|&(distance, lot, _)| std::cmp::Reverse((distance, lot)));
        self.ways.extend(self.sorted.iter().map(|&(_, _, step)| (depth, step)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stripify::tunnel::tests::graph_and_cover;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn joins_any_cover((graph, cover) in graph_and_cover(), length in 0..60_u32, seed in any::<u64>()) {
            let join = |length| {
                let mut cover = cover.clone();
                let options = EtaOptions::default().with_length(length);
                join(&graph, &mut cover, options, seed, &mut Tally::new(&()));
                cover
            };
            let joined = join(length);
            prop_assert_eq!(joined.check(&graph), Ok(()));
            prop_assert!(joined.path_count() <= cover.path_count());
            prop_assert!(joined.path_count() >= graph.components().1);
            prop_assert_eq!(&joined, &join(length));
            // No pair of terminals is left side by side.
            let ids = Ids::new(&graph, &joined);
            let place = Place { graph: &graph, cover: &joined, ids: &ids };
            for t in (0..joined.len() as u32).filter(|&t| length > 0 && place.is_terminal(t)) {
                for (_, v) in place.reds(t) {
                    prop_assert!(!place.is_terminal(v) || ids.path(v) == ids.path(t));
                }
            }
        }
    }
}
