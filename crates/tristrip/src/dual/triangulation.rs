//! Triangulations of a surface: which diagonals a method chose, and the dual graph of the triangles that they make.
//!
//! A face of k corners makes k − 2 triangles, which stand together, the faces in order. Across a face's own edges the
//! triangles are joined just as the faces are; across a diagonal, as the diagonal's two sides.
//!
//! # Complexity
//! 24 bytes a triangle and 4 a corner while it is built; nothing where every face is a triangle, which is borrowed.

use std::borrow::Cow;

use super::DualGraph;
use crate::ids::HalfEdge;
use crate::mesh::Faces;
use crate::prepare::PreparedFaces;

const NONE: u32 = u32::MAX;

/// The triangles of a surface and how they are joined.
#[derive(Debug, Clone)]
pub struct Triangulation<'a> {
    triangles: Cow<'a, [u32]>,
    graph: Cow<'a, DualGraph>,
}

impl<'a> Triangulation<'a> {
    /// Takes a surface of triangles as it is; `None` where it has a larger face.
    pub fn of_triangles(surface: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> Option<Self> {
        let triangles = surface.faces().as_triangles()?;
        Some(Self { triangles: Cow::Borrowed(triangles), graph: Cow::Borrowed(graph) })
    }

    /// Takes triangles and their dual graph, which the caller knows to be a triangulation of the surface.
    pub(crate) fn from_parts(triangles: Vec<u32>, graph: DualGraph) -> Self {
        Self { triangles: Cow::Owned(triangles), graph: Cow::Owned(graph) }
    }

    /// Cuts every face from its first corner.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, dual::Triangulation};
    /// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(corners, Faces::from_polygons([[0, 1, 2, 3]])?)?;
    /// let surface = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(surface.faces());
    /// assert_eq!(Triangulation::fan(&surface, &graph).triangles(), [0, 1, 2, 0, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn fan(surface: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> Self {
        Self::of_triangles(surface, graph).unwrap_or_else(|| {
            let mut builder = TriangulationBuilder::new(surface.faces(), graph);
            for (face, polygon) in surface.faces().iter().enumerate() {
                (1..polygon.len() as u32 - 1).for_each(|i| {
                    builder.add(face, [0, i, i + 1]);
                });
            }
            builder.finish()
        })
    }

    /// Cuts every face by alternate left and right turns from its first edge, so that it is one strip without a swap
    /// (Evans et al. 1996, figure 5b).
    ///
    /// ```
    /// # use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, dual::Triangulation};
    /// # let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// # let mesh = Mesh::new(corners, Faces::from_polygons([[0, 1, 2, 3]])?)?;
    /// let surface = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(surface.faces());
    /// assert_eq!(Triangulation::zigzag(&surface, &graph).triangles(), [0, 1, 3, 1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn zigzag(surface: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> Self {
        Self::of_triangles(surface, graph).unwrap_or_else(|| {
            let mut builder = TriangulationBuilder::new(surface.faces(), graph);
            for (face, polygon) in surface.faces().iter().enumerate() {
                let (mut low, mut high) = (0, polygon.len() as u32 - 1);
                let mut at_high = true;
                while high - low > 1 {
                    if at_high {
                        builder.add(face, [low, low + 1, high]);
                        low += 1;
                    } else {
                        builder.add(face, [low, high - 1, high]);
                        high -= 1;
                    }
                    at_high = !at_high;
                }
            }
            builder.finish()
        })
    }

    /// Gives three vertices for each triangle, in its winding.
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Gives the dual graph of the triangles.
    pub fn graph(&self) -> &DualGraph {
        &self.graph
    }

    /// Counts the triangles.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len() / 3
    }
}

/// Collects the triangles that a method cuts from the faces, in any order of the faces.
#[derive(Debug)]
pub(crate) struct TriangulationBuilder<'a> {
    faces: &'a Faces,
    graph: &'a DualGraph,
    triangles: Vec<u32>,
    /// The face's corner whose edge a triangle's edge is; `NONE` for a diagonal.
    edges: Vec<u32>,
    /// The next triangle of each face.
    next: Vec<u32>,
}

impl<'a> TriangulationBuilder<'a> {
    pub(crate) fn new(faces: &'a Faces, graph: &'a DualGraph) -> Self {
        let mut total = 0;
        let next = faces
            .iter()
            .map(|polygon| {
                let first = total;
                total += polygon.len() as u32 - 2;
                first
            })
            .collect();
        let corner_count = 3 * total as usize;
        Self { faces, graph, triangles: vec![NONE; corner_count], edges: vec![NONE; corner_count], next }
    }

    /// Adds a triangle of a face, by the places of its corners within the face, in the face's winding.
    /// Returns its number; its edges are numbered from `corners[0]` on.
    pub(crate) fn add(&mut self, face: usize, corners: [u32; 3]) -> u32 {
        let triangle = self.next[face];
        self.next[face] += 1;
        let range = self.faces.range(face);
        for (i, &corner) in corners.iter().enumerate() {
            let after = corners[(i + 1) % 3];
            let slot = 3 * triangle as usize + i;
            self.triangles[slot] = self.faces.corners()[range.start + corner as usize];
            if after == corner + 1 || (after == 0 && corner as usize + 1 == range.len()) {
                self.edges[slot] = range.start as u32 + corner;
            }
        }
        triangle
    }

    /// Joins the triangles. Every face must have got all of its own.
    pub(crate) fn finish(self) -> Triangulation<'a> {
        debug_assert!(self.triangles.iter().all(|&v| v != NONE), "a face has not got all of its triangles");
        let mut at_corner = vec![NONE; self.faces.corner_count()];
        for (half_edge, &corner) in self.edges.iter().enumerate() {
            if corner != NONE {
                at_corner[corner as usize] = half_edge as u32;
            }
        }
        let mut twins = vec![NONE; self.edges.len()];
        let mut diagonals: Vec<(u32, u32, u32)> = Vec::new();
        let mut start = 0;
        for face in 0..self.faces.face_count() {
            let end = start + 3 * (self.faces.range(face).len() - 2);
            diagonals.clear();
            for half_edge in start..end {
                let corner = self.edges[half_edge];
                if corner == NONE {
                    let from = self.triangles[half_edge];
                    let to = self.triangles[if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }];
                    diagonals.push((from.min(to), from.max(to), half_edge as u32));
                } else if let Some(twin) = self.graph.twin(HalfEdge(corner)) {
                    twins[half_edge] = at_corner[twin.0 as usize];
                }
            }
            diagonals.sort_unstable();
            for pair in diagonals.chunks_exact(2) {
                twins[pair[0].2 as usize] = pair[1].2;
                twins[pair[1].2 as usize] = pair[0].2;
            }
            start = end;
        }
        Triangulation {
            triangles: Cow::Owned(self.triangles),
            graph: Cow::Owned(DualGraph::from_triangle_twins(twins)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn joins_triangles_as_the_faces_and_across_diagonals() {
        // A hexagon with a quad on each of two sides.
        let positions: Vec<[f32; 3]> = (0..6)
            .map(|i| (i as f32 * std::f32::consts::FRAC_PI_3).sin_cos())
            .chain([(3.0, 0.0), (3.0, 1.0), (-3.0, 0.0), (-3.0, 1.0)])
            .map(|(y, x)| [x, y, 0.0])
            .collect();
        let polygons = [vec![0, 1, 2, 3, 4, 5], vec![1, 0, 6, 7], vec![4, 3, 8, 9]];
        let mesh = Mesh::new(positions, Faces::from_polygons(polygons).unwrap()).unwrap();
        let surface = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(surface.faces());
        for triangulation in [Triangulation::fan(&surface, &graph), Triangulation::zigzag(&surface, &graph)] {
            assert_eq!(triangulation.triangle_count(), surface.faces().triangle_count());
            assert_eq!(triangulation.graph().check(), Ok(()));
            let again = DualGraph::new(&Faces::from_triangles(triangulation.triangles().to_vec()).unwrap());
            assert_eq!(triangulation.graph(), &again);
        }
    }
}
