//! The removed points that each triangle represents. The price of a collapse uses them to measure
//! how far the surface already is from the full mesh.
//!
//! ```text
//!         u ───── w                   u ───── w
//!        ╱ ╲  x  ╱ ╲                 ╱ ╲ x  ╱╱
//!       ╱  x╲   ╱ x ╲               ╱ x ╲ ╱x╱
//!      ╱     ╲ ╱     ╲             ╱   ╱y╲ ╱
//!     a ────── b ─────·     →     a ───── ·
//! ```
//! Each removed point (x) is assigned to the triangle that was nearest when it was last moved. If b
//! collapses to a, the removed points of the triangles around b, and b itself (y), are reassigned
//! to the nearest of the triangles that replace them. The price is the sum of their squared
//! distances, weighted by the area of each point in the full mesh.
//!
//! The sum over all triangles is the mean squared distance of the full mesh from the simplified
//! one, measured at the vertices. A quadric only approximates it, because its planes are unbounded.
//!
//! # Complexity
//! 32 bytes per point and 4 bytes per triangle. At a level where one point in k remains, about 3 (k
//! − 1) removed points are assigned to the triangles around a point. The mean over all collapses
//! down to one point in k is 3 (ln k − 1).
//!
//! # References
//! Ciampalini, Cignoni, Montani, Scopigno: *Multiresolution Decimation Based on Global Error*,
//! 1997, assign removed vertices to the nearest faces, and bound the maximum distance by them. The
//! area-weighted sum as the price of a collapse was developed for this library.

use super::fan::TriangleFan;
use crate::ids::OptionalId;
use crate::simplify::price::best_collapse::finite;
use crate::simplify::surface::topology::{CornerId, Topology};
use crate::vector::{Point, dot, sub};

/// The number of sample positions on the edges of any mesh; one more is allowed per point.
const FEW_SAMPLES: usize = 10_000;

/// A point with the data needed once it has been removed, stored together for memory locality.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RemovedPoint {
    pub(crate) position: Point,
    /// The area that it represents, in squared units of the frame: a third of the area of its
    /// triangles in the full mesh.
    pub(crate) area: f32,
    /// The next removed point of the same triangle.
    next: OptionalId,
}

/// The removed points of each triangle, in lists.
#[derive(Debug)]
pub(crate) struct RemovedPoints {
    /// The first removed point of each triangle.
    first: Vec<OptionalId>,
    /// All points, removed or not, followed by the sample positions on edges.
    points: Vec<RemovedPoint>,
    /// Points that move to other triangles.
    moving: Vec<u32>,
    /// The triangles that they move to, and the edge of each that is opposite to the kept point.
    triangles: Vec<usize>,
    edges: Vec<[Point; 2]>,
    fan: TriangleFan,
}

impl RemovedPoints {
    /// Creates the lists with no points removed.
    pub(crate) fn new(triangle_count: usize, points: impl Iterator<Item = (Point, f64)>) -> Self {
        let point = |(position, area)| RemovedPoint { position, area: finite(area), next: OptionalId::NONE };
        Self {
            first: vec![OptionalId::NONE; triangle_count],
            points: points.map(point).collect(),
            moving: Vec::new(),
            triangles: Vec::new(),
            edges: Vec::new(),
            fan: TriangleFan::default(),
        }
    }

    /// Adds sample positions on the edges of the full mesh, about `spacing` apart unless there
    /// would be too many. They represent no area, and only affect the maximum distance: the
    /// midpoint of a long edge can be far from a surface that is near its ends.
    pub(crate) fn with_samples(mut self, topology: &Topology, spacing: f64) -> Self {
        if !spacing.is_finite() {
            return self;
        }
        let ends = |corner: CornerId| [topology.point(corner), topology.others(corner)[0]];
        let ascends = |corner: &CornerId| ends(*corner).is_sorted();
        // Take each edge once: an inner edge is in two triangles, in opposite directions.
        let borders = topology.open_edges().filter_map(|(corner, is_border)| is_border.then_some(corner));
        let descending = borders.filter(|corner| !ascends(corner));
        let edges: Vec<CornerId> = topology.corners().filter(ascends).chain(descending).collect();
        let span = |corner: CornerId| {
            let [from, to] = ends(corner).map(|p| self.points[p as usize].position);
            (from, sub(to, from))
        };
        let length = |along: Point| dot(along, along).sqrt();
        let whole: f64 = edges.iter().map(|&corner| length(span(corner).1)).sum();
        let spacing = spacing.max(whole / (FEW_SAMPLES + self.points.len()) as f64);
        let mut samples = Vec::new();
        for corner in edges {
            let (from, along) = span(corner);
            let parts = (length(along) / spacing).ceil();
            let mut part = 1.0;
            while part < parts {
                let position = [0, 1, 2].map(|k| from[k] + part / parts * along[k]);
                samples.push((corner.triangle(), position));
                part += 1.0;
            }
        }
        for (triangle, position) in samples {
            let number = OptionalId::some(self.points.len() as u32);
            let next = std::mem::replace(&mut self.first[triangle], number);
            self.points.push(RemovedPoint { position, area: 0.0, next });
        }
        self
    }

    /// Returns the area of a point.
    pub(crate) fn area(&self, point: u32) -> f64 {
        self.points[point as usize].area.into()
    }

    /// Collects the removed points assigned to the triangles of a point.
    pub(crate) fn around(&self, topology: &Topology, point: u32, found: &mut Vec<RemovedPoint>) {
        found.clear();
        for corner in topology.ring(point) {
            let mut at = self.first[corner.triangle()];
            while let Some(number) = at.get() {
                let removed = self.points[number as usize];
                found.push(removed);
                at = removed.next;
            }
        }
    }

    /// Moves a point that is about to collapse, and the removed points of its triangles, to the
    /// remaining triangles.
    pub(crate) fn collapse(&mut self, topology: &Topology, point: u32, to: u32) {
        self.moving.clear();
        self.moving.push(point);
        self.triangles.clear();
        self.edges.clear();
        for (corner, edge) in topology.ring(point).iter().zip(topology.opposite(point)) {
            let mut at = std::mem::replace(&mut self.first[corner.triangle()], OptionalId::NONE);
            while let Some(removed) = at.get() {
                self.moving.push(removed);
                at = self.points[removed as usize].next;
            }
            if !edge.contains(&to) {
                self.triangles.push(corner.triangle());
                self.edges.push(edge.map(|p| self.points[p as usize].position));
            }
        }
        // If no triangle remains, the points are dropped with their part of the surface.
        if self.triangles.is_empty() {
            return;
        }
        self.fan.place(self.points[to as usize].position, false, self.edges.iter().copied());
        for &moved in &self.moving {
            let point = &mut self.points[moved as usize];
            let triangle = self.triangles[self.fan.nearest(point.position)];
            point.next = std::mem::replace(&mut self.first[triangle], OptionalId::some(moved));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simplify::SimplifyOptions;
    use crate::simplify::price::neighbourhood::Neighbourhood;
    use crate::simplify::price::priced_surface::PricedSurface;
    use crate::vector::to_triangle;

    /// Returns positions on a paraboloid over a square grid of `side` by `side`, and the triangles.
    fn bowl(side: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
        let place = |v: u32| {
            let [x, y] = [v % side, v / side].map(|k| k as f32 / side as f32 - 0.4);
            [x, y, x * x + 0.7 * y * y]
        };
        let squares = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
        let triangles = squares.flat_map(|a| [a, a + 1, a + side, a + side, a + 1, a + side + 1]);
        ((0..side * side).map(place).collect(), triangles.collect())
    }

    /// A square of two triangles. Each side and the diagonal have samples at most 0.5 apart,
    /// assigned to a triangle with that edge.
    #[test]
    fn long_edges_have_places() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let topology = Topology::new(&corners[..], |_| Vec::new(), &[0, 1, 2, 2, 1, 3], false, 0.0);
        let points = || corners.iter().map(|corner| (corner.map(f64::from), 1.0));
        let places = |spacing: f64| {
            let removed = RemovedPoints::new(2, points()).with_samples(&topology, spacing);
            let mut places = Vec::new();
            for (t, first) in removed.first.iter().enumerate() {
                let mut at = *first;
                while let Some(number) = at.get() {
                    let place = removed.points[number as usize];
                    assert!(place.area == 0.0);
                    let sides =
                        [place.position[0], place.position[1], 1.0 - place.position[0] - place.position[1]];
                    assert!(sides[2].abs() < 1e-9 || (sides[2] > 0.0) == (t == 0));
                    places.push(place.position.map(|x| (x * 12.0).round() as i32));
                    at = place.next;
                }
            }
            places.sort_unstable();
            places
        };
        assert_eq!(places(0.5), [[0, 6, 0], [4, 8, 0], [6, 0, 0], [6, 12, 0], [8, 4, 0], [12, 6, 0]]);
        assert_eq!(places(1.2), [[6, 6, 0]], "the diagonal alone is longer");
        assert!(places(f64::INFINITY).is_empty());
        assert!((1..2 * FEW_SAMPLES).contains(&places(0.0).len()), "bounded");
        let points_of = |options: SimplifyOptions| {
            let topology = Topology::new(&corners[..], |_| Vec::new(), &[0, 1, 2, 2, 1, 3], false, 0.0);
            PricedSurface::new(topology, &corners[..], |_| None, &options).removed.unwrap().points.len()
        };
        assert_eq!(points_of(SimplifyOptions::default()), 4);
        assert_eq!(points_of(SimplifyOptions::default().with_error(0.25)), 10, "twice the error limit apart");
    }

    /// Collapses of a bowl. Each removed point is in exactly one list: the list of the nearest
    /// triangle around the kept point. The sum of distances matches a search.
    #[test]
    fn removed_points_belong_to_the_nearest_triangle() {
        let (positions, triangles) = bowl(6);
        let mut topology = Topology::new(&positions[..], |_| Vec::new(), &triangles, false, 0.0);
        let placed: Vec<Point> =
            (0..36).map(|p| positions[topology.vertex_of(p) as usize].map(f64::from)).collect();
        let point_of = |v: u32| (0..36).find(|&p| topology.vertex_of(p) == v).unwrap();
        let collapses = [(14, 15), (15, 21), (20, 21), (22, 21), (21, 27), (16, 27)]
            .map(|(from, to)| (point_of(from), point_of(to)));
        let areas: Vec<f64> = (0..36).map(|p| 1.0 + f64::from(p)).collect();
        let mut removed = RemovedPoints::new(topology.triangles.len(), placed.iter().copied().zip(areas));
        let mut gone: Vec<u32> = Vec::new();
        let (mut found, mut neighbourhood, mut most_around) = (Vec::new(), Neighbourhood::default(), 0);
        for (point, to) in collapses {
            // The sum in the price, computed by a search.
            removed.around(&topology, point, &mut found);
            most_around = most_around.max(found.len());
            let left = || topology.opposite(point).iter().filter(|edge| !edge.contains(&to));
            let corner = |p: u32| placed[p as usize];
            let nearest = |p: Point| {
                left().fold(f64::INFINITY, |least, &[u, w]| to_triangle(p, [to, u, w].map(corner), least))
            };
            let oracle: f64 = found.iter().map(|p| f64::from(p.area) * nearest(p.position)).sum();
            neighbourhood.collect(&topology, &placed, point);
            neighbourhood.collect_removed(&topology, point, &removed);
            let kept = corner(to);
            let (sum, largest) =
                neighbourhood.removed_distances(to, kept, f64::INFINITY, f64::INFINITY).unwrap();
            assert!((sum - oracle).abs() < 1e-6 * (1.0 + oracle), "{sum} {oracle}");
            if sum > 0.0 {
                assert!(neighbourhood.removed_distances(to, kept, 0.5 * sum, f64::INFINITY).is_none());
                assert!(neighbourhood.removed_distances(to, kept, f64::INFINITY, 0.5 * largest).is_none());
            }

            removed.collapse(&topology, point, to);
            topology.collapse(point, to, &[], &mut Vec::new());
            gone.push(point);
            let mut listed = Vec::new();
            for (t, first) in removed.first.iter().enumerate() {
                let mut at = *first;
                while let Some(p) = at.get() {
                    assert!(topology.triangles[t].iter().all(|other| !gone.contains(other)), "{t} is gone");
                    listed.push(p);
                    at = removed.points[p as usize].next;
                }
            }
            listed.sort_unstable();
            let mut expected = gone.clone();
            expected.sort_unstable();
            assert_eq!(listed, expected);
            // The point itself is assigned to the nearest of the triangles that replace its own.
            removed.around(&topology, to, &mut found);
            assert!(found.iter().any(|p| p.position.map(f64::to_bits) == corner(point).map(f64::to_bits)));
        }
        assert!(most_around >= 4);
    }
}
