//! glTF with Draco-compressed geometry: read like uncompressed geometry, with limits on malformed
//! streams.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use draco_gltf::{
    ComponentType, CompressionOptions, DracoPrimitiveEncoding, PackedAttribute, PackedGeometry,
    PackedIndices, PrimitiveMode,
};
use serde_json::{Value, json};
use tristrip::Layout;
use tristrip_io::{Drawing, Error, Format, gltf, write};

use crate::doubling::check_linear;
use crate::random::random;

const SIDE: u32 = 12;

fn encoded() -> DracoPrimitiveEncoding {
    encoded_grid(SIDE)
}

/// Returns a grid of (side + 1)² vertices with positions and colours of three bytes.
fn encoded_grid(side: u32) -> DracoPrimitiveEncoding {
    let vertex_count = ((side + 1) * (side + 1)) as usize;
    let at = |i: u32| [(i % (side + 1)) as f32, (i / (side + 1)) as f32, ((i * 7) % 5) as f32];
    let positions: Vec<u8> = (0..vertex_count as u32).flat_map(at).flat_map(f32::to_le_bytes).collect();
    let colours: Vec<u8> = (0..vertex_count as u32).flat_map(|i| [i as u8, 3, 9]).collect();
    let quad = |i: u32| {
        let v = i / side * (side + 1) + i % side;
        [v, v + 1, v + side + 1, v + side + 1, v + 1, v + side + 2]
    };
    let corners: Vec<u8> = (0..side * side).flat_map(quad).flat_map(u32::to_le_bytes).collect();
    let attributes = vec![
        PackedAttribute::new("POSITION", vertex_count, 3, ComponentType::F32, false, positions).unwrap(),
        PackedAttribute::new("COLOR_0", vertex_count, 3, ComponentType::U8, true, colours).unwrap(),
    ];
    let indices = PackedIndices::new(corners.len() / 4, ComponentType::U32, corners).unwrap();
    let geometry = PackedGeometry::new(PrimitiveMode::Triangles, attributes, Some(indices)).unwrap();
    DracoPrimitiveEncoding::encode(&geometry, &CompressionOptions::default()).unwrap()
}

/// Returns a document with a stream, followed by four other bytes.
fn document(encoded: &DracoPrimitiveEncoding, stream: &[u8]) -> Value {
    let numbers = encoded.extension(0);
    let numbers: serde_json::Map<String, Value> =
        numbers.attributes().map(|(name, number)| (name.to_owned(), number.into())).collect();
    let count = encoded.accessors()[0].count();
    let bytes = [stream, b"rest"].concat();
    let data = STANDARD.encode(&bytes);
    json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_draco_mesh_compression"],
        "extensionsRequired": ["KHR_draco_mesh_compression"],
        "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "COLOR_0": 1 }, "indices": 2, "mode": 4,
            "extensions": { "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": numbers } },
        }] }],
        "accessors": [
            { "componentType": 5126, "count": count, "type": "VEC3", "min": [0, 0, 0], "max": [12, 12, 4] },
            { "componentType": 5121, "count": count, "type": "VEC3", "normalized": true },
            { "componentType": 5125, "count": encoded.index_count(), "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": stream.len() },
            { "buffer": 0, "byteOffset": stream.len(), "byteLength": 4 },
        ],
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}") }],
    })
}

#[test]
fn a_compressed_primitive_is_read_and_written_without_compression() {
    let encoded = encoded();
    let json = document(&encoded, encoded.bytes());
    let model = gltf::read(json.to_string(), None).unwrap();
    let mesh = &model.parts[0].mesh;
    let expected = encoded.decoded().unwrap();
    assert_eq!(mesh.vertex_count(), expected.vertex_count());
    assert_eq!(mesh.faces().face_count(), (2 * SIDE * SIDE) as usize);
    let positions: Vec<u8> = mesh.positions().iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    assert_eq!(positions, expected.attributes()[0].bytes());
    assert_eq!((&*mesh.attributes()[0].name, mesh.attributes()[0].components), ("COLOR_0", 3));
    assert!(model.notes[0].starts_with("primitives compressed with Draco"), "{:?}", model.notes);
    let glb = write(&model, &[Drawing::Faces], Format::Glb, Layout::List).unwrap();
    let text = String::from_utf8_lossy(&glb);
    assert!(!text.contains("draco") && text.contains("rest"), "{text}");
    let again = gltf::read(glb, None).unwrap();
    assert_eq!(again.parts[0].mesh, *mesh);
}

#[test]
fn wrong_streams_and_counts_are_errors() {
    let encoded = encoded();
    let bytes = encoded.bytes();
    let read = |json: &Value| gltf::read(json.to_string(), None).map(drop).map_err(|error| error.to_string());
    for length in [0, 1, 7, 40, bytes.len() / 2] {
        let error = read(&document(&encoded, &bytes[..length])).unwrap_err();
        assert!(length == 0 || error.contains("KHR_draco_mesh_compression"), "{length}: {error}");
    }
    // Changing any single byte gives an error or another mesh, never a panic.
    for i in 0..bytes.len() {
        let mut changed = bytes.to_vec();
        changed[i] ^= 0x5a;
        let _ = read(&document(&encoded, &changed));
    }
    let mut json = document(&encoded, bytes);
    json["accessors"][2]["count"] = 30.into();
    assert!(read(&json).is_err());
    json["accessors"][2]["count"] = u32::MAX.into();
    assert!(read(&json).unwrap_err().contains("bytes decoded so far"));
    let mut json = document(&encoded, bytes);
    json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 9.into();
    assert!(read(&json).unwrap_err().contains("less than 2"));
    json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"] = json!({});
    assert!(read(&json).unwrap_err().contains("bufferView"));
}

const EXTENSION: &str = "KHR_draco_mesh_compression";

fn message(json: &Value) -> String {
    gltf::read(json.to_string(), None).map(drop).unwrap_err().to_string()
}

#[test]
fn damaged_streams_never_panic() {
    let encoded = encoded_grid(4);
    let bytes = encoded.bytes();
    for length in 1..bytes.len() {
        let error = message(&document(&encoded, &bytes[..length]));
        assert!(error.contains(EXTENSION) && error.ends_with("expected a Draco stream"), "{length}: {error}");
    }
    let mut random = random();
    let mut wrong = 0;
    for _ in 0..4000 {
        let mut changed = bytes.to_vec();
        for _ in 0..=random(4) {
            let at = random(changed.len());
            changed[at] = random(256) as u8;
        }
        match gltf::read(document(&encoded, &changed).to_string(), None) {
            Ok(model) => {
                let mesh = &model.parts[0].mesh;
                let vertex_count = mesh.vertex_count() as u32;
                assert!(
                    mesh.faces().corners().iter().all(|&v| v < vertex_count) && vertex_count <= 96,
                    "{vertex_count}"
                );
            }
            Err(error) => {
                wrong += 1;
                assert!(error.to_string().contains("found"), "{error}");
            }
        }
    }
    assert!((1000..3000).contains(&wrong), "{wrong}");
}

#[test]
fn wrong_members_are_named() {
    let encoded = encoded_grid(2);
    let primitive = "meshes[0].primitives[0]";
    let at = format!("{primitive}.extensions.{EXTENSION}");
    let wrong = |change: &dyn Fn(&mut Value)| {
        let mut json = document(&encoded, encoded.bytes());
        change(&mut json["meshes"][0]["primitives"][0]);
        message(&json)
    };
    for (member, value, found) in [
        ("bufferView", json!(-1), format!("{at}.bufferView: found -1, expected a non-negative integer")),
        ("bufferView", json!(null), format!("{at}.bufferView: found null, expected a non-negative integer")),
        ("attributes", json!([]), format!("{at}.attributes: found an array, expected an object")),
        ("attributes", json!({ "POSITION": -1 }), format!("{at}.attributes.POSITION: found -1")),
        ("attributes", json!({ "POSITION": u64::MAX }), format!("{at}: found ")),
        ("attributes", json!({ "POSITION": 99 }), format!("{at}: found ")),
        ("attributes", json!({}), format!("{at}: found ")),
    ] {
        let error = wrong(&|primitive| primitive["extensions"][EXTENSION][member] = value.clone());
        assert!(error.starts_with(&found), "{error}");
    }
    for (member, value, found) in [
        (
            "indices",
            json!(9),
            format!("{primitive}.indices: found 9, expected less than 3, the number of accessors"),
        ),
        ("indices", json!(-1), format!("{primitive}.indices: found -1, expected a non-negative integer")),
        ("attributes", json!({ "POSITION": 9 }), format!("{primitive}.attributes.POSITION: found 9")),
        ("attributes", json!(0), format!("{primitive}.attributes: found 0, expected an object")),
        ("attributes", json!({}), format!("{at}: found ")),
    ] {
        let error = wrong(&|primitive| primitive[member] = value.clone());
        assert!(error.starts_with(&found), "{error}");
    }
    let error = wrong(&|primitive| drop(primitive.as_object_mut().unwrap().remove("indices")));
    assert_eq!(error, format!("{primitive}.indices: found nothing, expected a value"));
}

#[test]
fn attributes_that_the_primitive_does_not_have_are_not_decoded() {
    let encoded = encoded_grid(2);
    let mut json = document(&encoded, encoded.bytes());
    for i in 0..1000 {
        json["meshes"][0]["primitives"][0]["extensions"][EXTENSION]["attributes"][format!("_{i}")] =
            99.into();
    }
    let mesh = &gltf::read(json.to_string(), None).unwrap().parts[0].mesh;
    assert_eq!((mesh.vertex_count(), mesh.attributes().len()), (9, 1));
}

#[test]
fn an_attribute_by_many_names_is_limited() {
    let encoded = encoded_grid(2);
    let named = |count: usize| {
        let mut json = document(&encoded, encoded.bytes());
        let primitive = &mut json["meshes"][0]["primitives"][0];
        let colour = primitive["extensions"][EXTENSION]["attributes"]["COLOR_0"].clone();
        for i in 0..count {
            primitive["attributes"][format!("_{i}")] = 1.into();
            primitive["extensions"][EXTENSION]["attributes"][format!("_{i}")] = colour.clone();
        }
        gltf::read(json.to_string(), None)
    };
    assert_eq!(named(100).unwrap().parts[0].mesh.attributes().len(), 101);
    let error = named(1000).unwrap_err();
    let Error::LimitExceeded { at, found, limit } = error else { unreachable!("{error}") };
    assert!(at.ends_with("KHR_draco_mesh_compression, bytes decoded so far"), "{at}");
    assert!(found > 1000 * (1 << 16) && limit < 9 << 20, "{found}, {limit}");
}

/// Returns a document of primitives with separate accessors, and separate streams or a common one.
fn primitives(count: usize, padding: usize, is_shared: bool) -> Value {
    let encoded = encoded_grid(1);
    let mut json = document(&encoded, &[encoded.bytes(), &vec![0; padding]].concat());
    let accessors = json["accessors"].as_array().unwrap().clone();
    let (primitive, view) = (json["meshes"][0]["primitives"][0].clone(), json["bufferViews"][0].clone());
    for i in 1..count {
        let mut next = primitive.clone();
        next["attributes"] = json!({ "POSITION": 3 * i, "COLOR_0": 3 * i + 1 });
        next["indices"] = (3 * i + 2).into();
        if !is_shared {
            next["extensions"][EXTENSION]["bufferView"] = (i + 1).into();
            json["bufferViews"].as_array_mut().unwrap().push(view.clone());
        }
        json["accessors"].as_array_mut().unwrap().extend(accessors.clone());
        json["meshes"][0]["primitives"].as_array_mut().unwrap().push(next);
    }
    json
}

#[test]
fn streams_of_many_primitives_take_linear_time() {
    check_linear(
        400,
        |count| (count, primitives(count, 0, false).to_string()),
        |(count, text)| {
            assert_eq!(gltf::read(&**text, None).unwrap().parts.len(), *count);
        },
    );
}

#[test]
fn a_stream_that_is_decoded_again_and_again_is_limited() {
    assert_eq!(gltf::read(primitives(200, 300_000, true).to_string(), None).unwrap().parts.len(), 200);
    let error = gltf::read(primitives(400, 300_000, true).to_string(), None).unwrap_err();
    let Error::LimitExceeded { at, found, limit } = error else { unreachable!("{error}") };
    assert!(at.ends_with("KHR_draco_mesh_compression, bytes decoded so far"), "{at}");
    assert!(found > limit && limit < (8 << 20) + 256 * 301_000, "{found}, {limit}");
}
