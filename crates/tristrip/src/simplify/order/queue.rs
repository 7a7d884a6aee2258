//! Quadric simplification as published by Garland and Heckbert: the globally cheapest pair of
//! neighbours collapses next.
//!
//! # Algorithm
//! 1. The quadric of a point is a sum of squared distances from planes. The planes of its triangles
//!    count once each, unweighted (1997, section 5). Each border edge adds a plane through the
//!    edge, perpendicular to its triangle (section 6).
//! 2. The cost of a collapse of `p` to `q` is `(Qp + Qq)` at the position of `q`. Every pair of
//!    neighbours is queued in both directions, so the better end point is kept. As in Kim et al.
//!    2005, all collapses are half-edge collapses, so no vertex moves.
//! 3. The cheapest collapse is taken from a queue. Ties go to the lowest removed point, then to the
//!    lowest kept point. Points are numbered in the order in which the triangles use them;
//!    triangles are sorted along a curve if neighbours are far apart in memory (module `curve`).
//!    The quadric of `p` is added to the quadric of `q`, and all surrounding pairs are priced
//!    again.
//!
//! An entry of the queue becomes invalid when a collapse changes the triangles of one of its
//! points. Whether a collapse is allowed depends only on these triangles. It is checked when the
//! entry reaches the front; a refused collapse is queued again after the next change. A point with
//! more than 256 triangles does not collapse. Its pairs are not priced again when other points
//! collapse to it. Costs only increase, so such a pair is priced again when it reaches the front.
//!
//! # Departures
//! - The paper only says that the weight of border planes is large. Here it is 1000, the default of
//!   its authors' program `QSlim`. `QSlim` and the later papers also weight each plane by the area
//!   of its triangle. The 1997 paper and this module use unweighted planes.
//! - All collapses refused by `decimate` are refused here. The paper allows any topology and only
//!   requires that no normal flips. Here no triangle rotates by more than about 75 degrees, the
//!   link condition holds, the last triangle of a component is kept, and attribute seams stay
//!   closed.
//! - Only the two ends of an edge form a pair: the paper's distance threshold for other pairs is 0.
//! - Vertices at the same position are one point. Vertex attributes do not affect the cost.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Garland: `QSlim`,
//! 1998 (the weight of border planes).
//!
//! # Complexity
//! O(d log n) time per collapse, where d is the number of triangles around its points and their
//! neighbours, at most 256 counted for each. 24 bytes per entry of the queue. There are three valid
//! entries per triangle; invalid entries are removed when they are as numerous as the valid ones.

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
    /// The number of collapses applied before it was priced.
    priced: u32,
}

/// Invalid entries are not removed while the queue has fewer entries.
const MIN_ENTRIES: usize = 64;

impl QueuedCollapse {
    /// Returns whether neither point has changed since it was priced. `changed` has the number of
    /// the last collapse that changed each point.
    fn is_current(&self, changed: &[u32]) -> bool {
        [self.point, self.to].iter().all(|&p| changed[p as usize] <= self.priced)
    }

    /// Compares by the order in which collapses are taken.
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

/// The collapses of all pairs of neighbours, cheapest first.
#[derive(Debug)]
pub(crate) struct CollapseQueue {
    heap: BinaryHeap<Reverse<QueuedCollapse>>,
    /// For each point, the number of the last collapse that changed its triangles, from 1.
    changed: Vec<u32>,
    /// The number of applied collapses.
    done: u32,
    /// The number of entries above which invalid ones are removed.
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

    /// Removes and returns the cheapest collapse whose points have not changed.
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

    /// Prices the pairs of the points around an applied collapse.
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
                // If the other point is also around, it prices the other direction itself.
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

/// Returns the cost of a collapse in units of the frame: the sum of the quadrics of both points,
/// evaluated at the kept one.
fn cost_of(surface: &PricedSurface, point: u32, to: u32) -> f64 {
    let mut quadric = surface.quadrics[point as usize];
    quadric.add(&surface.quadrics[to as usize]);
    quadric.at(surface.positions[to as usize])
}
