//! Converts a 16-bit index buffer into strips, without positions. Run with
//! `cargo run -p tristrip --example index_buffer`.
#![allow(clippy::print_stdout, reason = "an example shows what it does")]

use tristrip::Layout;

fn main() -> Result<(), tristrip::Error> {
    // A grid of 100 × 100 quadrilaterals, two triangles each.
    let quad = |i: u16| [i, i + 1, i + 101, i + 101, i + 1, i + 102];
    let cells = (0..100).flat_map(|y| (0..100).map(move |x| 101 * y + x));
    let indices: Vec<u16> = cells.flat_map(quad).collect();

    // ANCHOR: strip
    let vertex_count = 101 * 101;
    let strips = tristrip::stripify_indices(&indices, vertex_count)?;
    let buffer: Vec<u16> = strips.to_indices(Layout::Restart)?;
    // ANCHOR_END: strip

    println!("{} indices as a list, {} as {} strips", indices.len(), buffer.len(), strips.len());
    Ok(())
}
