//! Malformed compressed buffer views: errors with locations, limits, and changed bytes.

use serde_json::{Value, json};
use tristrip_io::{Error, gltf};

use crate::compressed::{Compression, EXT, KHR, compress, ribbon};
use crate::gltf_documents::*;
use crate::random::random;

/// Returns the error of a compressed ribbon after a change of its JSON.
fn error_after(change: impl FnOnce(&mut Draft)) -> String {
    let views = [(0, Compression::attributes(12, 0)), (1, Compression::TRIANGLES)];
    let mut draft = compress(&ribbon(40), EXT, &views);
    change(&mut draft);
    gltf::read(draft.glb(), None).unwrap_err().to_string()
}

#[test]
fn errors_name_the_place() {
    let set = |view: usize, field: &'static str, value: Value| {
        error_after(|draft| draft.json["bufferViews"][view]["extensions"][EXT][field] = value)
    };
    let at = format!("bufferViews[0].extensions.{EXT}");
    assert_eq!(
        set(0, "mode", "POINTS".into()),
        format!("{at}.mode: found \"POINTS\", expected ATTRIBUTES, TRIANGLES or INDICES")
    );
    assert_eq!(
        set(0, "filter", "HEX".into()),
        format!("{at}.filter: found \"HEX\", expected NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL or COLOR")
    );
    assert_eq!(
        set(0, "filter", "QUATERNION".into()),
        format!("{at}.byteStride: found 12, expected 8 for this filter")
    );
    assert_eq!(
        set(0, "byteStride", 10.into()),
        format!("{at}.byteStride: found 10, expected a multiple of 4 from 4 to 256 for ATTRIBUTES")
    );
    assert_eq!(
        set(0, "count", 39.into()),
        "bufferViews[0].byteLength: found 480, expected 468, 39 elements of 12 bytes"
    );
    assert_eq!(
        set(0, "buffer", 7.into()),
        format!("{at}.buffer: found 7, expected less than 2, the number of buffers")
    );
    assert!(set(0, "byteOffset", 9000.into()).starts_with(&format!("{at}: found ")));
    assert_eq!(
        set(0, "buffer", 1.into()),
        format!("{at}.buffer: found 1, expected a buffer with data; buffers[1] is marked as a fallback")
    );
    assert!(set(1, "count", 115.into()).ends_with("found 115, expected a multiple of 3 for TRIANGLES"));
    assert!(set(1, "filter", "OCTAHEDRAL".into()).ends_with("expected \"NONE\" for indices"));
    assert_eq!(
        error_after(|draft| {
            draft.json["bufferViews"][0].as_object_mut().unwrap().remove("extensions");
        }),
        "bufferViews[0].buffer: found 1, expected a buffer with data; buffers[1] is marked as a fallback"
    );
    let length =
        |draft: &Draft| draft.json["bufferViews"][0]["extensions"][EXT]["byteLength"].as_u64().unwrap();
    let cut = error_after(|draft| {
        draft.json["bufferViews"][0]["extensions"][EXT]["byteLength"] = (length(draft) - 1).into();
    });
    assert!(
        cut.starts_with(&format!("{at}: found ")) && cut.ends_with("expected 40 elements of 12 bytes"),
        "{cut}"
    );
    let header = error_after(|draft| draft.bin[0] = 0x50);
    assert!(header.contains("header is invalid"), "{header}");
}

#[test]
fn counts_that_no_byte_pays_for_are_refused_at_once() {
    for (mode, stride, header, least) in [
        ("ATTRIBUTES", 4, 0xa0, 1 + 32 + 4 * 4 * (1_u64 << 24)),
        ("ATTRIBUTES", 4, 0xa1, 1 + 24 + (1 << 24)),
        ("TRIANGLES", 4, 0xe1, 17 + (1 << 32) / 3),
        ("INDICES", 4, 0xd1, 5 + (1 << 32)),
    ] {
        let count = if mode == "TRIANGLES" { (1_u64 << 32) / 3 * 3 } else { 1 << 32 };
        let error = error_after(|draft| {
            draft.bin[0] = header;
            draft.json["bufferViews"][0]["extensions"][EXT] = json!({
                "buffer": 0, "byteLength": 20, "byteStride": stride, "count": count, "mode": mode,
            });
        });
        let found = format!("bufferViews[0].extensions.{EXT}.count: found {count}, ");
        let expected = format!("expected a count that fits into 20 bytes; this count needs at least {least}");
        assert_eq!(error, found + &expected);
    }
    let error = error_after(|draft| {
        draft.json["bufferViews"][0]["extensions"][EXT]["count"] = u64::MAX.into();
    });
    assert!(error.contains("expected a count that"), "{error}");
}

#[test]
fn the_same_bytes_again_and_again_are_limited() {
    let mut draft = ribbon(3);
    let view = draft.view(&vec![0; 256 << 10]);
    let mut draft = compress(&draft, KHR, &[(view, Compression::attributes(256, 1))]);
    let twice = draft.json["bufferViews"][view].clone();
    for _ in 0..40 {
        push(&mut draft.json["bufferViews"], twice.clone());
    }
    let error = gltf::read(draft.glb(), None).unwrap_err();
    let Error::LimitExceeded { at, found, limit } = error else { unreachable!("{error}") };
    assert!(at.ends_with(&format!("{KHR}, bytes decoded so far")), "{at}");
    assert!(found > 8 << 20 && (8 << 20..9 << 20).contains(&limit), "{found}, {limit}");
}

#[test]
fn changed_bytes_never_panic() {
    let mut random = random();
    let mut refused = 0;
    for how in [
        Compression::attributes(12, 0),
        Compression::attributes(12, 1),
        Compression { mode: "INDICES", stride: 4, ..Compression::TRIANGLES },
        Compression { mode: "TRIANGLES", stride: 4, ..Compression::TRIANGLES },
        Compression { filter: Some("OCTAHEDRAL"), ..Compression::attributes(4, 0) },
        Compression { filter: Some("QUATERNION"), ..Compression::attributes(8, 1) },
        Compression { filter: Some("COLOR"), ..Compression::attributes(8, 1) },
        Compression { filter: Some("EXPONENTIAL"), ..Compression::attributes(4, 0) },
    ] {
        let mut draft = ribbon(3);
        let bytes: Vec<u8> =
            (0..24 * 90).map(|i: usize| if i % 4 < 2 { (i / 24) as u8 } else { 0 }).collect();
        let view = draft.view(&bytes);
        let draft = compress(&draft, KHR, &[(view, how)]);
        let start =
            draft.json["bufferViews"][view]["extensions"][KHR]["byteOffset"].as_u64().unwrap() as usize;
        assert!(gltf::read(draft.glb(), None).is_ok());
        for _ in 0..1000 {
            let mut changed = Draft { json: draft.json.clone(), bin: draft.bin.clone() };
            for _ in 0..=random(4) {
                let at = start + random(changed.bin.len() - start);
                changed.bin[at] = random(256) as u8;
            }
            let length = &mut changed.json["bufferViews"][view]["extensions"][KHR]["byteLength"];
            *length = (length.as_u64().unwrap() - [0, 0, 1, 30][random(4)]).into();
            refused += usize::from(gltf::read(changed.glb(), None).is_err());
        }
    }
    assert!(refused > 2000, "{refused}");
}
