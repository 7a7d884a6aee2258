//! Strips that a decoder maintains, proven after every chunk of the models in testdata, with and
//! without their attributes.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::path::Path;

use tristrip::Mesh;
use tristrip::stream::{Decoder, StreamLimits, StreamOptions};
use tristrip::verify::verify;
use tristrip_io::read_path;
use tristrip_pipeline::stream_of_mesh;

/// Proves the strips after each chunk. Returns the mean number of vertices sent, relative to three
/// per triangle.
fn check(mesh: &Mesh) -> f64 {
    let streamed = stream_of_mesh(mesh, 0, &StreamOptions::default()).unwrap();
    let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
    let mut sum = 0.0;
    for chunk in &streamed.stream.chunks {
        decoder.update(&chunk.bytes).unwrap();
        let part = decoder.part(0).unwrap();
        let strips = part.strips().unwrap();
        verify(&part.mesh().unwrap(), &strips).unwrap();
        assert_eq!(part.vertices_sent(), Some(strips.vertices_sent()));
        sum += strips.vertices_sent() as f64 / (3.0 * part.triangle_count() as f64);
    }
    assert_eq!(decoder.part(0).unwrap().triangle_count(), streamed.triangles);
    sum / streamed.stream.chunks.len() as f64
}

#[test]
fn models_have_proven_strips_after_every_chunk() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
    for name in [
        "catmark_bishop.ply",
        "fish_control.ply",
        "hand.ply",
        "self_intersect_a.ply",
        "wingnut.ply",
        "milktruck.glb",
    ] {
        for part in read_path(folder.join(name)).unwrap().parts {
            let positions = Mesh::new(part.mesh.shared_positions(), part.mesh.faces().clone()).unwrap();
            let [all, alone] = [&part.mesh, &positions].map(check);
            // Seams cut strips, and some parts of the truck have two triangles.
            let most = if name.starts_with("milktruck") { 0.8 } else { 0.6 };
            assert!(alone < most && all < 0.8, "{name}: {all} {alone}");
        }
    }
}
