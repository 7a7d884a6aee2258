//! Tests of the whole method on generated and constructed meshes.

use proptest::prelude::*;

use super::greedy::{GreedyStripper, GreedyStrips};
use super::local_search;
use super::mutable_triangulation::{MutableTriangulation, PolygonTriangulation};
use super::policy::{Policy, STRIP_COST};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;
use crate::mesh::Faces;
use crate::prepare::PreparedFaces;
use crate::strip::{cover_cost, path_cost};
#[cfg(feature = "rayon")]
use crate::stripify::generated_meshes::MeshPart;
pub(in crate::stripify) use crate::stripify::generated_meshes::{mesh, polygons, triangle_graph};
use crate::verify::verify;

/// Returns the cost of a cover in addition to one index per triangle, without swaps at the starts
/// of strips.
fn cost_inside(graph: &DualGraph, cover: &PathCover) -> u64 {
    let with_starts: usize = cover
        .path_starts(graph)
        .map(|start| path_cost(graph, cover, start) + 1 - start_swap(graph, cover, start))
        .sum();
    (with_starts - cover.len()) as u64
}

/// Returns the number of swaps at the start of a path: 1 if both of its directions need one.
fn start_swap(graph: &DualGraph, cover: &PathCover, start: FaceId) -> usize {
    let turns: Vec<bool> = cover
        .walk(graph, start)
        .filter_map(|(_, entry, exit)| Some((exit?.0 + 3 - entry?.0) % 3 == 1))
        .collect();
    // The first turn of a strip is to the previous edge. From the other end every turn is to the
    // other side.
    let forward = turns.first().is_some_and(|&to_next| to_next);
    let backward = turns.last().is_some_and(|&to_next| !to_next);
    usize::from(forward && backward)
}

/// Runs the local search, and checks that it keeps the cover valid and lowers the cost by the
/// returned amount. A tunnel between two adjacent parts of a path may be priced one too low, but
/// saves a strip.
fn check_local_search(
    graph: &DualGraph,
    cover: &mut PathCover,
    strip_of: Vec<u32>,
) -> Result<(), TestCaseError> {
    let (before, strips) = (cost_inside(graph, cover), cover.path_count());
    let saved = local_search::improve(graph, cover, strip_of, 0);
    prop_assert_eq!(cover.check(graph), Ok(()));
    let (after, joined) = (cost_inside(graph, cover), strips - cover.path_count());
    prop_assert!(
        after <= before && after + saved <= before + joined as u64,
        "{} {} {}",
        before,
        after,
        saved
    );
    prop_assert!(saved > 0 || after == before);
    Ok(())
}

/// Checks greedy stripping and local search on a triangulation, and that the choice of diagonals
/// keeps the number of paths and does not raise the cost. Returns the final cost.
fn check_steps<T: MutableTriangulation>(triangulation: T) -> Result<usize, TestCaseError> {
    let strips = GreedyStripper::new(triangulation, Policy::DEFAULT).run();
    let GreedyStrips { mut triangulation, mut cover, strip_of, cost } = strips;
    prop_assert_eq!(cover.check(triangulation.graph()), Ok(()));
    let strips = strip_of.iter().max().map_or(0, |&s| s as usize + 1);
    prop_assert_eq!(strips, cover.path_count());
    let (inside, greedy) =
        (cost_inside(triangulation.graph(), &cover), cover_cost(triangulation.graph(), &cover));
    prop_assert!(inside <= cost && cost <= inside + strips as u64, "{} {}", inside, cost);

    check_local_search(triangulation.graph(), &mut cover, strip_of)?;
    let improved = cover_cost(triangulation.graph(), &cover);
    // Only swaps at starts are not priced: at most one per strip.
    prop_assert!(improved <= greedy + cover.path_count());

    let paths = cover.path_count();
    triangulation.optimize_diagonals(&mut cover);
    prop_assert_eq!(cover.check(triangulation.graph()), Ok(()));
    prop_assert_eq!(triangulation.graph().check(), Ok(()));
    prop_assert_eq!(cover.path_count(), paths);
    let optimized = cover_cost(triangulation.graph(), &cover);
    prop_assert!(optimized <= improved, "{} {}", improved, optimized);

    let strip_of = cover.renumber(triangulation.graph()).path;
    local_search::improve(triangulation.graph(), &mut cover, strip_of, 5);
    prop_assert_eq!(cover.check(triangulation.graph()), Ok(()));
    Ok(optimized)
}

/// Checks the steps, the proof of the strips of the whole method, and that they cost no more than
/// those of the default policy.
fn check_whole(polygons: &[Vec<u32>]) -> Result<(), TestCaseError> {
    let mesh = mesh(polygons);
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let default = match prepared.faces().as_triangles() {
        Some(_) => check_steps(&graph)?,
        None => check_steps(PolygonTriangulation::new(prepared.faces(), &graph))?,
    };
    let plan = super::plan(&prepared, &graph);
    prop_assert_eq!(plan.triangulation.graph().check(), Ok(()));
    prop_assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()));
    let strips = plan.strips();
    prop_assert!(verify(&mesh, &strips).is_ok(), "{:?}", verify(&mesh, &strips));
    prop_assert_eq!(
        strips.vertices_sent() + strips.len(),
        cover_cost(plan.triangulation.graph(), &plan.cover)
    );
    prop_assert!(plan.indices_restart() < default.max(1), "{} {}", default, plan.indices_restart());
    Ok(())
}

proptest! {
    #[test]
    fn strips_of_any_triangles_are_proven(polygons in polygons(true, 1..5)) {
        check_whole(&polygons)?;
    }

    #[test]
    fn strips_of_any_polygons_are_proven(polygons in polygons(false, 1..5)) {
        check_whole(&polygons)?;
    }

    #[test]
    fn local_search_improves_any_cover(graph in triangle_graph(), tries in prop::collection::vec(any::<u32>(), 0..200)) {
        let mut cover = PathCover::isolated(graph.face_count());
        for h in tries.iter().filter_map(|t| t.checked_rem(graph.half_edge_count() as u32)) {
            cover.join(&graph, crate::HalfEdge(h));
        }
        let strip_of = cover.renumber(&graph).path;
        check_local_search(&graph, &mut cover, strip_of)?;
    }
}

#[test]
fn a_tunnel_joins_two_strips() {
    //     0 ─── 1 ─── 2        Triangles w = 0, v = 1, a = 2, x = 3 in a row, b = 4 below v and
    //      ╲ w ╱ ╲ a ╱ ╲       c = 5 above a. Strips w, b ━ v ━ a ━ c and x: no two ends are
    //       ╲ ╱ v ╲ ╱ x ╲      neighbours, but after cutting v–a, w–v and a–x can be linked,
    //        3 ─── 4 ─── 5     which gives two strips.
    let faces = [[0, 3, 1], [1, 3, 4], [1, 4, 2], [2, 4, 5], [3, 6, 4], [1, 2, 7]];
    let graph = DualGraph::new(&Faces::from_triangles(faces.concat()).unwrap());
    let mut cover = PathCover::isolated(6);
    let link = |cover: &mut PathCover, from: u32, to: u32| {
        let mut arcs = graph.half_edges(FaceId(from));
        let arc = arcs.find(|&h| graph.twin(h).is_some_and(|h| graph.face_of(h).0 == to)).unwrap();
        assert!(cover.join(&graph, arc));
    };
    [(4, 1), (1, 2), (2, 5)].into_iter().for_each(|(from, to)| link(&mut cover, from, to));
    assert_eq!(cover.path_count(), 3);
    let before = cost_inside(&graph, &cover);
    let strip_of = cover.renumber(&graph).path;
    let saved = local_search::improve(&graph, &mut cover, strip_of, 0);
    assert_eq!(cover.check(&graph), Ok(()));
    let paths = cover.renumber(&graph).path;
    assert_eq!(paths, [0, 0, 1, 1, 0, 1], "two strips: w v b, and x a c");
    assert_eq!(cost_inside(&graph, &cover), before - saved);
    assert!(saved >= 1 && saved <= u64::from(STRIP_COST), "{saved}");
}

/// Returns grids of triangles with holes.
#[cfg(feature = "rayon")]
fn grids(count: u32, side: u32) -> Vec<Vec<u32>> {
    let mut all = Vec::new();
    for i in 0..count {
        let (holes, first) = (0x0010_0400_8001 << (i % 9), i * (side + 5) * (side + 2));
        let grid = MeshPart::Grid { width: side + i % 4, height: side, holes, cut: u64::MAX }.polygons();
        all.extend(grid.into_iter().map(|polygon| polygon.iter().map(|v| v + first).collect::<Vec<_>>()));
    }
    all
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_finds_the_same_strips() {
    use crate::stripify::{Method, StripifyOptions, stripify};
    let quads = MeshPart::Torus { around: 40, through: 30, cut: 0x00ff_00f0_1111_2222 };
    let meshes = [
        // Large and irregular: components in parallel. Small, regular or polygonal: policies in
        // parallel.
        mesh(&grids(40, 32)),
        mesh(&grids(3, 25)),
        mesh(&MeshPart::Torus { around: 90, through: 60, cut: u64::MAX }.polygons()),
        mesh(&quads.polygons()),
    ];
    let large = DualGraph::new(meshes[0].faces());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    assert!(pool.install(|| super::components::cover(&large)).is_some());
    for mesh in &meshes {
        let strips = [1, 2, 7].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                stripify(mesh, &StripifyOptions::default().with_method(Method::Sequential)).unwrap()
            })
        });
        assert!(verify(mesh, &strips[0]).is_ok());
        assert!(strips[0] == strips[1] && strips[0] == strips[2]);
    }
}
