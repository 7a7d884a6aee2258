//! Collapses from the queue, compared with a search over all pairs in every step, with costs from
//! lists of planes; and an example computed by hand.

use std::collections::{BTreeMap, HashMap};

use proptest::prelude::*;

use super::*;
use crate::mesh::{Faces, Mesh, triangles_of};
use crate::simplify::tests::grid;
use crate::simplify::{Price, SimplifyOptions, SurfaceSimplifier, simplify_triangles};
use crate::vector::{Point, cross, dot, normal_of, sub};

/// A plane: its unit normal, a point on it and its weight.
type Plane = (Point, Point, f64);

fn options() -> SimplifyOptions {
    SimplifyOptions::default().with_price(Price::Quadric)
}

/// Returns the planes of each point of the full mesh.
fn planes(decimation: &Decimation) -> Vec<Vec<Plane>> {
    let surface = &decimation.surface;
    let at = |p: u32| surface.positions[p as usize];
    let mut planes = vec![Vec::new(); surface.positions.len()];
    let mut triangles_at: HashMap<[u32; 2], usize> = HashMap::new();
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    for side in surface.topology.triangles.iter().flat_map(|&triangle| sides(triangle)) {
        *triangles_at.entry([side[0].min(side[1]), side[0].max(side[1])]).or_default() += 1;
    }
    for &triangle in &surface.topology.triangles {
        let normal = normal_of(triangle.map(at));
        let length = dot(normal, normal).sqrt();
        if length == 0.0 {
            continue;
        }
        let normal = normal.map(|x| x / length);
        triangle.iter().for_each(|&p| planes[p as usize].push((normal, at(triangle[0]), 1.0)));
        for [a, b] in sides(triangle) {
            if triangles_at[&[a.min(b), a.max(b)]] == 1 {
                let across = cross(sub(at(b), at(a)), normal);
                let length = dot(across, across).sqrt();
                let plane = (across.map(|x| x / length), at(a), 1000.0);
                [a, b].iter().for_each(|&p| planes[p as usize].push(plane));
            }
        }
    }
    planes
}

/// Returns the sum of the weighted squared distances of a point from planes.
fn sum<'a>(planes: impl Iterator<Item = &'a Plane>, at: Point) -> f64 {
    let square = |&(normal, through, weight): &Plane| {
        let distance = dot(normal, sub(at, through));
        weight * distance * distance
    };
    planes.map(square).sum()
}

fn decimation(positions: &[[f32; 3]], triangles: &[u32]) -> Decimation {
    let bits = |v: u32| v.to_le_bytes().to_vec();
    Decimation::new(positions, bits, triangles, |_, _| None, &options(), &[])
}

/// Returns the costs of all allowed collapses.
fn allowed(decimation: &mut Decimation, planes: &[Vec<Plane>]) -> BTreeMap<[u32; 2], f64> {
    let (mut found, mut neighbours) = (BTreeMap::new(), Vec::new());
    for point in 0..planes.len() as u32 {
        decimation.surface.topology.neighbours(point, &mut neighbours);
        for &to in &neighbours {
            let both = planes[point as usize].iter().chain(&planes[to as usize]);
            let cost = sum(both, decimation.surface.positions[to as usize]);
            if decimation.error_if_allowed(cost, point, to).is_some() {
                found.insert([point, to], cost);
            }
        }
    }
    found
}

/// Simplifies as far as possible, and checks each collapse against a search over all pairs. Returns
/// the number of collapses.
fn check_against_all_pairs(positions: &[[f32; 3]], triangles: &[u32]) -> usize {
    let mesh = Mesh::new(positions.to_vec(), Faces::from_triangles(triangles.to_vec()).unwrap()).unwrap();
    let done = simplify_triangles(&mesh, triangles.to_vec(), &options()).unwrap();
    done.sequence.check().unwrap();
    let mut naive = decimation(positions, triangles);
    let mut planes = planes(&naive);
    let count = naive.surface.topology.point_count() as u32;
    let points: HashMap<u32, u32> = (0..count).map(|p| (naive.surface.topology.vertex_of(p), p)).collect();
    let mut again = CollapseSequence::new(positions.len(), triangles.to_vec()).unwrap();
    for collapse in done.sequence.iter() {
        let [point, to] = [collapse.renames[0].removed, collapse.renames[0].kept].map(|v| points[&v]);
        let all = allowed(&mut naive, &planes);
        let cost = *all.get(&[point, to]).expect("the collapse is allowed");
        let (&cheapest, &least) = all.iter().min_by(|a, b| a.1.total_cmp(b.1)).unwrap();
        let rounding = 1e-9 * least + 1e-12;
        assert!(cost <= least + rounding, "{point} to {to} costs {cost}, {cheapest:?} {least}");
        // If rounding cannot swap two costs, the collapse taken has the smaller one.
        let is_clear = all.iter().all(|(&pair, &other)| pair == cheapest || other > least + rounding);
        assert!(!is_clear || cheapest == [point, to]);
        let error = f64::from(collapse.error) / naive.surface.unit;
        assert!((error * error - cost).abs() <= 1e-5 * cost + 1e-9, "{error} {cost}");

        naive.error_if_allowed(cost, point, to);
        naive.surface.topology.neighbours(point, &mut naive.around);
        naive.apply(point, &PricedCollapse { to, cost: finite(cost), error: finite(error) }, &mut again);
        let moved = std::mem::take(&mut planes[point as usize]);
        planes[to as usize].extend(moved);
    }
    assert!(allowed(&mut naive, &planes).is_empty(), "a collapse is left");
    assert_eq!(again.drawn(0).unwrap(), done.sequence.drawn(0).unwrap());
    done.sequence.len()
}

#[test]
fn each_collapse_is_the_cheapest_of_all_pairs() {
    for closed in [[false, false], [true, false], [true, true]] {
        let (positions, triangles) = grid(7, 6, closed);
        assert!(check_against_all_pairs(&positions, &triangles) > 25);
    }
    // Three sheets that share a line.
    let (mut positions, mut triangles) = grid(5, 4, [false, false]);
    let first = positions.len() as u32;
    positions.extend((0..5).map(|y| [2.0, y as f32, 3.0]));
    for y in 0..4 {
        let [a, b, c, d] = [6 * y + 2, 6 * y + 8, first + y, first + y + 1];
        triangles.extend([a, b, c, c, b, d]);
    }
    assert!(check_against_all_pairs(&positions, &triangles) > 15);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 5))]

    /// With equal positions, triangles without area, edges of many triangles and arbitrary
    /// windings.
    #[test]
    fn any_triangles_are_simplified_by_the_cheapest_pair(
        positions in prop::collection::vec(prop::array::uniform3(0_u8..4), 3..16),
        corners in prop::collection::vec(any::<prop::sample::Index>(), 0..60),
    ) {
        // One vertex per position, so no seam hides which point collapses.
        let mut positions: Vec<[f32; 3]> = positions.into_iter().map(|p| p.map(f32::from)).collect();
        positions.sort_by(|a, b| a.partial_cmp(b).unwrap());
        positions.dedup();
        let whole = corners.len() / 3 * 3;
        let triangles: Vec<u32> =
            corners[..whole].iter().map(|corner| corner.index(positions.len()) as u32).collect();
        let triangles: Vec<u32> = triangles_of(&triangles).filter(|[a, b, c]| a != b && b != c && c != a).flatten().collect();
        check_against_all_pairs(&positions, &triangles);
    }
}

/// The hub is not priced again at each collapse next to it, which would take minutes.
#[test]
fn cones_and_fans_of_many_triangles_are_simplified() {
    let rim = 40_000_u32;
    // Points of a circle.
    let on_circle = |i: u32| {
        let t = (f64::from(i) - 0.5 * f64::from(rim)) / 2000.0;
        [(1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t), 0.0].map(|x| x as f32)
    };
    let positions: Vec<[f32; 3]> = std::iter::once([0.0, 0.0, 1.0]).chain((0..rim).map(on_circle)).collect();
    let mesh = Mesh::new(positions, Faces::default()).unwrap();
    let half = rim as usize / 2;
    for is_closed in [true, false] {
        let count = if is_closed { rim } else { rim - 1 };
        let corners: Vec<u32> = (0..count).flat_map(|i| [0, 1 + i, 1 + (i + 1) % rim]).collect();
        let done = simplify_triangles(&mesh, corners, &options().with_triangles(half)).unwrap();
        assert_eq!(done.sequence.triangle_count(0).unwrap(), half, "{is_closed}");
    }
}

/// Four triangles with slopes of 1 around the apex 4 of a pyramid without a bottom:
/// ```text
///    3 ─────── 2
///    │ ╲     ╱ │
///    │    4    │
///    │ ╱     ╲ │
///    0 ─────── 1
/// ```
/// The apex collapses to a corner, say 0. The planes of the two triangles at 0 pass through it;
/// those of the other two, such as z = 2 - x, are √2 away from it. Cost: 2 · 2. Corner 0 has no
/// other planes.
///
/// A corner collapses to the next one, such as 0 to 1. The plane of the triangle 3 0 4 is √2 away
/// from 1, and so is the border plane through 3 0, which is perpendicular to it. Cost: 2 + 1000 ·
/// 2.
#[test]
fn costs_of_a_pyramid_are_those_computed_by_hand() {
    let positions = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 1.0]];
    let triangles = [0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4];
    let mesh = Mesh::new(positions, Faces::default()).unwrap();
    let mut surface = SurfaceSimplifier::new(vec![(&mesh, &triangles)], &options()).unwrap();
    assert!(surface.simplify_to(3));
    let close = |x: f64, expected: f64| (x - expected).abs() < 1e-4 * expected;
    assert!(close(surface.cost(), 4.0), "{}", surface.cost());
    assert!(surface.simplify_to(1));
    // The planes of the apex are now at corner 0. The pairs of the other corners are the cheapest,
    // all equal except for rounding.
    assert!(close(surface.cost(), 2002.0), "{}", surface.cost());
    let sequence = surface.finish(0).unwrap().sequences.remove(0);
    let found: Vec<_> = sequence
        .iter()
        .map(|collapse| (collapse.renames[0].removed, collapse.renames[0].kept, f64::from(collapse.error)))
        .collect();
    let pairs: Vec<_> = found.iter().map(|&(removed, kept, _)| (removed, kept)).collect();
    assert_eq!(pairs[0], (4, 0));
    assert!([(1, 2), (2, 1), (2, 3), (3, 2)].contains(&pairs[1]), "{pairs:?}");
    assert!(close(found[0].2, 2.0) && close(found[1].2, 2002.0_f64.sqrt()), "{found:?}");
}

#[test]
fn limits_and_locked_vertices_hold() {
    let (positions, triangles) = grid(9, 9, [false, false]);
    let mesh = Mesh::new(positions, Faces::default()).unwrap();
    let simplified =
        |options: SimplifyOptions| simplify_triangles(&mesh, triangles.clone(), &options).unwrap();
    let some = simplified(options().with_error(0.2));
    assert!(some.sequence.error(0).unwrap() <= 0.2 && some.stopped.is_some_and(|stopped| stopped.error > 0));
    let reached = simplified(options().with_triangles(60));
    assert!(reached.stopped.is_none() && (59..=60).contains(&reached.sequence.triangle_count(0).unwrap()));
    // The collapses to a number of triangles are a prefix of those to a smaller number.
    let further = simplified(options().with_triangles(30));
    assert!(reached.sequence.iter().eq(further.sequence.iter().take(reached.sequence.len())));
    let locked = simplified(options().with_locked(vec![true; 50]));
    assert!(locked.sequence.iter().all(|collapse| collapse.renames[0].removed >= 50));
}
