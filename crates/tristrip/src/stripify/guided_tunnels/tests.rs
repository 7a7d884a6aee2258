//! Tests of `guided-tunnels` over generated graphs and closed grids.

use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use super::join;
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::prepare::PreparedFaces;
use crate::stripify::sequential::tests::{mesh, polygons};
use crate::stripify::tunnel::context::{DualArc, SearchContext};
use crate::stripify::tunnel::path_tags::PathTags;
use crate::stripify::tunnel::tests::{check_watch, graph_and_cover, torus};
use crate::stripify::{Method, Start, StripifyOptions, TunnelOptions, plan};
use crate::verify::verify;

/// Joins isolated triangles.
fn cover_of(graph: &DualGraph, seed: u64) -> PathCover {
    let mut cover = PathCover::isolated(graph.face_count());
    join(graph, &mut cover, TunnelOptions::default(), seed, &());
    assert_eq!(cover.check(graph), Ok(()));
    cover
}

proptest! {
    #[test]
    fn joins_any_cover((graph, cover) in graph_and_cover(), length in 0..60_u32, seed in any::<u64>()) {
        let join = |length| {
            let mut cover = cover.clone();
            join(&graph, &mut cover, TunnelOptions::default().with_length(length), seed, &());
            cover
        };
        let joined = join(length);
        prop_assert_eq!(joined.check(&graph), Ok(()));
        prop_assert!(joined.path_count() <= cover.path_count());
        prop_assert!(joined.path_count() >= graph.components().1);
        prop_assert_eq!(&joined, &join(length));
    }

    #[test]
    fn strips_of_any_mesh_are_proven(polygons in polygons(false, 1..5), seed in any::<u64>()) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        for start in [Start::Isolated, Start::Input, Start::Sgi, Start::Sequential] {
            let method = Method::GuidedTunnels(TunnelOptions::default().with_start(start));
            let options = StripifyOptions::default().with_method(method).with_seed(seed);
            let plan = plan(&prepared, &graph, &options).unwrap();
            prop_assert!(verify(&mesh, &plan.strips()).is_ok(), "{:?}", start);
        }
    }
}

/// The inputs are fixed, because terminals that move in the last passes may leave such a pair.
#[test]
fn leaves_no_terminals_of_two_strips_side_by_side() {
    let mut runner = TestRunner::deterministic();
    let mut pair_count = 0;
    for _ in 0..200 {
        let inputs = (graph_and_cover(), 1..60_u32, any::<u64>());
        let ((graph, mut cover), length, seed) = inputs.new_tree(&mut runner).unwrap().current();
        join(&graph, &mut cover, TunnelOptions::default().with_length(length), seed, &());
        let tags = PathTags::new(&graph, &cover);
        let context = SearchContext { graph: &graph, cover: &cover, tags: &tags };
        for t in (0..cover.len() as u32).filter(|&t| context.is_terminal(t)) {
            for v in context.red_edges(t).map(DualArc::target).filter(|&v| context.is_terminal(v)) {
                assert_eq!(tags.path(v), tags.path(t), "{t} {v}");
                pair_count += 1;
            }
        }
    }
    assert!(pair_count > 100, "{pair_count}");
}

#[test]
fn makes_one_strip_of_a_closed_grid() {
    let graph = torus(90, 60);
    for seed in 0..4 {
        assert_eq!(cover_of(&graph, seed).path_count(), 1, "{seed}");
    }
}

#[test]
fn the_seed_decides() {
    let graph = torus(30, 20);
    let covers = [1, 1, 2].map(|seed| cover_of(&graph, seed));
    assert!(covers[0] == covers[1] && covers[0] != covers[2]);
}

#[test]
fn the_watch_stops_it() {
    check_watch(|graph, cover, watch| join(graph, cover, TunnelOptions::default(), 0, watch));
}
