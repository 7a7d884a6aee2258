//! The streams in testdata/stream/v1, which decoders in all languages read with the same results.

#![allow(clippy::unwrap_used, reason = "a test")]

use std::path::Path;

use serde_json::Value;
use tristrip::stream::{Decoder, StreamLimits};

#[test]
fn every_chunk_has_its_fingerprint() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/stream/v1");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "bin") {
            continue;
        }
        let bytes = std::fs::read(&path).unwrap();
        let expected: Value =
            serde_json::from_slice(&std::fs::read(path.with_extension("json")).unwrap()).unwrap();
        let mut decoder = Decoder::new(StreamLimits::default());
        let mut start = 0;
        for chunk in expected["chunks"].as_array().unwrap() {
            let number = |name: &str| chunk[name].as_u64().unwrap();
            let end = number("end") as usize;
            assert_eq!(decoder.update(&bytes[start..end]), Ok(1), "{}", path.display());
            start = end;
            let part = decoder.part(number("stream") as usize).unwrap();
            let found = [part.level() as u64, part.triangle_count() as u64, part.vertex_count() as u64];
            assert_eq!(found, ["level", "triangles", "vertices"].map(number), "{}", path.display());
            assert_eq!(u64::from(part.fingerprint()), number("fingerprint"), "{} at {end}", path.display());
        }
        assert_eq!((start, decoder.offset()), (bytes.len(), bytes.len() as u64));
        count += 1;
    }
    assert!(count >= 9, "{count}");
}
