//! Strip growth with speculative simulation: how many more triangles to draw before a restart, and
//! where the next strip starts.

use super::active_front::{ActiveFront, EdgeCrossing, StripHead};
use super::policy::GrowthPolicy;
use super::speculative::SpeculativeCache;
use crate::cover::PathCover;
use crate::ids::{FaceId, HalfEdge};

/// The numbers of triangles after which a restart is simulated, in addition to the horizon. They
/// are closely spaced at first, where the number matters most.
const LENGTHS: [u32; 15] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 52];

/// Grows strips over a whole triangulation.
pub(super) struct StripGrower<'a, C> {
    front: ActiveFront<'a, C>,
    /// Number of triangles of a speculative simulation.
    horizon: u32,
    /// Number of oldest cache entries whose vertices do not justify a restart.
    slack: u32,
    /// Strips to follow where possible.
    seed_strips: Option<&'a PathCover>,
}

/// The cost of a speculative simulation, compared per triangle.
#[derive(Debug, Clone, Copy)]
struct SimulatedCost {
    cost: i64,
    triangles: i64,
}

impl SimulatedCost {
    fn is_below(self, other: Self) -> bool {
        self.cost * other.triangles < other.cost * self.triangles
    }
}

impl<'a, C: SpeculativeCache> StripGrower<'a, C> {
    /// Creates a grower on an empty front.
    pub(super) fn new(
        front: ActiveFront<'a, C>,
        policy: GrowthPolicy,
        seed_strips: Option<&'a PathCover>,
    ) -> Self {
        let entry_count = front.entry_count();
        Self { front, horizon: policy.horizon(entry_count), slack: policy.slack(entry_count), seed_strips }
    }

    /// Covers all triangles. Returns the cover and the first triangle of each path in drawing
    /// order.
    pub(super) fn run(&mut self) -> (PathCover, Vec<FaceId>) {
        let graph = self.front.graph();
        let mut cover = PathCover::isolated(graph.face_count());
        let mut order = Vec::new();
        let mut head = None;
        loop {
            let mut more = self.best_length(head);
            if more == 0 {
                // One more triangle if possible, because it determines the vertices sent for the
                // first one.
                more = 1;
                let edge = self.front.oldest_edge(self.slack);
                let Some(edge) = edge.or_else(|| self.front.newest_edge()) else { break };
                order.push(FaceId(edge / 3));
                head = Some(self.start(edge));
            }
            for _ in 0..more {
                let next = head.and_then(|head| Some((head, self.crossing(head)?)));
                let Some((from, crossing)) = next else { break };
                cover.link(graph, HalfEdge(crossing.exit));
                head = Some(self.front.advance(from, crossing));
            }
            self.front.commit();
        }
        (cover, order)
    }

    #[cfg(test)]
    pub(super) fn front(&self) -> &ActiveFront<'a, C> {
        &self.front
    }

    /// Returns the next step of a strip. It follows the seed strips if possible. Otherwise it turns
    /// around the vertex on the side of the front.
    #[inline]
    fn crossing(&self, head: StripHead) -> Option<EdgeCrossing> {
        let [next, previous] = self.front.crossings(head);
        let seeded = self.seed_strips.and_then(|cover| {
            [next, previous].into_iter().flatten().find(|crossing| cover.is_linked(HalfEdge(crossing.exit)))
        });
        seeded.or(next).or(previous)
    }

    /// Starts a strip at an edge of the front.
    fn start(&mut self, edge: u32) -> StripHead {
        let triangle = edge / 3;
        let mut exits = [1, 2, 0].map(|turn| (edge + turn) % 3);
        if let Some(cover) = self.seed_strips {
            exits.sort_by_key(|exit| !cover.is_linked(HalfEdge(3 * triangle + exit)));
        }
        let exit = exits.into_iter().find(|&exit| self.front.crossing(triangle, exit).is_some());
        self.front.start(triangle, exit)
    }

    #[inline]
    fn step(&mut self, head: StripHead) -> Option<StripHead> {
        let crossing = self.crossing(head)?;
        Some(self.front.advance(head, crossing))
    }

    /// Returns the number of further triangles after which a restart is cheapest, by simulation.
    /// Returns 0 for an immediate restart.
    fn best_length(&mut self, head: Option<StripHead>) -> u32 {
        let Some(mut head) = head.filter(|&head| self.crossing(head).is_some()) else { return 0 };
        // Permanently, so no simulation scans again what was drawn since the last restart.
        self.front.oldest_edge(self.slack);
        let base = self.front.checkpoint();
        let paid = self.front.cost();
        let mut best = (0, self.simulate_restart(0, paid));
        self.front.roll_back(base);
        let mut length = 0;
        let horizon = self.horizon;
        let lengths = LENGTHS.into_iter().take_while(|&length| length < horizon);
        for target in lengths.chain([horizon]) {
            let mut has_ended = false;
            while length < target && !has_ended {
                match self.step(head) {
                    Some(next) => (head, length) = (next, length + 1),
                    None => has_ended = true,
                }
            }
            let here = self.front.checkpoint();
            let cost = self.simulate_restart(length, paid);
            self.front.roll_back(here);
            if best.1.is_none_or(|best| cost.is_some_and(|cost| cost.is_below(best))) {
                best = (length, cost);
            }
            if has_ended {
                break;
            }
        }
        self.front.roll_back(base);
        best.0
    }

    /// Restarts and continues to the horizon. Returns the cost of everything since `paid`, or
    /// `None` if nothing could be drawn.
    fn simulate_restart(&mut self, length: u32, paid: i64) -> Option<SimulatedCost> {
        let mut drawn = length;
        let mut head = None;
        while drawn < self.horizon {
            head = head.and_then(|head| self.step(head));
            if head.is_none() {
                let Some(edge) = self.front.oldest_edge(self.slack) else { break };
                head = Some(self.start(edge));
            }
            drawn += 1;
        }
        (drawn > 0).then(|| SimulatedCost { cost: self.front.cost() - paid, triangles: i64::from(drawn) })
    }
}
