//! The local frame of the positions, and the quadrics of the points of a full mesh.

use super::quadric::Quadric;
use crate::simplify::surface::topology::Topology;
use crate::vector::{Point, cross, dot, normal_of, sub};

/// The weight of a plane along a border relative to a face of the same size: a large penalty, as Garland and Heckbert, section 6, have it.
const BORDER_WEIGHT: f64 = 10.0;
/// The same for a seam, across which only attributes differ, where no attribute has a price: attributes that have one tell how far a seam
/// may move, and with planes as well the vertices on seams stay at the expense of all others.
const SEAM_WEIGHT: f64 = 1.0;

/// The weight of a plane along a border where planes of faces have a weight of 1. The paper only says that it is large; this is the default of its
/// authors' program `QSlim`.
const BORDER_PENALTY: f64 = 1000.0;

/// Returns positions in a frame in which the longest side of their bounding box is 1, and the length of that side.
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

/// Returns for each point the planes of its triangles, weighted by area, and planes perpendicular to them along borders and seams.
///
/// `priced` tells whether attributes have a price, so that seams need no planes.
pub(crate) fn quadrics(topology: &Topology, positions: &[Point], priced: bool) -> Vec<Quadric> {
    let edge_weight = |is_border: bool, square: f64| match is_border {
        true => Some(square * BORDER_WEIGHT),
        false if priced => None,
        false => Some(square * SEAM_WEIGHT),
    };
    sums_of_planes(topology, positions, |area| area, edge_weight)
}

/// Returns for each point the planes of its triangles, each with a weight of 1, and planes perpendicular to them along borders, as
/// Garland and Heckbert have them.
pub(crate) fn fundamental_quadrics(topology: &Topology, positions: &[Point]) -> Vec<Quadric> {
    sums_of_planes(topology, positions, |_| 1.0, |is_border, _| is_border.then_some(BORDER_PENALTY))
}

/// Adds up planes: of triangles, with a weight by twice their area, and of borders and seams, with one, if any, by the square of their length.
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
