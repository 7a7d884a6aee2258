//! Reads arbitrary bytes as OFF.
#![no_main]

use tristrip_io::Format;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = tristrip_io::read(data, Format::Off);
});
