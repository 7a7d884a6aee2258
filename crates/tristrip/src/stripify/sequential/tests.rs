//! Tests of the method over whole meshes: generated ones of many kinds, and planted ones.

use proptest::prelude::*;

use super::sheet::{Polygons, Sheet};
use super::{Peeled, Peeler, STRIP, USUAL, exchange};
use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;
use crate::mesh::{Faces, Mesh};
use crate::prepare::PreparedFaces;
use crate::strip::{cover_cost, path_cost};
use crate::verify::verify;

/// A component of a generated mesh.
#[derive(Debug, Clone)]
pub(super) enum Piece {
    /// Quadrilaterals in rows, those whose bit is set left out, or cut to two triangles, by another set of bits.
    Grid { width: u32, height: u32, holes: u64, cut: u64 },
    /// Quadrilaterals closed both ways.
    Torus { around: u32, through: u32, cut: u64 },
    /// Rings of quadrilaterals between two poles.
    Sphere { around: u32, rings: u32, cut: u64 },
    /// Triangles around a vertex.
    Fan { size: u32, closed: bool },
    /// Triangles that share one edge, in turn to its two sides.
    Fins { size: u32 },
    /// Triangles over a few vertices, some of them degenerate or doubled.
    Soup { corners: Vec<[u32; 3]> },
    /// One face.
    Polygon { size: u32 },
}

impl Piece {
    fn polygons(&self) -> Vec<Vec<u32>> {
        match *self {
            Self::Grid { width, height, holes, cut } => {
                let v = |x, y| y * (width + 1) + x;
                cells(width, height, cut, holes, |x, y| [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)])
            }
            Self::Torus { around, through, cut } => {
                let v = |x, y| y % through * around + x % around;
                cells(around, through, cut, 0, |x, y| [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)])
            }
            Self::Sphere { around, rings, cut } => {
                let v = |x, y| 2 + y * around + x % around;
                let quads =
                    cells(around, rings, cut, 0, |x, y| [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)]);
                let caps = (0..around)
                    .flat_map(|x| [vec![0, v(x + 1, 0), v(x, 0)], vec![1, v(x, rings), v(x + 1, rings)]]);
                quads.into_iter().chain(caps).collect()
            }
            Self::Fan { size, closed } => {
                let rim = |i| 1 + if closed { i % size } else { i };
                (0..size).map(|i| vec![0, rim(i), rim(i + 1)]).collect()
            }
            Self::Fins { size } => {
                (0..size).map(|i| if i % 2 == 0 { vec![0, 1, 2 + i] } else { vec![1, 0, 2 + i] }).collect()
            }
            Self::Soup { ref corners } => corners.iter().map(|c| c.to_vec()).collect(),
            Self::Polygon { size } => vec![(0..size).collect()],
        }
    }
}

/// Makes the cells of a lattice; a bit for each, used again and again, says whether it is left out or cut to two triangles.
fn cells(
    width: u32,
    height: u32,
    cut: u64,
    holes: u64,
    corners: impl Fn(u32, u32) -> [u32; 4],
) -> Vec<Vec<u32>> {
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let bit = |bits: u64, i: usize| bits >> (i % 64) & 1 == 1;
    let kept = places.enumerate().filter(|&(i, _)| !bit(holes, i));
    kept.flat_map(|(i, (x, y))| {
        let [a, b, c, d] = corners(x, y);
        if bit(cut, i) { vec![vec![a, b, c], vec![a, c, d]] } else { vec![vec![a, b, c, d]] }
    })
    .collect()
}

/// Draws a piece; with `ALL_CUT` all of its faces are triangles.
fn piece(all_cut: bool) -> impl Strategy<Value = Piece> {
    let bits = move || if all_cut { Just(u64::MAX).boxed() } else { any::<u64>().boxed() };
    let holes = || prop_oneof![Just(0), any::<u64>().prop_map(|bits| bits & bits >> 7 & bits >> 13)];
    let largest = if all_cut { 3 } else { 9_u32 };
    prop_oneof![
        4 => (1..9_u32, 1..9_u32, holes(), bits())
            .prop_map(|(width, height, holes, cut)| Piece::Grid { width, height, holes, cut }),
        2 => (3..8_u32, 3..8_u32, bits()).prop_map(|(around, through, cut)| Piece::Torus { around, through, cut }),
        2 => (3..8_u32, 1..5_u32, bits()).prop_map(|(around, rings, cut)| Piece::Sphere { around, rings, cut }),
        1 => (3..12_u32, any::<bool>()).prop_map(|(size, closed)| Piece::Fan { size, closed }),
        1 => (2..6_u32).prop_map(|size| Piece::Fins { size }),
        1 => prop::collection::vec(prop::array::uniform3(0..6_u32), 1..12).prop_map(|corners| Piece::Soup { corners }),
        1 => (3..=largest).prop_map(|size| Piece::Polygon { size }),
    ]
}

/// Draws polygons of several pieces; some faces come twice, some are wound the other way, and the order may be mixed.
pub(in crate::stripify) fn polygons(
    all_cut: bool,
    pieces: std::ops::Range<usize>,
) -> impl Strategy<Value = Vec<Vec<u32>>> {
    let whole = prop::collection::vec(piece(all_cut), pieces).prop_map(|pieces| {
        let mut first = 0;
        let mut all = Vec::new();
        for piece in pieces {
            let polygons = piece.polygons();
            all.extend(polygons.iter().map(|polygon| polygon.iter().map(|v| v + first).collect::<Vec<_>>()));
            first = all.iter().flatten().max().map_or(0, |v| v + 1);
        }
        all
    });
    let changes = prop::collection::vec((any::<prop::sample::Index>(), any::<bool>()), 0..4);
    let mixed = (whole, changes).prop_map(|(mut polygons, changes)| {
        for (place, doubled) in changes {
            if !polygons.is_empty() {
                let place = place.index(polygons.len());
                if doubled {
                    polygons.push(polygons[place].clone());
                } else {
                    polygons[place].reverse();
                }
            }
        }
        polygons
    });
    let mixed = mixed.boxed();
    prop_oneof![mixed.clone(), mixed.prop_shuffle()]
}

/// Draws the dual graph of triangles in many components.
pub(in crate::stripify) fn triangle_graph() -> impl Strategy<Value = DualGraph> {
    polygons(true, 1..9)
        .prop_map(|polygons| DualGraph::new(PreparedFaces::new(&mesh(&polygons), false).faces()))
}

pub(in crate::stripify) fn mesh(polygons: &[Vec<u32>]) -> Mesh {
    let count = polygons.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    Mesh::new(vec![[0.0; 3]; count], Faces::from_polygons(polygons).unwrap()).unwrap()
}

/// Counts what a cover costs beyond one index a triangle, but for the swaps at the starts of strips.
fn cost_inside(graph: &DualGraph, cover: &PathCover) -> u64 {
    let with_starts: usize = cover
        .path_starts(graph)
        .map(|start| path_cost(graph, cover, start) + 1 - starts(graph, cover, start))
        .sum();
    (with_starts - cover.len()) as u64
}

/// Counts the swap at the start of a path, where both of its directions need one.
fn starts(graph: &DualGraph, cover: &PathCover, start: FaceId) -> usize {
    let turns: Vec<bool> = cover
        .walk(graph, start)
        .filter_map(|(_, entry, exit)| Some((exit?.0 + 3 - entry?.0) % 3 == 1))
        .collect();
    // A strip's first turn is to the previous edge; sent from the other end every turn is to the other side.
    let forward = turns.first().is_some_and(|&to_next| to_next);
    let backward = turns.last().is_some_and(|&to_next| !to_next);
    usize::from(forward && backward)
}

/// Does exchanges, and checks that they keep the cover valid and lower its cost by what they say. A tunnel between pieces that are
/// neighbours may be priced one too low, but saves a strip.
fn check_exchanges(
    graph: &DualGraph,
    cover: &mut PathCover,
    strip_of: Vec<u32>,
) -> Result<(), TestCaseError> {
    let (before, strips) = (cost_inside(graph, cover), cover.path_count());
    let saved = exchange::improve(graph, cover, strip_of, 0);
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

/// Checks peeling and exchanges on a sheet, and that settling changes no path and costs nothing. Gives the price when settled.
fn check_steps<S: Sheet>(sheet: S) -> Result<usize, TestCaseError> {
    let Peeled { mut sheet, mut cover, strip_of, cost } = Peeler::new(sheet, USUAL).peel();
    prop_assert_eq!(cover.check(sheet.graph()), Ok(()));
    let strips = strip_of.iter().max().map_or(0, |&s| s as usize + 1);
    prop_assert_eq!(strips, cover.path_count());
    let (inside, peeled) = (cost_inside(sheet.graph(), &cover), cover_cost(sheet.graph(), &cover));
    prop_assert!(inside <= cost && cost <= inside + strips as u64, "{} {}", inside, cost);

    check_exchanges(sheet.graph(), &mut cover, strip_of)?;
    let improved = cover_cost(sheet.graph(), &cover);
    // Only swaps at starts are not priced, at most one for each strip.
    prop_assert!(improved <= peeled + cover.path_count());

    let paths = cover.path_count();
    sheet.settle(&mut cover);
    prop_assert_eq!(cover.check(sheet.graph()), Ok(()));
    prop_assert_eq!(sheet.graph().check(), Ok(()));
    prop_assert_eq!(cover.path_count(), paths);
    let settled = cover_cost(sheet.graph(), &cover);
    prop_assert!(settled <= improved, "{} {}", improved, settled);

    let strip_of = cover.renumber(sheet.graph()).path;
    exchange::improve(sheet.graph(), &mut cover, strip_of, 5);
    prop_assert_eq!(cover.check(sheet.graph()), Ok(()));
    Ok(settled)
}

/// Checks the steps, and that the whole method proves right and costs no more than its usual manner.
fn check_whole(polygons: &[Vec<u32>]) -> Result<(), TestCaseError> {
    let mesh = mesh(polygons);
    let surface = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(surface.faces());
    let usual = match surface.faces().as_triangles() {
        Some(_) => check_steps(&graph)?,
        None => check_steps(Polygons::new(surface.faces(), &graph))?,
    };
    let plan = super::plan(&surface, &graph);
    prop_assert_eq!(plan.triangulation.graph().check(), Ok(()));
    prop_assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()));
    let strips = plan.strips();
    prop_assert!(verify(&mesh, &strips).is_ok(), "{:?}", verify(&mesh, &strips));
    prop_assert_eq!(
        strips.vertices_sent() + strips.len(),
        cover_cost(plan.triangulation.graph(), &plan.cover)
    );
    prop_assert!(plan.indices_restart() < usual.max(1), "{} {}", usual, plan.indices_restart());
    Ok(())
}

proptest! {
    #[test]
    fn triangles_of_any_kind_are_stripped_right(polygons in polygons(true, 1..5)) {
        check_whole(&polygons)?;
    }

    #[test]
    fn polygons_of_any_kind_are_stripped_right(polygons in polygons(false, 1..5)) {
        check_whole(&polygons)?;
    }

    #[test]
    fn exchanges_mend_any_cover(graph in triangle_graph(), tries in prop::collection::vec(any::<u32>(), 0..200)) {
        let mut cover = PathCover::isolated(graph.face_count());
        for h in tries.iter().filter_map(|t| t.checked_rem(graph.half_edge_count() as u32)) {
            cover.join(&graph, crate::HalfEdge(h));
        }
        let strip_of = cover.renumber(&graph).path;
        check_exchanges(&graph, &mut cover, strip_of)?;
    }
}

#[test]
fn a_tunnel_joins_two_strips() {
    //     0 ─── 1 ─── 2        Triangles w = 0, v = 1, a = 2, x = 3 in a row, b = 4 below v and c = 5 above a. Strips
    //      ╲ w ╱ ╲ a ╱ ╲       w, b ━ v ━ a ━ c and x: no end is beside another, but cutting v–a lets w–v and a–x be
    //       ╲ ╱ v ╲ ╱ x ╲      linked, which makes two strips.
    //        3 ─── 4 ─── 5
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
    let saved = exchange::improve(&graph, &mut cover, strip_of, 0);
    assert_eq!(cover.check(&graph), Ok(()));
    let paths = cover.renumber(&graph).path;
    assert_eq!(paths, [0, 0, 1, 1, 0, 1], "two strips: w v b, and x a c");
    assert_eq!(cost_inside(&graph, &cover), before - saved);
    assert!(saved >= 1 && saved <= u64::from(STRIP), "{saved}");
}

/// Grids of triangles with holes.
#[cfg(feature = "rayon")]
fn sheets(count: u32, side: u32) -> Vec<Vec<u32>> {
    let mut all = Vec::new();
    for i in 0..count {
        let (holes, first) = (0x0010_0400_8001 << (i % 9), i * (side + 5) * (side + 2));
        let sheet = Piece::Grid { width: side + i % 4, height: side, holes, cut: u64::MAX }.polygons();
        all.extend(sheet.into_iter().map(|polygon| polygon.iter().map(|v| v + first).collect::<Vec<_>>()));
    }
    all
}

#[cfg(feature = "rayon")]
#[test]
fn any_number_of_threads_finds_the_same_strips() {
    use crate::stripify::{Method, StripifyOptions, stripify};
    let quads = Piece::Torus { around: 40, through: 30, cut: 0x00ff_00f0_1111_2222 };
    let meshes = [
        // Large and irregular: components in parallel. Small, regular, or of polygons: manners in parallel.
        mesh(&sheets(40, 32)),
        mesh(&sheets(3, 25)),
        mesh(&Piece::Torus { around: 90, through: 60, cut: u64::MAX }.polygons()),
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
