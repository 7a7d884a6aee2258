//! Every truncation and thousands of byte mutations of small valid files give a model or an error,
//! never a panic.

use tristrip_io::{Format, read};

use crate::random::{mutate, random};

const OBJ: &str = "o a\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\nusemtl m\n\
    f 1/1/1 2/2/1 \\\n 3/1/1\nusemtl n\nf -1//-1 3//1 2//1\ns 1\nl 1 2\n";
const OFF: &str = "STCNOFF\n# square\n4 2 0\n0 0 0 0 0 1 255 0 0 255 0 0\n1 0 0 0 0 1 0 255 0 255 1 0\n\
    1 1 0 0 0 1 0 0 255 255 1 1\n0 1 0 0 0 1 9 9 9 255 0 1\n3 0 1 2\n3 0 2 3 255 0 0\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n\
    endfacet\nendsolid a\n";
const PLY_ROWS: [[f32; 4]; 4] = [[0., 0., 0., 1.], [1., 0., 0., 2.], [0., 1., 0., 3.], [1., 1., 0., 4.]];

/// Returns a PLY file with attributes, faces, an extra element and strips.
fn ply(encoding: &str) -> Vec<u8> {
    let header = format!(
        "ply\nformat {encoding} 1.0\ncomment c\nelement vertex 4\nproperty float x\nproperty float y\n\
         property float z\nproperty double quality\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
         element face 1\nproperty list uchar int vertex_indices\nproperty short flags\nelement edge 1\n\
         property int a\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    );
    let mut out = header.into_bytes();
    let mut put = |value: f64, size: usize, is_float: bool, last: bool| {
        if encoding == "ascii" {
            out.extend(format!("{value}{}", if last { '\n' } else { ' ' }).bytes());
            return;
        }
        let mut bytes = match (size, is_float) {
            (4, true) => (value as f32).to_le_bytes().to_vec(),
            (8, true) => value.to_le_bytes().to_vec(),
            _ => (value as i64).to_le_bytes()[..size].to_vec(),
        };
        if encoding.contains("big") {
            bytes.reverse();
        }
        out.extend(bytes);
    };
    for row in PLY_ROWS {
        row[..3].iter().for_each(|&x| put(x.into(), 4, true, false));
        put(row[3].into(), 8, true, false);
        (0..3).for_each(|i| put(9.0, 1, false, i == 2));
    }
    put(4.0, 1, false, false);
    for v in [0., 1., 3., 2.] {
        put(v, 4, false, false);
    }
    put(7.0, 2, false, true);
    put(1.0, 4, false, true);
    put(8.0, 4, false, false);
    [0., 1., 2., 3., -1., 1., 3., 2.].into_iter().enumerate().for_each(|(i, v)| put(v, 4, false, i == 7));
    out
}

fn binary_stl() -> Vec<u8> {
    let mut out = vec![b' '; 80];
    out.extend(2u32.to_le_bytes());
    for i in 0..24 {
        out.extend((i as f32).to_le_bytes());
        if i % 12 == 11 {
            out.extend([0, 0]);
        }
    }
    out
}

fn samples() -> Vec<(Format, Vec<u8>)> {
    vec![
        (Format::Obj, OBJ.into()),
        (Format::Off, OFF.into()),
        (Format::Stl, STL.into()),
        (Format::Stl, binary_stl()),
        (Format::Ply, ply("ascii")),
        (Format::Ply, ply("binary_little_endian")),
        (Format::Ply, ply("binary_big_endian")),
    ]
}

#[test]
fn the_samples_are_valid() {
    for (format, bytes) in samples() {
        let model = read(&bytes, format).unwrap_or_else(|error| panic!("{format:?}: {error}"));
        assert!(model.parts[0].mesh.faces().face_count() > 0);
        assert_eq!(Format::from_bytes(&bytes), format);
    }
    let meshes: Vec<_> = samples()[4..]
        .iter()
        .map(|(format, bytes)| read(bytes, *format).unwrap().parts.remove(0).mesh)
        .collect();
    assert!(meshes.iter().all(|mesh| *mesh == meshes[0]), "the encodings differ");
}

#[test]
fn truncations_never_panic() {
    for (format, bytes) in samples() {
        for end in 0..bytes.len() {
            let got = read(&bytes[..end], format);
            let is_text = bytes.is_ascii() && format != Format::Stl || bytes.starts_with(b"solid");
            // Truncated text may still be valid: within the last number, or before the last line of
            // an OBJ.
            assert!(is_text || got.is_err(), "{format:?}: {end} of {} bytes were accepted", bytes.len());
        }
    }
}

#[test]
fn mutations_never_panic() {
    let mut random = random();
    for (format, bytes) in samples() {
        for _ in 0..20_000 {
            let mut changed = bytes.clone();
            mutate(&mut changed, 3, &mut random);
            let _ = read(&changed, format);
        }
    }
}
