//! Compressed buffer views, with meshoptimizer's own encoders and decoders as the oracle, and files
//! of gltfpack.

use meshopt::EncodeExpMode;
use serde_json::{Value, json};
use tristrip::{Layout, Strips};
use tristrip_io::{Drawing, Format, Model, gltf, write};

use crate::compressed::{Compression, EXT, KHR, compress, draft_of, model_path, ribbon, same_parts, written};
use crate::gltf_documents::*;
use crate::random::random;

#[test]
fn a_compressed_scene_is_the_same_vertex_by_vertex() {
    let glb = std::fs::read(model_path("milktruck.glb")).unwrap();
    let plain = gltf::read(glb.clone(), None).unwrap();
    let draft = draft_of(&glb);
    for (name, version, indices) in [(EXT, 0, "TRIANGLES"), (KHR, 1, "INDICES"), (EXT, 1, "TRIANGLES")] {
        let of_view = |view: usize| match [2, 12].contains(&view) {
            _ if [3, 6, 9, 13].contains(&view) => Compression { mode: indices, ..Compression::TRIANGLES },
            true => Compression::attributes(8, version),
            false => Compression::attributes(12, version),
        };
        let views: Vec<_> = (0..14).map(|view| (view, of_view(view))).collect();
        let compressed = compress(&draft, name, &views).glb();
        assert!(compressed.len() < glb.len() * 9 / 10);
        let model = gltf::read(compressed, None).unwrap();
        same_parts(&model, &plain);
        if indices == "INDICES" {
            assert!(model.parts.iter().zip(&plain.parts).all(|(one, other)| one.mesh == other.mesh));
        }
        assert_eq!(model.notes, ["compressed buffer views, uncompressed when written as GLB: 14"]);
    }
}

#[test]
fn every_stride_and_every_number_of_elements() {
    let mut random = random();
    for stride in [4, 8, 12, 16, 32, 36, 252] {
        for count in [1, 16, 17, 64, 65, 256, 257, 700] {
            for version in [0, 1] {
                // From constant, which takes the fewest bytes, to random.
                for spread in [1, 2, 9, 256] {
                    let mut draft = ribbon(3);
                    let bytes: Vec<u8> = (0..stride * count).map(|_| random(spread) as u8).collect();
                    let view = draft.view(&bytes);
                    let compressed =
                        compress(&draft, KHR, &[(view, Compression::attributes(stride, version))]);
                    let glb = written(&gltf::read(compressed.glb(), None).unwrap());
                    let json = json_of(&glb);
                    let what = format!("{count} of {stride} bytes, version {version}, spread {spread}");
                    assert_eq!(view_bytes(&json, bin_of(&glb), view), bytes, "{what}");
                }
            }
        }
    }
}

#[test]
fn index_streams_of_both_widths() {
    let mut random = random();
    for count in [3, 300, 3000] {
        for (component, stride) in [(U16, 2), (U32, 4)] {
            for (mode, spread) in
                [("TRIANGLES", 40), ("INDICES", 40), ("INDICES", 60_000), ("TRIANGLES", 60_000)]
            {
                let mut draft = ribbon(60_000);
                let corners: Vec<u32> = (0..count).map(|_| random(spread) as u32).collect();
                let accessor = draft.indices(component, &corners);
                draft.json["meshes"][0]["primitives"][0]["indices"] = accessor.into();
                let view = draft.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
                let how = Compression { mode, stride, ..Compression::TRIANGLES };
                let found = gltf::read(compress(&draft, EXT, &[(view, how)]).glb(), None).unwrap();
                let expected = gltf::read(draft.glb(), None).unwrap();
                same_parts(&found, &expected);
            }
        }
    }
}

/// Returns a view with a filter, read and written again.
fn filtered(encoded: &[u8], filter: &str, stride: usize, version: i32) -> Vec<u8> {
    let mut draft = ribbon(3);
    let view = draft.view(encoded);
    let how = Compression { filter: Some(filter), ..Compression::attributes(stride, version) };
    let glb = written(&gltf::read(compress(&draft, KHR, &[(view, how)]).glb(), None).unwrap());
    view_bytes(&json_of(&glb), bin_of(&glb), view).to_vec()
}

fn bytes_of<const N: usize, T: Copy, const B: usize>(values: &[[T; N]], le: fn(T) -> [u8; B]) -> Vec<u8> {
    values.iter().flatten().flat_map(|&x| le(x)).collect()
}

/// Checks that integers differ by at most one, as the extension allows for all filters except the
/// exponential one: meshoptimizer's decoders use the processor's approximate square roots.
fn within_one(found: &[u8], expected: &[i64], number: impl Fn(&[u8]) -> i64) {
    let width = found.len() / expected.len();
    for (i, (found, &expected)) in found.chunks(width).zip(expected).enumerate() {
        let difference = (number(found) - expected).abs();
        assert!(difference <= 1, "number {i}: {} and {expected}", number(found));
    }
}

fn i8_of(raw: &[u8]) -> i64 {
    i64::from(raw[0].cast_signed())
}

fn i16_of(raw: &[u8]) -> i64 {
    i64::from(i16::from_le_bytes([raw[0], raw[1]]))
}

#[test]
fn filters_are_undone_like_by_meshoptimizer() {
    let mut random = random();
    let mut unit = |count: usize| -> Vec<[f32; 4]> {
        let one = |_| {
            let v: [f32; 4] = std::array::from_fn(|_| random(2001) as f32 / 1000.0 - 1.0);
            let length = v.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-3);
            v.map(|x| x / length)
        };
        (0..count).map(one).collect()
    };
    for count in [1, 3, 16, 299] {
        let vectors: Vec<[f32; 4]> = unit(count)
            .into_iter()
            .map(|[x, y, z, w]| {
                let length = (x * x + y * y + z * z).sqrt().max(1e-3);
                [x / length, y / length, z / length, w.signum()]
            })
            .collect();
        for (bits, version) in [(4, 0), (8, 0), (8, 1)] {
            let mut oct = meshopt::encode_filter_oct::<i8>(&vectors, bits);
            let found = filtered(&bytes_of(&oct, i8::to_le_bytes), "OCTAHEDRAL", 4, version);
            meshopt::decode_filter_oct(&mut oct);
            let expected: Vec<i64> = oct.iter().flatten().map(|&x| x.into()).collect();
            within_one(&found, &expected, i8_of);
        }
        for (bits, version) in [(9, 0), (12, 1), (16, 0)] {
            let mut oct = meshopt::encode_filter_oct::<i16>(&vectors, bits);
            let found = filtered(&bytes_of(&oct, i16::to_le_bytes), "OCTAHEDRAL", 8, version);
            meshopt::decode_filter_oct(&mut oct);
            let expected: Vec<i64> = oct.iter().flatten().map(|&x| x.into()).collect();
            within_one(&found, &expected, i16_of);

            let mut quat = meshopt::encode_filter_quat(&unit(count), bits);
            let found = filtered(&bytes_of(&quat, i16::to_le_bytes), "QUATERNION", 8, version);
            meshopt::decode_filter_quat(&mut quat);
            let expected: Vec<i64> = quat.iter().flatten().map(|&x| x.into()).collect();
            within_one(&found, &expected, i16_of);
        }
        let colours: Vec<[f32; 4]> = unit(count).into_iter().map(|c| c.map(f32::abs)).collect();
        let mut colour = meshopt::encode_filter_color::<u8>(&colours, 8);
        let found = filtered(&bytes_of(&colour, u8::to_le_bytes), "COLOR", 4, 1);
        meshopt::decode_filter_color(&mut colour);
        let expected: Vec<i64> = colour.iter().flatten().map(|&x| x.into()).collect();
        within_one(&found, &expected, |raw| raw[0].into());

        let floats: Vec<[f32; 3]> = unit(count).iter().map(|v| [v[0] * 1e4, v[1], v[2] * 1e-4]).collect();
        for mode in [EncodeExpMode::Separate, EncodeExpMode::SharedVector, EncodeExpMode::SharedComponent] {
            let mut exp = meshopt::encode_filter_exp(&floats, 15, mode);
            let found = filtered(&bytes_of(&exp, u32::to_le_bytes), "EXPONENTIAL", 12, 0);
            meshopt::decode_filter_exp(&mut exp);
            assert_eq!(found, bytes_of(&exp, u32::to_le_bytes));
        }
    }
}

#[test]
fn a_file_of_gltfpack_is_its_own_fallback() {
    let bytes = std::fs::read(model_path("milktruck_meshopt.glb")).unwrap();
    let model = gltf::read(bytes.clone(), None).unwrap();
    // The same document without compression: the fallback has the bytes decoded by gltfpack.
    let mut plain = draft_of(&bytes);
    plain.bin = std::fs::read(model_path("milktruck_meshopt.fallback.bin")).unwrap();
    plain.json["buffers"] = json!([{}]);
    plain.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    for view in plain.json["bufferViews"].as_array_mut().unwrap() {
        view["buffer"] = 0.into();
        view.as_object_mut().unwrap().remove("extensions").unwrap();
    }
    let plain = gltf::read(plain.glb(), None).unwrap();
    assert!(model.parts.len() >= 2);
    same_parts(&model, &plain);
    // Quantized: integers, in the coordinates of a node that scales them.
    let quantized = model.parts[0].mesh.positions().as_flattened();
    assert!(quantized.iter().all(|x| x.fract() == 0.0) && quantized.iter().any(|&x| x > 1000.0));
}

#[test]
fn a_file_of_gltfpack_with_all_filters_is_decoded_like_by_meshoptimizer() {
    let bytes = std::fs::read(model_path("milktruck_meshopt_khr.glb")).unwrap();
    let model = gltf::read(bytes.clone(), None).unwrap();
    let glb = written(&model);
    validate("meshopt", &[("khr.glb".to_owned(), glb.clone())]);
    let (json, draft) = (json_of(&glb), draft_of(&bytes));
    // The bounds match the decompressed values; those of the file do not.
    let primitives =
        json["meshes"].as_array().unwrap().iter().flat_map(|m| m["primitives"].as_array().unwrap());
    let mut differ = 0;
    for (primitive, part) in primitives.zip(&model.parts) {
        let accessor = primitive["attributes"]["POSITION"].as_u64().unwrap() as usize;
        for (name, bound) in [("min", f32::min as fn(f32, f32) -> f32), ("max", f32::max)] {
            let fold = |axis| part.mesh.positions().iter().map(|p: &[f32; 3]| p[axis]).reduce(bound).unwrap();
            let expected: [f64; 3] = std::array::from_fn(|axis| fold(axis).into());
            let of = |json: &Value| -> Vec<f64> {
                let bound = json["accessors"][accessor][name].as_array().unwrap();
                bound.iter().map(|x| x.as_f64().unwrap()).collect()
            };
            assert_eq!(of(&json), expected);
            differ += usize::from(of(&draft.json) != expected);
        }
    }
    assert!(differ > 0);
    let mut filters = Vec::new();
    for (view, object) in draft.json["bufferViews"].as_array().unwrap().iter().enumerate() {
        let compressed = &object["extensions"][KHR];
        let number = |name: &str| compressed[name].as_u64().unwrap_or(0) as usize;
        let (stride, count) = (number("byteStride"), number("count"));
        let source = &draft.bin[number("byteOffset")..][..number("byteLength")];
        let found = view_bytes(&json, bin_of(&glb), view);
        let filter = compressed["filter"].as_str().unwrap_or("NONE");
        filters.push(filter);
        match (compressed["mode"].as_str().unwrap(), filter) {
            ("TRIANGLES", _) => {
                let expected = meshopt::decode_index_buffer::<u16>(source, count).unwrap();
                assert_eq!(found, expected.iter().flat_map(|i| i.to_le_bytes()).collect::<Vec<_>>());
            }
            (_, "NONE") => {
                fn decode<const N: usize>(source: &[u8], count: usize) -> Vec<u8>
                where
                    [u8; N]: Default,
                {
                    meshopt::decode_vertex_buffer::<[u8; N]>(source, count).unwrap().concat()
                }
                let expected = match stride {
                    4 => decode::<4>(source, count),
                    _ => decode::<8>(source, count),
                };
                assert_eq!(found, expected);
            }
            (_, "OCTAHEDRAL") => {
                let mut oct = meshopt::decode_vertex_buffer::<[i8; 4]>(source, count).unwrap();
                meshopt::decode_filter_oct(&mut oct);
                let expected: Vec<i64> = oct.iter().flatten().map(|&x| x.into()).collect();
                within_one(found, &expected, i8_of);
            }
            (_, "QUATERNION") => {
                let mut quat = meshopt::decode_vertex_buffer::<[i16; 4]>(source, count).unwrap();
                meshopt::decode_filter_quat(&mut quat);
                let expected: Vec<i64> = quat.iter().flatten().map(|&x| x.into()).collect();
                within_one(found, &expected, i16_of);
            }
            _ => {
                let mut exp = meshopt::decode_vertex_buffer::<[u32; 3]>(source, count).unwrap();
                meshopt::decode_filter_exp(&mut exp);
                assert_eq!(found, bytes_of(&exp, u32::to_le_bytes));
            }
        }
    }
    for filter in ["NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"] {
        assert!(filters.contains(&filter), "{filter}");
    }
}

#[test]
fn what_is_written_is_uncompressed_and_the_rest_is_unchanged() {
    let mut draft = ribbon(300);
    let image: Vec<u8> = (0..201_u32).map(|i| (i * 7) as u8).collect();
    let image_view = draft.view(&image);
    draft.json["images"] = json!([{ "bufferView": image_view, "mimeType": "image/png" }]);
    draft.json["textures"] = json!([{ "source": 0 }]);
    draft.json["extras"] = serde_json::from_str("{\"kept\":[1.50,\"x\"]}").unwrap();
    draft.json["extensionsUsed"] = json!(["KHR_materials_unlit"]);
    draft.json["bufferViews"][1]["extensions"] = json!({ "VENDOR_kept": {} });
    let expected = gltf::read(draft.glb(), None).unwrap();
    let views = [(0, Compression::attributes(12, 0)), (1, Compression::TRIANGLES)];
    for in_bin in [true, false] {
        let mut compressed = compress(&draft, EXT, &views);
        if !in_bin {
            // Not marked, and with a URI of a missing file: it is not read.
            compressed.json["buffers"][1] = json!({ "byteLength": 9000, "uri": "none.bin" });
        }
        let model = gltf::read(compressed.glb(), None).unwrap();
        let mut strips = Strips::default();
        triangles(&model, 0).iter().for_each(|triangle| strips.push(triangle));
        for drawing in [Drawing::Faces, Drawing::Strips(&strips)] {
            let glb = write(&model, &[drawing], Format::Glb, Layout::Degenerate).unwrap();
            let json = json_of(&glb);
            assert!(!json.to_string().contains("meshopt"), "{json}");
            assert_eq!(json["buffers"], json!([{ "byteLength": json["buffers"][0]["byteLength"] }]));
            assert_eq!(json["extensionsUsed"], json!(["KHR_materials_unlit"]));
            assert_eq!(json["extensionsRequired"], Value::Null);
            assert_eq!(json["extras"].to_string(), "{\"kept\":[1.50,\"x\"]}");
            assert_eq!(json["bufferViews"][1]["extensions"], json!({ "VENDOR_kept": {} }));
            assert_eq!(json["accessors"][0], draft.json["accessors"][0]);
            assert_eq!(view_bytes(&json, bin_of(&glb), image_view), image);
            // No compressed byte remains: positions, indices and the image, each aligned.
            let kept: usize =
                [300 * 12, 201, 298 * 3 * 2].iter().map(|n: &usize| n.next_multiple_of(8)).sum();
            let length = json["buffers"][0]["byteLength"].as_u64().unwrap() as usize;
            assert!(matches!(drawing, Drawing::Strips(_)) || length <= kept + 8, "{length}, {kept}");
            let again = gltf::read(glb, None).unwrap();
            // Degenerate joins may change the order.
            let sorted = |model: &Model| {
                let mut sorted = triangles(model, 0);
                sorted.sort_unstable();
                sorted
            };
            assert!(sorted(&again) == sorted(&expected));
            assert_eq!(again.parts[0].mesh.positions(), expected.parts[0].mesh.positions());
        }
    }
}

#[test]
fn a_document_of_nothing_but_a_fallback_can_be_read_again() {
    let asset = json!({ "version": "2.0" });
    let marked = json!({ "byteLength": 8, "extensions": { EXT: { "fallback": true } } });
    let empty = json!({ "byteLength": 0, "uri": "data:;base64," });
    for buffer in [marked, empty] {
        let json = json!({ "asset": asset, "buffers": [buffer] });
        let glb = written(&gltf::read(serde_json::to_vec(&json).unwrap(), None).unwrap());
        assert!(json_of(&glb).get("buffers").is_none());
        assert!(gltf::read(glb, None).is_ok());
    }
}
