//! The faces of a surface, the edges between faces matched by position, and the vertex normals.

use crate::error::Error;
use crate::mesh::{Attribute, Mesh, PositionIds, check_corners, check_triangles, triangles_of};
use crate::vector::{Point, dot, normal_of};

/// An edge shared by two triangles in opposite directions. Corners are numbered across all
/// triangles.
pub(super) struct InnerEdge {
    /// For each end of the edge, its corner in both triangles.
    pub(super) ends: [[u32; 2]; 2],
}

impl InnerEdge {
    /// Returns the indices of the two triangles.
    pub(super) fn triangles(&self) -> [usize; 2] {
        self.ends[0].map(|corner| corner as usize / 3)
    }
}

/// Triangles over points, with their unit normals.
pub(super) struct TriangleNormals {
    /// The point of each corner. Vertices at the same position are one point.
    points: Vec<u32>,
    /// The unit normal of each triangle; `None` for one without area.
    pub(super) normals: Vec<Option<Point>>,
}

impl TriangleNormals {
    pub(super) fn new(mesh: &Mesh, triangles: &[u32]) -> Result<Self, Error> {
        check_triangles(triangles.len())?;
        check_corners(triangles, mesh.vertex_count())?;
        let points = PositionIds::default().numbers(mesh.positions(), triangles);
        let normals = triangles_of(triangles).map(|corners| unit_normal(positions(mesh, corners)));
        Ok(Self { points, normals: normals.collect() })
    }

    /// Finds the edges, by their points, that exactly two triangles share in opposite directions.
    pub(super) fn inner_edges(&self) -> Vec<InnerEdge> {
        // The points of an edge, lower index first, and the corner where the triangle enters the
        // edge.
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(self.points.len());
        for corner in 0..self.points.len() as u32 {
            let [a, b] = [corner, next(corner)].map(|corner| self.points[corner as usize]);
            if a != b {
                edges.push(([a.min(b), a.max(b)], corner));
            }
        }
        edges.sort_unstable();
        let is_opposite = |a: u32, b: u32| self.points[a as usize] == self.points[next(b) as usize];
        let inner = edges.chunk_by(|a, b| a.0 == b.0).filter_map(|uses| match *uses {
            [(_, a), (_, b)] if is_opposite(a, b) => Some(InnerEdge { ends: [[a, next(b)], [next(a), b]] }),
            _ => None,
        });
        inner.collect()
    }

    /// Returns the cosine of the angle between the triangles of an edge; `None` if one has no area.
    pub(super) fn cosine(&self, edge: &InnerEdge) -> Option<f64> {
        let [a, b] = edge.triangles().map(|triangle| self.normals[triangle]);
        Some(dot(a?, b?))
    }
}

/// Returns the next corner of the same triangle.
pub(super) fn next(corner: u32) -> u32 {
    if corner % 3 == 2 { corner - 2 } else { corner + 1 }
}

/// Returns the positions of a triangle's corners. The caller has checked the indices.
pub(super) fn positions(mesh: &Mesh, corners: [u32; 3]) -> [Point; 3] {
    corners.map(|v| mesh.positions()[v as usize].map(f64::from))
}

/// Returns the unit normal of a triangle; `None` if it has no area.
pub(super) fn unit_normal(corners: [Point; 3]) -> Option<Point> {
    scaled_to_one(normal_of(corners))
}

/// Returns a vector scaled to length 1; `None` if it is zero or not finite.
pub(super) fn scaled_to_one(vector: Point) -> Option<Point> {
    // Divide by the largest component first, so that squares neither overflow nor underflow.
    let largest = vector.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let scaled = vector.map(|x| x / largest);
    let length = dot(scaled, scaled).sqrt();
    Some(scaled.map(|x| x / length))
}

/// Returns the normals of a mesh, if it has any.
pub(super) fn normals_of(mesh: &Mesh) -> Option<&Attribute> {
    mesh.attributes().iter().find(|a| a.name == "NORMAL" && a.components == 3)
}

/// Returns a value with three components. Components that are not finite become zero.
pub(super) fn vector(attribute: &Attribute, vertex: u32) -> Point {
    let component =
        |k: usize| attribute.float(3 * vertex as usize + k).filter(|x| x.is_finite()).unwrap_or(0.0);
    [0, 1, 2].map(|k| component(k).into())
}
