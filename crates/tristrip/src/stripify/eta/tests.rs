//! Tests of `eta`: a search that really cuts and links, the star against distances, and runs with
//! and without localization.

use std::sync::atomic::{AtomicU64, Ordering};

use proptest::prelude::*;

use super::star::EtaStar;
use super::tagged_strips::{TagLink, TaggedStrips};
use super::{EtaOptions, join};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::{FaceId, HalfEdge};
use crate::prepare::PreparedFaces;
use crate::stripify::sequential::tests::{mesh, polygons};
use crate::stripify::tunnel::path_tags::PathTags;
use crate::stripify::tunnel::tests::{check_watch, graph_and_cover, torus};
use crate::stripify::watch::{Progress, Watch};
use crate::stripify::{Acceptance, Localization, Method, Start, StripifyOptions, TunnelOptions, plan};
use crate::verify::verify;

/// Returns the default options with other tunnels.
fn eta(tunnels: TunnelOptions) -> EtaOptions {
    EtaOptions { tunnels, acceptance: Acceptance::default(), localization: Localization::default() }
}

fn exhaustive(length: u32) -> EtaOptions {
    eta(TunnelOptions::ETA.with_length(length).with_threshold(u32::MAX))
}

fn joined(graph: &DualGraph, cover: &PathCover, options: EtaOptions, seed: u64) -> PathCover {
    let mut cover = cover.clone();
    join(graph, &mut cover, options, seed, &());
    cover
}

/// Returns whether a terminal has a tunnel of at most `length` edges without a step that closes a
/// loop, by cutting and linking on the cover itself.
fn has_tunnel(graph: &DualGraph, cover: &PathCover, length: usize) -> bool {
    fn follow(
        graph: &DualGraph,
        original: &PathCover,
        cover: &mut PathCover,
        tip: FaceId,
        left: usize,
        used: &mut Vec<HalfEdge>,
    ) -> bool {
        for red in graph.half_edges(tip) {
            let Some(twin) = graph.twin(red) else { continue };
            if left == 0 || original.is_linked(red) || used.contains(&red) || used.contains(&twin) {
                continue;
            }
            if cover.link(graph, red) {
                let is_open = cover.check(graph).is_ok();
                cover.cut(graph, red);
                if is_open {
                    return true;
                }
            }
            for black in original.edges(graph.face_of(twin)).into_iter().flatten() {
                if left < 3 || !cover.is_linked(black) {
                    continue;
                }
                let far = graph.face_of(graph.twin(black).unwrap());
                cover.cut(graph, black);
                assert!(cover.link(graph, red));
                used.push(red);
                let found = cover.check(graph).is_ok() && follow(graph, original, cover, far, left - 2, used);
                used.pop();
                cover.cut(graph, red);
                assert!(cover.link(graph, black));
                if found {
                    return true;
                }
            }
        }
        false
    }
    let mut changed = cover.clone();
    let mut terminals = (0..cover.len() as u32).map(FaceId).filter(|&t| cover.degree(t) < 2);
    terminals.any(|t| follow(graph, cover, &mut changed, t, length, &mut Vec::new()))
}

/// Returns the number of steps from a triangle to every other one.
fn distances(graph: &DualGraph, from: u32) -> Vec<u32> {
    let mut distances = vec![u32::MAX; graph.face_count()];
    distances[from as usize] = 0;
    let mut queue = std::collections::VecDeque::from([from]);
    while let Some(t) = queue.pop_front() {
        for v in (3 * t..3 * t + 3).filter_map(|h| Some(graph.twin_of(h)? / 3)) {
            if distances[v as usize] == u32::MAX {
                distances[v as usize] = distances[t as usize] + 1;
                queue.push_back(v);
            }
        }
    }
    distances
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 4))]

    #[test]
    fn leaves_no_tunnel_without_loops((graph, cover) in graph_and_cover(), half in 0..4_u32, seed in any::<u64>()) {
        let length = 2 * half + 1;
        for acceptance in Acceptance::ALL.iter().copied() {
            let joined = joined(&graph, &cover, EtaOptions { acceptance, ..exhaustive(length) }, seed);
            prop_assert_eq!(joined.check(&graph), Ok(()));
            prop_assert!((graph.components().1..=cover.path_count()).contains(&joined.path_count()));
            prop_assert!(!has_tunnel(&graph, &joined, length as usize), "{}", acceptance);
        }
    }

    #[test]
    fn localization_leaves_the_strips_as_they_are((graph, cover) in graph_and_cover(), length in 0..40_u32, seed in any::<u64>()) {
        for acceptance in Acceptance::ALL.iter().copied() {
            let options = EtaOptions { acceptance, ..eta(TunnelOptions::ETA.with_length(length).with_threshold(200)) };
            let [local, plain, on_demand] =
                [Localization::Star, Localization::None, Localization::OnDemand].map(|l| joined(&graph, &cover, EtaOptions { localization: l, ..options }, seed));
            prop_assert_eq!(&local, &plain);
            prop_assert_eq!(&local, &on_demand);
            prop_assert_eq!(&local, &joined(&graph, &cover, options, seed));
        }
    }

    #[test]
    fn strips_of_any_mesh_are_proven(polygons in polygons(false, 1..5), seed in any::<u64>()) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        for start in Start::ALL.iter().copied() {
            let EtaOptions { tunnels, acceptance, localization } = eta(TunnelOptions::ETA.with_start(start));
            let method = Method::Eta { tunnels, acceptance, localization };
            let options = StripifyOptions::default().with_method(method).with_seed(seed);
            let plan = plan(&prepared, &graph, &options).unwrap();
            prop_assert!(verify(&mesh, &plan.strips()).is_ok(), "{:?}", start);
        }
    }

    /// Within the star every strip keeps the order of its triangles, and continues where it
    /// returns.
    #[test]
    fn temporary_edges_bridge_what_lies_outside((graph, cover) in graph_and_cover(), length in 0..6_u32, at in any::<prop::sample::Index>()) {
        prop_assume!(!cover.is_empty());
        let terminal = at.index(cover.len()) as u32;
        let tags = PathTags::new(&graph, &cover);
        let mut strips = TaggedStrips::new(&cover, &tags);
        let before: Vec<_> = (0..cover.len() as u32).map(|t| strips.links(t)).collect();
        let mut star = EtaStar::default();
        star.build((&graph, &cover, &tags), terminal, length, &mut strips);
        let distances = distances(&graph, terminal);
        let is_inside = |t: u32| distances[t as usize] <= length;
        let mut inside: Vec<u32> = (0..cover.len() as u32).filter(|&t| is_inside(t)).collect();
        inside.sort_by_key(|&t| (tags.path(t), tags.position(t)));
        for pair in inside.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let is_joined = |a: u32, b: u32| strips.links(a).into_iter().any(|link| match link {
                TagLink::Black(h) => graph.twin_of(h).is_some_and(|twin| twin / 3 == b),
                TagLink::Temporary(other) => other == b,
                TagLink::Free | TagLink::Outside => false,
            });
            prop_assert_eq!(is_joined(a, b), tags.path(a) == tags.path(b));
            prop_assert_eq!(is_joined(b, a), tags.path(a) == tags.path(b));
        }
        star.remove(&mut strips);
        for (t, links) in before.iter().enumerate() {
            let after = strips.links(t as u32);
            prop_assert!(links.iter().all(|link| after.contains(link)), "{} {:?} {:?}", t, links, after);
        }
    }
}

#[test]
fn makes_few_strips_of_a_closed_grid() {
    let graph = torus(60, 40);
    let isolated = PathCover::isolated(graph.face_count());
    let covers = [1, 1, 2].map(|seed| joined(&graph, &isolated, eta(TunnelOptions::ETA), seed));
    assert!(covers[0] == covers[1] && covers[0] != covers[2], "the seed decides");
    assert!(covers.iter().all(|cover| cover.path_count() <= 3), "{:?}", covers.map(|c| c.path_count()));
}

/// Localization makes the accesses of a search independent of the lengths of strips.
#[test]
fn localization_saves_accesses_where_strips_are_long() {
    #[derive(Default)]
    struct TestAccesses(AtomicU64, AtomicU64);
    impl Watch for TestAccesses {
        fn go_on(&self, _: Progress) -> bool {
            true
        }
        fn search_ended(&self, accesses: u64, has_found: bool) {
            self.0.fetch_add(accesses, Ordering::Relaxed);
            self.1.fetch_add(u64::from(has_found), Ordering::Relaxed);
        }
    }
    let graph = torus(120, 80);
    let options = eta(TunnelOptions::ETA.with_length(19));
    let [local, plain] = [Localization::Star, Localization::None].map(|localization| {
        let accesses = TestAccesses::default();
        let mut cover = PathCover::isolated(graph.face_count());
        join(&graph, &mut cover, EtaOptions { localization, ..options }, 7, &accesses);
        assert_eq!(accesses.1.into_inner(), (cover.len() - cover.path_count()) as u64);
        accesses.0.into_inner()
    });
    assert!(2 * local < plain, "{local} {plain}");
}

#[test]
fn the_watch_stops_it() {
    check_watch(|graph, cover, watch| join(graph, cover, eta(TunnelOptions::ETA), 0, watch));
}
