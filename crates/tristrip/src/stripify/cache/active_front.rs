//! The active front: the drawn triangles, the edges around them, and the cost so far. Strips grow
//! on this state, speculatively or permanently.

use super::policy::{MAX_HORIZON, PolicyWeights};
use super::speculative::SpeculativeCache;
use crate::dual::{DualGraph, Triangulation};

/// Marks a drawn triangle. Lower states are the number of neighbours that are not drawn.
const DRAWN: u8 = 4;

/// Anticipated costs, in indices, of triangles with one open neighbour (a strip will end there) and
/// with none (a strip of their own).
const LEAF: i64 = 1;
const ISOLATED: i64 = 3;
/// Change of the anticipated cost when a triangle is drawn, by its number of open neighbours.
const DRAWING: [i64; 8] = [-ISOLATED, -LEAF, 0, 0, 0, 0, 0, 0];
/// Change of the anticipated cost when a triangle loses an open neighbour, by the number before.
/// From [`DRAWN`] on the triangle is drawn itself.
const LOSING: [i64; 8] = [0, ISOLATED - LEAF, LEAF, 0, 0, 0, 0, 0];

/// Wraps a corner index that may exceed 2.
#[inline]
fn wrapped(corner: u32) -> usize {
    (if corner >= 3 { corner - 3 } else { corner }) as usize
}

/// The current end of a strip: the last triangle, the edge over which it was entered, and the
/// parity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct StripHead {
    pub(super) triangle: u32,
    pub(super) entry: u32,
    /// Whether the triangle has an even position. Leaving over the edge after `entry` then takes no
    /// swap.
    pub(super) is_even: bool,
}

/// A step to the next triangle: the half-edge over which the strip leaves, and its twin in the next
/// triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EdgeCrossing {
    pub(super) exit: u32,
    pub(super) entry: u32,
}

/// A state to roll back to.
#[derive(Debug, Clone, Copy)]
pub(super) struct FrontCheckpoint<C> {
    edges: usize,
    oldest: usize,
    drawn: usize,
    cost: i64,
    cache: C,
}

/// The drawn triangles, the edges around them, and the vertex cache.
#[derive(Debug)]
pub(super) struct ActiveFront<'a, C> {
    graph: &'a DualGraph,
    triangles: &'a [[u32; 3]],
    /// The number of open neighbours of each triangle, plus [`DRAWN`] if it is drawn.
    state: Vec<u8>,
    /// Half-edges of open triangles next to drawn ones, oldest first. Those of triangles drawn
    /// since are skipped.
    edges: Vec<u32>,
    edge_count: usize,
    /// No edge in `edges` before this position has its vertices in the cache.
    oldest: usize,
    /// Triangles drawn since the last [`ActiveFront::commit`].
    drawn: Vec<u32>,
    /// All triangles with lower indices are drawn.
    lowest: u32,
    cache: C,
    weights: PolicyWeights,
    cost: i64,
}

impl<'a, C: SpeculativeCache> ActiveFront<'a, C> {
    /// Creates a front without drawn triangles.
    pub(super) fn new(triangulation: &'a Triangulation<'_>, cache: C, weights: PolicyWeights) -> Self {
        let (triangles, _) = triangulation.triangles().as_chunks();
        let graph = triangulation.graph();
        Self {
            graph,
            triangles,
            state: graph.neighbour_counts().collect(),
            edges: vec![0; 3 * (triangles.len() + MAX_HORIZON as usize) + 1],
            edge_count: 0,
            oldest: 0,
            drawn: Vec::new(),
            lowest: 0,
            cache,
            weights,
            cost: 0,
        }
    }

    pub(super) fn graph(&self) -> &'a DualGraph {
        self.graph
    }

    pub(super) fn entry_count(&self) -> u32 {
        self.cache.entry_count()
    }

    /// Returns the cost so far plus the change of the anticipated cost: see [`LEAF`].
    pub(super) fn cost(&self) -> i64 {
        self.cost
    }

    /// Returns the anticipated cost of the open triangles: see [`LEAF`].
    #[cfg(test)]
    pub(super) fn anticipated_cost(&self) -> i64 {
        self.weights.index * self.state.iter().map(|&state| -DRAWING[usize::from(state & 7)]).sum::<i64>()
    }

    #[inline]
    fn is_open(&self, triangle: u32) -> bool {
        self.state[triangle as usize] < DRAWN
    }

    /// Returns the vertex at a corner, whose index may exceed 2.
    #[inline]
    fn corner(&self, triangle: u32, corner: u32) -> u32 {
        self.triangles[triangle as usize][wrapped(corner)]
    }

    /// Returns the step over an edge, or `None` unless the triangle on the other side is open.
    #[inline]
    pub(super) fn crossing(&self, triangle: u32, edge: u32) -> Option<EdgeCrossing> {
        let exit = 3 * triangle + wrapped(edge) as u32;
        let entry = self.graph.twin_of(exit)?;
        self.is_open(entry / 3).then_some(EdgeCrossing { exit, entry })
    }

    /// Returns the steps over the edge after the entry and over the edge before it.
    #[inline]
    pub(super) fn crossings(&self, head: StripHead) -> [Option<EdgeCrossing>; 2] {
        [1, 2].map(|turn| self.crossing(head.triangle, head.entry + turn))
    }

    #[inline]
    fn send(&mut self, vertex: u32) {
        let is_miss = self.cache.access(vertex);
        self.cost += self.weights.index + i64::from(is_miss) * self.weights.miss;
    }

    /// Draws an open triangle. Each neighbour then has one open neighbour fewer.
    #[inline]
    fn draw(&mut self, triangle: u32) {
        let state = &mut self.state[triangle as usize];
        let mut anticipated = DRAWING[usize::from(*state & 7)];
        *state += DRAWN;
        self.drawn.push(triangle);
        for twin in self.graph.twins_of(triangle) {
            let state = &mut self.state[(twin / 3) as usize];
            let before = *state;
            *state -= 1;
            anticipated += LOSING[usize::from(before & 7)];
            // Avoids an unpredictable branch: an entry that is not an edge of the front is
            // overwritten.
            self.edges[self.edge_count] = twin;
            self.edge_count += usize::from(before < DRAWN);
        }
        self.cost += anticipated * self.weights.index;
    }

    /// Starts a strip with a triangle that it leaves over `exit`, if given.
    pub(super) fn start(&mut self, triangle: u32, exit: Option<u32>) -> StripHead {
        let exit = exit.unwrap_or(1);
        self.cost += self.weights.index;
        [exit + 2, exit, exit + 1].into_iter().for_each(|corner| self.send(self.corner(triangle, corner)));
        self.draw(triangle);
        StripHead { triangle, entry: wrapped(exit + 2) as u32, is_even: true }
    }

    /// Extends a strip to the next triangle.
    #[inline]
    pub(super) fn advance(&mut self, head: StripHead, crossing: EdgeCrossing) -> StripHead {
        let is_next = crossing.exit % 3 == if head.entry == 2 { 0 } else { head.entry + 1 };
        let mut is_even = head.is_even;
        if is_next == is_even {
            is_even = !is_even;
        } else {
            // A swap repeats the vertex that would otherwise be dropped.
            self.send(self.corner(head.triangle, head.entry + u32::from(!is_even)));
        }
        let (triangle, entry) = (crossing.entry / 3, crossing.entry % 3);
        self.send(self.corner(triangle, entry + 2));
        self.draw(triangle);
        StripHead { triangle, entry, is_even }
    }

    /// Returns the oldest edge of the front whose vertices are in the cache but not among its
    /// `slack` oldest entries.
    #[inline]
    pub(super) fn oldest_edge(&mut self, slack: u32) -> Option<u32> {
        while self.oldest < self.edge_count {
            let half_edge = self.edges[self.oldest];
            let (triangle, edge) = (half_edge / 3, half_edge % 3);
            if self.is_open(triangle) {
                let [from, to] = [edge, edge + 1].map(|corner| self.cache.age(self.corner(triangle, corner)));
                if from.max(to).saturating_add(slack) < self.cache.entry_count() {
                    return Some(half_edge);
                }
            }
            self.oldest += 1;
        }
        None
    }

    /// Returns the newest edge of the front, or an edge of the lowest open triangle if the front is
    /// empty. Cannot be rolled back.
    pub(super) fn newest_edge(&mut self) -> Option<u32> {
        while self.edge_count > 0 {
            let half_edge = self.edges[self.edge_count - 1];
            if self.is_open(half_edge / 3) {
                return Some(half_edge);
            }
            self.edge_count -= 1;
            self.oldest = self.oldest.min(self.edge_count);
        }
        while (self.lowest as usize) < self.state.len() {
            if self.is_open(self.lowest) {
                return Some(3 * self.lowest);
            }
            self.lowest += 1;
        }
        None
    }

    /// Returns a checkpoint of the current state.
    pub(super) fn checkpoint(&mut self) -> FrontCheckpoint<C::Checkpoint> {
        FrontCheckpoint {
            edges: self.edge_count,
            oldest: self.oldest,
            drawn: self.drawn.len(),
            cost: self.cost,
            cache: self.cache.checkpoint(),
        }
    }

    /// Rolls back to a checkpoint.
    pub(super) fn roll_back(&mut self, checkpoint: FrontCheckpoint<C::Checkpoint>) {
        for &triangle in self.drawn[checkpoint.drawn..].iter().rev() {
            self.state[triangle as usize] -= DRAWN;
            for twin in self.graph.twins_of(triangle) {
                self.state[(twin / 3) as usize] += 1;
            }
        }
        self.drawn.truncate(checkpoint.drawn);
        self.edge_count = checkpoint.edges;
        (self.oldest, self.cost) = (checkpoint.oldest, checkpoint.cost);
        self.cache.roll_back(checkpoint.cache);
    }

    /// Makes all drawn triangles permanent and discards all checkpoints.
    pub(super) fn commit(&mut self) {
        self.drawn.clear();
        self.cache.commit();
    }
}
