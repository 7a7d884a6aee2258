//! `input`: strips in the order of the input faces. A search that starts from them is never worse
//! than the input.
//!
//! # Algorithm
//! Triangles keep their order, and polygons become fans. Each triangle is linked to the previous
//! one if they share an edge. A triangle list that was expanded from strips is converted back to
//! the same strips, or to longer ones.
//!
//! # Complexity
//! O(n) time and 1 byte per triangle.

use super::StripPlan;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::ids::FaceId;
use crate::prepare::PreparedFaces;

pub(super) fn plan<'a>(prepared: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> StripPlan<'a> {
    let triangulation = Triangulation::fan(prepared, graph);
    let cover = cover(triangulation.graph());
    StripPlan::new(triangulation, cover)
}

fn cover(graph: &DualGraph) -> PathCover {
    let mut cover = PathCover::isolated(graph.face_count());
    for face in (1..graph.face_count() as u32).map(FaceId) {
        let previous = FaceId(face.0 - 1);
        let shared = |&h: &_| graph.twin(h).is_some_and(|twin| graph.face_of(twin) == previous);
        if let Some(half_edge) = graph.half_edges(face).find(|h| shared(h) && !cover.is_linked(*h)) {
            cover.link(graph, half_edge);
        }
    }
    cover
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Faces, Mesh};
    use crate::strip::Strips;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_never_worse_than_the_strips_of_the_input(
            lengths in prop::collection::vec(3..20_u32, 1..8),
            seed in any::<u32>(),
        ) {
            let (mut strips, mut next) = (Strips::default(), 0);
            for length in lengths {
                let strip: Vec<u32> = (next..next + length).collect();
                next += length - (seed >> (length % 8)) % 3;
                strips.push(&strip);
            }
            let faces = Faces::from_triangles(strips.to_list()).unwrap();
            let mesh = Mesh::new(vec![[0.0; 3]; next as usize + 3], faces).unwrap();
            let prepared = PreparedFaces::new(&mesh, false);
            let graph = DualGraph::new(prepared.faces());
            let plan = plan(&prepared, &graph);
            prop_assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()));
            let found = plan.strips();
            let cost = |s: &Strips| s.vertices_sent() + s.len();
            prop_assert!(cost(&found) <= cost(&strips));
        }
    }
}
