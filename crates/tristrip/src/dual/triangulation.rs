//! Triangulations of prepared faces: the diagonals chosen by a method, and the dual graph of the
//! triangles.
//!
//! A face of k corners has k − 2 consecutive triangles, in face order. Triangles are connected
//! across shared edges, as their faces are, and across diagonals.
//!
//! # Complexity
//! 24 bytes per triangle and 4 per corner while building. If every face is a triangle, the
//! triangles are borrowed and take no memory.

use std::borrow::Cow;

use super::DualGraph;
use crate::error::Error;
use crate::ids::OptionalId;
use crate::mesh::Faces;
use crate::prepare::PreparedFaces;

/// The triangles of prepared faces and their dual graph.
///
/// ```
/// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, StripifyOptions, stripify::plan};
/// let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
/// let mesh = Mesh::new(corners, Faces::from_polygons([[0, 1, 2, 3]])?)?;
/// let prepared = PreparedFaces::new(&mesh, false);
/// let graph = DualGraph::new(prepared.faces());
/// let plan = plan(&prepared, &graph, &StripifyOptions::default())?;
/// assert_eq!(plan.triangulation().triangle_count(), 2);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Triangulation<'a> {
    triangles: Cow<'a, [u32]>,
    graph: Cow<'a, DualGraph>,
}

impl<'a> Triangulation<'a> {
    /// Borrows the faces if all are triangles; otherwise returns `None`.
    pub(crate) fn of_triangles(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> Option<Self> {
        let triangles = prepared.faces().as_triangles()?;
        Some(Self { triangles: Cow::Borrowed(triangles), graph: Cow::Borrowed(graph) })
    }

    /// Creates a triangulation from triangles and their dual graph. The triangles must triangulate
    /// the faces.
    pub(crate) fn from_parts(triangles: Vec<u32>, graph: DualGraph) -> Self {
        Self { triangles: Cow::Owned(triangles), graph: Cow::Owned(graph) }
    }

    /// Returns the same triangulation with owned data.
    pub(crate) fn into_owned<'b>(self) -> Triangulation<'b> {
        Triangulation::from_parts(self.triangles.into_owned(), self.graph.into_owned())
    }

    /// Triangulates every face as a fan around its first corner. Borrows the faces if all are
    /// triangles.
    ///
    /// # Errors
    /// The graph is not the dual graph of the faces.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, PreparedFaces, Triangulation};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_polygons([[0, 1, 2, 3, 4]])?)?;
    /// let prepared = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(prepared.faces());
    /// assert_eq!(Triangulation::fans(&prepared, &graph)?.triangles(), [0, 1, 2, 0, 2, 3, 0, 3, 4]);
    /// assert!(Triangulation::fans(&prepared, &DualGraph::new(&Faces::default())).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn fans(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> Result<Self, Error> {
        graph.check_faces(prepared.faces())?;
        Ok(Self::fan(prepared, graph))
    }

    /// Triangulates every face as a fan around its first corner. The graph must be that of the
    /// faces.
    pub(crate) fn fan(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> Self {
        Self::of_triangles(prepared, graph).unwrap_or_else(|| {
            let mut builder = TriangulationBuilder::new(prepared.faces(), graph);
            for (face, polygon) in prepared.faces().iter().enumerate() {
                (1..polygon.len() as u32 - 1).for_each(|i| {
                    builder.add(face, [0, i, i + 1]);
                });
            }
            builder.finish()
        })
    }

    /// Triangulates every face by alternate left and right turns from its first edge, which makes
    /// each face one strip without swaps (Evans et al. 1996, figure 5b).
    pub(crate) fn zigzag(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> Self {
        Self::of_triangles(prepared, graph).unwrap_or_else(|| {
            let mut builder = TriangulationBuilder::new(prepared.faces(), graph);
            for (face, polygon) in prepared.faces().iter().enumerate() {
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

    /// Returns the vertices of the triangles, three per triangle in winding order.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(plan.triangulation().triangles()[6..], [4, 5, 6]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Returns the dual graph of the triangles.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// // One diagonal: a pair of twins.
    /// assert_eq!(plan.triangulation().graph().half_edge_twins().flatten().count(), 2);
    /// assert_eq!(graph.half_edge_twins().flatten().count(), 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn graph(&self) -> &DualGraph {
        &self.graph
    }

    /// Counts the triangles.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!((plan.triangulation().triangle_count(), mesh.faces().face_count()), (3, 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangle_count(&self) -> usize {
        self.triangles.len() / 3
    }
}

/// Collects the triangles of the faces. The faces may be added in any order.
#[derive(Debug)]
pub(crate) struct TriangulationBuilder<'a> {
    faces: &'a Faces,
    graph: &'a DualGraph,
    triangles: Vec<u32>,
    /// The corner of the face at which an edge of a triangle starts; none for a diagonal.
    edges: Vec<OptionalId>,
    /// The next free triangle index of each face.
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
        Self {
            faces,
            graph,
            triangles: vec![0; corner_count],
            edges: vec![OptionalId::NONE; corner_count],
            next,
        }
    }

    /// Adds a triangle of a face, given by corner indices within the face, in the winding of the
    /// face. Returns the index of the triangle. Its edges are numbered from `corners[0]` on.
    pub(crate) fn add(&mut self, face: usize, corners: [u32; 3]) -> u32 {
        let triangle = self.next[face];
        self.next[face] += 1;
        let range = self.faces.range(face);
        for (i, &corner) in corners.iter().enumerate() {
            let after = corners[(i + 1) % 3];
            let slot = 3 * triangle as usize + i;
            self.triangles[slot] = self.faces.corners()[range.start + corner as usize];
            if after == corner + 1 || (after == 0 && corner as usize + 1 == range.len()) {
                self.edges[slot] = OptionalId::some(range.start as u32 + corner);
            }
        }
        triangle
    }

    /// Returns whether all triangles of all faces were added.
    fn is_complete(&self) -> bool {
        let mut end = 0;
        self.faces.iter().zip(&self.next).all(|(polygon, &next)| {
            end += polygon.len() as u32 - 2;
            next == end
        })
    }

    /// Connects the triangles. All triangles of all faces must have been added.
    pub(crate) fn finish(self) -> Triangulation<'a> {
        debug_assert!(self.is_complete(), "triangles of a face are missing");
        let mut at_corner = vec![OptionalId::NONE; self.faces.corner_count()];
        for (half_edge, corner) in self.edges.iter().enumerate() {
            if let Some(corner) = corner.get() {
                at_corner[corner as usize] = OptionalId::some(half_edge as u32);
            }
        }
        let mut twins = vec![OptionalId::NONE; self.edges.len()];
        let mut diagonals: Vec<(u32, u32, u32)> = Vec::new();
        let mut start = 0;
        for face in 0..self.faces.face_count() {
            let end = start + 3 * (self.faces.range(face).len() - 2);
            diagonals.clear();
            for half_edge in start..end {
                let Some(corner) = self.edges[half_edge].get() else {
                    let from = self.triangles[half_edge];
                    let to = self.triangles[if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }];
                    diagonals.push((from.min(to), from.max(to), half_edge as u32));
                    continue;
                };
                if let Some(twin) = self.graph.twin_of(corner) {
                    twins[half_edge] = at_corner[twin as usize];
                }
            }
            diagonals.sort_unstable();
            for pair in diagonals.chunks_exact(2) {
                twins[pair[0].2 as usize] = OptionalId::some(pair[1].2);
                twins[pair[1].2 as usize] = OptionalId::some(pair[0].2);
            }
            start = end;
        }
        Triangulation {
            triangles: Cow::Owned(self.triangles),
            graph: Cow::Owned(DualGraph::of_triangle_twins(twins.into_iter().map(OptionalId::get))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    #[test]
    fn connects_triangles_like_the_faces_and_across_diagonals() {
        // A hexagon with quads at two sides.
        let positions: Vec<[f32; 3]> = (0..6)
            .map(|i| (i as f32 * std::f32::consts::FRAC_PI_3).sin_cos())
            .chain([(3.0, 0.0), (3.0, 1.0), (-3.0, 0.0), (-3.0, 1.0)])
            .map(|(y, x)| [x, y, 0.0])
            .collect();
        let polygons = [vec![0, 1, 2, 3, 4, 5], vec![1, 0, 6, 7], vec![4, 3, 8, 9]];
        let mesh = Mesh::new(positions, Faces::from_polygons(polygons).unwrap()).unwrap();
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        for triangulation in [Triangulation::fan(&prepared, &graph), Triangulation::zigzag(&prepared, &graph)]
        {
            assert_eq!(triangulation.triangle_count(), prepared.faces().triangle_count());
            assert_eq!(triangulation.graph().check(), Ok(()));
            let again = DualGraph::new(&Faces::from_triangles(triangulation.triangles().to_vec()).unwrap());
            assert_eq!(triangulation.graph(), &again);
        }
    }
}
