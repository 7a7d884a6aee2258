//! Meshes and streams for tests.

use proptest::prelude::*;

use super::chunk::{ChunkHead, MAX_HEAD_BYTES};
use super::{Decoder, EncodedStream, StreamLimits, StreamOptions, StreamPart, encode, unsplittable};
use crate::mesh::{Attribute, AttributeData, Faces, Mesh};
use crate::random::Random;
use crate::simplify::{MergeTree, SimplifyOptions, refinement_batches};
use crate::stripify::generated_meshes::polygons;

/// Builds a mesh of triangles with random, distinct vertex positions.
pub(super) fn scattered(triangles: Vec<u32>, seed: u64) -> Mesh {
    let mut random = Random::new(seed);
    let count = triangles.iter().max().map_or(0, |&v| v + 1);
    let positions: Vec<_> =
        (0..count).map(|_| [(); 3].map(|()| random.below(4096) as f32 / 64.0 - 20.0)).collect();
    Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap()
}

/// Generates meshes of many kinds: open, closed, with several components, non-manifold, with
/// duplicate and degenerate triangles.
pub(super) fn meshes() -> impl Strategy<Value = Mesh> {
    (polygons(true, 1..4), any::<u64>()).prop_map(|(polygons, seed)| scattered(polygons.concat(), seed))
}

/// Builds a bumpy grid of `width` by `height` quads, each split into two triangles.
pub(super) fn grid(width: u32, height: u32) -> Mesh {
    let at = |x: u32, y: u32| y * (width + 1) + x;
    let quad = |x, y| [at(x, y), at(x + 1, y), at(x, y + 1), at(x, y + 1), at(x + 1, y), at(x + 1, y + 1)];
    let triangles: Vec<u32> = (0..height).flat_map(|y| (0..width).flat_map(move |x| quad(x, y))).collect();
    let bump = |v: u32| (v.wrapping_mul(2_654_435_761) >> 24) as f32 / 512.0;
    let position = |v: u32| [(v % (width + 1)) as f32, (v / (width + 1)) as f32, bump(v)];
    let positions: Vec<_> = (0..(width + 1) * (height + 1)).map(position).collect();
    Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap()
}

/// Builds a grid with normals, colours, joints, weights and texture coordinates. The texture
/// coordinates have a seam along the middle column, whose vertices are duplicated.
pub(super) fn with_attributes(width: u32, height: u32) -> Mesh {
    let plain = grid(width, height);
    let (middle, columns) = (width / 2, width + 1);
    let count = plain.vertex_count() as u32;
    // Beyond the seam, the triangles use the duplicated vertices of the middle column.
    let mut triangles = plain.faces().corners().to_vec();
    for triangle in triangles.chunks_exact_mut(3) {
        let is_beyond = triangle.iter().any(|v| v % columns > middle);
        for v in triangle.iter_mut().filter(|v| is_beyond && **v % columns == middle) {
            *v = count + *v / columns;
        }
    }
    let sources: Vec<u32> = (0..count).chain((0..=height).map(|y| y * columns + middle)).collect();
    let positions: Vec<_> = sources.iter().map(|&v| plain.positions()[v as usize]).collect();
    let mesh = Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap();
    let each = |of: &dyn Fn(usize, u32) -> Vec<f32>| -> Vec<f32> {
        sources.iter().enumerate().flat_map(|(v, &source)| of(v, source)).collect()
    };
    let unit = |x: f32, y: f32| {
        let length = (x * x + y * y + 1.0).sqrt();
        [x / length, y / length, 1.0 / length]
    };
    let normal = |source: u32| unit((source % 7) as f32 / 7.0 - 0.5, (source % 5) as f32 / 5.0 - 0.5);
    let uv = |v: usize, source: u32| {
        let beyond = if v >= count as usize || source % columns > middle { 0.5 } else { 0.0 };
        vec![beyond + (source % columns) as f32 / 40.0, (source / columns) as f32 / 20.0]
    };
    let weights = |source: u32| {
        let [a, b] = [(source % 9) as f32 / 16.0, (source % 4) as f32 / 16.0];
        vec![a, b, 1.0 - a - b, 0.0]
    };
    let colours = sources.iter().flat_map(|&v| [v % 256, v * 3 % 256, v / 4, 255].map(|x| x as u8)).collect();
    let joints = sources.iter().flat_map(|&v| [v % 3, 7 + v / 20, 200, 0].map(|x| x as u8)).collect();
    let attributes = [
        ("NORMAL", 3, false, AttributeData::F32(each(&|_, source| normal(source).to_vec()))),
        ("TEXCOORD_0", 2, false, AttributeData::F32(each(&uv))),
        ("COLOR_0", 4, true, AttributeData::U8(colours)),
        ("JOINTS_0", 4, false, AttributeData::U8(joints)),
        ("WEIGHTS_0", 4, false, AttributeData::F32(each(&|_, source| weights(source)))),
        (
            "TANGENT",
            4,
            false,
            AttributeData::F32(each(&|_, source| {
                let [x, y, z] = normal(source);
                vec![z, x, y, if source.is_multiple_of(2) { 1.0 } else { -1.0 }]
            })),
        ),
    ];
    attributes.into_iter().fold(mesh, |mesh, (name, components, normalized, data)| {
        mesh.with_attribute(Attribute { name: name.into(), components, normalized, data }).unwrap()
    })
}

/// Collapses the triangles of a mesh, with vertices locked until all collapses can be restored.
pub(super) fn batches(mesh: &Mesh) -> MergeTree {
    let mut locked = vec![false; mesh.vertex_count()];
    loop {
        let options = SimplifyOptions::default().with_locked(locked.clone());
        let batches = refinement_batches(mesh, mesh.faces().corners().to_vec(), &options).unwrap();
        let others = unsplittable(&batches.sequence);
        if others.is_empty() {
            return batches;
        }
        others.iter().for_each(|&v| locked[v as usize] = true);
    }
}

/// Returns options with a chunk after every few bytes.
pub(super) fn small_chunks() -> StreamOptions {
    StreamOptions { least_chunk_bytes: 40, most_chunk_bytes: 90, ..StreamOptions::default() }
}

/// Encodes a mesh.
pub(super) fn stream_of(mesh: &Mesh, stream: u32, options: &StreamOptions) -> (MergeTree, EncodedStream) {
    let batches = batches(mesh);
    let encoded = encode(mesh, &batches.sequence, &batches.level_ends, stream, options).unwrap();
    (batches, encoded)
}

/// Decodes the bytes of a valid stream.
pub(super) fn decoded(bytes: &[u8]) -> Decoder {
    let mut decoder = Decoder::new(StreamLimits::default());
    decoder.update(bytes).unwrap();
    decoder
}

/// Returns the levels and fingerprints of all meshes.
pub(super) fn fingerprints(decoder: &Decoder) -> Vec<(usize, u32)> {
    decoder.parts().map(|part: &StreamPart| (part.level(), part.fingerprint())).collect()
}

/// Splits bytes into the headers and payloads of chunks.
pub(super) fn chunks_of(mut bytes: &[u8]) -> Vec<(ChunkHead, Vec<u8>)> {
    let mut chunks = Vec::new();
    while let Some(Ok((head, _, length))) = ChunkHead::read(&bytes[..bytes.len().min(MAX_HEAD_BYTES)]) {
        let end = length + head.payload_bytes as usize;
        chunks.push((head, bytes[length..end].to_vec()));
        bytes = &bytes[end..];
    }
    chunks
}

/// Joins chunks, with correct lengths and checksums.
pub(super) fn sealed(chunks: &[(ChunkHead, Vec<u8>)]) -> Vec<u8> {
    chunks.iter().flat_map(|(head, payload)| head.with_payload(payload)).collect()
}
