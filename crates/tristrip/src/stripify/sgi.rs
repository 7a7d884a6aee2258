//! `sgi`: the SGI algorithm, a greedy method that leaves few isolated triangles. Later methods are
//! compared with it.
//!
//! A strip continues to the neighbour with the fewest free neighbours, which avoids cutting off
//! regions. Swaps are not avoided, because a swap costs only one bit in the library that the
//! algorithm was written for.
//!
//! ```text
//!   ╲  1 ╱╲  2 ╱        The strip is at the triangle in the middle. The left neighbour has
//!    ╲  ╱● ╲  ╱         one free neighbour, the right one has two: the strip turns left.
//!     ╲╱────╲╱
//! ```
//!
//! # Algorithm
//! 1. Polygons are triangulated first, by alternate left and right turns, because the algorithm
//!    works only on triangles.
//! 2. A strip starts at a free triangle with the fewest free neighbours.
//! 3. It continues to the free neighbour with the fewest free neighbours. Ties are broken by the
//!    fewest free neighbours of a neighbour's neighbour (one level of look-ahead), then by the
//!    winding (the last tie, see [`LastTie`]).
//! 4. At a dead end, the strip continues from its start in the same way.
//!
//! The implementation follows section 3 of the paper. Where the paper chooses an arbitrary start,
//! this implementation starts at the triangle that lost a neighbour most recently.
//!
//! # References
//! Akeley, Haeberli, Burns: `tomesh.c`, SGI Developer's Toolbox CD, 1990; Evans, Skiena, Varshney:
//! *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 3 and figure 4.
//!
//! # Complexity
//! O(n) time with a bucket queue; 22 bytes per triangle.

use super::{LastTie, StripPlan, stripe};
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::prepare::PreparedFaces;

/// Computes strips over the triangulated faces.
pub(super) fn plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    last_tie: LastTie,
) -> StripPlan<'a> {
    let triangulation = Triangulation::zigzag(prepared, graph);
    let cover = stripe::cover_by_look_ahead(triangulation.graph(), last_tie);
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

    /// The algorithm without incremental counts: free neighbours are counted whenever they are
    /// needed.
    struct Naive<'a> {
        graph: &'a DualGraph,
        cover: PathCover,
        taken: Vec<bool>,
        /// The last time at which each triangle lost a neighbour.
        changed: Vec<i64>,
        clock: i64,
        last_tie: LastTie,
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

        /// Returns the half-edges of a face after its entry.
        fn exits(entry: HalfEdge) -> [HalfEdge; 2] {
            [1, 2].map(|i| HalfEdge(entry.0 / 3 * 3 + (entry.0 + i) % 3))
        }

        fn grow(&mut self, mut exits: Vec<HalfEdge>) -> Option<HalfEdge> {
            let mut first = None;
            loop {
                // Of equal neighbours the first in this order is chosen.
                if self.last_tie == LastTie::Last {
                    exits.reverse();
                }
                let neighbours = exits.iter().filter_map(|&h| Some((h, self.free_neighbour(h)?)));
                let best = neighbours.min_by_key(|&(_, (twin, face))| {
                    let beyond = Self::exits(twin).into_iter().filter_map(|h| self.free_neighbour(h));
                    (self.adjacency(face), beyond.map(|(_, f)| self.adjacency(f)).min().unwrap_or(9))
                });
                let Some((exit, (twin, face))) = best else { return first };
                first = first.or(Some(exit));
                self.take(face);
                self.cover.link(self.graph, exit);
                exits = Self::exits(twin).to_vec();
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
                    self.grow(Self::exits(exit).to_vec());
                }
            }
            self.cover
        }
    }

    fn with_plan<T>(triangles: &[[u32; 3]], last_tie: LastTie, check: impl FnOnce(&StripPlan<'_>) -> T) -> T {
        let faces = Faces::from_polygons(triangles).unwrap();
        let mesh = Mesh::new(vec![[0.0; 3]; 64], faces).unwrap();
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        check(&plan(&prepared, &graph, last_tie))
    }

    /// Two triangles per cell of a grid, some with the other diagonal, some omitted.
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
        fn agrees_with_the_naive_algorithm(triangles in any_triangles(), is_first in any::<bool>()) {
            let last_tie = if is_first { LastTie::First } else { LastTie::Last };
            with_plan(&triangles, last_tie, |plan| {
                let (graph, n) = (plan.triangulation.graph(), plan.cover.len());
                let naive = Naive {
                    graph,
                    cover: PathCover::isolated(n),
                    taken: vec![false; n],
                    changed: (0..n).map(|i| -i64::try_from(i).unwrap()).collect(),
                    clock: 0,
                    last_tie,
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
    fn ignores_the_cost_of_swaps() {
        // A closed fan of six triangles is one strip, although every turn except the first needs a
        // swap.
        let fan: Vec<_> = (0..6).map(|i| [0, 1 + i, 1 + (i + 1) % 6]).collect();
        assert_eq!(with_plan(&fan, LastTie::Last, |plan| plan.cover.path_count()), 1);
    }

    #[test]
    fn starts_at_the_fewest_neighbours() {
        // Three arms of two triangles around a triangle: one strip covers two arms from end to end,
        // another one the third.
        let star = [[0, 1, 2], [1, 0, 3], [2, 1, 4], [0, 2, 5], [3, 0, 6], [4, 1, 7], [5, 2, 8]];
        assert_eq!(with_plan(&star, LastTie::Last, |plan| plan.cover.path_count()), 2);
    }
}
