//! The star of a terminal: the triangles that alternating paths reach, and their distances to
//! terminals of other strips.
//!
//! ```text
//!          11 ╲                  The numbers are the distances of tips: the length of the
//!   w ┄┄ v ━━ 9 ┄┄ ▪ ━━ 7 ┄ …    shortest alternating path from the tip, ignoring loops.
//! ```
//!
//! # Complexity
//! O(star) time; 12 bytes per triangle.

use crate::stripify::tunnel::accesses::AccessCounter;
use crate::stripify::tunnel::context::{DualArc, SearchContext};

/// Number of edges that the star extends beyond the nearest terminal. Tuned on fandisk, cessna and
/// bunny: 0 leaves 1.5 times as many strips, and 20 takes a third more time without a gain.
const MARGIN: u32 = 6;

/// The k-star of a terminal. Entries of earlier stars have older stamps.
#[derive(Debug, Default)]
pub(super) struct GuidedStar {
    stamp: u32,
    /// The stamp of the star in which each triangle was last reached, over a black edge or as the
    /// terminal.
    reached: Vec<u32>,
    /// The stamp of the star in which each triangle last had a distance to a terminal, and the
    /// distance in edges.
    distance: Vec<(u32, u32)>,
    queue: Vec<u32>,
    terminals: Vec<u32>,
}

impl GuidedStar {
    /// Builds the star of a terminal. Returns whether it contains a terminal of another strip.
    pub(super) fn build(
        &mut self,
        context: &SearchContext<'_>,
        terminal: u32,
        length: u32,
        counter: &mut AccessCounter<'_>,
    ) -> bool {
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            // After 2³² stars the stamps start from 1 again.
            self.reached.fill(0);
            self.distance.fill((0, 0));
            self.stamp = 1;
        }
        if self.reached.len() < context.cover.len() {
            self.reached.resize(context.cover.len(), 0);
            self.distance.resize(context.cover.len(), (0, 0));
        }
        self.expand(context, terminal, length);
        counter.add(self.queue.len() as u64);
        self.measure_distances(context);
        counter.add(self.queue.len() as u64);
        !self.terminals.is_empty()
    }

    /// Follows alternating paths from the terminal, breadth first, and collects the terminals of
    /// other strips that they reach.
    fn expand(&mut self, context: &SearchContext<'_>, terminal: u32, mut max_length: u32) {
        self.queue.clear();
        self.terminals.clear();
        self.reach(terminal);
        let own_path = context.tags.path(terminal);
        let (mut ring, mut length) = (0..1, 1);
        while !ring.is_empty() && length <= max_length {
            for i in ring.clone() {
                let tip = self.queue[i];
                for v in context.red_edges(tip).map(DualArc::target) {
                    if context.is_terminal(v) && context.tags.path(v) != own_path {
                        self.terminals.push(v);
                        max_length = max_length.min(length + MARGIN);
                    }
                    context.black_edges(v).for_each(|black| self.reach(black.target()));
                }
            }
            ring = ring.end..self.queue.len();
            length += 2;
        }
    }

    fn reach(&mut self, triangle: u32) {
        if std::mem::replace(&mut self.reached[triangle as usize], self.stamp) != self.stamp {
            self.queue.push(triangle);
        }
    }

    /// Computes the distances from the terminals, breadth first.
    fn measure_distances(&mut self, context: &SearchContext<'_>) {
        self.queue.clear();
        for i in 0..self.terminals.len() {
            context.red_edges(self.terminals[i]).for_each(|red| self.set_distance(red.target(), 1));
        }
        let mut next = 0;
        while next < self.queue.len() {
            let tip = self.queue[next];
            let distance = self.distance[tip as usize].1 + 2;
            for black in context.black_edges(tip) {
                context.red_edges(black.target()).for_each(|red| self.set_distance(red.target(), distance));
            }
            next += 1;
        }
    }

    /// Sets the distance of a triangle of the star that has none yet.
    fn set_distance(&mut self, triangle: u32, distance: u32) {
        let t = triangle as usize;
        if self.reached[t] == self.stamp && self.distance[t].0 != self.stamp {
            self.distance[t] = (self.stamp, distance);
            self.queue.push(triangle);
        }
    }

    /// Returns the length of the shortest alternating path from a triangle that has just been cut
    /// off, ignoring loops.
    pub(super) fn distance(&self, triangle: u32) -> Option<u32> {
        let (stamp, distance) = self.distance[triangle as usize];
        (stamp == self.stamp).then_some(distance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ids::HalfEdge;
    use crate::stripify::tunnel::path_tags::PathTags;
    use crate::stripify::tunnel::tests::graph_and_cover;
    use proptest::prelude::*;

    /// Computes, by repeated relaxation over all triangles, the number of edges from the terminal
    /// to each triangle reached over a black edge. Also computes, from each such triangle, the
    /// number of edges to a terminal that a path of at most `limit` edges reaches.
    fn naive_star(
        context: &SearchContext<'_>,
        terminal: u32,
        limit: u32,
    ) -> (Vec<Option<u32>>, Vec<Option<u32>>) {
        let n = context.cover.len() as u32;
        let is_shorter = |old: Option<u32>, new: u32| old.is_none_or(|old| new < old);
        let (mut out, mut back) = (vec![None; n as usize], vec![None; n as usize]);
        out[terminal as usize] = Some(0);
        for _ in 0..2 * n {
            for (a, red) in (0..n).flat_map(|a| context.red_edges(a).map(move |red| (a as usize, red))) {
                assert!(!context.cover.is_linked(HalfEdge(red.half_edge)));
                let v = red.target();
                for b in context.black_edges(v).map(|black| black.target() as usize) {
                    if let Some(length) = out[a]
                        && is_shorter(out[b], length + 2)
                    {
                        out[b] = Some(length + 2);
                    }
                    if let Some(length) = back[b]
                        && is_shorter(back[a], length + 2)
                    {
                        back[a] = Some(length + 2);
                    }
                }
                let is_reached = out[a].is_some_and(|length: u32| length < limit);
                if is_reached && context.is_terminal(v) && context.tags.path(v) != context.tags.path(terminal)
                {
                    // From there any red edge leads to it.
                    context.red_edges(v).for_each(|red| back[red.target() as usize] = Some(1));
                }
            }
        }
        (out, back)
    }

    proptest! {
        #[test]
        fn distances_are_those_of_relaxation((graph, cover) in graph_and_cover(), terminal in any::<u32>(), limit in 1..40_u32) {
            prop_assume!(!cover.is_empty());
            let terminal = terminal % cover.len() as u32;
            let tags = PathTags::new(&graph, &cover);
            let context = SearchContext { graph: &graph, cover: &cover, tags: &tags };
            prop_assume!(context.is_terminal(terminal));
            let mut star = GuidedStar::default();
            // The star ends a few edges beyond the nearest terminal.
            let (_, back) = naive_star(&context, terminal, limit);
            let nearest = back[terminal as usize].filter(|&nearest| nearest <= limit);
            let found = star.build(&context, terminal, limit, &mut AccessCounter::new(&()));
            prop_assert_eq!(found, nearest.is_some());
            prop_assert_eq!(star.distance(terminal), nearest);
            let limit = limit.min(nearest.unwrap_or(limit).saturating_add(MARGIN));
            let (out, back) = naive_star(&context, terminal, limit);
            for t in 0..cover.len() {
                let inside = out[t].is_some_and(|length| length <= limit + 1);
                prop_assert_eq!(star.reached[t] == star.stamp, inside, "{}", t);
                if let Some(distance) = star.distance(t as u32) {
                    prop_assert!(inside && back[t].is_some_and(|back| back <= distance));
                    let is_within = out[t].is_some_and(|length| length + distance <= limit);
                    prop_assert!(!is_within || back[t] == Some(distance), "{} {:?} {}", t, back[t], distance);
                }
            }
        }
    }
}
