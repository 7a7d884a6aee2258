//! Scenes with fewer triangles, and a naive comparison with the original.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;
use tristrip::Layout;
use tristrip_io::{Drawing, Format, Redrawn, gltf, with_triangles, write};

use crate::gltf_documents::scenes::raw;
use crate::gltf_documents::{F32, bin_of, json_of, view_bytes};

/// Keeps the triangles of each part that `keep` accepts by part and index, writes the scene, and
/// checks it.
pub(crate) fn shrunk(glb: &[u8], keep: impl Fn(usize, usize) -> bool) -> (Redrawn, Vec<u8>) {
    let model = gltf::read(glb, None).unwrap();
    let triangles = model.parts.iter().enumerate().map(|(part, one)| {
        let corners = one.mesh.faces().as_triangles().unwrap();
        let kept = corners.chunks(3).enumerate().filter(|&(t, _)| keep(part, t));
        kept.flat_map(|(_, t)| t.to_vec()).collect()
    });
    let triangles: Vec<Vec<u32>> = triangles.collect();
    let redrawn = with_triangles(&model, triangles.clone(), Format::Glb).unwrap();
    let drawings = vec![Drawing::Faces; triangles.len()];
    let after = write(&redrawn.model, &drawings, Format::Glb, Layout::List).unwrap();
    check(glb, &after, &triangles);
    (redrawn, after)
}

pub(crate) fn number(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

/// Returns the values of an integer accessor.
pub(crate) fn indices(glb: &[u8], accessor: &Value) -> Vec<usize> {
    raw(glb, number(accessor))
        .iter()
        .map(|b| b.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b)))
        .collect()
}

/// Returns the accessors with a value per vertex of a primitive.
pub(crate) fn vertex_accessors(primitive: &Value) -> Vec<usize> {
    let objects = primitive["targets"].as_array().into_iter().flatten().chain([&primitive["attributes"]]);
    objects.flat_map(|object| object.as_object().unwrap().values().map(number)).collect()
}

/// Checks a written scene against the original and the triangles of each part, using only the
/// bytes: every corner keeps its values of every accessor; points, lines, images and all other
/// accessors are the same; bounds are exact.
pub(crate) fn check(before: &[u8], after: &[u8], triangles: &[Vec<u32>]) {
    let (old, new) = (json_of(before), json_of(after));
    let old_accessors = old["accessors"].as_array().unwrap();
    let mut values: BTreeMap<usize, [Vec<Vec<u8>>; 2]> = BTreeMap::new();
    for accessor in 0..old_accessors.len() {
        values.insert(accessor, [raw(before, accessor), raw(after, accessor)]);
    }
    let (mut of_vertices, mut of_indices) = (BTreeSet::new(), BTreeSet::new());
    let mut part = 0;
    for (old, new) in old["meshes"].as_array().unwrap().iter().zip(new["meshes"].as_array().unwrap()) {
        let primitives = [old, new].map(|mesh| mesh["primitives"].as_array().unwrap());
        assert_eq!(primitives[0].len(), primitives[1].len());
        for (old, new) in primitives[0].iter().zip(primitives[1]) {
            assert_eq!((&old["attributes"], &old["targets"]), (&new["attributes"], &new["targets"]));
            of_indices.extend(old["indices"].as_u64().map(|accessor| accessor as usize));
            let drawn_before: Vec<usize> = if old["mode"].as_u64().is_some_and(|mode| mode < 4) {
                let all = || (0..number(&new_count(&values, old))).collect();
                old["indices"].as_u64().map_or_else(all, |_| indices(before, &old["indices"]))
            } else {
                assert!(new["mode"].as_u64().is_none_or(|mode| mode == 4));
                part += 1;
                let corners = &triangles[part - 1];
                // A part without triangles draws a degenerate one.
                if corners.is_empty() { Vec::new() } else { corners.iter().map(|&v| v as usize).collect() }
            };
            let drawn_after: Vec<usize> = match new["indices"].as_u64() {
                Some(_) => indices(after, &new["indices"]),
                None => (0..drawn_before.len()).collect(),
            };
            if drawn_before.is_empty() {
                assert!(drawn_after.iter().all(|&v| v == 0));
            } else {
                assert_eq!(drawn_before.len(), drawn_after.len());
            }
            for accessor in vertex_accessors(old) {
                of_vertices.insert(accessor);
                let [old, new] = &values[&accessor];
                for (before, after) in drawn_before.iter().zip(&drawn_after) {
                    assert_eq!(old.get(*before), new.get(*after), "accessor {accessor}, vertex {before}");
                }
            }
        }
    }
    for (accessor, [before, after]) in &values {
        if !of_vertices.contains(accessor) && !of_indices.contains(accessor) {
            assert_eq!(before, after, "accessor {accessor}");
        }
        let object = &new["accessors"][accessor];
        assert_eq!(object["type"], old_accessors[*accessor]["type"]);
        if of_vertices.contains(accessor) && object.get("min").is_some() && object["componentType"] == F32 {
            let all: Vec<Vec<f32>> = after
                .iter()
                .map(|value| value.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect())
                .collect();
            for (axis, bound) in object["min"].as_array().unwrap().iter().enumerate() {
                let low = all.iter().map(|value| value[axis]).fold(f32::INFINITY, f32::min);
                let high = all.iter().map(|value| value[axis]).fold(f32::NEG_INFINITY, f32::max);
                let max = &object["max"][axis];
                assert!(
                    bound.as_f64() == Some(low.into()) && max.as_f64() == Some(high.into()),
                    "{accessor}"
                );
            }
        }
    }
    let image = |glb: &[u8], json: &Value, image: &Value| {
        image["bufferView"].as_u64().map(|view| view_bytes(json, bin_of(glb), view as usize).to_vec())
    };
    let images = |glb, json: &Value| -> Vec<_> {
        json["images"].as_array().into_iter().flatten().map(|one| image(glb, json, one)).collect()
    };
    assert_eq!(images(before, &old), images(after, &new));
    for key in ["nodes", "scenes", "skins", "animations", "materials", "extensions", "extras", "images"] {
        assert_eq!(old.get(key), new.get(key));
    }
}

/// Returns the number of vertices of a primitive that draws all of them.
pub(crate) fn new_count(values: &BTreeMap<usize, [Vec<Vec<u8>>; 2]>, primitive: &Value) -> Value {
    values[&number(&primitive["attributes"]["POSITION"])][0].len().into()
}

pub(crate) fn count_of(glb: &[u8], accessor: usize) -> usize {
    number(&json_of(glb)["accessors"][accessor]["count"])
}
