//! The local frame of the positions, and the quadrics of the points of a full mesh.

use super::quadric::Quadric;
use crate::simplify::surface::topology::Topology;
use crate::vector::{Point, cross, dot, normal_of, sub};

/// The weight of a plane along a border relative to a face of the same size: a large penalty, as in
/// Garland and Heckbert, section 6.
const BORDER_WEIGHT: f64 = 10.0;
/// The weight of a plane along a seam, where only attributes differ, if no attribute has a price.
/// Priced attributes already limit how far a seam may move. With planes in addition, seam vertices
/// would be kept at the expense of all others.
const SEAM_WEIGHT: f64 = 1.0;

/// The weight of a plane along a border if planes of faces have a weight of 1. The paper only says
/// that it is large; this is the default of its authors' program `QSlim`.
const BORDER_PENALTY: f64 = 1000.0;

/// Returns the positions in a frame where the longest side of their bounding box is 1, and the
/// length of that side.
pub(crate) fn frame(positions: impl Iterator<Item = [f32; 3]> + Clone) -> (Vec<Point>, f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions.clone() {
        for k in 0..3 {
            low[k] = low[k].min(f64::from(p[k]));
            high[k] = high[k].max(f64::from(p[k]));
        }
    }
    let side = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let unit = if side > 0.0 { side } else { 1.0 };
    (positions.map(|p| [0, 1, 2].map(|k| (f64::from(p[k]) - low[k]) / unit)).collect(), unit)
}

/// Returns for each point the area-weighted planes of its triangles, and planes perpendicular to
/// them along borders and seams.
///
/// If `priced`, attributes have a price, and seams need no planes.
pub(crate) fn quadrics(topology: &Topology, positions: &[Point], priced: bool) -> Vec<Quadric> {
    let edge_weight = |is_border: bool, square: f64| match is_border {
        true => Some(square * BORDER_WEIGHT),
        false if priced => None,
        false => Some(square * SEAM_WEIGHT),
    };
    sums_of_planes(topology, positions, |area| area, edge_weight)
}

/// Returns for each point the planes of its triangles, each with a weight of 1, and planes
/// perpendicular to them along borders, as in Garland and Heckbert.
pub(crate) fn fundamental_quadrics(topology: &Topology, positions: &[Point]) -> Vec<Quadric> {
    sums_of_planes(topology, positions, |_| 1.0, |is_border, _| is_border.then_some(BORDER_PENALTY))
}

/// Sums planes per point. `face_weight` returns the weight of a triangle's plane from twice its
/// area; `edge_weight` that of a border or seam plane, if any, from the squared length of the edge.
fn sums_of_planes(
    topology: &Topology,
    positions: &[Point],
    face_weight: impl Fn(f64) -> f64,
    edge_weight: impl Fn(bool, f64) -> Option<f64>,
) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); positions.len()];
    let unit_normal = |t: usize| {
        let normal = normal_of(topology.triangles[t].map(|p| positions[p as usize]));
        let length = dot(normal, normal).sqrt();
        (length > 0.0).then(|| (normal.map(|x| x / length), length))
    };
    for (t, triangle) in topology.triangles.iter().enumerate() {
        let Some((normal, area)) = unit_normal(t) else { continue };
        let weight = face_weight(area);
        let plane = Quadric::plane(normal, positions[triangle[0] as usize], weight).of_faces(weight);
        triangle.iter().for_each(|&p| quadrics[p as usize].add(&plane));
    }
    for (corner, is_border) in topology.open_edges() {
        let [from, to] = [topology.point(corner), topology.others(corner)[0]];
        let edge = sub(positions[to as usize], positions[from as usize]);
        let Some(weight) = edge_weight(is_border, dot(edge, edge)) else { continue };
        let Some((normal, _)) = unit_normal(corner.triangle()) else { continue };
        let across = cross(edge, normal);
        let length = dot(across, across).sqrt();
        if length > 0.0 {
            let plane = Quadric::plane(across.map(|x| x / length), positions[from as usize], weight);
            [from, to].iter().for_each(|&p| quadrics[p as usize].add(&plane));
        }
    }
    quadrics
}
