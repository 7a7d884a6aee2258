//! Tests of tunnels: a brute force that really cuts and links is compared with the searches that
//! only simulate it.

use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::accesses::{AccessCounter, SearchOutcome};
use super::baseline;
use super::context::SearchContext;
use super::path_intervals::PathIntervals;
use super::path_tags::{PathTags, TunnelStep};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};
use crate::mesh::Faces;
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
                // Both had a free link: the tunnel ends here, unless that leaves a loop.
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

/// Generates a graph, and paths over it.
pub(in crate::stripify) fn graph_and_cover() -> impl Strategy<Value = (DualGraph, PathCover)> {
    (triangle_graph(), prop::collection::vec(any::<u32>(), 0..300)).prop_map(|(graph, tries)| {
        let mut cover = PathCover::isolated(graph.face_count());
        for h in tries.iter().filter_map(|t| t.checked_rem(graph.half_edge_count() as u32)) {
            cover.join(&graph, HalfEdge(h));
        }
        (graph, cover)
    })
}

/// Checks that steps are an alternating path of the cover between terminals, without repeated
/// edges.
fn is_tunnel(graph: &DualGraph, cover: &PathCover, from: u32, steps: &[TunnelStep]) -> bool {
    let mut tip = FaceId(from);
    let mut edges = Vec::new();
    let mut cross = |h: u32, is_black: bool, tip: &mut FaceId| {
        let (half_edge, twin) = (HalfEdge(h), graph.twin(HalfEdge(h)).unwrap());
        let leads_on = graph.face_of(half_edge) == *tip && cover.is_linked(half_edge) == is_black;
        *tip = graph.face_of(twin);
        edges.push(half_edge.min(twin));
        leads_on
    };
    let is_path = steps.iter().enumerate().all(|(i, step)| {
        let leads_on = cross(step.red, false, &mut tip);
        leads_on
            && match step.black.get() {
                Some(black) => i + 1 < steps.len() && cross(black, true, &mut tip),
                None => i + 1 == steps.len() && cover.degree(tip) < 2,
            }
    });
    let count = edges.len();
    edges.sort_unstable();
    edges.dedup();
    is_path && edges.len() == count && cover.degree(FaceId(from)) < 2
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 4))]

    #[test]
    fn finds_a_tunnel_wherever_the_brute_force_does((graph, mut cover) in graph_and_cover(), length in 0..5_u32) {
        let length = 2 * length + 1;
        let mut tags = PathTags::new(&graph, &cover);
        let mut search = baseline::TunnelSearch::default();
        // Complement all tunnels, shortest first, and compare with the brute force before each.
        loop {
            let shortest = brute_force(&graph, &cover, length as usize);
            let context = SearchContext { graph: &graph, cover: &cover, tags: &tags };
            let found = (1..=length).step_by(2).find_map(|length| {
                (0..cover.len() as u32).filter(|&t| context.is_terminal(t)).find(|&t| {
                    search.find(&context, t, length, &mut AccessCounter::new(&())) == SearchOutcome::Found
                })
            });
            let steps = search.tunnel.steps();
            prop_assert_eq!(found.map(|_| 2 * steps.len() - 1), shortest);
            let Some(from) = found else { break };
            prop_assert!(is_tunnel(&graph, &cover, from, steps));
            let paths = cover.path_count();
            tags.complement(&graph, &mut cover, steps);
            prop_assert_eq!(cover.check(&graph), Ok(()));
            prop_assert_eq!(cover.path_count(), paths - 1);
            prop_assert!(tags.check(&graph, &cover));
        }
    }

    #[test]
    fn leaves_no_tunnel_of_its_length((graph, mut cover) in graph_and_cover(), length in 0..9_u32) {
        baseline::join(&graph, &mut cover, length, &mut AccessCounter::new(&()));
        prop_assert_eq!(cover.check(&graph), Ok(()));
        prop_assert_eq!(brute_force(&graph, &cover, length as usize), None);
    }
}

/// Without that end it would try all odd lengths, two billion of them, and then the first one
/// again.
#[test]
fn ends_after_the_longest_path_whatever_the_limit() {
    // Two adjacent triangles, an isolated one, and a closed fan of five.
    let fan = (0..5).flat_map(|i| [7, 8 + i, 8 + (i + 1) % 5]);
    let corners = [0, 1, 2, 2, 1, 3, 4, 5, 6].into_iter().chain(fan).collect();
    let graph = DualGraph::new(&Faces::from_triangles(corners).unwrap());
    let mut cover = PathCover::isolated(8);
    baseline::join(&graph, &mut cover, u32::MAX, &mut AccessCounter::new(&()));
    assert_eq!(cover.path_count(), 3);
    let empty = DualGraph::new(&Faces::default());
    baseline::join(&empty, &mut PathCover::isolated(0), u32::MAX, &mut AccessCounter::new(&()));
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
    /// Takes random steps, undoes some of them, and does the same on covers.
    #[test]
    fn path_intervals_count_the_loops((graph, cover) in graph_and_cover(), terminal in any::<u32>(), turns in prop::collection::vec(0..7_usize, 0..40)) {
        prop_assume!(!cover.is_empty());
        let terminal = terminal % cover.len() as u32;
        prop_assume!(cover.degree(FaceId(terminal)) < 2);
        let tags = PathTags::new(&graph, &cover);
        let mut intervals = PathIntervals::default();
        intervals.begin(&tags, terminal);
        let mut covers = vec![(cover.clone(), FaceId(terminal))];
        for turn in turns {
            let (mut changed, tip) = covers[covers.len() - 1].clone();
            if turn == 6 {
                if covers.len() > 1 {
                    covers.pop();
                    intervals.undo();
                }
                prop_assert_eq!(intervals.loops() as usize, loops(&graph, &covers[covers.len() - 1].0));
                continue;
            }
            let red = HalfEdge(3 * tip.0 + turn as u32 / 2);
            let Some(twin) = graph.twin(red).filter(|_| !cover.is_linked(red) && !changed.is_linked(red)) else { continue };
            let v = graph.face_of(twin);
            let Some(black) = cover.edges(v)[turn % 2] else { continue };
            let b = graph.face_of(graph.twin(black).unwrap());
            let may_step = changed.cut(&graph, black);
            prop_assert_eq!(intervals.step(&tags, v.0, b.0), may_step);
            if may_step {
                prop_assert!(changed.link(&graph, red));
                prop_assert_eq!(intervals.loops() as usize, loops(&graph, &changed));
                covers.push((changed, b));
            }
        }
    }

    #[test]
    fn strips_of_any_mesh_are_proven(polygons in polygons(false, 1..5), length in 0..12_u32) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let options = StripifyOptions::default().with_method(Method::Tunnel { length });
        let plan = plan(&prepared, &graph, &options).unwrap();
        prop_assert!(verify(&mesh, &plan.strips()).is_ok());
    }
}

/// Stops a search at the n-th call.
struct StopAt(usize, AtomicUsize);

impl Watch for StopAt {
    fn go_on(&self, progress: Progress) -> bool {
        assert!(progress.strips > 0 && progress.steps > 0);
        self.1.fetch_add(1, Ordering::Relaxed) + 1 < self.0
    }
}

/// Builds a closed grid of triangles, in an order that gives many strips at first.
pub(in crate::stripify) fn torus(around: u32, through: u32) -> DualGraph {
    let v = |x, y| y % through * around + x % around;
    let count = around * through;
    let corners = (0..count).map(|i| i * 619 % count).flat_map(|i| {
        let (x, y) = (i % around, i / around);
        let [a, b, c, d] = [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
        if (x * 5 + y * 7) % 11 < 6 { [a, b, c, a, c, d] } else { [b, c, d, a, b, d] }
    });
    DualGraph::new(&Faces::from_triangles(corners.collect()).unwrap())
}

/// Checks that a watcher stops a search that joins the triangles of a closed grid, and that the
/// cover is then valid.
pub(in crate::stripify) fn check_watch(join: impl Fn(&DualGraph, &mut PathCover, &dyn Watch)) {
    let graph = torus(90, 60);
    let strips = [1, 2, 1000].map(|times| {
        let mut cover = PathCover::isolated(graph.face_count());
        let watch = StopAt(times, AtomicUsize::new(0));
        join(&graph, &mut cover, &watch);
        assert_eq!(cover.check(&graph), Ok(()));
        assert!(watch.1.into_inner() <= times);
        cover.path_count()
    });
    assert!(strips[0] > strips[1] && strips[1] > strips[2], "{strips:?}");
}

#[test]
fn the_watch_stops_it() {
    check_watch(|graph, cover, watch| baseline::join(graph, cover, 21, &mut AccessCounter::new(watch)));
}
