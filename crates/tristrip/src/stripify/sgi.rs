//! The SGI algorithm: greedy strips of triangles that leave few triangles isolated, the yardstick of later methods.
//!
//! It goes wherever there is least left to go, so that corners are not cut off; it does not care about swaps, which cost one bit
//! in the library that it was written for.
//!
//! ```text
//!   ╲  1 ╱╲  2 ╱        The strip has come to the triangle in the middle. The neighbour on the left has one
//!    ╲  ╱● ╲  ╱         free neighbour left, that on the right has two: the strip turns left.
//!     ╲╱────╲╱
//! ```
//!
//! # Algorithm
//! 1. Polygons are cut beforehand, by alternate left and right turns: the algorithm knows triangles only.
//! 2. A strip starts at a free triangle with the fewest free neighbours.
//! 3. It goes on to the free neighbour that has the fewest free neighbours. Of two such, to the one that has a neighbour with
//!    the fewest; where they are still equal any will do, here the first in the winding before the entry.
//! 4. When it is stuck it goes on from its start in the same way.
//!
//! The program is described in section 3 of the paper, which this follows; where that says "arbitrary", of several triangles to
//! start from the one is taken that lost a neighbour last.
//!
//! # References
//! Akeley, Haeberli, Burns: `tomesh.c`, SGI Developer's Toolbox CD, 1990; Evans, Skiena, Varshney: *Efficiently Generating
//! Triangle Strips for Fast Rendering*, 1996, section 3 and figure 4.
//!
//! # Complexity
//! O(n) time, by a bucket queue; 22 bytes a triangle.

use super::{StripPlan, stripe};
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::prepare::PreparedFaces;

/// Plans strips over the surface's triangles.
pub(super) fn plan<'a>(surface: &'a PreparedFaces<'_>, graph: &'a DualGraph) -> StripPlan<'a> {
    let triangulation = Triangulation::zigzag(surface, graph);
    let cover = stripe::cover_by_look_ahead(triangulation.graph());
    StripPlan::new(triangulation, cover)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cover::PathCover;
    use crate::ids::{FaceId, HalfEdge};
    use crate::mesh::{Faces, Mesh};
    use proptest::prelude::*;
    use std::cmp::Reverse;

    /// The algorithm with everything counted anew wherever it is asked for.
    struct Naive<'a> {
        graph: &'a DualGraph,
        cover: PathCover,
        taken: Vec<bool>,
        /// When a triangle lost a neighbour last.
        changed: Vec<i64>,
        clock: i64,
    }

    impl Naive<'_> {
        fn free_neighbour(&self, half_edge: HalfEdge) -> Option<(HalfEdge, FaceId)> {
            let twin = self.graph.twin(half_edge)?;
            let face = self.graph.face_of(twin);
            (!self.taken[face.0 as usize]).then_some((twin, face))
        }

        fn adjacency(&self, face: FaceId) -> usize {
            self.graph.half_edges(face).filter(|&h| self.free_neighbour(h).is_some()).count()
        }

        fn take(&mut self, face: FaceId) {
            self.taken[face.0 as usize] = true;
            for h in self.graph.half_edges(face) {
                if let Some((_, neighbour)) = self.free_neighbour(h) {
                    self.clock += 1;
                    self.changed[neighbour.0 as usize] = self.clock;
                }
            }
        }

        /// The half-edges of a face after its entry.
        fn ways(entry: HalfEdge) -> [HalfEdge; 2] {
            [1, 2].map(|i| HalfEdge(entry.0 / 3 * 3 + (entry.0 + i) % 3))
        }

        fn grow(&mut self, mut ways: Vec<HalfEdge>) -> Option<HalfEdge> {
            let mut first = None;
            loop {
                let neighbours = ways.iter().rev().filter_map(|&h| Some((h, self.free_neighbour(h)?)));
                let best = neighbours.min_by_key(|&(_, (twin, face))| {
                    let beyond = Self::ways(twin).into_iter().filter_map(|h| self.free_neighbour(h));
                    (self.adjacency(face), beyond.map(|(_, f)| self.adjacency(f)).min().unwrap_or(9))
                });
                let Some((exit, (twin, face))) = best else { return first };
                first = first.or(Some(exit));
                self.take(face);
                self.cover.link(self.graph, exit);
                ways = Self::ways(twin).to_vec();
            }
        }

        fn run(mut self) -> PathCover {
            let free = |naive: &Self| {
                (0..naive.taken.len() as u32)
                    .map(FaceId)
                    .filter(|f| !naive.taken[f.0 as usize])
                    .collect::<Vec<_>>()
            };
            while let Some(start) = free(&self)
                .into_iter()
                .min_by_key(|&face| (self.adjacency(face), Reverse(self.changed[face.0 as usize])))
            {
                self.take(start);
                if let Some(exit) = self.grow(self.graph.half_edges(start).collect()) {
                    self.grow(Self::ways(exit).to_vec());
                }
            }
            self.cover
        }
    }

    fn with_plan<T>(triangles: &[[u32; 3]], check: impl FnOnce(&StripPlan<'_>) -> T) -> T {
        let faces = Faces::from_polygons(triangles).unwrap();
        let mesh = Mesh::new(vec![[0.0; 3]; 64], faces).unwrap();
        let surface = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(surface.faces());
        check(&plan(&surface, &graph))
    }

    /// Two triangles for each place of a grid, some turned, some left out.
    fn any_triangles() -> impl Strategy<Value = Vec<[u32; 3]>> {
        prop::collection::vec(0..9_u8, 49).prop_map(|kinds| {
            let cut = |(i, kind): (usize, u8)| {
                let a = i as u32 / 7 * 8 + i as u32 % 7;
                let [a, b, c, d] = [a, a + 1, a + 9, a + 8];
                match kind {
                    0 => vec![],
                    1 => vec![[a, b, c]],
                    2..5 => vec![[b, c, d], [a, b, d]],
                    _ => vec![[a, b, c], [d, a, c]],
                }
            };
            kinds.into_iter().enumerate().flat_map(cut).collect()
        })
    }

    proptest! {
        #[test]
        fn agrees_with_the_naive_algorithm(triangles in any_triangles()) {
            with_plan(&triangles, |plan| {
                let (graph, n) = (plan.triangulation.graph(), plan.cover.len());
                let naive = Naive {
                    graph,
                    cover: PathCover::isolated(n),
                    taken: vec![false; n],
                    changed: (0..n).map(|i| -i64::try_from(i).unwrap()).collect(),
                    clock: 0,
                };
                let naive = naive.run();
                let linked = |cover: &PathCover| {
                    (0..3 * n as u32).map(|h| cover.is_linked(HalfEdge(h))).collect::<Vec<_>>()
                };
                assert_eq!(linked(&plan.cover), linked(&naive));
            });
        }
    }

    #[test]
    fn does_not_mind_swaps() {
        // A closed fan of six triangles is one strip, though every turn but the first swaps.
        let fan: Vec<_> = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
        assert_eq!(with_plan(&fan, |plan| plan.cover.path_count()), 1);
    }

    #[test]
    fn starts_where_the_fewest_neighbours_are() {
        // Three arms of two triangles around one: a strip takes two of the arms, from end to end, and another the third.
        let star = [[0, 1, 2], [1, 0, 3], [2, 1, 4], [0, 2, 5], [3, 0, 6], [4, 1, 7], [5, 2, 8]];
        assert_eq!(with_plan(&star, |plan| plan.cover.path_count()), 2);
    }
}
