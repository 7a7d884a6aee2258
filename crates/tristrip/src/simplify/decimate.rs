//! The choice of the collapses: the next vertex, the neighbour that it goes to, and the resulting changes.
//!
//! # Algorithm
//! Every point that may be removed waits with a cost, that of its best collapse as far as known (module `price`). Points are removed in passes:
//!
//! 1. The limit of a pass is the cost of the cheapest twelfth of the points that wait.
//! 2. All points are visited in their order. One whose cost is at most the limit, and near which nothing has changed in this pass, is priced,
//!    unless its last price still holds. If its price is at most the limit it collapses: its corners move to the kept
//!    point, its triangles with that point are dropped, its quadric is added to that of the kept point. Otherwise it waits with that price.
//! 3. The neighbours of a point that was removed keep their costs, and wait for the next pass; the kept point adds the price to its own.
//!
//! The next cheapest point of all could be taken instead, from a queue. It would lie anywhere in the mesh: its triangles, positions and quadrics
//! would come from memory each time, where those of the next point in a pass are at hand (module `curve`); and it would often be a
//! neighbour of the last one, whose price has just become void. A pass is always done to its end, and its collapses are sorted by price then, each
//! after those that it depends on (module `order`); they are cut off where the goal is reached.
//!
//! A collapse is refused if it would
//! - rotate a remaining triangle by more than about 75 degrees (`LEAST_COSINE` of the module `neighbourhood`);
//! - change the topology (the link condition): the two points must have no common neighbours except those of their common triangles, two or,
//!   on a border, one; a border point moves only along the border. For points that are neither inner ones nor on a border see the
//!   module `irregular`. Permissive simplification allows it: holes may close, handles vanish;
//! - remove the last triangle or tetrahedron of a component, unless the caller has stated the error of that;
//! - open a seam: each vertex at the point needs a triangle with the kept point, and they must agree;
//! - exceed the error limit, if there is one.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997. Dey, Edelsbrunner, Guha, Nekhayev: *Topology
//! Preserving Edge Contraction*, 1999 (the link condition). Passes over collapses that do not touch each other are known from parallel
//! simplification; the order by price afterwards, and the price, are our own.

use super::attribute_quadrics::AttributeQuadrics;
use super::attributes::PricedAttributes;
use super::frame::{frame, quadrics};
use super::neighbourhood::Neighbourhood;
use super::options::{Price, SimplifyOptions};
use super::order::CollapseOrder;
use super::outcome::{MOST_CORNERS, Outcome, Outcomes};
use super::quadric::Quadric;
use super::removed_points::RemovedPoints;
use super::stopped::Stopped;
use super::topology::{PointKind, Topology};
use super::waiting::{PricedCollapse, Waiting, finite};
use crate::collapse::{CollapseSequence, Rename};
use crate::ids::OptionalId;
use crate::mesh::{Positions, is_degenerate, triangles_of};
use crate::vector::Point;

/// One in so many of the points that wait are below the limit of a pass. From one in 6 to one in 12 the mean of the distances over 37 models
/// differs by one percent, and the time hardly.
const SHARE: usize = 12;
/// The limit of a pass is found among about so many of the costs.
const MOST_SAMPLES: usize = 1024;

/// The reason for which a collapse is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refusal {
    FoldOver,
    Topology,
    Seam,
}

/// A mesh while it is simplified.
#[derive(Debug)]
pub(super) struct Decimation {
    pub(super) topology: Topology,
    pub(super) positions: Vec<Point>,
    /// The unit of the local frame, in mesh units.
    unit: f64,
    pub(super) quadrics: Vec<Quadric>,
    pub(super) attributes: Option<AttributeQuadrics>,
    locked: Vec<bool>,
    /// The error of the removal of each point's component, in units of the frame; empty if all components stay.
    vanishing: Vec<f32>,
    pub(super) is_permissive: bool,
    /// Whether any collapse may change the topology.
    may_break: bool,
    pub(super) waiting: Vec<Waiting>,
    /// What a collapse costs.
    pub(super) price: Price,
    /// The points that wait, ascending, with others that did so until the last pass.
    points: Vec<u32>,
    /// Points for which no collapse was possible, and which wait again since something changed around them.
    revived: Vec<u32>,
    /// The number of the pass, from 1.
    pass: u32,
    order: CollapseOrder,
    /// Triangles that are drawn.
    triangle_count: usize,
    /// The largest error allowed, in units of the frame.
    pub(super) error_limit: f64,
    pub(super) outcomes: Outcomes,
    /// The removed points, if the price needs them.
    pub(super) removed: Option<RemovedPoints>,
    /// The triangles of the current point.
    pub(super) current: Neighbourhood,
    pub(super) neighbours: Vec<u32>,
    /// The neighbours of the point that was just removed.
    around: Vec<u32>,
    /// The neighbours that the current point may go to, with their estimates.
    pub(super) candidates: Vec<(f64, u32)>,
    pub(super) renames: Vec<Rename>,
    dropped: Vec<u32>,
}

impl Decimation {
    /// Connects the vertices of each point, computes the quadrics, and estimates all points. `priced` returns the attributes
    /// that have a price, given the triangles and the unit of the frame; `meshes` are the first vertices of the meshes if there are several.
    pub(super) fn new<P: Positions + ?Sized>(
        positions: &P,
        attribute_bits: impl Fn(u32) -> Vec<u8>,
        vertices: &[u32],
        priced: impl FnOnce(&[u32], f64) -> Option<PricedAttributes>,
        options: &SimplifyOptions,
        meshes: &[u32],
    ) -> Self {
        let topology =
            Topology::new(positions, attribute_bits, vertices, options.may_break()).with_meshes(meshes);
        let count = topology.point_count();
        let is_locked = locked_points(&topology, options);
        let position = |p| positions.position(topology.vertex_of(p) as usize).unwrap_or_default();
        let (framed, unit) = frame((0..count as u32).map(position));
        let attributes =
            priced(vertices, unit).map(|values| AttributeQuadrics::new(&topology, &framed, values));
        let vanishing = match options.vanishing() {
            [] => Vec::new(),
            errors => {
                (0..count as u32).map(|p| vanishing_error(errors, topology.vertex_of(p), unit)).collect()
            }
        };
        let quadrics = quadrics(&topology, &framed, attributes.is_some());
        let removed = (options.price() == Price::Distance).then(|| {
            let areas = quadrics.iter().map(|quadric| quadric.weight / 3.0);
            RemovedPoints::new(topology.triangles.len(), framed.iter().copied().zip(areas))
        });
        let mut decimation = Self {
            triangle_count: triangles_of(vertices).filter(|&t| !is_degenerate(t)).count(),
            topology,
            positions: framed,
            unit,
            quadrics,
            attributes,
            locked: is_locked,
            vanishing,
            is_permissive: options.is_permissive(),
            may_break: options.may_break(),
            waiting: vec![Waiting::NOT; count],
            price: options.price(),
            points: (0..count as u32).collect(),
            revived: Vec::new(),
            pass: 0,
            order: CollapseOrder::new(count),
            error_limit: options.error().map_or(f64::INFINITY, |error| f64::from(error) / unit),
            outcomes: Outcomes::new(count),
            removed,
            current: Neighbourhood::default(),
            neighbours: Vec::new(),
            around: Vec::new(),
            candidates: Vec::new(),
            renames: Vec::new(),
            dropped: Vec::new(),
        };
        (0..count as u32).for_each(|point| decimation.estimate(point));
        decimation
    }

    /// Does passes until there are at most `triangle_count` triangles, or no collapse is possible; returns whether there are. The collapses
    /// come in the order in which they were found, the last ones of a pass beyond the number, until [`Decimation::finish`] puts them in order.
    pub(super) fn run(&mut self, triangle_count: usize, sequence: &mut CollapseSequence) -> bool {
        let mut points = std::mem::take(&mut self.points);
        while self.triangle_count > triangle_count {
            if !self.revived.is_empty() {
                points.append(&mut self.revived);
                points.sort_unstable();
                points.dedup();
            }
            points.retain(|&point| self.waiting[point as usize].waits());
            let Some(limit) = self.pass_limit(&points) else { break };
            self.pass += 1;
            for &point in &points {
                let waiting = &self.waiting[point as usize];
                if waiting.changed == self.pass || waiting.cost > limit {
                    continue;
                }
                let priced = self.priced(point).or_else(|| self.price(point));
                if let Some(collapse) = priced.filter(|collapse| collapse.cost <= limit) {
                    self.topology.neighbours(point, &mut self.around);
                    self.order.push(self.pass, collapse.cost, &self.around);
                    self.collapse(point, &collapse, sequence);
                }
            }
        }
        self.points = points;
        self.triangle_count <= triangle_count
    }

    /// Puts the collapses in order, and removes those after at most `triangle_count` triangles. Returns the greatest cost so far of each that is
    /// left, in units of the frame to the third power.
    pub(super) fn finish(self, triangle_count: usize, sequence: &mut CollapseSequence) -> Vec<f32> {
        self.order.apply(triangle_count, sequence)
    }

    /// Returns the greatest cost of a collapse, as [`Decimation::finish`] does.
    pub(super) fn greatest_cost(&self) -> f32 {
        self.order.greatest()
    }

    /// Returns the unit of the frame, in mesh units.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// Returns the cost below which a share of the points wait; `None` without any points.
    fn pass_limit(&self, points: &[u32]) -> Option<f32> {
        let samples = points.iter().step_by(points.len().div_ceil(MOST_SAMPLES).max(1));
        let mut costs: Vec<f32> = samples.map(|&p| self.waiting[p as usize].cost).collect();
        if costs.is_empty() {
            return None;
        }
        let nth = costs.len() / SHARE;
        Some(*costs.select_nth_unstable_by(nth, f32::total_cmp).1)
    }

    /// Counts the reasons for which the remaining points cannot be removed.
    pub(super) fn stopped(&mut self) -> Stopped {
        let mut stopped = Stopped { triangle_count: self.triangle_count, ..Stopped::default() };
        for point in 0..self.topology.point_count() as u32 {
            if self.topology.ring(point).is_empty() {
                continue;
            }
            let reason = if self.locked[point as usize] {
                &mut stopped.locked
            } else if self.topology.kind(point) == PointKind::Degenerate {
                &mut stopped.non_manifold
            } else if self.topology.ring(point).len() > MOST_CORNERS {
                &mut stopped.topology
            } else {
                self.collect_candidates(point);
                self.set_current(point);
                let candidates = std::mem::take(&mut self.candidates);
                let refusals: Vec<_> = candidates.iter().map(|&(_, to)| self.refusal(point, to)).collect();
                self.candidates = candidates;
                let refusal = if refusals.contains(&None) { None } else { refusals[0] };
                match refusal {
                    Some(Refusal::FoldOver) => &mut stopped.fold_over,
                    Some(Refusal::Seam) => &mut stopped.seam,
                    Some(Refusal::Topology) if self.topology.kind(point) == PointKind::Irregular => {
                        &mut stopped.non_manifold
                    }
                    Some(Refusal::Topology) => &mut stopped.topology,
                    // Only the error limit holds it.
                    None => &mut stopped.error,
                }
            };
            *reason += 1;
        }
        stopped
    }

    /// Checks whether a point may be removed at all.
    fn is_removable(&self, point: u32) -> bool {
        let ring = self.topology.ring(point);
        !self.locked[point as usize]
            && self.topology.kind(point) != PointKind::Degenerate
            && !ring.is_empty()
            && ring.len() <= MOST_CORNERS
    }

    /// Estimates the cost of a point, if it may be removed.
    fn estimate(&mut self, point: u32) {
        self.give_up(point);
        if self.is_removable(point) {
            self.collect_candidates(point);
            if let Some(least) = self.candidates.iter().map(|&(estimate, _)| estimate).min_by(f64::total_cmp)
            {
                self.wait(point, self.price.expected(least));
            }
        }
    }

    /// Lets a point wait with a cost that is no price.
    fn wait(&mut self, point: u32, cost: f64) {
        let waiting = &mut self.waiting[point as usize];
        (waiting.cost, waiting.target) = (finite(cost), OptionalId::NONE);
    }

    /// Lets a point wait no longer, as no collapse is possible until something changes around it.
    pub(super) fn give_up(&mut self, point: u32) {
        let waiting = &mut self.waiting[point as usize];
        (waiting.cost, waiting.target) = (f32::INFINITY, OptionalId::NONE);
    }

    /// Does the collapse of a point, whose neighbours are known.
    fn collapse(&mut self, point: u32, collapse: &PricedCollapse, sequence: &mut CollapseSequence) {
        let to = collapse.to;
        let is_open = self.keeps_seams(point, to);
        debug_assert!(is_open);
        let (renames, mut dropped) = (std::mem::take(&mut self.renames), std::mem::take(&mut self.dropped));
        let around = std::mem::take(&mut self.around);
        let is_irregular = |p: u32| self.topology.kind(p) == PointKind::Irregular;
        let changes_kinds = self.may_break || is_irregular(point) || is_irregular(to);
        if let Some(removed) = &mut self.removed {
            removed.collapse(&self.topology, point, to);
        }
        self.topology.collapse(point, to, &renames, &mut dropped);
        if changes_kinds {
            self.topology.classify(&around, MOST_CORNERS);
        }
        sequence.push(&renames, &dropped, finite(f64::from(collapse.error) * self.unit));
        self.triangle_count -= dropped.len();
        let quadric = self.quadrics[point as usize];
        self.quadrics[to as usize].add(&quadric);
        if let Some(attributes) = &mut self.attributes {
            attributes.merge(&renames);
        }
        (self.renames, self.dropped) = (renames, dropped);

        self.give_up(point);
        for &p in &around {
            let waiting = &mut self.waiting[p as usize];
            (waiting.changed, waiting.target) = (self.pass, OptionalId::NONE);
            if !waiting.waits() {
                self.estimate(p);
                self.revived.push(p);
            } else if p == to {
                let cost = f64::from(waiting.cost) + f64::from(collapse.cost);
                self.wait(p, cost);
            }
        }
        self.around = around;
    }

    /// Returns the first reason for which the collapse of the current point is refused.
    fn refusal(&mut self, point: u32, to: u32) -> Option<Refusal> {
        if self.current.folds_over(to, self.positions[to as usize]) {
            return Some(Refusal::FoldOver);
        }
        if !self.is_allowed(point, to) {
            return Some(Refusal::Topology);
        }
        if !self.keeps_seams(point, to) {
            return Some(Refusal::Seam);
        }
        None
    }

    /// Collects the renames of a collapse; returns whether it keeps the seams closed, or may move them.
    pub(super) fn keeps_seams(&mut self, point: u32, to: u32) -> bool {
        if self.topology.renames(point, to, &mut self.renames).is_some() {
            return true;
        }
        let attributes = self.attributes.as_ref();
        let difference = |a: u32, b: u32| attributes.map_or(0.0, |attributes| attributes.difference(a, b));
        self.is_permissive && self.topology.renames_across(point, to, &mut self.renames, difference).is_some()
    }

    /// Checks whether a collapse keeps the topology of the surface, or removes a component that may vanish.
    fn is_allowed(&mut self, point: u32, to: u32) -> bool {
        match self.outcomes.of(&self.topology, point, to) {
            Outcome::Keeps => true,
            Outcome::Breaks if self.is_permissive => true,
            Outcome::Breaks | Outcome::Loses | Outcome::Ends => self.vanishing_error(point).is_finite(),
        }
    }

    /// Returns the error of the removal of a point's component, in units of the frame; infinite if it stays.
    pub(super) fn vanishing_error(&self, point: u32) -> f64 {
        self.vanishing.get(point as usize).copied().unwrap_or(f32::INFINITY).into()
    }
}

/// Returns which points are locked: those of locked vertices, and those on borders if borders are locked.
fn locked_points(topology: &Topology, options: &SimplifyOptions) -> Vec<bool> {
    let mut is_locked = vec![false; topology.point_count()];
    let locked = options.locked();
    if !locked.is_empty() {
        for corner in topology.corners() {
            is_locked[topology.point(corner) as usize] |=
                locked.get(topology.wedge(corner) as usize).copied().unwrap_or(false);
        }
    }
    if options.locks_borders() {
        for (corner, _) in topology.open_edges().filter(|&(_, is_border)| is_border) {
            let [to, _] = topology.others(corner);
            [topology.point(corner), to].iter().for_each(|&p| is_locked[p as usize] = true);
        }
    }
    is_locked
}

/// Returns the error of the removal of a vertex's component in units of the frame; infinite if it stays.
fn vanishing_error(errors: &[f32], vertex: u32, unit: f64) -> f32 {
    let error = errors.get(vertex as usize).copied().filter(|error| *error >= 0.0);
    error.map_or(f32::INFINITY, |error| (f64::from(error) / unit) as f32)
}
