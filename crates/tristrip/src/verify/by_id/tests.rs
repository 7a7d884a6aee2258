//! Proofs of triangles, polygons and welded strips, and the cost of polygon lookups.

use super::*;
use crate::mesh::VertexWelds;
use proptest::prelude::*;
use std::cell::Cell;

thread_local! {
    /// Number of polygons that lookups have examined.
    pub(super) static LOOKUPS: Cell<usize> = const { Cell::new(0) };
}

fn quads() -> Faces {
    Faces::from_polygons([vec![0, 1, 2, 3], vec![3, 2, 4], vec![2, 1, 5, 6, 7]]).unwrap()
}

#[test]
fn accepts_every_triangulation_and_nothing_else() {
    let good = [[0, 1, 3], [1, 2, 3], [4, 3, 2], [1, 5, 2], [5, 7, 2], [7, 5, 6]];
    assert_eq!(verify_drawing(&quads(), &good), Ok(Proof { faces: 3, triangles: 6 }));
    let changed = |i: usize, t: [u32; 3]| {
        let mut all = good;
        all[i] = t;
        verify_drawing(&quads(), &all).unwrap_err()
    };
    assert!(matches!(changed(0, [0, 1, 2]), Unproven::Boundary { face: 0, .. }), "overlaps");
    assert!(matches!(changed(0, [1, 0, 3]), Unproven::Boundary { face: 0, .. }), "flipped");
    assert!(matches!(changed(2, [4, 3, 1]), Unproven::Outside { triangle: [1, 4, 3] }));
    assert!(matches!(changed(2, [0, 1, 3]), Unproven::Count { .. }), "missing and doubled");
    assert!(matches!(changed(2, [3, 4, 2]), Unproven::Boundary { face: 1, .. }), "flipped");
}

/// A square with a square hole, as one polygon with a bridge. A triangle and its reverse cancel,
/// but exceed the number of triangles.
#[test]
fn a_polygon_with_a_bridge_has_no_more_triangles_than_its_corners_allow() {
    let faces = Faces::from_polygons([[0, 1, 2, 3, 0, 4, 7, 6, 5, 4]]).unwrap();
    let ring = [[0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]];
    assert_eq!(verify_drawing(&faces, &ring), Ok(Proof { faces: 1, triangles: 8 }));
    let covered = [&ring[..], &[[4, 5, 6], [4, 6, 5]]].concat();
    assert_eq!(
        verify_drawing(&faces, &covered),
        Err(Unproven::Count { face: 0, found: 10, expected: 8 }),
        "the hole is covered"
    );
}

#[test]
fn doubled_polygons_share_a_group() {
    let faces = Faces::from_polygons([[0, 1, 2, 3], [0, 1, 2, 3], [3, 2, 1, 0]]).unwrap();
    let drawn = [[0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3], [3, 2, 1], [3, 1, 0]];
    assert!(verify_drawing(&faces, &drawn).is_ok());
    assert!(verify_drawing(&faces, &drawn[..5]).is_err());
}

#[test]
fn many_polygons_over_the_same_corners_take_linear_time() {
    let count = 60_000;
    let faces = Faces::from_polygons(vec![[0, 1, 2, 3]; count]).unwrap();
    let drawn = [[0, 1, 2], [0, 2, 3]].repeat(count);
    LOOKUPS.set(0);
    assert!(verify_drawing(&faces, &drawn).is_ok());
    assert!(verify_drawing(&faces, &drawn[1..]).is_err());
    // Each proof examines all polygons once per distinct triangle, and there are two.
    assert!(LOOKUPS.get() <= 2 * 2 * (count + 1), "{}", LOOKUPS.get());
}

#[test]
fn many_polygons_over_almost_the_same_corners_take_linear_time() {
    // Polygons of 255 common corners, which start at different ones, and one corner of their own.
    // Each is cut from its own corner.
    let polygon = |i: u32, size: u32| {
        let common = (0..size - 1).map(move |k| (k + 7 * i) % (size - 1));
        common.chain([size + i]).collect::<Vec<_>>()
    };
    for (count, size) in [(250, 256), (1000, 256), (4000, 16)] {
        let polygons: Vec<Vec<u32>> = (0..count).map(|i| polygon(i, size)).collect();
        let faces = Faces::from_polygons(&polygons).unwrap();
        let fans = |middle: usize| {
            let cut = move |p: &Vec<u32>| {
                let (n, p) = (p.len(), p.clone());
                (1..n - 1).map(move |i| [p[middle], p[(middle + i) % n], p[(middle + i + 1) % n]])
            };
            polygons.iter().flat_map(cut).collect::<Vec<_>>()
        };
        for drawn in [fans(0), fans(size as usize / 2), fans(size as usize - 1)] {
            LOOKUPS.set(0);
            assert!(verify_drawing(&faces, &drawn).is_ok());
            assert!(LOOKUPS.get() <= 4 * faces.corner_count(), "{} {count} {size}", LOOKUPS.get());
            assert!(verify_drawing(&faces, &drawn[1..]).is_err());
        }
    }
}

/// Computes the groups by their definition: polygons that have all vertices of a triangle are
/// united.
fn naive_groups(polygons: &SimplePolygons, drawn: &[[u32; 3]]) -> Option<Vec<u32>> {
    let mut sets = UnionFind::new(polygons.count());
    for triangle in drawn {
        let mut with_all = (0..).zip(polygons.iter()).filter(|(_, p)| triangle.iter().all(|v| p.contains(v)));
        let (first, _) = with_all.next()?;
        with_all.for_each(|(other, _)| sets.unite(first, other));
    }
    Some((0..polygons.count() as u32).map(|polygon| sets.find(polygon)).collect())
}

proptest! {
    #[test]
    fn groups_are_those_of_the_definition(
        polygons in prop::collection::vec(prop::collection::vec(0..9_u32, 3..7), 1..12),
        picks in prop::collection::vec(any::<[prop::sample::Index; 4]>(), 0..60),
        stray in prop::option::of([0..11_u32, 0..11, 0..11]),
    ) {
        let simple = SimplePolygons::new(&Faces::from_polygons(&polygons).unwrap());
        let inside = picks.iter().map(|[p, rest @ ..]| {
            let polygon = &polygons[p.index(polygons.len())];
            [0, 1, 2].map(|i: usize| polygon[rest[i].index(polygon.len())])
        });
        let drawn = canonical_triangles(inside.chain(stray));
        let mut groups = Groups::new(&simple);
        let owners: Option<Vec<u32>> = drawn.iter().map(|&t| groups.unite_around(t)).collect();
        let expected = naive_groups(&simple, &drawn);
        prop_assert_eq!(owners.is_some(), expected.is_some());
        if let (Some(owners), Some(expected)) = (owners, expected) {
            let found: Vec<u32> = (0..simple.count() as u32).map(|p| groups.sets.find(p)).collect();
            prop_assert_eq!(found, expected);
            let all: Vec<&[u32]> = simple.iter().collect();
            let lies_in = |(owner, t): (&u32, &[u32; 3])| t.iter().all(|v| all[*owner as usize].contains(v));
            prop_assert!(owners.iter().zip(&drawn).all(lies_in));
        }
    }
}

#[test]
fn counts_triangles_with_their_winding() {
    let faces = Faces::from_triangles(vec![0, 1, 2, 2, 1, 0, 0, 1, 2, 5, 5, 6]).unwrap();
    assert!(verify_drawing(&faces, &[[1, 2, 0], [0, 1, 2], [0, 2, 1]]).is_ok());
    assert_eq!(
        verify_drawing(&faces, &[[1, 2, 0], [0, 2, 1], [0, 2, 1]]),
        Err(Unproven::Triangles { missing: 1, extra: 1, first: [0, 1, 2] })
    );
}

/// Polygons of sparse vertices are compared in memory proportional to their corners.
#[test]
fn any_vertices_are_compared() {
    let far = |polygons: Vec<Vec<u32>>| -> Vec<Vec<u32>> {
        polygons.into_iter().map(|p| p.into_iter().map(|v| u32::MAX - 7 + v).collect()).collect()
    };
    let quads = far(vec![vec![0, 1, 2, 3], vec![3, 2, 4], vec![2, 1, 5, 6, 7]]);
    let faces = Faces::from_polygons(&quads).unwrap();
    let mut triangles: Vec<[u32; 3]> = faces.fans().as_chunks().0.to_vec();
    assert!(verify_drawing(&faces, &triangles).is_ok());
    triangles.swap(0, 4);
    let first = triangles[0];
    triangles[0].swap(0, 1);
    assert!(
        matches!(verify_drawing(&faces, &triangles), Err(Unproven::Boundary { face: 2, edge: [a, b] }) if a > 9 && b > 9)
    );
    triangles[0] = [first[0], first[1], 3];
    let outside = verify_drawing(&faces, &triangles).unwrap_err();
    assert!(matches!(outside, Unproven::Outside { triangle } if triangle.contains(&3)), "{outside}");
    let triangles = [[u32::MAX, 0, 7]];
    assert!(verify_drawing(&Faces::from_triangles(vec![0, 7, u32::MAX]).unwrap(), &triangles).is_ok());
    assert!(verify_drawing(&Faces::default(), &triangles).is_err());
}

/// Four triangles without common vertices become one strip after welding.
#[test]
fn welded_strips_are_proven_against_their_mesh() {
    use crate::{StripifyOptions, strip::VertexOrder, stripify};
    let corners =
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 2.0, 0.0]];
    let list = [0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5];
    let positions: Vec<[f32; 3]> = list.iter().map(|&v: &usize| corners[v]).collect();
    let mesh = Mesh::new(positions.clone(), Faces::from_triangles((0..12).collect()).unwrap()).unwrap();
    let polygons =
        Mesh::new(positions, Faces::from_polygons([vec![0, 1, 5, 3], vec![6, 7, 11, 8]]).unwrap()).unwrap();
    let weld = StripifyOptions::default().with_weld(true);
    for mesh in [&mesh, &polygons] {
        let strips = stripify(mesh, &weld).unwrap();
        assert_eq!(strips.len(), 1);
        assert!(verify(mesh, &strips).is_ok());
        // Without the welds, or with those of another mesh, the proof fails.
        assert!(verify(mesh, &strips.clone().with_welds(VertexWelds::default())).is_err());
        let mut moved = mesh.positions().to_vec();
        let (vertex, other) = strips.welds().iter().next().unwrap();
        moved[vertex as usize][0] += 1.0;
        let moved = Mesh::new(moved, mesh.faces().clone()).unwrap();
        assert_eq!(verify(&moved, &strips), Err(Unproven::Weld { vertex, other }));
        assert!(matches!(verify(&Mesh::default(), &strips), Err(Unproven::Weld { .. })));
        // A missing triangle is found, and the welds follow a renumbering.
        let mut more = strips.clone();
        more.push(&[0, 1, 2]);
        assert!(verify(mesh, &more).is_err());
        let order = VertexOrder::of_strips(mesh.vertex_count(), [&strips]).unwrap();
        assert!(verify(&order.mesh(mesh).unwrap(), &order.strips(&strips).unwrap()).is_ok());
    }
}

#[test]
fn one_missing_triangle_is_not_reported_in_the_plural() {
    let faces = Faces::from_triangles(vec![0, 1, 2, 2, 1, 3]).unwrap();
    let message = verify_drawing(&faces, &[[0, 1, 2]]).unwrap_err().to_string();
    assert_eq!(message, "triangles missing: 1, extra or flipped: 0; the first is [1, 3, 2]");
    let square = Faces::from_polygons([[0, 1, 2, 3]]).unwrap();
    let message = verify_drawing(&square, &[[0, 1, 2]]).unwrap_err().to_string();
    assert_eq!(message, "face 0: triangles found: 1, expected: 2");
}
