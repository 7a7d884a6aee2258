//! The triangles around a point, and the distances to the triangles that would replace them.
//!
//! ```text
//!         u ───── w                   u ───── w
//!        ╱ ╲     ╱ ╲                 ╱ ╲    ╱╱
//!       ╱   ╲   ╱   ╲               ╱   ╲ ╱ ╱
//!      ╱     ╲ ╱     ╲             ╱   ╱ ╲ ╱
//!     a ────── b ─────·     →     a ───── ·
//! ```
//! If b collapses to a, its triangles with a are dropped. Each of the others, such as (b, u, w),
//! becomes (a, u, w). Two distances are computed:
//! - from b to the new triangles;
//! - from the midpoints of the new edges, such as a–u, to the old triangles.
//!
//! The second distance detects new triangles that bridge a valley next to b.

use super::fan::TriangleFan;
use super::removed_points::{RemovedPoint, RemovedPoints};
use crate::simplify::surface::topology::{PointKind, Topology};
use crate::vector::{Point, cross, dot, sub, to_segment, to_triangle};

/// The cosine of the maximum rotation of a triangle.
const MIN_COSINE: f64 = 0.25;

/// The barycentric coordinates of the positions on a new triangle that are compared with the full
/// mesh.
const NEW_PLACES: [[f64; 3]; 10] = [
    [0.5, 0.5, 0.0],
    [0.5, 0.0, 0.5],
    [0.25, 0.75, 0.0],
    [0.75, 0.25, 0.0],
    [0.25, 0.0, 0.75],
    [0.75, 0.0, 0.25],
    [0.34, 0.33, 0.33],
    [0.66, 0.17, 0.17],
    [0.17, 0.66, 0.17],
    [0.17, 0.17, 0.66],
];

/// The edge opposite to the point in one of its triangles.
#[derive(Debug, Clone, Copy)]
struct OppositeEdge {
    points: [u32; 2],
    positions: [Point; 2],
    /// The normal of the triangle, as long as twice its area.
    normal: Point,
}

impl OppositeEdge {
    fn has(&self, point: u32) -> bool {
        self.points[0] == point || self.points[1] == point
    }
}

/// The triangles around one point, in the order of its ring.
#[derive(Debug, Default)]
pub(crate) struct Neighbourhood {
    from: Point,
    is_inner: bool,
    edges: Vec<OppositeEdge>,
    /// The mesh of each triangle; empty if all belong to the same mesh.
    meshes: Vec<u32>,
    /// The same triangles, prepared for distances on first use.
    fan: TriangleFan,
    is_placed: bool,
    /// The removed points assigned to the triangles.
    removed: Vec<RemovedPoint>,
    /// The triangles that would replace them, for distances from the removed points.
    new_fan: TriangleFan,
    new_edges: Vec<[Point; 2]>,
}

impl Neighbourhood {
    /// Collects the triangles of a point.
    pub(crate) fn collect(&mut self, topology: &Topology, positions: &[Point], point: u32) {
        let from = positions[point as usize];
        (self.from, self.is_inner) = (from, topology.kind(point) == PointKind::Inner);
        topology.meshes_around(point, &mut self.meshes);
        self.edges.clear();
        self.edges.extend(topology.opposite(point).iter().map(|&points| {
            let [u, w] = points.map(|p| positions[p as usize]);
            OppositeEdge { points, positions: [u, w], normal: cross(sub(w, u), sub(from, u)) }
        }));
        self.is_placed = false;
    }

    /// Collects the removed points assigned to the triangles.
    pub(crate) fn collect_removed(&mut self, topology: &Topology, point: u32, removed: &RemovedPoints) {
        removed.around(topology, point, &mut self.removed);
    }

    /// Returns the area-weighted sum of the squared distances of the removed points from the
    /// triangles that the point would have at a neighbour, and the maximum squared distance.
    /// Returns `None` if the sum exceeds `most` or a squared distance exceeds `most_square`.
    pub(crate) fn removed_distances(
        &mut self,
        to: u32,
        kept: Point,
        most: f64,
        most_square: f64,
    ) -> Option<(f64, f64)> {
        self.new_edges.clear();
        if self.removed.is_empty() {
            return Some((0.0, 0.0));
        }
        self.new_edges.extend(self.edges.iter().filter(|edge| !edge.has(to)).map(|edge| edge.positions));
        if self.new_edges.is_empty() {
            return Some((0.0, 0.0));
        }
        self.new_fan.place(kept, false, self.new_edges.iter().copied());
        let (mut sum, mut largest) = (0.0, 0.0);
        for removed in &self.removed {
            let square = self.new_fan.old_distance(removed.position);
            sum += f64::from(removed.area) * square;
            largest = f64::max(largest, square);
            if sum > most || square > most_square {
                return None;
            }
        }
        Some((sum, largest))
    }

    /// Prepares the triangles for distances, once.
    fn place(&mut self) {
        if !self.is_placed {
            self.fan.place(self.from, self.is_inner, self.edges.iter().map(|edge| edge.positions));
            self.is_placed = true;
        }
    }

    /// Returns the squared distance of the point from the triangles that it would have at a
    /// neighbour. If none remain, returns the distance from the edges opposite to the point.
    /// Between several meshes, it is the maximum over the meshes, which measures how far the line
    /// between them moves.
    pub(crate) fn distance(&mut self, to: u32, kept: Point) -> f64 {
        if self.meshes.is_empty() {
            self.place();
            let edges = &self.edges;
            return self.fan.distance(kept, |i| edges[i].has(to));
        }
        let is_first = |i: usize| !self.meshes[..i].contains(&self.meshes[i]);
        let of_mesh = |mesh: u32| {
            let edges =
                self.edges.iter().zip(&self.meshes).filter(|(_, of)| **of == mesh).map(|(edge, _)| edge);
            self.distance_to(edges, to, kept)
        };
        (0..self.meshes.len()).filter(|&i| is_first(i)).map(|i| of_mesh(self.meshes[i])).fold(0.0, f64::max)
    }

    /// Returns the squared distance of the point from the new triangles at the given edges.
    fn distance_to<'a>(&self, edges: impl Iterator<Item = &'a OppositeEdge>, to: u32, kept: Point) -> f64 {
        let (mut least, mut least_edge) = (f64::INFINITY, f64::INFINITY);
        for edge in edges {
            let [u, w] = edge.positions;
            if edge.has(to) {
                least_edge = least_edge.min(to_segment(self.from, [u, w]));
            } else {
                least = to_triangle(self.from, [kept, u, w], least);
            }
        }
        if least.is_finite() { least } else { least_edge }
    }

    /// Returns whether a remaining triangle would rotate too far. A triangle without area must not
    /// become inverted.
    pub(crate) fn folds_over(&self, to: u32, kept: Point) -> bool {
        // A triangle without area is oriented like the sum of all triangles of the point.
        let all = || {
            let sum = |sum: Point, normal: Point| [0, 1, 2].map(|k| sum[k] + normal[k]);
            self.edges.iter().map(|edge| edge.normal).fold([0.0; 3], sum)
        };
        self.edges.iter().filter(|edge| !edge.has(to)).any(|edge| {
            let [u, w] = edge.positions;
            let (before, after) = (edge.normal, cross(sub(w, u), sub(kept, u)));
            let square = dot(before, before);
            if square == 0.0 {
                return dot(after, all()) < 0.0;
            }
            let cosine = dot(before, after);
            cosine <= 0.0 || cosine * cosine < MIN_COSINE * MIN_COSINE * square * dot(after, after)
        })
    }

    /// Iterates over sample positions on the triangles that the point would have at a neighbour:
    /// quarters of their edges at it, and interior positions.
    pub(crate) fn new_places(&self, to: u32, kept: Point) -> impl Iterator<Item = Point> {
        let edges = self.edges.iter().filter(move |edge| !edge.has(to));
        edges.flat_map(move |edge| {
            let [u, w] = edge.positions;
            NEW_PLACES
                .map(|[of_kept, of_u, of_w]| [0, 1, 2].map(|k| of_kept * kept[k] + of_u * u[k] + of_w * w[k]))
        })
    }

    /// Returns the maximum squared distance of the midpoints of new edges from the old triangles.
    /// Stops at the first that exceeds `most` and returns it.
    pub(crate) fn bridge(&mut self, to: u32, kept: Point, most: f64) -> f64 {
        self.place();
        // Around an inner point, each neighbour is the u of one triangle. Otherwise a neighbour may
        // be only a w.
        let ends = if self.is_inner { 1 } else { 2 };
        let mut largest = 0.0;
        for edge in self.edges.iter().filter(|edge| !edge.has(to)) {
            for end in &edge.positions[..ends] {
                let distance = self.fan.old_distance([0, 1, 2].map(|k| 0.5 * (kept[k] + end[k])));
                if distance > largest {
                    largest = distance;
                    if largest > most {
                        return largest;
                    }
                }
            }
        }
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the neighbourhood of vertex 0 in a closed fan around it.
    fn fan(positions: &[[f32; 3]]) -> (Neighbourhood, Vec<Point>, impl Fn(u32) -> u32 + use<>) {
        let rim = positions.len() as u32 - 1;
        let triangles: Vec<u32> = (1..=rim).flat_map(|i| [0, i, i % rim + 1]).collect();
        let topology = Topology::new(positions, |_| Vec::new(), &triangles, false, 0.0);
        let points: Vec<u32> = (0..positions.len() as u32).map(|p| topology.vertex_of(p)).collect();
        let placed: Vec<Point> = points.iter().map(|&v| positions[v as usize].map(f64::from)).collect();
        let point_of = move |v: u32| points.iter().position(|&other| other == v).unwrap() as u32;
        let mut neighbourhood = Neighbourhood::default();
        neighbourhood.collect(&topology, &placed, point_of(0));
        (neighbourhood, placed, point_of)
    }

    /// A square with its centre. When corner 3 is raised, the new edges to the opposite corner 1
    /// leave the old triangles.
    #[test]
    fn new_edges_are_compared_with_the_old_triangles() {
        let square = |height: f32| {
            vec![[0.0; 3], [-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, height], [-1.0, 1.0, 0.0]]
        };
        for (height, is_bridge) in [(0.0, false), (1.0, true)] {
            let (mut around, positions, point_of) = fan(&square(height));
            let to = point_of(1);
            let kept = positions[to as usize];
            // The midpoint of the edge from corner 1 to corner 3 is at half of the height, above
            // the centre.
            let bridge = around.bridge(to, kept, f64::INFINITY);
            assert_eq!(bridge > 0.1, is_bridge, "{bridge}");
            assert!(bridge <= f64::from(height * height) / 4.0);
            // A search that stops early finds the same value, or one above its limit.
            assert!(around.bridge(to, kept, 0.01) > 0.01 || !is_bridge);
            assert!(!around.folds_over(to, kept) && around.distance(to, kept) <= f64::from(height * height));
        }
    }

    /// The maximum distance does not depend on the order of the triangles: an exhaustive search
    /// finds the same.
    #[test]
    fn the_bridge_is_that_of_a_full_search() {
        let mut random = crate::random::Random::new(7);
        for _ in 0..100 {
            let mut height = || random.below(100) as f32 / 100.0;
            let rim = (0..7).map(|i| {
                let angle = i as f32 * 0.9;
                [angle.cos(), angle.sin(), height()]
            });
            let positions: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain(rim).collect();
            let (mut around, placed, point_of) = fan(&positions);
            for v in 1..=7 {
                let (to, kept) = (point_of(v), placed[point_of(v) as usize]);
                let new_ends = (1..=7).filter(|&u| u != v).map(|u| placed[point_of(u) as usize]);
                let middle = |end: Point| [0, 1, 2].map(|k| 0.5 * (kept[k] + end[k]));
                let triangles = (1..=7).map(|u| [0, u, u % 7 + 1].map(|v| placed[point_of(v) as usize]));
                let nearest = |p: Point| {
                    triangles.clone().fold(f64::INFINITY, |least, triangle| to_triangle(p, triangle, least))
                };
                let full = new_ends.map(|end| nearest(middle(end))).fold(0.0, f64::max);
                assert!((around.bridge(to, kept, f64::INFINITY) - full).abs() < 1e-6);
            }
        }
    }
}
