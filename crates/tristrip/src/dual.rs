//! The dual graph: faces connected across shared edges.
//!
//! A half-edge is a corner of a face and represents the edge from that corner to the next one. Two
//! half-edges with opposite directions between the same two vertices are *twins*. A pair of twins
//! is an arc of the graph.
//!
//! ```text
//!        c                  half-edge 3t + 0: a → b      its twin: b → a in the face below
//!       / \                 half-edge 3t + 1: b → c
//!      /   \                half-edge 3t + 2: c → a
//!     a ──▶ b   face t
//!     a ◀── b   neighbour   faces with consistent winding traverse the edge in opposite directions
//! ```
//!
//! # Edges of more than two faces
//! Each half-edge is compared with the last eight unpaired half-edges over the same edge. It is
//! paired with the most recent one of opposite direction whose face does not fold back onto its own
//! face. Two faces fold back if both have the same third corner, like a face and its own reverse.
//! Faces that fold back are paired last, in order. Half-edges with the same direction belong to
//! neighbours with inconsistent winding and are never paired.
//!
//! # Complexity
//! O(n) time for meshes of bounded valence, O(n log n) in the worst case. The graph takes 12 bytes
//! per triangle. Building it takes another 12 bytes per triangle and 12 bytes per vertex. All
//! vertices up to the highest one in use count, unless the mesh uses only a few of them. Each
//! thread after the first needs 8 bytes per vertex, and meshes of more than a million triangles
//! need another 12 bytes per triangle.

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
use pair::{NO_TWIN, pair};

use crate::error::Error;
use crate::ids::{FaceId, HalfEdge};
use crate::mesh::Faces;
use crate::union_find::UnionFind;

/// Number of corners above which vertices are renumbered before the pairing, whose result does not
/// depend on the numbers. In larger meshes a vertex leaves the processor's caches before its next
/// use, unless the vertex numbers follow the order of the faces.
const RENUMBER_ABOVE: usize = 3 << 20;

/// Faces connected across shared edges.
///
/// ```
/// use tristrip::{DualGraph, Faces, HalfEdge};
/// let faces = Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?;
/// let graph = DualGraph::new(&faces);
/// let twins: Vec<Option<HalfEdge>> = graph.half_edge_twins().collect();
/// assert_eq!(twins, [None, Some(HalfEdge(3)), None, Some(HalfEdge(1)), None, None]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct DualGraph {
    /// The twin of each half-edge, `NO_TWIN` at a boundary.
    twins: Vec<u32>,
    shape: FaceShape,
    /// Whether it is known that no two half-edges have the same direction over the same vertices.
    is_simple: bool,
}

/// Graphs are equal if they connect the same half-edges, regardless of how they were built.
impl PartialEq for DualGraph {
    fn eq(&self, other: &Self) -> bool {
        self.twins == other.twins && self.shape == other.shape
    }
}

impl Eq for DualGraph {}

#[derive(Debug, Clone, PartialEq, Eq)]
enum FaceShape {
    Triangles,
    Polygons { offsets: Vec<u32>, face_of: Vec<u32> },
}

impl FaceShape {
    /// Returns the first half-edge of a face.
    fn first_half_edge(&self, face: u32) -> u32 {
        match self {
            Self::Triangles => 3 * face,
            Self::Polygons { offsets, .. } => offsets[face as usize],
        }
    }
}

impl DualGraph {
    /// Connects the faces across shared edges. The source of this module describes the rule for
    /// edges of more than two faces.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces};
    /// // The first and the third triangle traverse the edge from 1 to 2, the second one from 2 to
    /// // 1.
    /// let graph = DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 2, 1, 3, 1, 2, 4])?);
    /// assert_eq!(graph.half_edge_twins().flatten().count(), 2);
    /// assert_eq!(graph.components().1, 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(faces: &Faces) -> Self {
        let compact = faces.compact();
        let renumbered;
        let faces = if compact.corner_count() > RENUMBER_ABOVE {
            renumbered = compact.in_order_of_use();
            &renumbered
        } else {
            &*compact
        };
        if faces.as_triangles().is_some() {
            let (twins, is_simple) = pair(&TriangleCorners { corners: faces.corners() });
            return Self { twins, shape: FaceShape::Triangles, is_simple };
        }
        let (offsets, face_of) = polygon_shape(faces);
        let corners = PolygonCorners { corners: faces.corners(), offsets: &offsets, face_of: &face_of };
        let (twins, is_simple) = pair(&corners);
        Self { twins, shape: FaceShape::Polygons { offsets, face_of }, is_simple }
    }

    /// Creates the graph of triangles from the twin of each half-edge. Twins must refer to each
    /// other.
    pub(crate) fn of_triangle_twins(twins: impl IntoIterator<Item = Option<u32>>) -> Self {
        Self::from_triangle_twins(twins.into_iter().map(|twin| twin.unwrap_or(NO_TWIN)).collect())
    }

    /// Creates the graph of triangles from packed twins, with `u32::MAX` at a boundary.
    pub(crate) fn from_triangle_twins(twins: Vec<u32>) -> Self {
        Self { twins, shape: FaceShape::Triangles, is_simple: false }
    }

    /// Counts the faces, which are the nodes of the graph.
    ///
    /// ```
    #[doc = include_str!("dual/example.txt")]
    /// assert_eq!((graph.face_count(), plan.triangulation().graph().face_count()), (2, 3));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn face_count(&self) -> usize {
        match &self.shape {
            FaceShape::Triangles => self.twins.len() / 3,
            FaceShape::Polygons { offsets, .. } => offsets.len() - 1,
        }
    }

    /// Returns whether every face is a triangle.
    pub(crate) fn is_of_triangles(&self) -> bool {
        self.shape == FaceShape::Triangles
    }

    /// Counts the half-edges, one per corner.
    pub(crate) fn half_edge_count(&self) -> usize {
        self.twins.len()
    }

    /// Iterates over the twins of the half-edges of all faces, in order. The twin is `None` at a
    /// boundary.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces};
    /// let graph = DualGraph::new(&Faces::from_polygons([[0, 1, 2, 3], [1, 0, 4, 5]])?);
    /// let boundary = graph.half_edge_twins().filter(|twin| twin.is_none()).count();
    /// assert_eq!((graph.half_edge_twins().len(), boundary), (8, 6));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn half_edge_twins(&self) -> impl ExactSizeIterator<Item = Option<HalfEdge>> {
        self.twins.iter().map(|&twin| (twin != NO_TWIN).then_some(HalfEdge(twin)))
    }

    /// Checks that the graph connects these faces: it has the same half-edges, and twins have the
    /// same two vertices.
    pub(crate) fn check_faces(&self, faces: &Faces) -> Result<(), Error> {
        let wrong = |found: String| Error::Parameter {
            name: "graph",
            found,
            expected: "the dual graph of the faces",
        };
        let (here, there) = (self.twins.len(), faces.corner_count());
        let same_faces = match (&self.shape, faces.offsets()) {
            (FaceShape::Triangles, None) => true,
            (FaceShape::Polygons { offsets, .. }, Some(expected)) => offsets == expected,
            _ => false,
        };
        if here != there || !same_faces {
            return Err(wrong(format!("{here} half-edges of {} faces", self.face_count())));
        }
        let runs_over = |h: u32| [faces.corners()[h as usize], faces.corners()[self.next(h) as usize]];
        let is_wrong = |(h, &twin): (u32, &u32)| {
            twin != NO_TWIN && {
                let [from, to] = runs_over(h);
                runs_over(twin) != [to, from]
            }
        };
        #[cfg(feature = "rayon")]
        {
            use rayon::prelude::*;
            let all = self.twins.par_iter().enumerate().with_min_len(1 << 16);
            if all.all(|(h, twin)| !is_wrong((h as u32, twin))) {
                return Ok(());
            }
        }
        match (0..).zip(&self.twins).find(|&pair| is_wrong(pair)) {
            Some((h, twin)) => Err(wrong(format!("the half-edges {h} and {twin} as twins"))),
            None => Ok(()),
        }
    }

    /// Returns the next half-edge of the face.
    fn next(&self, half_edge: u32) -> u32 {
        match &self.shape {
            FaceShape::Triangles => half_edge - half_edge % 3 + (half_edge + 1) % 3,
            FaceShape::Polygons { offsets, face_of } => {
                let face = face_of[half_edge as usize] as usize;
                if half_edge + 1 == offsets[face + 1] { offsets[face] } else { half_edge + 1 }
            }
        }
    }

    /// Returns the twin of a half-edge, or `None` at a boundary.
    #[inline]
    pub(crate) fn twin(&self, half_edge: HalfEdge) -> Option<HalfEdge> {
        let twin = self.twins[half_edge.0 as usize];
        (twin != NO_TWIN).then_some(HalfEdge(twin))
    }

    /// Returns the face of a half-edge.
    #[inline]
    pub(crate) fn face_of(&self, half_edge: HalfEdge) -> FaceId {
        match &self.shape {
            FaceShape::Triangles => FaceId(half_edge.0 / 3),
            FaceShape::Polygons { face_of, .. } => FaceId(face_of[half_edge.0 as usize]),
        }
    }

    /// Iterates over the half-edges of a face in winding order.
    pub(crate) fn half_edges(&self, face: FaceId) -> impl DoubleEndedIterator<Item = HalfEdge> + use<> {
        let range = match &self.shape {
            FaceShape::Triangles => 3 * face.0..3 * face.0 + 3,
            FaceShape::Polygons { offsets, .. } => offsets[face.0 as usize]..offsets[face.0 as usize + 1],
        };
        range.map(HalfEdge)
    }

    /// Iterates over the faces that share an edge with this one, in winding order. A face that
    /// shares two edges occurs twice.
    pub(crate) fn neighbours(&self, face: FaceId) -> impl Iterator<Item = FaceId> {
        self.half_edges(face).filter_map(|h| self.twin(h)).map(|h| self.face_of(h))
    }

    /// Returns the index of the twin of a half-edge, or `None` at a boundary. Used in inner loops.
    #[inline]
    pub(crate) fn twin_of(&self, half_edge: u32) -> Option<u32> {
        let twin = self.twins[half_edge as usize];
        (twin != NO_TWIN).then_some(twin)
    }

    /// Returns the packed twins, for inner loops: the twin of each half-edge, or `u32::MAX`.
    pub(crate) fn twins(&self) -> &[u32] {
        &self.twins
    }

    /// Iterates over the twins of a triangle's half-edges. Used in inner loops.
    #[inline]
    pub(crate) fn twins_of(&self, triangle: u32) -> impl Iterator<Item = u32> {
        let first = 3 * triangle as usize;
        self.twins[first..first + 3].iter().copied().filter(|&twin| twin != NO_TWIN)
    }

    /// Iterates over the number of neighbours of each triangle, in a graph of triangles.
    pub(crate) fn neighbour_counts(&self) -> impl Iterator<Item = u8> {
        let (triangles, _) = self.twins.as_chunks::<3>();
        triangles.iter().map(|twins| twins.iter().map(|&twin| u8::from(twin != NO_TWIN)).sum())
    }

    /// Returns whether it is known that no two half-edges have the same direction over the same
    /// vertices. Every edge then has one face, or two of opposite direction.
    pub(crate) fn is_simple(&self) -> bool {
        self.is_simple
    }

    /// Counts the half-edges without a twin.
    pub(crate) fn boundary_count(&self) -> usize {
        self.twins.iter().filter(|&&twin| twin == NO_TWIN).count()
    }

    /// Counts the faces without a neighbour.
    pub(crate) fn isolated_count(&self) -> usize {
        if let FaceShape::Triangles = self.shape {
            return self.neighbour_counts().filter(|&count| count == 0).count();
        }
        (0..self.face_count() as u32).filter(|&face| self.neighbours(FaceId(face)).next().is_none()).count()
    }

    /// Sets the twin of one half-edge. The caller must set the other side as well.
    #[inline]
    pub(crate) fn set_twin(&mut self, half_edge: u32, twin: Option<u32>) {
        self.is_simple = false;
        self.twins[half_edge as usize] = twin.unwrap_or(NO_TWIN);
    }

    /// Returns whether a cover of this many paths has the minimum, one path per connected
    /// component.
    pub(crate) fn has_components(&self, path_count: usize) -> bool {
        path_count <= 1 || self.components().1 == path_count
    }

    /// Returns the connected component of each face and the number of components. Components are
    /// numbered in order of their first faces.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces};
    /// let graph = DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 3, 4, 5, 2, 1, 6])?);
    /// assert_eq!(graph.components(), (vec![0, 1, 0], 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn components(&self) -> (Vec<u32>, usize) {
        let mut sets = self.connected_faces();
        // The root of a set is its first face, so the components are in the order of their first
        // faces.
        let mut count = 0;
        let mut component = vec![0; self.face_count()];
        for face in 0..self.face_count() as u32 {
            let root = sets.find(face);
            component[face as usize] = if root == face { count } else { component[root as usize] };
            count += u32::from(root == face);
        }
        (component, count as usize)
    }

    /// Counts the connected components.
    pub(crate) fn component_count(&self) -> usize {
        let sets = self.connected_faces();
        (0..self.face_count() as u32).filter(|&face| sets.is_root(face)).count()
    }

    /// Returns the sets of connected faces.
    fn connected_faces(&self) -> UnionFind {
        let mut sets = UnionFind::new(self.face_count());
        for face in 0..self.face_count() as u32 {
            let earlier = self.neighbours(FaceId(face)).filter(|next| next.0 < face);
            earlier.for_each(|next| sets.unite(face, next.0));
        }
        sets
    }

    /// Checks that twins refer to each other and never to a half-edge of the same face.
    ///
    /// # Errors
    /// Returns the first half-edge that violates this rule.
    ///
    /// ```
    #[doc = include_str!("dual/example.txt")]
    /// assert_eq!((graph.check(), plan.triangulation().graph().check()), (Ok(()), Ok(())));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn check(&self) -> Result<(), HalfEdge> {
        for h in (0..self.twins.len() as u32).map(HalfEdge) {
            let Some(twin) = self.twin(h) else { continue };
            let back = self.twins.get(twin.0 as usize).copied();
            if back != Some(h.0) || self.face_of(h) == self.face_of(twin) {
                return Err(h);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_faces_have_a_graph() {
        for polygons in [vec![], vec![vec![], vec![0]], vec![vec![u32::MAX, 0, 1], vec![0, u32::MAX, 1, 7]]] {
            let graph = DualGraph::new(&Faces::from_polygons(&polygons).unwrap());
            assert_eq!(graph.half_edge_twins().len(), polygons.iter().map(Vec::len).sum::<usize>());
            assert_eq!((graph.check(), graph.components().0.len()), (Ok(()), polygons.len()));
        }
    }
}
