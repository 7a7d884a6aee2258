//! Random plays, after each of which the segments are held against the links.

use proptest::prelude::*;

use super::*;
use crate::dual::DualGraph;
use crate::stripify::sequential::tests::triangle_graph;

impl Strands<'_> {
    /// Lists the triangles of each path by its segments, from head to tail.
    fn by_segments(&self) -> Vec<Vec<u32>> {
        let now = self.current[..self.strand_count].iter().filter(|s| !s.segments.is_empty());
        let mut paths: Vec<Vec<u32>> = now
            .map(|strand| {
                let triangles: Vec<u32> = strand
                    .segments
                    .iter()
                    .flat_map(|s| {
                        let part = self.paths[s.path as usize][s.low as usize..=s.high as usize].iter();
                        let part: Vec<u32> =
                            if s.reversed { part.rev().copied().collect() } else { part.copied().collect() };
                        part
                    })
                    .collect();
                assert_eq!((triangles[0], triangles[triangles.len() - 1]), (strand.head, strand.tail));
                triangles
            })
            .collect();
        let untouched = self.alive.iter().filter(|&&path| self.marks[path as usize] != self.mark);
        paths.extend(untouched.map(|&path| self.paths[path as usize].clone()));
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

/// Lists all half-edges that are linked.
fn links(cover: &PathCover) -> Vec<crate::HalfEdge> {
    let faces = (0..cover.len() as u32).map(crate::FaceId);
    let mut links: Vec<_> = faces.flat_map(|face| cover.edges(face).into_iter().flatten()).collect();
    links.sort_unstable();
    links
}

/// Does random things, so many of them.
fn play(strands: &mut Strands<'_>, graph: &DualGraph, random: &mut Random, moves: usize) {
    let mut walker = strands.random_end(random);
    for _ in 0..moves {
        match random.below(8) {
            0 => walker = strands.random_end(random),
            1 => {
                strands.cut_behind(random.below(graph.face_count()) as u32);
                walker = strands.random_end(random);
            }
            _ => match strands.step(walker, 64, random) {
                Step::Moved(moved) => walker = moved,
                Step::Joined | Step::Stuck => walker = strands.random_end(random),
            },
        }
        strands.check(graph);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    #[test]
    fn segments_follow_the_links(graph in triangle_graph(), seed: u64) {
        prop_assume!(graph.face_count() > 0);
        let mut cover = PathCover::isolated(graph.face_count());
        let mut strands = Strands::new(graph.twins(), &mut cover);
        let mut random = Random::new(seed);
        for _ in 0..3 {
            play(&mut strands, &graph, &mut random, 10);
            strands.save();
            let saved = strands.by_segments();
            let links = links(strands.cover);
            play(&mut strands, &graph, &mut random, 10);
            if random.coin() {
                strands.restore();
                strands.check(&graph);
                prop_assert_eq!(self::links(strands.cover), links);
                prop_assert_eq!(strands.by_segments().len(), saved.len());
            }
            strands.settle();
            strands.check(&graph);
        }
    }
}
