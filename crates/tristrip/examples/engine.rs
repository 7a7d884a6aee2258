//! Draws a mesh at the detail that a camera needs, in two ways. Run with
//! `cargo run --release -p tristrip --example engine`.
#![allow(clippy::print_stdout, reason = "an example prints its results")]

use std::sync::Arc;

use tristrip::lod::{BlockOptions, Blocks, Camera, Hysteresis, LevelCursor, SkipStrips, View, ViewCriteria};
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree, simplify_triangles};
use tristrip::{Faces, Mesh, StripifyOptions, stripify};

fn main() -> Result<(), tristrip::Error> {
    let mesh = hills(101)?;

    // ANCHOR: build
    // Once per mesh, when it is built or loaded.
    let strips = stripify(&mesh, &StripifyOptions::default())?;
    let sequence = simplify_triangles(&mesh, strips.to_list(), &SimplifyOptions::default())?.sequence;
    let model = Arc::new(Blocks::new(&strips, sequence, &BlockOptions::default())?);
    // ANCHOR_END: build

    // ANCHOR: level
    // Once per instance: a cursor with its own index buffer.
    let mut cursor = model.cursor::<u16>()?;

    // Per frame: the coarsest level with an error of at most one pixel.
    for distance in [50.0, 500.0, 5000.0] {
        let view = View::of_camera(distance, 45.0, 1080.0)?;
        cursor.follow_pixels(1.0, view, Hysteresis::default())?;
        // Upload these ranges of cursor.indices(), then draw one triangle strip with primitive
        // restart.
        let changed = cursor.take_changed(16);
        let triangles = cursor.levels().triangle_count(cursor.level())?;
        println!("distance {distance}: {triangles} triangles, {} ranges to upload", changed.len());
    }
    // ANCHOR_END: level

    // ANCHOR: view
    // Once per mesh: a merge tree, and strips over it.
    let tree =
        merge_tree(&mesh, strips.to_list(), MergeOrder::Quadric, &SimplifyOptions::default())?.sequence;
    let model = Arc::new(SkipStrips::new(&strips, &tree, mesh.positions())?);

    // Once per camera: a view. Per frame: an update.
    let mut view = model.view();
    let criteria = ViewCriteria::default().with_pixels(1.0).with_budget(5_000);
    for x in [0.0, 25.0, 50.0, 75.0, 100.0] {
        let camera = Camera::new([x, 20.0, -10.0], [50.0, 0.0, 50.0])?;
        // Upload update.changed, the ranges of view.indices() that differ from the previous frame.
        let update = view.update(&camera, &criteria)?;
        println!("x {x}: {} triangles, {} ranges to upload", view.triangle_count(), update.changed.len());
    }
    // ANCHOR_END: view
    Ok(())
}

/// Returns hills of `side` × `side` vertices, with the y axis up.
fn hills(side: u32) -> Result<Mesh, tristrip::Error> {
    let position = |i: u32| {
        let (x, z) = ((i % side) as f32, (i / side) as f32);
        [x, (0.21 * x).sin() * (0.17 * z).cos() * 6.0, z]
    };
    let quad = |i: u32| [i, i + side, i + side + 1, i + 1];
    let cells = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
    let faces = Faces::from_polygons(cells.map(quad))?;
    Mesh::new((0..side * side).map(position).collect::<Vec<_>>(), faces)
}
