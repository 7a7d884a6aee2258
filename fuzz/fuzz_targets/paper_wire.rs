//! Arbitrary bytes, decoded as the transmission of paper 001 in pieces of any size. The same bytes, read
//! as strips and collapses, are encoded, and each level is drawn as it arrives.
#![no_main]

use tristrip::lod::Encoding;
use tristrip_fuzz::{Bytes, Model, model, sorted};
use tristrip_lab::wire::{WireDecoder, encode};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let piece = usize::from(data.first().copied().unwrap_or(0)) + 1;
    if let Some(stream) = data.get(1..) {
        any_bytes(stream, piece);
        // The same after the signature, which is seldom found by chance.
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

/// Reads bytes at once and in pieces: the same levels, and memory that they justify.
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
