//! A surface during simplification: everything that the price of a collapse depends on.
//!
//! Sequential state, such as the order of the points, is in the module `decimate`. Several threads
//! can read a surface at a time.

use super::attribute_quadrics::AttributeQuadrics;
use super::attributes::PricedAttributes;
use super::deviation::TriangleDeviations;
use super::frame::{frame, fundamental_quadrics, quadrics};
use super::neighbourhood::Neighbourhood;
use super::quadric::Quadric;
use super::removed_points::RemovedPoints;
use crate::collapse::Rename;
use crate::mesh::Positions;
use crate::simplify::options::{Price, SimplifyOptions};
use crate::simplify::surface::topology::Topology;
use crate::vector::Point;

/// The remaining triangles, and what they represent.
#[derive(Debug)]
pub(crate) struct PricedSurface {
    pub(crate) topology: Topology,
    /// The positions of the points, in the frame.
    pub(crate) positions: Vec<Point>,
    /// The unit of the frame, in mesh units.
    pub(crate) unit: f64,
    pub(crate) quadrics: Vec<Quadric>,
    pub(crate) attributes: Option<AttributeQuadrics>,
    /// The removed points, if the price needs them.
    pub(crate) removed: Option<RemovedPoints>,
    /// The deviations of the triangles from the full mesh, if there is an error limit and the price
    /// is by distance.
    deviations: Option<TriangleDeviations>,
    /// The error of removing each point's component, in units of the frame; empty if all components
    /// are kept.
    vanishing: Vec<f32>,
    /// How the cost of a collapse is computed.
    pub(crate) price: Price,
    /// The maximum error, in units of the frame.
    pub(crate) error_limit: f64,
    pub(crate) is_permissive: bool,
}

impl PricedSurface {
    /// Places the points in a frame, and computes their quadrics. `priced` returns the attributes
    /// that have a price, given the unit of the frame.
    pub(crate) fn new<P: Positions + ?Sized>(
        topology: Topology,
        positions: &P,
        priced: impl FnOnce(f64) -> Option<PricedAttributes>,
        options: &SimplifyOptions,
    ) -> Self {
        let count = topology.point_count() as u32;
        let position = |p| positions.position(topology.vertex_of(p) as usize).unwrap_or_default();
        let (framed, unit) = frame((0..count).map(position));
        let is_published = options.price == Price::Quadric;
        let priced = if is_published { None } else { priced(unit) };
        let attributes = priced.map(|values| AttributeQuadrics::new(&topology, &framed, values));
        let vanishing = match &options.vanishing[..] {
            [] => Vec::new(),
            errors => vanishing_errors(errors, &topology, unit),
        };
        let quadrics = if is_published {
            fundamental_quadrics(&topology, &framed)
        } else {
            quadrics(&topology, &framed, attributes.is_some())
        };
        let error_limit = options.error.map_or(f64::INFINITY, |error| f64::from(error) / unit);
        let by_distance = options.price == Price::Distance;
        let removed = by_distance.then(|| {
            let areas = quadrics.iter().map(|quadric| quadric.weight / 3.0);
            let removed = RemovedPoints::new(topology.triangles.len(), framed.iter().copied().zip(areas));
            removed.with_samples(&topology, 2.0 * error_limit)
        });
        let is_limited = by_distance && error_limit.is_finite();
        let deviations = is_limited.then(|| TriangleDeviations::new(&topology.triangles));
        Self {
            topology,
            positions: framed,
            unit,
            quadrics,
            attributes,
            removed,
            deviations,
            vanishing,
            price: options.price,
            error_limit,
            is_permissive: options.permissive,
        }
    }

    /// Collects the renames of a collapse. Returns whether it keeps seams closed or may move them.
    pub(crate) fn keeps_seams(&self, point: u32, to: u32, renames: &mut Vec<Rename>) -> bool {
        if self.topology.renames(point, to, renames).is_some() {
            return true;
        }
        let attributes = self.attributes.as_ref();
        let difference = |a: u32, b: u32| attributes.map_or(0.0, |attributes| attributes.difference(a, b));
        self.is_permissive && self.topology.renames_across(point, to, renames, difference).is_some()
    }

    /// Returns the error of removing a point's component, in units of the frame; infinite if it
    /// must be kept.
    pub(crate) fn vanishing_error(&self, point: u32) -> f64 {
        self.vanishing.get(point as usize).copied().unwrap_or(f32::INFINITY).into()
    }

    /// Returns whether the new triangles of a collapse are within the error limit of the full mesh.
    /// If so, this collapse must be applied next.
    pub(crate) fn stays_near(&mut self, point: u32, to: u32, around: &mut Neighbourhood) -> bool {
        let Some(deviations) = &mut self.deviations else { return true };
        around.collect(&self.topology, &self.positions, point);
        deviations.allow(&self.topology, &self.positions, (around, point, to), self.error_limit)
    }

    /// Applies a collapse, and writes the indices of the triangles that it drops to `dropped`,
    /// ascending.
    pub(crate) fn collapse(&mut self, point: u32, to: u32, renames: &[Rename], dropped: &mut Vec<u32>) {
        if let Some(deviations) = &mut self.deviations {
            deviations.collapse(&self.topology, point, to);
        }
        if let Some(removed) = &mut self.removed {
            removed.collapse(&self.topology, point, to);
        }
        self.topology.collapse(point, to, renames, dropped);
        let quadric = self.quadrics[point as usize];
        self.quadrics[to as usize].add(&quadric);
        if let Some(attributes) = &mut self.attributes {
            attributes.merge(renames);
        }
    }
}

/// Returns the error of removing each point's component in units of the frame: the maximum over the
/// vertices of the point, or infinity if it must be kept.
fn vanishing_errors(errors: &[f32], topology: &Topology, unit: f64) -> Vec<f32> {
    let mut of_points = vec![0.0_f32; topology.point_count()];
    for corner in topology.corners() {
        let error = errors.get(topology.wedge(corner) as usize).copied().filter(|error| *error >= 0.0);
        let error = error.map_or(f32::INFINITY, |error| (f64::from(error) / unit) as f32);
        let of_point = &mut of_points[topology.point(corner) as usize];
        *of_point = of_point.max(error);
    }
    of_points
}

/// Returns which points are locked: those of locked vertices, and those on borders if borders are
/// locked.
pub(crate) fn locked_points(topology: &Topology, options: &SimplifyOptions) -> Vec<bool> {
    let mut is_locked = vec![false; topology.point_count()];
    let locked = &options.locked;
    if !locked.is_empty() {
        for corner in topology.corners() {
            is_locked[topology.point(corner) as usize] |=
                locked.get(topology.wedge(corner) as usize).copied().unwrap_or(false);
        }
    }
    if options.locked_borders {
        for (corner, _) in topology.open_edges().filter(|&(_, is_border)| is_border) {
            let [to, _] = topology.others(corner);
            [topology.point(corner), to].iter().for_each(|&p| is_locked[p as usize] = true);
        }
    }
    is_locked
}
