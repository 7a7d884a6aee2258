//! Scenes with levels of detail in one vertex array, checked by the written bytes. Every level
//! draws the values that the source has at the corners of its triangles, using the first vertices
//! of the finest level's accessors.

use std::collections::BTreeSet;

use crate::gltf_documents::scenes::{grid, raw, shared_scene};
use crate::gltf_documents::*;
use serde_json::{Value, json};
use tristrip::Layout;
use tristrip_io::{Drawing, Format, LeveledModel, Model, PartLevel, gltf, in_level_order, read, write};

const COVERAGE: [f64; 3] = [0.5, 0.125, 0.0];

/// Returns three levels of a model: all triangles, every third and every ninth, with added vertices
/// in descending order.
fn levels_of(model: &Model) -> Vec<Vec<PartLevel>> {
    let at = |step: usize, coarser: usize| {
        let parts = model.parts.iter().map(|part| {
            let corners = part.mesh.faces().as_triangles().unwrap();
            let drawn = |step: usize| {
                let triangles = corners.chunks(3).enumerate().filter(move |(t, _)| t.is_multiple_of(step));
                triangles.flat_map(|(_, t)| t.to_vec()).collect::<Vec<u32>>()
            };
            let old: BTreeSet<u32> =
                if coarser > 0 { drawn(coarser).into_iter().collect() } else { BTreeSet::new() };
            let new: BTreeSet<u32> = drawn(step).into_iter().filter(|v| !old.contains(v)).collect();
            let added = if coarser > 0 { new.into_iter().rev().collect() } else { Vec::new() };
            PartLevel { triangles: drawn(step), added }
        });
        parts.collect::<Vec<_>>()
    };
    vec![at(1, 3), at(3, 9), at(9, 0)]
}

fn with_levels(glb: &[u8]) -> (LeveledModel, Vec<Vec<PartLevel>>, Vec<u8>) {
    let model = gltf::read(glb, None).unwrap();
    let levels = levels_of(&model);
    let leveled = in_level_order(&model, &levels, Format::Glb).unwrap();
    let scene = leveled.scene(&|_| COVERAGE.to_vec()).unwrap();
    let drawings = vec![Drawing::Faces; scene.model.parts.len()];
    let out = write(&scene.model, &drawings, Format::Glb, Layout::List).unwrap();
    (leveled, levels, out)
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

/// Returns the node that draws the mesh of a node at a level.
fn node_at(json: &Value, node: usize, level: usize) -> usize {
    let has_levels = |&n: &usize| json["nodes"][n]["extensions"]["MSFT_lod"].is_object();
    let children = json["nodes"][node]["children"].as_array().into_iter().flatten().map(number);
    let Some(finest) = [node].into_iter().chain(children).find(has_levels) else { return node };
    let ids = &json["nodes"][finest]["extensions"]["MSFT_lod"]["ids"];
    if level == 0 { finest } else { number(&ids[level - 1]) }
}

fn vertex_accessors(primitive: &Value) -> Vec<(String, usize)> {
    let targets = primitive["targets"].as_array().cloned().unwrap_or_default();
    let objects = [&primitive["attributes"]].into_iter().chain(&targets).enumerate();
    let named = objects.flat_map(|(i, object)| {
        let members = object.as_object().unwrap().iter();
        members.map(move |(name, accessor)| (format!("{i} {name}"), number(accessor))).collect::<Vec<_>>()
    });
    named.collect()
}

/// Checks every level of the meshes of the first nodes. The meshes have one triangle primitive
/// each.
fn check(before: &[u8], after: &[u8], leveled: &LeveledModel, levels: &[Vec<PartLevel>]) {
    let (old, new) = (json_of(before), json_of(after));
    for (part, level) in
        (0..levels[0].len()).flat_map(|part| (0..levels.len()).map(move |level| (part, level)))
    {
        let primitive = |json: &Value, mesh: &Value| json["meshes"][number(mesh)]["primitives"][0].clone();
        let source = primitive(&old, &json!(part));
        let finest = primitive(&new, &json!(part));
        let node = old["nodes"].as_array().unwrap().iter().position(|node| node["mesh"] == part).unwrap();
        let drawn = primitive(&new, &new["nodes"][node_at(&new, node, level)]["mesh"]);
        let corners: Vec<usize> = raw(after, number(&drawn["indices"]))
            .iter()
            .map(|b| b.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b)))
            .collect();
        let expected = &levels[level][part].triangles;
        assert_eq!(corners.len(), expected.len());
        let count = leveled.vertex_counts[level][part];
        let names = |primitive: &Value| {
            vertex_accessors(primitive).into_iter().map(|(name, _)| name).collect::<Vec<_>>()
        };
        assert_eq!((names(&source), &source["material"]), (names(&drawn), &drawn["material"]));
        let accessors = [&source, &finest, &drawn].map(vertex_accessors);
        for ((before_, finest), drawn) in accessors[0].iter().zip(&accessors[1]).zip(&accessors[2]) {
            let values = [raw(before, before_.1), raw(after, drawn.1)];
            assert_eq!(values[1].len(), count, "part {part}, level {level}, {}", drawn.0);
            for (&from, &to) in expected.iter().zip(&corners) {
                assert_eq!(
                    values[0][from as usize], values[1][to],
                    "part {part}, level {level}, {}",
                    drawn.0
                );
            }
            let of = |accessor: usize, name: &str| new["accessors"][accessor][name].clone();
            for name in ["bufferView", "byteOffset", "componentType", "type", "normalized"] {
                assert_eq!(of(finest.1, name), of(drawn.1, name));
            }
            if drawn.0.ends_with("POSITION") {
                check_bounds(&new["accessors"][drawn.1], &values[1]);
            }
        }
    }
}

fn check_bounds(accessor: &Value, values: &[Vec<u8>]) {
    let component =
        |value: &[u8], axis: usize| f32::from_le_bytes(value[4 * axis..][..4].try_into().unwrap());
    for axis in 0..3 {
        let all = || values.iter().map(|value| component(value, axis));
        let found = ["min", "max"].map(|name| accessor[name][axis].as_f64().unwrap());
        let exact = [all().fold(f32::INFINITY, f32::min), all().fold(f32::NEG_INFINITY, f32::max)];
        assert_eq!(found.map(f64::to_bits), exact.map(|x| f64::from(x).to_bits()));
    }
}

#[test]
fn every_level_draws_the_values_of_the_source_from_the_first_vertices() {
    let before = shared_scene(6).glb();
    let (leveled, levels, after) = with_levels(&before);
    assert_eq!(
        leveled.groups.iter().map(|group| group.parts.clone()).collect::<Vec<_>>(),
        [vec![0, 1], vec![2]]
    );
    assert!(leveled.groups.iter().all(|group| group.kept.is_none()));
    let counts = |part: usize| leveled.vertex_counts.iter().map(|level| level[part]).collect::<Vec<_>>();
    assert!(counts(0).is_sorted_by(|a, b| a > b) && counts(0)[2] < counts(0)[0] / 2, "{:?}", counts(0));
    assert_eq!(counts(0), counts(1));
    check(&before, &after, &leveled, &levels);
    // The size of the finest level is the size of all vertex data in the file.
    let again = gltf::read(&after[..], None).unwrap().scene.unwrap();
    let meshes = |level: usize| {
        (0..3)
            .map(|n| {
                let json = json_of(&after);
                number(&json["nodes"][node_at(&json, n, level)]["mesh"])
            })
            .collect::<Vec<_>>()
    };
    let bytes = [0, 1, 2].map(|level| again.bytes_of_meshes(&meshes(level)).unwrap());
    assert!(bytes[0] > bytes[1] && bytes[1] > bytes[2], "{bytes:?}");
    validate("levels_of_detail", &[("shared.glb".to_owned(), after)]);
}

#[test]
fn strips_of_all_layouts_hold_all_levels() {
    let before = shared_scene(5).glb();
    let model = gltf::read(&before[..], None).unwrap();
    let levels = levels_of(&model);
    let leveled = in_level_order(&model, &levels, Format::Glb).unwrap();
    let scene = leveled.scene(&|_| COVERAGE.to_vec()).unwrap();
    let strips: Vec<_> =
        (0..scene.model.parts.len()).map(|part| greedy(&triangles(&scene.model, part))).collect();
    let drawings: Vec<Drawing<'_>> = strips.iter().map(Drawing::Strips).collect();
    let mut files = Vec::new();
    for layout in Layout::ALL {
        let glb = write(&scene.model, &drawings, Format::Glb, layout).unwrap();
        let again = gltf::read(&glb[..], None).unwrap();
        let mesh_of_parts = again.scene.as_ref().unwrap().mesh_of_parts();
        for (level, meshes) in scene.meshes.iter().enumerate() {
            let drawn = (0..again.parts.len()).filter(|&part| meshes.contains(&mesh_of_parts[part]));
            let mut found: Vec<_> = drawn.flat_map(|part| triangles(&again, part)).collect();
            let mut expected: Vec<_> = leveled.triangles[level]
                .iter()
                .flat_map(|t| rotated(t.as_chunks::<3>().0.iter().copied()))
                .collect();
            found.sort_unstable();
            expected.sort_unstable();
            assert_eq!(found, expected, "{layout:?}, level {level}");
        }
        files.push((format!("{layout:?}.glb"), glb));
    }
    validate("levels_of_detail_layouts", &files);
}

/// Returns a grid under one node, for tests to modify.
fn one_mesh() -> Draft {
    let mut draft = Draft::new();
    let (positions, corners) = grid(5);
    let position = draft.positions(&positions);
    let indices = draft.indices(U16, &corners);
    draft.primitive(position, Some(indices), 4);
    draft
}

#[test]
fn a_node_that_only_places_its_mesh_has_the_levels() {
    let mut draft = one_mesh();
    draft.json["nodes"][0] =
        json!({ "name": "wall", "mesh": 0, "translation": [1, 2, 3.5], "extras": { "kept": "yes" } });
    draft.json["meshes"][0]["name"] = "brick".into();
    let (_, _, after) = with_levels(&draft.glb());
    let json = json_of(&after);
    let names = |list: &str| {
        json[list]
            .as_array()
            .unwrap()
            .iter()
            .map(|one| one["name"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(names("nodes"), ["wall", "wall_lod1", "wall_lod2"]);
    assert_eq!(names("meshes"), ["brick", "brick_lod1", "brick_lod2"]);
    assert_eq!(json["nodes"][0]["extensions"], json!({ "MSFT_lod": { "ids": [1, 2] } }));
    assert_eq!(
        json["nodes"][0]["extras"],
        json!({ "kept": "yes", "MSFT_screencoverage": [0.5, 0.125, 0.0] })
    );
    for (level, node) in [1, 2].into_iter().zip(&json["nodes"].as_array().unwrap()[1..]) {
        assert_eq!((&node["mesh"], &node["translation"]), (&level.into(), &json!([1, 2, 3.5])));
        assert!(node.get("extensions").is_none() && node.get("extras").is_none());
    }
    assert_eq!(
        (&json["scenes"], &json["extensionsUsed"]),
        (&json!([{ "nodes": [0] }]), &json!(["MSFT_lod"]))
    );
    assert!(json.get("extensionsRequired").is_none());
    validate("levels_of_detail_place", &[("place.glb".to_owned(), after)]);
}

#[test]
fn a_node_that_does_more_keeps_its_transform_and_its_children() {
    let mut draft = one_mesh();
    draft.json["nodes"] = json!([
        { "name": "wheel", "mesh": 0, "rotation": [0, 0, 0, 1], "weights": [0.5], "children": [1] },
        { "name": "cap", "mesh": 0 },
    ]);
    let dense = draft.positions(&grid(5).0);
    draft.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": dense }]);
    let times = draft.view(&floats(&[0.0, 1.0]));
    let times = draft.accessor(times, F32, 2, "SCALAR");
    (draft.json["accessors"][times]["min"], draft.json["accessors"][times]["max"]) = (json!([0]), json!([1]));
    let turns = draft.view(&floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]));
    let turns = draft.accessor(turns, F32, 2, "VEC4");
    let weights = draft.accessor(
        draft.json["accessors"][times]["bufferView"].as_u64().unwrap() as usize,
        F32,
        2,
        "SCALAR",
    );
    let sampler = |output: usize| json!({ "input": times, "output": output });
    let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    draft.json["animations"] = json!([{
        "samplers": [sampler(turns), sampler(weights)],
        "channels": [channel(0, 0, "rotation"), channel(1, 0, "weights"), channel(1, 1, "weights")],
    }]);
    let before = draft.glb();
    let (leveled, levels, after) = with_levels(&before);
    check(&before, &after, &leveled, &levels);
    let json = json_of(&after);
    let nodes = json["nodes"].as_array().unwrap();
    assert_eq!(nodes[0], json!({ "name": "wheel", "rotation": [0, 0, 0, 1], "children": [1, 2] }));
    assert_eq!(
        (&nodes[2]["name"], &nodes[2]["mesh"], &nodes[2]["weights"]),
        (&"wheel_lod0".into(), &0.into(), &json!([0.5]))
    );
    assert_eq!(nodes[2]["extensions"]["MSFT_lod"]["ids"], json!([3, 4]));
    assert_eq!(nodes[3], json!({ "name": "wheel_lod1", "mesh": 1, "weights": [0.5] }));
    // The node of the cap only places its mesh, so its levels are its siblings.
    assert_eq!(nodes[1]["extensions"]["MSFT_lod"]["ids"], json!([5, 6]));
    let channels = json["animations"][0]["channels"].as_array().unwrap();
    let targets: Vec<_> = channels
        .iter()
        .map(|c| (c["target"]["path"].as_str().unwrap(), number(&c["target"]["node"])))
        .collect();
    let weights = [2, 3, 4, 1, 5, 6].map(|node| ("weights", node));
    assert_eq!(targets, [&[("rotation", 0)][..], &weights].concat());
    validate("levels_of_detail_wheel", &[("wheel.glb".to_owned(), after)]);
}

#[test]
fn instances_and_skins_belong_to_the_mesh_and_lights_to_the_node() {
    let mut draft = one_mesh();
    let offsets = draft.view(&floats(&[0.0, 0.0, 0.0, 9.0, 0.0, 0.0]));
    let offsets = draft.accessor(offsets, F32, 2, "VEC3");
    let instances = json!({ "attributes": { "TRANSLATION": offsets } });
    draft.json["nodes"][0] = json!({
        "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": instances, "KHR_lights_punctual": { "light": 0 } },
    });
    draft.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_lights_punctual"]);
    draft.json["extensions"] = json!({ "KHR_lights_punctual": { "lights": [{ "type": "point" }] } });
    let json = json_of(&with_levels(&draft.glb()).2);
    let nodes = json["nodes"].as_array().unwrap();
    assert_eq!(nodes[0], json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } }, "children": [1] }));
    let instances =
        |node: &Value| node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"].clone();
    assert!(nodes[1..].iter().all(|node| instances(node).is_u64() && node["mesh"].is_u64()), "{nodes:?}");
    assert_eq!(json["extensionsUsed"].as_array().unwrap().len(), 3);
}

#[test]
fn a_view_gets_a_stride_unless_it_holds_other_data() {
    // Positions and indices in one view: a stride would change the meaning of the indices.
    let (positions, corners) = grid(5);
    let mut draft = Draft::new();
    let position = draft.positions(&positions);
    let view = draft.view(&[floats(positions.as_flattened()), packed(U32, &corners)].concat());
    draft.json["accessors"][position]["bufferView"] = view.into();
    let indices = draft.accessor(view, U32, corners.len(), "SCALAR");
    draft.json["accessors"][indices]["byteOffset"] = (12 * positions.len()).into();
    draft.primitive(position, Some(indices), 4);
    let model = gltf::read(draft.glb(), None).unwrap();
    let shared = with_levels(&draft.glb());
    assert!(shared.0.groups[0].kept.is_none());
    let json = json_of(&shared.2);
    let primitive = |level: usize| &json["meshes"][level]["primitives"][0];
    assert!(json["bufferViews"].as_array().unwrap().iter().all(|view| view.get("byteStride").is_none()));
    assert_eq!(primitive(2)["attributes"], primitive(0)["attributes"]);
    assert_eq!(gltf::read(&shared.2[..], None).unwrap().parts.len(), 3 * model.parts.len());
    // Positions in a separate view.
    let own = json_of(&with_levels(&one_mesh().glb()).2);
    let accessor = |level: usize| number(&own["meshes"][level]["primitives"][0]["attributes"]["POSITION"]);
    let view = own["accessors"][accessor(2)]["bufferView"].clone();
    assert_ne!(accessor(2), accessor(0));
    assert_eq!(own["bufferViews"][number(&view)]["byteStride"], 12);
}

#[test]
fn points_over_the_vertices_keep_their_order() {
    let mut draft = one_mesh();
    draft.primitive(0, None, 0);
    let (leveled, levels, after) = with_levels(&draft.glb());
    assert_eq!(leveled.groups[0].kept.as_deref(), Some("points or lines use the same vertices"));
    let all = leveled.model.parts[0].mesh.vertex_count();
    assert_eq!(leveled.vertex_counts, [[all], [all], [all]]);
    check(&draft.glb(), &after, &leveled, &levels);
    // Every level draws the points.
    let json = json_of(&after);
    assert!(json["meshes"].as_array().unwrap().iter().all(|mesh| mesh["primitives"][1]["mode"] == 0));
    validate("levels_of_detail_points", &[("points.glb".to_owned(), after)]);
}

#[test]
fn a_mesh_that_does_not_change_is_not_copied() {
    let draft = one_mesh();
    let model = gltf::read(draft.glb(), None).unwrap();
    let whole = levels_of(&model).remove(0);
    let leveled = in_level_order(&model, &[whole.clone(), whole.clone(), whole], Format::Glb).unwrap();
    let scene = leveled.scene(&|_| COVERAGE.to_vec()).unwrap();
    assert_eq!((scene.parts, scene.meshes), (vec![vec![0]; 3], vec![vec![0]; 3]));
    let glb = write(&scene.model, &[Drawing::Faces], Format::Glb, Layout::List).unwrap();
    assert!(json_of(&glb).get("extensionsUsed").is_none());
}

#[test]
fn scenes_that_cannot_get_levels_are_left_alone() {
    let mut draft = one_mesh();
    draft.json["extensionsUsed"] = json!(["MSFT_lod"]);
    let model = gltf::read(draft.glb(), None).unwrap();
    let leveled = in_level_order(&model, &levels_of(&model), Format::Glb).unwrap();
    let refused = leveled.scene(&|_| COVERAGE.to_vec()).unwrap_err().to_string();
    assert!(refused.contains("already has levels of detail") && refused.contains("directory"), "{refused}");

    let mut draft = one_mesh();
    draft.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let target = json!({ "path": "pointer", "extensions": { "KHR_animation_pointer": { "pointer": "/nodes/0/weights" } } });
    draft.json["animations"] = json!([{ "samplers": [], "channels": [{ "sampler": 0, "target": target }] }]);
    let model = gltf::read(draft.glb(), None).unwrap();
    let leveled = in_level_order(&model, &levels_of(&model), Format::Glb).unwrap();
    assert_eq!(leveled.scene(&|_| COVERAGE.to_vec()).unwrap().nodes_without, 1);
}

#[test]
fn models_without_a_scene_get_one() {
    let (positions, corners) = grid(4);
    let lines: Vec<String> = positions.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces: Vec<String> =
        corners.chunks(3).map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1)).collect();
    let model = read([lines.concat(), faces.concat()].concat().as_bytes(), Format::Obj).unwrap();
    let levels = levels_of(&model);
    let leveled = in_level_order(&model, &levels, Format::Glb).unwrap();
    assert_eq!(
        leveled.model.parts[0].mesh.vertex_count(),
        positions.len() - 3,
        "unused vertices are dropped"
    );
    let scene = leveled.scene(&|_| COVERAGE.to_vec()).unwrap();
    let drawings = vec![Drawing::Faces; 3];
    let glb = write(&scene.model, &drawings, Format::Glb, Layout::List).unwrap();
    let again = gltf::read(&glb[..], None).unwrap();
    for (level, part) in again.parts.iter().enumerate() {
        let found =
            part.mesh.faces().corners().iter().map(|&v| part.mesh.positions()[v as usize].map(f32::to_bits));
        let expected = levels[level][0].triangles.iter().map(|&v| positions[v as usize].map(f32::to_bits));
        assert!(found.eq(expected), "level {level}");
        assert_eq!(part.mesh.vertex_count(), leveled.vertex_counts[level][0]);
    }
    validate("levels_of_detail_obj", &[("grid.glb".to_owned(), glb)]);
}

#[test]
fn levels_that_do_not_fit_the_model_are_refused() {
    let model = gltf::read(one_mesh().glb(), None).unwrap();
    let level = |triangles: &[u32]| vec![PartLevel { triangles: triangles.to_vec(), added: Vec::new() }];
    assert!(in_level_order(&model, &[], Format::Glb).is_err());
    assert!(in_level_order(&model, &[Vec::new()], Format::Glb).is_err());
    assert!(in_level_order(&model, &[level(&[0, 1])], Format::Glb).is_err());
    assert!(in_level_order(&model, &[level(&[0, 1, 2]), level(&[0, 1, 9999])], Format::Glb).is_err());
    let missing = vec![PartLevel { triangles: vec![0, 1, 2], added: vec![9999] }];
    assert!(in_level_order(&model, &[missing], Format::Glb).is_err());
}
