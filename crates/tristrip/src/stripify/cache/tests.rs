//! Tests of growth, speculative simulation and order annealing on generated meshes of many kinds
//! and on meshes with known results.

use proptest::prelude::*;

use super::active_front::ActiveFront;
use super::anneal_order::StripSequence;
use super::grow::StripGrower;
use super::policy::{GrowthPolicy, PolicyWeights, SeedStrips};
use super::speculative::SpeculativeFifo;
use crate::dual::DualGraph;
use crate::effort::Effort;
use crate::mesh::{Faces, Mesh};
use crate::prepare::PreparedFaces;
use crate::random::Random;
use crate::strip::{Metrics, Strips};
use crate::stripify::generated_meshes::{mesh, polygons};
use crate::stripify::{Method, Objective, Progress, StripPlan, StripifyOptions, Watch, plan, sequential};
use crate::verify::verify;
use crate::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};

const OBJECTIVES: [Objective; 3] = [Objective::Indices, Objective::Balanced, Objective::Misses];

fn options(objective: Objective, vertex_cache: VertexCache) -> StripifyOptions {
    let options = StripifyOptions::default().with_method(Method::Cache);
    options.with_objective(objective).with_vertex_cache(vertex_cache)
}

/// Returns a grid of `columns` × `rows` squares, all cut along the same diagonal, with its
/// triangles in scattered order.
fn grid(columns: u32, rows: u32) -> Mesh {
    let vertex = |x: u32, y: u32| y * (columns + 1) + x;
    let squares = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
    let mut triangles: Vec<[u32; 3]> = squares
        .flat_map(|(x, y)| {
            let [a, b, c, d] = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|(x, y)| vertex(x, y));
            [[a, b, c], [a, c, d]]
        })
        .collect();
    triangles.sort_by_key(|t| u64::from(t[0] + 7 * t[2]) * 0x9E37_79B9 % 65_521);
    let count = (columns + 1) * (rows + 1);
    Mesh::new(vec![[0.0; 3]; count as usize], Faces::from_triangles(triangles.concat()).unwrap()).unwrap()
}

fn strips(mesh: &Mesh, options: &StripifyOptions) -> Strips {
    let prepared = PreparedFaces::new(mesh, false);
    let graph = DualGraph::new(prepared.faces());
    plan(&prepared, &graph, options).unwrap().strips()
}

/// Returns the strips in the vertex order that the active front prices: the repeated vertex of a
/// swap comes after the vertex that it precedes.
fn priced(strips: &Strips) -> Strips {
    let mut priced = Strips::default();
    for strip in strips.iter() {
        let mut strip = strip.to_vec();
        let swaps: Vec<usize> = (2..strip.len()).filter(|&i| strip[i] == strip[i - 2]).collect();
        swaps.into_iter().for_each(|i| strip.swap(i, i + 1));
        priced.push(&strip);
    }
    priced
}

proptest! {
    #[test]
    fn every_objective_covers_every_mesh(
        polygons in polygons(false, 1..8),
        entry_count in 0..40_u32,
        is_lru in any::<bool>(),
        effort in 0..5_u8,
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let vertex_cache = if is_lru { VertexCache::lru(entry_count) } else { VertexCache::fifo(entry_count) };
        for objective in OBJECTIVES {
            let options = options(objective, vertex_cache).with_effort(Effort::new(effort).unwrap());
            let plan = plan(&prepared, &graph, &options).unwrap();
            prop_assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()));
            prop_assert_eq!(plan.order.as_ref().map(Vec::len), Some(plan.cover.path_count()));
            let strips = plan.strips();
            prop_assert!(verify(&mesh, &strips).is_ok());
            prop_assert_eq!(plan.indices_restart(), Metrics::of(&strips).indices_restart);
        }
    }

    #[test]
    fn the_active_front_prices_strips_exactly_after_any_simulation(
        polygons in polygons(false, 1..8),
        entry_count in 3..20_u32,
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let seed_plan = sequential::plan(&prepared, &graph);
        let [balanced, misses] = [Objective::Balanced, Objective::Misses].map(GrowthPolicy::all);
        for (policy, weights) in [(balanced[0], [1, 0]), (balanced[1], [1, 0]), (misses[0], [0, 1])] {
            let weights = PolicyWeights { index: weights[0], miss: weights[1] };
            let policy = policy.with_weights(weights);
            let triangulation = &seed_plan.triangulation;
            let vertex_cache = VertexCache::fifo(entry_count);
            let cache = SpeculativeFifo::new(entry_count, prepared.vertex_count());
            let front = ActiveFront::new(triangulation, cache, weights);
            let anticipated = front.anticipated_cost();
            let cover = (policy.seeds != SeedStrips::None).then_some(&seed_plan.cover);
            let mut grower = StripGrower::new(front, policy, cover);
            let (cover, order) = grower.run();
            let plan = StripPlan::in_order(triangulation.clone(), cover, order);
            let strips = plan.strips();
            let paid = grower.front().cost() + anticipated;
            if weights.index > 0 {
                prop_assert_eq!(paid.unsigned_abs() as usize, strips.vertices_sent() + strips.len());
            } else {
                let misses = VertexCacheStatistics::of(&priced(&strips), vertex_cache, FlushPolicy::Keep).misses;
                prop_assert_eq!(paid.unsigned_abs() as usize, misses);
            }
        }
    }
}

proptest! {
    #[test]
    fn annealing_reports_the_cost_that_it_saves(
        polygons in polygons(false, 1..8),
        entry_count in 1..20_u32,
        seed in any::<u64>(),
        weights in prop::sample::select(vec![[1, 0], [0, 1], [3, 2]]),
        hottest in 0.2..9.0_f64,
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let vertex_cache = VertexCache::fifo(entry_count);
        let start = plan(&prepared, &graph, &options(Objective::Balanced, vertex_cache)).unwrap();
        let order = start.order.as_ref().unwrap();
        let weights = PolicyWeights { index: weights[0], miss: weights[1] };
        let price = |plan: &StripPlan<'_>| super::price(plan, vertex_cache, weights);
        let mut sequence = StripSequence::new(&start.triangulation, &start.cover, order, entry_count, weights);
        let mut reported = (0, 0);
        for run in 0..3 {
            let mut random = Random::new(seed ^ run);
            sequence.anneal(&mut random, 20_000, [hottest, 0.1], |_, strips, saved| {
                reported = (strips, saved);
                true
            });
            let (cover, order) = sequence.finish();
            let found = StripPlan::in_order(start.triangulation.clone(), cover, order);
            prop_assert_eq!(found.cover.check(found.triangulation.graph()), Ok(()));
            prop_assert!(verify(&mesh, &found.strips()).is_ok());
            // The next run first reports what all previous runs saved.
            sequence.anneal(&mut random, 0, [0.1, 0.1], |_, strips, saved| {
                reported = (strips, saved);
                true
            });
            prop_assert_eq!(reported.0, found.cover.path_count());
            prop_assert_eq!(price(&start).cast_signed() as i64 - price(&found).cast_signed() as i64, reported.1);
        }
    }
}

#[test]
fn a_grid_has_few_misses() {
    let mesh = grid(60, 60);
    let sizes = [
        (VertexCache::fifo(16), 0.60, 1.35),
        (VertexCache::fifo(32), 0.56, 1.2),
        (VertexCache::lru(16), 0.68, 1.6),
    ];
    for (vertex_cache, most_misses, most_indices) in sizes {
        let strips = strips(&mesh, &options(Objective::Misses, vertex_cache));
        let used = VertexCacheStatistics::of(&strips, vertex_cache, FlushPolicy::Keep);
        let indices = Metrics::of(&strips).indices_restart_per_triangle();
        assert!(
            used.acmr() < most_misses && indices < most_indices,
            "{vertex_cache}: {} {indices}",
            used.acmr()
        );
    }
}

#[test]
fn objectives_trade_indices_for_misses() {
    let mesh = grid(40, 40);
    let [indices, balanced, misses] = OBJECTIVES.map(|objective| {
        let strips = strips(&mesh, &options(objective, VertexCache::default()));
        let used = VertexCacheStatistics::of(&strips, VertexCache::default(), FlushPolicy::Keep);
        (Metrics::of(&strips).indices_restart, used.misses)
    });
    assert!(indices.0 < balanced.0 && balanced.0 <= misses.0, "{indices:?} {balanced:?} {misses:?}");
    assert!(indices.1 > balanced.1 && balanced.1 >= misses.1, "{indices:?} {balanced:?} {misses:?}");
}

#[test]
fn joining_by_degenerate_triangles_keeps_the_order() {
    let mesh = grid(40, 40);
    let strips = strips(&mesh, &options(Objective::Misses, VertexCache::default()));
    let mut joined = Strips::default();
    joined.push(&strips.to_degenerate());
    let misses =
        |strips: &Strips| VertexCacheStatistics::of(strips, VertexCache::default(), FlushPolicy::Keep).misses;
    assert!(misses(&joined) <= misses(&strips) + strips.len() / 8);
    assert!(verify(&mesh, &joined).is_ok());
}

#[test]
fn a_stopped_search_returns_its_start() {
    struct StopAtOnce;
    impl Watch for StopAtOnce {
        fn go_on(&self, _: Progress) -> bool {
            false
        }
    }
    let mesh = grid(20, 20);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let most = options(Objective::Balanced, VertexCache::default()).with_effort(Effort::MAX);
    let stopped = super::plan(&prepared, &graph, &most, &StopAtOnce).strips();
    let least = strips(
        &mesh,
        &options(Objective::Balanced, VertexCache::default()).with_effort(Effort::new(0).unwrap()),
    );
    assert_eq!(stopped, least);
}

#[test]
fn an_empty_mesh_has_no_strips() {
    let mesh = Mesh::new(vec![], Faces::from_triangles(vec![]).unwrap()).unwrap();
    for objective in OBJECTIVES {
        assert!(strips(&mesh, &options(objective, VertexCache::fifo(1))).is_empty());
    }
}
