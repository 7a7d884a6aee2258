//! Mesh statistics: counts that determine how well a mesh can be stripped, and defects that users
//! should know about.
//!
//! # Algorithm
//! The pairing of the graph records whether any two half-edges have the same direction between the
//! same vertices. If there are none, every edge belongs to one face or to two faces with opposite
//! directions, and no face occurs twice. A half-edge without a twin is then a boundary edge.
//! Otherwise the half-edges are counted edge by edge, and faces are compared.
//!
//! # Complexity
//! O(n) time for meshes of bounded valence, O(n log n) in the worst case. Temporary memory: 8 bytes
//! per triangle and 1 per vertex, or 16 and 4 if the half-edges are counted.

use super::{DualGraph, for_each_edge};
use crate::csr::Csr;
use crate::mesh::{Faces, Mesh, vertex_bound};
use crate::prepare::{PreparedCounts, PreparedFaces};

/// Statistics of a mesh. Edges are counted over the prepared faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct MeshReport {
    /// Number of vertices, including unused ones.
    pub vertices: usize,
    /// Number of vertices that no face of the mesh uses.
    pub unreferenced_vertices: usize,
    /// Number of faces of the mesh, including degenerate faces.
    pub faces: usize,
    /// Number of triangles of the prepared faces, k − 2 per face of k corners.
    pub triangles: usize,
    /// Number of connected components of the dual graph.
    pub components: usize,
    /// Number of boundary edges, which belong to one face.
    pub boundary_edges: usize,
    /// Number of edges shared by more than two faces.
    pub non_manifold_edges: usize,
    /// Number of edges shared by two faces with inconsistent winding. No strip crosses such an
    /// edge.
    pub inconsistent_edges: usize,
    /// Number of faces that share no edge with another face.
    pub isolated_faces: usize,
    /// Number of faces with the same vertices and winding as an earlier face. Duplicate faces are
    /// drawn as well.
    pub duplicate_faces: usize,
    /// Counts of the changes made by the preparation of the faces.
    pub surface: PreparedCounts,
}

impl MeshReport {
    /// Computes the statistics of a mesh from its prepared faces and their dual graph.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, MeshReport, PreparedFaces};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
    /// let prepared = PreparedFaces::new(&mesh, false);
    /// let graph = DualGraph::new(prepared.faces());
    /// let report = MeshReport::of(&mesh, &prepared, &graph);
    /// assert_eq!((report.components, report.boundary_edges, report.unreferenced_vertices), (1, 4, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of(mesh: &Mesh, prepared: &PreparedFaces<'_>, graph: &DualGraph) -> Self {
        let faces = prepared.faces();
        let count_used = || used_vertices(mesh.faces().compact().corners());
        #[cfg(feature = "rayon")]
        let (used, components) = rayon::join(count_used, || graph.component_count());
        #[cfg(not(feature = "rayon"))]
        let (used, components) = (count_used(), graph.component_count());
        let mut report = Self {
            vertices: mesh.vertex_count(),
            unreferenced_vertices: mesh.vertex_count() - used,
            faces: mesh.faces().face_count(),
            triangles: faces.triangle_count(),
            components,
            isolated_faces: graph.isolated_count(),
            surface: prepared.counts(),
            ..Self::default()
        };
        if graph.is_simple() {
            report.boundary_edges = graph.boundary_count();
        } else {
            let faces = &*faces.compact();
            report.count_edges(faces);
            report.duplicate_faces = duplicates(faces);
        }
        report
    }

    /// Counts the edges by their numbers of half-edges in each direction.
    fn count_edges(&mut self, faces: &Faces) {
        for_each_edge(faces, |forward, backward| match (forward, backward) {
            (1, 0) | (0, 1) => self.boundary_edges += 1,
            (2, 0) | (0, 2) => self.inconsistent_edges += 1,
            (1, 1) => (),
            _ => self.non_manifold_edges += 1,
        });
    }
}

/// Counts the distinct vertices of the corners.
fn used_vertices(corners: &[u32]) -> usize {
    let mut used = vec![false; vertex_bound(corners)];
    corners.iter().for_each(|&v| used[v as usize] = true);
    used.iter().filter(|&&is_used| is_used).count()
}

/// Counts the faces that repeat an earlier one, regardless of the corner they start with. A
/// counting sort groups the faces by their lowest vertex, and each group is sorted by comparison.
fn duplicates(faces: &Faces) -> usize {
    let lowest = |polygon: &[u32]| (0..polygon.len()).min_by_key(|&k| polygon[k]).unwrap_or(0);
    let whole = |face: u32| {
        let polygon = faces.face(face as usize);
        let (before, after) = polygon.split_at(lowest(polygon));
        after.iter().chain(before)
    };
    let vertex_count = vertex_bound(faces.corners());
    let firsts = faces.iter().map(|polygon| polygon.get(lowest(polygon)).copied().unwrap_or(0));
    let mut by_lowest = Csr::group(firsts, vertex_count.max(1));
    by_lowest.sort_rows(|a, b| whole(a).cmp(whole(b)));
    let repeats = |faces: &[u32]| faces.windows(2).filter(|w| whole(w[0]).eq(whole(w[1]))).count();
    by_lowest.rows().map(repeats).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn duplicates_are_those_of_a_set(polygons in prop::collection::vec((3..5_usize, 0..6_u32, 1..4_u32), 0..40)) {
            let polygons = polygons.into_iter().map(|(n, first, step)| {
                (0..n as u32).map(|i| (first + i * step) % 7).collect::<Vec<_>>()
            });
            let polygons: Vec<Vec<u32>> = polygons.collect();
            let mut seen = BTreeSet::new();
            let expected = polygons.iter().filter(|polygon| {
                let rotations = (0..polygon.len()).map(|i| [&polygon[i..], &polygon[..i]].concat());
                !seen.insert(rotations.min())
            });
            prop_assert_eq!(duplicates(&Faces::from_polygons(&polygons).unwrap()), expected.count());
        }
    }

    proptest! {
        /// The oracle counts every edge and every face, even if the mesh is simple.
        #[test]
        fn counts_are_those_of_every_edge(polygons in prop::collection::vec((3..5_usize, 0..12_u32, 1..4_u32), 0..12)) {
            let polygons = polygons.into_iter().map(|(n, first, step)| {
                (0..n as u32).map(|i| (first + i * step) % 13).collect::<Vec<_>>()
            });
            let faces = Faces::from_polygons(polygons).unwrap();
            let mesh = Mesh::new((0..13).map(|i| [i as f32, (i * i) as f32, 0.0]).collect::<Vec<_>>(), faces).unwrap();
            let prepared = PreparedFaces::new(&mesh, false);
            let graph = DualGraph::new(prepared.faces());
            let found = MeshReport::of(&mesh, &prepared, &graph);
            let mut expected = MeshReport { boundary_edges: 0, duplicate_faces: duplicates(prepared.faces()), ..found };
            (expected.non_manifold_edges, expected.inconsistent_edges) = (0, 0);
            expected.count_edges(prepared.faces());
            let alone = |f: &u32| graph.neighbours(crate::FaceId(*f)).next().is_none();
            expected.isolated_faces = (0..graph.face_count() as u32).filter(alone).count();
            prop_assert_eq!(found, expected);
        }
    }

    #[test]
    fn sparse_vertices_have_the_same_report() {
        let report = |scale: u32, vertex_count: usize| {
            let corners = [0, 1, 2, 2, 1, 3, 1, 2, 0, 4, 4, 1].map(|v| v * scale).to_vec();
            let faces = Faces::from_triangles(corners).unwrap();
            let mesh = Mesh::new(vec![[0.0; 3]; vertex_count], faces).unwrap();
            let prepared = PreparedFaces::new(&mesh, false);
            MeshReport::of(&mesh, &prepared, &DualGraph::new(prepared.faces()))
        };
        let dense = report(1, 5);
        assert_eq!((dense.duplicate_faces, dense.non_manifold_edges, dense.unreferenced_vertices), (1, 1, 0));
        let sparse = MeshReport { vertices: 5, unreferenced_vertices: 0, ..report(1000, 4001) };
        assert_eq!(sparse, dense);
    }

    #[test]
    fn counts_duplicates_that_are_not_adjacent() {
        let fan = |last: u32| vec![0, 1, 2, last, 9];
        let faces = Faces::from_polygons([fan(3), fan(4), vec![9, 0, 1, 2, 3], fan(4)]).unwrap();
        assert_eq!(duplicates(&faces), 2);
        assert_eq!(duplicates(&Faces::from_polygons([[0, 1, 2], [2, 1, 0], [1, 2, 0]]).unwrap()), 1);
        let large: Vec<u32> = (0..200_000).collect();
        assert_eq!(duplicates(&Faces::from_polygons([&large, &large]).unwrap()), 1);
    }
}
