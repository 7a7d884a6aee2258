//! Reads arbitrary bytes as STL.
#![no_main]

use tristrip_io::Format;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = tristrip_io::read(data, Format::Stl);
});
