//! Reads arbitrary bytes as glTF and GLB. A model that can be read is reordered and written;
//! reading it again gives the same triangles.
#![no_main]

use tristrip::verify::verify_models;
use tristrip::{Layout, Mesh, Method, StripifyOptions, Strips, stripify};
use tristrip_io::{Drawing, Format, Model, read, reorder, write};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    for format in [Format::Gltf, Format::Glb] {
        let Ok(model) = read(data, format) else { continue };
        let options = StripifyOptions::default().with_method(Method::Input);
        let of = |mesh| stripify(mesh, &options).expect("the order of the input has strips");
        let strips: Vec<Strips> = meshes(&model).into_iter().map(of).collect();
        // Every other part is drawn as faces.
        let drawing = |(part, strips)| if part % 2 == 0 { Drawing::Strips(strips) } else { Drawing::Faces };
        let drawings: Vec<_> = strips.iter().enumerate().map(drawing).collect();
        let ordered =
            reorder(&model, &drawings, Format::Glb, Layout::Degenerate).expect("strips of the model");
        // Buffers cannot be merged if an extension refers to bytes of one.
        let Ok(bytes) = write(&ordered.model, &ordered.drawings(), Format::Glb, ordered.layout) else {
            continue;
        };
        let again = read(&bytes, Format::Glb).expect("what was written can be read");
        let proof = verify_models(&meshes(&model), &meshes(&again)).expect("few enough vertices");
        assert!(proof.is_ok(), "{proof:?}");
    }
});

fn meshes(model: &Model) -> Vec<&Mesh> {
    model.parts.iter().map(|part| &part.mesh).collect()
}
