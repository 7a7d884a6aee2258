//! Tests of tunnels: a brute force that really cuts and links, against the searches that only simulate it.

use proptest::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::ids::{Ids, NONE, Pieces, Step};
use super::order::Order;
use super::repair::Reach;
use super::{EtaOptions, Repairer, Searched, Start, Tally, baseline, eta};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::effort::Effort;
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

/// Gives the triangles within some steps of others.
fn around(graph: &DualGraph, faces: &[FaceId], steps: u32) -> Vec<bool> {
    let mut inside = vec![false; graph.face_count()];
    faces.iter().for_each(|face| inside[face.0 as usize] = true);
    for _ in 0..steps {
        let ring: Vec<FaceId> = (0..inside.len()).filter(|&t| inside[t]).map(|t| FaceId(t as u32)).collect();
        ring.into_iter().flat_map(|t| graph.neighbours(t)).for_each(|t| inside[t.0 as usize] = true);
    }
    inside
}

/// Cuts all links of triangles.
fn cut_off(graph: &DualGraph, cover: &mut PathCover, faces: &[FaceId]) {
    for &face in faces {
        for edge in cover.edges(face).into_iter().flatten() {
            cover.cut(graph, edge);
        }
    }
}

proptest! {
    #[test]
    fn repair_joins_near_the_change_only(
        (graph, mut cover) in graph_and_cover(),
        changed in prop::collection::vec(any::<u32>(), 0..5),
        (radius, threshold) in (1..5_u32, 1..100_u32),
    ) {
        prop_assume!(!cover.is_empty());
        let changed: Vec<FaceId> = changed.iter().map(|t| FaceId(t % cover.len() as u32)).collect();
        let mut repairer = Repairer::new(&graph, &cover);
        let touched = around(&graph, &changed, 1);
        let touched: Vec<FaceId> = (0..cover.len() as u32).map(FaceId).filter(|t| touched[t.0 as usize]).collect();
        cut_off(&graph, &mut cover, &changed);
        let before = cover.clone();
        let reach = Reach { radius, threshold };
        let repaired = repairer.repair_within(&graph, &mut cover, &touched, reach);
        prop_assert_eq!(cover.check(&graph), Ok(()));
        prop_assert_eq!(before.path_count() - cover.path_count(), repaired.joined);
        let near = around(&graph, &touched, 1 + radius);
        for t in (0..cover.len()).filter(|&t| !near[t]) {
            prop_assert_eq!(cover.edges(FaceId(t as u32)), before.edges(FaceId(t as u32)));
        }
        // A worker that is used again does the same as a new one.
        let mut again = cover.clone();
        cut_off(&graph, &mut again, &changed);
        let mut new = again.clone();
        prop_assert_eq!(
            repairer.repair_within(&graph, &mut again, &touched, reach),
            Repairer::new(&graph, &new).repair_within(&graph, &mut new, &touched, reach)
        );
        prop_assert_eq!(again, new);
    }

    #[test]
    fn the_order_follows((graph, mut cover) in graph_and_cover(), tries in prop::collection::vec(any::<u32>(), 0..200)) {
        let mut order = Order::new(&graph, &cover);
        prop_assert!(order.check(&graph, &cover));
        let tries: Vec<HalfEdge> = tries.iter().filter_map(|t| t.checked_rem(graph.half_edge_count() as u32)).map(HalfEdge).collect();
        for some in tries.chunks(3) {
            for &h in some {
                let _ = cover.cut(&graph, h) || cover.join(&graph, h);
            }
            let changed = some.iter().flat_map(|&h| [Some(h), graph.twin(h)]).flatten().map(|h| h.0 / 3);
            order.follow(&graph, &cover, changed);
            prop_assert!(order.check(&graph, &cover));
        }
    }
}

/// A graph in one strip, and triangles strewn over it.
fn one_strip(around: u32, through: u32, changed_count: usize) -> (DualGraph, PathCover, Vec<FaceId>) {
    let graph = torus(around, through);
    let mut cover = PathCover::isolated(graph.face_count());
    eta::join(&graph, &mut cover, EtaOptions::default(), 0, &mut Tally::new(&()));
    assert_eq!(cover.path_count(), 1);
    let changed = (0..changed_count).map(|i| FaceId((i * 7919 % cover.len()) as u32)).collect();
    (graph, cover, changed)
}

#[test]
fn repair_brings_the_strips_back() {
    let (graph, mut cover, changed) = one_strip(90, 60, 100);
    let near = around(&graph, &changed, 1);
    let near: Vec<FaceId> = (0..near.len() as u32).map(FaceId).filter(|t| near[t.0 as usize]).collect();
    let whole = cover.clone();
    cut_off(&graph, &mut cover, &near);
    let changed: Vec<FaceId> =
        (0..cover.len() as u32).map(FaceId).filter(|&t| cover.edges(t) != whole.edges(t)).collect();
    let broken = cover.path_count();
    assert!(broken > 300);
    let left = [0, 2, 5, 9].map(|level| {
        let mut cover = cover.clone();
        Repairer::new(&graph, &whole).repair(&graph, &mut cover, &changed, Effort::new(level).unwrap());
        assert_eq!(cover.check(&graph), Ok(()));
        cover.path_count()
    });
    assert!(
        left[2] <= broken / 20 && left[3] <= left[2] && left[2] <= left[1] && left[1] <= left[0],
        "{left:?}"
    );
}

#[test]
fn repair_takes_as_long_in_a_large_mesh() {
    let accesses = [(30, 20), (90, 60), (180, 120)].map(|(around, through)| {
        let (graph, mut cover, changed) = one_strip(around, through, 16);
        let mut repairer = Repairer::new(&graph, &cover);
        let touched = changed.iter().flat_map(|&t| graph.neighbours(t).chain([t])).collect::<Vec<_>>();
        cut_off(&graph, &mut cover, &changed);
        repairer.repair(&graph, &mut cover, &touched, Effort::default()).accesses
    });
    assert!(accesses[2] < 2 * accesses[1] && accesses[2] < 16 * 50_000, "{accesses:?}");
}

/// Makes the graph of those triangles that are in use; the others have no neighbours.
fn graph_of(triangles: &[Option<[u32; 3]>]) -> DualGraph {
    let used: Vec<u32> = (0..triangles.len() as u32).filter(|&t| triangles[t as usize].is_some()).collect();
    let corners = triangles.iter().flatten().flatten().copied().collect();
    let dense = DualGraph::new(&crate::mesh::Faces::from_triangles(corners).unwrap());
    let mut twins = vec![NONE; 3 * triangles.len()];
    for (h, twin) in (0..3 * used.len() as u32).filter_map(|h| Some((h, dense.twin(HalfEdge(h))?.0))) {
        twins[(3 * used[h as usize / 3] + h % 3) as usize] = 3 * used[twin as usize / 3] + twin % 3;
    }
    DualGraph::from_triangle_twins(twins)
}

#[test]
fn repair_keeps_up_with_collapses() {
    let (around, through) = (40, 30);
    let v = |x: u32, y: u32| y % through * around + x % around;
    let quads = (0..through).flat_map(|y| (0..around).map(move |x| (x, y)));
    let mut triangles: Vec<Option<[u32; 3]>> = quads
        .flat_map(|(x, y)| [[v(x, y), v(x + 1, y), v(x + 1, y + 1)], [v(x, y), v(x + 1, y + 1), v(x, y + 1)]])
        .map(Some)
        .collect();
    let mut graph = graph_of(&triangles);
    let mut cover = PathCover::isolated(triangles.len());
    eta::join(&graph, &mut cover, EtaOptions::default(), 0, &mut Tally::new(&()));
    let mut repairer = Repairer::new(&graph, &cover);
    let (mut gone, mut most, mut broken) = (0, 0, 0);
    for i in 0..300 {
        let Some([from, to, _]) = triangles[i * 7919 % triangles.len()] else { continue };
        // Collapse `from` to `to`: the triangles of both are no more, the others of `from` are renamed.
        let mut changed = Vec::new();
        for (t, triangle) in triangles.iter_mut().enumerate() {
            let Some(corners) = triangle else { continue };
            if corners.contains(&from) || corners.contains(&to) {
                changed.push(FaceId(t as u32));
            }
            if corners.contains(&from) && corners.contains(&to) {
                *triangle = None;
                gone += 1;
            } else {
                *corners = corners.map(|v| if v == from { to } else { v });
            }
        }
        let new_graph = graph_of(&triangles);
        let mut new_cover = PathCover::isolated(triangles.len());
        for h in (0..cover.len() as u32).flat_map(|t| cover.edges(FaceId(t))).flatten() {
            if new_graph.twin(h) == graph.twin(h) {
                new_cover.link(&new_graph, h);
            }
        }
        (graph, cover) = (new_graph, new_cover);
        broken += cover.path_count() - gone;
        repairer.repair(&graph, &mut cover, &changed, Effort::default());
        assert_eq!(cover.check(&graph), Ok(()), "{i}");
        most = most.max(cover.path_count() - gone);
        broken -= cover.path_count() - gone;
    }
    // A strip in each hundred triangles: their ends are farther apart than the repair looks.
    assert!(most <= 15 && broken > 300, "{most} {broken}");
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
