//! Tests of the search on whole meshes. Where a heuristic must find the optimum, the inputs are the
//! same in every run.

use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};

use super::*;
use crate::ids::HalfEdge;
use crate::mesh::{Faces, Mesh};
use crate::stripify::bound::Bound;
use crate::stripify::generated_meshes::{mesh, polygons};
use crate::verify::verify;

/// Stops a search after a number of calls.
struct Calls(AtomicU64, u64);

impl Watch for Calls {
    fn go_on(&self, _: Progress) -> bool {
        self.0.fetch_add(1, Ordering::Relaxed) < self.1
    }
}

fn options(level: u8, seed: u64) -> StripifyOptions {
    StripifyOptions::default().with_effort(Effort::new(level).unwrap()).with_seed(seed)
}

/// Runs a test on inputs that are the same in every run.
fn for_fixed_inputs<S: Strategy>(strategy: &S, test: impl Fn(S::Value) -> Result<(), TestCaseError>) {
    let config = ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    runner.run(strategy, test).unwrap();
}

/// Returns the dual graph of at most 13 triangles.
fn small_graph(triangles: &[Vec<u32>]) -> DualGraph {
    let mesh = mesh(&triangles[..triangles.len().min(13)]);
    DualGraph::new(PreparedFaces::new(&mesh, false).faces())
}

/// Builds a closed lattice of triangles in which every triangle has three neighbours.
fn torus(around: u32, through: u32) -> Mesh {
    let v = |x: u32, y: u32| y % through * around + x % around;
    let corners = (0..through).flat_map(|y| (0..around).map(move |x| (x, y))).flat_map(|(x, y)| {
        let [a, b, c, d] = [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
        if (7 * x + 3 * y) % 5 < 2 { [a, b, c, a, c, d] } else { [a, b, d, d, b, c] }
    });
    let count = (around * through) as usize;
    Mesh::new(vec![[0.0; 3]; count], Faces::from_triangles(corners.collect()).unwrap()).unwrap()
}

/// Searches by walks alone, without tunnels.
fn walk(graph: &DualGraph, cover: &mut PathCover, seed: u64, budget: u64) {
    let shared = SharedProgress::new(&(), budget, cover.path_count());
    FewestSearch::new(graph, cover, Random::new(seed)).run(1, budget, &shared);
    assert_eq!(shared.strips.into_inner(), cover.path_count());
}

/// Returns the minimum number of paths, by trying all covers.
fn fewest_by_brute_force(graph: &DualGraph) -> usize {
    fn go(graph: &DualGraph, cover: &mut PathCover, arcs: &[HalfEdge], least: &mut usize) {
        *least = (*least).min(cover.path_count());
        if let [arc, rest @ ..] = arcs
            && cover.path_count() - arcs.len().min(cover.path_count()) < *least
        {
            if cover.join(graph, *arc) {
                go(graph, cover, rest, least);
                cover.cut(graph, *arc);
            }
            go(graph, cover, rest, least);
        }
    }
    let arcs: Vec<HalfEdge> = (0..graph.half_edge_count() as u32)
        .map(HalfEdge)
        .filter(|&h| graph.twin(h).is_some_and(|twin| twin.0 > h.0))
        .collect();
    let mut least = graph.face_count();
    go(graph, &mut PathCover::isolated(graph.face_count()), &arcs, &mut least);
    least
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 4))]

    #[test]
    fn covers_and_proves(polygons in polygons(false, 1..6), seed: u64) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let before = sequential::plan(&prepared, &graph).cover.path_count();
        let found = plan(&prepared, &graph, &options(0, seed), &());
        let graph_of_triangles = found.triangulation.graph();
        prop_assert_eq!(found.cover.check(graph_of_triangles), Ok(()));
        prop_assert!(found.cover.path_count() <= before);
        prop_assert!(found.cover.path_count() >= Bound::of_triangulation(&found.triangulation).strips);
        prop_assert!(verify(&mesh, &found.strips()).is_ok());
        let again = plan(&prepared, &graph, &options(0, seed), &());
        prop_assert_eq!(found.cover, again.cover);
    }
}

#[test]
fn finds_the_fewest_on_small_graphs() {
    for_fixed_inputs(&polygons(true, 1..4), |triangles| {
        let graph = small_graph(&triangles);
        let mut cover = PathCover::isolated(graph.face_count());
        let lower_bounds = vec![1; graph.components().1];
        reduce_paths(&graph, &mut cover, &lower_bounds, &options(3, 1), &());
        prop_assert_eq!(cover.check(&graph), Ok(()));
        prop_assert_eq!(cover.path_count(), fewest_by_brute_force(&graph));
        Ok(())
    });
}

#[test]
fn walks_find_the_fewest_on_small_connected_graphs() {
    for_fixed_inputs(&(polygons(true, 1..2), any::<u64>()), |(triangles, seed)| {
        let graph = small_graph(&triangles);
        let mut cover = PathCover::isolated(graph.face_count());
        walk(&graph, &mut cover, seed, 30_000);
        prop_assert_eq!(cover.check(&graph), Ok(()));
        prop_assert_eq!(cover.path_count(), fewest_by_brute_force(&graph));
        Ok(())
    });
}

#[test]
fn covers_closed_lattices_by_one_path() {
    for (around, through) in [(3, 5), (16, 16), (40, 50)] {
        let mesh = torus(around, through);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let mut cover = PathCover::isolated(graph.face_count());
        reduce_paths(&graph, &mut cover, &[1], &options(5, 1), &());
        assert_eq!(cover.check(&graph), Ok(()));
        assert_eq!(cover.path_count(), 1, "{around} x {through}");
        let mut cover = PathCover::isolated(graph.face_count());
        walk(&graph, &mut cover, 1, 1_000_000);
        assert_eq!(cover.check(&graph), Ok(()));
        assert_eq!(cover.path_count(), 1, "{around} x {through}, by walks");
    }
}

#[test]
fn does_not_touch_components_at_their_lower_bound() {
    let mesh = torus(10, 10);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let start = sequential::plan(&prepared, &graph).cover;
    assert!(start.path_count() > 1, "there is something to join");
    let mut cover = start.clone();
    reduce_paths(&graph, &mut cover, &[start.path_count()], &options(5, 1), &());
    assert_eq!(cover, start);
}

#[test]
fn stops_with_a_valid_cover_on_request() {
    let mesh = torus(60, 60);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let mut counts = Vec::new();
    for calls in [0, 3, 1_000_000] {
        let mut cover = PathCover::isolated(graph.face_count());
        reduce_paths(&graph, &mut cover, &[1], &options(5, 1), &Calls(AtomicU64::new(0), calls));
        assert_eq!(cover.check(&graph), Ok(()));
        counts.push(cover.path_count());
    }
    assert!(counts[0] > counts[1] && counts[1] > counts[2], "{counts:?}");
    assert_eq!(counts[2], 1);
}

#[test]
fn ends_when_the_effort_is_used_up() {
    struct Furthest(AtomicU64, AtomicU64);
    impl Watch for Furthest {
        fn go_on(&self, progress: Progress) -> bool {
            self.0.fetch_max(progress.steps, Ordering::Relaxed);
            self.1.store(progress.step_limit.unwrap(), Ordering::Relaxed);
            true
        }
    }
    let mesh = torus(40, 50);
    let graph = DualGraph::new(mesh.faces());
    let mut steps = Vec::new();
    for level in [0, 4] {
        let furthest = Furthest(AtomicU64::new(0), AtomicU64::new(0));
        // No cover has zero paths, so only the effort ends the search.
        reduce_paths(
            &graph,
            &mut PathCover::isolated(graph.face_count()),
            &[0],
            &options(level, 1),
            &furthest,
        );
        let (found, limit) = (furthest.0.into_inner(), furthest.1.into_inner());
        assert!(found <= limit + limit / 4, "{found} of {limit} steps at level {level}");
        steps.push(found);
    }
    assert!(steps[1] > 2 * steps[0], "{steps:?}");
}

#[test]
fn another_component_does_not_change_the_cover() {
    // The first of two lattices in one mesh is covered as if it were alone.
    let one = torus(12, 9);
    let corners = one.faces().corners();
    let count = one.positions().len() as u32;
    let both: Vec<u32> = corners.iter().copied().chain(corners.iter().map(|v| v + count)).collect();
    let cover_of = |corners: Vec<u32>| {
        let graph = DualGraph::new(&Faces::from_triangles(corners).unwrap());
        let mut cover = PathCover::isolated(graph.face_count());
        let lower_bounds = vec![1; graph.components().1];
        reduce_paths(&graph, &mut cover, &lower_bounds, &options(5, 1), &());
        assert_eq!(cover.check(&graph), Ok(()));
        cover
    };
    let (alone, both) = (cover_of(corners.to_vec()), cover_of(both));
    assert_eq!(both.path_count(), 2);
    for t in 0..alone.len() as u32 {
        assert_eq!(alone.packed_edges(t), both.packed_edges(t));
    }
}
