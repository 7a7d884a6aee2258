//! Implements a custom stripper: chooses a path cover of the dual graph, and proves the strips. Run
//! with `cargo run -p tristrip --example custom_stripper`.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::error::Error;

use tristrip::stripify::StripPlan;
use tristrip::verify::verify;
use tristrip::{DualGraph, Faces, HalfEdge, Mesh, PathCover, PreparedFaces, Triangulation};

fn main() -> Result<(), Box<dyn Error>> {
    // A hilly grid of 20 × 20 quadrilaterals.
    let quad = |i: u32| [i, i + 1, i + 22, i + 21];
    let faces = Faces::from_polygons((0..20).flat_map(|y| (0..20).map(move |x| quad(21 * y + x))))?;
    let position = |i: u32| [(i % 21) as f32, (i / 21) as f32, (i * i % 7) as f32 / 4.0];
    let mesh = Mesh::new((0..441).map(position).collect::<Vec<_>>(), faces)?;

    // ANCHOR: method
    // 1. The triangles and their dual graph.
    let prepared = PreparedFaces::new(&mesh, false);
    let graph = DualGraph::new(prepared.faces());
    let triangulation = Triangulation::fans(&prepared, &graph)?;

    // 2. The method: join paths across shared edges, longest edges first.
    let mut edges: Vec<(f32, HalfEdge)> = Vec::new();
    for (h, twin) in (0_u32..).zip(triangulation.graph().half_edge_twins()) {
        // Visit each shared edge once.
        if twin.is_some_and(|twin| h < twin.0) {
            edges.push((squared_length(&mesh, triangulation.triangles(), h), HalfEdge(h)));
        }
    }
    edges.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let mut cover = PathCover::isolated(triangulation.triangle_count());
    for (_, half_edge) in edges {
        cover.join(triangulation.graph(), half_edge);
    }

    // 3. The strips of the paths, and the proof that they draw the mesh.
    let strips = StripPlan::from_cover(&prepared, triangulation, cover)?.strips();
    let proof = verify(&mesh, &strips)?;
    // ANCHOR_END: method
    println!("{} strips draw {} faces, with {} vertices", strips.len(), proof.faces, strips.vertices_sent());
    Ok(())
}

/// Returns the squared length of the edge from the corner of a half-edge to the next corner of its
/// triangle.
fn squared_length(mesh: &Mesh, triangles: &[u32], half_edge: u32) -> f32 {
    let next = half_edge - half_edge % 3 + (half_edge + 1) % 3;
    let [a, b] = [half_edge, next].map(|corner| mesh.positions()[triangles[corner as usize] as usize]);
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}
