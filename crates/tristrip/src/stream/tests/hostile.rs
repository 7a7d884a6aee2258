use std::sync::Arc;

use super::*;
use crate::lod::LevelModel;
use crate::mesh::is_degenerate;
use crate::random::Random;
use crate::stream::StreamError;
use crate::stream::chunk::ChunkHead;
use crate::stream::samples::{chunks_of, sealed};

/// Returns two meshes in small chunks, one of them with attributes.
fn bytes() -> Vec<u8> {
    let first = stream_of(&with_attributes(4, 4), 0, &small_chunks()).1;
    let second = stream_of(&grid(5, 3), 1, &small_chunks()).1;
    [first.bytes(), second.bytes()].concat()
}

fn message(bytes: &[u8], limits: StreamLimits) -> (Decoder, String) {
    let mut decoder = Decoder::new(limits);
    let fault: StreamError = decoder.update(bytes).unwrap_err();
    assert_eq!(decoder.update(&[]), Err(fault.clone()));
    (decoder, fault.to_string())
}

#[test]
fn a_stream_may_end_at_any_byte() {
    let bytes = bytes();
    let chunks = chunks_of(&bytes);
    let mut ends = Vec::new();
    for count in 1..=chunks.len() {
        ends.push(sealed(&chunks[..count]).len());
    }
    assert_eq!(ends.last(), Some(&bytes.len()));
    let mut states = vec![Vec::new()];
    for &end in &ends {
        states.push(fingerprints(&decoded(&bytes[..end])));
    }
    for length in 0..bytes.len() {
        let mut decoder = Decoder::new(StreamLimits::default());
        let count = decoder.update(&bytes[..length]).unwrap();
        assert_eq!(count, ends.iter().filter(|&&end| end <= length).count());
        assert_eq!(fingerprints(&decoder), states[count]);
        // Decoding can resume from there.
        if length % 7 == 0 {
            decoder.update(&bytes[length..]).unwrap();
            assert_eq!(fingerprints(&decoder), states[chunks.len()]);
        }
    }
}

#[test]
fn damage_is_noticed_and_what_came_before_stays() {
    let bytes = bytes();
    let chunks = chunks_of(&bytes);
    for at in 0..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        let mut decoder = Decoder::new(StreamLimits::default());
        let result = decoder.update(&damaged);
        let count = decoder.chunk_count();
        let before = sealed(&chunks[..count]);
        assert!(before.len() <= at, "{at}");
        // An increased length can only make the chunk incomplete.
        assert!(result.is_err() || count < chunks.len());
        assert_eq!(fingerprints(&decoder), fingerprints(&decoded(&before)));
        assert_eq!(decoder.offset(), before.len() as u64);
    }
}

#[test]
fn faults_say_where_and_what() {
    let bytes = bytes();
    let mut damaged = bytes.clone();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    let chunks = chunks_of(&bytes);
    let start = sealed(&chunks[..chunks.len() - 1]).len();
    let (_, found) = message(&damaged, StreamLimits::default());
    assert!(
        found.starts_with(&format!("chunk {} at byte {start}: found checksum ", chunks.len() - 1)),
        "{found}"
    );
    let (_, found) = message(&[0xFF; 40], StreamLimits::default());
    assert_eq!(found, "chunk 0 at byte 0: found a number of more than 32 bits, expected the head of a chunk");
    // A refinement without its base mesh.
    let (_, found) = message(&sealed(&chunks[1..2]), StreamLimits::default());
    assert!(found.starts_with("chunk 0 at byte 0: found "), "{found}");
}

#[test]
fn limits_are_respected() {
    let bytes = bytes();
    let default = StreamLimits::default();
    let all: Vec<usize> = decoded(&bytes).parts().map(StreamPart::triangle_count).collect();
    assert_eq!(all, [32, 30]);
    let just = StreamLimits { triangles: 62, meshes: 2, ..default };
    Decoder::new(just).update(&bytes).unwrap();

    let (decoder, found) = message(&bytes, StreamLimits { triangles: 61, ..default });
    assert!(found.ends_with("found 30 triangles, expected at most 29"), "{found}");
    assert!(decoder.parts().map(StreamPart::triangle_count).sum::<usize>() < 62);
    let (decoder, found) = message(&bytes, StreamLimits { meshes: 1, ..default });
    assert!(found.ends_with("found mesh 1, expected a number below 1"), "{found}");
    assert_eq!(decoder.parts().count(), 1);
    // A thousand visits in a chunk that only codes that nothing is split.
    let chunks = chunks_of(&bytes);
    // The largest number below the first range.
    let mut payload = vec![0xFF; 50];
    payload[3] = 0xFE;
    let idle = [chunks[0].clone(), (ChunkHead { visits: 1000, ..chunks[0].0 }, payload)];
    let (_, found) = message(&sealed(&idle), StreamLimits { corners: 100, ..default });
    assert!(found.ends_with("corners around vertices that are visited, expected at most 100"), "{found}");
    // Memory is reserved for the triangles that a head declares, but not for more than the limit.
    let (_, stream) = stream_of(&grid(40, 40), 0, &small_chunks());
    let allowed = 2 * stream.chunks[0].triangles as usize;
    let (decoder, _) = message(&stream.bytes(), StreamLimits { triangles: allowed, ..default });
    let part = decoder.part(0).unwrap();
    assert!(part.full_triangle_count() == 3200 && allowed < 1600, "{allowed}");
    assert!(part.surface().capacity() <= 2 * allowed, "{}", part.surface().capacity());
    // A chunk is rejected before its bytes have arrived.
    let base = &chunks_of(&bytes)[0];
    let length = base.1.len();
    let limits = StreamLimits { chunk_bytes: length - 1, ..default };
    let (_, found) = message(&bytes[..40], limits);
    assert!(found.ends_with(&format!("found {length} bytes, expected at most {}", length - 1)), "{found}");
    Decoder::new(StreamLimits { chunk_bytes: length.max(100), ..default }).update(&bytes).unwrap();
}

/// Changes some chunks at random. Lengths and checksums are correct.
fn mutated(random: &mut Random, chunks: &[(ChunkHead, Vec<u8>)]) -> Vec<u8> {
    let mut chunks = chunks.to_vec();
    for _ in 0..=random.below(3) {
        let count = chunks.len();
        let at = random.below(count);
        let (head, payload) = &mut chunks[at];
        let length = payload.len().max(1);
        let number = if random.coin() {
            random.below(300) as u32
        } else {
            random.next_u64() as u32 >> random.below(32)
        };
        match random.below(14) {
            0 => head.stream = random.below(3) as u32,
            1 => head.visits = number,
            2 => head.level = number,
            3 => head.triangles = number,
            4 => head.error = f32::from_bits(random.next_u64() as u32),
            5 => payload.truncate(random.below(length)),
            6 => payload.extend([0xFF; 9]),
            7 => {
                payload.iter_mut().skip(random.below(length)).for_each(|byte| *byte = random.next_u64() as u8)
            }
            8 => payload.iter_mut().skip(random.below(length)).for_each(|byte| *byte = 0),
            9 => {
                let other = random.below(count);
                chunks.swap(at, other);
            }
            _ => {
                if let Some(byte) = payload.get_mut(random.below(length)) {
                    *byte =
                        if random.coin() { random.next_u64() as u8 } else { *byte ^ 1 << random.below(8) };
                }
            }
        }
    }
    sealed(&chunks)
}

/// Changes the level and triangles declared by chunks to the decoded ones, so they are accepted.
fn accepted(bytes: &[u8], limits: StreamLimits) -> (Vec<u8>, bool) {
    let mut chunks = chunks_of(bytes);
    let mut decoder = Decoder::new(limits);
    for at in 0..chunks.len() {
        let before = decoder.clone();
        let (head, payload) = &chunks[at];
        let stream = head.stream as usize;
        if decoder.update(&head.with_payload(payload)).is_ok() {
            continue;
        }
        let built = decoder.part(stream).map(|part| (part.level(), part.triangle_count()));
        let (Some((level, triangles)), Some(_)) = (built, before.part(stream)) else {
            return (sealed(&chunks), false);
        };
        decoder = before;
        chunks[at].0.level = level as u32;
        chunks[at].0.triangles = triangles as u32;
        if decoder.update(&sealed(&chunks[at..=at])).is_err() {
            return (sealed(&chunks), false);
        }
    }
    (sealed(&chunks), true)
}

/// Calls all getters of the decoded parts. Returns the number of parts whose splits are not the
/// inverse of valid collapses.
fn check_parts(decoder: &Decoder, most: usize) -> usize {
    let (mut triangles, mut refused_sequences) = (0, 0);
    for part in decoder.parts() {
        part.surface().check().unwrap();
        strips::check_strips(part);
        triangles += part.triangle_count();
        let vertex_count = part.vertex_count();
        assert!(part.triangles().iter().all(|&v| (v as usize) < vertex_count));
        assert_eq!(part.positions().len(), vertex_count);
        if let Ok(mesh) = part.mesh() {
            assert_eq!(mesh.attributes().len(), part.attribute_names().count());
        }
        if let Ok(sequence) = part.sequence() {
            sequence.check().unwrap();
            let triangles = part.triangles();
            let drawn = sorted(triangles_of(&triangles).filter(|&t| !is_degenerate(t)));
            assert_eq!(sorted(sequence.drawn(part.level()).unwrap()), drawn);
        } else {
            refused_sequences += 1;
            let mut cursor = Arc::new(part.clone()).start();
            assert_eq!(cursor.level(), 0);
            let triangles = part.triangles();
            assert_eq!(
                sorted(cursor.strips().triangles()),
                sorted(triangles_of(&triangles).filter(|&t| !is_degenerate(t)))
            );
        }
    }
    assert!(triangles <= most, "{triangles} of {most}");
    refused_sequences
}

/// `MUTATED_STREAMS=100000` tries that many streams.
#[test]
fn changed_contents_do_no_harm() {
    let rounds = std::env::var("MUTATED_STREAMS").map_or(10_000, |count| count.parse().unwrap());
    let chunks = chunks_of(&bytes());
    let limits = StreamLimits { meshes: 3, triangles: 500, chunk_bytes: 4000, corners: 1 << 20 };
    let mut random = Random::new(7);
    let [mut right, mut wrong] = [0; 2];
    for i in 0..rounds {
        let bytes = mutated(&mut random, &chunks);
        let mut decoder = Decoder::new(limits).keeping_strips();
        let result = decoder.update(&bytes);
        *(if result.is_ok() { &mut right } else { &mut wrong }) += 1;
        // One split too many adds two triangles.
        check_parts(&decoder, limits.triangles + 2);
        if i % 4 == 0 {
            let (bytes, is_right) = accepted(&bytes, limits);
            let mut decoder = Decoder::new(limits).keeping_strips();
            assert_eq!(decoder.update(&bytes).is_ok(), is_right);
            check_parts(&decoder, limits.triangles + 2);
        }
        if i % 50 == 0 {
            let mut pieces = Decoder::new(limits).keeping_strips();
            let faults = bytes.chunks(11).map(|piece| pieces.update(piece).map(|_| ())).find(Result::is_err);
            assert_eq!(faults.unwrap_or(Ok(())), result.map(|_| ()));
            assert_eq!(fingerprints(&pieces), fingerprints(&decoder));
        }
    }
    assert!(right > rounds / 200 && wrong > rounds / 2, "{right} {wrong}");
}

#[test]
fn any_payload_is_read() {
    let limits = StreamLimits { meshes: 3, triangles: 3000, chunk_bytes: 4000, corners: 1 << 20 };
    let base = chunks_of(&bytes()).swap_remove(0);
    let mut random = Random::new(9);
    let mut refused = 0;
    for _ in 0..500 {
        // A base mesh with the usual head, followed by random bytes.
        let mut payload = base.1[..random.below(base.1.len())].to_vec();
        payload.extend((0..random.below(300)).map(|_| random.next_u64() as u8));
        let refinement: Vec<u8> = (0..random.below(900)).map(|_| random.next_u64() as u8).collect();
        let visits = random.below(4000) as u32;
        let head = ChunkHead { visits, triangles: 2000, level: 0, ..base.0 };
        let bytes = sealed(&[(base.0, payload), (head, refinement)]);
        let mut decoder = Decoder::new(limits).keeping_strips();
        let _ = decoder.update(&bytes);
        refused += check_parts(&decoder, limits.triangles + 2);
        let (bytes, _) = accepted(&bytes, limits);
        let mut decoder = Decoder::new(limits).keeping_strips();
        let _ = decoder.update(&bytes);
        refused += check_parts(&decoder, limits.triangles + 2);
    }
    // Such a part has one level.
    assert!(refused > 0, "{refused}");
}
