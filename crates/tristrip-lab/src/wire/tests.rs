use std::sync::Arc;

use proptest::prelude::*;

use super::{Encoded, WireDecoder, encode};
use crate::samples::samples;
use tristrip::Error;
use tristrip::Strips;
use tristrip::lod::{Encoding, Filter, LevelCursor, ProgressiveStrips};
use tristrip::random::Random;
use tristrip::{CollapseSequence, Rename};

const ENCODINGS: [Encoding; 2] = [Encoding::Naive, Encoding::Offsets];

fn strips(strips: &[&[u32]]) -> Strips {
    let mut all = Strips::default();
    strips.iter().for_each(|strip| all.push(strip));
    all
}

fn positions(count: usize) -> Vec<[f32; 3]> {
    (0..count).map(|i| [i as f32, 0.5, -(i as f32)]).collect()
}

fn encoded(strips: &Strips, collapses: &[&[(u32, u32)]]) -> Encoded {
    let rename = |&(removed, kept): &(u32, u32)| Rename { removed, kept };
    let renames: Vec<Vec<Rename>> = collapses.iter().map(|c| c.iter().map(rename).collect()).collect();
    let count = strips.vertices().iter().max().map_or(0, |&v| v as usize + 1);
    let renames = renames.iter().map(|r| (&r[..], 0.0));
    let sequence = CollapseSequence::from_collapses(count, strips.to_list(), renames).unwrap();
    encode(strips, &sequence, &positions(count), Encoding::Offsets).unwrap()
}

/// The bytes of the module's example: base mesh 0 1 2 ◁ ◁ 3 and two records, at bytes 80 and 94.
fn head() -> Encoded {
    encoded(&strips(&[&[0, 1, 2, 3, 4, 5]]), &[&[(4, 3)], &[(3, 2)]])
}

fn decoded(bytes: &[u8]) -> Result<WireDecoder, Error> {
    let mut decoder = WireDecoder::default();
    decoder.update(bytes).map(|()| decoder)
}

/// Formats bytes by section: positions as their first coordinate, everything else as hexadecimal
/// digits.
fn text(encoded: &Encoded) -> String {
    let decoder = decoded(&encoded.bytes).unwrap();
    let header = decoder.header().unwrap();
    let hex = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().concat();
    let position = |bytes: &[u8]| f32::from_le_bytes(*bytes.as_array().unwrap()).to_string();
    let (head, rest) = encoded.bytes.split_at(20);
    let (base, rest) = rest.split_at(12 * header.base_vertex_count as usize);
    let (map, mut rest) = rest.split_at(header.entry_bytes() * header.entry_count as usize);
    let words = |bytes: &[u8], size| bytes.chunks(size).map(hex).collect::<Vec<_>>().join(" ");
    let base = base.chunks(12).map(|p| position(&p[..4])).collect::<Vec<_>>().join(" ");
    let mut lines = vec![words(head, 4), base, words(map, header.entry_bytes())];
    while !rest.is_empty() {
        let (vertex, slots) = rest.split_at(12);
        let size = header.slot_bytes();
        let count = slots.chunks(size).position(|slot| slot[0] & 1 == 1).unwrap() + 1;
        lines.push(format!("{}: {}", position(&vertex[..4]), words(&slots[..size * count], size)));
        rest = &slots[size * count..];
    }
    lines.join("\n")
}

#[test]
fn the_bytes_of_the_head() {
    let head = head();
    let expected = "89505301 04000000 06000000 02000000 02000000\n\
                    0 1 2 5\n\
                    0000 0100 0200 fcff fcff 0300\n\
                    3: 0700\n\
                    4: 0900";
    assert_eq!(text(&head), expected);
    assert_eq!(head.vertices, [0, 1, 2, 5, 3, 4]);
}

#[test]
fn restarts_swaps_disjoint_and_closed_vertices() {
    // The swap 1 is R−2. Vertex 6 is closed: its slot next to 7 becomes R+1. The other slot
    // contains 7, and is disjoint, like that of strip 1.
    let strips = strips(&[&[0, 1, 2, 1, 3], &[6, 2, 3, 4, 6, 7], &[8, 6, 9]]);
    let expected = "89505301 08000000 10000000 01000000 01000000\n\
                    0 1 2 3 7 4 8 9\n\
                    0000 0100 0200 fbff 0300 ffff 0400 0200 0300 0500 fdff 0400 ffff 0600 0400 0700\n\
                    6: 0c00 1400 1d00";
    assert_eq!(text(&encoded(&strips, &[&[(6, 7)]])), expected);
}

#[test]
fn a_split_may_restore_several_vertices() {
    // 3 and 5 are renamed together, then 4.
    let strips = strips(&[&[0, 1, 2, 3], &[4, 5, 6]]);
    let encoded = encoded(&strips, &[&[(3, 2), (5, 6)], &[(4, 6)]]);
    let expected = "89505301 04000000 08000000 02000000 03000000\n\
                    0 1 2 6\n\
                    0000 0100 0200 fcff ffff fdff fdff 0300\n\
                    4: 0b00\n\
                    3: 0600 fdff\n\
                    5: 0d00";
    assert_eq!(text(&encoded), expected);
    let mut decoder = decoded(&encoded.bytes).unwrap();
    assert_eq!((decoder.level(), decoder.positions().len()), (Some(2), 7));
    decoder.set_level(1).unwrap();
    assert_eq!(decoder.positions().len(), 5);
}

#[test]
fn a_vertex_without_slots_is_a_level_of_its_own() {
    // The strips draw one of the two triangles of the sequence.
    let rename = [Rename { removed: 3, kept: 2 }];
    let sequence = CollapseSequence::from_collapses(4, vec![0, 1, 2, 2, 1, 3], [(&rename[..], 0.0)]).unwrap();
    let encoded = encode(&strips(&[&[0, 1, 2]]), &sequence, &positions(4), Encoding::Offsets).unwrap();
    assert!(text(&encoded).ends_with("\n3: ffff"), "{}", text(&encoded));
    assert_eq!(decoded(&encoded.bytes).unwrap().level(), Some(1));
}

#[test]
fn large_maps_have_wide_numbers() {
    // A zigzag of 70,000 vertices. The last two collapse.
    let count = 70_000;
    let zigzag: Vec<u32> = (0..count).collect();
    let collapses: [&[(u32, u32)]; 2] = [&[(count - 1, count - 2)], &[(count - 2, count - 3)]];
    let encoded = encoded(&strips(&[&zigzag]), &collapses);
    let mut decoder = decoded(&encoded.bytes).unwrap();
    let header = decoder.header().unwrap();
    assert_eq!((header.entry_bytes(), header.slot_bytes()), (3, 3));
    assert_eq!(encoded.sizes.record_bytes, 2 * (12 + 3));
    assert_eq!(encoded.bytes.len(), 20 + 12 * 69_998 + 3 * 70_000 + 30);
    assert_eq!(decoder.strips().vertices(), zigzag);
    decoder.set_level(0).unwrap();
    assert_eq!(decoder.strips().vertices(), &zigzag[..69_998]);
}

#[test]
fn numbers_are_as_narrow_as_they_can_be() {
    for (count, entry_bytes) in [(65_531, 2), (65_532, 3)] {
        let zigzag: Vec<u32> = (0..count).collect();
        let encoded = encoded(&strips(&[&zigzag]), &[]);
        let mut decoder = decoded(&encoded.bytes).unwrap();
        assert_eq!(decoder.header().unwrap().entry_bytes(), entry_bytes);
        assert_eq!(decoder.strips().vertices(), zigzag);
    }
    for (count, slot_bytes) in [(32_766, 2), (32_767, 3)] {
        let zigzag: Vec<u32> = (0..count).collect();
        let encoded = encoded(&strips(&[&zigzag]), &[&[(count - 1, count - 2)]]);
        let mut decoder = decoded(&encoded.bytes).unwrap();
        assert_eq!(decoder.header().unwrap().slot_bytes(), slot_bytes);
        assert_eq!(decoder.strips().vertices(), zigzag);
    }
}

#[test]
fn the_widest_numbers_have_four_bytes() {
    let widths = |base_vertices: u32, entries: u32| {
        let counts = [base_vertices, entries, 0, 0].map(u32::to_le_bytes);
        let header =
            decoded(&[&[0x89, b'P', b'S', 1][..], counts.as_flattened()].concat()).unwrap().header().unwrap();
        (header.entry_bytes(), header.slot_bytes())
    };
    assert_eq!(widths(16_777_211, 8_388_606), (3, 3));
    assert_eq!(widths(16_777_212, 8_388_607), (4, 4));
    assert_eq!(widths(u32::MAX - 4, (1 << 31) - 2), (4, 4));
}

#[test]
fn an_empty_mesh_is_complete_after_its_header() {
    let encoded = encoded(&Strips::default(), &[]);
    let mut decoder = decoded(&encoded.bytes).unwrap();
    assert_eq!((encoded.bytes.len(), decoder.level(), decoder.is_complete()), (20, Some(0), true));
    assert!(decoder.strips().is_empty() && decoder.positions().is_empty());
}

#[test]
fn what_cannot_be_encoded_is_refused() {
    let strips = strips(&[&[0, 1, 2]]);
    let sequence = |collapses: &[&[Rename]]| {
        let collapses = collapses.iter().map(|&renames| (renames, 0.0));
        CollapseSequence::from_collapses(3, vec![0, 1, 2], collapses).unwrap()
    };
    let error = |sequence: &CollapseSequence, positions: &[[f32; 3]]| {
        encode(&strips, sequence, positions, Encoding::Offsets).unwrap_err().to_string()
    };
    let found = error(&sequence(&[]), &positions(4));
    assert_eq!(found, "attribute `positions`: number of values: found 4, expected 3 (one per vertex)");
    let found = error(&sequence(&[]), &[[0.0; 3], [0.0, f32::NAN, 0.0], [0.0; 3]]);
    assert_eq!(found, "vertex 1: found coordinate NaN, expected a finite number");
    let found = error(&sequence(&[&[]]), &positions(3));
    let expected =
        "parameter `collapses`: found none in the collapse to level 0, expected a renamed vertex or more";
    assert_eq!(found, expected);
}

/// Each kind of damage to the bytes of the example, with its error, and the levels that arrived
/// before.
#[test]
fn damaged_bytes_are_errors_with_their_position() {
    let nan = f32::NAN.to_le_bytes();
    let cases: &[(usize, &[u8], &str, usize)] = &[
        (0, b"ply\n", "byte 0: found [70, 6C, 79, 0A], expected the signature [89, 50, 53, 01]", 0),
        (8, &[0xFF; 4], "byte 8: found 4294967295 entries, expected at most 2147483646", 0),
        (
            12,
            &[3],
            "byte 16: found 2 restored vertices of 3 splits, expected one per split or more, at most 4294967287",
            0,
        ),
        (
            12,
            &[0],
            "byte 16: found 2 restored vertices of 0 splits, expected one per split or more, at most 4294967287",
            0,
        ),
        (
            16,
            &[0xFF; 4],
            "byte 16: found 4294967295 restored vertices of 2 splits, expected one per split or more, at most 4294967287",
            0,
        ),
        (24, &nan, "byte 20: found the coordinate NaN, expected a finite number", 0),
        (70, &[4], "byte 70: found entry 4, expected less than 4, a symbol or a restart", 0),
        // R−2 at the second slot; R+2 at the last but one; R−1 and R+1 of each other; R−1 after a
        // restart.
        (70, &[0xFB, 0xFF], "byte 70: found a symbol, expected one that leads to a vertex of its strip", 0),
        (76, &[0xFE, 0xFF], "byte 76: found a symbol, expected one that leads to a vertex of its strip", 0),
        (72, &[0xFD, 0xFF], "byte 72: found a symbol, expected one that leads to a vertex of its strip", 0),
        (72, &[0xFF, 0xFF], "byte 74: found a symbol, expected one that leads to a vertex of its strip", 0),
        (92, &[13], "byte 92: found slot 6, expected less than 6", 1),
        // Another record of the first split leaves none for the second one.
        (
            92,
            &[0xFD, 0xFF],
            "byte 92: found another record of a split, of 1 that are left, expected one or more per split, of 2",
            1,
        ),
        // A slot that is not the last one. The next bytes are those of a position.
        (92, &[6], "byte 94: found slot 0, expected more than 3", 1),
        // A reserved slot that is not the last one.
        (92, &[0xFE, 0xFF], "byte 92: found slot 32767, expected less than 6", 1),
    ];
    let head = head().bytes;
    for &(at, damage, expected, levels) in cases {
        let mut bytes = head.clone();
        bytes[at..at + damage.len()].copy_from_slice(damage);
        let mut decoder = WireDecoder::default();
        let error = decoder.update(&bytes).unwrap_err();
        assert_eq!((error.to_string().as_str(), decoder.level_count()), (expected, levels));
        // The error persists, and is the same in pieces.
        assert_eq!(decoder.update(&head), Err(error.clone()));
        let mut decoder = WireDecoder::default();
        assert_eq!(bytes.iter().find_map(|&byte| decoder.update(&[byte]).err()), Some(error));
    }
    let mut decoder = decoded(&head).unwrap();
    let error = decoder.update(&[0]).unwrap_err().to_string();
    assert_eq!(error, "byte 108: found another byte, expected the end");
    assert_eq!((decoder.level(), decoder.is_complete()), (Some(2), true));
}

#[test]
fn splits_and_vertices_are_counted() {
    // Three vertices for two splits: the first or the last split restores two of them.
    let mut bytes = head().bytes;
    bytes[16] = 3;
    let error = decoded(&bytes).unwrap_err().to_string();
    let expected =
        "byte 106: found the last split, 1 vertex before the last one, expected another record of the split";
    assert_eq!(error, expected);
    // A record must not write to a restart.
    let two = encoded(&strips(&[&[0, 1, 2], &[3, 4, 5, 6]]), &[&[(6, 5)]]);
    let mut bytes = two.bytes;
    let last = bytes.len() - 2;
    assert_eq!(bytes[last..], [15, 0]);
    bytes[last] = 7;
    let error = decoded(&bytes).unwrap_err().to_string();
    assert!(error.ends_with("found slot 3, expected one of a vertex, not of a restart"), "{error}");
}

#[test]
fn hostile_counts_take_no_memory() {
    let counts = [0xFFFF_FF00_u32, 0x7FFF_FFFE, 1, 1].map(u32::to_le_bytes);
    let mut decoder = decoded(&[&[0x89, b'P', b'S', 1][..], counts.as_flattened()].concat()).unwrap();
    assert!(decoder.memory() < 100 && decoder.strips().is_empty() && decoder.level().is_none());
    // One entry of the map, and the bytes of an endless split: memory follows the bytes.
    let start = |splits: u32| {
        let header = [1, 3, splits, 1 << 20].map(u32::to_le_bytes);
        let base = [&[0; 12][..], &[0; 6]].concat();
        decoded(&[&[0x89, b'P', b'S', 1][..], header.as_flattened(), &base].concat()).unwrap()
    };
    let mut decoder = start(1);
    let record = [&[0; 12][..], &[0, 0, 2, 0, 4, 0, 0xFD, 0xFF]].concat();
    (0..1000).for_each(|_| decoder.update(&record).unwrap());
    assert_eq!(decoder.level(), Some(0));
    assert!(decoder.memory() < 3 * 1000 * record.len(), "{}", decoder.memory());
    // Splits that repeatedly write the same slots stop at a limit of 256 slots per entry.
    let mut decoder = start(1 << 20);
    let record = [&[0; 12][..], &[0, 0, 2, 0, 5, 0]].concat();
    let result = (0..1000).try_for_each(|_| decoder.update(&record));
    let limit = Error::LimitExceeded { what: "slots renamed by all collapses", found: 771, limit: 768 };
    assert_eq!(result, Err(limit));
    assert!((0..=256).all(|level| decoder.set_level(level).is_ok() && decoder.strips().is_empty()));
}

/// Draws the strips of a model, with the indices of sent vertices.
fn drawn(model: &mut impl LevelCursor, encoded: &Encoded) -> Strips {
    let mut number_of = vec![u32::MAX; 100];
    (0..).zip(&encoded.vertices).for_each(|(number, &vertex)| number_of[vertex as usize] = number);
    let mut drawn = Strips::default();
    for strip in model.strips().iter() {
        let numbers: Vec<u32> = strip.iter().map(|&vertex| number_of[vertex as usize]).collect();
        drawn.push(&numbers);
    }
    drawn
}

proptest! {
    #[test]
    fn every_prefix_draws_the_levels_that_arrived(sample in samples(), seed in any::<u64>(), filter in 0..4_usize) {
        let (sequence, random) = (&sample.sequence, &mut Random::new(seed));
        let (places, filter) = (positions(sequence.vertex_count()), Filter::ALL[filter]);
        for encoding in ENCODINGS {
            let model = ProgressiveStrips::new(&sample.strips, sequence, encoding).unwrap().with_filter(filter);
            let mut cursor = Arc::new(model).cursor();
            let encoded = encode(&sample.strips, sequence, &places, encoding).unwrap();
            prop_assert_eq!(encoded.sizes.total_bytes(), encoded.bytes.len() as u64);

            // 1. In pieces of any size.
            let mut decoder = WireDecoder::default().with_filter(filter);
            let mut rest = &encoded.bytes[..];
            let mut levels_seen = 0;
            while !rest.is_empty() {
                let (piece, after) = rest.split_at(1 + random.below(rest.len().min(40)));
                decoder.update(piece).unwrap();
                rest = after;
                let Some(level) = decoder.level() else { continue };
                levels_seen += 1;
                cursor.set_level(level).unwrap();
                prop_assert_eq!(decoder.strips(), &drawn(&mut cursor, &encoded));
                let sent = encoded.vertices.iter().map(|&v| places[v as usize]);
                prop_assert_eq!(decoder.positions().to_vec(), sent.take(decoder.positions().len()).collect::<Vec<_>>());
            }
            prop_assert!(levels_seen > 0 && decoder.is_complete());
            prop_assert_eq!(decoder.sizes(), encoded.sizes);

            // 2. All levels, by steps and by jumps.
            let steps = (0..=sequence.len()).rev().chain(0..=sequence.len());
            let jumps: Vec<usize> = (0..9).map(|_| random.below(sequence.len() + 1)).collect();
            for level in steps.chain(jumps) {
                decoder.set_level(level).unwrap();
                cursor.set_level(level).unwrap();
                prop_assert_eq!(decoder.strips(), &drawn(&mut cursor, &encoded));
                let used = decoder.positions().len() as u32;
                prop_assert!(decoder.strips().vertices().iter().all(|&v| v < used));
            }
            prop_assert!(decoder.set_level(sequence.len() + 1).is_err());
        }
    }

    /// A selected level does not change while others arrive; the highest one is followed.
    #[test]
    fn chosen_levels_stay_during_updates(sample in samples(), seed in any::<u64>()) {
        let random = &mut Random::new(seed);
        let places = positions(sample.sequence.vertex_count());
        let encoded = encode(&sample.strips, &sample.sequence, &places, Encoding::Offsets).unwrap();
        let mut whole = decoded(&encoded.bytes).unwrap();
        let mut decoder = WireDecoder::default();
        let mut chosen = None;
        for piece in encoded.bytes.chunks(1 + random.below(60)) {
            decoder.update(piece).unwrap();
            let highest = decoder.level_count().checked_sub(1);
            prop_assert_eq!(decoder.level(), chosen.or(highest));
            let Some(highest) = highest else { continue };
            whole.set_level(decoder.level().unwrap()).unwrap();
            prop_assert_eq!(decoder.positions(), whole.positions());
            prop_assert_eq!(decoder.strips(), whole.strips());
            if random.below(2) == 0 {
                let level = random.below(highest + 1);
                decoder.set_level(level).unwrap();
                chosen = (level < highest).then_some(level);
            }
        }
    }

    /// A record takes 12 + 2 u bytes: equation 2.
    #[test]
    fn records_have_the_published_size(sample in samples()) {
        let places = positions(sample.sequence.vertex_count());
        for encoding in ENCODINGS {
            let model = ProgressiveStrips::new(&sample.strips, &sample.sequence, encoding).unwrap();
            let encoded = encode(&sample.strips, &sample.sequence, &places, encoding).unwrap();
            let bytes = |level| {
                let restored = sample.sequence.collapse(level).unwrap().renames.len();
                12 * restored + 2 * model.slot_count(level) + 2 * (restored - 1)
            };
            let expected: usize = (0..sample.sequence.len()).map(bytes).sum();
            // A vertex whose slots all refer to others has none of its own.
            let without_slots = (0..sample.sequence.len())
                .filter(|&level| model.split(level).unwrap().last().is_some_and(|update| update.slots.is_empty()))
                .count();
            prop_assert_eq!(encoded.sizes.record_bytes, (expected + 2 * without_slots) as u64);
        }
    }

    #[test]
    fn damaged_bytes_do_not_panic(sample in samples(), at in any::<usize>(), bits in 1..=u8::MAX, piece in 1..50_usize) {
        let places = positions(sample.sequence.vertex_count());
        let mut bytes = encode(&sample.strips, &sample.sequence, &places, Encoding::Offsets).unwrap().bytes;
        let at = at % bytes.len();
        bytes[at] ^= bits;
        let (mut whole, mut pieces) = (WireDecoder::default(), WireDecoder::default());
        let result = whole.update(&bytes);
        let in_pieces = bytes.chunks(piece).try_for_each(|piece| pieces.update(piece));
        prop_assert_eq!(&result, &in_pieces);
        prop_assert_eq!(whole.strips(), pieces.strips());
        for level in (0..whole.level_count()).rev() {
            whole.set_level(level).unwrap();
            let used = whole.positions().len() as u32;
            prop_assert!(whole.strips().vertices().iter().all(|&v| v < used));
        }
        let is_signature_wrong = result.is_err_and(|error| error.to_string().starts_with("byte 0: "));
        prop_assert_eq!(is_signature_wrong, at < 4);
        // The levels before the damage are unchanged.
        bytes[at] ^= bits;
        let mut before = decoded(&bytes[..at]).unwrap();
        for level in 0..before.level_count() {
            whole.set_level(level).unwrap();
            before.set_level(level).unwrap();
            prop_assert_eq!(whole.positions(), before.positions());
            prop_assert_eq!(whole.strips(), before.strips());
        }
    }
}
