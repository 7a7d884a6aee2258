//! Decodes arbitrary bytes as a stream in pieces of any size, unchanged and with corrected
//! checksums; and the stream of a mesh with changed bytes. The result is an error, or meshes with
//! valid indices that are the same in one piece and in several.
#![no_main]

use tristrip::simplify::{SimplifyOptions, refinement_batches};
use tristrip::stream::{Decoder, StreamLimits, StreamOptions, encode};
use tristrip_fuzz::{Bytes, mesh, with_attributes};

/// Few triangles, so time and memory are proportional to the bytes.
const LIMITS: StreamLimits =
    StreamLimits { meshes: 4, triangles: 10_000, chunk_bytes: 1 << 20, corners: 1 << 20 };

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let piece = usize::from(data.first().copied().unwrap_or(0)) + 1;
    check(data, piece);
    check(&sealed(data), piece);

    let mut bytes = Bytes(data);
    let changes: Vec<[u32; 2]> = (0..bytes.next() % 8).map(|_| [0; 2].map(|_| bytes.word())).collect();
    let attributes = bytes.next();
    let mesh = with_attributes(mesh(&mut bytes), attributes);
    let triangles = tristrip::PreparedFaces::new(&mesh, true).faces().fans().into_owned();
    let Ok(batches) = refinement_batches(&mesh, triangles, &SimplifyOptions::default()) else { return };
    let options = StreamOptions::default();
    let Ok(stream) = encode(&mesh, &batches.sequence, &batches.level_ends, 0, &options) else { return };
    let mut changed = stream.bytes();
    let decoder = check(&changed, piece);
    let part = decoder.part(0).expect("a base mesh");
    assert_eq!((part.level(), part.triangle_count()), (part.full_level(), part.full_triangle_count()));
    for [at, value] in changes {
        let length = changed.len();
        changed[at as usize % length] = value as u8;
    }
    check(&sealed(&changed), piece);
});

/// Decodes bytes in one piece and in several.
fn check(bytes: &[u8], piece: usize) -> Decoder {
    let (mut whole, mut pieces) = (Decoder::new(LIMITS), Decoder::new(LIMITS));
    let result = whole.update(bytes).map(|_| ());
    assert_eq!(result, bytes.chunks(piece).try_for_each(|piece| pieces.update(piece).map(|_| ())));
    assert_eq!((whole.chunk_count(), whole.offset()), (pieces.chunk_count(), pieces.offset()));
    for (part, other) in whole.parts().zip(pieces.parts()) {
        assert_eq!(part.fingerprint(), other.fingerprint());
        let vertex_count = part.vertex_count();
        assert!(part.triangles().iter().all(|&v| (v as usize) < vertex_count));
        let _ = (part.mesh(), part.sequence().map(|sequence| sequence.check()));
    }
    // A split that exceeds the limit by one adds two triangles.
    assert!(whole.parts().map(|part| part.triangle_count()).sum::<usize>() <= LIMITS.triangles + 2);
    whole
}

/// Corrects the checksum of each complete chunk.
fn sealed(data: &[u8]) -> Vec<u8> {
    let (mut bytes, mut at) = (data.to_vec(), 0);
    while let Some((head, length)) = head(&bytes[at..]) {
        let checksum = at + head;
        let Some(end) = (checksum + 4).checked_add(length).filter(|&end| end <= bytes.len()) else { break };
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&bytes[at..checksum]);
        hasher.update(&bytes[checksum + 4..end]);
        bytes[checksum..checksum + 4].copy_from_slice(&hasher.finalize().to_le_bytes());
        at = end;
    }
    bytes
}

/// Returns the size of a chunk's header before its checksum, and the length of its payload.
fn head(bytes: &[u8]) -> Option<(usize, usize)> {
    let (mut at, mut payload) = (0, 0);
    for number in 0..5 {
        let length = bytes[at..].iter().take(5).position(|&byte| byte < 0x80)? + 1;
        if number == 1 {
            payload =
                bytes[at..at + length].iter().rev().fold(0, |sum, &byte| sum << 7 | usize::from(byte & 0x7F));
        }
        at += length;
    }
    (bytes.len() >= at + 8).then_some((at + 4, payload))
}
