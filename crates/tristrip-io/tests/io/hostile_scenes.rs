//! Malformed nodes, levels of detail and placements: each gives a result or an error with a
//! location, never a panic, in linear time.

use serde_json::{Value, json};
use tristrip::Layout;
use tristrip_io::{
    Drawing, Error, Format, Model, PartLevel, SceneLevels, gltf, in_level_order, load_materials, write,
};

use crate::doubling::check_linear;
use crate::gltf_documents::scenes::shared_scene;
use crate::gltf_documents::*;
use crate::random::mutated_documents;

/// Returns a scene with transforms, children, and animated morph weights. Its nodes draw three
/// meshes.
fn scene() -> Draft {
    let mut draft = shared_scene(3);
    let times = draft.view(&floats(&[0.0, 1.0]));
    let times = draft.accessor(times, F32, 2, "SCALAR");
    draft.json["nodes"] = json!([
        { "children": [1, 2], "scale": [2, 2, 2], "rotation": [0, 0, 0, 1] },
        { "mesh": 0, "translation": [1, 2, 3], "weights": [0.5, 0.5] },
        { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1], "children": [3] },
        { "mesh": 1, "camera": 0 },
        { "mesh": 2, "skin": 0 },
    ]);
    draft.json["scenes"][0]["nodes"] = json!([0, 4]);
    draft.json["cameras"] = json!([{ "type": "orthographic" }]);
    draft.json["animations"] = json!([{
        "samplers": [{ "input": times, "output": times }],
        "channels": [{ "sampler": 0, "target": { "node": 1, "path": "weights" } }],
    }]);
    draft
}

/// Returns a document with one mesh of one triangle, and these nodes.
fn with_nodes(nodes: Value) -> Draft {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(4));
    let indices = draft.indices(U16, &[0, 1, 2, 2, 1, 3]);
    draft.primitive(positions, Some(indices), 4);
    draft.json["nodes"] = nodes;
    draft
}

/// Adds lower levels that all consist of the first triangle of each part.
fn leveled(model: &Model, lower: usize) -> Result<SceneLevels, Error> {
    let level = |most: usize| {
        let parts = model.parts.iter().map(|part| {
            let corners = part.mesh.faces().as_triangles().unwrap();
            PartLevel { triangles: corners[..corners.len().min(most)].to_vec(), added: Vec::new() }
        });
        parts.collect::<Vec<_>>()
    };
    let mut levels = vec![level(3); lower + 1];
    levels[0] = level(usize::MAX);
    in_level_order(model, &levels, Format::Glb)?.scene(&|_| vec![0.0; lower + 1])
}

fn message<T>(result: Result<T, Error>) -> String {
    result.map(drop).unwrap_err().to_string()
}

/// Computes placements and levels of a document. Returns whether both succeed; every error has a
/// message.
fn use_document(glb: Vec<u8>) -> bool {
    let failed = |error: Error| {
        let (at, found, expected) = match &error {
            Error::Format { at, found, expected } => (&**at, &**found, &**expected),
            _ => ("-", "-", "-"),
        };
        assert!(!at.is_empty() && !found.is_empty() && !expected.is_empty(), "{error}");
        assert!(found != "something else" && error.to_string().len() < 1000, "{error}");
        false
    };
    let model = match gltf::read(glb, None) {
        Ok(model) => model,
        Err(error) => return failed(error),
    };
    let places = match model.scene.as_ref().unwrap().appearance() {
        Ok(appearance) => appearance,
        Err(error) => return failed(error),
    };
    assert!(places.instances.iter().flat_map(|place| place.transform).flatten().all(f64::is_finite));
    assert!(places.materials.iter().flat_map(|material| material.base_colour).all(f32::is_finite));
    let levels = match leveled(&model, 2) {
        Ok(levels) => levels,
        Err(error) => return failed(error),
    };
    let drawings = vec![Drawing::Faces; levels.model.parts.len()];
    let glb = match write(&levels.model, &drawings, Format::Glb, Layout::List) {
        Ok(glb) => glb,
        Err(error) => return failed(error),
    };
    let again = gltf::read(glb, None).unwrap();
    assert_eq!(again.parts.len(), levels.model.parts.len());
    true
}

#[test]
fn mutations_never_panic() {
    let glb = scene().glb();
    assert!(use_document(glb.clone()));
    let done = mutated_documents(&glb, 3000).filter(|changed| use_document(changed.clone())).count();
    assert!((300..2900).contains(&done), "{done}");
}

/// Lists the pointers to all values of a document.
fn pointers(value: &Value, at: &str, all: &mut Vec<String>) {
    let entries: Vec<(String, &Value)> = match value {
        Value::Array(items) => items.iter().enumerate().map(|(i, item)| (i.to_string(), item)).collect(),
        Value::Object(members) => members.iter().map(|(name, item)| (name.clone(), item)).collect(),
        _ => Vec::new(),
    };
    for (name, item) in entries {
        let at = format!("{at}/{name}");
        pointers(item, &at, all);
        all.push(at);
    }
}

#[test]
fn every_value_may_be_wrong() {
    let draft = scene();
    let mut all = Vec::new();
    pointers(&draft.json, "", &mut all);
    let wrong = [
        json!(null),
        json!(-1),
        json!(0.5),
        json!(1e308),
        json!(u64::MAX),
        json!(u32::MAX),
        json!("x".repeat(5000)),
        json!([]),
        json!([[0]]),
        json!({}),
        json!({ "extensions": 1, "extras": [] }),
    ];
    let mut done = 0;
    for at in &all {
        for value in &wrong {
            let mut changed = Draft { json: draft.json.clone(), bin: draft.bin.clone() };
            *changed.json.pointer_mut(at).unwrap() = value.clone();
            done += usize::from(use_document(changed.glb()));
        }
    }
    assert!(all.len() > 200 && (100..all.len() * wrong.len() / 2).contains(&done), "{done} of {}", all.len());
}

#[test]
fn transforms_are_finite_numbers() {
    let placed = |json: &str| {
        let draft = with_nodes(json!("NODES"));
        let text = draft.json.to_string().replace("\"NODES\"", json);
        let text = text
            .replace("\"buffers\":[{}]", &format!("\"buffers\":[{{\"byteLength\":{}}}]", draft.bin.len()));
        gltf::read(glb_of(text.as_bytes(), Some(&draft.bin)), None)?.scene.unwrap().placements()
    };
    let wrong = message(placed(r#"[{"mesh":0,"translation":[0,1e999,0]}]"#));
    assert_eq!(wrong, "nodes[0].translation[1]: found 1e999, expected a finite number");
    let wrong = message(placed(r#"[{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,-1e999,0,0,0,0,1]}]"#));
    assert_eq!(wrong, "nodes[0].matrix[10]: found -1e999, expected a finite number");
    assert!(message(placed(r#"[{"mesh":0,"scale":[NaN,0,0]}]"#)).starts_with("JSON line 1, "));
    assert!(message(placed(r#"[{"mesh":0,"scale":["1",0,0]}]"#)).contains("scale[0]: found \"1\""));
    // Each number is finite, but the products are not.
    let beyond = "found a transform that overflows, expected a finite transform";
    let wrong = message(placed(r#"[{"children":[1],"scale":[1e200,1,1]},{"mesh":0,"scale":[1e200,1,1]}]"#));
    assert_eq!(wrong, format!("nodes[1]: {beyond}"));
    let wrong = message(placed(r#"[{"mesh":0,"rotation":[1e200,0,1e200,1]}]"#));
    assert_eq!(wrong, format!("nodes[0]: {beyond}"));
    // The transform of a node with a skin is ignored, and a node without a mesh has no placement.
    let skinned = r#"[{"children":[1,2],"scale":[1e200,1,1]},{"mesh":0,"skin":0,"scale":[1e200,1,1]},{"scale":[1e200,1,1]}]"#;
    assert_eq!(
        placed(skinned).unwrap()[0].transform[0].map(f64::to_bits),
        [1.0, 0.0, 0.0, 0.0].map(f64::to_bits)
    );
}

#[test]
fn nodes_are_a_tree() {
    let read = |nodes: Value| gltf::read(with_nodes(nodes).glb(), None);
    for (nodes, expected) in [
        (json!([{ "children": [0] }]), "nodes[0]: found a cycle of children, expected a tree"),
        (
            json!([{ "mesh": 0 }, { "children": [2] }, { "children": [1] }]),
            "nodes[1]: found a cycle of children, expected a tree",
        ),
        (json!([{ "children": [1] }]), "nodes[0].children[0]: found 1, expected less than 1"),
        (json!([{ "children": [-1] }]), "nodes[0].children[0]: found -1, expected a non-negative integer"),
        (json!([{ "children": 1 }]), "nodes[0].children: found 1, expected an array"),
    ] {
        let wrong = message(read(nodes));
        assert!(wrong.starts_with(expected), "{wrong}");
    }
    let placed = |nodes: Value| read(nodes).unwrap().scene.unwrap().placements();
    let two_parents = "found a node with two parents, expected a tree";
    let shared = json!([{ "children": [1, 2] }, { "children": [3] }, { "children": [3] }, { "mesh": 0 }]);
    assert_eq!(message(placed(shared)), format!("nodes[3]: {two_parents}"));
    assert_eq!(message(placed(json!([{ "children": [1, 1] }, {}]))), format!("nodes[1]: {two_parents}"));
    assert_eq!(
        message(placed(json!([{ "mesh": 1 }]))),
        "nodes[0].mesh: found 1, expected less than 1, the number of meshes"
    );
    let wrong = message(placed(json!([{ "mesh": -1 }])));
    assert_eq!(wrong, "nodes[0].mesh: found -1, expected a non-negative integer");
}

#[test]
fn deep_nodes_take_linear_time() {
    let chain = |depth: usize| {
        let node = |i: usize| json!({ "children": [i + 1], "translation": [1, 0, 0] });
        let nodes: Vec<Value> = (0..depth).map(node).chain([json!({ "mesh": 0 })]).collect();
        (depth, with_nodes(nodes.into()).glb())
    };
    check_linear(4000, chain, |(depth, glb)| {
        let model = gltf::read(&glb[..], None).unwrap();
        let places = model.scene.as_ref().unwrap().placements().unwrap();
        assert_eq!(places[0].transform[0][3].to_bits(), (*depth as f64).to_bits());
        assert_eq!(leveled(&model, 1).unwrap().meshes, [[0], [1]]);
    });
}

#[test]
fn levels_of_many_accessors_take_linear_time() {
    let primitives = |count: usize| {
        let mut draft = Draft::new();
        for _ in 0..count {
            let positions = draft.positions(&bent(4));
            let indices = draft.indices(U16, &[0, 1, 2, 2, 1, 3]);
            draft.primitive(positions, Some(indices), 4);
        }
        gltf::read(draft.glb(), None).unwrap()
    };
    check_linear(400, primitives, |model| {
        assert_eq!(leveled(model, 1).unwrap().parts[1].len(), model.parts.len());
    });
}

#[test]
fn extras_of_a_mesh_are_searched_once_for_all_its_primitives() {
    let primitives = |count: usize| {
        let mut draft = with_nodes(json!([{ "mesh": 0 }]));
        let mesh = &mut draft.json["meshes"][0];
        mesh["primitives"] = vec![mesh["primitives"][0].clone(); count].into();
        mesh["extras"] = vec![json!("x"); 4 * count].into();
        gltf::read(draft.glb(), None).unwrap()
    };
    check_linear(1000, primitives, |model| {
        let level: Vec<PartLevel> = vec![PartLevel::default(); model.parts.len()];
        assert_eq!(in_level_order(model, &[level], Format::Glb).unwrap().level_count(), 1);
    });
}

#[test]
fn parts_in_too_many_places_are_refused_before_they_are_listed() {
    let mut draft = with_nodes(vec![json!({ "mesh": 0 }); 2000].into());
    let primitive = draft.json["meshes"][0]["primitives"][0].clone();
    draft.json["meshes"][0]["primitives"] = vec![primitive; 2000].into();
    draft.json["scenes"][0]["nodes"] = (0..2000).collect();
    draft.json["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorFactor": [1e300, 0.5, -1, 1] } }]);
    draft.json["meshes"][0]["primitives"][0]["material"] = 0.into();
    let mut model = gltf::read(draft.glb(), None).unwrap();
    let scene = model.scene.as_ref().unwrap();
    assert_eq!(scene.placements().unwrap().len(), 2000);
    let error = scene.appearance().unwrap_err();
    let Error::LimitExceeded { at, found, limit } = error else { unreachable!("{error}") };
    assert_eq!((&*at, found, limit), ("nodes, instances of parts", 4_000_000, (1 << 20) + 4 * 2000));
    // A material library does not depend on placements; its colours are from 0 to 1.
    load_materials(&mut model, None, "out");
    let materials = model.materials.unwrap();
    let text = String::from_utf8(materials.files[0].bytes.to_vec()).unwrap();
    assert!(text.contains("Kd 1 0.5 0\nd 1\n"), "{text}");
}

#[test]
fn scenes_that_name_levels_in_any_way_get_no_others() {
    for ids in [
        json!([1]),
        json!([0]),
        json!([7]),
        json!([-1]),
        json!([u64::MAX]),
        json!("x"),
        json!({}),
        json!(null),
    ] {
        for is_declared in [false, true] {
            let mut draft = with_nodes(
                json!([{ "mesh": 0, "extensions": { "MSFT_lod": { "ids": ids } } }, { "mesh": 0 }]),
            );
            if is_declared {
                draft.json["extensionsUsed"] = json!(["MSFT_lod"]);
            }
            let model = gltf::read(draft.glb(), None).unwrap();
            // The nodes of levels are not in a scene: their references are not followed.
            assert_eq!(model.scene.as_ref().unwrap().placements().unwrap().len(), 1);
            let wrong = message(leveled(&model, 1));
            assert!(wrong.starts_with("the scene already has levels of detail (MSFT_lod)"), "{ids}: {wrong}");
        }
    }
}

#[test]
fn levels_are_named_whatever_else_a_node_has() {
    for (member, value) in [
        ("extensions", json!(5)),
        ("extensions", json!([])),
        ("extensions", json!(null)),
        ("extras", json!(5)),
        ("extras", json!([1])),
        ("name", json!(5)),
        ("weights", json!({})),
        ("skin", json!(-1)),
    ] {
        let mut draft = with_nodes(json!([{ "mesh": 0 }]));
        draft.json["nodes"][0][member] = value.clone();
        let model = gltf::read(draft.glb(), None).unwrap();
        let scene = leveled(&model, 1).unwrap().model;
        let glb = write(&scene, &[Drawing::Faces; 2], Format::Glb, Layout::List).unwrap();
        let json = json_of(&glb);
        let named: Vec<&Value> = json["nodes"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|n| n["extensions"]["MSFT_lod"].is_object())
            .collect();
        assert_eq!(named.len(), 1, "{member}: {value}");
        let lower = named[0]["extensions"]["MSFT_lod"]["ids"][0].as_u64().unwrap() as usize;
        assert_eq!(json["nodes"][lower]["mesh"], 1, "{member}: {value}");
    }
    let mut draft = with_nodes(json!([{ "mesh": 0 }]));
    draft.json["extensionsUsed"] = json!(7);
    let model = gltf::read(draft.glb(), None).unwrap();
    assert_eq!(message(leveled(&model, 1)), "extensionsUsed: found 7, expected an array");
}

#[test]
fn the_size_of_all_levels_is_limited() {
    let draft = with_nodes(vec![json!({ "mesh": 0 }); 9000].into());
    let model = gltf::read(draft.glb(), None).unwrap();
    assert!(leveled(&model, 50).is_ok());
    let error = leveled(&model, 60).unwrap_err();
    let Error::LimitExceeded { at, found, limit } = error else { unreachable!("{error}") };
    assert_eq!(at, "values of the JSON with all levels");
    assert_eq!((found, limit), (60 * 8 * 9003, 4 << 20));
}
