//! Progressive strips of the small free models: at levels across the whole sequence, each
//! level-of-detail model draws the same as the oracle, with each filter. Refining back to the full
//! mesh restores the initial state.

use std::path::Path;
use std::sync::Arc;

use tristrip::lod::{Encoding, ProgressiveMesh, ProgressiveStrips};
use tristrip::lod::{Filter, LevelCursor};
use tristrip::simplify::{self, simplify_triangles};
use tristrip::{CollapseSequence, Mesh, Method, Strips, stripify};

const MODELS: [&str; 6] = [
    "catmark_bishop.ply",
    "fish_control.ply",
    "hand.ply",
    "milktruck.glb",
    "self_intersect_a.ply",
    "wingnut.ply",
];

/// The number of checked levels per part.
const LEVELS: usize = 24;

fn meshes() -> Vec<(String, Mesh)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models");
    let parts = MODELS.iter().flat_map(|name| {
        let model = tristrip_io::read_path(folder.join(name)).unwrap();
        model.parts.into_iter().enumerate().map(move |(i, part)| (format!("{name}, part {i}"), part.mesh))
    });
    parts.collect()
}

fn sorted(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let rotations = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    let mut sorted: Vec<_> = triangles.map(rotations).collect();
    sorted.sort_unstable();
    sorted
}

fn check(name: &str, strips: &Strips, sequence: &CollapseSequence) {
    let mut mesh = Arc::new(ProgressiveMesh::new(sequence).unwrap()).cursor();
    let model = |encoding| ProgressiveStrips::new(strips, sequence, encoding).unwrap();
    let mut cursors = Encoding::ALL.map(|encoding| Arc::new(model(encoding)).cursor());
    let full = cursors.each_ref().map(|cursor| cursor.entries().to_vec());
    let (mut map, mut display) = (Vec::new(), Strips::default());
    for step in (0..=LEVELS).rev() {
        let level = sequence.len() * step / LEVELS;
        let drawn = sorted(sequence.drawn(level).unwrap().into_iter());
        mesh.set_level(level).unwrap();
        let corners = mesh.corners().chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
        assert_eq!(sorted(corners), drawn, "{name}, level {level}");
        for cursor in &mut cursors {
            cursor.set_level(level).unwrap();
            cursor.decode_to(&mut map);
            for filter in Filter::ALL {
                display.clear();
                filter.map_to(&map, &mut display);
                assert_eq!(sorted(display.triangles()), drawn, "{name}, level {level}, {filter:?}");
            }
        }
    }
    for (cursor, full) in cursors.iter_mut().zip(full) {
        cursor.set_level(sequence.len()).unwrap();
        assert_eq!(cursor.entries(), full, "{name}");
    }
}

#[test]
fn models_draw_what_the_oracle_draws() {
    for (name, mesh) in meshes() {
        for method in [Method::STRIPE, Method::Sequential] {
            let strips = stripify(&mesh, &tristrip::StripifyOptions::default().with_method(method)).unwrap();
            let options = simplify::SimplifyOptions::default();
            let sequence = simplify_triangles(&mesh, strips.to_list(), &options).unwrap().sequence;
            check(&name, &strips, &sequence);
        }
    }
}
