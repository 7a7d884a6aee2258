//! Pairs half-edges into twins by the rule stated in [`super`].
//!
//! # Algorithm
//! In a simple mesh no two half-edges have the same direction over the same vertices, and no face
//! contains both half-edges of an edge. The twins are then unique and are found by marks, vertex by
//! vertex.
//!
//! Otherwise half-edges are processed in order. Each is stored in the list of its lower vertex
//! until a half-edge of opposite direction over the same vertices arrives, and is then paired and
//! removed from the list. The lists are stored in the slots of the unknown twins, so only their
//! heads need memory. If the lists become long, the half-edges are paired by sorting instead, with
//! the same result.
//!
//! # Complexity
//! See [`super`].

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

#[cfg(feature = "rayon")]
use rayon::prelude::*;

use super::corners::FaceCorners;
use crate::csr::Csr;
use crate::mesh::vertex_bound;

/// The packed twin of a half-edge without one. During the pairing it also ends a list of unpaired
/// half-edges.
pub(super) const NO_TWIN: u32 = u32::MAX;
/// Number of unpaired half-edges over one edge that are compared with a new one.
const CANDIDATES: usize = 8;
/// Average list steps per half-edge after which the pairing is done by sorting.
const STEPS_PER_HALF_EDGE: usize = 32;

/// Meshes with fewer corners are paired by one thread, in a few milliseconds.
#[cfg(feature = "rayon")]
const THREADING_MINIMUM: usize = 1 << 18;
/// Maximum number of vertex ranges that are paired in parallel. Each range reads all corners.
#[cfg(feature = "rayon")]
const RANGES: usize = 8;

/// Pairs all half-edges. Returns the twin of each, or `NO_TWIN`, and whether the mesh is simple,
/// which makes the pairing unique.
pub(super) fn pair(corners: &impl FaceCorners) -> (Vec<u32>, bool) {
    if let Some(twins) = pair_simple(corners) {
        return (twins, true);
    }
    (pair_by_lists(corners).unwrap_or_else(|| pair_by_sorting(corners)), false)
}

/// Pairs the half-edges of a simple mesh, or returns `None` if two half-edges have the same
/// direction over the same vertices. Ranges of vertices are processed in parallel: each half-edge
/// is paired at the vertex that it leads to.
fn pair_simple<C: FaceCorners>(corners: &C) -> Option<Vec<u32>> {
    #[cfg(feature = "rayon")]
    if corners.vertices().len() > THREADING_MINIMUM {
        return pair_simple_in_ranges(corners, rayon::current_num_threads().min(RANGES) as u32);
    }
    pair_simple_in_ranges(corners, 1)
}

/// Pairs the half-edges of a simple mesh in a given number of vertex ranges.
fn pair_simple_in_ranges<C: FaceCorners>(corners: &C, ranges: u32) -> Option<Vec<u32>> {
    let vertices = corners.vertices();
    let vertex_count = vertex_bound(vertices);
    let twins: Vec<AtomicU32> = (0..vertices.len()).map(|_| AtomicU32::new(NO_TWIN)).collect();
    let bound = |i: u32| (vertex_count as u64 * u64::from(i) / u64::from(ranges)) as u32;
    let pair_range = |i| pair_around(corners, bound(i)..bound(i + 1), vertex_count, &twins);
    #[cfg(feature = "rayon")]
    let nothing_to_choose = (0..ranges).into_par_iter().all(pair_range);
    #[cfg(not(feature = "rayon"))]
    let nothing_to_choose = (0..ranges).all(pair_range);
    nothing_to_choose.then(|| twins.into_iter().map(AtomicU32::into_inner).collect())
}

/// Finds the twins of the half-edges that lead to a range of vertices, and returns whether the mesh
/// is simple there. Each vertex marks the targets of its outgoing half-edges, then each incoming
/// half-edge reads the mark of its origin. Hardly any branch depends on the data, which makes this
/// fast.
fn pair_around<C: FaceCorners>(
    corners: &C,
    range: Range<u32>,
    vertex_count: usize,
    twins: &[AtomicU32],
) -> bool {
    let vertices = corners.vertices();
    let keyed =
        (0..).zip(vertices).filter(|(_, v)| range.contains(v)).map(|(corner, v)| (v - range.start, corner));
    let by_vertex: Csr = Csr::group_items(keyed, range.len());
    // For each vertex: the origin (counted from 1) of the last half-edge that leads to it, and that
    // half-edge. The allocator returns zeroed memory, so no initialization pass is needed.
    let mut marks = vec![(0, 0); vertex_count];
    for (v, here) in (range.start + 1..).zip(by_vertex.rows()) {
        for &corner in here {
            let to = vertices[corners.next(corner as usize)];
            let mark = &mut marks[to as usize];
            if mark.0 == v || to + 1 == v {
                return false; // two of equal direction, or one of zero length
            }
            *mark = (v, corner);
        }
        for &corner in here {
            let incoming = corners.previous(corner as usize);
            let (marked_by, outgoing) = marks[vertices[incoming] as usize];
            if marked_by != v {
                continue;
            }
            if C::LARGER && corners.face(outgoing as usize) == corners.face(incoming) {
                return false; // a face with both half-edges of an edge; a triangle then has one of zero length
            }
            twins[incoming].store(outgoing, Ordering::Relaxed);
        }
    }
    true
}

/// Returns whether two half-edges between the same vertices have opposite directions and different
/// faces, as twins must.
#[inline]
fn opposite(corners: &impl FaceCorners, h: usize, other: usize) -> bool {
    corners.vertices()[h] != corners.vertices()[other] && corners.face(h) != corners.face(other)
}

/// Returns whether the two faces of a pair of twins fold back onto each other, like a face and its
/// own reverse.
#[inline]
fn folds_back(corners: &impl FaceCorners, h: usize, other: usize) -> bool {
    let v = corners.vertices();
    v[corners.next(corners.next(h))] == v[corners.previous(other)]
}

/// Pairs half-edges by lists of unpaired ones, or returns `None` if the lists of some vertices grow
/// too long.
fn pair_by_lists(corners: &impl FaceCorners) -> Option<Vec<u32>> {
    let vertices = corners.vertices();
    let vertex_count = vertex_bound(vertices);
    let mut heads = vec![NO_TWIN; vertex_count];
    // The twin if it is known, otherwise the next half-edge in the list of the same vertex.
    let mut twins = vec![NO_TWIN; vertices.len()];
    let mut steps = 0;
    let limit = STEPS_PER_HALF_EDGE * vertices.len() + 1024;
    let mut folded = false;
    for h in 0..vertices.len() {
        let (from, to) = (vertices[h], vertices[corners.next(h)]);
        let (low, high) = (from.min(to), from.max(to));
        let head = &mut heads[low as usize];
        let (mut before, mut unpaired, mut seen) = (NO_TWIN, *head, 0);
        let found = loop {
            if unpaired == NO_TWIN || seen == CANDIDATES {
                break None;
            }
            steps += 1;
            let w = unpaired as usize;
            let (a, b) = (vertices[w], vertices[corners.next(w)]);
            if a.max(b) == high {
                seen += 1;
                if opposite(corners, h, w) {
                    if folds_back(corners, h, w) {
                        folded = true;
                    } else {
                        break Some(w);
                    }
                }
            }
            before = unpaired;
            unpaired = twins[w];
        };
        if let Some(w) = found {
            let after = twins[w];
            if before == NO_TWIN {
                *head = after
            } else {
                twins[before as usize] = after
            }
            twins[w] = h as u32;
            twins[h] = w as u32;
        } else {
            twins[h] = *head;
            *head = h as u32;
        }
        if steps > limit {
            return None;
        }
    }
    // An unpaired half-edge has no twin, unless it was skipped because it folds back.
    let mut left = Vec::new();
    for head in heads {
        let mut unpaired = head;
        while unpaired != NO_TWIN {
            let next = std::mem::replace(&mut twins[unpaired as usize], NO_TWIN);
            if folded {
                left.push(unpaired);
            }
            unpaired = next;
        }
    }
    pair_leftovers(corners, left, &mut twins);
    Some(twins)
}

/// Pairs half-edges by sorting, with the same result as [`pair_by_lists`]: groups them by edge, in
/// order, and applies the same rule to each group.
fn pair_by_sorting(corners: &impl FaceCorners) -> Vec<u32> {
    let mut twins = vec![NO_TWIN; corners.vertices().len()];
    let mut left = Vec::new();
    let mut unpaired: Vec<u32> = Vec::new();
    for group in sorted_by_edge(corners, (0..twins.len() as u32).collect()).chunk_by(|a, b| a.0 == b.0) {
        unpaired.clear();
        for &(_, h) in group {
            let recent = unpaired.len().saturating_sub(CANDIDATES)..unpaired.len();
            let found = recent.rev().find(|&i| {
                let w = unpaired[i] as usize;
                opposite(corners, h as usize, w) && !folds_back(corners, h as usize, w)
            });
            if let Some(i) = found {
                let w = unpaired.remove(i);
                twins[w as usize] = h;
                twins[h as usize] = w;
            } else {
                unpaired.push(h);
            }
        }
        left.extend_from_slice(&unpaired);
    }
    pair_leftovers(corners, left, &mut twins);
    twins
}

/// Pairs the remaining half-edges of each edge in order, forward ones with backward ones.
fn pair_leftovers(corners: &impl FaceCorners, left: Vec<u32>, twins: &mut [u32]) {
    let (mut forward, mut backward) = (Vec::new(), Vec::new());
    for group in sorted_by_edge(corners, left).chunk_by(|a, b| a.0 == b.0) {
        forward.clear();
        backward.clear();
        for &(edge, h) in group {
            let list = if u64::from(corners.vertices()[h as usize]) == edge >> 32 {
                &mut forward
            } else {
                &mut backward
            };
            list.push(h);
        }
        for (&a, &b) in forward.iter().zip(&backward) {
            if corners.face(a as usize) != corners.face(b as usize) {
                twins[a as usize] = b;
                twins[b as usize] = a;
            }
        }
    }
}

/// Sorts half-edges by edge (lower vertex, then higher vertex), then by index. Half-edges of zero
/// length are omitted.
fn sorted_by_edge(corners: &impl FaceCorners, half_edges: Vec<u32>) -> Vec<(u64, u32)> {
    let vertices = corners.vertices();
    let mut keyed: Vec<(u64, u32)> = half_edges
        .into_iter()
        .filter_map(|h| {
            let (from, to) = (vertices[h as usize], vertices[corners.next(h as usize)]);
            let edge = u64::from(from.min(to)) << 32 | u64::from(from.max(to));
            (from != to).then_some((edge, h))
        })
        .collect();
    keyed.sort_unstable();
    keyed
}

#[cfg(test)]
mod tests {
    use super::super::corners::{PolygonCorners, TriangleCorners, for_each_edge, polygon_shape};
    use super::*;
    use crate::dual::DualGraph;
    use crate::ids::HalfEdge;
    use crate::mesh::Faces;
    use proptest::prelude::*;

    /// Implements the pairing rule literally: compares every half-edge with every earlier one.
    fn naive(corners: &impl FaceCorners) -> Vec<u32> {
        let vertices = corners.vertices();
        let edge = |h: usize| {
            let (a, b) = (vertices[h], vertices[corners.next(h)]);
            (a.min(b), a.max(b))
        };
        let mut twins = vec![NO_TWIN; vertices.len()];
        for h in 0..vertices.len() {
            let unpaired =
                (0..h).rev().filter(|&w| twins[w] == NO_TWIN && edge(w) == edge(h) && edge(h).0 != edge(h).1);
            let found =
                unpaired.take(CANDIDATES).find(|&w| opposite(corners, h, w) && !folds_back(corners, h, w));
            if let Some(w) = found {
                twins[w] = h as u32;
                twins[h] = w as u32;
            }
        }
        let left = (0..vertices.len() as u32).filter(|&h| twins[h as usize] == NO_TWIN).collect();
        pair_leftovers(corners, left, &mut twins);
        twins
    }

    /// Compares every pairing algorithm that returns a result with the naive rule, and the edge
    /// counts with sorting.
    fn compare_by(corners: &impl FaceCorners, faces: &Faces) {
        let expected = naive(corners);
        assert_eq!(DualGraph::new(faces).twins, expected);
        assert_eq!(pair_by_sorting(corners), expected);
        if let Some(twins) = pair_by_lists(corners) {
            assert_eq!(twins, expected);
        }
        let directed: Vec<(u32, u32)> = (0..faces.corner_count())
            .map(|h| (corners.vertices()[h], corners.vertices()[corners.next(h)]))
            .collect();
        let mut sorted = directed.clone();
        sorted.sort_unstable();
        for ranges in 1..4 {
            match pair_simple_in_ranges(corners, ranges) {
                Some(twins) => assert_eq!(twins, expected),
                None => assert!(sorted.windows(2).any(|w| w[0] == w[1]), "nothing to choose"),
            }
        }

        let half_edges = (0..faces.corner_count() as u32).collect();
        let by_sorting: Vec<(usize, usize)> = sorted_by_edge(corners, half_edges)
            .chunk_by(|a, b| a.0 == b.0)
            .map(|group| {
                let forward =
                    |&&(edge, h): &&(u64, u32)| u64::from(corners.vertices()[h as usize]) == edge >> 32;
                let forward = group.iter().filter(forward).count();
                (forward, group.len() - forward)
            })
            .collect();
        let mut counted = Vec::new();
        for_each_edge(faces, |forward, backward| counted.push((forward, backward)));
        assert_eq!(counted, by_sorting);
    }

    fn compare(faces: &Faces) {
        assert_eq!(DualGraph::new(faces).check(), Ok(()));
        if faces.as_triangles().is_some() {
            compare_by(&TriangleCorners { corners: faces.corners() }, faces);
        }
        let (offsets, face_of) = polygon_shape(faces);
        let corners = PolygonCorners { corners: faces.corners(), offsets: &offsets, face_of: &face_of };
        compare_by(&corners, faces);
        // The same faces with sparse vertex numbers, which are renumbered.
        let apart = faces.corners().iter().map(|v| 1000 * v).collect();
        let apart = Faces::from_offsets(offsets.clone(), apart).unwrap();
        assert_eq!(DualGraph::new(&apart).twins, naive(&corners));
    }

    proptest! {
        #[test]
        fn agrees_with_the_naive_rule(corners in prop::collection::vec((0..9_u32, 0..9_u32, 0..9_u32), 0..60)) {
            let corners: Vec<u32> = corners.into_iter().filter(|t| t.0 != t.1 && t.1 != t.2 && t.0 != t.2)
                .flat_map(|t| [t.0, t.1, t.2]).collect();
            compare(&Faces::from_triangles(corners).unwrap());
        }

        #[test]
        fn agrees_with_the_naive_rule_on_polygons(seeds in prop::collection::vec((3..7_usize, 0..12_u32, 1..4_u32), 0..30)) {
            let polygons = seeds.into_iter().map(|(n, first, step)| {
                (0..n as u32).map(|i| (first + i * step) % 23).collect::<Vec<_>>()
            });
            compare(&Faces::from_polygons(polygons).unwrap());
        }
    }

    proptest! {
        #[test]
        fn vertex_numbers_do_not_matter(corners in prop::collection::vec((0..9_u32, 0..9_u32, 0..9_u32), 0..60)) {
            let corners: Vec<u32> = corners.into_iter().filter(|t| t.0 != t.1 && t.1 != t.2 && t.0 != t.2)
                .flat_map(|t| [8 - t.0, 8 - t.1, 8 - t.2]).collect();
            let faces = Faces::from_triangles(corners).unwrap();
            prop_assert_eq!(DualGraph::new(&faces), DualGraph::new(&faces.in_order_of_use()));
        }
    }

    #[test]
    fn faces_with_both_half_edges_of_an_edge_are_not_connected_to_themselves() {
        compare(&Faces::from_triangles(vec![0, 1, 0, 1, 0, 2, 3, 3, 3]).unwrap());
        compare(&Faces::from_polygons([vec![0, 1, 2, 1], vec![2, 1, 3], vec![4, 4]]).unwrap());
    }

    #[test]
    fn every_pairing_algorithm_is_reached() {
        // A tetrahedron; the same with a face twice; and triangles around a vertex whose open edges
        // make its list long.
        let closed = vec![0, 1, 2, 0, 2, 3, 0, 3, 1, 3, 2, 1];
        let doubled = [&closed[..], &closed[..3]].concat();
        let star: Vec<u32> = (0..300).flat_map(|i| [0, 1 + 2 * i, 2 + 2 * i]).collect();
        assert!(pair_simple(&TriangleCorners { corners: &closed }).is_some());
        assert!(pair_simple(&TriangleCorners { corners: &doubled }).is_none());
        assert!(pair_by_lists(&TriangleCorners { corners: &doubled }).is_some());
        assert!(pair_by_lists(&TriangleCorners { corners: &star }).is_none());
        for corners in [closed, doubled, star] {
            compare(&Faces::from_triangles(corners).unwrap());
        }
    }

    #[test]
    fn a_star_of_open_edges_is_paired_by_sorting() {
        let corners: Vec<u32> = (0..5000).flat_map(|i| [0, 1 + 2 * i, 2 + 2 * i]).collect();
        assert!(pair_by_lists(&TriangleCorners { corners: &corners }).is_none());
        assert_eq!(DualGraph::new(&Faces::from_triangles(corners).unwrap()).components().1, 5000);
    }

    #[test]
    fn doubled_faces_are_connected_to_their_neighbours_first() {
        // Two triangles that share an edge, each with its reverse.
        let faces = Faces::from_triangles(vec![0, 1, 2, 0, 2, 1, 2, 1, 3, 2, 3, 1]).unwrap();
        let graph = DualGraph::new(&faces);
        let over_shared_edge: Vec<_> = (0..12)
            .filter(|&h| {
                let face = h / 3;
                graph.twin(HalfEdge(h)).is_some_and(|t| t.0 / 3 / 2 != face / 2)
            })
            .collect();
        assert_eq!(over_shared_edge.len(), 4);
    }
}
