//! Limits of decoding: values without stored bytes are limited, shared arrays are decoded once, and
//! models that were read can be written and read again.

use serde_json::json;
use tristrip::{Layout, Strips};
use tristrip_io::{Drawing, Error, Format, Model, gltf, write};

use crate::gltf_documents::*;

/// Returns a document of one primitive whose positions are all zero.
fn zeros(count: usize, sparse: bool) -> Draft {
    let mut draft = Draft::new();
    draft.json["accessors"] = json!([{ "componentType": F32, "count": count, "type": "VEC3" }]);
    if sparse {
        let (at, to) = (draft.view(&[1, 0, 0, 0]), draft.view(&floats(&[9.0, 8.0, 7.0])));
        draft.json["accessors"][0]["sparse"] = json!({
            "count": 1, "indices": { "bufferView": at, "componentType": U32 }, "values": { "bufferView": to },
        });
    } else {
        draft.json.as_object_mut().unwrap().remove("buffers");
    }
    draft.primitive(0, None, 4);
    draft
}

#[test]
fn zeros_that_no_byte_pays_for_are_limited() {
    for sparse in [false, true] {
        assert!(gltf::read(zeros(60_000, sparse).glb(), None).is_ok());
        let error = gltf::read(zeros(4_000_000, sparse).glb(), None).unwrap_err();
        let Error::LimitExceeded { at, found, limit } = error else { unreachable!("{error}") };
        assert_eq!(at, "accessors[0], bytes decoded so far");
        assert!(found == 48_000_000 && limit < (1 << 20) + 1000, "{found}, {limit}");
    }
}

/// Returns a ribbon of `triangles`, drawn by several meshes with common vertex and index arrays.
fn meshes_over_one_ribbon(mesh_count: usize, triangles: u32) -> Draft {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(triangles as usize + 2));
    let corners = (0..triangles).flat_map(|t| if t % 2 == 0 { [t, t + 1, t + 2] } else { [t + 1, t, t + 2] });
    let indices = draft.indices(U16, &corners.collect::<Vec<_>>());
    let primitive = json!({ "attributes": { "POSITION": positions }, "indices": indices });
    draft.json["meshes"] = vec![json!({ "primitives": [primitive] }); mesh_count].into();
    draft
}

/// Returns isolated triangles: the strips with the most indices per triangle.
fn isolated(model: &Model) -> Strips {
    let mut strips = Strips::default();
    triangles(model, 0).iter().for_each(|triangle| strips.push(triangle));
    strips
}

#[test]
fn thousands_of_meshes_over_one_array_are_written_and_read_again() {
    let model = gltf::read(meshes_over_one_ribbon(5000, 1000).glb(), None).unwrap();
    let first = &model.parts[0].mesh;
    assert!(model.parts.len() == 5000 && model.parts.iter().all(|part| part.mesh.shares_vertices(first)));
    let (long, short) = (greedy(&triangles(&model, 0)), isolated(&model));
    for (strips, layout) in [(&long, Layout::Degenerate), (&short, Layout::Restart)] {
        let glb = write(&model, &vec![Drawing::Strips(strips); 5000], Format::Glb, layout).unwrap();
        let again = gltf::read(glb, None).unwrap();
        assert_eq!(again.parts.len(), 5000);
        for part in [0, 4999] {
            assert_eq!(triangles(&again, part).len(), 1000);
            assert_eq!(again.parts[part].stored, again.parts[0].stored);
        }
    }
}

#[test]
fn triangles_drawn_again_and_again_are_limited() {
    let error = gltf::read(meshes_over_one_ribbon(9, 60_000).glb(), None).map(|_| ());
    assert!(error.is_ok(), "{error:?}");
    let error = gltf::read(meshes_over_one_ribbon(2000, 60_000).glb(), None).unwrap_err();
    let Error::LimitExceeded { at, found, limit } = error else { unreachable!("{error}") };
    assert_eq!(at, "meshes[20].primitives[0], triangles drawn so far, including repeated indices");
    assert_eq!((found, limit), (21 * 60_000, (1 << 18) + 21 * 1024 + 16 * 60_000));
}

#[test]
fn an_index_is_checked_for_each_array_of_vertices() {
    let mut draft = meshes_over_one_ribbon(2, 8);
    let fewer = draft.positions(&bent(9));
    draft.json["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = fewer.into();
    for mode in [4, 5] {
        for mesh in 0..2 {
            draft.json["meshes"][mesh]["primitives"][0]["mode"] = mode.into();
        }
        let error = gltf::read(draft.glb(), None).unwrap_err().to_string();
        assert!(error.ends_with("found index 9, expected less than 9, the number of vertices"), "{error}");
    }
}
