//! Streams of generated meshes, whole, in pieces and damaged. The oracle of what a stream builds is the sequence that was encoded.

use crate::mesh::{Attribute, AttributeData, Faces, Mesh, triangles_of};
use crate::random::Random;
use crate::stream::chunk::{ChunkHead, checksum};
use crate::stream::{Decoder, EncodedStream, StreamLimits, StreamOptions, encode};
use crate::{CollapseSequence, Rename};

/// A wavy grid of `n` × `n` quadrilaterals, each cut into two triangles. With `seam`, its middle column has two vertices at each point.
fn grid(n: u32, seam: bool) -> Mesh {
    let half = n / 2;
    let mut positions = Vec::new();
    let mut texture = Vec::new();
    let mut vertex_of = std::collections::HashMap::new();
    let mut corner = |x: u32, y: u32, side: bool| {
        let key = (x, y, seam && x == half && side);
        *vertex_of.entry(key).or_insert_with(|| {
            let (u, v) = (x as f32 / n as f32, y as f32 / n as f32);
            positions.push([u, v, 0.2 * (6.0 * u) * (1.0 - u) * v]);
            texture.extend([if key.2 { u + 1.0 } else { u }, v]);
            positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for y in 0..n {
        for x in 0..n {
            let side = x >= half;
            let [a, b, c, d] = [
                corner(x, y, side),
                corner(x + 1, y, side),
                corner(x + 1, y + 1, side),
                corner(x, y + 1, side),
            ];
            triangles.extend([a, b, d, d, b, c]);
        }
    }
    let shades = positions.iter().map(|p| (200.0 * p[0]) as u8).collect();
    let mesh = Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap();
    let uv = AttributeData::F32(texture);
    let uv = Attribute { name: "TEXCOORD_0".into(), components: 2, normalized: false, data: uv };
    let shades = AttributeData::U8(shades);
    let shades = Attribute { name: "COLOR_0".into(), components: 1, normalized: true, data: shades };
    mesh.with_attribute(uv).unwrap().with_attribute(shades).unwrap()
}

/// Collapses of the grid, found without a simplification: inner points go to the left, in two batches of points that are not neighbours, and along
/// a seam both of its vertices go downwards.
fn sequence(mesh: &Mesh, n: u32, seam: bool) -> (CollapseSequence, Vec<u32>) {
    let positions = mesh.positions();
    let half = n / 2;
    let at = |x: u32, y: u32, right: bool| {
        let shift = if right && seam && x == half { 1.0 } else { 0.0 };
        let is = |v: &usize| {
            let Some(u) = mesh.attributes()[0].float(2 * v) else { return false };
            let p = positions[*v];
            let near = |a: f32, b: u32| (a * n as f32 - b as f32).abs() < 0.01;
            near(p[0], x) && near(p[1], y) && (u - p[0] - shift).abs() < 0.1
        };
        (0..positions.len()).find(is).unwrap() as u32
    };
    let mut groups: Vec<Vec<Rename>> = Vec::new();
    let mut ends = Vec::new();
    for parity in [1, 0] {
        for y in (2..n - 1).filter(|y| y % 2 == 0) {
            for x in (1..n).filter(|x| x % 4 == 2 * parity && *x != half && *x > 1 && *x - 1 != half) {
                groups.push(vec![Rename { removed: at(x, y, x > half), kept: at(x - 1, y, x > half) }]);
            }
            if parity == 0 && seam && y % 4 == 2 {
                let of = |right: bool| Rename { removed: at(half, y, right), kept: at(half, y - 1, right) };
                groups.push(vec![of(false), of(true)]);
            }
        }
        ends.push(groups.len() as u32);
    }
    let collapses = groups.iter().map(|group| (&group[..], 0.01));
    let triangles = mesh.faces().corners().to_vec();
    (CollapseSequence::from_collapses(positions.len(), triangles, collapses).unwrap(), ends)
}

fn encoded(n: u32, seam: bool) -> (Mesh, CollapseSequence, EncodedStream) {
    let mesh = grid(n, seam);
    let (sequence, ends) = sequence(&mesh, n, seam);
    let stream = encode(&mesh, &sequence, &ends, 0, &StreamOptions::default()).unwrap();
    (mesh, sequence, stream)
}

/// The triangles by the positions and values of their corners, rounded, each turned to start with its least corner.
fn drawn(mesh: &Mesh, triangles: &[u32]) -> Vec<[[i32; 6]; 3]> {
    let corner = |v: u32| {
        let p = mesh.positions()[v as usize].map(|x| (1000.0 * x).round() as i32);
        let value = |a: usize, i: usize| (1000.0 * mesh.attributes()[a].float(i).unwrap()).round() as i32;
        [p[0], p[1], p[2], value(0, 2 * v as usize), value(0, 2 * v as usize + 1), value(1, v as usize)]
    };
    let turned = |t: [u32; 3]| {
        let corners = t.map(corner);
        (0..3).map(|i| [corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]]).min().unwrap()
    };
    let mut drawn: Vec<_> = triangles_of(triangles).map(turned).collect();
    drawn.sort_unstable();
    drawn
}

/// Checks that two lists of triangles are the same up to rounding of their values.
fn assert_near(found: &[[[i32; 6]; 3]], expected: &[[[i32; 6]; 3]]) {
    assert_eq!(found.len(), expected.len());
    let is_near = |a: &[[i32; 6]; 3], b: &[[i32; 6]; 3]| {
        a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() <= 2)
    };
    for triangle in found {
        assert!(expected.iter().any(|other| is_near(triangle, other)), "{triangle:?}");
    }
}

#[test]
fn the_full_mesh_is_that_of_the_input() {
    for (n, seam) in [(9, false), (16, false), (16, true)] {
        let (mesh, sequence, stream) = encoded(n, seam);
        assert!(sequence.len() > 8 && stream.chunks.len() > 1);
        let mut decoder = Decoder::new(StreamLimits::default());
        decoder.update(&stream.bytes()).unwrap();
        let part = decoder.part(0).unwrap();
        assert_eq!((part.level(), part.full_level()), (sequence.len(), sequence.len()));
        assert_eq!(part.vertex_count(), mesh.vertex_count());
        let full = part.mesh().unwrap();
        assert_near(&drawn(&full, full.faces().corners()), &drawn(&mesh, mesh.faces().corners()));
        let error = stream.position_error;
        assert!(error > 0.0 && error < 1e-4);
    }
}

#[test]
fn every_chunk_leads_to_a_level_of_what_follows() {
    let (mesh, _, stream) = encoded(24, true);
    let mut decoder = Decoder::new(StreamLimits::default());
    decoder.update(&stream.bytes()).unwrap();
    let full = decoder.part(0).unwrap();
    let all = full.sequence().unwrap();
    all.check().unwrap();
    assert_eq!(stream.base.len() / 3, stream.chunks[0].triangles as usize);
    let base = drawn(&mesh, &stream.base);
    let mut decoder = Decoder::new(StreamLimits::default());
    for (number, chunk) in stream.chunks.iter().enumerate() {
        decoder.update(&chunk.bytes).unwrap();
        let part = decoder.part(0).unwrap();
        assert_eq!((part.level(), part.triangle_count()), (chunk.level as usize, chunk.triangles as usize));
        let mut found = part.triangles().chunks_exact(3).map(turned).collect::<Vec<_>>();
        let mut expected: Vec<[u32; 3]> =
            all.drawn(part.level()).unwrap().iter().map(|t| turned(t)).collect();
        found.sort_unstable();
        expected.sort_unstable();
        assert_eq!(found, expected);
        if number == 0 {
            let coarse = part.mesh().unwrap();
            assert_eq!(drawn(&coarse, coarse.faces().corners()).len(), base.len());
        }
    }
}

fn turned(t: &[u32]) -> [u32; 3] {
    (0..3).map(|i| [t[i], t[(i + 1) % 3], t[(i + 2) % 3]]).min().unwrap()
}

/// The fingerprints after each piece of the bytes.
fn last_fingerprint(pieces: impl Iterator<Item = Vec<u8>>) -> u32 {
    let mut decoder = Decoder::new(StreamLimits::default());
    pieces.for_each(|piece| {
        decoder.update(&piece).unwrap();
    });
    decoder.part(0).unwrap().fingerprint()
}

#[test]
fn any_split_of_the_bytes_gives_the_same() {
    let (.., stream) = encoded(16, true);
    let bytes = stream.bytes();
    let whole = last_fingerprint([bytes.clone()].into_iter());
    assert_eq!(last_fingerprint(bytes.iter().map(|&byte| vec![byte])), whole);
    let mut random = Random::new(7);
    for _ in 0..50 {
        let mut rest = &bytes[..];
        let mut pieces = Vec::new();
        while !rest.is_empty() {
            let (piece, other) = rest.split_at(random.below(rest.len()) + 1);
            pieces.push(piece.to_vec());
            rest = other;
        }
        assert_eq!(last_fingerprint(pieces.into_iter()), whole);
    }
    // The same input gives the same bytes.
    assert_eq!(encoded(16, true).2, stream);
}

#[test]
fn what_is_complete_of_a_cut_stream_is_there() {
    let (.., stream) = encoded(9, false);
    let bytes = stream.bytes();
    for end in 0..bytes.len() {
        let mut decoder = Decoder::new(StreamLimits::default());
        decoder.update(&bytes[..end]).unwrap();
        let lengths = stream.chunks.iter().scan(0, |sum, chunk| {
            *sum += chunk.bytes.len();
            Some(*sum)
        });
        let complete = lengths.filter(|&length| length <= end).count();
        assert_eq!(decoder.chunk_count(), complete);
        let level = complete.checked_sub(1).map(|last| stream.chunks[last].level as usize);
        assert_eq!(decoder.part(0).map(crate::stream::StreamPart::level), level);
    }
}

#[test]
fn a_damaged_chunk_is_reported_and_what_came_before_stays() {
    let (.., stream) = encoded(24, false);
    let mut decoder = Decoder::new(StreamLimits::default());
    decoder.update(&stream.chunks[0].bytes).unwrap();
    let before = decoder.part(0).unwrap().fingerprint();
    let mut damaged = stream.chunks[1].bytes.clone();
    let last = damaged.len() - 1;
    damaged[last] ^= 1;
    let error = decoder.update(&damaged).unwrap_err().to_string();
    assert!(error.starts_with(&format!("chunk 1 at byte {}: found checksum", decoder.offset())), "{error}");
    assert_eq!(decoder.part(0).unwrap().fingerprint(), before);
    // The decoder has lost its place.
    assert_eq!(decoder.update(&stream.chunks[1].bytes).unwrap_err().to_string(), error);
}

/// Changes the payload or the head of a chunk, and makes the checksum right again.
fn mutated(chunk: &[u8], random: &mut Random) -> Vec<u8> {
    let (head, _, length) = ChunkHead::read(chunk).unwrap().unwrap();
    let mut payload = chunk[length..].to_vec();
    for _ in 0..=random.below(4) {
        match random.below(4) {
            0 if !payload.is_empty() => payload.truncate(random.below(payload.len())),
            1 => payload.push(random.below(256) as u8),
            _ if !payload.is_empty() => {
                let at = random.below(payload.len());
                payload[at] ^= 1 << random.below(8);
            }
            _ => (),
        }
    }
    let mut head = head;
    if random.below(4) == 0 {
        head.visits = random.below(5000) as u32;
    }
    if random.below(8) == 0 {
        head.triangles = random.below(1 << 20) as u32;
    }
    head.with_payload(&payload)
}

#[test]
fn mutated_chunks_are_errors_or_meshes() {
    let (.., stream) = encoded(16, true);
    let limits = StreamLimits { triangles: 10_000, meshes: 2, chunk_bytes: 1 << 16 };
    let mut random = Random::new(1);
    for _ in 0..5000 {
        let mut decoder = Decoder::new(limits);
        let damaged = random.below(stream.chunks.len());
        for (number, chunk) in stream.chunks.iter().enumerate() {
            let bytes =
                if number == damaged { mutated(&chunk.bytes, &mut random) } else { chunk.bytes.clone() };
            if decoder.update(&bytes).is_err() {
                break;
            }
        }
        for part in decoder.parts() {
            assert!(part.triangle_count() <= limits.triangles);
            part.mesh().unwrap();
            part.fingerprint();
        }
    }
}

#[test]
fn streams_beyond_the_limits_are_refused() {
    let (.., stream) = encoded(16, false);
    let refused =
        |limits: StreamLimits| Decoder::new(limits).update(&stream.bytes()).unwrap_err().to_string();
    let usual = StreamLimits::default();
    assert!(refused(StreamLimits { triangles: 400, ..usual }).ends_with("expected at most 400"));
    assert!(refused(StreamLimits { meshes: 0, ..usual }).ends_with("expected at most 0 meshes"));
    assert!(refused(StreamLimits { chunk_bytes: 9, ..usual }).ends_with("expected at most 9"));
    // A head that claims four gigabytes.
    let mut huge = vec![0, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F, 0, 0, 0];
    huge.extend([0; 4]);
    huge.extend(checksum(&huge, &[]).to_le_bytes());
    assert!(Decoder::new(usual).update(&huge).is_err());
}

#[test]
fn wrong_arguments_are_errors() {
    let mesh = grid(9, false);
    let (sequence, _) = sequence(&mesh, 9, false);
    let options = StreamOptions::default();
    // One batch for all: neighbours are removed together.
    let other = grid(8, false);
    assert!(encode(&other, &sequence, &[], 0, &options).is_err());
    let values = AttributeData::F32(vec![f32::NAN; mesh.vertex_count()]);
    let values = Attribute { name: "noise".into(), components: 1, normalized: false, data: values };
    let error = encode(&mesh.with_attribute(values).unwrap(), &sequence, &[], 0, &options).unwrap_err();
    assert!(error.to_string().contains("expected finite numbers"), "{error}");
    assert!(options.with_position_bits(3).is_err() && options.with_position_bits(17).is_err());
}

#[test]
fn small_and_strange_meshes_have_streams() {
    let p = |x: f32, y: f32, z: f32| [x, y, z];
    let book = vec![p(0., 0., 0.), p(1., 0., 0.), p(0., 1., 0.), p(0., -1., 0.), p(0., 0., 1.)];
    let cases: [(Vec<[f32; 3]>, Vec<u32>); 6] = [
        (vec![], vec![]),
        (book.clone(), vec![0, 1, 2]),
        // Three triangles at one edge.
        (book.clone(), vec![0, 1, 2, 1, 0, 3, 0, 1, 4]),
        // The same triangle twice, and turned over.
        (book.clone(), vec![0, 1, 2, 0, 1, 2, 0, 2, 1]),
        // Two that touch in a point.
        (book, vec![0, 1, 2, 0, 3, 4]),
        (vec![[1.0; 3]; 3], vec![0, 1, 2]),
    ];
    for (positions, triangles) in cases {
        let count = triangles.len() / 3;
        let mesh = Mesh::new(positions, Faces::from_triangles(triangles.clone()).unwrap()).unwrap();
        let sequence = CollapseSequence::new(mesh.vertex_count(), triangles).unwrap();
        let stream = encode(&mesh, &sequence, &[], 3, &StreamOptions::default()).unwrap();
        let mut decoder = Decoder::new(StreamLimits::default());
        decoder.update(&stream.bytes()).unwrap();
        assert_eq!(decoder.part(3).unwrap().triangle_count(), count);
        assert!(decoder.part(0).is_none());
    }
}
