//! Proves strips, and shows the result for incomplete ones. Run with
//! `cargo run -p tristrip --example prove`.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use tristrip::verify::verify;
use tristrip::{Faces, Mesh, StripifyOptions, Strips, stripify};

fn main() -> Result<(), tristrip::Error> {
    // A cube of six quadrilaterals.
    let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f32);
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mesh = Mesh::new((0..8).map(corner).collect::<Vec<_>>(), Faces::from_polygons(sides)?)?;

    // ANCHOR: prove
    let strips = stripify(&mesh, &StripifyOptions::default())?;
    match verify(&mesh, &strips) {
        Ok(_) => println!("{} strips draw the cube, with {} vertices", strips.len(), strips.vertices_sent()),
        Err(problem) => println!("not proven: {problem}"),
    }
    // ANCHOR_END: prove

    // Without its first strip the cube is incomplete.
    let mut wrong = Strips::default();
    strips.iter().skip(1).for_each(|strip| wrong.push(strip));
    match verify(&mesh, &wrong) {
        Ok(_) => println!("a part of the cube was taken for all of it"),
        Err(problem) => println!("not proven, as it should be: {problem}"),
    }
    Ok(())
}
