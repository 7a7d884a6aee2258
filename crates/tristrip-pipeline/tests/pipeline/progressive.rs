//! Progressive GLB: every level of packed models, truncated files, and damaged files.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use tristrip::stream::{StreamLimits, StreamOptions};
use tristrip_io::gltf::{ArrivalLimits, ArrivingGlb, ProgressiveGlb};
use tristrip_io::{Format, Model, read};
use tristrip_pipeline::{
    Error, Observer, inspect, levels::Level, pack, stream_of_mesh, unpack, unpack::StreamGoal,
};

fn model(name: &str) -> Model {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/models");
    tristrip_io::read_path(Path::new(folder).join(name)).unwrap()
}

/// A hilly grid of quadrilaterals in two materials. The border between them is a zigzag.
fn two_materials(n: usize) -> Model {
    let mut obj = String::new();
    for (y, x) in (0..n).flat_map(|y| (0..n).map(move |x| (y, x))) {
        writeln!(obj, "v {x} {y} {}", (x * 7 + y * y * 3) % 5).unwrap();
    }
    for material in 0..2 {
        writeln!(obj, "usemtl {material}").unwrap();
        for (y, x) in (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (y, x))) {
            if usize::from(x + y % 3 > n / 2) == material {
                let v = n * y + x + 1;
                writeln!(obj, "f {v} {} {} {}", v + 1, v + n + 1, v + n).unwrap();
            }
        }
    }
    read(obj.as_bytes(), Format::Obj).unwrap()
}

fn packed(model: &Model) -> Vec<u8> {
    pack::run(model, &pack::Options::default(), &()).unwrap().bytes
}

fn open(bytes: &[u8]) -> ProgressiveGlb {
    ProgressiveGlb::open(bytes.to_vec()).unwrap().unwrap()
}

fn unpack_to(glb: &ProgressiveGlb, goal: StreamGoal) -> Result<unpack::Outcome, Error> {
    unpack::run(glb, &unpack::Options::default().with_goal(goal), &())
}

fn at(glb: &ProgressiveGlb, goal: StreamGoal) -> unpack::Outcome {
    let unpacked = unpack_to(glb, goal).unwrap();
    assert_eq!(unpacked.problem, None);
    unpacked
}

/// Counts the edges of one triangle, over the positions of all parts.
fn border(model: &Model) -> usize {
    let mut edges: HashMap<[[u32; 3]; 2], usize> = HashMap::new();
    for part in &model.parts {
        let position = |v: u32| part.mesh.positions()[v as usize].map(f32::to_bits);
        for face in part.mesh.faces().iter() {
            for i in 0..3 {
                let mut edge = [position(face[i]), position(face[(i + 1) % 3])];
                edge.sort_unstable();
                *edges.entry(edge).or_default() += 1;
            }
        }
    }
    edges.values().filter(|&&count| count == 1).count()
}

#[test]
fn borders_between_materials_stay_closed_at_every_level() {
    let n = 24;
    let glb = open(&packed(&two_materials(n)));
    assert_eq!(glb.primitive_count(), 2);
    let full = at(&glb, StreamGoal::Level(Level::Percent(100.0)));
    assert_eq!((full.level, full.triangles), (full.levels, 2 * (n - 1) * (n - 1)));
    assert_eq!(border(&full.model), 4 * (n - 1));
    // At the lowest levels, positions are only known to a few units.
    for level in (full.levels / 4..=full.levels).step_by(7) {
        let part = at(&glb, StreamGoal::Level(Level::Number(level)));
        assert_eq!(part.level, level);
        assert_eq!(part.model.parts.len(), 2);
        // If a crack opens, edges of one triangle lie inside the grid.
        let outer = part.model.parts.iter().flat_map(|part| {
            part.mesh
                .positions()
                .iter()
                .filter(|p| p[..2].iter().any(|x| x.abs() < 0.5 || (x - (n - 1) as f32).abs() < 0.5))
        });
        let outer: HashSet<[u32; 3]> = outer.map(|p| p.map(f32::to_bits)).collect();
        assert_eq!(border(&part.model), outer.len(), "level {level}");
    }
    let beyond = unpack_to(&glb, StreamGoal::Level(Level::Number(full.levels + 1)));
    assert!(beyond.unwrap_err().to_string().contains("level: found"));
}

#[test]
fn goals_are_reached_as_closely_as_possible() {
    let bytes = packed(&model("milktruck.glb"));
    let glb = open(&bytes);
    let figures = inspect::run(&glb, &()).unwrap();
    assert_eq!(figures.problem, None);
    let full = at(&glb, StreamGoal::Level(Level::Percent(100.0)));
    assert_eq!(full.bytes, glb.chunk_start() + glb.chunk_bytes());
    let base = at(&glb, StreamGoal::Triangles(0));
    for wanted in (base.triangles..full.triangles).step_by(97) {
        let part = at(&glb, StreamGoal::Triangles(wanted));
        assert!(part.triangles <= wanted && part.triangles + 3 > wanted, "{} for {wanted}", part.triangles);
    }
    for chunk in &figures.chunks {
        let part = at(&glb, StreamGoal::Bytes(chunk.end));
        assert_eq!((part.bytes, part.level, part.triangles), (chunk.end, chunk.level, chunk.triangles));
        let before = at(&glb, StreamGoal::Bytes(chunk.end - 1));
        assert!(before.bytes < chunk.end);
    }
}

#[test]
fn a_scene_keeps_all_but_its_meshes() {
    let source = model("milktruck.glb");
    let bytes = packed(&source);
    let again = read(&bytes, Format::Glb).unwrap();
    let beyond = |model: &Model| model.scene.as_ref().map(tristrip_io::gltf::Scene::beyond_parts);
    assert_eq!(beyond(&again), beyond(&source));
    assert_eq!(again.parts.len(), source.parts.len());
    for (a, b) in again.parts.iter().zip(&source.parts) {
        assert_eq!(a.mesh.faces().triangle_count(), b.mesh.faces().triangle_count());
        let names = |part: &tristrip_io::Part| -> Vec<String> {
            part.mesh.attributes().iter().map(|attribute| attribute.name.clone()).collect()
        };
        let sorted = |mut names: Vec<String>| {
            names.sort();
            names
        };
        assert_eq!(sorted(names(a)), sorted(names(b)));
    }
    // A GLB of the full meshes has no traces of the stream.
    let drawings = vec![tristrip_io::Drawing::Faces; again.parts.len()];
    let plain = tristrip_io::write(&again, &drawings, Format::Glb, tristrip::Layout::List).unwrap();
    assert!(!String::from_utf8_lossy(&plain).contains("TRISTRIP_progressive"));
    let once_more = read(&plain, Format::Glb).unwrap();
    for (a, b) in again.parts.iter().zip(&once_more.parts) {
        assert_eq!(a.mesh, b.mesh);
    }
}

#[test]
fn a_file_that_is_cut_at_any_byte_gives_what_is_complete() {
    let bytes = packed(&two_materials(20));
    let whole = open(&bytes);
    let ends: Vec<usize> = inspect::run(&whole, &()).unwrap().chunks.iter().map(|chunk| chunk.end).collect();
    assert!(ends.len() > 1);
    let full = at(&whole, StreamGoal::Level(Level::Percent(100.0)));
    for end in 0..bytes.len() {
        let Ok(opened) = ProgressiveGlb::open(bytes[..end].to_vec()) else {
            assert!(end < whole.chunk_start(), "{end}");
            continue;
        };
        // Fewer than four bytes are not known to be a GLB.
        let Some(glb) = opened else {
            assert!(end < 4, "{end}");
            continue;
        };
        let part = unpack_to(&glb, StreamGoal::Level(Level::Percent(100.0))).unwrap();
        let complete = ends.iter().filter(|&&chunk| chunk <= end).count();
        assert_eq!(part.chunks, complete, "{end}");
        assert_eq!(part.problem.is_none(), complete == ends.len(), "{end}");
        assert!(part.triangles <= full.triangles);
        // The base meshes are drawn without any chunk.
        assert!(part.model.parts.iter().all(|part| part.mesh.faces().triangle_count() > 0));
    }
}

#[test]
fn damaged_files_are_reported() {
    let bytes = packed(&two_materials(16));
    let start = open(&bytes).chunk_start();
    let mut random = 1_u32;
    let mut next = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (random >> 8) as usize
    };
    let (mut refused, mut reported) = (0, 0);
    for _ in 0..3_000 {
        let mut damaged = bytes.clone();
        let at = next() % bytes.len();
        damaged[at] ^= 1 << (next() % 8);
        let result = ProgressiveGlb::open(damaged.clone());
        let Ok(Some(glb)) = result else {
            refused += 1;
            continue;
        };
        let unpacked = unpack_to(&glb, StreamGoal::Level(Level::Percent(100.0)));
        let read = read(&damaged, Format::Glb);
        if at >= start && at < start + glb.chunk_bytes() {
            // Every byte of the chunks is covered by a checksum. A damaged header may require more
            // bytes than the file has.
            assert!(unpacked.is_ok_and(|unpacked| unpacked.problem.is_some()), "{at}");
            assert!(read.is_err(), "{at}");
            reported += 1;
        }
    }
    assert!(refused > 100 && reported > 500, "{refused}, {reported}");
}

#[test]
fn files_without_a_stream_are_told_apart() {
    let glb =
        std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/models/milktruck.glb")).unwrap();
    assert!(ProgressiveGlb::open(glb).unwrap().is_none());
    for bytes in [&b""[..], b"glT", b"ply\n", b"glTF\x02\0\0\0\xff\xff\xff\x7f"] {
        assert!(!matches!(ProgressiveGlb::open(bytes.to_vec()), Ok(Some(_))));
    }
}

#[test]
fn opening_a_file_does_not_copy_it() {
    let file = std::sync::Arc::new(packed(&two_materials(20)));
    let glb = ProgressiveGlb::open(std::sync::Arc::clone(&file)).unwrap().unwrap();
    assert_eq!(glb.chunks().as_ptr_range(), file[glb.chunk_start()..][..glb.chunk_bytes()].as_ptr_range());
}

#[test]
fn what_is_near_the_eye_is_refined_first() {
    let n = 40;
    let mut obj = String::new();
    for (y, x) in (0..n).flat_map(|y| (0..n).map(move |x| (y, x))) {
        writeln!(obj, "v {x} {y} {}", (x as f32 * 0.5).sin() + (y as f32 * 0.4).cos()).unwrap();
    }
    for (y, x) in (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (y, x))) {
        let v = n * y + x + 1;
        writeln!(obj, "f {v} {} {} {}", v + 1, v + n + 1, v + n).unwrap();
    }
    let model = read(obj.as_bytes(), Format::Obj).unwrap();
    let near = |eye: Option<[f32; 3]>| {
        let packed = pack::run(&model, &pack::Options::default().with_eye(eye), &()).unwrap();
        let part = at(&open(&packed.bytes), StreamGoal::Level(Level::Percent(30.0)));
        let positions = part.model.parts.iter().flat_map(|part| part.mesh.positions().iter());
        positions.filter(|p| p[0] + p[1] < n as f32 / 2.0).count()
    };
    let [from_eye, alike] = [near(Some([0.0, 0.0, 2.0])), near(None)];
    assert!(2 * from_eye > 3 * alike, "{from_eye}, {alike}");
}

/// Cancels at the n-th call.
struct CancelAt {
    asked: AtomicUsize,
    at: usize,
}

impl Observer for CancelAt {
    fn is_cancelled(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.at
    }
}

#[test]
fn packing_is_cancelled_between_stages_and_meshes() {
    let model = model("milktruck.glb");
    let run = |at| {
        let observer = CancelAt { asked: AtomicUsize::new(0), at };
        let result = pack::run(&model, &pack::Options::default(), &observer).map(|packed| packed.meshes);
        (result, observer.asked.into_inner())
    };
    let (meshes, asked) = run(usize::MAX);
    let meshes = meshes.unwrap();
    assert!(meshes > 1 && asked >= meshes + 3, "{asked} of {meshes}");
    for at in 0..asked {
        assert!(matches!(run(at).0, Err(Error::Cancelled)), "{at}");
    }
}

#[test]
fn tiny_meshes_are_not_refined() {
    let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj).unwrap();
    let packed = pack::run(&model, &pack::Options::default(), &()).unwrap();
    assert_eq!((packed.meshes, packed.chunks, packed.triangles, packed.vertices), (0, 0, 1, 3));
    assert!(packed.notes.iter().any(|note| note.contains("not refined")), "{:?}", packed.notes);
    assert!(ProgressiveGlb::open(packed.bytes).unwrap().is_none());
}

#[test]
fn more_position_bits_are_nearer_to_the_input() {
    let error = |bits: u32| {
        let stream = StreamOptions::default().with_position_bits(bits);
        let options = pack::Options::default().with_stream(stream);
        pack::run(&two_materials(16), &options, &()).unwrap().position_error
    };
    assert!(error(10) > 12.0 * error(14));
}

/// Replaces the first occurrence of a text in the JSON of a GLB.
fn with_json(glb: &[u8], from: &str, to: &str) -> Vec<u8> {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let (json, bin) = (std::str::from_utf8(&glb[20..20 + length]).unwrap(), &glb[20 + length..]);
    assert!(json.contains(from), "{json}");
    let mut json = json.replacen(from, to, 1);
    while json.len() % 4 > 0 {
        json.push(' ');
    }
    let total = (20 + json.len() + bin.len()) as u32;
    let json_length = (json.len() as u32).to_le_bytes();
    [&glb[..8], &total.to_le_bytes(), &json_length, &glb[16..20], json.as_bytes(), bin].concat()
}

#[test]
fn parts_stay_closed_beside_one_with_morph_targets() {
    // Two tiles that meet at x = 20, the left one with a morph target.
    let n = 21;
    let mut obj = String::new();
    for (y, x) in (0..n).flat_map(|y| (0..2 * n - 1).map(move |x| (y, x))) {
        writeln!(obj, "v {x} {y} {}", (x as f32 * 0.5).sin() + (y as f32 * 0.4).cos()).unwrap();
    }
    for tile in 0..2 {
        writeln!(obj, "usemtl {tile}").unwrap();
        for (y, x) in (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (y, x + tile * (n - 1)))) {
            let (v, above) = ((2 * n - 1) * y + x + 1, 2 * n - 1);
            writeln!(obj, "f {v} {} {} {}", v + 1, v + above + 1, v + above).unwrap();
        }
    }
    let model = read(obj.as_bytes(), Format::Obj).unwrap();
    let drawings = vec![tristrip_io::Drawing::Faces; 2];
    let glb = tristrip_io::write(&model, &drawings, Format::Glb, tristrip::Layout::List).unwrap();
    let glb = with_json(&glb, "\"mode\":4", "\"mode\":4,\"targets\":[{\"POSITION\":0}]");
    let packed = packed(&read(&glb, Format::Glb).unwrap());
    let base = at(&open(&packed), StreamGoal::Level(Level::Number(0)));
    assert!(base.triangles < 2 * (n - 1) * (n - 1));
    let right = base.model.parts[1].mesh.positions();
    for y in 0..n {
        let is_near = |p: &&[f32; 3]| (p[0] - 20.0).abs() < 0.01 && (p[1] - y as f32).abs() < 0.01;
        assert!(right.iter().any(|p| is_near(&p)), "no vertex at the border at {y}");
    }
}

#[test]
fn wrong_documents_are_refused() {
    let bytes = packed(&two_materials(16));
    let view = ProgressiveGlb::open(bytes.clone()).unwrap().map(|_| "\"bufferView\":0").unwrap();
    let refused = |from: &str, to: &str| {
        let glb = with_json(&bytes, from, to);
        let level = StreamGoal::Level(Level::Percent(100.0));
        let unpacked = ProgressiveGlb::open(glb.clone()).map(|glb| glb.map(|glb| unpack_to(&glb, level)));
        assert!(read(&glb, Format::Glb).is_err(), "{from} became {to}");
        assert!(!matches!(unpacked, Ok(Some(Ok(_)))), "{from} became {to}");
    };
    refused(view, "\"bufferView\":99");
    refused("\"version\":1", "\"version\":2");
    refused("\"stream\":0,\"part\":0", "\"stream\":0,\"part\":-1");
    refused("\"stream\":0,\"part\":0", "\"stream\":\"0\"");
    refused("\"scene\":0", "\"scene\":0,\"images\":[{\"bufferView\":2,\"mimeType\":\"image/png\"}]");
}

#[test]
fn a_file_that_arrives_byte_by_byte_gives_what_is_complete() {
    let model = two_materials(20);
    let bytes = packed(&model);
    let glb = open(&bytes);
    let mut arriving = ArrivingGlb::new(ArrivalLimits::default()).keeping_strips();
    let meshes = |model: &Model| model.parts.iter().map(|part| part.mesh.clone()).collect::<Vec<_>>();
    let mut seen = HashSet::new();
    for (at, byte) in bytes.iter().enumerate() {
        assert_eq!(arriving.offset(), at as u64);
        assert_eq!(arriving.is_complete(), at >= glb.chunk_start() + glb.chunk_bytes(), "byte {at}");
        assert_eq!(arriving.has_base(), at >= glb.chunk_start(), "byte {at}");
        arriving.update(std::slice::from_ref(byte)).unwrap();
        let chunks = arriving.decoder().map_or(0, tristrip::stream::Decoder::chunk_count);
        if arriving.has_base() && seen.insert(chunks) {
            // The truncated file, written as a file of its own, has the same meshes. Without its
            // first chunk it has the base meshes.
            let now = arriving.model(None).unwrap().unwrap();
            let cut = unpack_to(&open(&bytes[..=at]), StreamGoal::Bytes(at + 1)).unwrap().model;
            assert_eq!(meshes(&now), meshes(&cut));
        }
    }
    arriving.finish().unwrap();
    let mut whole = ArrivingGlb::new(ArrivalLimits::default());
    assert_eq!(whole.update(&bytes).unwrap(), seen.len() - 1);
    let prints = |glb: &ArrivingGlb| glb.parts().map(|(_, part)| part.fingerprint()).collect::<Vec<_>>();
    assert_eq!(prints(&whole), prints(&arriving));
    assert_eq!(meshes(&whole.model(None).unwrap().unwrap()), meshes(&read(&bytes, Format::Glb).unwrap()));
}

#[test]
fn files_that_arrive_are_checked_and_limited() {
    let bytes = packed(&two_materials(20));
    let glb = open(&bytes);
    let update = |bytes: &[u8], limits: ArrivalLimits| {
        let mut arriving = ArrivingGlb::new(limits);
        let error = arriving.update(bytes).unwrap_err().to_string();
        // The error persists, whatever bytes follow.
        assert_eq!(arriving.update(&[]).unwrap_err().to_string(), error);
        assert_eq!(arriving.finish().unwrap_err().to_string(), error);
        error
    };
    let usual = ArrivalLimits::default();
    assert_eq!(update(b"gl_", usual), "byte 0: found \"gl_\", expected `glTF` of a GLB");
    let with = |at: usize, byte: u8| {
        let mut bytes = bytes.clone();
        bytes[at] = byte;
        bytes
    };
    assert_eq!(update(&with(4, 3), usual), "byte 4: found GLB version 3, expected 2");
    assert!(update(&with(16, b'_'), usual).starts_with("byte 16: found chunk type"));
    let damaged = update(&with(bytes.len() - 9, bytes[bytes.len() - 9] ^ 1), usual);
    assert!(damaged.contains("the chunk is damaged"), "{damaged}");
    let few = usual.with_kept_bytes(100);
    let kept = update(&bytes, few);
    assert!(kept.starts_with("bytes before the first chunk: found ") && kept.ends_with("the limit is 100"));
    let stream = StreamLimits { triangles: 100, ..usual.stream };
    let triangles = update(&bytes, usual.with_stream(stream));
    assert!(
        triangles.contains("of the stream, triangles: found ") && triangles.ends_with("the limit is 100")
    );
    let stream = StreamLimits { meshes: 0, ..usual.stream };
    assert!(update(&bytes, usual.with_stream(stream)).ends_with("meshes: found 1, the limit is 0"));
    for end in [0, 10, 30, glb.chunk_start() - 1, glb.chunk_start() + 5] {
        let mut arriving = ArrivingGlb::new(usual);
        arriving.update(&bytes[..end]).unwrap();
        let error = arriving.finish().unwrap_err().to_string();
        assert!(error.starts_with(&format!("file: found the end of the file after {end} bytes")), "{error}");
    }
}

/// The stream of the dragon had 108 triangles fewer than the model, without a note.
#[test]
fn a_stream_counts_triangles_whose_corners_become_equal() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../testdata/issues/equal_corners.obj");
    let model = tristrip_io::read_path(path).unwrap();
    let streamed = stream_of_mesh(&model.parts[0].mesh, 0, &StreamOptions::default()).unwrap();
    assert_eq!((streamed.triangles, streamed.dropped_triangles), (2, 1));
}
