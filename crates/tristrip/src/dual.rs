//! The dual graph: faces joined across the edges that they share.
//!
//! A half-edge is a corner of a face and stands for the edge from that corner to the next one of the face. Two half-edges of
//! opposite direction over the same two vertices are *twins*, and a pair of twins is an arc of the graph.
//!
//! ```text
//!        c                  half-edge 3t + 0: a → b      its twin: b → a in the face below
//!       / \                 half-edge 3t + 1: b → c
//!      /   \                half-edge 3t + 2: c → a
//!     a ──▶ b   face t
//!     a ◀── b   neighbour   Faces wound alike give the edge between them opposite directions.
//! ```
//!
//! # Edges of more than two faces
//! A half-edge is paired with the most recent one that waits, of the last eight over that edge, whose face does not fold back
//! onto its own (the same next corner seen from both sides: a face and its own reverse). Faces that fold back are paired only when
//! all else is done, in order. Half-edges of equal direction, that is neighbours with inconsistent winding, are never paired.
//!
//! # Complexity
//! O(n) time for meshes of bounded valence, O(n log n) at worst; 12 bytes a triangle, and while building 12 more and 12 for each
//! number up to the highest vertex in use, or for each vertex in use where those are few. Past a million triangles another 12 bytes.

mod corners;
mod pair;
mod report;
mod subgraph;
mod triangulation;

pub(crate) use corners::for_each_edge;
pub use report::MeshReport;
pub use triangulation::Triangulation;
pub(crate) use triangulation::TriangulationBuilder;

use corners::{PolygonCorners, TriangleCorners, polygon_shape};
use pair::pair;

use crate::ids::{FaceId, HalfEdge};
use crate::mesh::Faces;

/// Marks a half-edge without a twin inside the packed arrays.
const NONE: u32 = u32::MAX;
/// Faces of more corners have their vertices renumbered for the pairing, which does not ask for their names: the caches no longer
/// hold a vertex until it comes again, unless the numbers follow the faces.
const SCATTERED: usize = 3 << 20;

/// Faces joined across shared edges.
///
/// ```
/// use tristrip::{DualGraph, Faces, HalfEdge};
/// let faces = Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?;
/// let graph = DualGraph::new(&faces);
/// assert_eq!(graph.twin(HalfEdge(1)), Some(HalfEdge(3)));
/// assert_eq!(graph.twin(HalfEdge(0)), None);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DualGraph {
    twins: Vec<u32>,
    shape: Shape,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Shape {
    Triangles,
    Polygons { offsets: Vec<u32>, face_of: Vec<u32> },
}

impl DualGraph {
    /// Joins the faces across the edges that they share; see the module's head for the rule at edges of more than two faces.
    pub fn new(faces: &Faces) -> Self {
        let compact = faces.compact();
        let renumbered;
        let faces = if compact.corner_count() > SCATTERED {
            renumbered = compact.in_order_of_use();
            &renumbered
        } else {
            &*compact
        };
        if faces.as_triangles().is_some() {
            let twins = pair(&TriangleCorners { corners: faces.corners() });
            return Self { twins, shape: Shape::Triangles };
        }
        let (offsets, face_of) = polygon_shape(faces);
        let corners = PolygonCorners { corners: faces.corners(), offsets: &offsets, face_of: &face_of };
        Self { twins: pair(&corners), shape: Shape::Polygons { offsets, face_of } }
    }

    /// Creates the graph of triangles from the twin of each half-edge. The caller has paired the twins.
    pub(crate) fn of_triangle_twins(twins: impl IntoIterator<Item = Option<u32>>) -> Self {
        Self::from_triangle_twins(twins.into_iter().map(|twin| twin.unwrap_or(NONE)).collect())
    }

    /// Makes the graph of triangles from twins that the caller has paired.
    pub(crate) fn from_triangle_twins(twins: Vec<u32>) -> Self {
        Self { twins, shape: Shape::Triangles }
    }

    /// Counts the faces, the nodes of the graph.
    pub fn face_count(&self) -> usize {
        match &self.shape {
            Shape::Triangles => self.twins.len() / 3,
            Shape::Polygons { offsets, .. } => offsets.len() - 1,
        }
    }

    /// Counts the half-edges, which are as many as the corners.
    pub fn half_edge_count(&self) -> usize {
        self.twins.len()
    }

    /// Gives the half-edge on the other side, or `None` at a boundary.
    ///
    /// # Panics
    /// The half-edge is not one of this graph.
    #[inline]
    pub fn twin(&self, half_edge: HalfEdge) -> Option<HalfEdge> {
        let twin = self.twins[half_edge.0 as usize];
        (twin != NONE).then_some(HalfEdge(twin))
    }

    /// Gives the face that a half-edge belongs to.
    ///
    /// # Panics
    /// The graph is one of polygons and the half-edge is not one of it.
    #[inline]
    pub fn face_of(&self, half_edge: HalfEdge) -> FaceId {
        match &self.shape {
            Shape::Triangles => FaceId(half_edge.0 / 3),
            Shape::Polygons { face_of, .. } => FaceId(face_of[half_edge.0 as usize]),
        }
    }

    /// Walks over the half-edges of a face in its winding.
    ///
    /// # Panics
    /// The face is not one of this graph.
    pub fn half_edges(&self, face: FaceId) -> impl DoubleEndedIterator<Item = HalfEdge> + use<> {
        let range = match &self.shape {
            Shape::Triangles => 3 * face.0..3 * face.0 + 3,
            Shape::Polygons { offsets, .. } => offsets[face.0 as usize]..offsets[face.0 as usize + 1],
        };
        range.map(HalfEdge)
    }

    /// Walks over the faces that share an edge with this one, in its winding; one that shares two edges comes twice.
    ///
    /// # Panics
    /// The face is not one of this graph.
    pub fn neighbours(&self, face: FaceId) -> impl Iterator<Item = FaceId> {
        self.half_edges(face).filter_map(|h| self.twin(h)).map(|h| self.face_of(h))
    }

    /// Returns the half-edge on the other side by number, or `None` at a boundary, for inner loops.
    #[inline]
    pub(crate) fn twin_of(&self, half_edge: u32) -> Option<u32> {
        let twin = self.twins[half_edge as usize];
        (twin != NONE).then_some(twin)
    }

    /// Gives the packed twins for the inner loops: the other side of each half-edge, or `u32::MAX`.
    pub(crate) fn twins(&self) -> &[u32] {
        &self.twins
    }

    /// Sets the twin of one half-edge. The caller sets the other side, too.
    #[inline]
    pub(crate) fn set_twin(&mut self, half_edge: u32, twin: Option<u32>) {
        self.twins[half_edge as usize] = twin.unwrap_or(NONE);
    }

    /// Numbers the connected components: the component of each face, counted in order of their first faces, and their number.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces};
    /// let graph = DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 3, 4, 5, 2, 1, 6])?);
    /// assert_eq!(graph.components(), (vec![0, 1, 0], 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut component = vec![NONE; self.face_count()];
        let mut count = 0;
        let mut open = Vec::new();
        for first in 0..component.len() {
            if component[first] != NONE {
                continue;
            }
            component[first] = count;
            open.push(FaceId(first as u32));
            while let Some(face) = open.pop() {
                for next in self.neighbours(face) {
                    if component[next.0 as usize] == NONE {
                        component[next.0 as usize] = count;
                        open.push(next);
                    }
                }
            }
            count += 1;
        }
        (component, count as usize)
    }

    /// Checks that twins name each other and never a half-edge of the same face.
    ///
    /// # Errors
    /// The first half-edge at fault.
    pub fn check(&self) -> Result<(), HalfEdge> {
        for (h, &twin) in self.twins.iter().enumerate() {
            let h = HalfEdge(h as u32);
            if twin == NONE {
                continue;
            }
            let back = self.twins.get(twin as usize).copied();
            if back != Some(h.0) || self.face_of(h) == self.face_of(HalfEdge(twin)) {
                return Err(h);
            }
        }
        Ok(())
    }
}
