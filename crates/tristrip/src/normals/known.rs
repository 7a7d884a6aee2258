//! Collects the normals of a mesh at each point.

use super::fit::fits;
use super::surface::{normals_of, scaled_to_one, vector};
use crate::csr::Csr;
use crate::mesh::{Mesh, PositionIds};
use crate::vector::{Point, dot};

/// The cosine of the maximum angle between a kept normal and the mean of the faces: 32 degrees.
/// Smaller angles replace normals of round shapes that looked right; larger ones keep normals of
/// removed faces.
const NEAR: f64 = 0.85;

/// The maximum number of normals compared at a point.
const MAX_NORMALS: usize = 32;

/// The vertex normals at the points of triangles.
pub(super) struct KnownNormals {
    /// The point of each corner.
    points: Vec<u32>,
    /// The unit normals at each point.
    normals: Csr<Point>,
}

impl KnownNormals {
    /// Collects the vertex normals of `before` at the points of `triangles`.
    pub(super) fn new(mesh: &Mesh, before: &[u32], triangles: &[u32]) -> Self {
        let mut ids = PositionIds::default();
        let points = ids.numbers(mesh.positions(), triangles);
        let point_count = points.iter().max().map_or(0, |&last| last as usize + 1);
        let mut pairs: Vec<(u32, u32)> =
            ids.numbers(mesh.positions(), before).into_iter().zip(before.iter().copied()).collect();
        pairs.retain(|&(point, _)| (point as usize) < point_count);
        pairs.sort_unstable();
        pairs.dedup();
        let unit = |(point, v)| Some((point, scaled_to_one(vector(normals_of(mesh)?, v))?));
        let known: Vec<(u32, Point)> = pairs.into_iter().filter_map(unit).collect();
        Self { points, normals: Csr::group_items(known.iter().copied(), point_count) }
    }

    /// Returns the known normal at a corner's point that is nearest to a unit vector, or that
    /// vector if none is near.
    pub(super) fn nearest(&self, corner: usize, mean: Point) -> Point {
        self.best(corner, mean).filter(|&normal| dot(normal, mean) >= NEAR).unwrap_or(mean)
    }

    /// Returns the known normal at a corner's point that is nearest to the face normal, if it fits.
    pub(super) fn fitting(&self, corner: usize, face: Point) -> Option<Point> {
        self.best(corner, face).filter(|&normal| fits(normal, face))
    }

    fn best(&self, corner: usize, to: Point) -> Option<Point> {
        let known = self.normals.row(self.points[corner]).iter().take(MAX_NORMALS);
        let best = known.map(|&normal| (dot(normal, to), normal)).max_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, normal)| normal)
    }
}
