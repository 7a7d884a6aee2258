//! Writing GLB: the scene is kept, every layout draws the same triangles, and the Khronos validator
//! accepts the files.

use proptest::prelude::*;
use serde_json::{Value, json};
use tristrip::{Attribute, AttributeData, Faces, Layout, Mesh, Strips};
use tristrip_io::{Drawing, Error, Format, Model, Part, gltf, losses};

use crate::gltf_documents::*;
use crate::kept_scenes::{LAYOUTS, check_scene, rich, strips_of, write};

fn model_of(meshes: impl IntoIterator<Item = Mesh>) -> Model {
    let parts = meshes.into_iter().map(|mesh| Part { mesh, ..Part::default() }).collect();
    Model { parts, ..Model::default() }
}

fn mesh_of(vertex_count: usize, triangles: &[[u32; 3]]) -> Mesh {
    Mesh::new(bent(vertex_count), Faces::from_triangles(triangles.as_flattened().to_vec()).unwrap()).unwrap()
}

#[test]
fn keeps_a_rich_scene() {
    let draft = rich();
    let mut files = check_scene("rich", &draft.glb());
    files.push(("source.glb".into(), draft.glb()));
    files.extend(check_scene("again", &files[0].1.clone()));
    validate("keeps_a_rich_scene", &files);
}

#[test]
fn faces_of_a_triangle_list_stay_unchanged() {
    let glb = rich().glb();
    let model = gltf::read(glb.clone(), None).unwrap();
    let after = tristrip_io::write(&model, &[Drawing::Faces; 3], Format::Glb, Layout::Degenerate).unwrap();
    assert_eq!(json_of(&after), json_of(&glb));
    assert_eq!(bin_of(&after), bin_of(&glb));
}

#[test]
fn unused_old_indices_are_replaced() {
    let glb = rich().glb();
    let model = gltf::read(glb.clone(), None).unwrap();
    let list: Vec<_> = strips_of(&model);
    let after = write(&model, &list, Layout::Degenerate);
    let (old, new) = (json_of(&glb), json_of(&after));
    // Two new index accessors replaced the two old ones; the shared one is still shared.
    for list in ["accessors", "bufferViews"] {
        assert_eq!(old[list].as_array().unwrap().len(), new[list].as_array().unwrap().len());
    }
    assert_eq!(new["meshes"][0]["primitives"][1]["indices"], new["meshes"][0]["primitives"][2]["indices"]);
    // A number in extras that may refer to the accessor keeps it.
    let mut draft = rich();
    draft.json["extras"] = json!({ "indices of the first primitive": 2 });
    let after = write(&model_with(&draft), &list, Layout::Degenerate);
    assert_eq!(json_of(&after)["accessors"][2], old["accessors"][2]);
    // A line list also keeps it.
    let mut draft = rich();
    push(
        &mut draft.json["meshes"][0]["primitives"],
        json!({ "attributes": { "POSITION": 0 }, "indices": 2, "mode": 1 }),
    );
    let after = write(&model_with(&draft), &list, Layout::Degenerate);
    assert_eq!(json_of(&after)["accessors"][2], old["accessors"][2]);
    // An extension that refers to bytes keeps all bytes.
    let mut draft = rich();
    draft.json["extensions"] = json!({ "EXT_unknown_thing": { "buffer": 0, "byteOffset": 144 } });
    let after = write(&model_with(&draft), &list, Layout::Degenerate);
    assert!(bin_of(&after).starts_with(&draft.bin));
}

#[test]
fn unused_bytes_are_removed_from_the_buffer() {
    // 1200 bytes of indices between the vertices of two primitives, and 4 bytes outside all views.
    let mut draft = Draft::new();
    let first = draft.positions(&bent(5));
    let indices = draft.indices(U32, &[0, 1, 2].repeat(100));
    draft.bin.extend_from_slice(&[0xAA; 4]);
    let second = draft.positions(&bent(7));
    draft.primitive(first, Some(indices), 4);
    draft.primitive(second, None, 5);
    let glb = draft.glb();
    let files = check_scene("leave", &glb);
    let after = &files[1].1;
    // Removed: from the first multiple of 8 after 5 × 12 + 4 bytes to the last within the 1200
    // bytes, 1192 bytes. Added: 300 bytes for 100 joined strips of 3, padded to a multiple of 8,
    // and 7 bytes for the other primitive.
    assert_eq!(bin_of(&glb).len(), 60 + 1200 + 4 + 84);
    assert_eq!(json_of(after)["buffers"][0]["byteLength"], 60 + 8 + 4 + 84 + 4 + 300 + 4 + 7);
    assert_eq!(bin_of(after)[68..72], [0xAA; 4]);
    validate("unused_bytes_are_removed", &files);
}

#[test]
fn index_accessors_of_one_view_get_separate_views() {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(9));
    let all = draft.indices(U16, &[0, 1, 2, 2, 1, 3, 4, 5, 6, 6, 5, 7]);
    let view = draft.json["accessors"][all]["bufferView"].clone();
    draft.json["accessors"][all]["count"] = 6.into();
    let rest = push(
        &mut draft.json["accessors"],
        json!({ "bufferView": view, "byteOffset": 12, "componentType": U16, "count": 6, "type": "SCALAR" }),
    );
    draft.primitive(positions, Some(all), 4);
    draft.primitive(positions, Some(rest), 4);
    let files = check_scene("view", &draft.glb());
    let after = json_of(&files[1].1);
    assert_eq!(after["accessors"].as_array().unwrap().len(), 3);
    assert_eq!(after["bufferViews"].as_array().unwrap().len(), 3);
    validate("index_accessors_of_one_view", &files);
    // A line list that uses one of the two keeps the view and its accessor.
    push(
        &mut draft.json["meshes"][0]["primitives"],
        json!({ "attributes": { "POSITION": 0 }, "indices": rest, "mode": 1 }),
    );
    let files = check_scene("kept", &draft.glb());
    let after = json_of(&files[1].1);
    assert_eq!(after["meshes"][0]["primitives"][2]["indices"], rest);
    assert_eq!(after["bufferViews"][1], draft.json["bufferViews"][1]);
    validate("index_accessors_of_one_view", &files);
}

fn model_with(draft: &Draft) -> Model {
    gltf::read(draft.glb(), None).unwrap()
}

#[test]
fn joins_buffers_into_one() {
    use base64::Engine;
    let mut draft = rich();
    let extra = floats(bent(3).as_flattened());
    let text = base64::engine::general_purpose::STANDARD.encode([&[7; 5][..], &extra].concat());
    draft.json["buffers"] = json!([
        { "byteLength": draft.bin.len() },
        { "byteLength": 41, "uri": format!("data:application/octet-stream;base64,{text}") },
    ]);
    let view =
        push(&mut draft.json["bufferViews"], json!({ "buffer": 1, "byteOffset": 5, "byteLength": 36 }));
    let positions = draft.accessor(view, F32, 3, "VEC3");
    draft.json["accessors"][positions]["min"] = json!([0, 0, 0]);
    draft.json["accessors"][positions]["max"] = json!([2, 4, 2]);
    let mesh = json!({ "primitives": [{ "attributes": { "POSITION": positions } }] });
    push(&mut draft.json["meshes"], mesh);
    let model = model_with(&draft);
    let after = write(&model, &strips_of(&model), Layout::Restart);
    let back = gltf::read(after.clone(), None).unwrap();
    assert_eq!(json_of(&after)["buffers"].as_array().unwrap().len(), 1);
    assert_eq!(back.parts[3].mesh.positions(), bent(3));
    assert_eq!(triangles(&back, 0), triangles(&model, 0));
    // A `.gltf` with its bytes in the JSON also becomes a GLB.
    let model = gltf::read(rich().gltf(), None).unwrap();
    let after = write(&model, &strips_of(&model), Layout::Degenerate);
    validate("joins_buffers_into_one", &[("data.glb".into(), after)]);
}

#[test]
fn declares_restarts_only_where_there_are_any() {
    let names =
        |glb: &[u8]| (json_of(glb)["extensionsUsed"].clone(), json_of(glb)["extensionsRequired"].clone());
    let both = |list: Value| (list.clone(), list);
    let none = both(Value::Null);
    let two = model_of([mesh_of(6, &[[0, 1, 2], [3, 4, 5]])]);
    let restart = write(&two, &strips_of(&two), Layout::Restart);
    assert_eq!(names(&restart), both(json!(["KHR_mesh_primitive_restart"])));
    let one = model_of([mesh_of(6, &[[0, 1, 2]])]);
    assert_eq!(names(&write(&one, &strips_of(&one), Layout::Restart)), none);
    // After reading and writing without restarts, the name is removed; with line strips in the
    // scene, it remains.
    let model = gltf::read(restart.clone(), None).unwrap();
    assert_eq!(names(&write(&model, &strips_of(&model), Layout::Degenerate)), none);
    let mut json = json_of(&restart);
    push(&mut json["meshes"][0]["primitives"], json!({ "attributes": { "POSITION": 0 }, "mode": 3 }));
    let lines = glb_of(json.to_string().as_bytes(), Some(bin_of(&restart)));
    let model = gltf::read(lines, None).unwrap();
    let after = write(&model, &strips_of(&model), Layout::Degenerate);
    assert_eq!(names(&after), both(json!(["KHR_mesh_primitive_restart"])));
    // Faces of a strip primitive become a list.
    let after = tristrip_io::write(&model, &[Drawing::Faces], Format::Glb, Layout::Restart).unwrap();
    assert_eq!(json_of(&after)["meshes"][0]["primitives"][0]["mode"], 4);
    assert_eq!(triangles(&gltf::read(after, None).unwrap(), 0), [[0, 1, 2], [3, 4, 5]]);
}

#[test]
fn extensions_about_the_index_order_are_dropped() {
    let mut draft = rich();
    draft.json["extensionsUsed"] = json!(["EXT_unknown_thing", "EXT_mesh_manifold"]);
    draft.json["meshes"][0]["extensions"] =
        json!({ "EXT_mesh_manifold": { "mergeIndices": 2 }, "EXT_unknown_thing": {} });
    let model = model_with(&draft);
    assert!(model.notes[0].starts_with("EXT_mesh_manifold describes the order"), "{:?}", model.notes);
    let after = json_of(&write(&model, &strips_of(&model), Layout::List));
    assert_eq!(after["extensionsUsed"], json!(["EXT_unknown_thing"]));
    assert_eq!(after["meshes"][0]["extensions"], json!({ "EXT_unknown_thing": {} }));
    let after =
        json_of(&tristrip_io::write(&model, &[Drawing::Faces; 3], Format::Glb, Layout::List).unwrap());
    assert_eq!(after["meshes"][0]["extensions"], draft.json["meshes"][0]["extensions"]);
}

#[test]
fn writes_models_without_triangles() {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(4));
    let indices = draft.indices(U8, &[0, 0, 1]);
    draft.primitive(positions, Some(indices), 5);
    let kept = model_with(&draft);
    let empty = model_of([mesh_of(4, &[]), Mesh::default()]);
    let mut files = Vec::new();
    for layout in LAYOUTS {
        files.push((format!("kept_{layout:?}.glb"), write(&kept, &[Strips::default()], layout)));
        files.push((
            format!("empty_{layout:?}.glb"),
            write(&empty, &[Strips::default(), Strips::default()], layout),
        ));
        files.push((format!("none_{layout:?}.glb"), write(&Model::default(), &[], layout)));
        let mut short = Strips::default();
        for strip in [&[][..], &[0], &[0, 1], &[0, 1, 1]] {
            short.push(strip);
        }
        files.push((format!("short_{layout:?}.glb"), write(&empty, &[short, Strips::default()], layout)));
    }
    for (name, glb) in &files {
        let back = gltf::read(glb.clone(), None).unwrap();
        assert!(back.parts.iter().all(|p| real_triangle_count(&p.mesh) == 0), "{name}");
    }
    validate("writes_models_without_triangles", &files);
}

fn real_triangle_count(mesh: &Mesh) -> usize {
    mesh.faces().iter().filter(|f| f[0] != f[1] && f[1] != f[2] && f[0] != f[2]).count()
}

#[test]
fn chooses_the_width_that_keeps_the_highest_value_free() {
    let mut files = Vec::new();
    for (highest, code, restart) in [
        (254, U8, 255),
        (255, U16, 65535),
        (65534, U16, 65535),
        (65535, U32, u32::MAX),
        (70000, U32, u32::MAX),
    ] {
        let model = model_of([mesh_of(highest as usize + 1, &[[0, 1, highest], [2, 3, 4]])]);
        let strips = strips_of(&model);
        for layout in LAYOUTS {
            let glb = write(&model, &strips, layout);
            let (json, bin) = (json_of(&glb), bin_of(&glb));
            let indices = json["meshes"][0]["primitives"][0]["indices"].as_u64().unwrap() as usize;
            let accessor = &json["accessors"][indices];
            assert_eq!(accessor["componentType"], code, "{highest} {layout:?}");
            if layout == Layout::Restart {
                let view = accessor["bufferView"].as_u64().unwrap() as usize;
                assert_eq!(view_bytes(&json, bin, view), packed(code, &[0, 1, highest, restart, 2, 3, 4]));
            }
            files.push((format!("{highest}_{layout:?}.glb"), glb));
        }
    }
    validate("chooses_the_width", &files);
}

fn attribute(name: &str, components: u8, normalized: bool, data: AttributeData) -> Attribute {
    Attribute { name: name.into(), components, normalized, data }
}

#[test]
fn writes_attributes_under_valid_names() {
    let up = [0.0, 0.0, 1.0].repeat(3);
    let mut bad_up = up.clone();
    bad_up[2] = 1.01;
    let floats = |n: usize| AttributeData::F32(vec![0.5; 3 * n]);
    let with = |list: Vec<Attribute>| {
        list.into_iter().fold(mesh_of(3, &[[0, 1, 2]]), |mesh, a| mesh.with_attribute(a).unwrap())
    };
    let good = with(vec![
        attribute("TEXCOORD_1", 2, true, AttributeData::U8(vec![7; 6])),
        attribute("NORMAL", 3, false, AttributeData::F32(up)),
        attribute("TANGENT", 4, false, AttributeData::F32([1.0, 0.0, 0.0, -1.0].repeat(3))),
        attribute("TEXCOORD_0", 2, false, floats(2)),
        attribute("COLOR_0", 3, true, AttributeData::U8(vec![200; 9])),
        attribute("COLOR_1", 4, true, AttributeData::U16(vec![200; 12])),
        attribute("COLOR_2", 4, false, floats(4)),
        attribute("_ID", 1, false, AttributeData::U16(vec![1, 2, 3])),
        attribute("quality", 1, false, floats(1)),
        attribute("flow", 3, true, AttributeData::I8(vec![-5; 9])),
    ]);
    let bad = with(vec![
        attribute("NORMAL", 3, false, AttributeData::F32(bad_up)),
        attribute("TANGENT", 4, false, AttributeData::F32([1.0, 0.0, 0.0, -1.0].repeat(3))),
        attribute("TEXCOORD_1", 2, false, floats(2)),
        attribute("COLOR_0", 3, false, AttributeData::F32(vec![1.5; 9])),
        attribute("COLOR_01", 3, false, floats(3)),
        attribute("JOINTS_0", 4, false, AttributeData::U8(vec![0; 12])),
        attribute("id", 1, false, AttributeData::U32(vec![0; 3])),
        attribute("five", 5, false, floats(5)),
        attribute("nan", 1, false, AttributeData::F32(vec![f32::NAN; 3])),
        attribute("_COLOR_0", 1, false, floats(1)),
    ]);
    let model = model_of([good, bad]);
    assert_eq!(
        losses(&model, &[Drawing::Faces; 2], Format::Glb),
        [
            "attribute `COLOR_01` written as `_COLOR_01`: 1",
            "attribute `COLOR_0` written as `_COLOR_0`: 1",
            "attribute `JOINTS_0` written as `_JOINTS_0`: 1",
            "attribute `NORMAL` written as `_NORMAL`: 1",
            "attribute `TANGENT` written as `_TANGENT`: 1",
            "attribute `TEXCOORD_1` written as `_TEXCOORD_1`: 1",
            "attribute `_COLOR_0` not written: another attribute is written as `_COLOR_0`: 1",
            "attribute `five` not written: it has 5 components; glTF allows 1 to 4: 1",
            "attribute `flow` written as `_flow`: 1",
            "attribute `id` not written: glTF has no 64-bit floats or 32-bit integers for vertices: 1",
            "attribute `nan` not written: it has values that are not finite: 1",
            "attribute `quality` written as `_quality`: 1",
        ]
    );
    let glb = tristrip_io::write(&model, &[Drawing::Faces; 2], Format::Glb, Layout::Degenerate).unwrap();
    let back = gltf::read(glb.clone(), None).unwrap();
    for (old, new) in model.parts[0].mesh.attributes().iter().zip(back.parts[0].mesh.attributes()) {
        assert_eq!((old.components, &old.data, old.normalized), (new.components, &new.data, new.normalized));
    }
    assert_eq!(back.parts[1].mesh.attributes().len(), 6);
    validate("writes_attributes", &[("attributes.glb".into(), glb)]);
}

#[test]
fn parts_that_share_positions_share_them_in_the_file() {
    let first = mesh_of(300, &[[0, 1, 2]]);
    let shared = first.shared_positions();
    let second = Mesh::new(shared, Faces::from_polygons([[9, 8, 7, 6]]).unwrap()).unwrap();
    let color = || attribute("COLOR_0", 3, true, AttributeData::U8(vec![9; 900]));
    let mut model = model_of([
        first.with_attribute(color()).unwrap(),
        second.with_attribute(color()).unwrap(),
        mesh_of(3, &[]),
    ]);
    for (part, (name, material)) in model.parts.iter_mut().zip([("a", "m"), ("a", "n"), ("b", "m")]) {
        (part.name, part.material) = (Some(name.into()), Some(material.into()));
    }
    let glb = tristrip_io::write(&model, &[Drawing::Faces; 3], Format::Glb, Layout::Degenerate).unwrap();
    let json = json_of(&glb);
    let primitives = &json["meshes"][0]["primitives"];
    assert_eq!(primitives[0]["attributes"], primitives[1]["attributes"]);
    assert_eq!([&primitives[0]["material"], &primitives[1]["material"]], [0, 1]);
    assert_eq!(json["meshes"][1]["primitives"][0]["material"], 0);
    assert_eq!(json["nodes"], json!([{ "name": "a", "mesh": 0 }, { "name": "b", "mesh": 1 }]));
    assert_eq!(json["materials"], json!([{ "name": "m" }, { "name": "n" }]));
    assert_eq!(losses(&model, &[Drawing::Faces; 3], Format::Glb), ["polygons cut into fans: 1"]);
    let back = gltf::read(glb.clone(), None).unwrap();
    assert_eq!(triangles(&back, 1), [[7, 9, 8], [6, 9, 7]]);
    validate("parts_that_share", &[("shared.glb".into(), glb)]);
}

#[test]
fn refuses_invalid_drawings() {
    let model = model_of([mesh_of(3, &[[0, 1, 2]])]);
    let message = |drawings: &[Drawing<'_>]| {
        tristrip_io::write(&model, drawings, Format::Glb, Layout::Degenerate).unwrap_err().to_string()
    };
    assert_eq!(message(&[]), "drawings: found 0, expected 1 (one per part)");
    let mut strips = Strips::default();
    strips.push(&[0, 1, 3]);
    assert_eq!(
        message(&[Drawing::Strips(&strips)]),
        "strip 0, vertex 2: found vertex index 3, expected less than 3"
    );
    let mut model = model_with(&rich());
    model.parts.pop();
    let error = tristrip_io::write(&model, &[Drawing::Faces; 2], Format::Glb, Layout::List).unwrap_err();
    assert!(matches!(error, Error::Unsupported(_)), "{error}");
}

#[test]
fn keeps_real_scenes() {
    check_real_scenes("keeps_real_scenes", |name, glb| {
        // One primitive per strip is too slow for the validator in large scenes, because greedy
        // strips are short.
        let is_small = |file: &str| !file.ends_with("_Separate.glb") || name == "milktruck";
        check_scene(name, glb).into_iter().filter(|(file, _)| is_small(file)).collect()
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 4))]
    #[test]
    fn every_layout_draws_the_same_triangles(
        vertex_count in prop_oneof![3usize..12, 250usize..260, 65530usize..65540],
        seeds in prop::collection::vec(any::<[u32; 3]>(), 0..40),
        local in any::<bool>(),
    ) {
        let real: Vec<[u32; 3]> = seeds
            .iter()
            .enumerate()
            .map(|(i, seed)| {
                let n = vertex_count as u32;
                if local { [i as u32 % n, (i as u32 + 1) % n, (i as u32 + 2) % n] } else { seed.map(|s| s % n) }
            })
            .filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2])
            .collect();
        let model = model_of([mesh_of(vertex_count, &real)]);
        let strips = greedy(&real);
        prop_assert_eq!(rotated(strips.triangles()), rotated(real.iter().copied()));
        for layout in LAYOUTS {
            let drawing = [Drawing::Strips(&strips)];
            let first = tristrip_io::write(&model, &drawing, Format::Glb, layout).unwrap();
            let kept = gltf::read(first, None).unwrap();
            let drawn = |model: &Model| {
                let all: Vec<[u32; 3]> = (0..model.parts.len()).flat_map(|part| triangles(model, part)).collect();
                all.into_iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]).collect::<Vec<_>>()
            };
            // Joined strips are drawn in another order.
            let sorted = |triangles| {
                let mut all = rotated(triangles);
                all.sort_unstable();
                all
            };
            prop_assert_eq!(sorted(drawn(&kept)), sorted(real.clone()));
            // Written a second time, with the scene.
            let again = strips_of(&kept);
            let second = write(&kept, &again, Layout::Restart);
            prop_assert_eq!(sorted(drawn(&gltf::read(second, None).unwrap())), sorted(real.clone()));
        }
    }
}

#[test]
fn attributes_without_a_type_in_gltf_are_losses() {
    let data = AttributeData::F64(vec![1.0]);
    let quality = Attribute { name: "quality".into(), components: 1, normalized: false, data };
    let mesh = Mesh::new(vec![[0.0; 3]], Faces::default()).unwrap().with_attribute(quality).unwrap();
    let model = Model { parts: vec![Part { mesh, ..Part::default() }], ..Model::default() };
    assert_eq!(
        losses(&model, &[Drawing::Faces], Format::Glb),
        ["attribute `quality` not written: glTF has no 64-bit floats or 32-bit integers for vertices: 1"],
    );
}
