//! Points of both surfaces, each with the point of the other one that is nearest to it.

use rayon::prelude::*;
use tristrip::random::Random;

use super::equations::{Equations, Pull};
use super::surface::{Point, Spot, Surface, unit};
use crate::surface_change::{dot, sub};

/// The points per triangle of the simplified surface, on each surface.
const POINTS_PER_TRIANGLE: f64 = 12.0;
/// The least and the most points on each surface.
const POINTS: (f64, f64) = (2_000.0, 4_000_000.0);

/// A point of each surface: one is fixed, the other is searched.
#[derive(Debug, Clone, Copy)]
struct Pair {
    original: Spot,
    simplified: Spot,
}

/// The points of both surfaces.
pub(super) struct Points {
    /// Those of the original, with the nearest of the simplified surface; then the reverse.
    of_original: Vec<Pair>,
    of_simplified: Vec<Pair>,
}

impl Points {
    /// Spreads points over both surfaces and searches the nearest of each; `starts` has the triangle of the simplified surface at which
    /// the searches for the points of a triangle of the original begin. None are in vanished components, which have no such triangle.
    /// The first positions of the original are those of the simplified surface.
    pub(super) fn new(original: &Surface, simplified: &Surface, starts: &[Option<u32>]) -> Self {
        let count = (simplified.triangles.len() as f64 * POINTS_PER_TRIANGLE).clamp(POINTS.0, POINTS.1);
        let mut random = Random::new(0);
        let mut of_original = Vec::new();
        original.side().sample(count, &mut random, |number, _, shares| {
            let pair = |start| Pair {
                original: Spot { triangle: number as u32, shares },
                simplified: Spot { triangle: start, shares },
            };
            of_original.extend(starts[number].map(pair));
        });
        let mut points = Self { of_original, of_simplified: Vec::new() };
        points.search_simplified(original, simplified, false);
        // The searches in the other direction begin at the points that were found in the same triangle.
        points.of_original.sort_by_key(|pair| pair.simplified.triangle);
        let found = &points.of_original;
        let mut of_simplified = Vec::new();
        simplified.side().sample(count, &mut random, |number, facet, shares| {
            let spot = Spot { triangle: number as u32, shares };
            let near = found.partition_point(|pair| pair.simplified.triangle < spot.triangle);
            let near = found[near..].iter().take_while(|pair| pair.simplified.triangle == spot.triangle);
            let at = facet.at(shares);
            let square = |pair: &Pair| {
                let rest = sub(simplified.point(&pair.simplified), at);
                dot(rest, rest)
            };
            let nearest =
                near.min_by(|a, b| square(a).total_cmp(&square(b))).map(|pair| pair.original.triangle);
            let start = nearest
                .or_else(|| facet.vertices().iter().find_map(|&v| original.around(v).first().copied()));
            let pair = |start| Pair { original: Spot { triangle: start, shares }, simplified: spot };
            of_simplified.extend(start.map(pair));
        });
        points.of_simplified = of_simplified;
        points.search_original(original, simplified, false);
        points
    }

    /// Searches the nearest points again after the simplified surface has moved, near where they were.
    pub(super) fn search(&mut self, original: &Surface, simplified: &Surface) {
        self.search_simplified(original, simplified, true);
        self.search_original(original, simplified, true);
    }

    fn search_simplified(&mut self, original: &Surface, simplified: &Surface, stays: bool) {
        self.of_original.par_iter_mut().for_each(|pair| {
            let point = original.point(&pair.original);
            pair.simplified = simplified.nearest(point, pair.simplified.triangle, stays);
        });
    }

    fn search_original(&mut self, original: &Surface, simplified: &Surface, stays: bool) {
        self.of_simplified.par_iter_mut().for_each(|pair| {
            let point = simplified.point(&pair.simplified);
            pair.original = original.nearest(point, pair.original.triangle, stays);
        });
    }

    /// Returns the sum of the mean squared distances in both directions.
    pub(super) fn mean_squares(&self, original: &Surface, simplified: &Surface) -> f64 {
        let mean = |pairs: &[Pair]| {
            let squares = pairs.iter().map(|pair| {
                let rest = pair.rest(original, simplified);
                dot(rest, rest)
            });
            squares.sum::<f64>() / pairs.len().max(1) as f64
        };
        mean(&self.of_original) + mean(&self.of_simplified)
    }

    /// Returns the equations of all points.
    pub(super) fn equations<'a>(&self, original: &Surface, simplified: &'a Surface) -> Equations<'a> {
        let mut equations = Equations::new(&simplified.triangles, simplified.at.len());
        let lists = [(&self.of_original, true), (&self.of_simplified, false)];
        for (pairs, is_of_original) in lists {
            let weight = 1.0 / pairs.len().max(1) as f64;
            for pair in pairs {
                let rest = pair.rest(original, simplified);
                let (surface, found) =
                    if is_of_original { (simplified, &pair.simplified) } else { (original, &pair.original) };
                let normal = if found.is_inside() { surface.facet(found.triangle).normal() } else { rest };
                let Spot { triangle, shares } = pair.simplified;
                equations.add(&Pull { triangle, shares, rest, normal: unit(normal), weight });
            }
        }
        equations
    }
}

impl Pair {
    /// Returns the vector from the simplified surface to the original.
    fn rest(&self, original: &Surface, simplified: &Surface) -> Point {
        sub(original.point(&self.original), simplified.point(&self.simplified))
    }
}
