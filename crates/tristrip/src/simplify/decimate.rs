//! The choice of the collapses: the next vertex, the neighbour that it goes to, and the resulting changes.
//!
//! # Algorithm
//! Every point that may be removed waits in a queue, by the cost of its best collapse. There are two costs:
//! - the *estimate*: the point's quadric at the neighbour that would replace it. It takes one evaluation per neighbour, and is a lower
//!   bound of the other;
//! - the *price*: the estimate plus squared distances between the old and the new triangles, weighted like the quadric: of the point from
//!   the triangles that would replace its own, and of the middles of the edges that these would have from its own triangles. The quadric knows
//!   only planes; the price detects that an edge would run across a ridge, or bridge a valley. The quadrics of the attributes are added,
//!   if there are any (module `attribute_quadrics`).
//!
//! Both are divided by the square root of the weight of the point, the area that it represents: by area alone thin parts would vanish first,
//! since they have none, and by distance alone a small part would cost as much as a large one.
//!
//! 1. Take the cheapest point. If its neighbourhood has changed since it was priced, price it: its neighbours by ascending estimate,
//!    until the estimate alone exceeds the best price; collapses that are refused are left out. Reinsert it and start over.
//! 2. Otherwise collapse it: its corners move to the kept point, its triangles with that point are dropped, its quadric is added to that
//!    of the kept point.
//! 3. Estimate the kept point again. Its new neighbours only compare: they wait at the minimum of their cost and the estimate for the
//!    kept point, and are priced when they are the cheapest.
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
//! Preserving Edge Contraction*, 1999 (the link condition). The price is our own: docs/levels.md compares the distances between the surfaces
//! with those of meshoptimizer.

use super::attribute_quadrics::AttributeQuadrics;
use super::attributes::PricedAttributes;
use super::frame::{frame, quadrics};
use super::neighbourhood::Neighbourhood;
use super::options::SimplifyOptions;
use super::outcome::{MOST_CORNERS, Outcome, Outcomes};
use super::quadric::Quadric;
use super::queue::CostQueue;
use super::stopped::Stopped;
use super::topology::{PointKind, Topology};
use crate::collapse::{CollapseSequence, Rename};
use crate::ids::OptionalId;
use crate::mesh::{Positions, is_degenerate, triangles_of};
use crate::vector::{Point, dot, sub};

/// The weight of the squared distance to the new triangles relative to the quadric. From 1 to 3 made little difference on bunny, horse and
/// armadillo; 0.3 and 10 were worse.
const DISTANCE_WEIGHT: f64 = 2.0;
/// The weight of the squared distance of the new edges. Over 13 models 1 gave a larger mean distance; 4 was as good, and slower.
const BRIDGE_WEIGHT: f64 = 2.0;
/// The weight of the squared edge length, relative to the quadric. If all neighbours cost the same, as on a plane, points of little weight
/// go to near ones, and no point is passed on along a chain, which would rename the same corners repeatedly.
const LENGTH_WEIGHT: f64 = 1e-6;

/// The reason for which a collapse is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refusal {
    FoldOver,
    Topology,
    Seam,
}

/// The price of a collapse.
#[derive(Debug, Clone, Copy)]
struct CollapsePrice {
    cost: f64,
    /// The distance between the surfaces, in units of the frame.
    error: f64,
}

/// The best collapse of a point, as far as known. Times are numbers of collapses.
#[derive(Debug, Clone, Copy)]
struct CollapsePlan {
    /// The point that it would go to.
    target: OptionalId,
    /// The error, in mesh units, after pricing.
    error: f32,
    /// The time of the pricing.
    priced: u32,
    /// The time of the last change of the neighbourhood.
    changed: u32,
}

/// A mesh while it is simplified.
pub(super) struct Decimation {
    topology: Topology,
    positions: Vec<Point>,
    /// The unit of the local frame, in mesh units.
    unit: f64,
    quadrics: Vec<Quadric>,
    attributes: Option<AttributeQuadrics>,
    locked: Vec<bool>,
    /// The error of the removal of each point's component, in units of the frame; empty if all components stay.
    vanishing: Vec<f32>,
    is_permissive: bool,
    /// Whether any collapse may change the topology.
    may_break: bool,
    queue: CostQueue,
    plans: Vec<CollapsePlan>,
    now: u32,
    /// Triangles that are drawn.
    triangle_count: usize,
    /// The largest error allowed, in units of the frame.
    error_limit: f64,
    outcomes: Outcomes,
    /// The triangles of the current point.
    current: Neighbourhood,
    neighbours: Vec<u32>,
    /// The neighbours of the point that was just removed.
    around: Vec<u32>,
    /// The neighbours that the current point may go to, with their estimates.
    candidates: Vec<(f64, u32)>,
    renames: Vec<Rename>,
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
        let is_locked = locked_points(&topology, vertices, options);
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
            queue: CostQueue::new(count),
            plans: vec![CollapsePlan { target: OptionalId::NONE, error: 0.0, priced: 0, changed: 1 }; count],
            now: 1,
            error_limit: options.error().map_or(f64::INFINITY, |error| f64::from(error) / unit),
            outcomes: Outcomes::new(count),
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

    /// Collapses until there are at most `triangle_count` triangles, or no collapse is possible.
    pub(super) fn run(&mut self, triangle_count: usize, sequence: &mut CollapseSequence) {
        while self.triangle_count > triangle_count {
            let Some(point) = self.queue.first() else { break };
            match self.priced_target(point) {
                Some(to) => self.collapse(point, to, sequence),
                None => self.price(point),
            }
        }
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

    /// Makes a point the current one.
    fn set_current(&mut self, point: u32) {
        self.current.collect(&self.topology, &self.positions, point);
    }

    /// Collects the neighbours that a point may go to, with their estimates: for a border point those along the border.
    fn collect_candidates(&mut self, point: u32) {
        match self.topology.kind(point) {
            PointKind::Irregular => {
                self.outcomes.irregular_neighbours(&self.topology, point, &mut self.neighbours)
            }
            _ => self.topology.neighbours(point, &mut self.neighbours),
        }
        let first = match self.topology.kind(point) {
            PointKind::Border => self.neighbours.len().saturating_sub(2),
            _ => 0,
        };
        let (quadric, from) = (&self.quadrics[point as usize], self.positions[point as usize]);
        let estimate = |&to: &u32| (estimate_of(quadric, from, self.positions[to as usize]), to);
        self.candidates.clear();
        self.candidates.extend(self.neighbours[first..].iter().map(estimate));
    }

    /// Inserts a point into the queue by the estimate of its best collapse.
    fn estimate(&mut self, point: u32) {
        if !self.is_removable(point) {
            self.plans[point as usize].target = OptionalId::NONE;
            self.queue.remove(point);
            return;
        }
        self.collect_candidates(point);
        let least = self.candidates.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        if let Some((cost, to)) = least {
            self.plans[point as usize].target = OptionalId::some(to);
            self.queue.set(point, cost as f32);
        }
    }

    /// Prices the collapses of a point, and inserts it into the queue by the best, or removes it if none is possible.
    fn price(&mut self, point: u32) {
        self.collect_candidates(point);
        self.set_current(point);
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut best: Option<(CollapsePrice, u32)> = None;
        for &(estimate, to) in &candidates {
            let is_better = |cost: f64| best.is_none_or(|(best, _)| cost < best.cost);
            if !is_better(estimate) {
                break;
            }
            let kept = self.positions[to as usize];
            let mut price = self.price_of(point, to, estimate);
            if !is_better(price.cost) || price.error > self.error_limit || self.current.folds_over(to, kept) {
                continue;
            }
            let weight = share_of(self.quadrics[point as usize].weight);
            if self.attributes.is_some() {
                let Some(change) = self.attribute_change(point, to) else { continue };
                price.cost += if weight > 0.0 { change / weight } else { change };
                if !is_better(price.cost) {
                    continue;
                }
            }
            let most =
                best.map_or(f64::INFINITY, |(best, _)| (best.cost - price.cost) / (BRIDGE_WEIGHT * weight));
            let bridge = self.current.bridge(to, kept, most);
            price.cost += BRIDGE_WEIGHT * weight * bridge;
            price.error = price.error.max(bridge.sqrt());
            if !is_better(price.cost) || price.error > self.error_limit {
                continue;
            }
            match self.outcomes.of(&self.topology, point, to) {
                Outcome::Keeps => {}
                Outcome::Breaks if self.is_permissive => {}
                // A component that may vanish may also break on the way.
                Outcome::Breaks | Outcome::Loses | Outcome::Ends => {
                    let error = self.vanishing_error(point);
                    if error.is_infinite() {
                        continue;
                    }
                    price.cost += DISTANCE_WEIGHT * weight * error * error;
                    price.error = price.error.max(error);
                }
            }
            if is_better(price.cost) && price.error <= self.error_limit && self.keeps_seams(point, to) {
                best = Some((price, to));
            }
        }
        self.candidates = candidates;
        if let Some((price, to)) = best {
            let plan = &mut self.plans[point as usize];
            (plan.target, plan.error, plan.priced) =
                (OptionalId::some(to), (price.error * self.unit).min(f64::from(f32::MAX)) as f32, self.now);
            self.queue.set(point, price.cost as f32);
        } else {
            self.plans[point as usize].target = OptionalId::NONE;
            self.queue.remove(point);
        }
    }

    /// Returns the price of a collapse of the current point, without its new edges and attributes: its estimate plus the distance to the triangles
    /// around the kept point.
    fn price_of(&mut self, point: u32, to: u32, estimate: f64) -> CollapsePrice {
        let kept = self.positions[to as usize];
        let square = self.current.distance(to, kept);
        let quadric = &self.quadrics[point as usize];
        let mean = if quadric.whole_weight > 0.0 { quadric.at(kept) / quadric.whole_weight } else { 0.0 };
        let cost = estimate + DISTANCE_WEIGHT * share_of(quadric.weight) * square;
        CollapsePrice { cost, error: mean.max(square).sqrt() }
    }

    /// Returns the sum of the squared deviations of the attributes if a point goes to a neighbour; `None` if a seam would open.
    fn attribute_change(&mut self, point: u32, to: u32) -> Option<f64> {
        if !self.keeps_seams(point, to) {
            return None;
        }
        let attributes = self.attributes.as_ref()?;
        Some(attributes.change(&self.renames, self.positions[to as usize]))
    }

    /// Returns the target of a point whose price is still valid.
    fn priced_target(&mut self, point: u32) -> Option<u32> {
        let CollapsePlan { target, priced, changed, .. } = self.plans[point as usize];
        let target = target.get().filter(|_| priced >= changed)?;
        // The end of a component has a price of its own.
        let is_permissive = self.is_permissive;
        let is_as_priced = |outcome| outcome == Outcome::Keeps || is_permissive && outcome == Outcome::Breaks;
        let is_valid = priced >= self.plans[target as usize].changed
            || is_as_priced(self.outcomes.of(&self.topology, point, target));
        is_valid.then_some(target)
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
    fn keeps_seams(&mut self, point: u32, to: u32) -> bool {
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
    fn vanishing_error(&self, point: u32) -> f64 {
        self.vanishing.get(point as usize).copied().unwrap_or(f32::INFINITY).into()
    }

    /// Does the collapse of a point to a neighbour, and updates the queue.
    fn collapse(&mut self, point: u32, to: u32, sequence: &mut CollapseSequence) {
        let is_open = self.keeps_seams(point, to);
        debug_assert!(is_open);
        let (renames, mut dropped) = (std::mem::take(&mut self.renames), std::mem::take(&mut self.dropped));
        let mut around = std::mem::take(&mut self.around);
        self.topology.neighbours(point, &mut around);
        let is_irregular = |p: u32| self.topology.kind(p) == PointKind::Irregular;
        let changes_kinds = self.may_break || is_irregular(point) || is_irregular(to);
        self.topology.collapse(point, to, &renames, &mut dropped);
        if changes_kinds {
            self.topology.classify(&around);
        }
        sequence.push(&renames, &dropped, self.plans[point as usize].error);
        self.triangle_count -= dropped.len();
        self.queue.remove(point);
        let quadric = self.quadrics[point as usize];
        self.quadrics[to as usize].add(&quadric);
        if let Some(attributes) = &mut self.attributes {
            attributes.merge(&renames);
        }
        (self.renames, self.dropped) = (renames, dropped);

        self.now += 1;
        for &p in &around {
            self.plans[p as usize].changed = self.now;
        }
        self.estimate(to);
        for &p in &around {
            if p != to {
                self.consider_target(p, to);
            }
        }
        self.around = around;
    }

    /// Lowers the cost of a point to the estimate for its new neighbour, if that is less.
    fn consider_target(&mut self, point: u32, kept: u32) {
        let Some(cost) = self.queue.cost(point) else { return self.estimate(point) };
        if self.topology.kind(point) == PointKind::Border && self.topology.kind(kept) != PointKind::Border {
            return;
        }
        let [from, to] = [point, kept].map(|p| self.positions[p as usize]);
        let other = estimate_of(&self.quadrics[point as usize], from, to) as f32;
        if other < cost {
            self.plans[point as usize].target = OptionalId::some(kept);
            self.queue.set(point, other);
        }
    }
}

/// Returns the estimate of a collapse between two positions.
#[inline]
fn estimate_of(quadric: &Quadric, from: Point, to: Point) -> f64 {
    let edge = sub(to, from);
    let sum = quadric.at(to) + LENGTH_WEIGHT * quadric.weight * dot(edge, edge);
    if quadric.weight > 0.0 { sum / quadric.weight.sqrt() } else { sum }
}

/// Returns the part of a weight that counts: its square root.
fn share_of(weight: f64) -> f64 {
    weight.sqrt()
}

/// Returns which points are locked: those of locked vertices, and those on borders if borders are locked.
fn locked_points(topology: &Topology, vertices: &[u32], options: &SimplifyOptions) -> Vec<bool> {
    let mut is_locked = vec![false; topology.point_count()];
    let locked = options.locked();
    if !locked.is_empty() {
        for (&point, &v) in topology.triangles.iter().flatten().zip(vertices) {
            is_locked[point as usize] |= locked.get(v as usize).copied().unwrap_or(false);
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
