//! Tests of the streams in testdata/stream/v1, which decoders in all languages must read with the
//! same results, and of the strips that they maintain.
//!
//! `TRISTRIP_BLESS=1` writes new checksums of the strips. Review the difference before committing it.

#![allow(clippy::unwrap_used, reason = "a test")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::Value;
use tristrip::Layout;
use tristrip::stream::{Decoder, StreamLimits};
use tristrip::verify::verify;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/stream")
}

/// Returns the streams by name, each with its expected results.
fn streams() -> Vec<(String, Vec<u8>, Value)> {
    let entries = std::fs::read_dir(folder().join("v1")).unwrap().map(|entry| entry.unwrap().path());
    let streams = entries.filter(|path| path.extension().is_some_and(|extension| extension == "bin"));
    let read = |path: PathBuf| {
        let expected = serde_json::from_slice(&std::fs::read(path.with_extension("json")).unwrap()).unwrap();
        (path.file_stem().unwrap().to_string_lossy().into_owned(), std::fs::read(&path).unwrap(), expected)
    };
    let streams: Vec<_> = streams.map(read).collect();
    assert!(streams.len() >= 9, "{}", streams.len());
    streams
}

#[test]
fn every_chunk_has_its_fingerprint() {
    for (name, bytes, expected) in streams() {
        let mut decoder = Decoder::new(StreamLimits::default());
        let mut start = 0;
        for chunk in expected["chunks"].as_array().unwrap() {
            let number = |name: &str| chunk[name].as_u64().unwrap();
            let end = number("end") as usize;
            assert_eq!(decoder.update(&bytes[start..end]), Ok(1), "{name}");
            start = end;
            let part = decoder.part(number("stream") as usize).unwrap();
            let found = [part.level() as u64, part.triangle_count() as u64, part.vertex_count() as u64];
            assert_eq!(found, ["level", "triangles", "vertices"].map(number), "{name}");
            assert_eq!(u64::from(part.fingerprint()), number("fingerprint"), "{name} at {end}");
        }
        assert_eq!((start, decoder.offset()), (bytes.len(), bytes.len() as u64));
    }
}

/// Compares the CRC-32 of the index buffer with restarts (little-endian 32-bit integers) after each
/// chunk.
#[test]
fn every_chunk_has_its_strips() {
    let mut found: BTreeMap<String, Vec<u32>> = BTreeMap::new();
    for (name, bytes, expected) in streams() {
        let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
        let mut start = 0;
        for chunk in expected["chunks"].as_array().unwrap() {
            let end = chunk["end"].as_u64().unwrap() as usize;
            decoder.update(&bytes[start..end]).unwrap();
            start = end;
            let part = decoder.part(chunk["stream"].as_u64().unwrap() as usize).unwrap();
            let strips = part.strips().unwrap();
            verify(&part.mesh().unwrap(), &strips).unwrap();
            let indices = strips.to_indices::<u32>(Layout::Restart).unwrap();
            let index_bytes: Vec<u8> = indices.into_iter().flat_map(u32::to_le_bytes).collect();
            found.entry(name.clone()).or_default().push(crc32fast::hash(&index_bytes));
        }
    }
    let path = folder().join("strips.json");
    if std::env::var_os("TRISTRIP_BLESS").is_some_and(|v| v == "1") {
        let rows: Vec<String> = found.iter().map(|(name, list)| format!("  \"{name}\": {list:?}")).collect();
        std::fs::write(&path, format!("{{\n{}\n}}\n", rows.join(",\n"))).unwrap();
    }
    let expected: BTreeMap<String, Vec<u32>> = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(found, expected);
}
