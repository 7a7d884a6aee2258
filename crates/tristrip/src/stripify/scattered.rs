//! Handles meshes whose faces are in random order. This library's own methods process these faces
//! in another order, in which neighbours are close in memory.
//!
//! A method reads a face, then its neighbours. In scans, grids and stored strips, most neighbours
//! are a few faces away. In files with randomly ordered faces, each step causes cache misses, and a
//! million triangles take five to ten times as long. The published methods and `input` process the
//! faces in mesh order, which is part of their definition.
//!
//! # Algorithm
//! 1. Sample faces at equal distances in the order, and count the faces with a nearby neighbour. If
//!    there are few, the faces are scattered.
//! 2. Order the faces by a breadth-first search over the dual graph, started from each face in
//!    turn.
//! 3. Copy the faces and the dual graph in that order. Half-edges keep their twins.
//!
//! # Complexity
//! The test takes a few thousand accesses. Reordering takes O(n) time, and 12 bytes per corner for
//! faces and graph.

use crate::dual::DualGraph;
use crate::ids::FaceId;
use crate::prepare::PreparedFaces;

/// Smaller meshes fit in processor caches. Counted in faces.
const MINIMUM: usize = 1 << 16;
/// Faces are near each other if their indices differ by at most this.
const NEAR: u32 = 1 << 10;
/// Number of faces sampled.
const SAMPLES: usize = 1 << 12;
/// Faces are scattered if at most one in this many has a nearby neighbour.
const FEW: usize = 8;

/// Returns faces and their graph in an order in which neighbours are near, or `None` if they are
/// already.
pub(super) fn gather<'a>(
    prepared: &PreparedFaces<'_>,
    graph: &DualGraph,
) -> Option<(PreparedFaces<'a>, DualGraph)> {
    if graph.face_count() < MINIMUM || !is_scattered(graph) {
        return None;
    }
    let order = breadth_first(graph);
    let gathered = prepared.in_order(&order);
    let graph = graph.in_order(&order, gathered.faces());
    Some((gathered, graph))
}

/// Returns whether few faces have a neighbour that is near in the order. Faces without neighbours
/// do not count.
fn is_scattered(graph: &DualGraph) -> bool {
    let step = (graph.face_count() / SAMPLES).max(1);
    let (mut connected, mut near) = (0, 0);
    for face in (0..graph.face_count() as u32).step_by(step) {
        let nearest = graph.neighbours(FaceId(face)).map(|other| other.0.abs_diff(face)).min();
        connected += usize::from(nearest.is_some());
        near += usize::from(nearest.is_some_and(|distance| distance <= NEAR));
    }
    connected > 0 && near * FEW <= connected
}

/// Returns the faces in the order of breadth-first searches, each from the first face that no
/// search has reached.
fn breadth_first(graph: &DualGraph) -> Vec<u32> {
    let mut is_reached = vec![false; graph.face_count()];
    let mut order: Vec<u32> = Vec::with_capacity(graph.face_count());
    for start in 0..graph.face_count() as u32 {
        let mut next = order.len();
        if !std::mem::replace(&mut is_reached[start as usize], true) {
            order.push(start);
        }
        while let Some(&face) = order.get(next) {
            next += 1;
            for other in graph.neighbours(FaceId(face)) {
                if !std::mem::replace(&mut is_reached[other.0 as usize], true) {
                    order.push(other.0);
                }
            }
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Faces, Mesh};
    use crate::random::Random;
    use crate::strip::Metrics;
    use crate::stripify::{Method, StripifyOptions, generated_meshes, stripify};
    use crate::verify::verify;
    use proptest::prelude::*;

    /// Returns a grid of squares, each of two triangles or one polygon, in row order or random
    /// order.
    fn grid(side: u32, are_triangles: bool, at_random: bool) -> Mesh {
        let corners = |i: u32| {
            let v = i / side * (side + 1) + i % side;
            [v, v + 1, v + side + 2, v + side + 1]
        };
        let squares = (0..side * side).map(corners);
        let mut faces: Vec<Vec<u32>> = if are_triangles {
            squares.flat_map(|[a, b, c, d]| [vec![a, b, c], vec![a, c, d]]).collect()
        } else {
            squares.map(Vec::from).collect()
        };
        let mut random = Random::new(1);
        for i in (1..faces.len()).rev().filter(|_| at_random) {
            faces.swap(i, random.below(i + 1));
        }
        let at = |i: u32| [(i % (side + 1)) as f32, (i / (side + 1)) as f32, 0.0];
        let positions: Vec<[f32; 3]> = (0..(side + 1) * (side + 1)).map(at).collect();
        Mesh::new(positions, Faces::from_polygons(&faces).unwrap()).unwrap()
    }

    #[test]
    fn scattered_faces_get_strips_as_good_as_ordered_ones() {
        for (side, are_triangles) in [(190, true), (260, false)] {
            for method in [Method::Sequential, Method::Cache] {
                let options = StripifyOptions::default().with_method(method);
                let indices = [false, true].map(|at_random| {
                    let mesh = grid(side, are_triangles, at_random);
                    let prepared = PreparedFaces::new(&mesh, false);
                    let graph = DualGraph::new(prepared.faces());
                    assert_eq!(gather(&prepared, &graph).is_some(), at_random);
                    let strips = stripify(&mesh, &options).unwrap();
                    assert!(verify(&mesh, &strips).is_ok());
                    Metrics::of(&strips).indices_restart
                });
                assert!(indices[1] * 10 < indices[0] * 11, "{method}: {indices:?}");
            }
        }
    }

    #[test]
    fn faces_without_neighbours_stay() {
        let corners = (0..3 * MINIMUM as u32).collect();
        let mesh = Mesh::new(vec![[0.0; 3]; 3 * MINIMUM], Faces::from_triangles(corners).unwrap()).unwrap();
        let prepared = PreparedFaces::new(&mesh, false);
        assert!(gather(&prepared, &DualGraph::new(prepared.faces())).is_none());
    }

    proptest! {
        /// Every face occurs once, and half-edges keep their twins.
        #[test]
        fn the_graph_connects_the_same_faces(polygons in generated_meshes::polygons(false, 1..9)) {
            let vertex_count = polygons.iter().flatten().max().map_or(0, |&v| v as usize + 1);
            let faces = Faces::from_polygons(&polygons).unwrap();
            let mesh = Mesh::new(vec![[0.0; 3]; vertex_count], faces).unwrap();
            let prepared = PreparedFaces::new(&mesh, false);
            let graph = DualGraph::new(prepared.faces());
            let order = breadth_first(&graph);
            let mut sorted = order.clone();
            sorted.sort_unstable();
            prop_assert!(sorted.into_iter().eq(0..graph.face_count() as u32));
            let gathered = prepared.in_order(&order);
            let reordered = graph.in_order(&order, gathered.faces());
            prop_assert!(reordered.check().is_ok() && reordered.check_faces(gathered.faces()).is_ok());
            for (new, &old) in (0..).zip(&order) {
                prop_assert!(gathered.faces().get(new as usize) == prepared.faces().get(old as usize));
                let before = graph.neighbours(FaceId(old)).map(|face| face.0);
                let after = reordered.neighbours(FaceId(new)).map(|face| order[face.0 as usize]);
                prop_assert!(before.eq(after));
            }
        }
    }
}
