//! Images of a textured scene that is built here: strips change no pixel, simplification opens no
//! holes, a torn mesh is detected, and a level of detail looks the same in a scene and in its own
//! file.
#![allow(clippy::unwrap_used, reason = "tests")]

use std::f64::consts::PI;

use serde_json::Value;
use tristrip_io::{Format, Model, read, with_triangles};
use tristrip_pipeline::{Amount, Deviation, Goal, Ratio, chain, encode, simplify, strip};
use tristrip_render::images::{Differences, Mode, TexturedModel, compare, rows_of_sides};

/// The number of quadrilaterals around, and from pole to pole.
const AROUND: usize = 32;
const DOWN: usize = 20;

/// Returns a chequered image of 16 × 16 pixels as a PNG file.
fn chequers() -> Vec<u8> {
    let pixel =
        |at: usize| if (at % 16 / 4 + at / 64).is_multiple_of(2) { [200, 60, 40] } else { [40, 90, 210] };
    let data: Vec<u8> = (0..256).flat_map(pixel).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16, 16);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    bytes
}

/// Returns a GLB of two eggs, one larger and rotated: normals, a seam in the texture coordinates,
/// and a texture.
fn eggs() -> Vec<u8> {
    let (mut positions, mut normals, mut coordinates) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..=DOWN {
        for column in 0..=AROUND {
            let [u, v] = [column as f64 / AROUND as f64, row as f64 / DOWN as f64];
            let (around, down) = (2.0 * PI * (u + if column == AROUND { -1.0 } else { 0.0 }), PI * v);
            // Bit-identical at the seam and at the poles.
            let ring = if row == 0 || row == DOWN { 0.0 } else { down.sin() };
            let normal = [ring * around.cos(), down.cos(), ring * around.sin()];
            positions.extend([normal[0], 1.4 * normal[1], normal[2]].map(|x| x as f32));
            let scaled = [normal[0], normal[1] / 1.4, normal[2]];
            let length = scaled.iter().map(|x| x * x).sum::<f64>().sqrt();
            normals.extend(scaled.map(|x| (x / length) as f32));
            coordinates.extend([u as f32, v as f32]);
        }
    }
    let mut corners: Vec<u32> = Vec::new();
    for row in 0..DOWN as u32 {
        for column in 0..AROUND as u32 {
            let a = row * (AROUND as u32 + 1) + column;
            let c = a + AROUND as u32 + 1;
            if row > 0 {
                corners.extend([a, a + 1, c + 1]);
            }
            if row + 1 < DOWN as u32 {
                corners.extend([a, c + 1, c]);
            }
        }
    }
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let indices: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    let (mut bin, mut views) = (Vec::new(), Vec::new());
    for bytes in [floats(&positions), floats(&normals), floats(&coordinates), indices, chequers()] {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, bin.len(), bytes.len()));
        bin.extend(bytes);
        bin.resize(bin.len().next_multiple_of(4), 0);
    }
    let vertices = positions.len() / 3;
    let accessor = |view: usize, component: u32, count: usize, kind: &str| {
        format!(r#"{{"bufferView":{view},"componentType":{component},"count":{count},"type":"{kind}"}}"#)
    };
    let accessors = [
        accessor(0, 5126, vertices, "VEC3"),
        accessor(1, 5126, vertices, "VEC3"),
        accessor(2, 5126, vertices, "VEC2"),
        accessor(3, 5125, corners.len(), "SCALAR"),
    ];
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0,"children":[1]}},
                 {{"mesh":0,"translation":[2.5,0.5,0],"rotation":[0.6,0,0,0.8],"scale":[0.5,1.2,0.5]}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2}},"indices":3,"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}},"baseColorFactor":[1,0.9,0.8,1]}}}}],
        "textures":[{{"source":0}}],"images":[{{"bufferView":4,"mimeType":"image/png"}}],
        "accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#,
        accessors.join(","),
        views.join(","),
        bin.len()
    );
    glb(json, &bin)
}

/// Returns a GLB of a document and its buffer, whose size is a multiple of four bytes.
fn glb(json: String, bin: &[u8]) -> Vec<u8> {
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut glb = Vec::new();
    let length = 28 + json.len() + bin.len();
    for word in [0x4654_6c67, 2, length as u32, json.len() as u32, 0x4e4f_534a] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(json);
    for word in [bin.len() as u32, 0x004e_4942] {
        glb.extend(word.to_le_bytes());
    }
    glb.extend(bin);
    glb
}

/// Returns a square with these vertices, and further attributes of its primitive and members of the
/// document. The accessors: positions, normals, 8-bit joints, weights, two matrices, indices.
fn square(positions: [[f32; 3]; 4], attributes: &str, members: &str) -> Model {
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let column = |x: f32| [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, 0.0, 0.0, 1.0];
    let arrays = [
        floats(&positions.concat()),
        floats(&[[0.0, 0.0, 1.0]; 4].concat()),
        // The last joints are not in the skin.
        [[0, 1, 9, 9], [0, 1, 9, 9], [0, 1, 9, 9], [1, 0, 9, 9]].concat(),
        // Weights that do not sum to 1 are normalized; a vertex without weights follows its first
        // joint.
        floats(&[[1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 5.0], [0.5, 0.5, 0.0, 0.0], [0.0; 4]].concat()),
        floats(&[column(0.0), column(-1.0)].concat()),
        [0_u32, 1, 2, 2, 1, 3].map(u32::to_le_bytes).concat(),
    ];
    let kinds = [
        (5126, 4, "VEC3"),
        (5126, 4, "VEC3"),
        (5121, 4, "VEC4"),
        (5126, 4, "VEC4"),
        (5126, 2, "MAT4"),
        (5125, 6, "SCALAR"),
    ];
    let (mut bin, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    for (view, (bytes, (component, count, kind))) in arrays.iter().zip(kinds).enumerate() {
        views.push(format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":{}}}"#, bin.len(), bytes.len()));
        let accessor = r#""bufferView":VIEW,"componentType":COMPONENT,"count":COUNT,"type":"KIND""#;
        let accessor =
            accessor.replace("VIEW", &view.to_string()).replace("COMPONENT", &component.to_string());
        accessors
            .push(format!("{{{}}}", accessor.replace("COUNT", &count.to_string()).replace("KIND", kind)));
        bin.extend(bytes);
    }
    let (views, accessors, length) = (views.join(","), accessors.join(","), bin.len());
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1{attributes}}},"indices":5,
        "targets":[{{"POSITION":0,"NORMAL":1}}]}}]}}],"accessors":[{accessors}],"bufferViews":[{views}],"buffers":[{{"byteLength":{length}}}],{members}}}"#
    );
    read(&glb(json, &bin), Format::Glb).unwrap()
}

#[test]
fn skins_and_morph_targets_are_drawn_in_the_rest_pose() {
    let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [2.0, 2.0, 0.0]];
    let skinned = r#","JOINTS_0":2,"WEIGHTS_0":3"#;
    // The transform of the node with the skin is ignored. The second joint is 4 to the right, and
    // its inverse bind matrix moves 1 back.
    let nodes = r#""nodes":[{"mesh":0,"skin":0,"scale":[7,1,1]},{"children":[2]},{"translation":[4,0,0]}],
        "skins":[{"joints":[1,2],"inverseBindMatrices":4}]"#;
    let same = |before: &Model, after: &Model| {
        let models = [before, after].map(|model| TexturedModel::new(model).unwrap());
        let found = compare(&models[0], &models[1], Mode::Normals).unwrap();
        assert!(found.shown > 10_000, "{found:?}");
        found.different == 0
    };
    let plain = |corners| square(corners, "", r#""nodes":[{"mesh":0}]"#);
    let posed = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.5, 2.0, 0.0], [5.0, 2.0, 0.0]];
    assert!(same(&square(corners, skinned, nodes), &plain(posed)));
    assert!(!same(&square(corners, skinned, nodes), &plain(corners)));
    // A mesh without joints does not move, nor does one whose skin cannot be read.
    assert!(same(&square(corners, "", nodes), &plain(corners)));
    let broken = square(corners, skinned, &nodes.replace("[1,2]", "[1,9]"));
    assert!(same(&broken, &plain(corners)));
    let notes = TexturedModel::new(&broken).unwrap().notes().to_vec();
    assert!(notes[0].starts_with("drawn without a skin: skins[0].joints[1]: found 9"), "{notes:?}");
    // The target is the mesh itself, applied before the skin.
    let morphed = square(corners, "", r#""nodes":[{"mesh":0,"weights":[0.5]}]"#);
    assert!(same(&morphed, &plain(corners.map(|corner| corner.map(|x| 1.5 * x)))));
    let both = square(corners, skinned, &nodes.replace(r#""skin":0"#, r#""skin":0,"weights":[1]"#));
    let doubled = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.5, 4.0, 0.0], [7.0, 4.0, 0.0]];
    assert!(same(&both, &plain(doubled)));
}

fn scene() -> Model {
    read(&eggs(), Format::Glb).unwrap()
}

fn differences(before: &Model, after: &Model) -> [Differences; 4] {
    let (before, after) = (TexturedModel::new(before).unwrap(), TexturedModel::new(after).unwrap());
    Mode::ALL.map(|mode| compare(&before, &after, mode).unwrap())
}

#[test]
fn strips_change_no_pixel() {
    let model = scene();
    let stripped = strip::run(&model, &strip::Options::default(), &()).unwrap();
    let encoded = stripped.encode(&model, &encode::Options::new(Format::Glb), &()).unwrap().encoded;
    let after = read(&encoded.bytes, Format::Glb).unwrap();
    assert!(after.parts[0].stripped && after.parts[0].mesh.faces() != model.parts[0].mesh.faces());
    for found in differences(&model, &after) {
        assert!(found.shown > 50_000, "{found:?}");
        assert_eq!((found.different, found.holes, found.grown), (0, 0, 0), "{found:?}");
    }
}

#[test]
fn half_of_the_triangles_open_no_hole() {
    let model = scene();
    let goal = Goal { amount: Ratio::new(0.5).map(Amount::Ratio), ..Goal::default() };
    let simplified =
        simplify::run(&model, &simplify::Options::default().with_goal(goal).with_format(Format::Glb), &())
            .unwrap();
    let found = differences(&model, &simplified.redrawn.model);
    let bounds = Mode::ALL.map(|mode| match mode {
        Mode::Textured | Mode::Shaded => 0.25,
        Mode::Normals => 0.7,
        Mode::Uv => 0.1,
    });
    for ((found, bound), mode) in found.iter().zip(bounds).zip(Mode::ALL) {
        assert_eq!(found.holes, 0, "{}: {found:?}", mode.name());
        assert!(found.different > 0 && found.share() < bound, "{}: {found:?}", mode.name());
    }
}

#[test]
fn a_missing_triangle_is_a_hole_and_an_additional_one_is_grown() {
    // Holes do not depend on the mode.
    let normals = |before: &Model, after: &Model| {
        let models = [before, after].map(|model| TexturedModel::new(model).unwrap());
        compare(&models[0], &models[1], Mode::Normals).unwrap()
    };
    let model = scene();
    let all = model.parts[0].mesh.faces().corners();
    let with = |kept: &[u32]| with_triangles(&model, vec![kept.to_vec()], Format::Glb).unwrap().model;
    // Behind a triangle of a closed surface is its back side: another colour, but no hole.
    let middle = all.len() / 6 * 3;
    let found = normals(&model, &with(&[&all[..middle], &all[middle + 3..]].concat()));
    assert!(found.different > 0 && found.holes < found.different && found.grown == 0, "{found:?}");
    // The upper half is missing, so the background is visible there.
    let open = with(&all[middle..]);
    // Behind a triangle of a plane is the background.
    let plane = |faces: &str| {
        let corners = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 0 2 0\nv 1 2 0\nv 2 2 0\n";
        read([corners, faces].concat().as_bytes(), Format::Obj).unwrap()
    };
    let faces = "f 1 2 4\nf 2 5 4\nf 2 3 5\nf 3 6 5\nf 4 5 7\nf 5 8 7\nf 5 6 8\nf 6 9 8\n";
    let (full, without_one) = (plane(faces), plane(&faces.replacen("f 3 6 5\n", "", 1)));
    for [before, after] in [[&full, &without_one], [&model, &open]] {
        let (torn, mended) = (normals(before, after), normals(after, before));
        assert!(torn.holes > 100 && torn.grown == 0, "{torn:?}");
        assert!(mended.grown > 100 && mended.holes == 0, "{mended:?}");
    }
}

#[test]
fn a_sheet_has_a_row_per_model_and_is_the_same_with_any_number_of_threads() {
    let model = TexturedModel::new(&scene()).unwrap();
    let sheet = || rows_of_sides(&[&model, &model], Mode::Textured, 40).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let sheets = [pool.install(sheet), one.install(sheet)];
    assert!(sheets[0] == sheets[1]);
    let mut reader = png::Decoder::new(std::io::Cursor::new(&sheets[0])).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (320, 80));
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let (upper, lower) = pixels.split_at(pixels.len() / 2);
    assert!(upper == lower && upper.iter().any(|&value| value < 200));
    assert!(rows_of_sides(&[&model], Mode::Textured, 0).is_err());
    assert!(rows_of_sides(&[&model], Mode::Textured, 5000).is_err());
}

#[test]
fn wrong_images_and_a_model_behind_the_eye_are_refused() {
    let glb = eggs();
    let at = glb.windows(8).position(|bytes| bytes == b"\x89PNG\r\n\x1a\n").unwrap();
    for (offset, byte, message) in [(0, 0, "expected PNG or JPEG"), (16, 0x7f, ""), (60, 0xff, "")] {
        let mut bad = glb.clone();
        bad[at + offset] = byte;
        let error = TexturedModel::new(&read(&bad, Format::Glb).unwrap()).unwrap_err().to_string();
        assert!(error.contains(message) && error.starts_with("image: images[0]: "), "{error}");
    }
    let triangle = |scale: &str| {
        let text = format!("v 0 0 0\nv {scale} 0 0\nv 0 {scale} {scale}\nf 1 2 3\n");
        TexturedModel::new(&read(text.as_bytes(), Format::Obj).unwrap()).unwrap()
    };
    let error = compare(&triangle("1"), &triangle("100"), Mode::Shaded).unwrap_err().to_string();
    assert!(error.contains("behind the eye"), "{error}");
}

/// Returns a GLB in which the nodes of a level replace those of the finest level.
fn with_level(glb: &[u8], level: usize) -> Vec<u8> {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut json: Value = serde_json::from_slice(&glb[20..20 + length]).unwrap();
    let nodes = json["nodes"].clone();
    let replace = |list: &mut Value| {
        for node in list.as_array_mut().into_iter().flatten() {
            let lower = &nodes[node.as_u64().unwrap() as usize]["extensions"]["MSFT_lod"]["ids"];
            if level > 0 && lower.is_array() {
                *node = lower[level - 1].clone();
            }
        }
    };
    json["scenes"].as_array_mut().unwrap().iter_mut().for_each(|scene| replace(&mut scene["nodes"]));
    let with_children = json["nodes"].as_array_mut().unwrap().iter_mut();
    with_children
        .filter(|node| node.get("children").is_some())
        .for_each(|node| replace(&mut node["children"]));
    let mut text = serde_json::to_vec(&json).unwrap();
    text.resize(text.len().next_multiple_of(4), b' ');
    let head = [12 + 8 + text.len() + glb.len() - 20 - length, text.len()].map(|n| (n as u32).to_le_bytes());
    [&glb[..8], &head[0], &head[1], &glb[16..20], &text, &glb[20 + length..]].concat()
}

/// One egg has a child, so its mesh moves to another child; the other node only places its mesh.
#[test]
fn every_level_of_a_scene_looks_like_its_own_file() {
    let model = scene();
    let options = chain::Options::new("100%,50%,20%".parse().unwrap(), Format::Glb);
    let chain = chain::run(&model, &options.with_deviation(Deviation::Percent(100.0)), &()).unwrap().chain;
    let encode = encode::Options::new(Format::Glb);
    let all = chain.encode(&model, &encode, &()).unwrap().encoded.bytes;
    let text = String::from_utf8_lossy(&all).into_owned();
    assert_eq!(text.matches("MSFT_lod\":").count(), 2);
    let mut shown = Vec::new();
    for level in 0..3 {
        let own = chain.encode_level(&model, level, &encode, &()).unwrap().bytes;
        let own = read(&own, Format::Glb).unwrap();
        let in_scene = read(&with_level(&all, level), Format::Glb).unwrap();
        let [own, in_scene] = [own, in_scene].map(|model| TexturedModel::new(&model).unwrap());
        let found = compare(&own, &in_scene, Mode::Textured).unwrap();
        assert!(found.shown > 50_000, "{found:?}");
        assert_eq!((found.different, found.holes, found.grown), (0, 0, 0), "level {level}: {found:?}");
        shown.push(own);
    }
    // The comparison detects a wrong level.
    assert!(compare(&shown[0], &shown[2], Mode::Textured).unwrap().different > 1000);
}
