//! `.tlod` files: written files are read back; truncated, changed, oversized or invented files give
//! errors.

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use crate::random::random;
use proptest::prelude::*;
use tristrip::simplify::{MergeOrder, SimplifyOptions, merge_tree};
use tristrip::{
    Attribute, AttributeData, CollapseSequence, Faces, Mesh, Rename, StripifyOptions, Strips, stripify,
};
use tristrip_io::Error;
use tristrip_io::tlod::{TlodLimits, TlodModel, read, write};

fn test_model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models").join(name)
}

/// Builds the strips and the merge tree of a mesh.
fn model_of(mesh: Mesh) -> TlodModel {
    let strips = stripify(&mesh, &StripifyOptions::default()).unwrap();
    let tree = merge_tree(&mesh, strips.to_list(), MergeOrder::Quadric, &SimplifyOptions::default()).unwrap();
    TlodModel::new(mesh, strips, tree.sequence).unwrap()
}

fn attribute(number: u8, components: u8, vertex_count: usize) -> Attribute {
    let values = || (0..vertex_count * usize::from(components)).map(|i| (i * 37 + 11) as u8);
    let data = match number {
        0 => AttributeData::F32(values().map(f32::from).collect()),
        1 => AttributeData::F64(values().map(f64::from).collect()),
        2 => AttributeData::U8(values().collect()),
        3 => AttributeData::I8(values().map(u8::cast_signed).collect()),
        4 => AttributeData::U16(values().map(|x| u16::from(x) << 8).collect()),
        5 => AttributeData::I16(values().map(|x| -i16::from(x)).collect()),
        6 => AttributeData::U32(values().map(|x| u32::from(x) << 24).collect()),
        _ => AttributeData::I32(values().map(|x| -i32::from(x)).collect()),
    };
    Attribute { name: format!("TYPE_{number} é"), components, normalized: number.is_multiple_of(2), data }
}

/// Returns a strip of triangles with attributes of all types, two unused vertices, and collapses of
/// one vertex, of two, and of none.
fn small() -> TlodModel {
    let positions = (0..8).map(|i| [i as f32, (i % 2) as f32, -0.5]).collect::<Vec<_>>();
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2, 3]);
    strips.push(&[]);
    strips.push(&[3, 2, 4, 2, 5]);
    let triangles = strips.to_list();
    let mut mesh = Mesh::new(positions, Faces::from_triangles(triangles.clone()).unwrap()).unwrap();
    for number in 0..8 {
        mesh = mesh.with_attribute(attribute(number, number % 3 + 1, 8)).unwrap();
    }
    let rename = |removed, kept| Rename { removed, kept };
    let collapses: [(&[Rename], f32); 3] =
        [(&[rename(5, 4)], 0.25), (&[], 0.0), (&[rename(4, 2), rename(3, 1)], f32::INFINITY)];
    let sequence = CollapseSequence::from_collapses(8, triangles, collapses).unwrap();
    TlodModel::new(mesh, strips, sequence).unwrap()
}

fn written(model: &TlodModel) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(model, &mut bytes).unwrap();
    bytes
}

fn read_all(bytes: &[u8]) -> Result<TlodModel, Error> {
    read(bytes, &TlodLimits::default())
}

fn message(bytes: &[u8]) -> String {
    read_all(bytes).unwrap_err().to_string()
}

/// Returns the start of each section and the end of its content. All sections must be complete.
fn sections(bytes: &[u8]) -> Vec<(usize, usize)> {
    let (mut sections, mut at) = (Vec::new(), 12);
    while at < bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 4..at + 12].try_into().unwrap()) as usize;
        sections.push((at, at + 12 + length));
        at += 16 + length;
    }
    sections
}

/// Corrects the checksums of these sections.
fn seal(bytes: &mut [u8], sections: &[(usize, usize)]) {
    for &(start, end) in sections {
        let checksum = crc32fast::hash(&bytes[start..end]);
        bytes[end..end + 4].copy_from_slice(&checksum.to_le_bytes());
    }
}

/// Changes bytes of a small file at an offset in the content of a section, and returns the error.
fn changed(section: usize, offset: usize, new: &[u8]) -> String {
    let mut bytes = written(&small());
    let sections = sections(&bytes);
    let at = sections[section].0 + 12 + offset;
    bytes[at..at + new.len()].copy_from_slice(new);
    seal(&mut bytes, &sections);
    message(&bytes)
}

fn meshes() -> impl Strategy<Value = Mesh> {
    let positions = prop::collection::vec(prop::array::uniform3(-4_i8..4), 3..24);
    let attributes = prop::collection::vec((0_u8..8, 1_u8..5), 0..4);
    (positions, prop::collection::vec(prop::array::uniform3(0_usize..24), 0..40), attributes).prop_map(
        |(positions, triangles, attributes)| {
            let count = positions.len();
            let corners = triangles.as_flattened().iter().map(|&v| (v % count) as u32).collect();
            let positions: Vec<_> = positions.into_iter().map(|p| p.map(f32::from)).collect();
            let mut mesh = Mesh::new(positions, Faces::from_triangles(corners).unwrap()).unwrap();
            for (number, components) in attributes {
                mesh = mesh.with_attribute(attribute(number, components, count)).unwrap();
            }
            mesh
        },
    )
}

proptest! {
    #[test]
    fn any_mesh_is_read_again(mesh in meshes()) {
        let model = model_of(mesh);
        let bytes = written(&model);
        let again = read_all(&bytes).unwrap();
        prop_assert!(again == model);
        prop_assert_eq!(written(&again), bytes);
    }
}

#[test]
fn models_are_read_again() {
    let mut collapse_count = 0;
    for name in ["catmark_bishop.ply", "fish_control.ply", "hand.ply", "milktruck.glb", "wingnut.ply"] {
        for part in tristrip_io::read_path(test_model(name)).unwrap().parts {
            let vertex_count = part.mesh.vertex_count();
            let model = model_of(part.mesh);
            collapse_count += model.sequence.len();
            let again = read_all(&written(&model)).unwrap();
            assert!(again == model && again.mesh.vertex_count() == vertex_count, "{name}");
        }
    }
    assert!(collapse_count > 10_000, "{collapse_count}");
}

#[test]
fn the_bytes_of_version_1_stay_what_they_are() {
    let bytes = std::fs::read(test_model("fish_control.tlod")).unwrap();
    let model = read_all(&bytes).unwrap();
    assert_eq!((model.mesh.vertex_count(), model.sequence.triangles().len()), (112, 3 * 220));
    assert!(written(&model) == bytes);
}

#[test]
fn an_empty_model_is_read_again() {
    let model = TlodModel::new(Mesh::default(), Strips::default(), CollapseSequence::default()).unwrap();
    let bytes = written(&model);
    assert_eq!(bytes.len(), 12 + 4 * 16 + 28);
    assert!(read_all(&bytes).unwrap() == model);
}

#[test]
fn every_bit_of_an_attribute_is_kept() {
    let values = [f32::NAN, -0.0, f32::from_bits(0x7f80_0001), f32::NEG_INFINITY];
    let data = AttributeData::F32(values.to_vec());
    let attribute = Attribute { name: String::new(), components: 1, normalized: true, data };
    let mesh = Mesh::new(vec![[-0.0; 3]; 4], Faces::from_triangles(Vec::new()).unwrap()).unwrap();
    let mesh = mesh.with_attribute(attribute).unwrap();
    let sequence = CollapseSequence::from_collapses(4, Vec::new(), []).unwrap();
    let bytes = written(&TlodModel::new(mesh, Strips::default(), sequence).unwrap());
    let again = read_all(&bytes).unwrap();
    let AttributeData::F32(read) = &again.mesh.attributes()[0].data else { panic!("other values") };
    assert_eq!(read.iter().map(|x| x.to_bits()).collect::<Vec<_>>(), values.map(f32::to_bits));
    assert!(again.mesh.positions()[0][0].is_sign_negative() && written(&again) == bytes);
}

#[test]
fn polygons_become_the_triangles_of_the_strips() {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mesh = Mesh::new(positions, Faces::from_polygons([[0, 1, 2, 3]]).unwrap()).unwrap();
    let strips = Strips::from_parts(vec![1, 2, 0, 3], vec![4]).unwrap();
    // An order that differs from that of the strips.
    let sequence = CollapseSequence::from_collapses(4, vec![0, 2, 3, 0, 1, 2], []).unwrap();
    let model = TlodModel::new(mesh.clone(), strips.clone(), sequence).unwrap();
    assert_eq!(model.sequence.triangles(), [1, 2, 0, 0, 2, 3]);
    assert_eq!(model.mesh.faces().corners(), model.sequence.triangles());
    let other = CollapseSequence::from_collapses(4, vec![0, 1, 3, 1, 2, 3], []).unwrap();
    let wrong = TlodModel::new(mesh.clone(), strips.clone(), other).unwrap_err().to_string();
    assert!(wrong.starts_with("strips of the collapses: triangles missing: 2, "), "{wrong}");
    let larger = CollapseSequence::from_collapses(5, vec![0, 2, 3, 0, 1, 2], []).unwrap();
    let wrong = TlodModel::new(mesh, strips, larger).unwrap_err().to_string();
    assert_eq!(wrong, "vertices of the collapses: found 5, expected 4");
}

#[test]
fn a_model_whose_fields_were_changed_is_not_written() {
    let mut model = small();
    model.strips.push(&[0, 1, 2]);
    let refused = |model: &TlodModel| write(model, &mut Vec::new()).unwrap_err().to_string();
    assert!(refused(&model).starts_with("triangles: found differences"));
    model.strips.push(&[8]);
    assert_eq!(refused(&model), "strip 4, vertex 0: found vertex index 8, expected less than 8");
    model.sequence = CollapseSequence::default();
    assert!(refused(&model).starts_with("vertices of the collapses: found 0"));
}

#[test]
fn strips_with_welds_are_refused() {
    let (a, b, c, d) = ([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]);
    let mesh = Mesh::new(vec![a, b, c, c, b, d], Faces::from_triangles((0..6).collect()).unwrap()).unwrap();
    let strips = stripify(&mesh, &StripifyOptions::default().with_weld(true)).unwrap();
    let sequence = CollapseSequence::from_collapses(6, strips.to_list(), []).unwrap();
    let wrong = TlodModel::new(mesh, strips, sequence).unwrap_err().to_string();
    assert_eq!(wrong, "strips: found 2 welded vertices, expected no welds");
}

#[test]
fn every_truncation_is_an_error() {
    let bytes = written(&small());
    for length in 0..bytes.len() {
        let message = message(&bytes[..length]);
        assert!(message.starts_with(&format!("byte {length}: found the end of the file, ")), "{message}");
    }
    let hand = tristrip_io::read_path(test_model("hand.ply")).unwrap().parts.remove(0).mesh;
    let bytes = written(&model_of(hand));
    for length in (0..bytes.len()).step_by(1 << 10) {
        assert!(read_all(&bytes[..length]).is_err(), "{length} of {} bytes", bytes.len());
    }
}

#[test]
fn every_changed_bit_is_an_error() {
    let bytes = written(&small());
    let mut random = random();
    for _ in 0..10_000 {
        let (at, bit) = (random(bytes.len()), random(8));
        let mut changed = bytes.clone();
        changed[at] ^= 1 << bit;
        assert!(read_all(&changed).is_err(), "bit {bit} of byte {at}");
    }
}

#[test]
fn changes_with_right_checksums_give_a_model_or_an_error() {
    let bytes = written(&small());
    let sections = sections(&bytes);
    let mut random = random();
    let mut models = 0;
    for _ in 0..20_000 {
        let mut changed = bytes.clone();
        for _ in 0..=random(2) {
            let (start, end) = sections[random(sections.len())];
            let at = start + 12 + random(end - start - 12);
            changed[at] = if random(2) == 0 { random(256) as u8 } else { changed[at] ^ (1 << random(8)) };
        }
        seal(&mut changed, &sections);
        if let Ok(model) = read_all(&changed) {
            models += 1;
            assert!(written(&model) == changed);
        }
    }
    assert!(models > 100, "{models}");
}

#[test]
fn counts_without_data_are_errors() {
    let mut start = b"\x89TLOD\r\n\x1a\x01\0\0\0HEAD\x1c\0\0\0\0\0\0\0".to_vec();
    start.extend([255; 28]);
    let start_40 = &start[..40];
    assert_eq!(message(start_40), "byte 40: found the end of the file, expected counts");
    let checksum = crc32fast::hash(&start[12..]);
    start.extend(checksum.to_le_bytes());
    assert_eq!(message(&start), "byte 24, vertices: found 4294967295, the limit is 67108864");
    let limits = TlodLimits::default()
        .with_vertices(u32::MAX)
        .with_attributes(u32::MAX)
        .with_triangles(u32::MAX)
        .with_collapses(u32::MAX)
        .with_bytes(u64::MAX);
    let message = |bytes: &[u8]| read(bytes, &limits).unwrap_err().to_string();
    assert_eq!(message(&start), "byte 56: found the end of the file, expected section POSN");
    let mut long = start.clone();
    long.extend(b"POSN");
    long.extend((12 * u64::from(u32::MAX)).to_le_bytes());
    assert_eq!(message(&long), "byte 68: found the end of the file, expected positions");
    let longer = [&start[..], b"POSN", &[255; 8]].concat();
    let expected = "byte 60: found 18446744073709551615 bytes in section POSN, expected 51539607540, according to the counts";
    assert_eq!(message(&longer), expected);
    // The counts alone do not determine the length of an attribute section.
    let mut attribute = written(&small());
    let at = sections(&attribute)[2].0;
    attribute[at + 4..at + 12].copy_from_slice(&[255; 8]);
    let found = message(&attribute);
    assert!(found.contains("18446744073709551615 bytes in section ATTR, expected 49"), "{found}");
}

#[test]
fn limits_are_kept() {
    let bytes = written(&small());
    let limits = TlodLimits::default();
    let exact = limits
        .with_vertices(8)
        .with_triangles(4)
        .with_collapses(3)
        .with_attributes(8)
        .with_name_bytes(9)
        .with_bytes(bytes.len() as u64);
    assert!(read(&bytes[..], &exact).is_ok());
    let less = [
        (exact.with_vertices(7), "byte 24, vertices: found 8, the limit is 7"),
        (exact.with_attributes(7), "byte 28, attributes: found 8, the limit is 7"),
        (exact.with_triangles(3), "byte 40, triangles: found 4, the limit is 3"),
        (exact.with_collapses(2), "byte 44, collapses: found 3, the limit is 2"),
        (exact.with_name_bytes(8), "byte 180, bytes of a name: found 9, the limit is 8"),
        (exact.with_bytes(7), "byte 0, the file: found 8, the limit is 7"),
    ];
    for (limits, expected) in less {
        assert_eq!(read(&bytes[..], &limits).unwrap_err().to_string(), expected);
    }
    for limit in 0..bytes.len() as u64 {
        let wrong = read(&bytes[..], &exact.with_bytes(limit)).unwrap_err();
        assert!(matches!(wrong, Error::LimitExceeded { .. }), "{limit}: {wrong}");
    }
}

#[test]
fn a_bad_strip_vertex_is_reported_by_its_position_and_not_as_a_corner_of_a_face() {
    let bytes = std::fs::read(test_model("../issues/strip_vertex_out_of_range.tlod")).unwrap();
    assert_eq!(message(&bytes), "byte 148: found vertex 9, expected less than 4");
    // The same strips with the same vertices, built by a caller.
    let mesh = Mesh::new(vec![[0.0; 3]; 4], Faces::default()).unwrap();
    let mut strips = Strips::default();
    strips.push(&[0, 2, 1]);
    strips.push(&[3, 0, 2, 9]);
    let none = CollapseSequence::from_collapses(4, vec![], []).unwrap();
    let wrong = TlodModel::new(mesh, strips, none).unwrap_err().to_string();
    assert_eq!(wrong, "strip 1, vertex 3: found vertex index 9, expected less than 4");
}

/// Returns one byte per call, after an interruption.
struct Slow<'a>(&'a [u8], bool);

impl Read for Slow<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.1 = !self.1;
        if self.1 {
            return Err(io::ErrorKind::Interrupted.into());
        }
        let one = bytes.len().min(1);
        self.0.read(&mut bytes[..one])
    }
}

/// Fails after a number of bytes.
struct Broken(usize);

impl Read for Broken {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let count = bytes.len().min(self.0);
        if count == 0 {
            return Err(io::Error::other("the line is cut"));
        }
        bytes[..count].copy_from_slice(&b"\x89TLOD\r\n\x1a\x01\0\0\0"[12 - self.0..][..count]);
        self.0 -= count;
        Ok(count)
    }
}

#[test]
fn sources_may_be_slow_or_fail() {
    let model = small();
    let bytes = written(&model);
    assert!(read(Slow(&bytes, false), &TlodLimits::default()).unwrap() == model);
    let wrong = read(Broken(12), &TlodLimits::default()).unwrap_err();
    assert_eq!(wrong.to_string(), "byte 12 of the model: the line is cut");
    let full = write(&model, &mut &mut [0; 100][..]).unwrap_err().to_string();
    assert!(full.starts_with("the target of the model: "), "{full}");
}

#[test]
fn errors_say_where_and_what() {
    let good = written(&small());
    assert_eq!(message(b"ply\nformat"), "byte 0: found `ply\\nform`, expected a .tlod file");
    let mut bytes = good.clone();
    bytes[8] = 2;
    assert_eq!(message(&bytes), "byte 8: found version 2, expected version 1");
    bytes = good.clone();
    bytes[12..16].copy_from_slice(b"WHAT");
    assert_eq!(message(&bytes), "byte 12: found the unknown section WHAT, expected section HEAD");
    bytes[12..16].copy_from_slice(b"POSN");
    assert_eq!(message(&bytes), "byte 12: found section POSN, expected section HEAD");
    bytes = good.clone();
    bytes.push(0);
    let expected = format!("byte {}: found more bytes, expected the end of the file", good.len());
    assert_eq!(message(&bytes), expected);
    bytes = good.clone();
    bytes[70] ^= 1;
    assert!(message(&bytes).starts_with("byte 164: found checksum "), "{}", message(&bytes));

    let (head, positions, attribute, strips, collapses) = (0, 1, 2, 10, 11);
    let number = u32::to_le_bytes;
    for (section, offset, new, expected) in [
        (head, 24, number(9), "byte 48: found 9 renames, expected at most 8, one per vertex"),
        (head, 16, number(5), "found 4 triangles, expected 5, the declared count"),
        (positions, 12, f32::NAN.to_le_bytes(), "vertex 1: found coordinate NaN, expected a finite number"),
        (
            attribute,
            4,
            [8, 1, 0, 0],
            "byte 184: found type 8, components 1, normalized 0, 0, expected a type",
        ),
        (
            attribute,
            4,
            [0, 0, 0, 0],
            "byte 184: found type 0, components 0, normalized 0, 0, expected a type",
        ),
        (
            attribute,
            4,
            [0, 1, 2, 0],
            "byte 184: found type 0, components 1, normalized 2, 0, expected a type",
        ),
        (
            attribute,
            8,
            [b'T', 0xff, b'P', b'E'],
            "byte 188: found `T\\xffPE_0 \\xc3\\xa9`, expected a name in UTF-8",
        ),
        (strips, 4, number(3), "found end 3 of strips, expected at least 4, the previous end"),
        (strips, 8, number(10), "found end 10 of strips, expected 9, the total number"),
        (strips, 12, number(8), "found vertex 8, expected less than 8"),
        (
            collapses,
            0,
            (-1.0_f32).to_le_bytes(),
            "parameter `error`: found -1 of collapse 0 from the full mesh",
        ),
        (collapses, 16, number(0), "found end 0 of collapses, expected at least 1, the previous end"),
        (
            collapses,
            24,
            number(7),
            "parameter `collapses`: found 7 renamed to 4 by collapse 0 from the full mesh",
        ),
        (
            collapses,
            28,
            number(5),
            "parameter `collapses`: found 5 renamed to 5 by collapse 0 from the full mesh",
        ),
    ] {
        let message = changed(section, offset, &new);
        assert!(message.contains(expected), "{message}\n{expected}");
    }
}
