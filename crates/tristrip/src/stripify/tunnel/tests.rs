//! Tests of tunnels: a brute force that really cuts and links, against the searches that only simulate it.

use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::ids::{Ids, NONE, Pieces, Step};
use super::{EtaOptions, Searched, Start, Tally, baseline, eta};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};
use crate::prepare::PreparedFaces;
use crate::stripify::sequential::tests::{mesh, polygons, triangle_graph};
use crate::stripify::watch::{Progress, Watch};
use crate::stripify::{Method, StripifyOptions, plan};
use crate::verify::verify;

/// Finds the shortest tunnel up to a length by trying every alternating path on the cover itself.
fn brute_force(graph: &DualGraph, cover: &PathCover, length: usize) -> Option<usize> {
    fn follow(
        graph: &DualGraph,
        original: &PathCover,
        cover: &mut PathCover,
        from: FaceId,
        left: usize,
        used: &mut Vec<HalfEdge>,
    ) -> Option<usize> {
        let mut shortest = None;
        for red in graph.half_edges(from) {
            let Some(twin) = graph.twin(red) else { continue };
            if left == 0 || original.is_linked(red) || used.contains(&red) || used.contains(&twin) {
                continue;
            }
            let v = graph.face_of(twin);
            if cover.link(graph, red) {
                // Both had a link free: the tunnel ends here, unless that leaves a loop.
                let closed = cover.check(graph).is_err();
                cover.cut(graph, red);
                if !closed {
                    return Some(1);
                }
            }
            for black in original.edges(v).into_iter().flatten() {
                if left < 3 || !cover.is_linked(black) {
                    continue;
                }
                let twin_black = graph.twin(black).unwrap();
                cover.cut(graph, black);
                assert!(cover.link(graph, red));
                used.push(red);
                let rest = follow(graph, original, cover, graph.face_of(twin_black), left - 2, used);
                shortest = shortest.into_iter().chain(rest.map(|rest| rest + 2)).min();
                used.pop();
                cover.cut(graph, red);
                assert!(cover.link(graph, black));
            }
        }
        shortest
    }
    let mut changed = cover.clone();
    (0..cover.len() as u32)
        .map(FaceId)
        .filter(|&t| cover.degree(t) < 2)
        .filter_map(|t| follow(graph, cover, &mut changed, t, length, &mut Vec::new()))
        .min()
}

/// Draws a graph, and paths over it.
pub(super) fn graph_and_cover() -> impl Strategy<Value = (DualGraph, PathCover)> {
    (triangle_graph(), prop::collection::vec(any::<u32>(), 0..300)).prop_map(|(graph, tries)| {
        let mut cover = PathCover::isolated(graph.face_count());
        for h in tries.iter().filter_map(|t| t.checked_rem(graph.half_edge_count() as u32)) {
            cover.join(&graph, HalfEdge(h));
        }
        (graph, cover)
    })
}

/// Checks that steps are an alternating path of the cover.
fn is_tunnel(graph: &DualGraph, cover: &PathCover, from: u32, steps: &[Step]) -> bool {
    let mut at = FaceId(from);
    let whole = steps.iter().enumerate().all(|(i, step)| {
        let red = HalfEdge(step.red);
        let leads = graph.face_of(red) == at && !cover.is_linked(red);
        at = FaceId(graph.twins()[step.red as usize] / 3);
        if i + 1 == steps.len() {
            return leads && step.black == NONE && cover.degree(at) < 2;
        }
        let black = HalfEdge(step.black);
        let leads = leads && graph.face_of(black) == at && cover.is_linked(black);
        at = FaceId(graph.twins()[step.black as usize] / 3);
        leads
    });
    let mut edges: Vec<u32> = steps.iter().flat_map(|s| [s.red, s.black]).filter(|&h| h != NONE).collect();
    edges.iter_mut().for_each(|h| *h = (*h).min(graph.twins()[*h as usize]));
    let count = edges.len();
    edges.sort_unstable();
    edges.dedup();
    whole && edges.len() == count && cover.degree(FaceId(from)) < 2
}

proptest! {
    #[test]
    fn finds_a_tunnel_wherever_there_is_one((graph, mut cover) in graph_and_cover(), length in 0..5_u32) {
        let length = 2 * length + 1;
        let mut ids = Ids::new(&graph, &cover);
        let mut search = baseline::Search::default();
        // Complement all that there are, the shortest first, and compare with the brute force before each.
        loop {
            let shortest = brute_force(&graph, &cover, length as usize);
            let found = (1..=length).step_by(2).find_map(|limit| {
                (0..cover.len() as u32).filter(|&t| cover.degree(FaceId(t)) < 2).find(|&t| {
                    let searched = search.tunnel(&graph, &cover, &ids, t, limit, &mut Tally::new(&()));
                    searched == Searched::Found
                })
            });
            prop_assert_eq!(found.map(|_| 2 * search.steps.len() - 1), shortest);
            let Some(from) = found else { break };
            prop_assert!(is_tunnel(&graph, &cover, from, &search.steps));
            let paths = cover.path_count();
            ids.complement(&graph, &mut cover, &search.steps);
            prop_assert_eq!(cover.check(&graph), Ok(()));
            prop_assert_eq!(cover.path_count(), paths - 1);
            prop_assert!(ids.check(&graph, &cover));
        }
    }

    #[test]
    fn leaves_no_tunnel_of_its_length((graph, mut cover) in graph_and_cover(), length in 0..9_u32) {
        baseline::join(&graph, &mut cover, length, &mut Tally::new(&()));
        prop_assert_eq!(cover.check(&graph), Ok(()));
        prop_assert_eq!(brute_force(&graph, &cover, length as usize), None);
    }
}

/// It went through all odd lengths, two thousand million of them, and then from the first again.
#[test]
fn the_longest_path_ends_it_whatever_the_limit() {
    // Two triangles side by side, one alone, and a closed fan of five.
    let fan = (0..5).flat_map(|i| [7, 8 + i, 8 + (i + 1) % 5]);
    let corners = [0, 1, 2, 2, 1, 3, 4, 5, 6].into_iter().chain(fan).collect();
    let graph = DualGraph::new(&crate::Faces::from_triangles(corners).unwrap());
    let mut cover = PathCover::isolated(8);
    baseline::join(&graph, &mut cover, u32::MAX, &mut Tally::new(&()));
    assert_eq!(cover.path_count(), 3);
    let nothing = DualGraph::new(&crate::Faces::default());
    baseline::join(&nothing, &mut PathCover::isolated(0), u32::MAX, &mut Tally::new(&()));
}

/// Counts the closed paths of a cover.
fn loops(graph: &DualGraph, cover: &PathCover) -> usize {
    let mut seen = vec![false; cover.len()];
    let mut see = |start: FaceId| {
        let is_new = !seen[start.0 as usize];
        let walk = cover.walk(graph, start).map(|(face, _, _)| face.0 as usize);
        walk.for_each(|face| seen[face] = true);
        is_new
    };
    let faces = || (0..cover.len() as u32).map(FaceId);
    for end in faces().filter(|&face| cover.degree(face) < 2) {
        see(end);
    }
    faces().filter(|&face| see(face)).count()
}

proptest! {
    #[test]
    fn pieces_know_the_loops((graph, cover) in graph_and_cover(), terminal in any::<u32>(), turns in prop::collection::vec(0..7_usize, 0..40)) {
        prop_assume!(!cover.is_empty());
        let terminal = terminal % cover.len() as u32;
        prop_assume!(cover.degree(FaceId(terminal)) < 2);
        let ids = Ids::new(&graph, &cover);
        let mut pieces = Pieces::default();
        pieces.begin(&ids, terminal);
        // Steps as they come, some taken back; the same is done to covers.
        let mut covers = vec![(cover.clone(), FaceId(terminal))];
        for turn in turns {
            let (mut now, tip) = covers[covers.len() - 1].clone();
            if turn == 6 {
                if covers.len() > 1 {
                    covers.pop();
                    pieces.undo();
                }
                prop_assert_eq!(pieces.loops() as usize, loops(&graph, &covers[covers.len() - 1].0));
                continue;
            }
            let red = HalfEdge(3 * tip.0 + turn as u32 / 2);
            let Some(twin) = graph.twin(red).filter(|_| !cover.is_linked(red) && !now.is_linked(red)) else { continue };
            let v = graph.face_of(twin);
            let Some(black) = cover.edges(v)[turn % 2] else { continue };
            let b = graph.face_of(graph.twin(black).unwrap());
            let can = now.cut(&graph, black);
            prop_assert_eq!(pieces.step(&ids, v.0, b.0), can);
            if can {
                prop_assert!(now.link(&graph, red));
                prop_assert_eq!(pieces.loops() as usize, loops(&graph, &now));
                covers.push((now, b));
            }
        }
    }

    #[test]
    fn strips_of_any_mesh_are_right(polygons in polygons(false, 1..5), length in 0..12_u32, seed in any::<u64>()) {
        let mesh = mesh(&polygons);
        let surface = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(surface.faces());
        let eta = EtaOptions::default();
        let starts = [Start::Isolated, Start::Input, Start::Sgi, Start::Sequential];
        let starts = starts.map(|start| Method::Eta(eta.with_start(start)));
        for method in starts.into_iter().chain([Method::Tunnel { length }]) {
            let plan = plan(&surface, &graph, &StripifyOptions::default().with_method(method).with_seed(seed)).unwrap();
            let strips = plan.strips();
            prop_assert!(verify(&mesh, &strips).is_ok(), "{:?}", method);
        }
    }
}

#[test]
fn eta_makes_one_strip_of_a_closed_grid() {
    for seed in 0..4 {
        let graph = torus(90, 60);
        let mut cover = PathCover::isolated(graph.face_count());
        eta::join(&graph, &mut cover, EtaOptions::default(), seed, &mut Tally::new(&()));
        assert_eq!((cover.check(&graph), cover.path_count()), (Ok(()), 1), "{seed}");
    }
}

#[test]
fn the_seed_decides() {
    let graph = torus(30, 20);
    let covers = [1, 1, 2].map(|seed| {
        let mut cover = PathCover::isolated(graph.face_count());
        eta::join(&graph, &mut cover, EtaOptions::default(), seed, &mut Tally::new(&()));
        cover
    });
    assert!(covers[0] == covers[1] && covers[0] != covers[2]);
}

/// Stops a search when it is asked for the n-th time.
struct StopAt(usize, AtomicUsize);

impl Watch for StopAt {
    fn go_on(&self, progress: Progress) -> bool {
        assert!(progress.strips > 0 && progress.steps > 0);
        self.1.fetch_add(1, Ordering::Relaxed) + 1 < self.0
    }
}

/// A closed grid of triangles, in an order that makes many strips at first.
fn torus(around: u32, through: u32) -> DualGraph {
    let v = |x, y| y % through * around + x % around;
    let count = around * through;
    let corners = (0..count).map(|i| i * 619 % count).flat_map(|i| {
        let (x, y) = (i % around, i / around);
        let [a, b, c, d] = [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
        if (x * 5 + y * 7) % 11 < 6 { [a, b, c, a, c, d] } else { [b, c, d, a, b, d] }
    });
    DualGraph::new(&crate::mesh::Faces::from_triangles(corners.collect()).unwrap())
}

#[test]
fn the_watch_stops_it() {
    let graph = torus(90, 60);
    let searches: [fn(&DualGraph, &mut PathCover, &mut Tally<'_>); 2] = [
        |graph, cover, tally| baseline::join(graph, cover, 21, tally),
        |graph, cover, tally| eta::join(graph, cover, EtaOptions::default(), 0, tally),
    ];
    for search in searches {
        let strips = [1, 2, 1000].map(|times| {
            let mut cover = PathCover::isolated(graph.face_count());
            let watch = StopAt(times, AtomicUsize::new(0));
            search(&graph, &mut cover, &mut Tally::new(&watch));
            assert_eq!(cover.check(&graph), Ok(()));
            assert!(watch.1.into_inner() <= times);
            cover.path_count()
        });
        assert!(strips[0] > strips[1] && strips[1] > strips[2], "{strips:?}");
    }
}
