//! Reordered vertices of scenes: the values of all accessors move with their vertices; groups that
//! cannot be reordered keep their order.

use proptest::prelude::*;
use serde_json::{Value, json};
use tristrip::verify::verify_models;
use tristrip::{Layout, Mesh, VertexOrder, strip_triangles};
use tristrip_io::{Format, Reordered, gltf, reorder, write};

use crate::gltf_documents::scenes::{grid, interleaved, raw, shared_scene};
use crate::gltf_documents::*;
use crate::random::mutated_documents;
use crate::reordered::{check, check_first_uses, drawn, meshes, strips_of};

const LAYOUTS: [Layout; 4] = [Layout::Restart, Layout::Degenerate, Layout::Separate, Layout::List];

/// Checks a scene: the accessors of a group are in its order, the others unchanged; the JSON is the
/// same except for indices.
fn check_scene(glb: &[u8], layout: Layout) -> (Reordered, Vec<u8>) {
    let model = gltf::read(glb, None).unwrap();
    let (reordered, after) = check(&model, Format::Glb, layout);
    let (old, new) = (json_of(glb), json_of(&after));
    let mut index_accessors = Vec::new();
    let mut orders: Vec<(u64, VertexOrder)> = Vec::new();
    let mut part = 0;
    for mesh in old["meshes"].as_array().unwrap() {
        for primitive in mesh["primitives"].as_array().unwrap() {
            if primitive["mode"].as_u64().is_some_and(|mode| mode < 4) {
                continue;
            }
            index_accessors.extend(primitive["indices"].as_u64());
            let group = reordered.groups.iter().find(|group| group.parts.contains(&part)).unwrap();
            let objects =
                primitive["targets"].as_array().into_iter().flatten().chain([&primitive["attributes"]]);
            for accessor in objects.flat_map(|o| o.as_object().unwrap().values()).filter_map(Value::as_u64) {
                orders.push((accessor, group.order.clone()));
            }
            part += 1;
        }
    }
    for number in 0..old["accessors"].as_array().unwrap().len() {
        if index_accessors.contains(&(number as u64)) {
            continue;
        }
        assert_eq!(old["accessors"][number], new["accessors"][number]);
        let (before, after) = (raw(glb, number), raw(&after, number));
        let order = orders.iter().find(|(accessor, _)| *accessor == number as u64);
        let expected = match order {
            Some((_, order)) if order.moved_count() > 0 => {
                order.new_to_old().iter().map(|&v| before[v as usize].clone()).collect()
            }
            _ => before,
        };
        assert_eq!(after, expected, "accessor {number}");
    }
    (reordered, after)
}

#[test]
fn accessors_of_a_scene_move_with_their_vertices() {
    let glb = shared_scene(6).glb();
    let mut files = vec![("source.glb".to_owned(), glb.clone())];
    for layout in LAYOUTS {
        let (reordered, after) = check_scene(&glb, layout);
        let parts: Vec<_> = reordered.groups.iter().map(|group| group.parts.clone()).collect();
        assert_eq!(parts, [vec![0, 1], vec![2]]);
        assert!(reordered.groups.iter().all(|group| group.kept.is_none() && group.order.moved_count() > 40));
        let once = gltf::read(after.clone(), None).unwrap();
        if layout != Layout::Separate {
            // First uses are also in ascending order in the file, across both primitives of a
            // group.
            let json = json_of(&after);
            let indices = |mesh: usize| {
                let accessor = json["meshes"][mesh]["primitives"][0]["indices"].as_u64().unwrap() as usize;
                let values = raw(&after, accessor).into_iter();
                let value = |b: Vec<u8>| b.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b));
                values.map(value).filter(|&v| v != 255 && v != 65535).collect::<Vec<_>>()
            };
            check_first_uses(indices(1), check_first_uses(indices(0), 0));
            check_first_uses(indices(2), 0);
            assert_eq!(once.parts.len(), 3);
        }
        files.push((format!("{layout:?}.glb"), after));
    }
    validate("accessors_of_a_scene", &files);
}

#[test]
fn a_document_with_external_buffers_is_reordered() {
    let draft = shared_scene(4);
    let model = gltf::read(draft.gltf(), None).unwrap();
    let (reordered, after) = check(&model, Format::Glb, Layout::Degenerate);
    let (again, plain) = check_scene(&draft.glb(), Layout::Degenerate);
    assert!(reordered.groups == again.groups && after == plain);
}

#[test]
fn vertices_keep_their_order_where_something_depends_on_it() {
    let kept = |draft: &Draft, group: usize, why: &str| {
        let (reordered, _) = check_scene(&draft.glb(), Layout::Degenerate);
        let reasons: Vec<_> = reordered.groups.iter().map(|group| group.kept.clone()).collect();
        let found = reasons[group].clone().unwrap_or_default();
        assert!(found.contains(why), "{reasons:?}");
        assert_eq!(reasons.iter().flatten().count(), 1, "{reasons:?}");
    };
    let primitives = |draft: &mut Draft, mesh: usize, value: Value| {
        push(&mut draft.json["meshes"][mesh]["primitives"], value);
    };
    let mut draft = shared_scene(4);
    primitives(&mut draft, 1, json!({ "attributes": { "POSITION": 0 }, "mode": 0 }));
    kept(&draft, 0, "points or lines");
    for extras in [json!({ "order": [3, 1, 2] }), json!(7)] {
        let mut draft = shared_scene(4);
        draft.json["meshes"][2]["primitives"][0]["extras"] = extras;
        kept(&draft, 1, "may refer to vertices by index");
    }
    let mut draft = shared_scene(4);
    draft.json["meshes"][0]["extensions"] = json!({ "EXT_unknown_thing": { "indices": 4 } });
    kept(&draft, 0, "may refer to vertices by index");
    let mut draft = shared_scene(4);
    draft.json["bufferViews"][0]["extensions"] = json!({ "EXT_unknown_thing": { "stripes": 4 } });
    kept(&draft, 0, "may refer to vertices by index");
    let mut draft = shared_scene(4);
    let own = draft.json["meshes"][2]["primitives"][0]["attributes"]["POSITION"].clone();
    draft.json["nodes"][2]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": own } } });
    kept(&draft, 1, "another use");
    // A morph target with fewer values than vertices.
    let mut draft = shared_scene(4);
    let short = draft.positions(&bent(5));
    draft.json["meshes"][2]["primitives"][0]["targets"] = json!([{ "POSITION": short }]);
    kept(&draft, 1, "does not have one value per vertex");
    // An image between the vertices.
    let mut draft = shared_scene(4);
    let view =
        push(&mut draft.json["bufferViews"], json!({ "buffer": 0, "byteOffset": 16, "byteLength": 40 }));
    draft.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    kept(&draft, 0, "uses the same bytes");
    // A view without an accessor.
    let mut draft = shared_scene(4);
    push(&mut draft.json["bufferViews"], json!({ "buffer": 0, "byteOffset": 28, "byteLength": 4 }));
    kept(&draft, 0, "uses the same bytes");
    let mut draft = shared_scene(4);
    draft.json["extensions"] = json!({ "EXT_unknown_thing": { "buffer": 0, "byteOffset": 144 } });
    let (reordered, _) = check_scene(&draft.glb(), Layout::Degenerate);
    assert!(reordered.groups.iter().all(|group| group.kept.as_ref().unwrap().contains("refers to bytes")));
}

#[test]
fn material_variants_and_extras_without_numbers_allow_reordering() {
    let mut draft = shared_scene(4);
    draft.json["meshes"][0]["extras"] = json!({ "targetNames": ["a", "b"], "scale": 0.5 });
    draft.json["meshes"][0]["primitives"][0]["extensions"] =
        json!({ "KHR_materials_variants": { "mappings": [{ "material": 0, "variants": [0] }] } });
    let features = |ids: Value| json!({ "EXT_mesh_features": { "featureIds": [ids] } });
    let primitive = |draft: &mut Draft, extensions| {
        draft.json["meshes"][2]["primitives"][0]["extensions"] = extensions;
    };
    primitive(&mut draft, features(json!({ "featureCount": 9, "attribute": 0 })));
    let (reordered, _) = check_scene(&draft.glb(), Layout::Restart);
    assert!(reordered.groups.iter().all(|group| group.kept.is_none()));
    // Without an attribute or texture, the vertex indices are the ids.
    primitive(&mut draft, features(json!({ "featureCount": 9 })));
    let (reordered, _) = check_scene(&draft.glb(), Layout::Restart);
    assert_eq!(reordered.groups.iter().map(|group| group.kept.is_some()).collect::<Vec<_>>(), [false, true]);
}

#[test]
fn accessors_over_the_same_bytes() {
    let scene = |second_offset: usize, share: bool| {
        let mut draft = Draft::new();
        let (positions, corners) = grid(3);
        let count = positions.len();
        let position = draft.positions(&positions);
        let view = draft.json["accessors"][position]["bufferView"].clone();
        draft.bin.resize(draft.bin.len() + 64, 0);
        draft.json["bufferViews"][0]["byteLength"] = (12 * count + 24).into();
        let twin = push(
            &mut draft.json["accessors"],
            json!({ "bufferView": view, "byteOffset": second_offset, "componentType": F32, "count": count, "type": "VEC3" }),
        );
        let indices = draft.indices(U16, &corners);
        let other: Vec<u32> = corners.iter().rev().copied().collect();
        let reversed = draft.indices(U16, &other);
        if share {
            let attributes = json!({ "POSITION": position, "_TWIN": twin });
            draft.json["meshes"][0]["primitives"] = json!([{ "attributes": attributes, "indices": indices }]);
        } else {
            draft.primitive(position, Some(indices), 4);
            draft.primitive(twin, Some(reversed), 4);
        }
        check_scene(&draft.glb(), Layout::Restart).0
    };
    // Values shared by two accessors are moved once.
    let same = scene(0, true);
    assert!(same.groups[0].kept.is_none() && same.groups[0].order.moved_count() > 10);
    // Two accessors that are offset by one vertex cannot be moved together.
    assert!(scene(12, true).groups[0].kept.as_ref().unwrap().contains("overlap"));
    // The same bytes cannot be moved in two orders.
    for offset in [0, 12, 24] {
        let two = scene(offset, false);
        assert_eq!(two.groups.len(), 2);
        assert!(two.groups.iter().all(|group| group.kept.as_ref().unwrap().contains("other data")));
    }
}

#[test]
fn sparse_indices_must_hold_the_new_numbers() {
    let scene = |component: u32| {
        let mut draft = Draft::new();
        let (positions, mut corners) = grid(18);
        let count = positions.len();
        corners.retain(|&v| v != 0);
        corners.truncate(corners.len() / 3 * 3);
        let position = draft.positions(&positions);
        // Vertex 0 is in no triangle, so more than 255 others precede it.
        let indices = draft.view(&packed(component, &[0, 3]));
        let values = draft.view(&floats(&[1.0; 6]));
        let sparse = push(
            &mut draft.json["accessors"],
            json!({
                "componentType": F32, "count": count, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1],
                "sparse": {
                    "count": 2, "indices": { "bufferView": indices, "componentType": component },
                    "values": { "bufferView": values },
                },
            }),
        );
        let indices = draft.indices(U16, &corners);
        draft.primitive(position, Some(indices), 4);
        draft.json["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": sparse }]);
        check_scene(&draft.glb(), Layout::Restart).0.groups.remove(0).kept
    };
    assert!(scene(U8).unwrap().contains("index type of a sparse accessor"));
    assert_eq!((scene(U16), scene(U32)), (None, None));
}

/// Documents with a few changed bytes: if they can be read, they can be reordered and written, and
/// draw the same triangles.
#[test]
fn mutations_never_panic() {
    let glb = shared_scene(3).glb();
    let mut done = 0;
    for changed in mutated_documents(&glb, 4000) {
        let Ok(model) = gltf::read(changed, None) else { continue };
        let strips = strips_of(&model);
        let reordered = reorder(&model, &drawn(&strips), Format::Glb, Layout::Restart).unwrap();
        let bytes = write(&reordered.model, &reordered.drawings(), Format::Glb, reordered.layout).unwrap();
        let back = gltf::read(bytes, None).unwrap();
        assert!(verify_models(&meshes(&model), &meshes(&back)).unwrap().is_ok());
        for (ordered, back) in reordered.model.parts.iter().zip(&back.parts) {
            let bits =
                |mesh: &Mesh| mesh.positions().iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&ordered.mesh), bits(&back.mesh));
        }
        done += 1;
    }
    assert!(done > 500, "{done}");
}

#[test]
fn reorders_real_scenes() {
    check_real_scenes("reorders_real_scenes", |name, glb| {
        let layouts = [Layout::Restart, Layout::Degenerate, Layout::List].into_iter();
        let files = layouts.map(|layout| {
            let (reordered, after) = check_scene(glb, layout);
            assert!(reordered.groups.iter().all(|group| group.kept.is_none()));
            (format!("{name}_{layout:?}.glb"), after)
        });
        files.collect()
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 5))]
    /// Primitives with vertex arrays that are shared, interleaved in one view, or in separate
    /// views.
    #[test]
    fn every_scene_is_reordered_or_kept(
        primitives in prop::collection::vec((0..3_usize, prop::collection::vec(0..12_u32, 3..30)), 1..5),
        separate in any::<bool>(),
        overlap in any::<bool>(),
        layout in prop::sample::select(LAYOUTS.to_vec()),
    ) {
        let mut draft = Draft::new();
        let mut rows = Vec::new();
        for i in 0..12_u8 {
            for list in 0..3_u8 {
                rows.extend(floats(&[f32::from(i), f32::from(list), f32::from(i * i % 5)]));
            }
        }
        let at = if overlap { [0, 4, 24] } else { [0, 12, 24] };
        let accessors = if separate {
            (0..3_u8).map(|list| {
                let all: Vec<_> = (0..12_u8).map(|i| [f32::from(i), f32::from(list), 0.0]).collect();
                draft.positions(&all)
            }).collect()
        } else {
            interleaved(&mut draft, 36, &rows, &at.map(|offset| (offset, F32, "VEC3")))
        };
        for (list, corners) in &primitives {
            let indices = draft.indices(U8, &corners[..corners.len() / 3 * 3]);
            draft.primitive(accessors[*list], Some(indices), 4);
        }
        let (reordered, glb) = check_scene(&draft.glb(), layout);
        let clash = overlap && !separate && reordered.groups.len() > 1;
        prop_assert!(clash || reordered.groups.iter().all(|group| group.kept.is_none() || overlap));
        let drawn_count: usize = strips_of(&gltf::read(glb, None).unwrap()).iter().map(|s| s.iter().flat_map(strip_triangles).count()).sum();
        let expected_count: usize = strips_of(&gltf::read(draft.glb(), None).unwrap()).iter().map(|s| s.triangles().count()).sum();
        prop_assert_eq!(drawn_count, expected_count);
    }
}
