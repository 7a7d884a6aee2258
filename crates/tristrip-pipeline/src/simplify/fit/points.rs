//! Sample points of both surfaces, each with its nearest point on the other surface.

use rayon::prelude::*;
use tristrip::random::Random;

use super::equations::{Equations, Pull};
use super::surface::{FitSurface, Point, Spot, unit};
use crate::surface_change::{Facet, dot, sub};

/// The number of points per triangle of the simplified surface, on each surface.
const POINTS_PER_TRIANGLE: f64 = 12.0;
/// The maximum number of points on each surface.
const MAX_POINTS: f64 = 4_000_000.0;
/// The minimum and maximum number of points of a triangle, relative to the mean. Each vertex needs
/// some points, and no triangle should get most of them.
const MIN_SHARE: f64 = 0.5;
const LARGEST_SHARE: f64 = 4.0;
/// The maximum number of points of a triangle that are tried as the start of a search.
const MAX_STARTS: usize = 16;
/// Points farther away than this multiple of the root mean square get a second, wider search.
const FAR: f64 = 8.0;

/// A pair of points, one on each surface. One point is fixed. The other point is found by a search.
#[derive(Debug, Clone, Copy)]
struct Pair {
    original: Spot,
    simplified: Spot,
    /// The fraction of the area that the point represents; zero for vertices.
    weight: f64,
}

/// The points of both surfaces.
pub(super) struct Points {
    /// The points of the original with their nearest points on the simplified surface, and the
    /// reverse.
    of_original: Vec<Pair>,
    of_simplified: Vec<Pair>,
    /// A squared distance that counts as zero. Position rounding causes distances of this size.
    negligible: f64,
}

impl Points {
    /// Samples points on both surfaces and finds the nearest point of each on the other surface.
    ///
    /// `starts` has, for each triangle of the original, the simplified triangle at which its
    /// searches start. Removed components have no such triangle and get no points. The first
    /// positions of the original are those of the simplified surface.
    pub(super) fn new(original: &FitSurface, simplified: &FitSurface, starts: &[Option<u32>]) -> Self {
        let mut random = Random::new(0);
        // 1. The original. All triangles that collapsed to one triangle share the points of that
        //    triangle.
        let (original_side, simplified_side) = (original.side(), simplified.side());
        let mut areas = vec![0.0; simplified.triangles.len()];
        for (facet, start) in original_side.facets().iter().zip(starts) {
            start.iter().for_each(|&start| areas[start as usize] += facet.area());
        }
        let spread = Spread::new(&areas);
        let mut of_original = Vec::new();
        let expected =
            |number: usize, area: f64| starts[number].map_or(0.0, |s| spread.points(s as usize, area));
        original_side.visit(expected, &mut random, |number, _, shares| {
            let pair = |start| Pair {
                original: Spot { triangle: number as u32, shares },
                simplified: Spot { triangle: start, shares },
                weight: spread.weights[start as usize],
            };
            of_original.extend(starts[number].map(pair));
        });
        // The vertices of the original, evenly selected, measure the maximum distance. They have no
        // weight.
        let vertices = original.at.len() as u32;
        let step = (vertices as usize).div_ceil(of_original.len().max(1)).max(1);
        of_original.extend((0..vertices).step_by(step).filter_map(|v| {
            let original = original.corner(v)?;
            let start = starts[original.triangle as usize]?;
            Some(Pair { original, simplified: Spot { triangle: start, ..original }, weight: 0.0 })
        }));
        let all = vec![true; simplified.triangles.len()];
        let negligible = (f64::from(f32::EPSILON) * original_side.diagonal()).powi(2);
        let mut points = Self { of_original, of_simplified: Vec::new(), negligible };
        points.search_simplified(original, simplified, &all, false);
        // 2. The simplified surface. Its searches start at the points that were found in the same
        //    triangle.
        points.of_original.sort_by_key(|pair| pair.simplified.triangle);
        let found = &points.of_original;
        let areas: Vec<f64> = simplified_side.facets().iter().map(Facet::area).collect();
        let spread = Spread::new(&areas);
        let mut of_simplified = Vec::new();
        simplified_side.visit(
            |number, area| spread.points(number, area),
            &mut random,
            |number, facet, shares| {
                let spot = Spot { triangle: number as u32, shares };
                let first = found.partition_point(|pair| pair.simplified.triangle < spot.triangle);
                let count = found[first..].partition_point(|pair| pair.simplified.triangle == spot.triangle);
                let near = found[first..first + count].iter().step_by(count.div_ceil(MAX_STARTS).max(1));
                let at = facet.at(shares);
                let square = |pair: &Pair| {
                    let rest = sub(simplified.point(&pair.simplified), at);
                    dot(rest, rest)
                };
                let nearest =
                    near.min_by(|a, b| square(a).total_cmp(&square(b))).map(|pair| pair.original.triangle);
                let start = nearest
                    .or_else(|| facet.vertices().iter().find_map(|&v| original.around(v).first().copied()));
                let weight = spread.weights[number];
                let pair =
                    |start| Pair { original: Spot { triangle: start, shares }, simplified: spot, weight };
                of_simplified.extend(start.map(pair));
            },
        );
        // The vertices of the simplified surface lie on the original.
        let corners = (0..simplified.at.len() as u32).filter_map(|v| {
            let start = *original.around(v).first()?;
            let simplified = simplified.corner(v)?;
            Some(Pair { original: Spot { triangle: start, ..simplified }, simplified, weight: 0.0 })
        });
        of_simplified.extend(corners);
        points.of_simplified = of_simplified;
        points.search_original(original, simplified, &all, false);
        // The limit uses the count, not the area: at most 1/64 of any squares exceed 64 times their
        // mean.
        let pairs = || points.of_original.iter().chain(&points.of_simplified);
        let squares: f64 = pairs().map(|pair| pair.square(original, simplified)).sum();
        let limit = FAR * FAR * squares / pairs().count().max(1) as f64;
        points.search_beyond(original, simplified, &all, limit.max(negligible));
        points
    }

    /// Repeats the searches near the current points, after some triangles of the simplified surface
    /// have moved.
    pub(super) fn search(&mut self, original: &FitSurface, simplified: &FitSurface, has_moved: &[bool]) {
        self.search_simplified(original, simplified, has_moved, true);
        self.search_original(original, simplified, has_moved, true);
    }

    fn search_simplified(
        &mut self,
        original: &FitSurface,
        simplified: &FitSurface,
        has_moved: &[bool],
        stays: bool,
    ) {
        Pair::of(&mut self.of_original, has_moved).for_each(|pair| {
            let point = original.point(&pair.original);
            pair.simplified = simplified.nearest(point, pair.simplified.triangle, stays);
        });
    }

    fn search_original(
        &mut self,
        original: &FitSurface,
        simplified: &FitSurface,
        has_moved: &[bool],
        stays: bool,
    ) {
        Pair::of(&mut self.of_simplified, has_moved).for_each(|pair| {
            let point = simplified.point(&pair.simplified);
            pair.original = original.nearest(point, pair.original.triangle, stays);
        });
    }

    /// Repeats the search with a wider range for points beyond a squared distance, because the walk
    /// from triangle to neighbour may have ended too early.
    fn search_beyond(
        &mut self,
        original: &FitSurface,
        simplified: &FitSurface,
        has_moved: &[bool],
        limit: f64,
    ) {
        let is_far = |pair: &Pair| pair.square(original, simplified) > limit;
        Pair::of(&mut self.of_original, has_moved).filter(|pair| is_far(pair)).for_each(|pair| {
            let point = original.point(&pair.original);
            pair.simplified = simplified.nearest_around(point, pair.simplified);
        });
        Pair::of(&mut self.of_simplified, has_moved).filter(|pair| is_far(pair)).for_each(|pair| {
            let point = simplified.point(&pair.simplified);
            pair.original = original.nearest_around(point, pair.original);
        });
    }

    /// Returns the sum of the mean squared distances in both directions.
    pub(super) fn mean_squares(&self, original: &FitSurface, simplified: &FitSurface) -> f64 {
        let mean = |pairs: &[Pair]| {
            pairs.iter().map(|pair| pair.weight * pair.square(original, simplified)).sum::<f64>()
        };
        mean(&self.of_original) + mean(&self.of_simplified)
    }

    /// Returns the maximum squared distance, or the negligible distance if that is larger.
    pub(super) fn largest_square(&self, original: &FitSurface, simplified: &FitSurface) -> f64 {
        let largest = |pairs: &[Pair]| {
            let squares = pairs.par_iter().map(|pair| pair.square(original, simplified));
            squares.reduce(|| 0.0, f64::max)
        };
        largest(&self.of_original).max(largest(&self.of_simplified)).max(self.negligible)
    }

    /// Returns which triangles of the simplified surface, among those that have moved, have points
    /// beyond a squared distance.
    pub(super) fn beyond(
        &mut self,
        original: &FitSurface,
        simplified: &FitSurface,
        has_moved: &[bool],
        limit: f64,
    ) -> Vec<u32> {
        self.search_beyond(original, simplified, has_moved, limit);
        let is_far = |pair: &&Pair| pair.square(original, simplified) > limit;
        let mut far = Vec::new();
        for pairs in [&mut self.of_original, &mut self.of_simplified] {
            let pairs = Pair::of(pairs, has_moved).map(|pair| &*pair);
            far.par_extend(pairs.filter(is_far).map(|pair| pair.simplified.triangle));
        }
        far
    }

    /// Returns the equations of all points.
    pub(super) fn equations<'a>(&self, original: &FitSurface, simplified: &'a FitSurface) -> Equations<'a> {
        let mut equations = Equations::new(&simplified.triangles, simplified.masses());
        for (pairs, is_of_original) in [(&self.of_original, true), (&self.of_simplified, false)] {
            for pair in pairs.iter().filter(|pair| pair.weight > 0.0) {
                let rest = pair.rest(original, simplified);
                let (surface, found) =
                    if is_of_original { (simplified, &pair.simplified) } else { (original, &pair.original) };
                let normal = if found.is_inside() { surface.facet(found.triangle).normal() } else { rest };
                let Spot { triangle, shares } = pair.simplified;
                equations.add(&Pull { triangle, shares, rest, normal: unit(normal), weight: pair.weight });
            }
        }
        equations
    }
}

/// The distribution of points over triangles, or over the areas that belong to them.
struct Spread {
    /// The number of points per unit area.
    densities: Vec<f64>,
    /// The fraction of the total area that a point represents.
    weights: Vec<f64>,
}

impl Spread {
    fn new(areas: &[f64]) -> Self {
        let (sum, count) = (areas.iter().sum::<f64>(), areas.len() as f64);
        let mean = POINTS_PER_TRIANGLE.min(MAX_POINTS / count.max(1.0));
        let points = |area: f64| (area / sum * count).clamp(MIN_SHARE, LARGEST_SHARE) * mean;
        let of = |value: &dyn Fn(f64) -> f64| -> Vec<f64> {
            areas.iter().map(|&area| if area > 0.0 { value(area) } else { 0.0 }).collect()
        };
        Self { densities: of(&|area| points(area) / area), weights: of(&|area| area / sum / points(area)) }
    }

    /// Returns the number of points for a part of the area of a triangle.
    fn points(&self, triangle: usize, area: f64) -> f64 {
        self.densities[triangle] * area
    }
}

impl Pair {
    /// Returns the pairs on triangles of the simplified surface that have moved.
    fn of<'a>(pairs: &'a mut [Self], has_moved: &'a [bool]) -> impl ParallelIterator<Item = &'a mut Self> {
        pairs.par_iter_mut().filter(|pair| has_moved[pair.simplified.triangle as usize])
    }

    /// Returns the vector from the simplified surface to the original.
    fn rest(&self, original: &FitSurface, simplified: &FitSurface) -> Point {
        sub(original.point(&self.original), simplified.point(&self.simplified))
    }

    fn square(&self, original: &FitSurface, simplified: &FitSurface) -> f64 {
        let rest = self.rest(original, simplified);
        dot(rest, rest)
    }
}
