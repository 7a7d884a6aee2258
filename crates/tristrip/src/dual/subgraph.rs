//! Subgraphs and reordered graphs. A subgraph consists of whole connected components of a dual
//! graph, renumbered from 0. A method can process each subgraph separately.
//!
//! ```text
//!   triangles   3 4 7          numbered 0 1 2 in the subgraph
//!   half-edge   9  →  0        edges of a triangle keep their numbers 0 to 2
//! ```
//! Path covers need no translation, because a link is an edge number within its own triangle.

use super::{DualGraph, FaceShape, NO_TWIN, polygon_shape};
use crate::ids::{FaceId, HalfEdge};
use crate::mesh::Faces;

impl DualGraph {
    /// Returns the graph of the given triangles, numbered from 0 in the given order. They must not
    /// share edges with other triangles. `renumber` maps a half-edge of the whole graph to the
    /// half-edge of the subgraph.
    pub(crate) fn subgraph(
        &self,
        triangles: impl IntoIterator<Item = u32>,
        renumber: impl Fn(u32) -> u32,
    ) -> Self {
        let half_edges = triangles.into_iter().flat_map(|t| 3 * t..3 * t + 3);
        Self::of_triangle_twins(half_edges.map(|half_edge| self.twin_of(half_edge).map(&renumber)))
    }

    /// Returns the graph of all faces in another order. `order` has the old index of each face, and
    /// `faces` are the faces in the new order.
    pub(crate) fn in_order(&self, order: &[u32], faces: &Faces) -> Self {
        let shape = match &self.shape {
            FaceShape::Triangles => FaceShape::Triangles,
            FaceShape::Polygons { .. } => {
                let (offsets, face_of) = polygon_shape(faces);
                FaceShape::Polygons { offsets, face_of }
            }
        };
        // The amount by which the half-edges of an old face are shifted. It wraps around where it
        // is negative.
        let mut growth = vec![0_u32; order.len()];
        for (new, &old) in (0..).zip(order) {
            growth[old as usize] = shape.first_half_edge(new).wrapping_sub(self.shape.first_half_edge(old));
        }
        let renumber = |twin: u32| twin.wrapping_add(growth[self.face_of(HalfEdge(twin)).0 as usize]);
        let half_edges = order.iter().flat_map(|&face| self.half_edges(FaceId(face)));
        let twins = half_edges.map(|half_edge| self.twin_of(half_edge.0).map_or(NO_TWIN, renumber));
        Self { twins: twins.collect(), shape, is_simple: self.is_simple }
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
