//! Peels the connected components of a large mesh in parallel, with the very cover that one thread finds.
//!
//! ```text
//!   triangle    0 1 2 3 4 5 6 7 8         group 0: components a, b    group 1: component c
//!   component   a a b a b c c c c    ─▶   0 1 2 3 4                   5 6 7 8
//!                        ▲                each renumbered from 0, peeled, and its links put back
//!                        no edge is shared across this place
//! ```
//! # Algorithm
//! 1. *Split* the triangles, in the input's order, at places that no shared edge leads across, so that each group has whole
//!    components and at least so many triangles. Where one group holds nearly all of them there is nothing to gain, and the
//!    mesh is left to one thread.
//! 2. *Peel* each group, by twins of its own, and do the exchanges in it, the groups in parallel.
//! 3. *Put back* the links, which name a triangle's own edges and so need no renumbering, and add up the costs.
//!
//! Files of many parts have them one after the other, and what is mixed is mixed with its neighbours. To gather components from
//! all over the mesh, they would have to be numbered by a search first, which takes a fifth of the time of the whole method: too much
//! for the meshes of one component, which most large ones are, as it is only known afterwards.
//!
//! The cover does not depend on the groups, nor on the number of threads, because no step lets one component see another:
//! - The next seed is the due triangle of the fewest free neighbours, the last come. What is on top of the lists of waiting
//!   triangles for all components is on top for its own, too. An entry that is thrown away is one whose triangle has been
//!   taken or has lost a neighbour since; it never gets one back, so that it does not matter when the entry is thrown away.
//! - Where no triangle waits, the first free one is taken: the first free one of its own component, as the order is kept. The
//!   triangles before it are taken, or belong to components in which nothing waits either.
//! - Trials mark triangles with a number that is new each time; only whether it is the newest is ever asked.
//! - Exchanges begin at the ends in order of the triangles and reach only along links and shared edges. The numbers of strips are
//!   names: they are compared, with those in the same component, and never counted on.
//! - The lot by which equal exchanges are drawn would couple components, but is drawn only when ends are gone over again, which
//!   is done for the whole mesh.
//!
//! Polygons are not grouped: whether one is cut again when a strip enters asks for the marks of the last trial, and that may have
//! been one in another component.
//!
//! # Complexity
//! O(n) time, of which splitting is done by one thread: one pass over the twins. 12 bytes for each triangle of the groups that are
//! being peeled, beyond what [`super`] needs.

use std::ops::Range;

use rayon::prelude::*;

use super::{NONE, USUAL, strip};
use crate::cover::PathCover;
use crate::dual::DualGraph;

/// Meshes of at most so many triangles are left to one thread: they take a few milliseconds.
const SMALL: usize = 65_536;
/// Least triangles of a group: about a millisecond's work, long beside what a task costs, and still many tasks in a large mesh.
const GROUP: usize = 16_384;
/// Where one group holds more than so many percent of the triangles, the others are soon done beside it.
const NEARLY_ALL_PERCENT: usize = 80;

/// Covers a large mesh of several components in the usual manner by the threads of the current pool, and gives what it costs, as
/// [`strip`] does; `None` where one thread would do as well.
pub(super) fn cover(graph: &DualGraph) -> Option<(PathCover, i64)> {
    if graph.face_count() <= SMALL || rayon::current_num_threads() == 1 {
        return None;
    }
    cover_in_groups(graph, GROUP)
}

/// The same for groups of at least `group_size` triangles, whatever the mesh and the pool.
fn cover_in_groups(graph: &DualGraph, group_size: usize) -> Option<(PathCover, i64)> {
    let groups = split(graph.twins(), group_size);
    let largest = groups.iter().map(Range::len).max()?;
    if 100 * largest > NEARLY_ALL_PERCENT * graph.face_count() {
        return None;
    }
    let parts: Vec<_> = groups
        .par_iter()
        .map(|group| {
            let part = cut_out(graph.twins(), group);
            let ((_, cover), cost) = strip(&part, USUAL);
            (cover, cost)
        })
        .collect();
    let mut whole = PathCover::isolated(graph.face_count());
    let mut total = 0;
    for (group, (cover, cost)) in groups.iter().zip(&parts) {
        whole.put_back(group.start, cover);
        total += cost;
    }
    Some((whole, total))
}

/// Splits triangles where no shared edge leads across, into groups of at least `group_size`, but for the last.
fn split(twins: &[u32], group_size: usize) -> Vec<Range<usize>> {
    let mut groups = Vec::new();
    let (mut start, mut reach) = (0, 0); // `reach` is the half-edge after the last one that is a twin of those before.
    for (end, edges) in (1..).zip(twins.chunks_exact(3)) {
        // A boundary, `NONE`, reaches nowhere.
        reach = edges.iter().fold(reach, |reach, twin| reach.max(twin.wrapping_add(1)));
        if reach as usize <= 3 * end && end - start >= group_size {
            groups.push(start..end);
            start = end;
        }
    }
    if start < twins.len() / 3 {
        groups.push(start..twins.len() / 3);
    }
    groups
}

/// Makes the dual graph of a group.
fn cut_out(twins: &[u32], group: &Range<usize>) -> DualGraph {
    let start = 3 * group.start as u32;
    let within = twins[3 * group.start..3 * group.end].iter();
    DualGraph::from_triangle_twins(within.map(|&h| if h == NONE { NONE } else { h - start }).collect())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::tests::triangle_graph;
    use super::*;
    use crate::mesh::Faces;

    #[test]
    fn splits_only_between_components() {
        // Components of two triangles: 0 and 1, then 2 and 4, 3 and 5 mixed, then 6 by itself.
        let mut twins = vec![NONE; 21];
        for (a, b) in [(0, 5), (7, 12), (9, 16)] {
            (twins[a], twins[b]) = (b as u32, a as u32);
        }
        assert_eq!(split(&twins, 1), [0..2, 2..6, 6..7]);
        assert_eq!(split(&twins, 3), [0..6, 6..7]);
        assert_eq!(split(&twins, 7).len(), 1);
        assert_eq!(split(&[], 1), []);
        assert_eq!(cut_out(&twins, &(2..6)).twins()[..4], [NONE, 6, NONE, 10]);
    }

    #[test]
    fn leaves_alone_what_gains_nothing() {
        // Ten triangles in one component, and one or three by themselves.
        let row = (0..10).flat_map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] });
        let mut corners: Vec<u32> = row.chain(20..23).collect();
        let graph = |corners: &[u32]| DualGraph::new(&Faces::from_triangles(corners.to_vec()).unwrap());
        assert!(cover_in_groups(&graph(&corners), 1).is_none(), "nearly all in one");
        corners.extend(30..36);
        assert!(cover_in_groups(&graph(&corners), 1).is_some());
        assert!(cover_in_groups(&graph(&corners), 13).is_none(), "one group");
        assert!(cover_in_groups(&graph(&[]), 1).is_none());
    }

    proptest! {
        #[test]
        fn groups_find_the_cover_of_the_whole(graph in triangle_graph(), group_size in 1..80_usize) {
            if let Some((cover, cost)) = cover_in_groups(&graph, group_size) {
                let ((_, whole), whole_cost) = strip(&graph, USUAL);
                prop_assert_eq!(cover, whole);
                prop_assert_eq!(cost, whole_cost);
            }
        }

        #[test]
        fn groups_hold_whole_components(graph in triangle_graph(), group_size in 1..80_usize) {
            let (component, _) = graph.components();
            let groups = split(graph.twins(), group_size);
            let mut end = 0;
            for group in &groups {
                prop_assert_eq!(group.start, end);
                end = group.end;
                prop_assert!(end == graph.face_count() || group.len() >= group_size);
                prop_assert_eq!(cut_out(graph.twins(), group).check(), Ok(()));
                prop_assert!(component[end..].iter().all(|c| !component[group.clone()].contains(c)));
            }
            prop_assert_eq!(end, graph.face_count());
        }
    }
}
