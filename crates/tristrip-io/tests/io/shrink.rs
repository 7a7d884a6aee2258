//! Scenes with fewer triangles: unused vertices are removed with all their values, and everything
//! else is unchanged.

use std::collections::BTreeSet;

use crate::gltf_documents::scenes::{grid, interleaved, shared_scene};
use crate::gltf_documents::*;
use crate::random::mutated_documents;
use crate::shrunk::{count_of, indices, number, shrunk};
use proptest::prelude::*;
use serde_json::{Value, json};
use tristrip::Layout;
use tristrip_io::{Drawing, Format, gltf, reorder, with_triangles, write};

#[test]
fn dropped_vertices_take_all_their_values_along() {
    let glb = shared_scene(6).glb();
    // The first two parts share vertices; the third has its own.
    let (redrawn, after) = shrunk(&glb, |part, t| part == 0 && t % 5 == 0 || part == 2 && t < 3);
    assert!(redrawn.kept_groups.is_empty() && redrawn.dropped > 60, "{redrawn:?}");
    let used = redrawn.model.parts.iter().map(|part| part.mesh.vertex_count()).collect::<Vec<_>>();
    assert_eq!((redrawn.used, used[0]), (used[0] + used[2], used[1]));
    for accessor in [0, 1, 2, 3, 4, 5, 6, 7] {
        assert_eq!(count_of(&after, accessor), used[0], "accessor {accessor}");
    }
    // Bytes per vertex: interleaved 28, joints 4, weights 16, matrix 16, target 12, own 12; plus at
    // most 16 per array.
    let vertices = used[0] * (28 + 4 + 16 + 16 + 12) + used[2] * 12;
    let others = 4 * 2 + 4 * 12 + 2 * 64 + 2 * 3 * 100;
    assert!(bin_of(&after).len() < vertices + others + 16 * 12, "{}", bin_of(&after).len());
    // The written file can be read and changed again.
    let (again, twice) = shrunk(&after, |part, t| part == 0 && t < 2);
    assert!(again.dropped > 5 && twice.len() < after.len());
    let external = gltf::read(shared_scene(6).gltf(), None).unwrap();
    let lists = external.parts.iter().map(|part| part.mesh.faces().corners()[..3].to_vec()).collect();
    let small = with_triangles(&external, lists, Format::Glb).unwrap();
    let small = write(&small.model, &[Drawing::Faces; 3], Format::Glb, Layout::List).unwrap();
    let same = shrunk(&glb, |_, t| t == 0).1;
    assert_eq!(bin_of(&small), bin_of(&same));
    validate(
        "dropped_vertices",
        &[("shrunk.glb".into(), after), ("twice.glb".into(), twice), ("same.glb".into(), same)],
    );
}

#[test]
fn sparse_values_of_dropped_vertices_are_dropped() {
    let glb = shared_scene(6).glb();
    let model = gltf::read(&glb[..], None).unwrap();
    // No vertex with a sparse value remains.
    let moved = |v: u32| [1, 4, 8, model.parts[0].mesh.vertex_count() as u32 - 1].contains(&v);
    let avoids = |part: usize, t: usize| {
        let corners = model.parts[part].mesh.faces().get(t).unwrap();
        part == 2 || corners.iter().all(|&v| !moved(v))
    };
    let (redrawn, after) = shrunk(&glb, |part, t| t < 9 && avoids(part, t));
    let json = json_of(&after);
    assert!(redrawn.dropped > 0 && json["accessors"][7].get("sparse").is_none(), "{}", json["accessors"][7]);
    assert_eq!(
        (&json["accessors"][7]["min"], &json["accessors"][7]["max"]),
        (&json!([0.0, 0.0, 0.0]), &json!([0.0, 0.0, 0.0]))
    );
    validate("sparse_values", &[("none.glb".into(), after)]);
}

#[test]
fn arrays_behind_each_other_in_one_view_move_together() {
    let mut draft = Draft::new();
    let (positions, corners) = grid(6);
    let count = positions.len();
    let other: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x + 0.5)).collect();
    // One view with positions, joints of two bytes, and the positions of another part; then an
    // image.
    let joints: Vec<u8> = (0..2 * count).map(|i| i as u8).collect();
    let bytes =
        [floats(positions.as_flattened()), joints, vec![0; 2 * count % 4], floats(other.as_flattened())]
            .concat();
    let view = draft.view(&bytes);
    let image = draft.view(&[137; 37]);
    let add = |draft: &mut Draft, offset: usize, component: u32, kind: &str| {
        let accessor = draft.accessor(view, component, count, kind);
        draft.json["accessors"][accessor]["byteOffset"] = offset.into();
        accessor
    };
    let first = add(&mut draft, 0, F32, "VEC3");
    let ids = add(&mut draft, 12 * count, U8, "VEC2");
    let second = add(&mut draft, 12 * count + (2 * count).next_multiple_of(4), F32, "VEC3");
    draft.json["images"] = json!([{ "bufferView": image, "mimeType": "image/png" }]);
    let list = draft.indices(U16, &corners);
    draft.primitive(first, Some(list), 4);
    draft.json["meshes"][0]["primitives"][0]["attributes"]["_ID"] = ids.into();
    draft.primitive(second, Some(list), 4);
    let glb = draft.glb();
    let (redrawn, after) = shrunk(&glb, |part, t| t < 20 - 10 * part);
    let counts = redrawn.model.parts.iter().map(|part| part.mesh.vertex_count()).collect::<Vec<_>>();
    assert!(counts[0] > counts[1] && count_of(&after, second) == counts[1]);
    assert!(bin_of(&after).len() < 14 * counts[0] + 12 * counts[1] + 37 + 2 * 3 * 30 + 8 * 8);
    // Only one of the parts loses vertices.
    let (redrawn, after) = shrunk(&glb, |part, t| part == 1 || t == 0);
    assert_eq!((count_of(&after, first), redrawn.model.parts[0].mesh.vertex_count()), (3, 3));
}

#[test]
fn points_and_lines_keep_the_vertices_that_they_draw() {
    let with = |mode: u32, vertices: Option<&[u32]>| {
        let mut draft = shared_scene(4);
        let mut primitive = json!({ "attributes": { "POSITION": 0 }, "mode": mode });
        if let Some(vertices) = vertices {
            let lines = draft.indices(U8, vertices);
            draft.json["accessors"][lines]["min"] = json!([0]);
            draft.json["accessors"][lines]["max"] =
                json!([vertices.iter().filter(|&&v| v != 255).max().unwrap()]);
            primitive["indices"] = lines.into();
        }
        push(&mut draft.json["meshes"][1]["primitives"], primitive);
        shrunk(&draft.glb(), |part, t| part != 1 && t == 0)
    };
    // Vertex 27 is the last one.
    let (redrawn, after) = with(1, Some(&[27, 3, 3, 9]));
    assert!(
        redrawn.kept_groups.is_empty() && (4..=6).contains(&count_of(&after, 0)),
        "{}",
        count_of(&after, 0)
    );
    assert_eq!(redrawn.used, 6);
    let json = json_of(&after);
    let lines = number(&json["meshes"][1]["primitives"][1]["indices"]);
    assert_eq!(json["accessors"][lines]["max"], json!([count_of(&after, 0) - 1]));
    validate("points_and_lines", &[("lines.glb".into(), after)]);
    // Restarts are unchanged.
    let (redrawn, _) = with(3, Some(&[27, 3, 255, 9, 2]));
    assert!(redrawn.kept_groups.is_empty() && redrawn.dropped > 20);
    // With this many vertices, the highest value of the type may be a vertex or a restart.
    let mut draft = shared_scene(16);
    let points = draft.indices(U8, &[255, 3]);
    push(
        &mut draft.json["meshes"][1]["primitives"],
        json!({ "attributes": { "POSITION": 0 }, "mode": 0, "indices": points }),
    );
    let (redrawn, _) = shrunk(&draft.glb(), |_, t| t == 0);
    assert!(redrawn.kept_groups.len() == 1 && redrawn.kept_groups[0].why.contains("a vertex or a restart"));
    // Points without indices draw every vertex, so none is unused.
    let (redrawn, after) = with(0, None);
    assert!(redrawn.kept_groups.is_empty());
    assert_eq!((count_of(&after, 0), redrawn.kept), (28, 0));
}

#[test]
fn vertices_stay_where_something_depends_on_their_numbers() {
    let kept = |draft: &Draft, group: usize, why: &str| {
        let (redrawn, after) = shrunk(&draft.glb(), |part, t| part != 1 && t == 0);
        let found: Vec<_> =
            redrawn.kept_groups.iter().map(|group| (group.parts.clone(), &group.why)).collect();
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].0 == [vec![0, 1], vec![2]][group] && found[0].1.contains(why), "{found:?}");
        assert_eq!(redrawn.kept, 28 - 3);
        assert_eq!([count_of(&after, 0), count_of(&after, 11)][group], 28);
        assert_eq!([count_of(&after, 11), count_of(&after, 0)][group], 3);
    };
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut draft = shared_scene(4);
        change(&mut draft.json);
        draft
    };
    assert_eq!(shared_scene(4).json["meshes"][2]["primitives"][0]["attributes"]["POSITION"], 11);
    // A number in an unknown extension may refer to an accessor or a view; also in extras.
    let named = "refer to their accessors or buffer views by index";
    let draft = changed(&|json| json["extensions"] = json!({ "EXT_unknown_thing": { "values": 11 } }));
    kept(&draft, 1, named);
    let draft =
        changed(&|json| json["nodes"][1]["extensions"] = json!({ "EXT_unknown_thing": { "view": 3 } }));
    kept(&draft, 0, named);
    let draft = changed(&|json| json["asset"]["extras"] = json!([4.5, 11]));
    kept(&draft, 1, named);
    let by_number = "may refer to vertices by index";
    kept(
        &changed(&|json| json["meshes"][2]["primitives"][0]["extras"] = json!({ "order": [300] })),
        1,
        by_number,
    );
    kept(
        &changed(&|json| {
            json["bufferViews"][0]["extensions"] = json!({ "EXT_unknown_thing": { "stripes": 400 } })
        }),
        0,
        by_number,
    );
    let mut draft = shared_scene(4);
    let view =
        push(&mut draft.json["bufferViews"], json!({ "buffer": 0, "byteOffset": 28, "byteLength": 4 }));
    draft.json["images"] = json!([{ "bufferView": view, "mimeType": "image/png" }]);
    kept(&draft, 0, "uses the same bytes");
    let mut draft = shared_scene(4);
    let lines = draft.indices(U8, &[0, 1]);
    for position in [0, 11] {
        push(
            &mut draft.json["meshes"][0]["primitives"],
            json!({ "attributes": { "POSITION": position }, "mode": 1, "indices": lines }),
        );
    }
    let (redrawn, _) = shrunk(&draft.glb(), |_, t| t == 0);
    assert!(redrawn.kept_groups.iter().all(|group| group.why.contains("use the same index accessor")));
    assert_eq!(redrawn.kept_groups.len(), 2);
    let draft = changed(&|json| json["extensions"] = json!({ "EXT_unknown_thing": { "buffer": 0 } }));
    let (redrawn, after) = shrunk(&draft.glb(), |_, t| t == 0);
    assert!(
        redrawn.kept_groups.iter().all(|group| group.why.contains("refers to bytes")) && redrawn.dropped == 0
    );
    assert_eq!(count_of(&after, 11), 28);
}

#[test]
fn known_extensions_do_not_keep_vertices() {
    let mut draft = shared_scene(4);
    let texture =
        json!({ "index": 0, "extensions": { "KHR_texture_transform": { "offset": [0, 1], "texCoord": 0 } } });
    draft.json["materials"] =
        json!([{ "extensions": { "KHR_materials_clearcoat": { "clearcoatTexture": texture } } }]);
    draft.json["textures"] = json!([{}]);
    let (redrawn, _) = shrunk(&draft.glb(), |_, t| t == 0);
    assert!(redrawn.kept_groups.is_empty() && redrawn.dropped > 40);
    // Numbers of an unknown extension inside a known one count.
    draft.json["materials"][0]["extensions"]["KHR_materials_clearcoat"]["extensions"] =
        json!({ "EXT_unknown_thing": [0] });
    assert_eq!(shrunk(&draft.glb(), |_, t| t == 0).0.kept_groups.len(), 1);
}

#[test]
fn parts_without_triangles_keep_one_vertex() {
    let (redrawn, after) = shrunk(&shared_scene(4).glb(), |part, t| part == 2 && t == 0);
    assert_eq!((redrawn.used, count_of(&after, 0), count_of(&after, 11)), (3, 1, 3));
    validate("parts_without_triangles", &[("empty.glb".into(), after)]);
    let (redrawn, after) = shrunk(&shared_scene(4).glb(), |_, _| false);
    assert_eq!((redrawn.dropped, redrawn.kept, count_of(&after, 0)), (0, 56, 28));
    assert!(redrawn.kept_groups.iter().all(|group| group.why == "nothing is drawn"));
}

#[test]
fn json_is_written_without_spaces_outside_of_text() {
    let draft = shared_scene(4);
    let mut json = draft.json.clone();
    json["buffers"][0]["byteLength"] = draft.bin.len().into();
    json["asset"]["copyright"] = " a \\ \" b ".into();
    let spaced = glb_of(&serde_json::to_vec_pretty(&json).unwrap(), Some(&draft.bin));
    let packed = glb_of(&serde_json::to_vec(&json).unwrap(), Some(&draft.bin));
    for left in [1, 1000] {
        let [spaced, packed] = [&spaced, &packed].map(|glb| shrunk(glb, |_, t| t < left).1);
        assert_eq!(json_of(&spaced)["asset"], json["asset"]);
        assert!(
            spaced == packed
                && packed.len() < glb_of(&serde_json::to_vec(&json).unwrap(), Some(&draft.bin)).len()
        );
    }
}

#[test]
fn integer_bounds_are_those_of_the_vertices_left() {
    let mut draft = Draft::new();
    let (positions, corners) = grid(3);
    let position = draft.positions(&positions);
    let rows: Vec<u8> = (0..positions.len()).flat_map(|i| [i as u8, 200 - i as u8, 0x80, 0]).collect();
    let ids = interleaved(&mut draft, 4, &rows, &[(0, U8, "VEC2"), (2, 5120, "SCALAR")]);
    draft.json["accessors"][ids[0]]["min"] = json!([0, 100]);
    draft.json["accessors"][ids[0]]["max"] = json!([100, 200]);
    draft.json["accessors"][ids[1]]["min"] = json!([-128]);
    let list = draft.indices(U16, &corners);
    draft.primitive(position, Some(list), 4);
    let attributes = &mut draft.json["meshes"][0]["primitives"][0]["attributes"];
    (attributes["_PAIR"], attributes["_ONE"]) = (ids[0].into(), ids[1].into());
    let after = shrunk(&draft.glb(), |_, t| t == 0).1;
    let mut used: Vec<u32> = corners[..3].to_vec();
    used.sort_unstable();
    let json = json_of(&after);
    assert_eq!(json["accessors"][ids[0]]["min"], json!([used[0], 200 - used[2]]));
    assert_eq!(json["accessors"][ids[0]]["max"], json!([used[2], 200 - used[0]]));
    assert_eq!(
        (&json["accessors"][ids[1]]["min"], &json["accessors"][ids[1]]["max"]),
        (&json!([-128]), &json!([-128]))
    );
}

/// Parts drawn as faces get new indices if their vertices are renumbered.
#[test]
fn faces_of_a_reordered_scene_are_written() {
    let model = gltf::read(shared_scene(4).glb(), None).unwrap();
    let reordered = reorder(&model, &[Drawing::Faces; 3], Format::Glb, Layout::List).unwrap();
    assert!(reordered.groups.iter().all(|group| group.kept.is_none() && group.order.moved_count() > 10));
    let bytes = write(&reordered.model, &reordered.drawings(), Format::Glb, reordered.layout).unwrap();
    let back = gltf::read(bytes, None).unwrap();
    for (part, back) in reordered.model.parts.iter().zip(&back.parts) {
        assert_eq!(part.mesh, back.mesh);
    }
}

/// Documents with a few changed bytes: if they can be read, vertices can be removed, and the
/// triangles are the same.
#[test]
fn mutations_never_panic() {
    let mut draft = shared_scene(3);
    let lines = draft.indices(U8, &[5, 3, 3, 9]);
    push(
        &mut draft.json["meshes"][1]["primitives"],
        json!({ "attributes": { "POSITION": 0 }, "mode": 1, "indices": lines }),
    );
    let glb = draft.glb();
    let (mut done, mut dropped) = (0, 0);
    for changed in mutated_documents(&glb, 4000) {
        let Ok(model) = gltf::read(changed, None) else { continue };
        let lists = model.parts.iter().map(|part| part.mesh.faces().as_triangles().unwrap());
        let lists: Vec<Vec<u32>> = lists.map(|all| all[..all.len() / 6 * 3].to_vec()).collect();
        let drawings = vec![Drawing::Faces; lists.len()];
        let redrawn = with_triangles(&model, lists, Format::Glb).unwrap();
        let bytes = write(&redrawn.model, &drawings, Format::Glb, Layout::List).unwrap();
        let back = gltf::read(bytes, None).unwrap();
        for (part, back) in redrawn.model.parts.iter().zip(&back.parts) {
            assert_eq!(part.mesh.positions(), back.mesh.positions());
            let bits = |mesh: &tristrip::Mesh| format!("{:?}", mesh.attributes());
            assert_eq!(bits(&part.mesh), bits(&back.mesh));
            assert!(part.mesh.faces().corner_count() == 0 || part.mesh.faces() == back.mesh.faces());
        }
        done += 1;
        dropped += usize::from(redrawn.dropped > 0);
    }
    assert!(done > 500 && dropped > 300, "{done}, {dropped}");
}

#[test]
fn real_scenes_shrink() {
    check_real_scenes("real_scenes_shrink", |name, glb| {
        let (redrawn, after) = shrunk(glb, |_, t| t % 10 == 0);
        assert!(redrawn.kept_groups.is_empty(), "{name}: {:?}", redrawn.kept_groups);
        assert!(2 * redrawn.dropped > redrawn.used, "{name}: {} of {}", redrawn.dropped, redrawn.used);
        vec![(format!("{name}_shrunk.glb"), after)]
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(ProptestConfig::default().cases / 3))]
    /// Primitives with vertex arrays that are shared, interleaved in one view, consecutive in one
    /// view, or in separate views. Some primitives are lines.
    #[test]
    fn every_scene_shrinks_or_stays(
        primitives in prop::collection::vec((0..3_usize, any::<bool>(), prop::collection::vec(0..40_u32, 6..30)), 1..5),
        storage in 0..3,
        modulus in 1..4_usize,
    ) {
        let mut draft = Draft::new();
        let at = |list: usize| (0..40_u8).map(move |i| [f32::from(i), list as f32, f32::from(i % 7)]);
        let accessors: Vec<usize> = match storage {
            0 => (0..3).map(|list| draft.positions(&at(list).collect::<Vec<_>>())).collect(),
            1 => {
                let rows: Vec<f32> = (0..40).flat_map(|i| (0..3).flat_map(move |list| at(list).nth(i).unwrap())).collect();
                interleaved(&mut draft, 36, &floats(&rows), &[0, 12, 24].map(|offset| (offset, F32, "VEC3")))
            }
            _ => {
                let all: Vec<f32> = (0..3).flat_map(|list| at(list).flatten()).collect();
                let view = draft.view(&floats(&all));
                let add = |list: usize| {
                    let accessor = draft.accessor(view, F32, 40, "VEC3");
                    draft.json["accessors"][accessor]["byteOffset"] = (480 * list).into();
                    accessor
                };
                (0..3).map(add).collect()
            }
        };
        for (list, is_lines, corners) in &primitives {
            let indices = draft.indices(U8, &corners[..corners.len() / 6 * 6]);
            draft.primitive(accessors[*list], Some(indices), if *is_lines { 1 } else { 4 });
        }
        let (redrawn, after) = shrunk(&draft.glb(), |part, t| (part + t) % modulus == 0);
        prop_assert!(redrawn.kept_groups.iter().all(|group| group.why == "nothing is drawn"));
        let drawn: BTreeSet<usize> = primitives.iter().filter(|p| !p.1).map(|p| p.0).collect();
        for (number, accessor) in accessors.iter().enumerate().filter(|(list, _)| drawn.contains(list)) {
            // Exactly the used vertices remain.
            let json = json_of(&after);
            let users = json["meshes"][0]["primitives"].as_array().unwrap();
            let users = users.iter().filter(|p| p["attributes"]["POSITION"] == *accessor);
            let used: BTreeSet<usize> = users.flat_map(|p| indices(&after, &p["indices"])).collect();
            if redrawn.kept_groups.is_empty() {
                prop_assert_eq!(count_of(&after, *accessor), used.len(), "array {}", number);
            }
        }
    }
}
