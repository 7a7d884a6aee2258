//! Reads a mesh, builds strips, verifies them and writes a GLB: the lines of the README.

use tristrip::Layout;
use tristrip_io::Drawing;

#[expect(clippy::print_stdout, reason = "an example prints its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: file
    let model = tristrip_io::read_path("testdata/models/hand.ply")?;
    let mesh = &model.parts[0].mesh;
    let strips = tristrip::stripify(mesh, &tristrip::StripifyOptions::default())?;
    let proof = tristrip::verify::verify(mesh, &strips)?;
    tristrip_io::write_path("hand.glb", &model, &[Drawing::Strips(&strips)], Layout::Degenerate)?;
    // ANCHOR_END: file
    println!("{} strips draw {} faces", strips.len(), proof.faces);
    Ok(())
}
