//! Common parts of the glTF tests: a builder of small documents, the Khronos validator, and real
//! scenes.
#![allow(dead_code, reason = "each test file uses a part of it")]
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may panic, and reports what it skips")]

pub(crate) mod scenes;

use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::{Value, json};
use tristrip::Strips;
use tristrip_io::Model;

pub(crate) const U8: u32 = 5121;
pub(crate) const U16: u32 = 5123;
pub(crate) const U32: u32 = 5125;
pub(crate) const F32: u32 = 5126;

/// A document under construction.
pub(crate) struct Draft {
    pub(crate) json: Value,
    pub(crate) bin: Vec<u8>,
}

impl Draft {
    pub(crate) fn new() -> Self {
        Self {
            json: json!({
                "asset": { "version": "2.0" },
                "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
                "meshes": [{ "primitives": [] }],
                "accessors": [], "bufferViews": [], "buffers": [{}],
            }),
            bin: Vec::new(),
        }
    }

    /// Appends bytes, aligned to four, and returns the buffer view.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bin.resize(self.bin.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bin.len(), "byteLength": bytes.len() });
        self.bin.extend_from_slice(bytes);
        push(&mut self.json["bufferViews"], view)
    }

    pub(crate) fn accessor(&mut self, view: usize, component: u32, count: usize, kind: &str) -> usize {
        let accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        push(&mut self.json["accessors"], accessor)
    }

    pub(crate) fn positions(&mut self, positions: &[[f32; 3]]) -> usize {
        let view = self.view(&floats(positions.as_flattened()));
        self.json["bufferViews"][view]["target"] = 34962.into();
        let accessor = self.accessor(view, F32, positions.len(), "VEC3");
        let bound = |f: fn(f32, f32) -> f32| {
            let mut out = positions[0];
            for p in positions {
                (0..3).for_each(|axis| out[axis] = f(out[axis], p[axis]));
            }
            json!(out)
        };
        self.json["accessors"][accessor]["min"] = bound(f32::min);
        self.json["accessors"][accessor]["max"] = bound(f32::max);
        accessor
    }

    pub(crate) fn indices(&mut self, component: u32, indices: &[u32]) -> usize {
        let view = self.view(&packed(component, indices));
        self.json["bufferViews"][view]["target"] = 34963.into();
        self.accessor(view, component, indices.len(), "SCALAR")
    }

    pub(crate) fn primitive(&mut self, position: usize, indices: Option<usize>, mode: u32) -> usize {
        let mut primitive = json!({ "attributes": { "POSITION": position }, "mode": mode });
        if let Some(indices) = indices {
            primitive["indices"] = indices.into();
        }
        push(&mut self.json["meshes"][0]["primitives"], primitive)
    }

    /// Builds the GLB.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        if json["buffers"][0]["byteLength"].is_null() && json["buffers"][0].is_object() {
            json["buffers"][0]["byteLength"] = self.bin.len().into();
        }
        glb_of(&serde_json::to_vec(&json).unwrap(), Some(&self.bin))
    }

    /// Builds a `.gltf` with its buffer in a data URI.
    pub(crate) fn gltf(&self) -> Vec<u8> {
        use base64::Engine;
        let text = base64::engine::general_purpose::STANDARD.encode(&self.bin);
        let mut json = self.json.clone();
        json["buffers"][0] = json!({
            "byteLength": self.bin.len(),
            "uri": format!("data:application/octet-stream;base64,{text}"),
        });
        serde_json::to_vec(&json).unwrap()
    }
}

pub(crate) fn push(list: &mut Value, value: Value) -> usize {
    let list = list.as_array_mut().unwrap();
    list.push(value);
    list.len() - 1
}

pub(crate) fn glb_of(json: &[u8], bin: Option<&[u8]>) -> Vec<u8> {
    let chunk = |kind: &[u8; 4], body: &[u8], fill: u8| {
        let mut out = (body.len().next_multiple_of(4) as u32).to_le_bytes().to_vec();
        out.extend_from_slice(kind);
        out.extend_from_slice(body);
        out.resize(8 + body.len().next_multiple_of(4), fill);
        out
    };
    let mut body = chunk(b"JSON", json, b' ');
    body.extend(bin.map(|bin| chunk(b"BIN\0", bin, 0)).unwrap_or_default());
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((12 + body.len() as u32).to_le_bytes());
    out.extend(body);
    out
}

pub(crate) fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

pub(crate) fn packed(component: u32, indices: &[u32]) -> Vec<u8> {
    let bytes = [1, 2, 4][[U8, U16, U32].iter().position(|&c| c == component).unwrap()];
    indices.iter().flat_map(|i| i.to_le_bytes()[..bytes].to_vec()).collect()
}

/// Returns distinct positions along a bent line.
pub(crate) fn bent(count: usize) -> Vec<[f32; 3]> {
    (0..count).map(|i| [i as f32, (i * i % 7) as f32, (i % 3) as f32]).collect()
}

/// Returns the JSON of a GLB.
pub(crate) fn json_of(glb: &[u8]) -> Value {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    serde_json::from_slice(&glb[20..20 + length]).unwrap()
}

/// Returns the BIN chunk of a GLB.
pub(crate) fn bin_of(glb: &[u8]) -> &[u8] {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    glb.get(28 + length..).unwrap_or_default()
}

/// Returns the bytes of a buffer view of a GLB.
pub(crate) fn view_bytes<'a>(json: &Value, bin: &'a [u8], view: usize) -> &'a [u8] {
    let view = &json["bufferViews"][view];
    let number = |name: &str| view[name].as_u64().unwrap_or(0) as usize;
    &bin[number("byteOffset")..][..number("byteLength")]
}

/// Returns the triangles, each starting at its lowest vertex.
pub(crate) fn rotated(triangles: impl IntoIterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    triangles
        .into_iter()
        .map(|mut t| {
            let lowest = (0..3).min_by_key(|&i| t[i]).unwrap();
            t.rotate_left(lowest);
            t
        })
        .collect()
}

pub(crate) fn triangles(model: &Model, part: usize) -> Vec<[u32; 3]> {
    rotated(model.parts[part].mesh.faces().as_triangles().unwrap().as_chunks::<3>().0.iter().copied())
}

/// Builds strips greedily: a strip continues while the next triangle shares the required edge.
pub(crate) fn greedy(triangles: &[[u32; 3]]) -> Strips {
    let mut strips = Strips::default();
    let mut strip: Vec<u32> = Vec::new();
    for &t in triangles {
        if strip.len() >= 3 {
            let (a, b) = (strip[strip.len() - 2], strip[strip.len() - 1]);
            let edge = if strip.len().is_multiple_of(2) { [a, b] } else { [b, a] };
            let third = (0..3).find(|&i| [t[i], t[(i + 1) % 3]] == edge).map(|i| t[(i + 2) % 3]);
            if let Some(third) = third.filter(|&v| v != a && v != b) {
                strip.push(third);
                continue;
            }
            strips.push(&strip);
        }
        strip = t.to_vec();
    }
    if strip.len() >= 3 {
        strips.push(&strip);
    }
    strips
}

/// Validates files with the Khronos validator, if it is installed. With
/// `TRISTRIP_REQUIRE_VALIDATOR=1`, the validator must be installed.
pub(crate) fn validate(test: &str, files: &[(String, Vec<u8>)]) {
    let tool = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tools/gltf-validate");
    if !tool.join("node_modules/gltf-validator").is_dir() {
        let why = "SKIPPED: Khronos validator not installed; run `npm ci --prefix tools/gltf-validate`";
        assert!(std::env::var_os("TRISTRIP_REQUIRE_VALIDATOR").is_none_or(|v| v != "1"), "{why}");
        eprintln!("{test}: {why}");
        return;
    }
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(test);
    std::fs::create_dir_all(&folder).unwrap();
    let paths: Vec<PathBuf> = files
        .iter()
        .map(|(name, bytes)| {
            let path = folder.join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        })
        .collect();
    for paths in paths.chunks(100) {
        let run = Command::new("node").arg(tool.join("validate.mjs")).args(paths).output();
        match run {
            Ok(out) => assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stdout)),
            Err(e) => {
                assert!(std::env::var_os("TRISTRIP_REQUIRE_VALIDATOR").is_none_or(|v| v != "1"), "node: {e}");
                eprintln!("{test}: SKIPPED: node cannot be run: {e}");
            }
        }
    }
}

/// Calls `check` with the name and bytes of real scenes in the directory `TRISTRIP_MODELS`, if it
/// is set, and validates the files that `check` returns.
pub(crate) fn check_real_scenes(test: &str, mut check: impl FnMut(&str, &[u8]) -> Vec<(String, Vec<u8>)>) {
    let Some(folder) = std::env::var_os("TRISTRIP_MODELS").map(PathBuf::from) else {
        eprintln!("{test}: SKIPPED: TRISTRIP_MODELS is not set");
        return;
    };
    let mut files = Vec::new();
    for name in ["milktruck", "engine_2cylinder", "sheencloth"] {
        let glb = std::fs::read(folder.join(format!("{name}.glb"))).unwrap();
        files.extend(check(name, &glb));
    }
    validate(test, &files);
}
