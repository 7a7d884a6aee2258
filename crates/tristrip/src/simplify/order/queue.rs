//! Simplification by quadrics as Garland and Heckbert published it: of all pairs of neighbours the cheapest collapses next.
//!
//! # Algorithm
//! 1. The quadric of a point is the sum of the squared distances from the planes of its triangles, each plane once and unweighted
//!    (1997, section 5), and from planes through its border edges, perpendicular to their triangles (section 6).
//! 2. The cost of a collapse of `p` to `q` is `(Qp + Qq)` at the position of `q`. Every pair of neighbours waits in both directions, which
//!    is the paper's pair whose better end is kept: Kim et al. 2005 collapse half-edges, and no vertex moves.
//! 3. The cheapest collapse is taken from a queue; of equal costs that of the lowest point, then to the lowest one. Points are numbered in
//!    the order in which the triangles use them, sorted along a curve where they are far apart (module `curve`). The quadric of `p` is
//!    added to that of `q`, and all pairs around are priced again.
//!
//! An entry of the queue is void once a collapse has changed the triangles of one of its points. Whether a collapse is allowed depends on
//! these triangles alone, and is checked when the entry comes to the front: a refused one comes back with the next change. A point of more than
//! 256 triangles does not collapse, and its pairs are not priced again when others collapse to it: costs only increase, so that a pair is priced
//! again when it comes to the front.
//!
//! # Departures
//! - The paper only says that the weight of border planes is large; here it is 1000, the default of its authors' program `QSlim`. `QSlim` and the
//!   later papers also weight each plane by the area of its triangle; the paper of 1997 does not, and neither does this.
//! - All collapses that `decimate` refuses are refused here: the paper allows any topology, and only asks that no normal flips; here no triangle
//!   rotates by more than about 75 degrees, the link condition holds, the last triangle of a component stays, and seams of attributes stay closed.
//! - Pairs are edges alone: the paper's distance threshold for pairs without an edge is 0.
//! - Vertices of one position are one point. The attributes of vertices have no price.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Garland: `QSlim`, 1998 (the weight of border planes).
//!
//! # Complexity
//! O(d log n) time per collapse, d the number of triangles around its points and their neighbours, of which each counts 256 at most; 24 bytes
//! per entry of the queue. There are three entries per triangle that are not void, and void ones are removed when there are as many of them.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use crate::simplify::price::priced_surface::PricedSurface;
use crate::simplify::surface::outcome::MAX_CORNERS;

/// A collapse in the queue.
#[derive(Debug, Clone, Copy)]
pub(crate) struct QueuedCollapse {
    /// In units of the frame.
    pub(crate) cost: f64,
    pub(crate) point: u32,
    pub(crate) to: u32,
    /// The number of collapses that were done before it was priced.
    priced: u32,
}

/// Void entries are not removed while there are fewer entries.
const MIN_ENTRIES: usize = 64;

impl QueuedCollapse {
    /// Returns whether neither point has changed since; `changed` has the number of the last collapse that did.
    fn is_current(&self, changed: &[u32]) -> bool {
        [self.point, self.to].iter().all(|&p| changed[p as usize] <= self.priced)
    }

    /// The order in which collapses are taken.
    fn order(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then_with(|| (self.point, self.to).cmp(&(other.point, other.to)))
    }
}

impl Ord for QueuedCollapse {
    fn cmp(&self, other: &Self) -> Ordering {
        self.order(other)
    }
}

impl PartialOrd for QueuedCollapse {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for QueuedCollapse {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for QueuedCollapse {}

/// The collapses of all pairs of neighbours, the cheapest first.
#[derive(Debug)]
pub(crate) struct CollapseQueue {
    heap: BinaryHeap<Reverse<QueuedCollapse>>,
    /// For each point the number of the last collapse that changed its triangles, from 1.
    changed: Vec<u32>,
    /// The number of collapses done.
    done: u32,
    /// The number of entries above which void ones are removed.
    most_entries: usize,
    neighbours: Vec<u32>,
}

impl CollapseQueue {
    /// Prices all pairs of neighbours.
    pub(crate) fn new(surface: &PricedSurface) -> Self {
        let count = surface.topology.point_count();
        let mut queue = Self {
            heap: BinaryHeap::new(),
            changed: vec![0; count],
            done: 0,
            most_entries: 0,
            neighbours: Vec::new(),
        };
        let mut entries = Vec::new();
        for point in (0..count as u32).filter(|&point| may_collapse(surface, point)) {
            surface.topology.neighbours(point, &mut queue.neighbours);
            entries.extend(queue.neighbours.iter().map(|&to| Reverse(queue.priced(surface, point, to))));
        }
        queue.heap = entries.into();
        queue.most_entries = 2 * queue.heap.len().max(MIN_ENTRIES);
        queue
    }

    fn priced(&self, surface: &PricedSurface, point: u32, to: u32) -> QueuedCollapse {
        QueuedCollapse { cost: cost_of(surface, point, to), point, to, priced: self.done }
    }

    /// Returns the cheapest collapse whose points have not changed, and removes it.
    pub(crate) fn next(&mut self, surface: &PricedSurface) -> Option<QueuedCollapse> {
        while let Some(Reverse(next)) = self.heap.pop() {
            if !next.is_current(&self.changed) {
                continue;
            }
            let priced = self.priced(surface, next.point, next.to);
            if priced.cost.total_cmp(&next.cost).is_eq() {
                return Some(next);
            }
            self.heap.push(Reverse(priced));
        }
        None
    }

    /// Prices the pairs of the points around a collapse that was done.
    pub(crate) fn update(&mut self, surface: &PricedSurface, removed: u32, around: &[u32]) {
        self.done += 1;
        self.changed[removed as usize] = self.done;
        let around = || around.iter().copied().filter(|&point| may_collapse(surface, point));
        around().for_each(|point| self.changed[point as usize] = self.done);
        let mut neighbours = std::mem::take(&mut self.neighbours);
        for point in around() {
            surface.topology.neighbours(point, &mut neighbours);
            for &other in &neighbours {
                self.heap.push(Reverse(self.priced(surface, point, other)));
                // The other direction is priced with the other point, if that is around, too.
                if self.changed[other as usize] != self.done && may_collapse(surface, other) {
                    self.heap.push(Reverse(self.priced(surface, other, point)));
                }
            }
        }
        self.neighbours = neighbours;
        if self.heap.len() > self.most_entries {
            let changed = &self.changed;
            self.heap.retain(|Reverse(entry)| entry.is_current(changed));
            self.most_entries = 2 * self.heap.len().max(MIN_ENTRIES);
        }
    }
}

/// Returns whether a point has few enough triangles to collapse.
fn may_collapse(surface: &PricedSurface, point: u32) -> bool {
    surface.topology.ring(point).len() <= MAX_CORNERS
}

/// Returns the cost of a collapse in units of the frame: the sum of the quadrics of both points where the kept one is.
fn cost_of(surface: &PricedSurface, point: u32, to: u32) -> f64 {
    let mut quadric = surface.quadrics[point as usize];
    quadric.add(&surface.quadrics[to as usize]);
    quadric.at(surface.positions[to as usize])
}
