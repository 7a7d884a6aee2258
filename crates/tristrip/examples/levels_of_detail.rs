//! Draws a mesh at another level of detail in every frame. Run with
//! `cargo run --release -p tristrip --example levels_of_detail`.
//!
//! The mesh moves away from the camera and returns. In each frame its error may cover one pixel.
//! Only the changed ranges of the index buffer would be uploaded to the GPU.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use std::sync::Arc;
use std::time::Instant;

use tristrip::lod::{Encoding, LevelCursor, LevelModel, ProgressiveStrips, View};
use tristrip::simplify::{SimplifyOptions, simplify_triangles};
use tristrip::{Faces, Layout, Mesh, StripifyOptions, stripify};

/// Number of frames of the flight.
const FRAMES: usize = 600;
/// Number of rows of the image.
const ROWS: f32 = 1080.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Hills of 150 × 150 quadrilaterals.
    let side = 151;
    let height = |x: f32, y: f32| (0.21 * x).sin() * (0.17 * y).cos() * 6.0;
    let at = |i: u32| {
        let (x, y) = ((i % side) as f32, (i / side) as f32);
        [x, y, height(x, y)]
    };
    let quad = |i: u32| [i, i + 1, i + side + 1, i + side];
    let cells = (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| y * side + x));
    let mesh =
        Mesh::new((0..side * side).map(at).collect::<Vec<_>>(), Faces::from_polygons(cells.map(quad))?)?;

    // Once: the strips of the full mesh, the collapses, and the model of all levels.
    let strips = stripify(&mesh, &StripifyOptions::default())?;
    let sequence = simplify_triangles(&mesh, strips.to_list(), &SimplifyOptions::default())?.sequence;
    let model = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?);
    println!("{} levels, {} kB", model.levels().collapse_count() + 1, model.memory() / 1000);

    // Per frame: a level, its strips, and the changes of the buffer.
    let mut cursor = model.cursor();
    let mut buffer: Vec<u16> = Vec::new();
    let (mut triangles, mut sent) = (0, 0);
    let start = Instant::now();
    for frame in 0..FRAMES {
        let away = frame.min(FRAMES - frame) as f32 / (FRAMES / 2) as f32;
        cursor.set_pixels(1.0, View::perspective(100.0 + 20_000.0 * away, 1.7, ROWS)?)?;
        let changed = cursor.strips().update_indices(Layout::Restart, &mut buffer)?;
        triangles += model.levels().triangle_count(cursor.level())?;
        sent += changed.iter().map(ExactSizeIterator::len).sum::<usize>();
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{:.3} ms per frame", 1e3 * seconds / FRAMES as f64);
    println!("{} triangles and {} changed indices per frame", triangles / FRAMES, sent / FRAMES);
    Ok(())
}
