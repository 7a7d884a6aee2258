//! The streams in `testdata/stream/v1`, which test decoders in other languages. `TRISTRIP_BLESS=1`
//! writes them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::mesh::{Attribute, AttributeData, Faces, Mesh};
use crate::stream::samples::{decoded, grid, scattered, stream_of, with_attributes};
use crate::stream::{Decoder, EncodedStream, StreamLimits, StreamOptions, StreamPart};

/// Builds a bumpy torus of `width` by `height` quads.
fn torus(width: u32, height: u32) -> Mesh {
    let at = |x: u32, y: u32| y % height * width + x % width;
    let quad = |x, y| [at(x, y), at(x + 1, y), at(x, y + 1), at(x, y + 1), at(x + 1, y), at(x + 1, y + 1)];
    let triangles = (0..height).flat_map(|y| (0..width).flat_map(move |x| quad(x, y))).collect();
    // A square rolled up along two parabolas, which are computed identically on every platform.
    let turn = |i: u32, n: u32| {
        let t = 4.0 * i as f32 / n as f32;
        let bow = |t: f32| if t < 2.0 { t * (2.0 - t) } else { (t - 2.0) * (t - 4.0) };
        [bow((t + 1.0) % 4.0), bow(t)]
    };
    let position = |v: u32| {
        let ([a, b], [c, d]) = (turn(v % width, width), turn(v / width, height));
        let bump = (v.wrapping_mul(2_654_435_761) >> 24) as f32 / 2048.0;
        let radius = 3.0 + (1.0 + bump) * c;
        [radius * a, radius * b, (1.0 + bump) * d]
    };
    let positions: Vec<[f32; 3]> = (0..width * height).map(position).collect();
    Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap()
}

/// Builds a grid without some of its triangles.
fn holes() -> Mesh {
    let whole = grid(40, 40);
    let corners = whole.faces().corners().chunks_exact(3).enumerate();
    let kept = corners.filter(|(t, _)| t % 41 > 2).flat_map(|(_, corners)| corners.iter().copied());
    Mesh::new(whole.positions().to_vec(), Faces::from_triangles(kept.collect()).unwrap()).unwrap()
}

/// Builds tori and grids next to each other.
fn components() -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (i, mesh) in [torus(9, 7), grid(5, 9), torus(6, 6), grid(3, 3)].into_iter().enumerate() {
        let first = positions.len() as u32;
        positions.extend(mesh.positions().iter().map(|&[x, y, z]| [x + 12.0 * i as f32, y, z]));
        triangles.extend(mesh.faces().corners().iter().map(|v| first + v));
    }
    Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap()
}

/// Builds three sheets that share their first column, with a few duplicate triangles.
fn nonmanifold() -> Mesh {
    let sheet = grid(8, 8);
    let count = sheet.vertex_count() as u32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..3 {
        positions.extend(sheet.positions().iter().map(|&[x, y, z]| match i {
            0 => [x, y, z],
            1 => [z, y, x],
            _ => [-x, y, -z],
        }));
        let shared = |v: u32| if v.is_multiple_of(9) { v } else { i * count + v };
        triangles.extend(sheet.faces().corners().iter().map(|&v| shared(v)));
    }
    triangles.extend(sheet.faces().corners()[60..75].iter().copied());
    Mesh::new(positions, Faces::from_triangles(triangles).unwrap()).unwrap()
}

/// Builds a grid with attributes of all kinds.
fn seams(width: u32, height: u32) -> Mesh {
    let mesh = with_attributes(width, height);
    let ids = (-500..).step_by(31).take(mesh.vertex_count());
    let temperatures = mesh.positions().iter().map(|p| f64::from(p[0]) * 0.25 + f64::from(p[2]));
    let more = [
        ("_ID", AttributeData::I32(ids.collect())),
        ("_TEMPERATURE", AttributeData::F64(temperatures.collect())),
        ("_PAIR", AttributeData::U16((0..2 * mesh.vertex_count() as u16).collect())),
    ];
    more.into_iter().fold(mesh, |mesh, (name, data)| {
        let components = if name == "_PAIR" { 2 } else { 1 };
        mesh.with_attribute(Attribute { name: name.into(), components, normalized: false, data }).unwrap()
    })
}

fn chunks_of_size(least: usize, most: usize) -> StreamOptions {
    StreamOptions { least_chunk_bytes: least, most_chunk_bytes: most, ..StreamOptions::default() }
}

/// Returns the streams by name, as the bytes of their chunks.
fn vectors() -> Vec<(&'static str, Vec<Vec<u8>>)> {
    let bits = |bits| StreamOptions::default().with_position_bits(bits);
    let chunks = |stream: EncodedStream| stream.chunks.into_iter().map(|chunk| chunk.bytes).collect();
    let encoded = |mesh: &Mesh, options: &StreamOptions| chunks(stream_of(mesh, 0, options).1);
    let small = chunks_of_size(300, 700);
    let meshes = [torus(24, 17), seams(12, 12)];
    let streams: Vec<Vec<Vec<u8>>> =
        (0..).zip(&meshes).map(|(i, mesh)| chunks(stream_of(mesh, i, &small).1)).collect();
    let most = streams.iter().map(Vec::len).max().unwrap();
    let in_turn = (0..most).flat_map(|i| streams.iter().filter_map(move |chunks| chunks.get(i).cloned()));
    vec![
        ("coarse", encoded(&torus(24, 17), &bits(4))),
        ("components", encoded(&components(), &small)),
        ("empty", encoded(&scattered(Vec::new(), 1), &small)),
        ("fine", encoded(&torus(24, 17), &bits(16))),
        ("holes", encoded(&holes(), &chunks_of_size(1000, 2000))),
        ("meshes", in_turn.collect()),
        ("nonmanifold", encoded(&nonmanifold(), &small)),
        ("seams", encoded(&seams(32, 32), &chunks_of_size(1000, 4000))),
        ("triangle", encoded(&scattered(vec![0, 1, 2], 5), &small)),
    ]
}

/// Describes the decoder state after each chunk, and the final meshes.
fn description(chunks: &[Vec<u8>]) -> String {
    let mut decoder = Decoder::new(StreamLimits::default());
    let (mut lines, mut end) = (Vec::new(), 0);
    for chunk in chunks {
        decoder.update(chunk).unwrap();
        end += chunk.len();
        // The first byte is the index of the stream.
        let stream = chunk[0];
        let part = decoder.part(stream.into()).unwrap();
        let [level, triangles, vertices] = [part.level(), part.triangle_count(), part.vertex_count()];
        lines.push(format!(
            "    {{\"end\": {end}, \"stream\": {stream}, \"level\": {level}, \"triangles\": {triangles}, \"vertices\": {vertices}, \
             \"error\": {}, \"fingerprint\": {}}}",
            part.error(),
            part.fingerprint()
        ));
    }
    let parts: Vec<String> = decoder.parts().map(part_description).collect();
    format!(
        "{{\n  \"chunks\": [\n{}\n  ],\n  \"parts\": [\n{}\n  ]\n}}\n",
        lines.join(",\n"),
        parts.join(",\n")
    )
}

fn part_description(part: &StreamPart) -> String {
    let mesh = part.mesh().unwrap();
    let positions = mesh.positions().iter().flatten().flat_map(|x| x.to_le_bytes());
    let mut line = format!(
        "    {{\"fullLevel\": {}, \"fullTriangles\": {}, \"positions\": {}, \"attributes\": [",
        part.full_level(),
        part.full_triangle_count(),
        checksum(positions)
    );
    for (i, attribute) in mesh.attributes().iter().enumerate() {
        macro_rules! bytes {
            ($array:literal, $values:expr) => {
                ($array, checksum($values.iter().flat_map(|x| x.to_le_bytes())))
            };
        }
        let (array, crc) = match &attribute.data {
            AttributeData::F32(values) => bytes!("Float32Array", values),
            AttributeData::F64(values) => bytes!("Float64Array", values),
            AttributeData::U8(values) => bytes!("Uint8Array", values),
            AttributeData::I8(values) => bytes!("Int8Array", values),
            AttributeData::U16(values) => bytes!("Uint16Array", values),
            AttributeData::I16(values) => bytes!("Int16Array", values),
            AttributeData::U32(values) => bytes!("Uint32Array", values),
            AttributeData::I32(values) => bytes!("Int32Array", values),
        };
        let Attribute { name, components, normalized, .. } = attribute;
        let comma = if i > 0 { ", " } else { "" };
        write!(
            line,
            "{comma}{{\"name\": \"{name}\", \"components\": {components}, \"normalized\": {normalized}, \"array\": \"{array}\", \"crc\": {crc}}}"
        )
        .unwrap();
    }
    line + "]}"
}

fn checksum(bytes: impl Iterator<Item = u8>) -> u32 {
    crc32fast::hash(&bytes.collect::<Vec<_>>())
}

#[test]
fn committed_streams_are_those_of_the_encoder() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/stream/v1");
    let is_blessed = std::env::var_os("TRISTRIP_BLESS").is_some_and(|value| value == "1");
    let mut files: Vec<PathBuf> = Vec::new();
    for (name, chunks) in vectors() {
        decoded(&chunks.concat());
        for (extension, bytes) in [("bin", chunks.concat()), ("json", description(&chunks).into_bytes())] {
            let path = folder.join(name).with_extension(extension);
            if is_blessed {
                std::fs::write(&path, &bytes).unwrap();
            }
            let is_same = std::fs::read(&path).unwrap() == bytes;
            assert!(is_same, "{} is another file: TRISTRIP_BLESS=1 writes it", path.display());
            files.push(path);
        }
    }
    let there: Vec<PathBuf> =
        std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(there.iter().all(|path| files.contains(path)), "{there:?}");
}
