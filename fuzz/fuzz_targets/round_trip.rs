//! Writes models that can be read as PLY and OBJ and reads them again: positions and faces are the
//! same.
#![no_main]

use tristrip::Layout;
use tristrip_io::{Drawing, Format, Model, read, write};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(model) = read(data, Format::from_bytes(data)) else { return };
    let drawings = vec![Drawing::Faces; model.parts.len()];
    let again = |format| {
        let bytes =
            write(&model, &drawings, format, Layout::List).expect("a model that was read can be written");
        read(&bytes, format)
    };
    let ply = again(Format::Ply).expect("what was written can be read");
    assert_eq!(faces(&model), faces(&ply));
    // OBJ cannot represent a model without vertices.
    if model.parts.iter().any(|part| part.mesh.vertex_count() > 0) {
        again(Format::Obj).expect("what was written can be read");
    }
});

/// Returns the corners of every face as the bits of their positions.
fn faces(model: &Model) -> Vec<Vec<[u32; 3]>> {
    let mut out = Vec::new();
    for part in &model.parts {
        let position = |&v: &u32| part.mesh.positions()[v as usize].map(f32::to_bits);
        out.extend(part.mesh.faces().iter().map(|face| face.iter().map(position).collect()));
    }
    out
}
