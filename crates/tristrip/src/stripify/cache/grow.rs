//! Growing strips under trial: how many triangles more, then a restart, and where.

use super::border::{Border, Head, Way};
use super::buffers::Trial;
use super::{Growth, LEAST_HORIZON, MOST_HORIZON};
use crate::cover::PathCover;
use crate::ids::{FaceId, HalfEdge};

/// After how many triangles more a restart is tried, the horizon besides: closely at first, where it matters most.
const LENGTHS: [u32; 15] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 40, 52];

/// Lays strips down over a whole triangulation.
pub(super) struct Grower<'a, B> {
    border: Border<'a, B>,
    /// Triangles of a trial.
    horizon: u32,
    /// Places of the buffer from its old end in which a vertex is no longer worth a restart.
    slack: u32,
    /// Strips that are followed where they are.
    guide: Option<&'a PathCover>,
}

/// A trial's price, compared by cost a triangle.
#[derive(Debug, Clone, Copy)]
struct Price {
    cost: i64,
    triangles: i64,
}

impl Price {
    fn is_below(self, other: Self) -> bool {
        self.cost * other.triangles < other.cost * self.triangles
    }
}

impl<'a, B: Trial> Grower<'a, B> {
    pub(super) fn new(border: Border<'a, B>, growth: Growth, guide: Option<&'a PathCover>) -> Self {
        let places = border.places();
        Self {
            border,
            horizon: (places.saturating_mul(growth.horizon) / 16).clamp(LEAST_HORIZON, MOST_HORIZON),
            slack: places.saturating_mul(growth.slack) / 16,
            guide,
        }
    }

    /// Covers everything; gives the cover and the first triangle of each path, the paths as they are drawn.
    pub(super) fn run(&mut self) -> (PathCover, Vec<FaceId>) {
        let graph = self.border.graph();
        let mut cover = PathCover::isolated(graph.face_count());
        let mut order = Vec::new();
        let mut head = None;
        loop {
            let mut more = self.best_length(head);
            if more == 0 {
                // One triangle more where there is a way: what was sent of the first depends on it.
                more = 1;
                let edge = self.border.oldest_edge(self.slack);
                let Some(edge) = edge.or_else(|| self.border.youngest_edge()) else { break };
                order.push(FaceId(edge / 3));
                head = Some(self.start(edge));
            }
            for _ in 0..more {
                let Some((from, way)) = head.and_then(|head| Some((head, self.way(head)?))) else { break };
                cover.link(graph, HalfEdge(way.exit));
                head = Some(self.border.go(from, way));
            }
            self.border.keep();
        }
        (cover, order)
    }

    #[cfg(test)]
    pub(super) fn border(&self) -> &Border<'a, B> {
        &self.border
    }

    /// Gives the way that the strip takes: the guide's, else around the vertex of the border on its side.
    #[inline]
    fn way(&self, head: Head) -> Option<Way> {
        let [next, previous] = self.border.ways(head);
        let guided = self.guide.and_then(|guide| {
            [next, previous].into_iter().flatten().find(|way| guide.is_linked(HalfEdge(way.exit)))
        });
        guided.or(next).or(previous)
    }

    /// Begins a strip at an edge of the border.
    fn start(&mut self, edge: u32) -> Head {
        let triangle = edge / 3;
        let mut exits = [1, 2, 0].map(|turn| (edge + turn) % 3);
        if let Some(guide) = self.guide {
            exits.sort_by_key(|exit| !guide.is_linked(HalfEdge(3 * triangle + exit)));
        }
        let exit = exits.into_iter().find(|&exit| self.border.across(triangle, exit).is_some());
        self.border.start(triangle, exit)
    }

    #[inline]
    fn step(&mut self, head: Head) -> Option<Head> {
        let way = self.way(head)?;
        Some(self.border.go(head, way))
    }

    /// Tries after how many triangles more a restart is cheapest; 0 for one at once.
    fn best_length(&mut self, head: Option<Head>) -> u32 {
        let Some(mut head) = head.filter(|&head| self.way(head).is_some()) else { return 0 };
        // For good, so that no trial passes again over what was drawn since the last restart.
        self.border.oldest_edge(self.slack);
        let base = self.border.mark();
        let paid = self.border.cost();
        let mut best = (0, self.trial(0, paid));
        self.border.undo(base);
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
            let here = self.border.mark();
            let price = self.trial(length, paid);
            self.border.undo(here);
            if best.1.is_none_or(|best| price.is_some_and(|price| price.is_below(best))) {
                best = (length, price);
            }
            if has_ended {
                break;
            }
        }
        self.border.undo(base);
        best.0
    }

    /// Restarts and goes on to the horizon; gives the price of all since `paid`, or `None` where nothing could be drawn.
    fn trial(&mut self, length: u32, paid: i64) -> Option<Price> {
        let mut drawn = length;
        let mut head = None;
        while drawn < self.horizon {
            head = head.and_then(|head| self.step(head));
            if head.is_none() {
                let Some(edge) = self.border.oldest_edge(self.slack) else { break };
                head = Some(self.start(edge));
            }
            drawn += 1;
        }
        (drawn > 0).then(|| Price { cost: self.border.cost() - paid, triangles: i64::from(drawn) })
    }
}
