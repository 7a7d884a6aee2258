//! Decodes arbitrary bytes as the transmission of paper 001, in pieces of any size. Also builds
//! strips and collapses from the bytes, encodes them, and draws each level as it is received.
#![no_main]

use tristrip::lod::Encoding;
use tristrip_fuzz::{Bytes, Model, model, sorted};
use tristrip_lab::wire::{WireDecoder, encode};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let piece = usize::from(data.first().copied().unwrap_or(0)) + 1;
    if let Some(stream) = data.get(1..) {
        any_bytes(stream, piece);
        // The same bytes after the signature, which random bytes rarely contain.
        any_bytes(&[&[0x89, b'P', b'S', 1], stream].concat(), piece);
    }
    let Some(Model { strips, sequence }) = model(&mut Bytes(data)) else { return };
    let positions = vec![[0.0; 3]; sequence.vertex_count()];
    for encoding in [Encoding::Naive, Encoding::Offsets] {
        let Ok(encoded) = encode(&strips, &sequence, &positions, encoding) else { continue };
        let mut decoder = WireDecoder::default();
        for piece in encoded.bytes.chunks(piece) {
            decoder.update(piece).expect("bytes of the encoder");
            let Some(level) = decoder.level() else { continue };
            let original = |t: [u32; 3]| t.map(|v| encoded.vertices[v as usize]);
            let drawn = sorted(decoder.strips().triangles().map(original));
            assert_eq!(drawn, sorted(sequence.drawn(level).expect("a level that arrived")));
        }
        assert!(decoder.is_complete());
        assert_eq!((decoder.level(), decoder.sizes()), (Some(sequence.len()), encoded.sizes));
    }
});

/// Decodes bytes in one piece and in several, with the same levels and bounded memory.
fn any_bytes(bytes: &[u8], piece: usize) {
    let (mut whole, mut pieces) = (WireDecoder::default(), WireDecoder::default());
    let result = whole.update(bytes);
    assert_eq!(result, bytes.chunks(piece).try_for_each(|piece| pieces.update(piece)));
    assert_eq!((whole.level(), whole.strips()), (pieces.level(), pieces.strips()));
    assert!(whole.memory() <= 64 * bytes.len() + 256, "{} for {}", whole.memory(), bytes.len());
    for level in (0..whole.level_count()).rev() {
        whole.set_level(level).expect("a level that arrived");
        let vertex_count = whole.positions().len();
        assert!(whole.strips().vertices().iter().all(|&v| (v as usize) < vertex_count));
    }
}
