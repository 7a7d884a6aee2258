//! Scenes written in every layout, and a naive comparison of the data that must not change.

use serde_json::{Value, json};
use tristrip::{Layout, Strips};
use tristrip_io::{Drawing, Format, Model, gltf};

use crate::gltf_documents::*;

pub(crate) const LAYOUTS: [Layout; 4] = [Layout::Restart, Layout::Degenerate, Layout::Separate, Layout::List];

pub(crate) fn strips_of(model: &Model) -> Vec<Strips> {
    (0..model.parts.len())
        .map(|part| {
            let real = triangles(model, part).into_iter();
            greedy(&real.filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]).collect::<Vec<_>>())
        })
        .collect()
}

pub(crate) fn write(model: &Model, strips: &[Strips], layout: Layout) -> Vec<u8> {
    let drawings: Vec<_> = strips.iter().map(Drawing::Strips).collect();
    tristrip_io::write(model, &drawings, Format::Glb, layout).unwrap()
}

/// Returns a document with each kind of reference.
pub(crate) fn rich() -> Draft {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(6));
    let normals = draft.view(&floats(&[0.0, 0.0, 1.0].repeat(6)));
    let normals = draft.accessor(normals, F32, 6, "VEC3");
    let old = draft.indices(U16, &[0, 1, 2, 2, 1, 3, 3, 4, 5]);
    let texcoords = draft.view(&floats(&[0.5; 12]));
    let texcoords = draft.accessor(texcoords, F32, 6, "VEC2");
    let joints = draft.view(&[0; 24]);
    let joints = draft.accessor(joints, U8, 6, "VEC4");
    let weights = draft.view(&floats(&[1.0, 0.0, 0.0, 0.0].repeat(6)));
    let weights = draft.accessor(weights, F32, 6, "VEC4");
    let png = draft.view(&PNG);
    let shared = draft.indices(U8, &[0, 1, 2, 1, 3, 2]);
    let targets = draft.positions(&bent(6));
    let identity: Vec<f32> = (0..16).map(|i| f32::from(u8::from(i % 5 == 0))).collect();
    let matrices = draft.view(&floats(&identity));
    let matrices = draft.accessor(matrices, F32, 1, "MAT4");
    let times = draft.view(&floats(&[0.0, 1.5]));
    let times = draft.accessor(times, F32, 2, "SCALAR");
    draft.json["accessors"][times]["min"] = json!([0.0]);
    draft.json["accessors"][times]["max"] = json!([1.5]);
    let outputs = draft.view(&floats(&[0.0, 1.0]));
    let outputs = draft.accessor(outputs, F32, 2, "SCALAR");
    for view in [normals, texcoords, joints, weights, targets] {
        let view = draft.json["accessors"][view]["bufferView"].as_u64().unwrap() as usize;
        draft.json["bufferViews"][view]["target"] = 34962.into();
    }
    let primitive = |indices: usize| {
        json!({
            "attributes": {
                "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": texcoords,
                "JOINTS_0": joints, "WEIGHTS_0": weights,
            },
            "indices": indices, "material": 0, "targets": [{ "POSITION": targets }],
            "extras": { "primitive": "kept" }, "extensions": { "EXT_unknown_thing": { "deep": [1.5, true] } },
        })
    };
    draft.json["meshes"][0] = json!({
        "name": "rich", "weights": [0.25], "extras": { "precise": 0.1 },
        "primitives": [primitive(old), primitive(shared), primitive(shared)],
    });
    draft.json["skins"] = json!([{ "joints": [1], "inverseBindMatrices": matrices, "extras": { "s": "x" } }]);
    draft.json["nodes"] =
        json!([{ "mesh": 0, "skin": 0 }, { "name": "bone", "translation": [1e-3, 2.50, 3] }]);
    draft.json["scenes"] = json!([{ "nodes": [0, 1] }]);
    draft.json["animations"] = json!([{
        "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        "samplers": [{ "input": times, "output": outputs }],
    }]);
    draft.json["images"] = json!([{ "bufferView": png, "mimeType": "image/png" }]);
    draft.json["textures"] = json!([{ "source": 0 }]);
    draft.json["materials"] =
        json!([{ "name": "skin", "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    draft.json["extensionsUsed"] = json!(["EXT_unknown_thing"]);
    draft
}

pub(crate) const PNG: [u8; 67] = [
    0x89, b'P', b'N', b'G', 13, 10, 26, 10, 0, 0, 0, 13, b'I', b'H', b'D', b'R', 0, 0, 0, 1, 0, 0, 0, 1, 8,
    0, 0, 0, 0, 0x3A, 0x7E, 0x9B, 0x55, 0, 0, 0, 10, b'I', b'D', b'A', b'T', 0x78, 0x9C, 0x63, 0x60, 0, 0, 0,
    2, 0, 1, 0x48, 0xAF, 0xA4, 0x71, 0, 0, 0, 0, b'I', b'E', b'N', b'D', 0xAE, 0x42, 0x60, 0x82,
];

/// Checks that two GLBs differ only in indices and modes: all other JSON and the bytes it refers to
/// are the same.
pub(crate) fn assert_scene_kept(before: &[u8], after: &[u8], layout: Layout) {
    let (old, new) = (json_of(before), json_of(after));
    let (old_bin, new_bin) = (bin_of(before), bin_of(after));
    let rest = |json: &Value| {
        let mut json = json.clone();
        let members = json.as_object_mut().unwrap();
        for list in ["accessors", "bufferViews", "buffers"] {
            members.shift_remove(list);
        }
        for list in ["extensionsUsed", "extensionsRequired"] {
            if let Some(names) = members.get_mut(list).and_then(Value::as_array_mut) {
                names.retain(|n| n != "KHR_mesh_primitive_restart");
                if names.is_empty() {
                    members.shift_remove(list);
                }
            }
        }
        for mesh in json["meshes"].as_array_mut().unwrap() {
            let primitives = mesh["primitives"].as_array_mut().unwrap();
            for primitive in primitives.iter_mut().filter(|p| p["mode"].as_u64().is_none_or(|m| m >= 4)) {
                primitive.as_object_mut().unwrap().shift_remove("indices");
                primitive.as_object_mut().unwrap().shift_remove("mode");
            }
            if layout == Layout::Separate {
                primitives.dedup();
            }
        }
        json
    };
    let (mut a, mut b) = (rest(&old), rest(&new));
    assert_eq!(a, b);
    // Even the digits of numbers are the same.
    for json in [&mut a, &mut b] {
        json.as_object_mut().unwrap().sort_keys();
    }
    assert_eq!(a.to_string(), b.to_string());
    // The remaining references lead to the same bytes.
    let drawn: Vec<u64> = old["meshes"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|m| m["primitives"].as_array().unwrap())
        .filter(|p| p["mode"].as_u64().is_none_or(|m| m >= 4))
        .filter_map(|p| p["indices"].as_u64())
        .collect();
    for (index, accessor) in old["accessors"].as_array().unwrap().iter().enumerate() {
        if drawn.contains(&(index as u64)) {
            continue;
        }
        assert_eq!(*accessor, new["accessors"][index]);
        let view = accessor["bufferView"].as_u64().unwrap() as usize;
        assert_eq!(view_bytes(&old, old_bin, view), view_bytes(&new, new_bin, view));
    }
    for image in old["images"].as_array().into_iter().flatten() {
        let view = image["bufferView"].as_u64().unwrap() as usize;
        assert_eq!(view_bytes(&old, old_bin, view), view_bytes(&new, new_bin, view));
    }
}

/// Writes a document in every layout, checks each file, and returns them for the validator.
pub(crate) fn check_scene(name: &str, glb: &[u8]) -> Vec<(String, Vec<u8>)> {
    let model = gltf::read(glb, None).unwrap();
    let strips = strips_of(&model);
    let mut files = Vec::new();
    for layout in LAYOUTS {
        let after = write(&model, &strips, layout);
        assert_scene_kept(glb, &after, layout);
        let back = gltf::read(after.clone(), None).unwrap();
        if layout == Layout::Separate {
            let drawn: usize = strips.iter().map(|s| s.len().max(1)).sum();
            assert_eq!(back.parts.len(), drawn);
        } else {
            for (part, strips) in strips.iter().enumerate() {
                // Joined strips are drawn in another order.
                let sorted = |mut triangles: Vec<[u32; 3]>| {
                    triangles.sort_unstable();
                    triangles
                };
                let (drawn, expected) = (sorted(triangles(&back, part)), sorted(rotated(strips.triangles())));
                assert!(drawn == expected, "{name} {layout:?} {part}: other triangles are drawn");
            }
        }
        files.push((format!("{name}_{layout:?}.glb"), after));
    }
    files
}
