//! Reading glTF: small documents for each way to store triangles.

use serde_json::json;
use tristrip::AttributeData;
use tristrip_io::{Error, Format, gltf, write};

use crate::gltf_documents::*;

const FAN: u32 = 6;
const STRIP: u32 = 5;
const LIST: u32 = 4;

fn one(component: u32, indices: &[u32], mode: u32) -> Draft {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(300));
    let indices = draft.indices(component, indices);
    draft.primitive(positions, Some(indices), mode);
    draft
}

#[test]
fn reads_every_mode_in_every_width() {
    let strip = [[0, 1, 2], [1, 3, 2], [2, 3, 4]];
    for (component, restart) in [(U8, 0xFF), (U16, 0xFFFF), (U32, u32::MAX)] {
        for (mode, indices, expected) in [
            (LIST, vec![0, 1, 2, 2, 1, 3], vec![[0, 1, 2], [1, 3, 2]]),
            (STRIP, vec![0, 1, 2, 3, 4], strip.to_vec()),
            (FAN, vec![7, 1, 2, 3], vec![[1, 2, 7], [2, 3, 7]]),
            // Odd lengths before a restart: the restart resets the parity.
            (STRIP, vec![5, 6, 7, restart, 0, 1, 2, 3, 4], [&[[5, 6, 7]][..], &strip].concat()),
            (STRIP, vec![restart, restart, 0, 1, restart, 0, 1, 2, restart], vec![[0, 1, 2]]),
            (FAN, vec![7, 1, 2, restart, 9, 3, 4, 5], vec![[1, 2, 7], [3, 4, 9], [4, 5, 9]]),
            // Degenerate triangles are dropped and keep the parity.
            (STRIP, vec![0, 1, 2, 2, 2, 3, 3, 4, 5], vec![[0, 1, 2], [3, 4, 5]]),
            (STRIP, vec![0, 1, 2, 2, 3, 3, 4, 5], vec![[0, 1, 2], [3, 5, 4]]),
        ] {
            let mut draft = one(component, &indices, mode);
            draft.json["extensionsUsed"] = json!(["KHR_mesh_primitive_restart"]);
            for bytes in [draft.glb(), draft.gltf()] {
                let model = gltf::read(bytes, None).unwrap();
                assert_eq!(triangles(&model, 0), expected, "{component} {mode} {indices:?}");
                let runs: Vec<&[u32]> =
                    indices.split(|&i| i == restart).filter(|run| !run.is_empty()).collect();
                let stored = model.parts[0].stored.as_ref();
                assert_eq!(stored.is_some(), mode != LIST);
                if let Some(stored) = stored {
                    assert_eq!(stored.runs.iter().collect::<Vec<_>>(), runs);
                    assert_eq!((stored.indices(), stored.fans), (indices.len(), mode == FAN));
                }
            }
        }
    }
}

#[test]
fn the_highest_index_of_a_list_is_an_index() {
    let model = gltf::read(one(U8, &[0, 1, 255], LIST).glb(), None).unwrap();
    assert_eq!(triangles(&model, 0), [[0, 1, 255]]);
}

#[test]
fn notes_what_it_drops() {
    let mut draft = one(U8, &[0, 1, 2, 255, 3, 3, 4], STRIP);
    draft.primitive(0, None, 0);
    draft.primitive(0, Some(1), LIST);
    draft.json["images"] = json!([{ "uri": "a.png" }]);
    let mut bytes = draft.glb();
    bytes.extend_from_slice(&[0; 5]);
    // The triangle list shares the seven indices of the strip, and 255 is a vertex in it.
    let model = gltf::read(bytes, None).unwrap();
    assert_eq!(
        model.notes,
        [
            "dropped bytes after the end of the GLB: 5",
            "primitives of points or lines, kept only in a GLB: 1",
            "dropped degenerate triangles of strips and fans: 1",
            "dropped indices at the end of triangle lists that form no triangle: 1",
            "restart indices accepted although the file does not use KHR_mesh_primitive_restart: 1",
            "images in separate files: 1",
        ]
    );
    assert_eq!(model.parts.len(), 2);
}

#[test]
fn reads_without_indices_and_shares_positions() {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(6));
    let indices = draft.indices(U8, &[3, 4, 5]);
    for (indices, mode) in [(None, LIST), (None, STRIP), (None, FAN), (Some(indices), LIST)] {
        draft.primitive(positions, indices, mode);
    }
    draft.json["meshes"][0]["name"] = "six".into();
    draft.json["materials"] = json!([{ "name": "red" }]);
    draft.json["meshes"][0]["primitives"][3]["material"] = 0.into();
    let model = gltf::read(draft.glb(), None).unwrap();
    assert_eq!(triangles(&model, 0), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(triangles(&model, 1), [[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]]);
    assert_eq!(triangles(&model, 2), [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    assert_eq!(triangles(&model, 3), [[3, 4, 5]]);
    let first = model.parts[0].mesh.shared_positions();
    assert!(model.parts.iter().all(|p| std::sync::Arc::ptr_eq(&first, &p.mesh.shared_positions())));
    assert_eq!(model.parts[3].name.as_deref(), Some("six"));
    assert_eq!(model.parts.iter().filter_map(|p| p.material.as_deref()).collect::<Vec<_>>(), ["red"]);
}

#[test]
fn reads_interleaved_vertices() {
    let mut draft = Draft::new();
    // 12 bytes of position, 4 of colour, 2 of texture coordinates and 2 of padding.
    let mut bytes = Vec::new();
    for (i, p) in bent(4).into_iter().enumerate() {
        bytes.extend(floats(&p));
        bytes.extend([i as u8; 4]);
        bytes.extend([10 * i as u8, 255, 99, 99]);
    }
    bytes.truncate(bytes.len() - 2); // the last value needs no padding after it
    let view = draft.view(&bytes);
    draft.json["bufferViews"][view]["byteStride"] = 20.into();
    let positions = draft.accessor(view, F32, 4, "VEC3");
    let colors = draft.accessor(view, U8, 4, "VEC4");
    let texcoords = draft.accessor(view, U8, 4, "VEC2");
    draft.json["accessors"][colors]["byteOffset"] = 12.into();
    draft.json["accessors"][colors]["normalized"] = true.into();
    draft.json["accessors"][texcoords]["byteOffset"] = 16.into();
    draft.primitive(positions, None, STRIP);
    draft.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = colors.into();
    draft.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = texcoords.into();
    let model = gltf::read(draft.glb(), None).unwrap();
    let mesh = &model.parts[0].mesh;
    assert_eq!(mesh.positions(), bent(4));
    let [color, texcoord] = mesh.attributes() else { panic!("{:?}", mesh.attributes()) };
    assert_eq!((color.name.as_str(), color.components, color.normalized), ("COLOR_0", 4, true));
    assert_eq!(color.data, AttributeData::U8(vec![0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3]));
    assert_eq!((texcoord.name.as_str(), texcoord.components, texcoord.normalized), ("TEXCOORD_0", 2, false));
    assert_eq!(texcoord.data, AttributeData::U8(vec![0, 255, 10, 255, 20, 255, 30, 255]));
}

#[test]
fn reads_sparse_positions_and_indices() {
    let mut draft = one(U16, &[0, 1, 2, 2, 1, 3], LIST);
    let (at, to) = (draft.view(&[1, 0, 44, 1, 0, 0]), draft.view(&floats(&[9.0, 8.0, 7.0, 6.0, 5.0, 4.0])));
    draft.json["accessors"][0]["count"] = 301.into();
    draft.json["accessors"][0].as_object_mut().unwrap().shift_remove("bufferView");
    draft.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": at, "componentType": U16 },
        "values": { "bufferView": to },
    });
    let (at, to) = (draft.view(&[0, 4]), draft.view(&packed(U16, &[99, 5, 300])));
    draft.json["accessors"][1]["sparse"] = json!({
        "count": 2,
        "indices": { "bufferView": at, "componentType": U8 },
        "values": { "bufferView": to, "byteOffset": 2 },
    });
    let model = gltf::read(draft.glb(), None).unwrap();
    assert_eq!(model.parts[0].mesh.faces().corners(), [5, 1, 2, 2, 300, 3]);
    let positions = model.parts[0].mesh.positions();
    assert_eq!([positions[0], positions[1], positions[300]], [[0.0; 3], [9.0, 8.0, 7.0], [6.0, 5.0, 4.0]]);
}

#[test]
fn reads_quantized_positions() {
    let values: [i8; 12] = [-128, -127, 0, 0, 127, 0, 0, 0, 64, 0, 0, 0];
    for (component, normalized, expected) in [
        (5120, true, [-1.0, -1.0, 0.0]),
        (5120, false, [-128.0, -127.0, 0.0]),
        (U8, true, [128.0 / 255.0, 129.0 / 255.0, 0.0]),
        (U8, false, [128.0, 129.0, 0.0]),
    ] {
        let mut draft = Draft::new();
        let view = draft.view(&values.map(i8::cast_unsigned));
        draft.json["bufferViews"][view]["byteStride"] = 4.into();
        let positions = draft.accessor(view, component, 3, "VEC3");
        draft.json["accessors"][positions]["normalized"] = normalized.into();
        draft.primitive(positions, None, LIST);
        draft.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        let model = gltf::read(draft.glb(), None).unwrap();
        assert_eq!(model.parts[0].mesh.positions()[0].map(f32::to_bits), expected.map(f32::to_bits));
    }
    for (component, expected) in
        [(5122, [-1.0, 1.0, 0.0]), (U16, [32768.0 / 65535.0, 32767.0 / 65535.0, 0.0])]
    {
        let mut draft = Draft::new();
        let view = draft.view(&[0, 128, 255, 127, 0, 0, 0, 0].repeat(3));
        draft.json["bufferViews"][view]["byteStride"] = 8.into();
        let positions = draft.accessor(view, component, 3, "VEC3");
        draft.json["accessors"][positions]["normalized"] = true.into();
        draft.primitive(positions, None, LIST);
        draft.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let model = gltf::read(draft.glb(), None).unwrap();
        assert_eq!(model.parts[0].mesh.positions()[0].map(f32::to_bits), expected.map(f32::to_bits));
    }
}

#[test]
fn reads_only_files_in_its_own_folder() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("gltf_read_files");
    std::fs::create_dir_all(folder.join("in/sub")).unwrap();
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(3));
    draft.primitive(positions, None, LIST);
    std::fs::write(folder.join("in/sub/a b.bin"), &draft.bin).unwrap();
    std::fs::write(folder.join("secret.bin"), &draft.bin).unwrap();
    let _ = std::fs::remove_file(folder.join("in/link.bin"));
    #[cfg(unix)]
    std::os::unix::fs::symlink(folder.join("secret.bin"), folder.join("in/link.bin")).unwrap();
    let read = |uri: &str, folder: Option<&std::path::Path>| {
        let mut json = draft.json.clone();
        json["buffers"][0] = json!({ "byteLength": draft.bin.len(), "uri": uri });
        gltf::read(serde_json::to_vec(&json).unwrap(), folder).map(|model| triangles(&model, 0))
    };
    let inside = folder.join("in");
    assert_eq!(read("sub/a%20b.bin", Some(&inside)).unwrap(), [[0, 1, 2]]);
    let message = |uri: &str, folder| read(uri, folder).unwrap_err().to_string();
    let expected = "expected a data URI, or a file in the directory of the document";
    assert_eq!(
        message("../secret.bin", Some(&inside)),
        format!("buffers[0].uri: found \"../secret.bin\", {expected}")
    );
    #[cfg(unix)]
    assert_eq!(message("link.bin", Some(&inside)), format!("buffers[0].uri: found \"link.bin\", {expected}"));
    assert_eq!(message("sub", Some(&inside)), format!("buffers[0].uri: found \"sub\", {expected}"));
    assert!(
        message("sub/a b.bin", None)
            .ends_with("expected a data URI, because the directory of the document is unknown")
    );
    assert!(matches!(read("none.bin", Some(&inside)), Err(Error::Io { .. })));
    // A document without a directory in its name is in the current one, like this package's
    // manifest.
    let here = read("Cargo.toml", Some(std::path::Path::new("")));
    assert!(!matches!(here, Err(Error::Io { .. })), "{here:?}");
}

#[test]
fn names_the_extension_whose_absence_makes_a_file_unreadable() {
    let mut draft = one(U8, &[0, 1, 2], LIST);
    draft.json["extensionsRequired"] =
        json!(["KHR_materials_unlit", "VENDOR_geometry", "KHR_mesh_quantization"]);
    assert!(gltf::read(draft.glb(), None).is_ok());
    draft.json["meshes"][0]["primitives"][0]["attributes"] = json!({});
    let error = gltf::read(draft.glb(), None).unwrap_err();
    let place = "meshes[0].primitives[0].attributes.POSITION: found nothing, expected a value";
    let expected = format!("{place}; the file requires VENDOR_geometry, which is not supported");
    assert_eq!(error.to_string(), expected);
}

#[test]
fn json_padded_with_zeros_or_with_a_byte_order_mark_is_read() {
    let draft = one(U8, &[0, 1, 2], LIST);
    let glb = draft.glb();
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let json = glb[20..20 + length].trim_ascii_end();
    for (before, after) in [("\u{feff}", ""), ("", "\0\0\0"), ("\u{feff} ", " \0\n \0")] {
        let text = [before.as_bytes(), json, after.as_bytes()].concat();
        let model = gltf::read(glb_of(&text, Some(&draft.bin)), None).unwrap();
        assert_eq!(triangles(&model, 0), [[0, 1, 2]]);
        let gltf = [before.as_bytes(), &draft.gltf(), after.as_bytes()].concat();
        assert_eq!(triangles(&gltf::read(gltf, None).unwrap(), 0), [[0, 1, 2]]);
    }
    let error = gltf::read(glb_of(b"\0{}", None), None).unwrap_err().to_string();
    assert_eq!(error, "JSON line 1, column 1: found expected value, expected JSON");
}

#[cfg(unix)]
#[test]
fn a_document_behind_a_link_finds_its_buffers() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["real/sub", "links/sub", "outside"] {
        std::fs::create_dir_all(at(name)).unwrap();
    }
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(3));
    draft.primitive(positions, None, LIST);
    draft.json["buffers"][0] = json!({ "byteLength": draft.bin.len(), "uri": "sub/a.bin" });
    std::fs::write(at("real/scene.gltf"), serde_json::to_vec(&draft.json).unwrap()).unwrap();
    std::fs::write(at("real/sub/a.bin"), &draft.bin).unwrap();
    symlink(at("real/scene.gltf"), at("links/scene.gltf")).unwrap();
    let first = || {
        tristrip_io::read_path(at("links/scene.gltf")).map(|m| m.parts[0].mesh.positions()[0][0].to_bits())
    };
    // 1. Next to the target of the link.
    assert_eq!(first().unwrap(), 0);
    // 2. Files next to the link have priority. A buffer may also be a link into either directory.
    symlink(at("real/sub/a.bin"), at("links/sub/a.bin")).unwrap();
    assert_eq!(first().unwrap(), 0);
    std::fs::remove_file(at("links/sub/a.bin")).unwrap();
    std::fs::write(at("links/sub/a.bin"), floats(&[7.0; 9])).unwrap();
    assert_eq!(first().unwrap(), 7.0_f32.to_bits());
    // 3. Never outside both directories.
    std::fs::remove_file(at("links/sub/a.bin")).unwrap();
    std::fs::write(at("outside/a.bin"), &draft.bin).unwrap();
    symlink(at("outside/a.bin"), at("links/sub/a.bin")).unwrap();
    let error = first().unwrap_err().to_string();
    assert!(error.ends_with("expected a data URI, or a file in the directory of the document"), "{error}");
    // 4. The error names a missing file next to the link.
    std::fs::remove_file(at("links/sub/a.bin")).unwrap();
    std::fs::remove_file(at("real/sub/a.bin")).unwrap();
    let error = first().unwrap_err().to_string();
    assert!(error.contains("links/sub/a.bin: "), "{error}");
}

#[test]
fn many_primitives_over_one_accessor_stay_small() {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(1000));
    let indices = draft.indices(U16, &[0, 1, 2]);
    let normals = draft.accessor(0, F32, 1000, "VEC3");
    for _ in 0..10_000 {
        let primitive = draft.primitive(positions, Some(indices), LIST);
        draft.json["meshes"][0]["primitives"][primitive]["attributes"]["_N"] = normals.into();
    }
    // Primitives with the same set of attributes share them.
    let model = gltf::read(draft.glb(), None).unwrap();
    let first = &model.parts[0].mesh;
    assert!(first.attributes().len() == 1 && model.parts.iter().all(|p| p.mesh.shares_vertices(first)));
    // Otherwise, 10 000 × 12 000 bytes of attributes exceed the limit, and most are skipped.
    for (i, primitive) in draft.json["meshes"][0]["primitives"].as_array_mut().unwrap().iter_mut().enumerate()
    {
        primitive["attributes"].as_object_mut().unwrap().shift_remove("_N");
        primitive["attributes"][format!("_N{i}")] = normals.into();
    }
    let model = gltf::read(draft.glb(), None).unwrap();
    let decoded = model.parts.iter().filter(|p| !p.mesh.attributes().is_empty()).count();
    assert!((100..9_000).contains(&decoded), "{decoded}");
    assert!(
        model.notes.iter().any(|note| note.contains("vertex attributes not decoded")),
        "{:?}",
        model.notes
    );
    // Without indices, 10 000 × 4 000 bytes of generated indices fit, but the triangles of strips
    // do not.
    for primitive in draft.json["meshes"][0]["primitives"].as_array_mut().unwrap() {
        primitive.as_object_mut().unwrap().shift_remove("indices");
        primitive["mode"] = STRIP.into();
    }
    let error = gltf::read(draft.glb(), None).unwrap_err();
    assert!(matches!(error, Error::LimitExceeded { .. }), "{error}");
}

#[test]
fn no_truncation_or_mutation_panics() {
    let mut draft = one(U8, &[0, 1, 2, 255, 3, 4, 5], STRIP);
    let (at, to) = (draft.view(&[1]), draft.view(&floats(&[9.0, 8.0, 7.0])));
    draft.json["accessors"][0]["count"] = 8.into();
    draft.json["bufferViews"][0]["byteLength"] = 96.into();
    draft.json["accessors"][0]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": at, "componentType": U8 }, "values": { "bufferView": to },
    });
    draft.json["nodes"] = json!([{ "mesh": 0, "children": [1] }, {}]);
    let good = draft.glb();
    for bytes in [good, draft.gltf()] {
        assert!(gltf::read(bytes.clone(), None).is_ok());
        for end in 0..bytes.len() {
            if let Ok(model) = gltf::read(&bytes[..end], None) {
                assert!(!model.notes.is_empty() || end + 3 >= bytes.len(), "{end}");
            }
        }
        let json_end = bytes.iter().rposition(|&b| b == b'}').unwrap();
        for at in 0..bytes.len() {
            // Every byte of the JSON, and a sample of the others.
            if at > json_end + 40 && at % 16 != 0 {
                continue;
            }
            for new in [0, b'0', b'9', b'-', b'}', b'"', b',', 0x7F, 0xFF, bytes[at] ^ 1, bytes[at] ^ 0x80] {
                let mut mutated = bytes.clone();
                mutated[at] = new;
                if let Ok(model) = gltf::read(mutated, None) {
                    let drawings = vec![tristrip_io::Drawing::Faces; model.parts.len()];
                    let _ = write(&model, &drawings, Format::Glb, tristrip::Layout::Degenerate);
                }
            }
        }
    }
}
