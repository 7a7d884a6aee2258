//! What a mesh is like: counts that decide how well it can be stripped, and defects that a user wants to know of.

use super::{Mesh, Surface, SurfaceCounts};
use crate::dual::{DualGraph, for_each_edge};

/// The counts of a mesh. Edges are those of the surface's faces, between two vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct MeshReport {
    /// Vertices, used or not.
    pub vertices: usize,
    /// Vertices that no face of the mesh uses.
    pub unreferenced_vertices: usize,
    /// Faces of the mesh, degenerate ones included.
    pub faces: usize,
    /// Triangles that the faces which draw something make.
    pub triangles: usize,
    /// Parts of the dual graph that no shared edge joins.
    pub components: usize,
    /// Edges of one face.
    pub boundary_edges: usize,
    /// Edges of more than two faces.
    pub non_manifold_edges: usize,
    /// Edges of two faces that are wound in opposite senses there; no strip passes over them.
    pub inconsistent_edges: usize,
    /// Faces that share no edge with another.
    pub isolated_faces: usize,
    /// Faces that have the same vertices in the same winding as an earlier one; they are drawn, too.
    pub duplicate_faces: usize,
    /// What was changed to make the faces ready.
    pub surface: SurfaceCounts,
}

impl MeshReport {
    /// Counts a mesh, its surface and its dual graph.
    ///
    /// ```
    /// use tristrip::{DualGraph, Faces, Mesh, Surface, mesh::MeshReport};
    /// let mesh = Mesh::new(vec![[0.0; 3]; 5], Faces::from_triangles(vec![0, 1, 2, 2, 1, 3])?)?;
    /// let surface = Surface::new(&mesh, false);
    /// let graph = DualGraph::new(surface.faces());
    /// let report = MeshReport::of(&mesh, &surface, &graph);
    /// assert_eq!((report.components, report.boundary_edges, report.unreferenced_vertices), (1, 4, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of(mesh: &Mesh, surface: &Surface<'_>, graph: &DualGraph) -> Self {
        let faces = surface.faces();
        let mut used = vec![false; mesh.vertex_count()];
        mesh.faces().corners().iter().for_each(|&v| used[v as usize] = true);
        let mut report = Self {
            vertices: mesh.vertex_count(),
            unreferenced_vertices: used.iter().filter(|&&u| !u).count(),
            faces: mesh.faces().face_count(),
            triangles: faces.triangle_count(),
            components: graph.components().1,
            surface: surface.counts(),
            ..Self::default()
        };
        for_each_edge(faces, |forward, backward| match (forward, backward) {
            (1, 0) | (0, 1) => report.boundary_edges += 1,
            (2, 0) | (0, 2) => report.inconsistent_edges += 1,
            (1, 1) => (),
            _ => report.non_manifold_edges += 1,
        });
        let faces_of_graph = 0..graph.face_count() as u32;
        report.isolated_faces =
            faces_of_graph.filter(|&f| graph.neighbours(crate::dual::FaceId(f)).next().is_none()).count();
        report.duplicate_faces = duplicates(faces);
        report
    }
}

/// Counts the faces that repeat an earlier one, whatever corner they begin with.
fn duplicates(faces: &super::Faces) -> usize {
    // Sorted by size and the first corners from the lowest on; the rest is read only where these are the same.
    let key = |(face, polygon): (u32, &[u32])| {
        let lowest = (0..polygon.len()).min_by_key(|&k| polygon[k]).unwrap_or(0);
        let corner = |i: usize| polygon[(lowest + i) % polygon.len()];
        (polygon.len() as u32, [corner(0), corner(1), corner(2)], lowest as u32, face)
    };
    let mut keys: Vec<(u32, [u32; 3], u32, u32)> = (0..).zip(faces.iter()).map(key).collect();
    let reading = |&(_, _, lowest, face): &(u32, [u32; 3], u32, u32)| {
        let (before, from) = faces.face(face as usize).split_at(lowest as usize);
        from.iter().chain(before)
    };
    keys.sort_unstable_by(|a, b| {
        (a.0, a.1).cmp(&(b.0, b.1)).then_with(|| reading(a).cmp(reading(b))).then(a.3.cmp(&b.3))
    });
    keys.windows(2)
        .filter(|w| (w[0].0, w[0].1) == (w[1].0, w[1].1) && reading(&w[0]).eq(reading(&w[1])))
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Faces;

    #[test]
    fn counts_duplicates_whatever_stands_between_them() {
        let fan = |last: u32| vec![0, 1, 2, last, 9];
        let faces = Faces::from_polygons([fan(3), fan(4), vec![9, 0, 1, 2, 3], fan(4)]).unwrap();
        assert_eq!(duplicates(&faces), 2);
        assert_eq!(duplicates(&Faces::from_polygons([[0, 1, 2], [2, 1, 0], [1, 2, 0]]).unwrap()), 1);
        let large: Vec<u32> = (0..200_000).collect();
        assert_eq!(duplicates(&Faces::from_polygons([&large, &large]).unwrap()), 1);
    }
}
