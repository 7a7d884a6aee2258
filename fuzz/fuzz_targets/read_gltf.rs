//! Any bytes, read as glTF and GLB: an answer or an error.
#![no_main]

use tristrip_io::Format;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = tristrip_io::read(data, Format::Gltf);
    let _ = tristrip_io::read(data, Format::Glb);
});
