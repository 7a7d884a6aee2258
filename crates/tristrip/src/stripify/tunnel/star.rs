//! The star of a terminal: where alternating paths lead, and how far it is from there to a terminal of another strip.
//!
//! ```text
//!          11 ╲                  The tip of a tunnel has a distance: that of the shortest alternating path on from it, were there
//!   w ┄┄ v ━━ 9 ┄┄ ▪ ━━ 7 ┄ …    no loops. From `w` the way over v leads to tips at distances 9 and 11.
//! ```
//!
//! # Complexity
//! O(star) time; 12 bytes a triangle.

use super::Tally;
use super::baseline::is_red;
use super::ids::Ids;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;

/// Edges that the star goes on beyond the nearest terminal. Tuned on fandisk, cessna and bunny: 0 leaves half as many strips again,
/// 20 takes a third more time and gains nothing.
const BEYOND: u32 = 6;

/// What a search looks at.
pub(super) struct Place<'a> {
    pub(super) graph: &'a DualGraph,
    pub(super) cover: &'a PathCover,
    pub(super) ids: &'a Ids,
}

impl Place<'_> {
    pub(super) fn is_terminal(&self, t: u32) -> bool {
        self.cover.degree(FaceId(t)) < 2
    }

    pub(super) fn across(&self, half_edge: u32) -> u32 {
        self.graph.twins()[half_edge as usize] / 3
    }

    /// Walks over the red edges of a triangle and where they lead.
    pub(super) fn reds(&self, t: u32) -> impl Iterator<Item = (u32, u32)> {
        let reds = (3 * t..3 * t + 3).filter(|&h| is_red(self.graph, self.cover, h));
        reds.map(|h| (h, self.across(h)))
    }

    /// Walks over the black edges of a triangle and where they lead.
    pub(super) fn blacks(&self, t: u32) -> impl Iterator<Item = (u32, u32)> {
        let blacks = self.cover.edges(FaceId(t)).into_iter().flatten();
        blacks.map(|h| (h.0, self.across(h.0)))
    }
}

/// The k-star of a terminal. What belongs to an earlier one is told by its stamp.
#[derive(Debug, Default)]
pub(super) struct Star {
    stamp: u32,
    /// The star that each triangle was last come to in, over a black edge or as the terminal.
    reached: Vec<u32>,
    /// The star that a triangle's distance to a terminal belongs to, and the distance in edges.
    distance: Vec<(u32, u32)>,
    queue: Vec<u32>,
    terminals: Vec<u32>,
}

impl Star {
    /// Finds the star of a terminal. Returns whether another strip has a terminal in it.
    pub(super) fn find(
        &mut self,
        place: &Place<'_>,
        terminal: u32,
        limit: u32,
        tally: &mut Tally<'_>,
    ) -> bool {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            // The stamps come round again: forget the old ones.
            self.reached.fill(0);
            self.distance.fill((0, 0));
            self.stamp = 1;
        }
        if self.reached.len() < place.cover.len() {
            self.reached.resize(place.cover.len(), 0);
            self.distance.resize(place.cover.len(), (0, 0));
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
    pub(super) fn distance(&self, t: u32) -> Option<u32> {
        let (stamp, distance) = self.distance[t as usize];
        (stamp == self.stamp).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::HalfEdge;
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
            let mut star = Star::default();
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
    }
}
