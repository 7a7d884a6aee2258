//! Random changes. After each of them the segments are compared with the links.

use proptest::prelude::*;

use super::*;
use crate::dual::DualGraph;
use crate::stripify::generated_meshes::triangle_graph;

impl SegmentedPaths<'_> {
    /// Returns the triangles of each path by its segments, from head to tail.
    fn by_segments(&self) -> Vec<Vec<u32>> {
        let triangles_of = |s: &Segment| {
            let mut part = self.paths[s.path as usize][s.low as usize..=s.high as usize].to_vec();
            if s.reversed {
                part.reverse();
            }
            part
        };
        let changed = self.changed[..self.changed_count].iter().filter(|path| !path.segments.is_empty());
        let mut paths: Vec<Vec<u32>> = changed
            .map(|path| {
                let triangles: Vec<u32> = path.segments.iter().flat_map(triangles_of).collect();
                assert_eq!((triangles[0], triangles[triangles.len() - 1]), (path.head, path.tail));
                triangles
            })
            .collect();
        let untouched = self.alive.iter().filter(|&&number| self.marks[number as usize] != self.mark);
        paths.extend(untouched.map(|&number| self.paths[number as usize].clone()));
        paths
    }

    /// Checks the cover, and the segments against its links.
    fn check(&self, graph: &DualGraph) {
        assert_eq!(self.cover.check(graph), Ok(()));
        assert_eq!(self.cover.path_count(), self.path_count);
        let mut seen = 0;
        let paths = self.by_segments();
        assert_eq!(paths.len(), self.path_count);
        for path in paths {
            let ends = [path[0], path[path.len() - 1]];
            let walked: Vec<u32> =
                self.cover.walk(graph, crate::FaceId(ends[0])).map(|(face, _, _)| face.0).collect();
            assert_eq!(walked, path);
            seen += path.len();
        }
        assert_eq!(seen, self.cover.len());
    }
}

/// Returns all linked half-edges.
fn links(cover: &PathCover) -> Vec<crate::HalfEdge> {
    let faces = (0..cover.len() as u32).map(crate::FaceId);
    let mut links: Vec<_> = faces.flat_map(|face| cover.edges(face).into_iter().flatten()).collect();
    links.sort_unstable();
    links
}

/// Makes a number of random changes.
fn change_at_random(paths: &mut SegmentedPaths<'_>, graph: &DualGraph, random: &mut Random, count: usize) {
    let mut end = paths.random_end(random);
    for _ in 0..count {
        match random.below(8) {
            0 => end = paths.random_end(random),
            1 => {
                paths.cut_after(random.below(graph.face_count()) as u32);
                end = paths.random_end(random);
            }
            _ => match paths.step(end, 64, random) {
                WalkStep::Moved(moved) => end = moved,
                WalkStep::Joined | WalkStep::Stuck => end = paths.random_end(random),
            },
        }
        paths.check(graph);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 2))]

    #[test]
    fn segments_follow_the_links(graph in triangle_graph(), seed: u64) {
        prop_assume!(graph.face_count() > 0);
        let mut cover = PathCover::isolated(graph.face_count());
        let mut paths = SegmentedPaths::new(&graph, &mut cover);
        let mut random = Random::new(seed);
        for _ in 0..3 {
            change_at_random(&mut paths, &graph, &mut random, 10);
            paths.save();
            let (saved, links_then) = (paths.by_segments(), links(paths.cover));
            change_at_random(&mut paths, &graph, &mut random, 10);
            if random.coin() {
                paths.restore();
                paths.check(&graph);
                prop_assert_eq!(links(paths.cover), links_then);
                prop_assert_eq!(paths.by_segments().len(), saved.len());
            }
            paths.renumber_touched();
            paths.check(&graph);
        }
    }
}
