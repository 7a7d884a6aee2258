//! The enhanced tunnelling algorithm: tunnels of hundreds of edges, found in a part of the graph that is made for each search.
//!
//! # Algorithm
//! The numbers are those of the paper's section 4.1.
//!
//! 1. *The length k.* It grows, 3, 7, 15 …, up to the limit; a length is gone over again while it joins many strips.
//! 2. *A terminal*, in an order drawn by lot.
//! 3. *Its k-star*: the triangles that alternating paths of k edges from it come to, and of these the distances, along
//!    alternating paths, to the terminals of other strips. No terminal, no search.
//! 4. *Temporary edges* for the strips that leave the star and come back: none are made, see below.
//! 5. *Tunnelling*, depth first, any length up to k: at each step the way of the least distance first, of equals one by lot. The
//!    forecast of section 4.2 ends a search after so many accesses to nodes.
//! 6. *Complement*, if a tunnel was found, and only then write identifiers.
//! 7. *The next terminal.*
//!
//! When the greatest length finds nothing, strips are *moved*: of a search that fails, the part that came nearest to another
//! terminal is complemented, which makes a triangle there the terminal in place of the first, with as many strips as before.
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
//!   single way at each step, and nothing to search: without it horse stays at 2 to 7 strips, with it it comes to 1.
//! - The order of the ways, which the paper leaves open; terminals that move.
//!
//! # References
//! Porcu, Scateni: *Partitioning Meshes into Strips using the Enhanced Tunnelling Algorithm (ETA)*, 2006; Pósa: *Hamiltonian
//! circuits in random graphs*, 1976 (moving an end).
//!
//! # Complexity
//! A search takes O(star + threshold · length) time. 28 bytes a triangle, beside the cover and the dual graph.

use super::baseline::is_red;
use super::ids::{Ids, NONE, Pieces, Step};
use super::{EtaOptions, Searched, Tally};
use crate::cover::PathCover;
use crate::dual::{DualGraph, FaceId};
use crate::stripify::random::Random;

/// A length is gone over again if it has joined at least one in so many strips.
const MANY: usize = 20;
/// Edges that the star goes on beyond the nearest terminal. Tuned on fandisk, cessna and bunny: 0 leaves half as many strips again,
/// 20 takes a third more time and gains nothing.
const BEYOND: u32 = 6;
/// Passes that move terminals and join nothing, after which the search ends.
const PATIENCE: u32 = 20;
/// Loops that may be closed at a time while terminals move, and before. Tuned on bunny and horse: two lose the way.
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
        star: Star::new(cover.len()),
        search: Search::default(),
        random: Random::new(seed),
        graph,
        cover,
    };
    let mut limit = options.length.min(3);
    let (mut moving, mut fruitless) = (false, 0);
    while eta.cover.path_count() > least && fruitless < PATIENCE {
        let before = eta.cover.path_count();
        if !eta.pass(limit, options.threshold, moving, tally) {
            return;
        }
        let found = before - eta.cover.path_count();
        if moving {
            fruitless = if found == 0 { fruitless + 1 } else { 0 };
        } else if MANY * found < before {
            moving = limit == options.length;
            limit = (2 * limit + 1).min(options.length);
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
    /// Searches from every terminal once, from those that find something again. Returns whether to go on.
    fn pass(&mut self, limit: u32, threshold: u32, moving: bool, tally: &mut Tally<'_>) -> bool {
        let all = 0..self.cover.len() as u32;
        let mut terminals: Vec<u32> = all.filter(|&t| self.cover.degree(FaceId(t)) < 2).collect();
        for i in (1..terminals.len()).rev() {
            terminals.swap(i, self.random.below(i + 1));
        }
        for t in terminals {
            while self.cover.degree(FaceId(t)) < 2 {
                let place = Place { graph: self.graph, cover: self.cover, ids: &self.ids };
                if !self.star.find(&place, t, limit, tally) {
                    break;
                }
                let (star, random) = (&self.star, &mut self.random);
                let loops = if moving { LOOPS } else { 0 };
                match self.search.tunnel(&place, star, t, Limits { limit, threshold, loops }, random, tally) {
                    Searched::Stopped => return false,
                    Searched::Found => self.ids.complement(self.graph, self.cover, &self.search.steps),
                    Searched::Nothing => {
                        if moving {
                            self.ids.complement(self.graph, self.cover, &self.search.nearest);
                        }
                        break;
                    }
                }
            }
            if !tally.go_on(self.cover) {
                return false;
            }
        }
        true
    }
}

/// What a search looks at.
struct Place<'a> {
    graph: &'a DualGraph,
    cover: &'a PathCover,
    ids: &'a Ids,
}

impl Place<'_> {
    fn is_terminal(&self, t: u32) -> bool {
        self.cover.degree(FaceId(t)) < 2
    }

    fn across(&self, half_edge: u32) -> u32 {
        self.graph.twins()[half_edge as usize] / 3
    }

    /// Walks over the red edges of a triangle and where they lead.
    fn reds(&self, t: u32) -> impl Iterator<Item = (u32, u32)> {
        (3 * t..3 * t + 3).filter(|&h| is_red(self.graph, self.cover, h)).map(|h| (h, self.across(h)))
    }

    /// Walks over the black edges of a triangle and where they lead.
    fn blacks(&self, t: u32) -> impl Iterator<Item = (u32, u32)> {
        self.cover.edges(FaceId(t)).into_iter().flatten().map(|h| (h.0, self.across(h.0)))
    }
}

/// The k-star of a terminal. What belongs to an earlier one is told by its stamp.
#[derive(Debug)]
struct Star {
    stamp: u32,
    /// The star that each triangle was last come to in, over a black edge or as the terminal.
    reached: Vec<u32>,
    /// The star that a triangle's distance to a terminal belongs to, and the distance in edges.
    distance: Vec<(u32, u32)>,
    queue: Vec<u32>,
    terminals: Vec<u32>,
}

impl Star {
    fn new(triangle_count: usize) -> Self {
        let (queue, terminals) = (Vec::new(), Vec::new());
        let (reached, distance) = (vec![0; triangle_count], vec![(0, 0); triangle_count]);
        Self { stamp: 0, reached, distance, queue, terminals }
    }

    /// Finds the star of a terminal. Returns whether another strip has a terminal in it.
    fn find(&mut self, place: &Place<'_>, terminal: u32, limit: u32, tally: &mut Tally<'_>) -> bool {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            // The stamps come round again: forget the old ones.
            self.reached.fill(0);
            self.distance.fill((0, 0));
            self.stamp = 1;
        }
        self.go_out(place, terminal, limit);
        tally.accesses += self.queue.len() as u64;
        self.come_back(place);
        tally.accesses += self.queue.len() as u64;
        !self.terminals.is_empty()
    }

    /// Follows alternating paths outward, ring by ring, and notes the terminals of other strips that they come to.
    fn go_out(&mut self, place: &Place<'_>, terminal: u32, mut limit: u32) {
        self.queue.clear();
        self.terminals.clear();
        self.reach(terminal);
        let own = place.ids.path(terminal);
        let (mut ring, mut length) = (0..1, 1);
        while !ring.is_empty() && length <= limit {
            for i in ring.clone() {
                let tip = self.queue[i];
                for (_, v) in place.reds(tip) {
                    if place.is_terminal(v) && place.ids.path(v) != own {
                        self.terminals.push(v);
                        limit = limit.min(length + BEYOND);
                    }
                    place.blacks(v).for_each(|(_, b)| self.reach(b));
                }
            }
            ring = ring.end..self.queue.len();
            length += 2;
        }
    }

    fn reach(&mut self, t: u32) {
        if std::mem::replace(&mut self.reached[t as usize], self.stamp) != self.stamp {
            self.queue.push(t);
        }
    }

    /// Measures the distances from the terminals back.
    fn come_back(&mut self, place: &Place<'_>) {
        self.queue.clear();
        for i in 0..self.terminals.len() {
            place.reds(self.terminals[i]).for_each(|(_, a)| self.measure(a, 1));
        }
        let mut next = 0;
        while next < self.queue.len() {
            let tip = self.queue[next];
            let distance = self.distance[tip as usize].1 + 2;
            for (_, v) in place.blacks(tip) {
                place.reds(v).for_each(|(_, a)| self.measure(a, distance));
            }
            next += 1;
        }
    }

    fn measure(&mut self, t: u32, distance: u32) {
        if self.reached[t as usize] == self.stamp && self.distance[t as usize].0 != self.stamp {
            self.distance[t as usize] = (self.stamp, distance);
            self.queue.push(t);
        }
    }

    /// The length of the shortest alternating path on from a triangle that has just been cut off, were there no loops.
    fn distance(&self, t: u32) -> Option<u32> {
        let (stamp, distance) = self.distance[t as usize];
        (stamp == self.stamp).then_some(distance)
    }
}

/// How far a search goes.
#[derive(Debug, Clone, Copy)]
struct Limits {
    /// The longest tunnel.
    limit: u32,
    /// Accesses to nodes.
    threshold: u32,
    /// Loops that may be closed at a time.
    loops: u32,
}

/// A search from one terminal.
#[derive(Debug, Default)]
struct Search {
    pieces: Pieces,
    /// The tunnel so far; found, it ends with a red edge.
    steps: Vec<Step>,
    /// The part of a tunnel, without a loop, that came nearest to a terminal.
    nearest: Vec<Step>,
    /// The ways that are still to be tried, each with the steps before it.
    ways: Vec<(usize, Step)>,
    /// The ways on from a triangle: the distance, a lot, and the way.
    sorted: Vec<(u32, u64, Step)>,
}

impl Search {
    /// Looks for a tunnel from a terminal.
    fn tunnel(
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
                    self.sorted.push((distance, random.next(), Step { red, black }));
                }
            }
            if place.is_terminal(v) {
                self.sorted.push((0, random.next(), Step { red, black: NONE }));
            }
        }
        self.sorted.sort_unstable_by_key(|&(distance, lot, _)| std::cmp::Reverse((distance, lot)));
        self.ways.extend(self.sorted.iter().map(|&(_, _, step)| (depth, step)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::HalfEdge;
    use crate::stripify::tunnel::tests::graph_and_cover;
    use proptest::prelude::*;

    /// Distances by going over all triangles again and again, and the ends that paths of at most `limit` edges come to.
    fn naive_star(place: &Place<'_>, terminal: u32, limit: u32) -> (Vec<Option<u32>>, Vec<Option<u32>>) {
        let n = place.cover.len() as u32;
        let shorter = |old: Option<u32>, new: u32| old.is_none_or(|old| new < old);
        // Edges from the terminal to each triangle over a black edge at last, and from such a triangle to a terminal.
        let (mut out, mut back) = (vec![None; n as usize], vec![None; n as usize]);
        out[terminal as usize] = Some(0);
        for _ in 0..2 * n {
            for (a, (red, v)) in (0..n).flat_map(|a| place.reds(a).map(move |edge| (a, edge))) {
                assert!(!place.cover.is_linked(HalfEdge(red)));
                for (_, b) in place.blacks(v) {
                    if let Some(length) = out[a as usize]
                        && shorter(out[b as usize], length + 2)
                    {
                        out[b as usize] = Some(length + 2);
                    }
                    if let Some(length) = back[b as usize]
                        && shorter(back[a as usize], length + 2)
                    {
                        back[a as usize] = Some(length + 2);
                    }
                }
                let reached = out[a as usize].is_some_and(|length: u32| length < limit);
                if reached && place.is_terminal(v) && place.ids.path(v) != place.ids.path(terminal) {
                    // Any red edge leads to it from there on.
                    place.reds(v).for_each(|(_, a)| back[a as usize] = Some(1));
                }
            }
        }
        (out, back)
    }

    proptest! {
        #[test]
        fn the_star_knows_the_distances((graph, cover) in graph_and_cover(), terminal in any::<u32>(), limit in 1..40_u32) {
            prop_assume!(!cover.is_empty());
            let terminal = terminal % cover.len() as u32;
            let ids = Ids::new(&graph, &cover);
            let place = Place { graph: &graph, cover: &cover, ids: &ids };
            prop_assume!(place.is_terminal(terminal));
            let mut star = Star::new(cover.len());
            // The star ends a few edges beyond the nearest terminal.
            let (_, back) = naive_star(&place, terminal, limit);
            let nearest = back[terminal as usize].filter(|&nearest| nearest <= limit);
            let found = star.find(&place, terminal, limit, &mut Tally::new(&()));
            prop_assert_eq!(found, nearest.is_some());
            prop_assert_eq!(star.distance(terminal), nearest);
            let limit = limit.min(nearest.unwrap_or(limit).saturating_add(BEYOND));
            let (out, back) = naive_star(&place, terminal, limit);
            for t in 0..cover.len() {
                let inside = out[t].is_some_and(|length| length <= limit + 1);
                prop_assert_eq!(star.reached[t] == star.stamp, inside, "{}", t);
                if let Some(distance) = star.distance(t as u32) {
                    prop_assert!(inside && back[t].is_some_and(|back| back <= distance));
                    let whole = out[t].is_some_and(|length| length + distance <= limit);
                    prop_assert!(!whole || back[t] == Some(distance), "{} {:?} {}", t, back[t], distance);
                }
            }
        }

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
