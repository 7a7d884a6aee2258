//! Simplifications of meshes of every kind, held to what the collapses promise at every level.

use std::collections::{HashMap, HashSet};

use proptest::prelude::*;

use super::*;
use crate::mesh::{Attribute, AttributeData, Faces};

/// A grid of quadrilaterals cut in two, `wide` by `high`, closed around in either direction on request, with a height for each vertex.
fn grid(wide: u32, high: u32, around: [bool; 2]) -> (Vec<[f32; 3]>, Vec<u32>) {
    let columns = if around[0] { wide } else { wide + 1 };
    let rows = if around[1] { high } else { high + 1 };
    let at = |x: u32, y: u32| (y % rows) * columns + x % columns;
    let tau = std::f32::consts::TAU;
    let position = |v: u32| {
        let (x, y) = ((v % columns) as f32, (v / columns) as f32);
        let bump = ((v.wrapping_mul(2_654_435_761)) >> 24) as f32 / 2560.0;
        if around[0] {
            let (a, b) = (tau * x / wide as f32, tau * y / high as f32);
            let r = if around[1] { 3.0 + b.cos() } else { 3.0 };
            let z = if around[1] { b.sin() } else { y };
            [(r + bump) * a.cos(), (r + bump) * a.sin(), z]
        } else {
            [x, y, bump]
        }
    };
    let quads = (0..high).flat_map(move |y| (0..wide).map(move |x| (x, y)));
    let triangles = quads.flat_map(|(x, y)| {
        let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        [a, b, c, c, b, d]
    });
    ((0..columns * rows).map(position).collect(), triangles.collect())
}

fn mesh(positions: &[[f32; 3]], triangles: &[u32]) -> Mesh {
    Mesh::new(positions.to_vec(), Faces::from_triangles(triangles.to_vec()).unwrap()).unwrap()
}

fn simplified(positions: &[[f32; 3]], triangles: &[u32], options: &SimplifyOptions) -> Simplification {
    let simplification = simplify(&mesh(positions, triangles), triangles.to_vec(), options).unwrap();
    simplification.sequence.check().unwrap();
    simplification
}

/// How often each directed edge is drawn.
fn edges(triangles: &[[u32; 3]]) -> HashMap<[u32; 2], usize> {
    let mut edges = HashMap::new();
    for [a, b, c] in triangles {
        for edge in [[*a, *b], [*b, *c], [*c, *a]] {
            *edges.entry(edge).or_insert(0) += 1;
        }
    }
    edges
}

fn root_of(roots: &mut HashMap<u32, u32>, v: u32) -> u32 {
    let up = *roots.entry(v).or_insert(v);
    if up == v { v } else { root_of(roots, up) }
}

/// Vertices less edges and faces, borders and components of a manifold: what no collapse may change.
fn shape(triangles: &[[u32; 3]]) -> (i64, usize, usize) {
    let edges = edges(triangles);
    assert!(edges.values().all(|&count| count == 1), "an edge twice in one direction");
    let vertices: HashSet<u32> = triangles.iter().flatten().copied().collect();
    let undirected: HashSet<[u32; 2]> = edges.keys().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    // Components of the whole, and loops of border edges.
    let components = |edges: &mut dyn Iterator<Item = [u32; 2]>| {
        let mut root: HashMap<u32, u32> = HashMap::new();
        for [a, b] in edges {
            let (a, b) = (root_of(&mut root, a), root_of(&mut root, b));
            root.insert(a, b);
        }
        let all: Vec<u32> = root.keys().copied().collect();
        all.into_iter().filter(|&v| root_of(&mut root, v) == v).count()
    };
    let whole = components(&mut undirected.iter().copied());
    let borders = components(&mut edges.keys().copied().filter(|&[a, b]| !edges.contains_key(&[b, a])));
    let [v, e, f] =
        [vertices.len(), undirected.len(), triangles.len()].map(|count| i64::try_from(count).unwrap());
    (v - e + f, whole, borders)
}

#[test]
fn every_level_has_the_shape_of_the_full_mesh() {
    for (around, least) in [([false, false], 1), ([true, false], 6), ([true, true], 14)] {
        let (positions, triangles) = grid(9, 8, around);
        let Simplification { sequence, stopped } =
            simplified(&positions, &triangles, &SimplifyOptions::default());
        let full = shape(&sequence.drawn(sequence.len()));
        for level in 0..sequence.len() {
            let drawn = sequence.drawn(level);
            assert_eq!(shape(&drawn), full, "level {level}");
            assert_eq!(drawn.len(), sequence.triangle_count(level));
        }
        let reached = sequence.triangle_count(0);
        assert!(reached >= least && reached <= 3 * least + 8, "{reached} triangles of at least {least}");
        let stopped = stopped.unwrap();
        assert_eq!(stopped.triangle_count, reached);
        assert!(stopped.topology + stopped.fold_over > 0, "{stopped}");
    }
}

#[test]
fn the_target_is_reached_and_not_passed_by_more_than_a_collapse() {
    let (positions, triangles) = grid(12, 12, [true, true]);
    for target in [288, 287, 150, 41] {
        let options = SimplifyOptions::default().with_triangles(target);
        let simplification = simplified(&positions, &triangles, &options);
        let reached = simplification.sequence.triangle_count(0);
        assert!(reached <= target && reached + 2 > target, "{reached} of {target}");
        assert!(simplification.stopped.is_none());
    }
}

#[test]
fn a_tetrahedron_and_a_triangle_stay() {
    let positions = [
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [5.0, 0.0, 0.0],
        [6.0, 0.0, 0.0],
        [5.0, 1.0, 0.0],
    ];
    let triangles = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2, 4, 5, 6];
    let simplification = simplified(&positions, &triangles, &SimplifyOptions::default());
    assert!(simplification.sequence.is_empty());
    let stopped = simplification.stopped.unwrap();
    assert_eq!((stopped.triangle_count, stopped.topology + stopped.fold_over), (5, 7));
    assert!(
        stopped.to_string().starts_with("stopped at 5 triangles; vertices left: 6 held by the topology"),
        "{stopped}"
    );
}

#[test]
fn an_octahedron_becomes_a_tetrahedron() {
    let positions = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let triangles: Vec<u32> =
        [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]].concat();
    let simplification = simplified(&positions, &triangles, &SimplifyOptions::default());
    let drawn = simplification.sequence.drawn(0);
    assert_eq!(drawn.len(), 4, "{drawn:?}");
    assert_eq!(shape(&drawn), (2, 1, 0));
}

#[test]
fn locked_vertices_stay() {
    let (positions, triangles) = grid(6, 6, [false, false]);
    let locked: Vec<bool> = (0..49).map(|v| v % 5 == 0).collect();
    let options = SimplifyOptions::default().with_locked(locked.clone());
    let simplification = simplified(&positions, &triangles, &options);
    let left: HashSet<u32> = simplification.sequence.drawn(0).into_iter().flatten().collect();
    assert!(locked.iter().enumerate().all(|(v, &locked)| !locked || left.contains(&(v as u32))));
    assert!(left.len() < 25);
    assert_eq!(simplification.stopped.unwrap().locked, 10);
}

#[test]
fn no_collapse_exceeds_the_error_allowed() {
    let (positions, triangles) = grid(20, 10, [true, true]);
    let mut counts = Vec::new();
    for error in [0.02, 0.1, 0.2, 0.4] {
        let simplification =
            simplified(&positions, &triangles, &SimplifyOptions::default().with_error(error));
        assert!(simplification.sequence.error(0) <= error);
        assert!(simplification.stopped.unwrap().error > 0);
        counts.push(simplification.sequence.triangle_count(0));
    }
    assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
    for error in [f32::NAN, -1.0] {
        let (options, mesh) = (SimplifyOptions::default().with_error(error), mesh(&positions, &triangles));
        assert!(simplify(&mesh, triangles.clone(), &options).is_err());
    }
}

/// A cylinder cut open along one side: the vertices there stand twice, as they do where texture coordinates begin anew.
#[test]
fn a_seam_stays_closed() {
    let (mut positions, mut triangles) = grid(12, 10, [true, false]);
    let count = positions.len() as u32;
    let seam: Vec<u32> = (0..=10).map(|y| y * 12).collect();
    positions.extend(seam.iter().map(|&v| positions[v as usize]).collect::<Vec<_>>());
    for (t, triangle) in triangles.chunks_exact_mut(3).enumerate() {
        if (t / 2) % 12 == 11 {
            triangle.iter_mut().filter(|v| **v % 12 == 0).for_each(|v| *v = count + *v / 12);
        }
    }
    let plain = simplified(&positions, &triangles, &SimplifyOptions::default()).sequence;
    let sides = AttributeData::U8((0..positions.len()).map(|v| u8::from(v >= count as usize)).collect());
    let side = Attribute { name: "side".into(), components: 1, normalized: false, data: sides };
    let mesh = mesh(&positions, &triangles).with_attribute(side).unwrap();
    let Simplification { sequence, .. } = simplify(&mesh, triangles, &SimplifyOptions::default()).unwrap();
    sequence.check().unwrap();
    // Where the vertices of both sides are the same but for their number, the seam is none.
    assert!(plain.triangle_count(0) <= sequence.triangle_count(0));
    let point = |v: u32| if v >= count { (v - count) * 12 } else { v };
    assert!(sequence.iter().any(|collapse| collapse.renames.len() == 2));
    for level in 0..=sequence.len() {
        let drawn = sequence.drawn(level);
        let joined: Vec<[u32; 3]> = drawn.iter().map(|t| t.map(point)).collect();
        assert_eq!(shape(&joined), (0, 1, 2), "level {level}");
        // No triangle has a vertex of each side, and none lost an edge of the seam to another vertex.
        let torn =
            |t: &[u32; 3]| t.iter().any(|&v| v >= count) && t.iter().any(|&v| v < count && v % 12 == 0);
        assert!(!drawn.iter().any(torn), "level {level}");
    }
}

#[test]
fn where_three_faces_meet_at_an_edge_all_stays() {
    let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    let simplification = simplified(&positions, &[0, 1, 2, 1, 0, 3, 0, 1, 4], &SimplifyOptions::default());
    let left: HashSet<u32> = simplification.sequence.drawn(0).into_iter().flatten().collect();
    assert!(left.contains(&0) && left.contains(&1));
    assert_eq!(simplification.stopped.unwrap().non_manifold, 2);
}

/// A cone whose tip has more triangles than a point that goes may have: time must not go by their square.
#[test]
fn a_point_of_many_triangles_does_no_harm() {
    let n = 20_000_u32;
    let rim = |i: u32| {
        let a = std::f32::consts::TAU * i as f32 / n as f32;
        [a.cos(), a.sin(), 0.0]
    };
    let positions: Vec<[f32; 3]> = std::iter::once([0.0, 0.0, 1.0]).chain((0..n).map(rim)).collect();
    let triangles: Vec<u32> = (0..n).flat_map(|i| [0, i + 1, (i + 1) % n + 1]).collect();
    let simplification = simplified(&positions, &triangles, &SimplifyOptions::default().with_triangles(10));
    assert!(simplification.sequence.triangle_count(0) <= 10);
}

/// A plane in which triangles without area lie, as where edges of one face meet two of another: none comes to lie upside down.
#[test]
fn triangles_without_area_do_not_unfold_upside_down() {
    let n = 20_u32;
    let mut positions: Vec<[f32; 3]> =
        (0..(n + 1) * (n + 1)).map(|v| [(v % (n + 1)) as f32, (v / (n + 1)) as f32, 0.0]).collect();
    let mut triangles = Vec::new();
    for quad in 0..n * n {
        let a = quad / n * (n + 1) + quad % n;
        let [b, c, d] = [a + 1, a + n + 1, a + n + 2];
        // The diagonal has a vertex in the middle that one side knows of, and a cap closes the gap.
        let middle = positions.len() as u32;
        let [p, q] = [positions[b as usize], positions[c as usize]];
        positions.push([0, 1, 2].map(|k| f32::midpoint(p[k], q[k])));
        triangles.extend([a, b, c, c, b, middle, c, middle, d, middle, b, d]);
    }
    let options = SimplifyOptions::default().with_triangles(triangles.len() / 30);
    let sequence = simplified(&positions, &triangles, &options).sequence;
    for level in (0..=sequence.len()).step_by(10) {
        let up = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| positions[v as usize]);
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        assert!(sequence.drawn(level).iter().all(|t| up(t) > -1e-3), "level {level}");
    }
    assert!(sequence.error(0) < 1.0, "{}", sequence.error(0));
}

#[test]
fn nothing_and_what_is_flat_are_no_trouble() {
    let nothing = simplified(&[], &[], &SimplifyOptions::default());
    assert!(nothing.sequence.is_empty() && nothing.stopped.is_none());
    // All at one place, and all on one line.
    let twice = simplified(&[[1.0; 3]; 4], &[0, 1, 2, 2, 1, 3], &SimplifyOptions::default());
    assert_eq!(twice.sequence.triangle_count(0), 2);
    let line: Vec<[f32; 3]> = (0..6).map(|i| [i as f32, 0.0, 0.0]).collect();
    let flat = simplified(&line, &[0, 1, 2, 2, 1, 3, 2, 3, 4, 4, 3, 5], &SimplifyOptions::default());
    assert!(flat.sequence.triangle_count(0) < 4);
    let huge = [[-3e38, 0.0, 0.0], [3e38, 0.0, 0.0], [0.0, 3e38, 0.0], [3e38, 3e38, 3e38]];
    simplified(&huge, &[0, 1, 2, 2, 1, 3], &SimplifyOptions::default());
    assert!(simplify(&mesh(&line, &[]), vec![0, 1], &SimplifyOptions::default()).is_err());
    assert!(simplify(&mesh(&line, &[]), vec![0, 1, 6], &SimplifyOptions::default()).is_err());
}

proptest! {
    /// Triangles of any kind, non-manifold, double, of one position: the collapses are what they say, and the result is the same again.
    #[test]
    fn soup_is_no_trouble(
        corners in prop::collection::vec(0..12_u32, 0..90),
        places in prop::collection::vec([0..3_u8, 0..3_u8, 0..3_u8], 12),
        target in 0..20_usize,
    ) {
        let positions: Vec<[f32; 3]> = places.iter().map(|p| p.map(f32::from)).collect();
        let whole = corners.len() / 3 * 3;
        let triangles = corners[..whole].to_vec();
        let options = SimplifyOptions::default().with_triangles(target);
        let simplification = simplified(&positions, &triangles, &options);
        let sequence = &simplification.sequence;
        for level in 0..=sequence.len() {
            prop_assert_eq!(sequence.drawn(level).len(), sequence.triangle_count(level));
        }
        prop_assert_eq!(simplification.stopped.is_some(), sequence.triangle_count(0) > target);
        prop_assert_eq!(&simplification, &simplified(&positions, &triangles, &options));
    }

    /// Grids with holes: every level is a manifold of the same shape.
    #[test]
    fn holes_stay(missing in prop::collection::hash_set(0..128_usize, 0..40), around in any::<[bool; 2]>()) {
        let (positions, triangles) = grid(8, 8, around);
        let triangles: Vec<u32> = triangles.chunks_exact(3).enumerate()
            .filter(|(t, _)| !missing.contains(t)).flat_map(|(_, t)| t.to_vec()).collect();
        let sequence = simplified(&positions, &triangles, &SimplifyOptions::default()).sequence;
        let full = shape(&sequence.drawn(sequence.len()));
        for level in 0..sequence.len() {
            prop_assert_eq!(shape(&sequence.drawn(level)).1, full.1, "level {}", level);
            prop_assert_eq!(shape(&sequence.drawn(level)).0, full.0, "level {}", level);
        }
    }
}
