//! glTF with geometry compressed by Draco: read as if it were not, and bounded on wrong streams.
#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use draco_gltf::{
    ComponentType, CompressionOptions, DracoPrimitiveEncoding, PackedAttribute, PackedGeometry,
    PackedIndices, PrimitiveMode,
};
use serde_json::{Value, json};
use tristrip::Layout;
use tristrip_io::{Drawing, Format, gltf, write};

const SIDE: u32 = 12;

/// Returns a grid of (SIDE + 1)² vertices with positions, and colours of three bytes.
fn encoded() -> DracoPrimitiveEncoding {
    let vertex_count = ((SIDE + 1) * (SIDE + 1)) as usize;
    let at = |i: u32| [(i % (SIDE + 1)) as f32, (i / (SIDE + 1)) as f32, ((i * 7) % 5) as f32];
    let positions: Vec<u8> = (0..vertex_count as u32).flat_map(at).flat_map(f32::to_le_bytes).collect();
    let colours: Vec<u8> = (0..vertex_count as u32).flat_map(|i| [i as u8, 3, 9]).collect();
    let quad = |i: u32| {
        let v = i / SIDE * (SIDE + 1) + i % SIDE;
        [v, v + 1, v + SIDE + 1, v + SIDE + 1, v + 1, v + SIDE + 2]
    };
    let corners: Vec<u8> = (0..SIDE * SIDE).flat_map(quad).flat_map(u32::to_le_bytes).collect();
    let attributes = vec![
        PackedAttribute::new("POSITION", vertex_count, 3, ComponentType::F32, false, positions).unwrap(),
        PackedAttribute::new("COLOR_0", vertex_count, 3, ComponentType::U8, true, colours).unwrap(),
    ];
    let indices = PackedIndices::new(corners.len() / 4, ComponentType::U32, corners).unwrap();
    let geometry = PackedGeometry::new(PrimitiveMode::Triangles, attributes, Some(indices)).unwrap();
    DracoPrimitiveEncoding::encode(&geometry, &CompressionOptions::default()).unwrap()
}

/// Returns a document with a stream, and with four bytes of something else after it.
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
    assert!(model.notes[0].starts_with("primitives compressed by Draco"), "{:?}", model.notes);
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
    // Every byte changed, one after the other, gives an error or another mesh, never a panic.
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
