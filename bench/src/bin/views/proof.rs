//! Compares two sets of triangles, and finds cracks in a surface.

use std::collections::HashSet;

use tristrip::Mesh;
use tristrip_bench::failure::Failure;
use tristrip_bench::meshoptimizer::adapter;

/// Returns a triangle rotated to start with its lowest vertex.
pub(super) fn from_lowest([a, b, c]: [u32; 3]) -> [u32; 3] {
    [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap_or([a, b, c])
}

/// Returns sorted triangles, each rotated to start with its lowest vertex.
pub(super) fn sorted(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let mut sorted: Vec<_> = triangles.into_iter().map(from_lowest).collect();
    sorted.sort_unstable();
    sorted
}

/// Edges of triangles, by position.
pub(super) struct Borders {
    /// For each vertex, the first vertex at its position.
    first: Vec<u32>,
    /// The vertices at the borders of the full mesh.
    at_border: HashSet<u32>,
}

impl Borders {
    pub(super) fn of(mesh: &Mesh) -> Result<Self, Failure> {
        let first = meshopt::generate_position_remap(&adapter(mesh.positions())?);
        let mut borders = Self { first, at_border: HashSet::new() };
        let (triangles, _) = mesh.faces().as_triangles().unwrap_or_default().as_chunks::<3>();
        borders.at_border = borders.open_edges(triangles).into_iter().flatten().collect();
        Ok(borders)
    }

    /// Returns the edges that no triangle has in the opposite direction.
    fn open_edges(&self, triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
        let welded = triangles.iter().map(|triangle| triangle.map(|vertex| self.first[vertex as usize]));
        let real = welded.filter(|[a, b, c]| a != b && b != c && c != a);
        let mut edges: Vec<[u32; 2]> = real.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        edges.dedup();
        let is_open = |&[a, b]: &[u32; 2]| edges.binary_search(&[b, a]).is_err();
        edges.iter().copied().filter(is_open).collect()
    }

    /// Counts the open edges that are not at a border of the full mesh. These are the cracks.
    pub(super) fn cracks(&self, triangles: &[[u32; 3]]) -> usize {
        let is_crack = |edge: &[u32; 2]| !edge.iter().all(|vertex| self.at_border.contains(vertex));
        self.open_edges(triangles).iter().filter(|edge| is_crack(edge)).count()
    }
}
