//! Simplifies a mesh in passes: selects the next point and the neighbour that it collapses to, and
//! applies the collapse.
//!
//! # Algorithm
//! Every removable point has a cost: the cost of its best known collapse (module `price`). Points
//! are removed in passes:
//!
//! 1. The limit of a pass is the cost of the cheapest twelfth of the candidate points.
//! 2. All points are visited in the order of their indices. A point is priced if its cost is at
//!    most the limit and nothing near it has changed in this pass. A valid price from an earlier
//!    pass is reused. If the price is at most the limit, the point collapses: its corners move to
//!    the kept point, its triangles with that point are dropped, and its quadric is added to the
//!    quadric of the kept point. Otherwise the price becomes the cost of the point.
//! 3. The neighbours of a removed point keep their costs and are skipped until the next pass. The
//!    price is added to the cost of the kept point.
//!
//! The alternative is to take the cheapest point from a queue. Such a point can be anywhere in the
//! mesh, so its triangles, positions and quadrics must be fetched from memory each time. The data
//! of the next point in a pass is usually cached (module `curve`). The cheapest point is also often
//! a neighbour of the last one, whose price has just become invalid. A pass always runs to its end.
//! Its collapses are then sorted by price, each after the collapses that it depends on (module
//! `order`). The sequence is cut off where the target is reached.
//!
//! A collapse is refused if it would
//! - rotate a remaining triangle by more than about 75 degrees (`MIN_COSINE` of the module
//!   `neighbourhood`);
//! - change the topology (the link condition): all common neighbours of the two points must be
//!   corners of their common triangles, two inside the surface or one on a border. A border point
//!   moves only along the border. The module `irregular` handles points that are neither inner nor
//!   border points. Permissive simplification allows topology changes: holes can close and handles
//!   can vanish;
//! - remove the last triangle or tetrahedron of a component, unless the caller has given the error
//!   of its removal;
//! - open a seam: each vertex at the point needs a triangle with a vertex of the kept point, and
//!   all triangles of a vertex must lead to the same kept vertex;
//! - exceed the error limit, if there is one.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Dey,
//! Edelsbrunner, Guha, Nekhayev: *Topology Preserving Edge Contraction*, 1999 (the link condition).
//! Passes over independent collapses are known from parallel simplification. The price, and sorting
//! by price after a pass, were developed for this library. The module `queue` implements the
//! published algorithm, which has no passes.

mod merge_levels;

use super::ahead::{PricesAhead, least_estimates};
use super::queue::{CollapseQueue, QueuedCollapse};
use super::stopped::Stopped;
use crate::collapse::CollapseSequence;
use crate::ids::OptionalId;
use crate::mesh::{Positions, is_degenerate, triangles_of};
use crate::simplify::options::{Price, SimplifyOptions};
use crate::simplify::order::collapse_order::CollapseOrder;
use crate::simplify::price::attributes::PricedAttributes;
use crate::simplify::price::best_collapse::{BestCollapse, PricedCollapse, finite};
use crate::simplify::price::priced_surface::{PricedSurface, locked_points};
use crate::simplify::price::search::PriceSearch;
use crate::simplify::surface::outcome::{CollapseOutcome, MAX_CORNERS, Outcomes};
use crate::simplify::surface::topology::{PointKind, Topology};

/// The limit of a pass is the cost of the cheapest 1/12 of the candidates. From 1/6 to 1/12, the
/// mean distance over 37 models differs by one percent, and the time hardly differs.
const SHARE: usize = 12;
/// The limit of a pass is estimated from about this many costs.
const MAX_SAMPLES: usize = 1024;

/// The reason why a collapse is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CollapseRefusal {
    FoldOver,
    Topology,
    Seam,
}

/// A mesh during simplification.
#[derive(Debug)]
pub(crate) struct Decimation {
    surface: PricedSurface,
    locked: Vec<bool>,
    /// Whether any collapse may change the topology.
    may_break: bool,
    best_collapses: Vec<BestCollapse>,
    /// The points with a possible collapse, ascending. It can include points that lost theirs in
    /// the last pass.
    points: Vec<u32>,
    /// Points without a possible collapse to try again, because something changed around them.
    requeued: Vec<u32>,
    /// The number of the pass, from 1.
    pass: u32,
    order: CollapseOrder,
    /// The number of drawn triangles.
    triangle_count: usize,
    outcomes: Outcomes,
    search: PriceSearch,
    ahead: PricesAhead,
    /// The neighbours of the point that was last removed.
    around: Vec<u32>,
    dropped: Vec<u32>,
    /// The queued collapses, if they are applied one by one.
    queue: Option<CollapseQueue>,
}

impl Decimation {
    /// Connects the vertices of each point, computes the quadrics, and estimates all points.
    /// `priced` returns the attributes that have a price, given the triangles and the unit of the
    /// frame. `meshes` has the first vertex of each mesh if there are several.
    pub(crate) fn new<P: Positions + ?Sized>(
        positions: &P,
        attribute_bits: impl Fn(u32) -> Vec<u8>,
        vertices: &[u32],
        priced: impl FnOnce(&[u32], f64) -> Option<PricedAttributes>,
        options: &SimplifyOptions,
        meshes: &[u32],
    ) -> Self {
        let (may_break, weld_distance) = (options.may_break(), options.weld_distance);
        let topology = Topology::new(positions, attribute_bits, vertices, may_break, weld_distance);
        let topology = topology.with_meshes(meshes);
        let count = topology.point_count();
        let locked = locked_points(&topology, options);
        let surface = PricedSurface::new(topology, positions, |unit| priced(vertices, unit), options);
        let mut decimation = Self {
            triangle_count: triangles_of(vertices).filter(|&t| !is_degenerate(t)).count(),
            surface,
            locked,
            may_break,
            best_collapses: vec![BestCollapse::NONE; count],
            points: (0..count as u32).collect(),
            requeued: Vec::new(),
            pass: 0,
            order: CollapseOrder::new(count),
            outcomes: Outcomes::new(count),
            search: PriceSearch::default(),
            ahead: PricesAhead::default(),
            around: Vec::new(),
            dropped: Vec::new(),
            queue: None,
        };
        if options.price == Price::Quadric {
            decimation.queue = Some(CollapseQueue::new(&decimation.surface));
            return decimation;
        }
        let estimates = least_estimates(&decimation.surface, |point| decimation.is_removable(point));
        for (point, estimate) in (0..).zip(estimates) {
            decimation.set_estimate(point, estimate);
        }
        decimation
    }

    /// Applies collapses until at most `triangle_count` triangles remain or no collapse is
    /// possible. Returns whether the target was reached. The collapses are in the order in which
    /// they were found, and a pass can go beyond the target; [`Decimation::finish`] sorts them and
    /// removes the excess.
    pub(crate) fn run(&mut self, triangle_count: usize, sequence: &mut CollapseSequence) -> bool {
        if let Some(mut queue) = self.queue.take() {
            self.run_cheapest_first(&mut queue, triangle_count, sequence);
            self.queue = Some(queue);
        } else {
            self.run_passes(triangle_count, sequence);
        }
        self.triangle_count <= triangle_count
    }

    fn run_passes(&mut self, triangle_count: usize, sequence: &mut CollapseSequence) {
        let mut points = std::mem::take(&mut self.points);
        while self.triangle_count > triangle_count {
            if !self.requeued.is_empty() {
                points.append(&mut self.requeued);
                points.sort_unstable();
                points.dedup();
            }
            points.retain(|&point| self.best_collapses[point as usize].is_possible());
            let Some(limit) = self.pass_limit(&points) else { break };
            self.pass += 1;
            self.ahead.find(&self.surface, &self.best_collapses, &points, limit);
            for &point in &points {
                let known = &self.best_collapses[point as usize];
                if known.changed == self.pass || known.cost > limit {
                    continue;
                }
                if let Some(found) = self.ahead.of(point) {
                    self.set_price(point, found.best);
                }
                if let Some(collapse) = self.collapse_below(point, limit) {
                    self.surface.topology.neighbours(point, &mut self.around);
                    self.order.push(self.pass, collapse.cost, &self.around);
                    self.collapse(point, &collapse, sequence);
                }
            }
        }
        self.points = points;
    }

    /// Applies collapses, cheapest first, until at most `triangle_count` triangles remain or none
    /// is possible.
    fn run_cheapest_first(
        &mut self,
        queue: &mut CollapseQueue,
        triangle_count: usize,
        sequence: &mut CollapseSequence,
    ) {
        while self.triangle_count > triangle_count {
            let Some(QueuedCollapse { cost, point, to, .. }) = queue.next(&self.surface) else { break };
            let Some(error) = self.error_if_allowed(cost, point, to) else { continue };
            let collapse = PricedCollapse { to, cost: finite(cost), error: finite(error) };
            self.pass += 1;
            self.surface.topology.neighbours(point, &mut self.around);
            self.order.push(self.pass, collapse.cost, &self.around);
            self.apply(point, &collapse, sequence);
            queue.update(&self.surface, point, &self.around);
        }
    }

    /// Returns the error of a collapse if it is allowed. The error is the square root of its cost,
    /// an upper bound of the distance of the kept point from each plane.
    fn error_if_allowed(&mut self, cost: f64, point: u32, to: u32) -> Option<f64> {
        if !self.is_removable(point) {
            return None;
        }
        let Self { search, surface, .. } = self;
        search.collect_candidates(surface, point);
        if search.candidates.iter().all(|&(_, candidate)| candidate != to) {
            return None;
        }
        search.set_current(surface, point);
        if self.refusal(point, to).is_some() {
            return None;
        }
        let removal = match self.outcomes.of(&self.surface.topology, point, to) {
            CollapseOutcome::Keeps => 0.0,
            CollapseOutcome::Breaks if self.surface.is_permissive => 0.0,
            CollapseOutcome::Breaks | CollapseOutcome::Loses | CollapseOutcome::Ends => {
                self.surface.vanishing_error(point)
            }
        };
        let error = cost.sqrt().max(removal);
        (error <= self.surface.error_limit).then_some(error)
    }

    /// Sorts the collapses, and removes those after at most `triangle_count` triangles remain.
    /// Returns the maximum cost so far for each remaining collapse, in units of the frame.
    pub(crate) fn finish(self, triangle_count: usize, sequence: &mut CollapseSequence) -> Vec<f32> {
        self.order.apply(triangle_count, sequence)
    }

    /// Returns the maximum cost of a collapse, in the unit of [`Decimation::finish`].
    pub(crate) fn greatest_cost(&self) -> f32 {
        self.order.greatest()
    }

    /// Returns the unit of costs in the frame, in mesh units.
    pub(crate) fn cost_unit(&self) -> f64 {
        self.surface.price.cost_unit(self.surface.unit)
    }

    /// Returns the cost of the cheapest share of the points; `None` if there are no points.
    fn pass_limit(&self, points: &[u32]) -> Option<f32> {
        let samples = points.iter().step_by(points.len().div_ceil(MAX_SAMPLES).max(1));
        let mut costs: Vec<f32> = samples.map(|&p| self.best_collapses[p as usize].cost).collect();
        if costs.is_empty() {
            return None;
        }
        let nth = costs.len() / SHARE;
        Some(*costs.select_nth_unstable_by(nth, f32::total_cmp).1)
    }

    /// Returns why the remaining points cannot be removed, as counts per reason.
    pub(crate) fn stopped(&mut self) -> Stopped {
        let mut stopped = Stopped { triangle_count: self.triangle_count, ..Stopped::default() };
        for point in 0..self.surface.topology.point_count() as u32 {
            let topology = &self.surface.topology;
            if topology.ring(point).is_empty() {
                continue;
            }
            let reason = if self.locked[point as usize] {
                &mut stopped.locked
            } else if topology.kind(point) == PointKind::Degenerate {
                &mut stopped.non_manifold
            } else if topology.ring(point).len() > MAX_CORNERS {
                &mut stopped.topology
            } else {
                self.search.collect_candidates(&self.surface, point);
                self.search.set_current(&self.surface, point);
                let candidates = std::mem::take(&mut self.search.candidates);
                let refusals: Vec<_> = candidates.iter().map(|&(_, to)| self.refusal(point, to)).collect();
                self.search.candidates = candidates;
                let refusal = if refusals.contains(&None) { None } else { refusals[0] };
                match refusal {
                    Some(CollapseRefusal::FoldOver) => &mut stopped.fold_over,
                    Some(CollapseRefusal::Seam) => &mut stopped.seam,
                    Some(CollapseRefusal::Topology)
                        if self.surface.topology.kind(point) == PointKind::Irregular =>
                    {
                        &mut stopped.non_manifold
                    }
                    Some(CollapseRefusal::Topology) => &mut stopped.topology,
                    // Only the error limit prevents it.
                    None => &mut stopped.error,
                }
            };
            *reason += 1;
        }
        stopped
    }

    /// Returns whether a point may be removed at all.
    fn is_removable(&self, point: u32) -> bool {
        let ring = self.surface.topology.ring(point);
        !self.locked[point as usize]
            && self.surface.topology.kind(point) != PointKind::Degenerate
            && !ring.is_empty()
            && ring.len() <= MAX_CORNERS
    }

    /// Estimates the cost of a point, if it may be removed.
    fn estimate(&mut self, point: u32) {
        let is_removable = self.is_removable(point);
        let least = is_removable.then(|| self.search.least_estimate(&self.surface, point)).flatten();
        self.set_estimate(point, least);
    }

    /// Sets the cost of a point to the price predicted from its smallest estimate. Without an
    /// estimate, no collapse is possible.
    fn set_estimate(&mut self, point: u32, estimate: Option<f64>) {
        match estimate {
            None => self.set_price(point, None),
            Some(estimate) => self.set_cost(point, self.surface.price.expected(estimate)),
        }
    }

    /// Sets a cost that is not a price.
    fn set_cost(&mut self, point: u32, cost: f64) {
        let known = &mut self.best_collapses[point as usize];
        (known.cost, known.target) = (finite(cost), OptionalId::NONE);
    }

    /// Sets the best collapse of a point. Without one, the point is skipped until something changes
    /// around it.
    fn set_price(&mut self, point: u32, best: Option<PricedCollapse>) {
        self.best_collapses[point as usize].set_price(best);
    }

    /// Returns the collapse of a point if its price is still valid.
    fn priced(&mut self, point: u32) -> Option<PricedCollapse> {
        let BestCollapse { cost, target, error, .. } = self.best_collapses[point as usize];
        let to = target.get()?;
        // Something may have changed around the other point. The end of a component is priced
        // differently.
        let is_as_priced = match self.outcomes.of(&self.surface.topology, point, to) {
            CollapseOutcome::Keeps => true,
            CollapseOutcome::Breaks => self.surface.is_permissive,
            CollapseOutcome::Loses | CollapseOutcome::Ends => false,
        };
        is_as_priced.then_some(PricedCollapse { to, cost, error })
    }

    /// Prices a point, and stores and returns its best collapse.
    fn price(&mut self, point: u32) -> Option<PricedCollapse> {
        let Self { surface, outcomes, search, .. } = self;
        let best = search.best(surface, point, |to| outcomes.of(&surface.topology, point, to));
        self.set_price(point, best);
        best
    }

    /// Returns the best collapse of a point if its price is at most the limit. If its triangles
    /// would be too far from the full mesh, the next best one is tried.
    fn collapse_below(&mut self, point: u32, limit: f32) -> Option<PricedCollapse> {
        let mut best = self.priced(point).or_else(|| self.price(point));
        while let Some(collapse) = best.filter(|collapse| collapse.cost <= limit) {
            if self.surface.stays_near(point, collapse.to, &mut self.search.current) {
                self.search.refused.clear();
                return Some(collapse);
            }
            self.search.refused.push(collapse.to);
            best = self.price(point);
        }
        self.search.refused.clear();
        None
    }

    /// Applies the collapse of a point whose neighbours are in `around`, and defers them to the
    /// next pass.
    fn collapse(&mut self, point: u32, collapse: &PricedCollapse, sequence: &mut CollapseSequence) {
        self.apply(point, collapse, sequence);
        let around = std::mem::take(&mut self.around);
        self.set_price(point, None);
        for &p in &around {
            let known = &mut self.best_collapses[p as usize];
            (known.changed, known.target) = (self.pass, OptionalId::NONE);
            if !known.is_possible() {
                self.estimate(p);
                self.requeued.push(p);
            } else if p == collapse.to {
                let cost = f64::from(known.cost) + f64::from(collapse.cost);
                self.set_cost(p, cost);
            }
        }
        self.around = around;
    }

    /// Applies the collapse of a point whose neighbours are in `around` to the surface, and records
    /// it.
    fn apply(&mut self, point: u32, collapse: &PricedCollapse, sequence: &mut CollapseSequence) {
        let to = collapse.to;
        let is_open = self.surface.keeps_seams(point, to, &mut self.search.renames);
        debug_assert!(is_open);
        let is_irregular = |p: u32| self.surface.topology.kind(p) == PointKind::Irregular;
        let changes_kinds = self.may_break || is_irregular(point) || is_irregular(to);
        self.surface.collapse(point, to, &self.search.renames, &mut self.dropped);
        if changes_kinds {
            self.surface.topology.classify(&self.around, MAX_CORNERS);
        }
        let error = finite(f64::from(collapse.error) * self.surface.unit);
        sequence.push(&self.search.renames, &self.dropped, error);
        self.triangle_count -= self.dropped.len();
    }

    /// Returns the first reason why the collapse of the current point is refused.
    fn refusal(&mut self, point: u32, to: u32) -> Option<CollapseRefusal> {
        if self.search.current.folds_over(to, self.surface.positions[to as usize]) {
            return Some(CollapseRefusal::FoldOver);
        }
        if !self.is_allowed(point, to) {
            return Some(CollapseRefusal::Topology);
        }
        if !self.surface.keeps_seams(point, to, &mut self.search.renames) {
            return Some(CollapseRefusal::Seam);
        }
        None
    }

    /// Returns whether a collapse preserves the topology of the surface, or removes a component
    /// that may vanish.
    fn is_allowed(&mut self, point: u32, to: u32) -> bool {
        match self.outcomes.of(&self.surface.topology, point, to) {
            CollapseOutcome::Keeps => true,
            CollapseOutcome::Breaks if self.surface.is_permissive => true,
            CollapseOutcome::Breaks | CollapseOutcome::Loses | CollapseOutcome::Ends => {
                self.surface.vanishing_error(point).is_finite()
            }
        }
    }
}

#[cfg(test)]
mod tests;
