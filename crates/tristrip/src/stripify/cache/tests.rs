//! Tests over generated meshes of many kinds: what is grown, what trials leave behind, and what a person can check by hand.

use proptest::prelude::*;

use super::border::Border;
use super::buffers::FifoTrial;
use super::polish::Sequence;
use super::{BALANCED, FEW_MISSES, Growth, Guide, Objective, Weights};
use crate::dual::DualGraph;
use crate::dual::Triangulation;
use crate::effort::Effort;
use crate::mesh::{Faces, Mesh};
use crate::prepare::PreparedFaces;
use crate::random::Random;
use crate::strip::Metrics;
use crate::strip::Strips;
use crate::stripify::generated_meshes::{mesh, polygons};
use crate::stripify::{Method, Progress, StripPlan, StripifyOptions, Watch, plan, sequential};
use crate::verify::verify;
use crate::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};

const PREFERENCES: [Objective; 3] = [Objective::Indices, Objective::Balanced, Objective::Misses];

fn options(prefer: Objective, buffer: VertexCache) -> StripifyOptions {
    StripifyOptions::default().with_method(Method::Cache).with_objective(prefer).with_vertex_cache(buffer)
}

/// A sheet of `columns` × `rows` squares, each cut in two the same way, its triangles in scattered order.
fn sheet(columns: u32, rows: u32) -> Mesh {
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

/// Strips as the border prices them: a swap's vertex sent again after the vertex before which it stands.
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
    fn every_preference_covers_every_mesh(
        polygons in polygons(false, 1..8),
        places in 0..40_u32,
        is_lru in any::<bool>(),
        effort in 0..5_u8,
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let buffer = if is_lru { VertexCache::lru(places) } else { VertexCache::fifo(places) };
        for prefer in PREFERENCES {
            let options = options(prefer, buffer).with_effort(Effort::new(effort).unwrap());
            let plan = plan(&prepared, &graph, &options).unwrap();
            prop_assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()));
            prop_assert_eq!(plan.order.as_ref().map(Vec::len), Some(plan.cover.path_count()));
            let strips = plan.strips();
            prop_assert!(verify(&mesh, &strips).is_ok());
            prop_assert_eq!(plan.indices_restart(), Metrics::of(&strips).indices_restart);
        }
    }

    #[test]
    fn the_border_pays_what_the_strips_cost_and_undoes_what_it_tried(polygons in polygons(false, 1..8), places in 3..20_u32) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let guide = sequential::plan(&prepared, &graph);
        for (growth, weights) in [(BALANCED[0], [1, 0]), (BALANCED[1], [1, 0]), (FEW_MISSES[0], [0, 1])] {
            let weights = Weights { index: weights[0], miss: weights[1] };
            let growth = Growth { weights, ..growth };
            let triangulation = &guide.triangulation;
            let buffer = VertexCache::fifo(places);
            let border = Border::new(triangulation, FifoTrial::new(places, prepared.vertex_count()), weights);
            let due = border.due();
            let cover = (growth.guide != Guide::None).then_some(&guide.cover);
            let mut grower = super::Grower::new(border, growth, cover);
            let (cover, order) = grower.run();
            let plan = StripPlan { triangulation: triangulation.clone(), cover, order: Some(order) };
            let strips = plan.strips();
            let paid = grower.border().cost() + due;
            if weights.index > 0 {
                prop_assert_eq!(paid.unsigned_abs() as usize, strips.vertices_sent() + strips.len());
            } else {
                let misses = VertexCacheStatistics::of(&priced(&strips), buffer, FlushPolicy::Keep, prepared.vertex_count()).misses;
                prop_assert_eq!(paid.unsigned_abs() as usize, misses);
            }
        }
    }
}

proptest! {
    #[test]
    fn exchanges_save_what_they_say_they_save(
        polygons in polygons(false, 1..8),
        places in 1..20_u32,
        seed in any::<u64>(),
        weights in prop::sample::select(vec![[1, 0], [0, 1], [3, 2]]),
        hottest in 0.2..9.0_f64,
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let buffer = VertexCache::fifo(places);
        let start = plan(&prepared, &graph, &options(Objective::Balanced, buffer)).unwrap();
        let order = start.order.as_ref().unwrap();
        let weights = Weights { index: weights[0], miss: weights[1] };
        let price = |plan: &StripPlan<'_>| super::price(plan, buffer, weights, prepared.vertex_count());
        let mut sequence = Sequence::new(&start.triangulation, &start.cover, order, places, weights);
        let mut reported = (0, 0);
        for run in 0..3 {
            let mut random = Random::new(seed ^ run);
            sequence.anneal(&mut random, 20_000, [hottest, 0.1], |_, strips, saved| {
                reported = (strips, saved);
                true
            });
            let (cover, order) = sequence.finish();
            let found = StripPlan { triangulation: start.triangulation.clone(), cover, order: Some(order) };
            prop_assert_eq!(found.cover.check(found.triangulation.graph()), Ok(()));
            prop_assert!(verify(&mesh, &found.strips()).is_ok());
            // What is told before the next run is what all before it saved.
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
fn a_sheet_is_drawn_row_by_row_at_few_misses() {
    let mesh = sheet(60, 60);
    let sizes = [
        (VertexCache::fifo(16), 0.60, 1.35),
        (VertexCache::fifo(32), 0.56, 1.2),
        (VertexCache::lru(16), 0.68, 1.6),
    ];
    for (buffer, most_misses, most_indices) in sizes {
        let strips = strips(&mesh, &options(Objective::Misses, buffer));
        let used = VertexCacheStatistics::of(&strips, buffer, FlushPolicy::Keep, mesh.vertex_count());
        let indices = Metrics::of(&strips).indices_restart_per_triangle();
        assert!(used.acmr() < most_misses && indices < most_indices, "{buffer}: {} {indices}", used.acmr());
    }
}

#[test]
fn preferences_trade_indices_for_misses() {
    let mesh = sheet(40, 40);
    let [indices, balanced, misses] = PREFERENCES.map(|prefer| {
        let strips = strips(&mesh, &options(prefer, VertexCache::default()));
        let used = VertexCacheStatistics::of(
            &strips,
            VertexCache::default(),
            FlushPolicy::Keep,
            mesh.vertex_count(),
        );
        (Metrics::of(&strips).indices_restart, used.misses)
    });
    assert!(indices.0 < balanced.0 && balanced.0 <= misses.0, "{indices:?} {balanced:?} {misses:?}");
    assert!(indices.1 > balanced.1 && balanced.1 >= misses.1, "{indices:?} {balanced:?} {misses:?}");
}

#[test]
fn joining_by_degenerate_triangles_keeps_the_order() {
    let mesh = sheet(40, 40);
    let strips = strips(&mesh, &options(Objective::Misses, VertexCache::default()));
    let mut joined = Strips::default();
    joined.push(&strips.to_degenerate());
    let misses = |strips: &Strips| {
        VertexCacheStatistics::of(strips, VertexCache::default(), FlushPolicy::Keep, mesh.vertex_count())
            .misses
    };
    assert!(misses(&joined) <= misses(&strips) + strips.len() / 8);
    assert!(verify(&mesh, &joined).is_ok());
}

#[test]
fn a_watcher_ends_the_search_with_what_there_is() {
    struct Never;
    impl Watch for Never {
        fn go_on(&self, _: Progress) -> bool {
            false
        }
    }
    let mesh = sheet(20, 20);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let most = options(Objective::Balanced, VertexCache::default()).with_effort(Effort::MAX);
    let stopped = super::plan(&prepared, &graph, &most, &Never).strips();
    let least = strips(
        &mesh,
        &options(Objective::Balanced, VertexCache::default()).with_effort(Effort::new(0).unwrap()),
    );
    assert_eq!(stopped, least);
}

#[test]
fn nothing_makes_no_strip() {
    let mesh = Mesh::new(vec![], Faces::from_triangles(vec![]).unwrap()).unwrap();
    for prefer in PREFERENCES {
        assert!(strips(&mesh, &options(prefer, VertexCache::fifo(1))).is_empty());
    }
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    assert!(Triangulation::of_triangles(&prepared, &graph).is_some());
}
