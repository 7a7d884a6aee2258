//! Tests of the local and global algorithms over whole meshes.

use super::local::{LocalStripper, StripRules};
use super::polygon_triangulator::{PolygonTriangulator, StripFace, StripSink, brute_force_swaps};
use super::remaining_faces::RemainingFaces;
use super::turn_sequence::TurnDiagonals;
use crate::dual::DualGraph;
use crate::mesh::{Faces, Mesh};
use crate::prepare::PreparedFaces;
use crate::strip::{Metrics, Strips};
use crate::stripify::{FaceTriangulation, LastTie, Method, Patches, StripPlan, StripifyOptions, Ties, plan};
use crate::verify::verify;
use proptest::prelude::*;

const TRIANGULATIONS: [FaceTriangulation; 4] = FaceTriangulation::ALL;
const TIES: [Ties; 6] = Ties::ALL;

fn methods() -> Vec<Method> {
    let local = TRIANGULATIONS
        .into_iter()
        .flat_map(|triangulation| TIES.map(|ties| Method::StripeLocal { triangulation, ties }));
    let global = [Patches::Rows, Patches::Full]
        .into_iter()
        .flat_map(|patches| [1, 5, 25].map(|cutoff| (patches, cutoff)))
        .flat_map(|(patches, cutoff)| TIES.map(|ties| Method::StripeGlobal { patches, cutoff, ties }));
    let rows = [1, 5, 25].map(|cutoff| Method::QuadRows { cutoff });
    let sgi = LastTie::ALL.map(|last_tie| Method::Sgi { last_tie });
    sgi.into_iter().chain(rows).chain(local).chain(global).collect()
}

/// Builds strips and proves them.
fn strips(mesh: &Mesh, method: Method, seed: u64) -> Strips {
    let prepared = PreparedFaces::new(mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let options = StripifyOptions::default().with_method(method).with_seed(seed);
    let plan = plan(&prepared, &graph, &options).unwrap();
    assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()), "{method:?}");
    let strips = plan.strips();
    assert_eq!(strips.len(), plan.cover.path_count());
    if let Err(error) = verify(mesh, &strips) {
        panic!("{method:?}: {error}");
    }
    strips
}

/// Builds a mesh with all vertices at the origin, where every polygon without a repeated corner is
/// convex.
fn mesh(polygons: &[Vec<u32>]) -> Mesh {
    let count = polygons.iter().flatten().max().map_or(0, |&v| v as usize + 1);
    Mesh::new(vec![[0.0; 3]; count], Faces::from_polygons(polygons).unwrap()).unwrap()
}

fn grid(width: u32, height: u32) -> Vec<Vec<u32>> {
    let v = |x: u32, y: u32| y * (width + 1) + x;
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| vec![v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)])
        .collect()
}

fn cube() -> Mesh {
    mesh(&[[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]].map(Vec::from))
}

#[test]
fn a_quadrilateral_in_a_row_costs_two_vertices() {
    for (width, height, rows) in [(5, 1, 1), (7, 4, 4), (3, 9, 3), (6, 6, 6)] {
        let strips = strips(&mesh(&grid(width, height)), Method::STRIPE, 0);
        let m = Metrics::of(&strips);
        assert_eq!((m.strips, m.swaps), (rows, 0), "{width} x {height}");
        assert_eq!(m.vertices_sent, 2 * (width * height) as usize + 2 * rows);
    }
}

#[test]
fn a_full_patch_costs_three_swaps_per_row_change() {
    // One vertex more if neither end of the strip matches its winding.
    for (width, height, repeat) in [(5, 1, 0), (7, 4, 0), (6, 6, 0), (20, 3, 1)] {
        let full = Method::StripeGlobal { patches: Patches::Full, cutoff: 5, ties: Ties::Sequential };
        let m = Metrics::of(&strips(&mesh(&grid(width, height)), full, 0));
        assert_eq!((m.strips, m.swaps), (1, 3 * (height as usize - 1) + repeat), "{width} x {height}");
    }
}

/// Section 3.2: strips along rows have only the faces of their rows. The strip of a full patch
/// grows backward and forward.
#[test]
fn rows_do_not_grow_and_full_patches_do() {
    // A grid of six by two, and a triangle at each end of its rows.
    let mut polygons = grid(6, 2);
    polygons.extend([[0, 7, 30], [7, 14, 31], [13, 6, 32], [20, 13, 33]].map(Vec::from));
    let metrics = |patches| {
        let method = Method::StripeGlobal { patches, cutoff: 5, ties: Ties::Sequential };
        let m = Metrics::of(&strips(&mesh(&polygons), method, 0));
        (m.strips, m.isolated)
    };
    assert_eq!(metrics(Patches::Rows), (6, 4), "two rows and four triangles");
    assert_eq!(metrics(Patches::Full), (3, 2), "the strip takes the triangles at its ends");
    let grown = Metrics::of(&strips(&mesh(&polygons), Method::QUAD_ROWS, 0));
    assert_eq!((grown.strips, grown.isolated), (2, 0), "our rows grow");
}

#[test]
fn the_cutoff_is_the_size_of_the_smallest_patch() {
    // A grid of twelve and a triangle.
    let mut polygons = grid(4, 3);
    polygons.push(vec![18, 17, 20]);
    let rows = |cutoff| {
        let method = Method::StripeGlobal { patches: Patches::Rows, cutoff, ties: Ties::Sequential };
        strips(&mesh(&polygons), method, 0).len()
    };
    assert!(rows(12) > rows(13), "three rows where the grid is a patch: {} and {}", rows(12), rows(13));
    let small = mesh(&grid(2, 2));
    let prepared = PreparedFaces::new(&small, false);
    let graph = DualGraph::new(prepared.faces());
    let none = Method::StripeGlobal { patches: Patches::Rows, cutoff: 0, ties: Ties::Sequential };
    for method in [none, Method::QuadRows { cutoff: 0 }] {
        assert!(plan(&prepared, &graph, &StripifyOptions::default().with_method(method)).is_err());
    }
}

#[test]
fn a_cube_is_one_strip_when_its_diagonals_are_free() {
    for ties in TIES {
        let whole = Method::StripeLocal { triangulation: FaceTriangulation::Whole, ties };
        assert_eq!(strips(&cube(), whole, 0).len(), 1, "{ties:?}");
    }
}

/// Evans et al. 1996, section 3.1: partial triangulation gives a sequential strip of the cube,
/// which a triangulation in advance may not have. The exits without a swap are chosen at random, so
/// not every seed finds it.
#[test]
fn a_cube_is_one_sequential_strip_by_partial_faces() {
    let found = |triangulation| {
        let method = Method::StripeLocal { triangulation, ties: Ties::Sequential };
        let sequential = |seed| {
            let m = Metrics::of(&strips(&cube(), method, seed));
            (m.strips, m.swaps, m.triangles) == (1, 0, 12)
        };
        (0..32).filter(|&seed| sequential(seed)).count()
    };
    assert!(found(FaceTriangulation::Partial) > 0, "by partial faces");
    assert_eq!(found(FaceTriangulation::Static), 0, "by triangles");
}

#[test]
fn a_polygon_is_cut_for_the_path_through_it() {
    // Quadrilaterals on opposite sides of an octagon: the five faces are one strip without a swap.
    let octagon = vec![10, 11, 12, 13, 14, 15, 16, 17];
    let (west, east) = (vec![15, 14, 20, 21], vec![11, 10, 30, 31]);
    let further = (vec![20, 22, 23, 21], vec![31, 30, 32, 33]);
    let m = mesh(&[octagon, west, east, further.0, further.1]);
    let sequential = |triangulation| Method::StripeLocal { triangulation, ties: Ties::Sequential };
    let whole = Metrics::of(&strips(&m, sequential(FaceTriangulation::Whole), 0));
    assert_eq!((whole.strips, whole.swaps, whole.triangles), (1, 0, 14));
}

#[test]
fn triangles_and_quadrilaterals_in_a_row_are_one_strip() {
    // Between 2i and 2i + 1 on the two sides: a quadrilateral for even i, two triangles for odd i.
    let row: Vec<Vec<u32>> = (0..8)
        .flat_map(|i| {
            let [a, b, c, d] = [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1];
            if i % 2 == 0 { vec![vec![a, b, c, d]] } else { vec![vec![a, b, c], vec![a, c, d]] }
        })
        .collect();
    let m = mesh(&row);
    for triangulation in TRIANGULATIONS {
        for ties in TIES {
            let method = Method::StripeLocal { triangulation, ties };
            assert_eq!(strips(&m, method, 0).len(), 1, "{method:?}");
        }
    }
}

#[test]
fn random_ties_follow_the_seed() {
    let random = Method::StripeLocal { triangulation: FaceTriangulation::Whole, ties: Ties::Random };
    let m = mesh(&grid(12, 12));
    assert_eq!(strips(&m, random, 7), strips(&m, random, 7));
    assert!((1..9).any(|seed| strips(&m, random, seed) != strips(&m, random, 0)));
}

/// Checks the remaining faces at the end of every strip, and counts the swaps that the strips
/// should cost, by brute force over the turns.
struct CheckingSink<'a> {
    triangulator: PolygonTriangulator<'a>,
    swaps: usize,
}

impl StripSink for CheckingSink<'_> {
    fn receive(&mut self, strip: &[StripFace], remaining: &RemainingFaces<'_>) {
        assert_eq!(remaining.check(), Ok(()));
        if !remaining.is_partial() {
            self.swaps += brute_force_swaps(strip, remaining);
        }
        self.triangulator.receive(strip, remaining);
    }
}

/// Plans strips of whole or partial faces with checks. Returns the plan and the swaps that the
/// strips should cost.
fn checked_plan<'a>(
    prepared: &'a PreparedFaces<'_>,
    graph: &'a DualGraph,
    partial: bool,
    rules: StripRules,
) -> (StripPlan<'a>, usize) {
    let triangulator = PolygonTriangulator::new(prepared.faces(), graph, rules.diagonals);
    let mut sink = CheckingSink { triangulator, swaps: 0 };
    let remaining = RemainingFaces::new(graph, partial, rules.starts);
    LocalStripper::new(remaining, rules, 3).strip_all(&mut sink);
    (sink.triangulator.finish(), sink.swaps)
}

/// Generates quadrilaterals, triangles and larger faces: a grid with some faces merged, cut,
/// doubled, reversed or missing.
fn any_polygons() -> impl Strategy<Value = Vec<Vec<u32>>> {
    (1..7_u32, 1..7_u32, prop::collection::vec(0..12_u8, 36)).prop_map(|(width, height, changes)| {
        let mut polygons: Vec<Vec<u32>> = Vec::new();
        for (i, quad) in grid(width, height).into_iter().enumerate() {
            let previous = polygons.last().filter(|p| p.len() % 2 == 0 && p[p.len() / 2] == quad[3]).cloned();
            match (changes[i], previous) {
                (0, _) => {}
                (1, _) => polygons.extend([vec![quad[0], quad[1], quad[2]], vec![quad[0], quad[2], quad[3]]]),
                (2, _) => polygons.extend([quad.clone(), quad]),
                (3, _) => polygons.push(quad.into_iter().rev().collect()),
                (4, _) => polygons.push(vec![quad[0], quad[1], quad[2]]),
                _ => polygons.push(quad),
            }
        }
        // Merge a quadrilateral with the previous faces of its row, depending on the changes.
        let mut merged: Vec<Vec<u32>> = Vec::new();
        for (i, quad) in polygons.into_iter().enumerate() {
            match merged.last_mut() {
                Some(last) if changes[i % 36] > 8 && quad.len() == 4 && last.len() % 2 == 0 => {
                    let half = last.len() / 2;
                    let joins =
                        last[half - 1] == quad[0] && last[half] == quad[3] && !last.contains(&quad[1]);
                    if joins && !last.contains(&quad[2]) {
                        last.splice(half..half, [quad[1], quad[2]]);
                    } else {
                        merged.push(quad);
                    }
                }
                _ => merged.push(quad),
            }
        }
        merged
    })
}

/// Generates polygons of any corners over so few vertices that edges meet often.
fn soup() -> impl Strategy<Value = Vec<Vec<u32>>> {
    prop::collection::vec(prop::collection::vec(0..9_u32, 3..8), 1..30)
}

proptest! {
    #[test]
    fn every_variant_covers_every_mesh(polygons in prop_oneof![any_polygons(), soup()], seed in any::<u64>()) {
        let mesh = mesh(&polygons);
        for method in methods() {
            let once = strips(&mesh, method, seed);
            prop_assert_eq!(&once, &strips(&mesh, method, seed), "{:?}", method);
        }
    }

    #[test]
    fn triangles_alone_are_covered(triangles in prop::collection::vec([0..12_u32, 0..12, 0..12], 1..60)) {
        let mesh = mesh(&triangles.into_iter().map(Vec::from).collect::<Vec<_>>());
        for method in methods() {
            strips(&mesh, method, 1);
        }
    }

    #[test]
    fn remaining_faces_stay_valid(
        polygons in prop_oneof![any_polygons(), soup()], partial in any::<bool>(), absorbs in any::<bool>(), ties in 0..6_usize,
    ) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        let rules = StripRules { absorbs_rests: absorbs, ..StripRules::PUBLISHED.with_ties(TIES[ties]) };
        let (plan, _) = checked_plan(&prepared, &graph, partial, rules);
        prop_assert_eq!(plan.cover.check(plan.triangulation.graph()), Ok(()));
    }

    #[test]
    fn strips_have_the_fewest_swaps_that_their_faces_allow(polygons in any_polygons(), ties in 0..6_usize) {
        let mesh = mesh(&polygons);
        let prepared = PreparedFaces::new(&mesh, false);
        let graph = DualGraph::new(prepared.faces());
        // Diagonals that are chosen together have the fewest swaps. Those of a passing strip cannot
        // have fewer.
        let together = StripRules { diagonals: TurnDiagonals::Together, ..StripRules::PUBLISHED.with_ties(TIES[ties]) };
        let (plan, swaps) = checked_plan(&prepared, &graph, false, together);
        prop_assert_eq!(Metrics::of(&plan.strips()).swaps, swaps);
        let (plan, swaps) = checked_plan(&prepared, &graph, false, StripRules::PUBLISHED.with_ties(TIES[ties]));
        prop_assert!(Metrics::of(&plan.strips()).swaps >= swaps);
    }
}
