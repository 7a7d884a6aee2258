//! Scenes with data of many kinds for the same vertices, and a naive reader of accessors.

use serde_json::{Value, json};

use super::{Draft, F32, U8, U16, bin_of, floats, json_of, packed, push};

/// Returns a grid of triangles with shuffled vertex indices; some vertices are unused.
pub(crate) fn grid(side: u32) -> (Vec<[f32; 3]>, Vec<u32>) {
    let count = (side + 1) * (side + 1) + 3;
    let name = |v: u32| (v * 7919 + 5) % count;
    let mut positions = vec![[0.0; 3]; count as usize];
    (0..count)
        .for_each(|v| positions[name(v) as usize] = [(v % (side + 1)) as f32, (v / (side + 1)) as f32, 0.5]);
    let corner = |x: u32, y: u32| name(y * (side + 1) + x);
    let cells = (0..side * side).map(|cell| (cell % side, cell / side));
    let faces = cells.flat_map(|(x, y)| {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x, y + 1), corner(x + 1, y + 1)];
        [a, b, c, c, b, d]
    });
    (positions, faces.collect())
}

/// Adds a view of interleaved rows of `stride` bytes. Returns accessors for the fields at the given
/// offsets.
pub(crate) fn interleaved(
    draft: &mut Draft,
    stride: usize,
    bytes: &[u8],
    parts: &[(usize, u32, &str)],
) -> Vec<usize> {
    let view = draft.view(bytes);
    draft.json["bufferViews"][view]["byteStride"] = stride.into();
    draft.json["bufferViews"][view]["target"] = 34962.into();
    let count = bytes.len() / stride;
    let add = |&(offset, component, kind): &(usize, u32, &str)| {
        let accessor = draft.accessor(view, component, count, kind);
        draft.json["accessors"][accessor]["byteOffset"] = offset.into();
        accessor
    };
    parts.iter().map(add).collect()
}

/// Returns a scene with one vertex array: interleaved positions and normals, colours of three
/// bytes, joints and weights, a matrix per vertex, a dense and a sparse morph target. A second
/// vertex array shares its indices with the first.
pub(crate) fn shared_scene(side: u32) -> Draft {
    let mut draft = Draft::new();
    let (positions, corners) = grid(side);
    let count = positions.len();
    let mut rows = Vec::new();
    for (i, p) in positions.iter().enumerate() {
        rows.extend(floats(p));
        let angle = i as f32;
        rows.extend(floats(&[angle.cos(), angle.sin(), 0.0]));
        rows.extend([i as u8, (i >> 8) as u8, 9, 0]);
    }
    let parts = interleaved(&mut draft, 28, &rows, &[(0, F32, "VEC3"), (12, F32, "VEC3"), (24, U8, "VEC3")]);
    let [position, normal, colour] = parts[..] else { return draft };
    draft.json["accessors"][position]["min"] = json!([0, 0, 0.5]);
    draft.json["accessors"][position]["max"] = json!([side, side + 1, 0.5]);
    draft.json["accessors"][colour]["normalized"] = true.into();
    let bytes: Vec<u8> = (0..4 * count).map(|i| u8::from(i % 4 == 1)).collect();
    let joints = draft.view(&bytes);
    let joints = draft.accessor(joints, U8, count, "VEC4");
    let weights: Vec<f32> =
        (0..count).flat_map(|i| [i as f32 / count as f32, 1.0 - i as f32 / count as f32, 0.0, 0.0]).collect();
    let weights = draft.view(&floats(&weights));
    let weights = draft.accessor(weights, F32, count, "VEC4");
    let matrix: Vec<f32> = (0..4 * count).map(|i| i as f32).collect();
    let matrix = draft.view(&floats(&matrix));
    let matrix = draft.accessor(matrix, F32, count, "MAT2");
    for accessor in [joints, weights, matrix] {
        let view = draft.json["accessors"][accessor]["bufferView"].as_u64().unwrap() as usize;
        draft.json["bufferViews"][view]["target"] = 34962.into();
    }
    // Two morph targets: a dense one, and a sparse one with four values.
    let dense: Vec<[f32; 3]> = (0..count).map(|i| [0.0, i as f32, 0.0]).collect();
    let dense = draft.positions(&dense);
    let indices = draft.view(&packed(U16, &[1, 4, 8, count as u32 - 1]));
    let moved = draft.view(&floats(&[1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 3.0, 0.0, 0.0, 4.0, 0.0, 0.0]));
    let sparse = push(
        &mut draft.json["accessors"],
        json!({
            "componentType": F32, "count": count, "type": "VEC3", "min": [0, 0, 0], "max": [4, 0, 0],
            "sparse": {
                "count": 4, "indices": { "bufferView": indices, "componentType": U16 }, "values": { "bufferView": moved },
            },
        }),
    );
    let identity: Vec<f32> = (0..16).map(|i| f32::from(u8::from(i % 5 == 0))).collect();
    let matrices = draft.view(&floats(&[&identity[..], &identity].concat()));
    let matrices = draft.accessor(matrices, F32, 2, "MAT4");
    let half = corners.len() / 6 * 3;
    let first = draft.indices(U16, &corners[half..]);
    let second = draft.indices(U16, &corners[..half]);
    let attributes = json!({
        "POSITION": position, "NORMAL": normal, "COLOR_0": colour, "JOINTS_0": joints, "WEIGHTS_0": weights, "_MATRIX": matrix,
    });
    let targets = json!([{ "POSITION": dense }, { "POSITION": sparse }]);
    let own: Vec<[f32; 3]> = (0..count).map(|i| [i as f32, 1.0, 2.0]).collect();
    let own = draft.positions(&own);
    draft.json["meshes"] = json!([
        { "primitives": [{ "attributes": attributes, "indices": first, "targets": targets }] },
        { "primitives": [{ "attributes": { "POSITION": position }, "indices": second }] },
        { "primitives": [{ "attributes": { "POSITION": own }, "indices": first }] },
    ]);
    draft.json["nodes"] = json!([{ "mesh": 0, "skin": 0 }, { "mesh": 1 }, { "mesh": 2 }, { "name": "bone", "children": [4] }, {}]);
    draft.json["scenes"] = json!([{ "nodes": [0, 1, 2, 3] }]);
    draft.json["skins"] = json!([{ "joints": [3, 4], "inverseBindMatrices": matrices }]);
    draft
}

/// Returns the bytes of each value of an accessor, with the sparse values applied.
pub(crate) fn raw(glb: &[u8], accessor: usize) -> Vec<Vec<u8>> {
    let (json, bin) = (json_of(glb), bin_of(glb));
    let accessor = &json["accessors"][accessor];
    let number = |value: &Value| value.as_u64().unwrap_or(0) as usize;
    let width = |code: &Value| [1, 1, 2, 2, 0, 4, 4][number(code) - 5120];
    let names = ["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"];
    let kind = names.iter().position(|name| *name == accessor["type"]).unwrap();
    let element = [1, 2, 3, 4, 4, 9, 16][kind] * width(&accessor["componentType"]);
    let list = |holder: &Value, element: usize, count: usize| -> Vec<Vec<u8>> {
        let view = &json["bufferViews"][number(&holder["bufferView"])];
        let start = number(&view["byteOffset"]) + number(&holder["byteOffset"]);
        let stride = number(&view["byteStride"]).max(element);
        (0..count).map(|i| bin[start + i * stride..][..element].to_vec()).collect()
    };
    let count = number(&accessor["count"]);
    let mut out = match &accessor["bufferView"] {
        Value::Null => vec![vec![0; element]; count],
        _ => list(accessor, element, count),
    };
    if let Some(sparse) = accessor.get("sparse") {
        let count = number(&sparse["count"]);
        let indices = list(&sparse["indices"], width(&sparse["indices"]["componentType"]), count);
        let indices: Vec<usize> =
            indices.iter().map(|b| b.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b))).collect();
        assert!(indices.is_sorted_by(|a, b| a < b));
        for (index, value) in indices.into_iter().zip(list(&sparse["values"], element, count)) {
            out[index] = value;
        }
    }
    out
}
