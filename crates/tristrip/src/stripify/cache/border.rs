//! What is drawn, the border around it, and what it has cost: the state in which strips grow, for good or for trial.

use super::buffers::Trial;
use super::{MOST_HORIZON, Weights};
use crate::dual::DualGraph;
use crate::dual::Triangulation;

/// No triangle beyond an edge.
const NONE: u32 = u32::MAX;
/// Marks a triangle that is drawn; below it a triangle's neighbours that are not drawn are counted.
const DRAWN: u8 = 4;

/// What triangles with one open neighbour and with none cost in advance, in indices: strips will end in the one, and the other will
/// be a strip.
const LEAF: i64 = 1;
const ALONE: i64 = 3;
/// What that changes when a triangle of so many open neighbours is drawn.
const DRAWING: [i64; 8] = [-ALONE, -LEAF, 0, 0, 0, 0, 0, 0];
/// What that changes when a triangle of so many open neighbours loses one; from [`DRAWN`] on it is drawn itself.
const LOSING: [i64; 8] = [0, ALONE - LEAF, LEAF, 0, 0, 0, 0, 0];

/// Counts corners on beyond the third.
#[inline]
fn wrapped(corner: u32) -> usize {
    (if corner >= 3 { corner - 3 } else { corner }) as usize
}

/// Where a strip stands: the triangle drawn last, the edge over which it was entered, and the strip's parity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Head {
    pub(super) triangle: u32,
    pub(super) entry: u32,
    /// Whether the triangle stands at an even place, where leaving over the edge after `entry` takes no swap.
    pub(super) is_even: bool,
}

/// A way to go on: the half-edge across which the next triangle lies, and that triangle's side of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Way {
    pub(super) exit: u32,
    pub(super) entry: u32,
}

/// A state to come back to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mark<M> {
    edges: usize,
    oldest: usize,
    drawn: usize,
    cost: i64,
    buffer: M,
}

/// Triangles drawn, those around them, and the vertex buffer.
#[derive(Debug)]
pub(super) struct Border<'a, B> {
    graph: &'a DualGraph,
    triangles: &'a [[u32; 3]],
    twins: &'a [[u32; 3]],
    /// Open neighbours of each triangle, and whether it is drawn.
    state: Vec<u8>,
    /// Half-edges of open triangles toward drawn ones, in the order in which they became so; drawn ones are passed over.
    edges: Vec<u32>,
    edge_count: usize,
    /// Before this place of `edges` no vertices are in the buffer.
    oldest: usize,
    /// Triangles drawn since the last [`Border::keep`].
    drawn: Vec<u32>,
    /// No open triangle is lower.
    lowest: u32,
    buffer: B,
    weights: Weights,
    cost: i64,
}

impl<'a, B: Trial> Border<'a, B> {
    pub(super) fn new(triangulation: &'a Triangulation<'_>, buffer: B, weights: Weights) -> Self {
        let (triangles, _) = triangulation.triangles().as_chunks();
        let (twins, _) = triangulation.graph().twins().as_chunks();
        let count = |edges: &[u32; 3]| edges.iter().filter(|&&twin| twin != NONE).count() as u8;
        Self {
            graph: triangulation.graph(),
            triangles,
            twins,
            state: twins.iter().map(count).collect(),
            edges: vec![0; 3 * (twins.len() + MOST_HORIZON as usize) + 1],
            edge_count: 0,
            oldest: 0,
            drawn: Vec::new(),
            lowest: 0,
            buffer,
            weights,
            cost: 0,
        }
    }

    pub(super) fn graph(&self) -> &'a DualGraph {
        self.graph
    }

    pub(super) fn places(&self) -> u32 {
        self.buffer.places()
    }

    /// Gives what was paid and will have to be paid: see [`LEAF`].
    pub(super) fn cost(&self) -> i64 {
        self.cost
    }

    /// Counts what is due in advance: see [`LEAF`].
    #[cfg(test)]
    pub(super) fn due(&self) -> i64 {
        self.weights.index * self.state.iter().map(|&state| -DRAWING[usize::from(state & 7)]).sum::<i64>()
    }

    #[inline]
    fn is_open(&self, triangle: u32) -> bool {
        self.state[triangle as usize] < DRAWN
    }

    /// Gives the vertex at a corner, counted on beyond the third.
    #[inline]
    fn corner(&self, triangle: u32, corner: u32) -> u32 {
        self.triangles[triangle as usize][wrapped(corner)]
    }

    /// Gives the other side of an edge where the triangle there is open.
    #[inline]
    pub(super) fn across(&self, triangle: u32, edge: u32) -> Option<Way> {
        let edge = wrapped(edge);
        let (exit, entry) = (3 * triangle + edge as u32, self.twins[triangle as usize][edge]);
        (entry != NONE && self.is_open(entry / 3)).then_some(Way { exit, entry })
    }

    /// Gives the way over the edge after the entry, and over the one before it.
    #[inline]
    pub(super) fn ways(&self, head: Head) -> [Option<Way>; 2] {
        [1, 2].map(|turn| self.across(head.triangle, head.entry + turn))
    }

    #[inline]
    fn send(&mut self, vertex: u32) {
        let is_missing = self.buffer.send(vertex);
        self.cost += self.weights.index + i64::from(is_missing) * self.weights.miss;
    }

    /// Draws an open triangle: its neighbours have one open neighbour less.
    #[inline]
    fn draw(&mut self, triangle: u32) {
        let state = &mut self.state[triangle as usize];
        let mut due = DRAWING[usize::from(*state & 7)];
        *state += DRAWN;
        self.drawn.push(triangle);
        for &twin in &self.twins[triangle as usize] {
            if twin == NONE {
                continue;
            }
            let state = &mut self.state[(twin / 3) as usize];
            let before = *state;
            *state -= 1;
            due += LOSING[usize::from(before & 7)];
            // Without a branch, which no processor could foresee: what is not an edge of the border is written over.
            self.edges[self.edge_count] = twin;
            self.edge_count += usize::from(before < DRAWN);
        }
        self.cost += due * self.weights.index;
    }

    /// Begins a strip with a triangle that it leaves over an edge, if at all.
    pub(super) fn start(&mut self, triangle: u32, exit: Option<u32>) -> Head {
        let exit = exit.unwrap_or(1);
        self.cost += self.weights.index;
        [exit + 2, exit, exit + 1].into_iter().for_each(|corner| self.send(self.corner(triangle, corner)));
        self.draw(triangle);
        Head { triangle, entry: wrapped(exit + 2) as u32, is_even: true }
    }

    /// Goes on to the next triangle.
    #[inline]
    pub(super) fn go(&mut self, head: Head, way: Way) -> Head {
        let is_next = way.exit % 3 == if head.entry == 2 { 0 } else { head.entry + 1 };
        let mut is_even = head.is_even;
        if is_next == is_even {
            is_even = !is_even;
        } else {
            // A swap sends the vertex again that is left behind otherwise.
            self.send(self.corner(head.triangle, head.entry + u32::from(!is_even)));
        }
        let (triangle, entry) = (way.entry / 3, way.entry % 3);
        self.send(self.corner(triangle, entry + 2));
        self.draw(triangle);
        Head { triangle, entry, is_even }
    }

    /// Finds the oldest edge of the border whose vertices are in the buffer, and not among its `slack` oldest.
    #[inline]
    pub(super) fn oldest_edge(&mut self, slack: u32) -> Option<u32> {
        while self.oldest < self.edge_count {
            let half_edge = self.edges[self.oldest];
            let (triangle, edge) = (half_edge / 3, half_edge % 3);
            if self.is_open(triangle) {
                let [from, to] =
                    [edge, edge + 1].map(|corner| self.buffer.age(self.corner(triangle, corner)));
                if from.max(to).saturating_add(slack) < self.buffer.places() {
                    return Some(half_edge);
                }
            }
            self.oldest += 1;
        }
        None
    }

    /// Finds the edge of the border that was drawn last, else one of the lowest open triangle. Not to be undone.
    pub(super) fn youngest_edge(&mut self) -> Option<u32> {
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

    pub(super) fn mark(&mut self) -> Mark<B::Mark> {
        Mark {
            edges: self.edge_count,
            oldest: self.oldest,
            drawn: self.drawn.len(),
            cost: self.cost,
            buffer: self.buffer.mark(),
        }
    }

    pub(super) fn undo(&mut self, mark: Mark<B::Mark>) {
        for &triangle in self.drawn[mark.drawn..].iter().rev() {
            self.state[triangle as usize] -= DRAWN;
            for &twin in &self.twins[triangle as usize] {
                if twin != NONE {
                    self.state[(twin / 3) as usize] += 1;
                }
            }
        }
        self.drawn.truncate(mark.drawn);
        self.edge_count = mark.edges;
        (self.oldest, self.cost) = (mark.oldest, mark.cost);
        self.buffer.undo(mark.buffer);
    }

    /// Forgets all marks: what is drawn is drawn for good.
    pub(super) fn keep(&mut self) {
        self.drawn.clear();
        self.buffer.keep();
    }
}
