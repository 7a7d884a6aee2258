//! The cost of a collapse.
//!
//! There are two costs:
//! - The *estimate* is the point's quadric, evaluated at the neighbour that would replace it. It
//!   takes one evaluation per neighbour.
//! - The *price* measures how far the new triangles would be from the full mesh and from the old
//!   triangles. It has three terms. The first is the sum of the squared distances of the point and
//!   of the removed points that its triangles represent (module `removed_points`), weighted by the
//!   areas that they represent. The second is the maximum squared distance of the midpoints of the
//!   new edges from the old triangles. The third is a small share of the estimate. A quadric
//!   represents only unbounded planes, and it counts them repeatedly. The first term of the price,
//!   in contrast, is the actual mean squared distance. The midpoints show whether a new edge would
//!   cut a ridge or bridge a valley. The quadrics of the attributes are added, if there are any
//!   (module `attribute_quadrics`).
//!
//! Both costs are divided by the square root of the weight of the point. The weight is the area
//! that the point represents. Weighting by area alone would remove thin parts first. Weighting by
//! distance alone would make a small part as expensive as a large one.
//!
//! # Algorithm
//! The neighbours are priced by ascending estimate. A price is computed in steps, cheap ones first,
//! and abandoned as soon as it exceeds the best price. The cost of a point that was never priced is
//! its estimate times a typical ratio of price to estimate, so few prices are wasted. A neighbour
//! whose estimate exceeds the best price is skipped, because its price is rarely better.
//!
//! For [`Price::Planes`], the price is the estimate plus the attributes. [`Price::Quadric`] does
//! not use these costs; see the module `queue`.

use super::neighbourhood::Neighbourhood;
use super::quadric::Quadric;
use crate::collapse::Rename;
use crate::simplify::options::Price;
use crate::simplify::price::best_collapse::{PricedCollapse, finite};
use crate::simplify::price::priced_surface::PricedSurface;
use crate::simplify::surface::irregular::Links;
use crate::simplify::surface::outcome::CollapseOutcome;
use crate::simplify::surface::topology::PointKind;
use crate::vector::{Point, dot, sub};

/// The weight of the area-weighted squared distances relative to the quadric, which counts each
/// area at three points.
const DISTANCE_WEIGHT: f64 = 4.0;
/// The weight of the maximum squared distance of the new edges. Over 22 models, 1 gave the same
/// mean distance and a larger maximum; 4 was worse in both.
const BRIDGE_WEIGHT: f64 = 2.0;
/// The share of the estimate in the price of inner points. Over 31 models, 0.03 gave the same
/// distances, 0.3 and 1 larger ones.
const INNER_ESTIMATE_SHARE: f64 = 0.1;
/// The share for other points, whose quadrics have planes along borders and seams.
const ESTIMATE_SHARE: f64 = 0.3;
/// The weight of the squared distance from a vanishing component, multiplied by the area that the
/// point represents.
const VANISHING_WEIGHT: f64 = 2.0;
/// The weight of the squared edge length relative to the quadric. If all neighbours cost the same,
/// as on a plane, points of small weight then collapse to near ones. No point is passed along a
/// chain, which would rename the same corners repeatedly.
const LENGTH_WEIGHT: f64 = 1e-6;
/// The ratio of the expected price by distance to the estimate, for points without a price. With
/// 0.5 or 1, distances are the same, but more prices are computed without being used.
const USUAL_RATIO: f64 = 2.0;

impl Price {
    /// Returns the expected price of a collapse.
    pub(crate) fn expected(self, estimate: f64) -> f64 {
        match self {
            Self::Distance => USUAL_RATIO * estimate,
            Self::Planes | Self::Quadric => estimate,
        }
    }
}

/// The state of pricing one point at a time; one per thread.
#[derive(Debug, Default)]
pub(crate) struct PriceSearch {
    /// The triangles of the point.
    pub(crate) current: Neighbourhood,
    pub(crate) neighbours: Vec<u32>,
    /// The neighbours that the point may collapse to, with their estimates.
    pub(crate) candidates: Vec<(f64, u32)>,
    /// Neighbours that the point must not collapse to.
    pub(crate) refused: Vec<u32>,
    /// The renames of the last collapse that was examined.
    pub(crate) renames: Vec<Rename>,
    links: Links,
}

impl PriceSearch {
    /// Sets the current point.
    pub(crate) fn set_current(&mut self, surface: &PricedSurface, point: u32) {
        self.current.collect(&surface.topology, &surface.positions, point);
    }

    /// Collects the neighbours that a point may collapse to, with their estimates. For a border
    /// point these are along the border.
    pub(crate) fn collect_candidates(&mut self, surface: &PricedSurface, point: u32) {
        let kind = surface.topology.kind(point);
        match kind {
            PointKind::Irregular => self.links.neighbours(&surface.topology, point, &mut self.neighbours),
            _ => surface.topology.neighbours(point, &mut self.neighbours),
        }
        let first = match kind {
            PointKind::Border => self.neighbours.len().saturating_sub(2),
            _ => 0,
        };
        let (quadric, from) = (&surface.quadrics[point as usize], surface.positions[point as usize]);
        let root = quadric.weight.sqrt();
        let scale = if root > 0.0 { 1.0 / root } else { 1.0 };
        let estimate = |&to: &u32| (scale * estimate_of(quadric, from, surface.positions[to as usize]), to);
        self.candidates.clear();
        self.candidates.extend(self.neighbours[first..].iter().map(estimate));
    }

    /// Returns the smallest estimate of a point.
    pub(crate) fn least_estimate(&mut self, surface: &PricedSurface, point: u32) -> Option<f64> {
        self.collect_candidates(surface, point);
        self.candidates.iter().map(|&(estimate, _)| estimate).min_by(f64::total_cmp)
    }

    /// Returns the best collapse of a point. `outcome` returns how the collapse to a neighbour
    /// changes the topology.
    pub(crate) fn best(
        &mut self,
        surface: &PricedSurface,
        point: u32,
        mut outcome: impl FnMut(u32) -> CollapseOutcome,
    ) -> Option<PricedCollapse> {
        self.collect_candidates(surface, point);
        self.set_current(surface, point);
        if let Some(removed) = &surface.removed {
            self.current.collect_removed(&surface.topology, point, removed);
        }
        let mut candidates = std::mem::take(&mut self.candidates);
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (mut best, mut most) = (None, f64::INFINITY);
        for &(estimate, to) in &candidates {
            if estimate >= most {
                break;
            }
            if self.refused.contains(&to) {
                continue;
            }
            if let Some(priced) = self.price_of(surface, point, to, estimate, most, &mut outcome) {
                let (cost, error) = priced;
                most = cost;
                best = Some(PricedCollapse { to, cost: finite(cost), error: finite(error) });
            }
        }
        self.candidates = candidates;
        best
    }

    /// Returns the possible collapse of a point along its shortest edge. Its cost is the length of
    /// the edge.
    pub(crate) fn nearest(
        &mut self,
        (surface, point): (&PricedSurface, u32),
        mut outcome: impl FnMut(u32) -> CollapseOutcome,
    ) -> Option<PricedCollapse> {
        self.set_current(surface, point);
        self.collect_candidates(surface, point);
        let from = surface.positions[point as usize];
        let mut candidates = std::mem::take(&mut self.candidates);
        for (cost, to) in &mut candidates {
            let edge = sub(surface.positions[*to as usize], from);
            *cost = dot(edge, edge).sqrt();
        }
        candidates.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let best = candidates.iter().find_map(|&(length, to)| {
            if self.refused.contains(&to) {
                return None;
            }
            let (_, error) = self.price_of(surface, point, to, 0.0, f64::INFINITY, &mut outcome)?;
            Some(PricedCollapse { to, cost: finite(length), error: finite(error) })
        });
        self.candidates = candidates;
        best
    }

    /// Returns the price and the error of a collapse of the current point, if it is possible and
    /// its price is below `most`.
    fn price_of(
        &mut self,
        surface: &PricedSurface,
        point: u32,
        to: u32,
        estimate: f64,
        most: f64,
        outcome: &mut impl FnMut(u32) -> CollapseOutcome,
    ) -> Option<(f64, f64)> {
        let kept = surface.positions[to as usize];
        let quadric = &surface.quadrics[point as usize];
        let weight = quadric.weight.sqrt();
        let per_area = if weight > 0.0 { DISTANCE_WEIGHT / weight } else { 0.0 };
        let most_square = surface.error_limit * surface.error_limit;
        // 1. The distance of the point, or of the planes.
        let (mut cost, mut square) = if let Some(removed) = &surface.removed {
            let square = self.current.distance(to, kept);
            let is_inner = surface.topology.kind(point) == PointKind::Inner;
            let share = if is_inner { INNER_ESTIMATE_SHARE } else { ESTIMATE_SHARE };
            (share * estimate + per_area * removed.area(point) * square, square)
        } else {
            let area = quadric.whole_weight;
            (estimate, if area > 0.0 { quadric.at(kept) / area } else { 0.0 })
        };
        if cost >= most || square > most_square || self.current.folds_over(to, kept) {
            return None;
        }
        // 2. The distances of the removed points.
        if surface.removed.is_some() {
            let most_sum = if per_area > 0.0 { (most - cost) / per_area } else { f64::INFINITY };
            let (sum, largest) = self.current.removed_distances(to, kept, most_sum, most_square)?;
            cost += per_area * sum;
            square = square.max(largest);
        }
        // 3. The attributes.
        if surface.attributes.is_some() {
            let change = self.attribute_change(surface, point, to)?;
            cost += if weight > 0.0 { change / weight } else { change };
        }
        if cost >= most {
            return None;
        }
        // 4. The new edges.
        if surface.removed.is_some() {
            let bridge = self.current.bridge(to, kept, (most - cost) / (BRIDGE_WEIGHT * weight));
            cost += BRIDGE_WEIGHT * weight * bridge;
            square = square.max(bridge);
        }
        if cost >= most || square > most_square {
            return None;
        }
        // 5. The change of the topology.
        let mut error = square.sqrt();
        match outcome(to) {
            CollapseOutcome::Keeps => {}
            CollapseOutcome::Breaks if surface.is_permissive => {}
            // A component that may vanish may also break on the way.
            CollapseOutcome::Breaks | CollapseOutcome::Loses | CollapseOutcome::Ends => {
                let removal = surface.vanishing_error(point);
                cost += VANISHING_WEIGHT * weight * removal * removal;
                error = error.max(removal);
            }
        }
        let is_possible = cost < most && error.is_finite() && error <= surface.error_limit;
        (is_possible && surface.keeps_seams(point, to, &mut self.renames)).then_some((cost, error))
    }

    /// Returns the sum of the squared attribute deviations if a point collapses to a neighbour;
    /// `None` if a seam would open.
    fn attribute_change(&mut self, surface: &PricedSurface, point: u32, to: u32) -> Option<f64> {
        if !surface.keeps_seams(point, to, &mut self.renames) {
            return None;
        }
        let attributes = surface.attributes.as_ref()?;
        Some(attributes.change(&self.renames, surface.positions[to as usize]))
    }
}

/// Returns the estimate of a collapse between two positions, times the square root of the weight.
#[inline]
fn estimate_of(quadric: &Quadric, from: Point, to: Point) -> f64 {
    let edge = sub(to, from);
    quadric.at(to) + LENGTH_WEIGHT * quadric.weight * dot(edge, edge)
}
