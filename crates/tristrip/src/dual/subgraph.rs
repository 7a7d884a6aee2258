//! Subgraphs: whole connected components of a dual graph, renumbered from 0, so that a method can process them separately.
//!
//! ```text
//!   triangles   3 4 7          numbered 0 1 2 in the subgraph
//!   half-edge   9  →  0        edges of a triangle keep their numbers 0 to 2
//! ```
//! Path covers need no translation: a link names an edge of its own triangle.

use super::DualGraph;

impl DualGraph {
    /// Returns the graph of some triangles, numbered from 0 in the given order. No shared edge may lead to other triangles.
    /// `renumber` maps a half-edge of the whole graph to the half-edge of the subgraph.
    pub(crate) fn subgraph(
        &self,
        triangles: impl IntoIterator<Item = u32>,
        renumber: impl Fn(u32) -> u32,
    ) -> Self {
        let half_edges = triangles.into_iter().flat_map(|t| 3 * t..3 * t + 3);
        Self::of_triangle_twins(half_edges.map(|half_edge| self.twin_of(half_edge).map(&renumber)))
    }
}

#[cfg(test)]
mod tests {
    use crate::dual::DualGraph;
    use crate::mesh::Faces;

    #[test]
    fn a_component_keeps_its_shared_edges() {
        // Triangles 0 and 2 share the edge 1–2, triangles 1 and 3 the edge 4–5.
        let faces = Faces::from_triangles(vec![0, 1, 2, 3, 4, 5, 2, 1, 6, 5, 4, 7]).unwrap();
        let graph = DualGraph::new(&faces);
        let first = graph.subgraph([0, 2], |h| if h < 3 { h } else { h - 3 });
        assert_eq!(first, DualGraph::new(&Faces::from_triangles(vec![0, 1, 2, 2, 1, 6]).unwrap()));
        let numbers = [0, 0, 0, 1];
        let second = graph.subgraph([1, 3], |h| 3 * numbers[h as usize / 3] + h % 3);
        assert_eq!(second, first);
        assert_eq!(second.check(), Ok(()));
    }
}
