//! A surface of triangles over distinct positions. Nearest points are found by walking from
//! triangle to neighbour.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

use tristrip::Faces;

use crate::surface_change::{Facet, Side, dot};

pub(super) type Point = [f64; 3];

/// The maximum number of steps of a search.
const MAX_STEPS: usize = 32;
/// The maximum number of triangles around a corner that a step visits, evenly selected.
const MAX_AROUND: usize = 32;
/// The maximum number of triangles that a wide search visits.
const MAX_WIDE: usize = 256;

/// Triangles over positions, with the triangles around each position.
pub(super) struct FitSurface {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) at: Vec<Point>,
    /// For each position, the end of its range of triangles.
    ends: Vec<u32>,
    around: Vec<u32>,
}

/// A point of a surface: a triangle and barycentric coordinates.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spot {
    pub(super) triangle: u32,
    pub(super) shares: Point,
}

impl Spot {
    /// Checks whether the point is inside the triangle, not on its boundary.
    pub(super) fn is_inside(&self) -> bool {
        self.shares.iter().all(|&share| share > 0.0)
    }
}

impl FitSurface {
    /// Builds the surface from triangles over position indices.
    pub(super) fn new(faces: &Faces, at: Vec<Point>) -> Self {
        let triangles = faces.corners().as_chunks().0.to_vec();
        let mut ends = vec![0_u32; at.len() + 1];
        faces.corners().iter().for_each(|&v| ends[v as usize + 1] += 1);
        (0..at.len()).for_each(|v| ends[v + 1] += ends[v]);
        let mut around = vec![0; faces.corner_count()];
        // Each start becomes an end while the triangles are filled in.
        for (corner, &v) in (0..).zip(faces.corners()) {
            around[ends[v as usize] as usize] = corner / 3;
            ends[v as usize] += 1;
        }
        ends.truncate(at.len());
        Self { triangles, at, ends, around }
    }

    /// Returns the triangles around a position.
    pub(super) fn around(&self, v: u32) -> &[u32] {
        let start = if v == 0 { 0 } else { self.ends[v as usize - 1] };
        &self.around[start as usize..self.ends[v as usize] as usize]
    }

    /// Returns which positions have two triangles at every edge.
    pub(super) fn inner(&self) -> Vec<bool> {
        let mut edges: HashMap<[u32; 2], u32> = HashMap::with_capacity(2 * self.triangles.len());
        for &[a, b, c] in &self.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *edges.entry([from.min(to), from.max(to)]).or_default() += 1;
            }
        }
        let mut is_inner = vec![true; self.at.len()];
        for (edge, triangles) in edges {
            if triangles != 2 {
                edge.iter().for_each(|&v| is_inner[v as usize] = false);
            }
        }
        is_inner
    }

    pub(super) fn facet(&self, triangle: u32) -> Facet {
        let corners = self.triangles[triangle as usize];
        Facet::new(corners, corners.map(|v| self.at[v as usize]))
    }

    pub(super) fn point(&self, spot: &Spot) -> Point {
        self.facet(spot.triangle).at(spot.shares)
    }

    /// Returns a position as a point of a triangle; `None` if no triangle uses it.
    pub(super) fn corner(&self, v: u32) -> Option<Spot> {
        let triangle = *self.around(v).first()?;
        let corner = self.triangles[triangle as usize].iter().position(|&corner| corner == v);
        Some(Spot { triangle, shares: [0, 1, 2].map(|k| f64::from(u8::from(corner == Some(k)))) })
    }

    /// Returns, for each position, the sum of its squared barycentric weights over evenly spread
    /// points. The points represent twice the area of the surface. Each of the three corners gets
    /// 1/6 of a triangle's area.
    pub(super) fn masses(&self) -> Vec<f64> {
        let areas: Vec<f64> =
            (0..self.triangles.len() as u32).map(|triangle| self.facet(triangle).area()).collect();
        let sum: f64 = areas.iter().sum();
        let mut masses = vec![0.0; self.at.len()];
        for (corners, area) in self.triangles.iter().zip(areas).filter(|(_, area)| *area > 0.0) {
            corners.iter().for_each(|&v| masses[v as usize] += area / sum / 3.0);
        }
        masses
    }

    /// Returns the triangles in a form from which points are sampled.
    pub(super) fn side(&self) -> Side {
        Side::of((0..self.triangles.len() as u32).map(|triangle| self.facet(triangle)))
    }

    /// Returns the squared distance of a point from a triangle, and the nearest point of the
    /// triangle.
    fn nearest_in(&self, point: Point, triangle: u32) -> (f64, Spot) {
        #[cfg(test)]
        tests::LOOKED_AT.set(tests::LOOKED_AT.get() + 1);
        let (square, shares) = self.facet(triangle).nearest(point);
        (square, Spot { triangle, shares })
    }

    /// Finds the nearest point among the triangles around a spot, in order of distance. Triangles
    /// that are farther away are also expanded, because their neighbours may be nearer.
    pub(super) fn nearest_around(&self, point: Point, spot: Spot) -> Spot {
        let mut best = self.nearest_in(point, spot.triangle);
        // The squares are non-negative, so their bit patterns sort like their values.
        let mut queue = BinaryHeap::from([Reverse((best.0.to_bits(), spot.triangle))]);
        let mut seen = HashSet::from([spot.triangle]);
        while let Some(Reverse((_, triangle))) = queue.pop() {
            for v in self.triangles[triangle as usize] {
                for &near in self.around(v) {
                    if seen.len() >= MAX_WIDE {
                        return best.1;
                    }
                    if seen.insert(near) {
                        let found = self.nearest_in(point, near);
                        queue.push(Reverse((found.0.to_bits(), near)));
                        if found.0 < best.0 {
                            best = found;
                        }
                    }
                }
            }
        }
        best.1
    }

    /// Finds the nearest point by a walk that starts at a triangle. With `stays`, a point inside
    /// that triangle is returned at once.
    pub(super) fn nearest(&self, point: Point, start: u32, stays: bool) -> Spot {
        let (mut least, mut spot) = self.nearest_in(point, start);
        // The triangles around a corner of high valence are visited once, and not at all with
        // `stays`.
        let mut known = None;
        for _ in 0..MAX_STEPS {
            if stays && spot.is_inside() {
                break;
            }
            let from = spot.triangle;
            let corners = self.triangles[from as usize].into_iter().zip(spot.shares);
            for (v, _) in corners.filter(|&(_, share)| share > 0.0) {
                let around = self.around(v);
                let step = around.len().div_ceil(MAX_AROUND).max(1);
                if step > 1 && (stays || known == Some(v)) {
                    continue;
                }
                if step > 1 {
                    known = Some(v);
                }
                for &near in around.iter().step_by(step).filter(|&&near| near != from) {
                    let found = self.nearest_in(point, near);
                    if found.0 < least {
                        (least, spot) = found;
                    }
                }
            }
            if spot.triangle == from {
                break;
            }
        }
        spot
    }
}

/// Returns the unit vector, or the zero vector if the input has no direction.
pub(super) fn unit(vector: Point) -> Point {
    let length = dot(vector, vector).sqrt();
    if length > 0.0 && length.is_finite() { vector.map(|x| x / length) } else { [0.0; 3] }
}

#[cfg(test)]
pub(super) mod tests {
    use std::cell::Cell;

    use super::*;
    use tristrip::random::Random;

    thread_local! {
        /// The number of triangles that the searches of this thread have visited.
        pub(in crate::simplify::fit) static LOOKED_AT: Cell<usize> = const { Cell::new(0) };
    }

    /// A strip of triangles in the shape of a U. The path between its ends is long, and the
    /// distance rises along it before it falls.
    fn bent(length: usize) -> FitSurface {
        let at: Vec<Point> = (0..2 * length)
            .map(|v| {
                let along = std::f64::consts::PI * 1.8 * (v / 2) as f64 / (length - 1) as f64;
                [along.cos(), along.sin(), (v % 2) as f64]
            })
            .collect();
        let corners: Vec<u32> = (0..2 * length as u32 - 2).flat_map(|v| [v, v + 1, v + 2]).collect();
        FitSurface::new(&Faces::from_triangles(corners).unwrap(), at)
    }

    #[test]
    fn wide_searches_find_what_short_ones_miss() {
        let surface = bent(40);
        let last = surface.triangles.len() as u32 - 1;
        let mut random = Random::new(3);
        let mut number = || random.below(1000) as f64 / 1000.0;
        let mut missed = 0;
        for _ in 0..200 {
            let point = [2.0 * number() - 1.0, 2.0 * number() - 1.0, number()];
            let squares = (0..=last).map(|triangle| surface.facet(triangle).nearest(point).0);
            let least = squares.fold(f64::INFINITY, f64::min);
            let short = surface.nearest(point, 0, false);
            let wide = surface.nearest_around(point, short);
            let square = |spot: Spot| surface.facet(spot.triangle).nearest(point).0;
            assert!((square(wide) - least).abs() < 1e-12, "{point:?}");
            missed += usize::from(square(short) > least + 1e-12);
        }
        assert!((10..190).contains(&missed), "{missed}");
    }
}
