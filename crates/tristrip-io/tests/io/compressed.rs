//! Documents with buffer views compressed by meshoptimizer's own encoders.
#![allow(dead_code, reason = "each test file uses a part of it")]

use std::path::PathBuf;

use serde_json::json;
use tristrip::Layout;
use tristrip_io::{Drawing, Format, Model, write};

use crate::gltf_documents::*;

pub(crate) const EXT: &str = "EXT_meshopt_compression";
pub(crate) const KHR: &str = "KHR_meshopt_compression";

/// The compression of a buffer view.
#[derive(Clone, Copy)]
pub(crate) struct Compression<'a> {
    pub(crate) mode: &'a str,
    pub(crate) filter: Option<&'a str>,
    pub(crate) stride: usize,
    /// The version of the attribute codec.
    pub(crate) version: i32,
}

impl Compression<'_> {
    pub(crate) const TRIANGLES: Self = Self { mode: "TRIANGLES", filter: None, stride: 2, version: 1 };

    pub(crate) fn attributes(stride: usize, version: i32) -> Self {
        Self { mode: "ATTRIBUTES", filter: None, stride, version }
    }

    pub(crate) fn encode(&self, bytes: &[u8]) -> Vec<u8> {
        let indices = || -> Vec<u32> {
            let of = |raw: &[u8]| raw.iter().rev().fold(0, |index, &b| index << 8 | u32::from(b));
            bytes.chunks(self.stride).map(of).collect()
        };
        match self.mode {
            "TRIANGLES" => meshopt::encode_index_buffer(&indices(), 1 << 16).unwrap(),
            "INDICES" => meshopt::encode_index_sequence(&indices(), 1 << 16).unwrap(),
            _ => encode_attributes(bytes, self.stride, self.version),
        }
    }
}

/// Calls a generic function for a stride known only at run time.
macro_rules! for_stride {
    ($stride:expr, $name:ident($($argument:expr),*)) => {
        match $stride {
            4 => $name::<4>($($argument),*),
            8 => $name::<8>($($argument),*),
            12 => $name::<12>($($argument),*),
            16 => $name::<16>($($argument),*),
            32 => $name::<32>($($argument),*),
            36 => $name::<36>($($argument),*),
            252 => $name::<252>($($argument),*),
            256 => $name::<256>($($argument),*),
            stride => panic!("stride {stride}"),
        }
    };
}

pub(crate) fn encode_attributes(bytes: &[u8], stride: usize, version: i32) -> Vec<u8> {
    fn encode<const N: usize>(bytes: &[u8], version: i32) -> Vec<u8> {
        meshopt::encode_vertex_buffer_level(bytes.as_chunks::<N>().0, 2, Some(version)).unwrap()
    }
    for_stride!(stride, encode(bytes, version))
}

/// Returns a document with some views compressed, in a second buffer marked as a fallback.
pub(crate) fn compress(draft: &Draft, name: &str, views: &[(usize, Compression<'_>)]) -> Draft {
    let mut out = Draft { json: draft.json.clone(), bin: Vec::new() };
    out.json["buffers"] = json!([{}]);
    let mut fallback = 0;
    for view in 0..draft.json["bufferViews"].as_array().unwrap().len() {
        let bytes = view_bytes(&draft.json, &draft.bin, view);
        out.bin.resize(out.bin.len().next_multiple_of(4), 0);
        let offset = out.bin.len();
        let object = &mut out.json["bufferViews"][view];
        let Some((_, how)) = views.iter().find(|(compressed, _)| *compressed == view) else {
            object["byteOffset"] = offset.into();
            out.bin.extend_from_slice(bytes);
            continue;
        };
        let encoded = how.encode(bytes);
        object["buffer"] = 1.into();
        object["byteOffset"] = fallback.into();
        fallback += bytes.len().next_multiple_of(4);
        object["extensions"][name] = json!({
            "buffer": 0, "byteOffset": offset, "byteLength": encoded.len(),
            "byteStride": how.stride, "count": bytes.len() / how.stride, "mode": how.mode,
        });
        if let Some(filter) = how.filter {
            object["extensions"][name]["filter"] = filter.into();
        }
        out.bin.extend_from_slice(&encoded);
    }
    push(
        &mut out.json["buffers"],
        json!({ "byteLength": fallback, "extensions": { name: { "fallback": true } } }),
    );
    for list in ["extensionsUsed", "extensionsRequired"] {
        if out.json[list].is_null() {
            out.json[list] = json!([]);
        }
        push(&mut out.json[list], name.into());
    }
    out
}

pub(crate) fn draft_of(glb: &[u8]) -> Draft {
    Draft { json: json_of(glb), bin: bin_of(glb).to_vec() }
}

pub(crate) fn model_path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models").join(name)
}

/// Checks that two models have the same vertices and triangles in the same order. The triangle
/// codec may rotate a triangle.
pub(crate) fn same_parts(found: &Model, expected: &Model) {
    assert_eq!(found.parts.len(), expected.parts.len());
    for (part, (one, other)) in found.parts.iter().zip(&expected.parts).enumerate() {
        assert_eq!((&one.name, &one.material), (&other.name, &other.material));
        assert!(one.mesh.positions() == other.mesh.positions(), "positions of part {part}");
        assert!(one.mesh.attributes() == other.mesh.attributes(), "attributes of part {part}");
        assert!(first_rotations(found, part) == first_rotations(expected, part), "triangles of part {part}");
    }
}

/// Returns the triangles, each in its smallest rotation, even if corners are equal.
pub(crate) fn first_rotations(model: &Model, part: usize) -> Vec<[u32; 3]> {
    let corners = model.parts[part].mesh.faces().as_triangles().unwrap();
    let first = |&[a, b, c]: &[u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().unwrap();
    corners.as_chunks::<3>().0.iter().map(first).collect()
}

/// Writes a model with its faces.
pub(crate) fn written(model: &Model) -> Vec<u8> {
    write(model, &vec![Drawing::Faces; model.parts.len()], Format::Glb, Layout::List).unwrap()
}

/// Returns a ribbon with a view for its indices.
pub(crate) fn ribbon(vertices: usize) -> Draft {
    let mut draft = Draft::new();
    let positions = draft.positions(&bent(vertices));
    let corners: Vec<u32> = (0..vertices as u32 - 2).flat_map(|i| [i, i + 1, i + 2]).collect();
    let indices = draft.indices(U16, &corners);
    draft.primitive(positions, Some(indices), 4);
    draft
}
