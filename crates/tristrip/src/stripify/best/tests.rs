//! Tests on generated meshes of many kinds: prices are compared with those of whole paths, and the
//! method with its starts.

use proptest::prelude::*;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering::Relaxed};

use super::{Annealer, AnnealingPhase, is_lowest_possible, price};
use crate::cover::PathCover;
use crate::cover::local_search::LocalSearch;
use crate::cover::moves::{cut, flip_diagonal, move_end};
use crate::cover::priced::{PricedPaths, StripPrices};
use crate::dual::{DualGraph, Triangulation};
use crate::effort::Effort;
use crate::ids::HalfEdge;
use crate::mesh::Faces;
use crate::prepare::PreparedFaces;
use crate::random::Random;
use crate::strip::{Cost, Metrics, cover_cost};
use crate::stripify::generated_meshes::{mesh, polygons};
use crate::stripify::{Method, Progress, StripPlan, StripifyOptions, Watch, plan, sequential};
use crate::verify::verify;

const COSTS: [Cost; 4] = [Cost::Restart, Cost::OpenGl, Cost::Degenerate, Cost::Gl];

/// Computes the cost of paths in addition to one index per triangle, from the cost of every whole
/// path.
fn naive_cost(triangulation: &Triangulation<'_>, cover: &PathCover, prices: StripPrices) -> i64 {
    let strips = cover.path_count();
    let swaps = cover_cost(triangulation.graph(), cover) - cover.len() - 3 * strips;
    let times = |count: usize, price: i32| count.cast_signed() as i64 * i64::from(price);
    times(strips, prices.strip) + times(swaps, prices.swap)
}

fn to_plan<'a>(paths: &PricedPaths, start: &Triangulation<'a>) -> StripPlan<'a> {
    let (triangulation, cover) = paths.to_parts(start);
    StripPlan::new(triangulation, cover)
}

fn check_paths(
    paths: &PricedPaths,
    prepared: &PreparedFaces<'_>,
    start: &Triangulation<'_>,
) -> Result<(), TestCaseError> {
    let plan = to_plan(paths, start);
    prop_assert_eq!(plan.triangulation.graph().check(), Ok(()));
    prop_assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()));
    prop_assert_eq!(paths.cost(), naive_cost(&plan.triangulation, &plan.cover, paths.prices()));
    prop_assert_eq!(paths.strip_count(), plan.cover.path_count());
    let rebuilt = PricedPaths::new(prepared.faces(), &plan.triangulation, &plan.cover, paths.prices());
    for t in 0..paths.len() as u32 {
        prop_assert_eq!(paths.mask(t), rebuilt.mask(t));
        prop_assert_eq!([0, 1, 2].map(|e| paths.twin(4 * t + e)), [0, 1, 2].map(|e| rebuilt.twin(4 * t + e)));
        let is_end = paths.mask(t).count_ones() < 2;
        prop_assert_eq!(paths.ends_of(t as usize / 64) >> (t % 64) & 1 == 1, is_end);
        prop_assert!(!is_end || paths.partner(t) == rebuilt.partner(t));
    }
    Ok(())
}

/// Returns the cost of the swaps at the starts of all paths.
fn start_swaps(paths: &PricedPaths) -> i64 {
    let ends = (0..paths.len() as u32).filter(|&t| paths.mask(t).count_ones() < 2 && paths.partner(t) > t);
    let swaps: i32 = ends.map(|t| paths.start_swap(t, paths.partner(t))).sum();
    i64::from(swaps * paths.prices().swap)
}

/// Tries one move at a half-edge, if possible, and checks its price.
fn change(paths: &mut PricedPaths, link: u32, kind: u8) -> Result<(), TestCaseError> {
    let Some(twin) = paths.twin(link) else { return Ok(()) };
    let (before, starts_before) = (paths.cost(), start_swaps(paths));
    let ends = [link, twin].map(|h| paths.mask(h / 4).count_ones() < 2);
    if paths.mask(link / 4) >> (link % 4) & 1 == 1 {
        let inside = paths.cut_rise(link);
        let rise = paths.cut(link);
        prop_assert_eq!(i64::from(rise), paths.cost() - before);
        prop_assert_eq!(i64::from(rise - inside), start_swaps(paths) - starts_before);
        if kind == 0 {
            prop_assert_eq!(paths.join(link), Some(-rise));
        }
    } else if ends == [true, true] {
        let rise = paths.join(link);
        prop_assert_eq!(i64::from(rise.unwrap_or(0)), paths.cost() - before);
    } else if ends == [true, false] {
        let mask = paths.mask(twin / 4);
        let cut_edge = if kind.is_multiple_of(2) { mask.trailing_zeros() } else { mask.ilog2() };
        let cut = twin & !3 | cut_edge;
        if paths.across(cut) / 4 != link / 4 {
            let inside = paths.rotation_rise(link, cut);
            let rise = paths.cut(cut);
            if let Some(more) = paths.join(link) {
                prop_assert_eq!(i64::from(rise + more - inside), start_swaps(paths) - starts_before);
            } else {
                prop_assert_eq!(paths.join(cut), Some(-rise));
            }
        }
    }
    Ok(())
}

/// Stops a search at the n-th call.
struct StopAtCall {
    last_call: u64,
    calls: AtomicU64,
    last_cost: AtomicUsize,
}

impl Watch for StopAtCall {
    fn go_on(&self, progress: Progress) -> bool {
        assert!(Some(progress.steps) <= progress.step_limit && progress.strips > 0);
        self.last_cost.store(progress.cost, Relaxed);
        self.calls.fetch_add(1, Relaxed) + 1 < self.last_call
    }
}

proptest! {
    #[test]
    fn prices_of_moves_are_those_of_whole_paths(
        polygons in polygons(true, 1..5),
        changes in prop::collection::vec((any::<prop::sample::Index>(), 0..4_u8), 1..60),
        prices in (1..5, 0..2),
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        if graph.half_edge_count() == 0 {
            return Ok(());
        }
        let start = Triangulation::fan(&prepared, &graph);
        let mut cover = PathCover::isolated(graph.face_count());
        (0..graph.half_edge_count() as u32).step_by(2).for_each(|h| { cover.join(&graph, HalfEdge(h)); });
        let prices = StripPrices { strip: prices.0, swap: prices.1 };
        let mut paths = PricedPaths::new(prepared.faces(), &start, &cover, prices);
        check_paths(&paths, &prepared, &start)?;
        for (index, kind) in changes {
            let h = index.index(graph.half_edge_count()) as u32;
            change(&mut paths, h / 3 * 4 + h % 3, kind)?;
            check_paths(&paths, &prepared, &start)?;
        }
    }

    #[test]
    fn annealing_keeps_paths_valid(polygons in polygons(false, 1..5), seed in any::<u64>(), hottest in 0.2..3.0_f64) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let start = Triangulation::zigzag(&prepared, &graph);
        let prices = StripPrices { strip: 3, swap: 1 };
        let cover = PathCover::isolated(start.triangle_count());
        let mut paths = PricedPaths::new(prepared.faces(), &start, &cover, prices);
        let phase = AnnealingPhase { sweeps: 20, hottest, coldest: 0.15 };
        Annealer::new(seed, &(), &[phase], cover.len(), cover.len()).run(&mut paths, phase);
        check_paths(&paths, &prepared, &start)?;
        let plan = to_plan(&paths, &start);
        let strips = plan.strips();
        prop_assert!(verify(&mesh, &strips).is_ok(), "{:?}", verify(&mesh, &strips));
    }

    #[test]
    fn local_search_keeps_paths_valid_and_never_raises_the_cost(
        polygons in polygons(false, 1..5),
        seed in any::<u64>(),
        prices in (1..4, 0..2),
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let start = Triangulation::zigzag(&prepared, &graph);
        let prices = StripPrices { strip: prices.0, swap: prices.1 };
        let cover = PathCover::isolated(start.triangle_count());
        let mut paths = PricedPaths::new(prepared.faces(), &start, &cover, prices);
        let mut search = LocalSearch::new(seed);
        for t in (0..paths.len() as u32).chain(0..paths.len() as u32) {
            let before = paths.cost();
            search.improve_at(&mut paths, t);
            prop_assert!(paths.cost() <= before);
            check_paths(&paths, &prepared, &start)?;
        }
    }

    #[test]
    fn is_proven_and_never_worse_than_its_starts(polygons in polygons(false, 1..4), seed in any::<u64>()) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        for cost in COSTS {
            let options = StripifyOptions::default().with_cost(cost).with_seed(seed).with_effort(Effort::new(2).unwrap());
            let found = |method| {
                let plan = plan(&prepared, &graph, &options.with_method(method)).unwrap();
                plan.strips()
            };
            let best = found(Method::Best);
            prop_assert!(verify(&mesh, &best).is_ok(), "{:?}", verify(&mesh, &best));
            prop_assert!(best == found(Method::Best));
            for start in [Method::Sequential, Method::Input, Method::QUAD_ROWS] {
                let (ours, theirs) = (Metrics::of(&best), Metrics::of(&found(start)));
                prop_assert!(cost.of(&ours) <= cost.of(&theirs), "{:?} {:?}: {:?} {:?}", cost, start, ours, theirs);
            }
        }
    }
}

#[test]
fn four_flips_of_a_diagonal_restore_the_triangulation() {
    // A hexagon, quadrilaterals on two of its edges, and a triangle on an edge of one of them.
    let faces = [vec![0, 1, 2, 3, 4, 5], vec![1, 0, 6, 7], vec![4, 3, 8, 9], vec![7, 6, 10]];
    let mesh = mesh(&faces);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let start = Triangulation::zigzag(&prepared, &graph);
    let cover = PathCover::isolated(start.triangle_count());
    let mut paths = PricedPaths::new(prepared.faces(), &start, &cover, StripPrices { strip: 3, swap: 1 });
    let cut = |paths: &PricedPaths| to_plan(paths, &start).triangulation.triangles().to_vec();
    let diagonals: Vec<u32> = (0..4 * paths.len() as u32)
        .filter(|h| h % 4 < 3 && paths.diagonals(h / 4) >> (h % 4) & 1 == 1)
        .collect();
    assert_eq!(diagonals.len(), 2 * (3 + 1 + 1));
    for diagonal in diagonals {
        let before = cut(&paths);
        for flip in 1..=4 {
            paths.flip_diagonal(diagonal);
            check_paths(&paths, &prepared, &start).unwrap();
            let plan = to_plan(&paths, &start);
            assert!(verify(&mesh, &plan.strips()).is_ok());
            let joined =
                DualGraph::new(&Faces::from_triangles(plan.triangulation.triangles().to_vec()).unwrap());
            assert_eq!(plan.triangulation.graph(), &joined);
            assert_eq!(cut(&paths) == before, flip == 4);
        }
    }
}

/// Returns a torus of quadrilaterals, each cut along a random diagonal.
fn torus(side: u32) -> Vec<Vec<u32>> {
    let v = |x, y| y % side * side + x % side;
    let mut random = Random::new(1);
    let cells = (0..side * side).flat_map(|i| {
        let (x, y) = (i % side, i / side);
        let [a, b, c, d] = [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
        if random.coin() { [vec![a, b, c], vec![a, c, d]] } else { [vec![a, b, d], vec![b, c, d]] }
    });
    cells.collect()
}

#[test]
fn a_watcher_stops_the_search_and_more_effort_lowers_the_cost() {
    let mesh = mesh(&torus(40));
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let at = |last_call, level| {
        let watch =
            StopAtCall { last_call, calls: AtomicU64::new(0), last_cost: AtomicUsize::new(usize::MAX) };
        let plan = super::plan(&prepared, &graph, Cost::Restart, Effort::new(level).unwrap(), 0, &watch);
        assert_eq!(plan.cover.check(&graph), Ok(()));
        let (cost, calls) = (plan.indices_restart(), watch.calls.into_inner());
        assert!(calls < last_call || cost <= watch.last_cost.into_inner(), "costs more than its last report");
        (cost, calls)
    };
    let (stopped, calls) = at(3, 4);
    assert_eq!(calls, 3);
    let (whole, calls) = at(u64::MAX, 4);
    assert!(calls > 10, "{calls}");
    let (little, _) = at(u64::MAX, 1);
    let (none, calls) = at(u64::MAX, 0);
    assert_eq!(calls, 0);
    assert!(
        whole < little && little < none && whole < stopped && stopped <= none,
        "{whole} {little} {none} {stopped}"
    );
}

/// Returns the cover of a triangulated polygon by one path over all of its diagonals.
fn one_path(triangulation: &Triangulation<'_>) -> PathCover {
    let graph = triangulation.graph();
    let mut cover = PathCover::isolated(graph.face_count());
    (0..graph.half_edge_count() as u32).for_each(|h| _ = cover.link(graph, HalfEdge(h)));
    assert_eq!(cover.path_count(), 1);
    cover
}

#[test]
fn without_steps_a_search_cuts_only_near_the_ends() {
    let mesh = mesh(&[(0..1000).collect()]);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let start = Triangulation::zigzag(&prepared, &graph);
    let prices = StripPrices { strip: 3, swap: 1 };
    let mut paths = PricedPaths::new(prepared.faces(), &start, &one_path(&start), prices);
    let link_of = |paths: &PricedPaths, t: u32| 4 * t + paths.mask(t).trailing_zeros();
    // The triangles of the only path are in path order, 498 on each side of the middle.
    let middle = link_of(&paths, 499);
    assert_eq!(paths.try_cut(middle), None);
    paths.allow_walks(490);
    assert_eq!(paths.try_cut(middle), None);
    check_paths(&paths, &prepared, &start).unwrap();
    let near = link_of(&paths, 10);
    let rise = paths.try_cut(near).unwrap();
    assert_eq!(paths.join(near), Some(-rise));
    paths.allow_walks(600);
    assert!(paths.try_cut(middle).is_some());
    check_paths(&paths, &prepared, &start).unwrap();
}

#[test]
fn moves_that_lack_steps_leave_the_paths_as_they_were() {
    let mesh = mesh(&[(0..600).collect(), (300..900).collect()]);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let start = Triangulation::zigzag(&prepared, &graph);
    let mut cover = PathCover::isolated(start.triangle_count());
    (0..graph.half_edge_count() as u32).for_each(|h| _ = cover.join(start.graph(), HalfEdge(h)));
    let prices = StripPrices { strip: 3, swap: 1 };
    let mut paths = PricedPaths::new(prepared.faces(), &start, &cover, prices);
    let mut random = Random::new(1);
    for round in 0..4000 {
        let h = 4 * random.below(paths.len()) as u32 + random.below(3) as u32;
        let highest_rise = i32::from(random.below(5) as u8);
        if paths.diagonals(h / 4) >> (h % 4) & 1 == 1 && random.coin() {
            flip_diagonal(&mut paths, h, random.coin(), highest_rise);
        } else if paths.mask(h / 4) >> (h % 4) & 1 == 1 {
            cut(&mut paths, h, highest_rise);
        } else if paths.degree(h / 4) < 2 {
            move_end(&mut paths, h / 4, random.next_u64(), highest_rise);
        }
        if round % 100 == 0 {
            check_paths(&paths, &prepared, &start).unwrap();
        }
    }
    assert!(verify(&mesh, &to_plan(&paths, &start).strips()).is_ok());
}

#[test]
fn a_start_of_the_lowest_possible_price_is_recognized() {
    let lowest = |faces: &[Vec<u32>]| {
        let mesh = mesh(faces);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let plan = sequential::plan(&prepared, &graph);
        COSTS.map(|cost| is_lowest_possible(&plan, price(&plan, cost), cost))
    };
    assert_eq!(lowest(&[(0..50).collect()]), [true; 4]);
    let is_not_joined = COSTS.map(|cost| cost != Cost::Degenerate);
    assert_eq!(lowest(&[(0..50).collect(), (50..90).collect()]), is_not_joined);
    // Three triangles around a fourth take two strips.
    assert_eq!(lowest(&[vec![0, 1, 2], vec![1, 0, 3], vec![2, 1, 4], vec![0, 2, 5]]), [false; 4]);
}

#[test]
fn the_walks_of_a_phase_are_limited() {
    let phase = AnnealingPhase { sweeps: 3, hottest: 0.5, coldest: 0.1 };
    let steps = |count| Annealer::walk_steps(count, phase);
    assert_eq!([1000, 100_000, 1_000_000].map(steps), [4 * 64_000, 4 << 20, 4 * 4_000_000]);
}
