//! Strips the connected components of a large mesh in parallel. The cover is exactly the same as
//! with a single thread.
//!
//! ```text
//!   triangle    0 1 2 3 4 5 6 7 8         group 0: components a, b    group 1: component c
//!   component   a a b a b c c c c    ─▶   0 1 2 3 4                   5 6 7 8
//!                        ▲                each renumbered from 0 and stripped; links copied back
//!                        no shared edge leads across this boundary
//! ```
//! # Algorithm
//! 1. *Split* the triangles, in input order, wherever no earlier triangle shares an edge with a
//!    later one. Each group consists of whole components and has a minimum number of triangles. If
//!    one group contains nearly all triangles, parallelism gains nothing, and one thread strips the
//!    mesh.
//! 2. *Strip* the groups in parallel, each with its own dual graph.
//! 3. *Copy back* the links and add up the costs. Links are edge numbers within a triangle and need
//!    no renumbering.
//!
//! Files with many parts store them one after the other, and interleaved components are usually
//! close together in the file. Collecting components from all over the mesh would require a search
//! that numbers them first. Such a search takes a fifth of the time of the whole method. Most large
//! meshes have only one component and would not benefit from the search.
//!
//! The cover depends neither on the groups nor on the number of threads, because components do not
//! affect each other in any step:
//! - The next seed is the valid candidate with the fewest free neighbours, and ties go to the last
//!   one added. The best candidate of all components is also the best candidate of its own
//!   component. An entry is dropped if its triangle has been taken or has lost a neighbour since.
//!   Triangles never gain neighbours, so it does not matter when an entry is dropped.
//! - Without candidates, the first free triangle is taken. This triangle is also the first free
//!   triangle of its component, because the order is kept. The triangles before it are taken, or
//!   belong to components without candidates.
//! - Each tentative run marks triangles with a new number. Marks are compared only with the newest
//!   number.
//! - The local search processes ends in the order of the triangles and reaches only along links and
//!   shared edges. Strip numbers are compared only within a component.
//! - The random choice between equal moves would couple components, but is only used in plateau
//!   passes, which run on the whole mesh.
//!
//! Polygons are not grouped: whether a polygon is triangulated again on entry depends on the marks
//! of the last tentative run, which may have been in another component.
//!
//! # Complexity
//! O(n) time. Splitting is sequential: one pass over the twins. 12 bytes per triangle of the groups
//! in progress, in addition to the memory of [`super`].

use std::ops::Range;

use rayon::prelude::*;

use super::policy::Policy;
use super::stages::strip;
use crate::cover::PathCover;
use crate::dual::DualGraph;

/// Meshes with at most this many triangles are stripped by one thread, in a few milliseconds.
const SMALL: usize = 65_536;
/// Minimum number of triangles per group: about a millisecond of work. This is long compared with
/// the overhead of a task, and gives many tasks for a large mesh.
const GROUP: usize = 16_384;
/// If one group contains more than this percentage of the triangles, the others take little time in
/// comparison.
const NEARLY_ALL_PERCENT: usize = 80;

/// Covers a large mesh of several components with the default policy, on the threads of the current
/// pool. Returns the cover and its cost like [`strip`], or `None` if one thread is as fast.
pub(super) fn cover(graph: &DualGraph) -> Option<(PathCover, i64)> {
    if graph.face_count() <= SMALL || rayon::current_num_threads() == 1 {
        return None;
    }
    cover_in_groups(graph, GROUP)
}

/// Covers groups of at least `group_size` triangles, for any mesh and any pool.
fn cover_in_groups(graph: &DualGraph, group_size: usize) -> Option<(PathCover, i64)> {
    let groups = split(graph, group_size);
    let largest = groups.iter().map(Range::len).max()?;
    if 100 * largest > NEARLY_ALL_PERCENT * graph.face_count() {
        return None;
    }
    let parts: Vec<_> = groups
        .par_iter()
        .map(|group| {
            let part = subgraph(graph, group);
            let stripped = strip(&part, Policy::DEFAULT);
            (stripped.cover, stripped.cost)
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

/// Splits the triangle order wherever no earlier triangle shares an edge with a later one. All
/// groups except the last have at least `group_size` triangles.
fn split(graph: &DualGraph, group_size: usize) -> Vec<Range<usize>> {
    let mut groups = Vec::new();
    let (mut start, mut reach) = (0, 0); // `reach` is the half-edge after the last twin so far.
    for end in 1..=graph.face_count() {
        let twins = (3 * end as u32 - 3..3 * end as u32).filter_map(|h| graph.twin_of(h));
        reach = twins.fold(reach, |reach, twin| reach.max(twin + 1));
        if reach as usize <= 3 * end && end - start >= group_size {
            groups.push(start..end);
            start = end;
        }
    }
    if start < graph.face_count() {
        groups.push(start..graph.face_count());
    }
    groups
}

/// Returns the dual graph of a group.
fn subgraph(graph: &DualGraph, group: &Range<usize>) -> DualGraph {
    let (start, end) = (group.start as u32, group.end as u32);
    graph.subgraph(start..end, |half_edge| half_edge - 3 * start)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::mesh::Faces;
    use crate::stripify::generated_meshes::triangle_graph;

    #[test]
    fn splits_only_between_components() {
        // Components of two triangles: 0 and 1, then 2 and 4 interleaved with 3 and 5, then 6
        // alone.
        let mut twins = vec![None; 21];
        for (a, b) in [(0, 5), (7, 12), (9, 16)] {
            (twins[a], twins[b]) = (Some(b as u32), Some(a as u32));
        }
        let graph = DualGraph::of_triangle_twins(twins);
        assert_eq!(split(&graph, 1), [0..2, 2..6, 6..7]);
        assert_eq!(split(&graph, 3), [0..6, 6..7]);
        assert_eq!(split(&graph, 7).len(), 1);
        assert_eq!(split(&DualGraph::of_triangle_twins([]), 1), []);
        let part = subgraph(&graph, &(2..6));
        assert_eq!([0, 1, 2, 3].map(|h| part.twin_of(h)), [None, Some(6), None, Some(10)]);
    }

    #[test]
    fn rejects_groups_that_save_no_time() {
        // Ten triangles in one component, and one or three isolated ones.
        let row = (0..10).flat_map(|i| if i % 2 == 0 { [i, i + 1, i + 2] } else { [i + 1, i, i + 2] });
        let mut corners: Vec<u32> = row.chain(20..23).collect();
        let graph = |corners: &[u32]| DualGraph::new(&Faces::from_triangles(corners.to_vec()).unwrap());
        assert!(cover_in_groups(&graph(&corners), 1).is_none(), "nearly all in one group");
        corners.extend(30..36);
        assert!(cover_in_groups(&graph(&corners), 1).is_some());
        assert!(cover_in_groups(&graph(&corners), 13).is_none(), "one group");
        assert!(cover_in_groups(&graph(&[]), 1).is_none());
    }

    proptest! {
        #[test]
        fn groups_find_the_cover_of_the_whole(graph in triangle_graph(), group_size in 1..80_usize) {
            if let Some((cover, cost)) = cover_in_groups(&graph, group_size) {
                let whole = strip(&graph, Policy::DEFAULT);
                prop_assert_eq!(cover, whole.cover);
                prop_assert_eq!(cost, whole.cost);
            }
        }

        #[test]
        fn groups_hold_whole_components(graph in triangle_graph(), group_size in 1..80_usize) {
            let (component, _) = graph.components();
            let groups = split(&graph, group_size);
            let mut end = 0;
            for group in &groups {
                prop_assert_eq!(group.start, end);
                end = group.end;
                prop_assert!(end == graph.face_count() || group.len() >= group_size);
                prop_assert_eq!(subgraph(&graph, group).check(), Ok(()));
                prop_assert!(component[end..].iter().all(|c| !component[group.clone()].contains(c)));
            }
            prop_assert_eq!(end, graph.face_count());
        }
    }
}
