//! `tristrip strip --reorder-vertices`: vertices in the order of first use, with their attributes,
//! and the map to the old order.

#![allow(clippy::unwrap_used, reason = "a test may stop")]

use std::fs;
use std::path::Path;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;
use tristrip::AttributeData;
use tristrip_io::Model;

/// Strips a file with its vertices in the new order, and returns the report.
fn reordered(source: &Path, target: &Path, layout: &str) -> Value {
    let mut command = tristrip();
    command.args(["strip", "--json", "--reorder-vertices", "-m", "sequential", "--layout", layout]);
    json(command.arg(source).arg("-o").arg(target))
}

fn numbers(value: &Value) -> Vec<usize> {
    let numbers = value.as_array().into_iter().flatten().filter_map(Value::as_u64);
    numbers.map(|n| usize::try_from(n).unwrap()).collect()
}

fn load(path: &Path) -> Model {
    tristrip_io::read_path(path).unwrap()
}

/// Checks that the vertices of a file are those of its source under the map of the report,
/// including attributes; returns the number of moved vertices.
fn check_map(source: &Path, target: &Path, report: &Value) -> usize {
    assert_eq!((&report["proven"], &report["error"]), (&true.into(), &Value::Null));
    tristrip().arg("verify").arg(source).arg(target).assert().success();
    let (old, new) = (load(source), load(target));
    assert_eq!(old.parts.len(), new.parts.len());
    let mut moved = 0;
    for group in report["vertex_order"].as_array().unwrap() {
        assert_eq!(keys(group), ["parts", "vertices", "moved", "new_to_old", "kept"]);
        let map = numbers(&group["new_to_old"]);
        assert_eq!(group["vertices"], map.len());
        let changed = (0..).zip(&map).filter(|(new, old)| new != *old).count();
        assert_eq!((&group["moved"], &group["kept"]), (&changed.into(), &Value::Null));
        moved += changed;
        for part in numbers(&group["parts"]) {
            let (old, new) = (&old.parts[part].mesh, &new.parts[part].mesh);
            assert_eq!(new.vertex_count(), map.len());
            for (slot, &from) in map.iter().enumerate() {
                assert_eq!(new.positions()[slot].map(f32::to_bits), old.positions()[from].map(f32::to_bits));
            }
            let order = tristrip::VertexOrder::from_new_to_old(
                &map.iter().map(|&v| u32::try_from(v).unwrap()).collect::<Vec<_>>(),
            );
            let order = order.unwrap();
            assert_eq!(old.attributes().len(), new.attributes().len());
            let turns = [source, target].map(|path| path.extension().is_some_and(|ext| ext == "obj"));
            for (old, new) in old.attributes().iter().zip(new.attributes()) {
                let mut moved = order.attribute(old).unwrap().data;
                // In OBJ, textures begin at the bottom, in glTF at the top.
                if let (true, AttributeData::F32(uv)) =
                    (old.name == "TEXCOORD_0" && turns[0] != turns[1], &mut moved)
                {
                    uv.iter_mut().skip(1).step_by(2).for_each(|v| *v = 1.0 - *v);
                }
                assert_eq!(moved, new.data, "{}", old.name);
            }
        }
    }
    moved
}

#[test]
fn ply_keeps_columns_and_colours_with_their_vertices() {
    let dir = tempfile::tempdir().unwrap();
    let (source, target) = (dir.path().join("a.ply"), dir.path().join("b.ply"));
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 7\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\nproperty double quality\nproperty int label\nelement face 3\n\
         property list uchar int vertex_indices\nend_header\n",
    );
    for i in 0..7 {
        text.push_str(
            &[i.to_string(), (i * i).to_string(), format!("0.5 {} 9 8 {i}.125 -{i}\n", 30 * i)].join(" "),
        );
    }
    text.push_str("3 6 2 4\n3 4 2 1\n3 1 2 5\n");
    fs::write(&source, text).unwrap();
    for layout in ["restart", "degenerate", "separate", "list"] {
        let report = reordered(&source, &target, layout);
        assert!(check_map(&source, &target, &report) > 3);
        // Two vertices are not in any strip: they come last, in their old order.
        let map = numbers(&report["vertex_order"][0]["new_to_old"]);
        assert_eq!(map[5..], [0, 3], "{layout}");
        assert_eq!(load(&target).parts[0].mesh.attributes().len(), 3);
        assert_eq!(report["layout"], layout);
    }
}

#[test]
fn obj_keeps_seams_and_normals_with_their_vertices() {
    let dir = tempfile::tempdir().unwrap();
    let (source, target) = (dir.path().join("a.obj"), dir.path().join("b.glb"));
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nv 1 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\nvn 1 0 0\nusemtl a\n\
        f 4/4/1 6/2/1 5/3/2\nf 4/4/1 3/3/1 6/2/1\nusemtl b\nf 1/1/2 2/2/2 3/3/2\nf 1/1/1 3/3/2 4/4/1\n";
    fs::write(&source, text).unwrap();
    let report = reordered(&source, &target, "degenerate");
    assert!(check_map(&source, &target, &report) > 2);
    assert_eq!(report["vertex_order"].as_array().unwrap().len(), 2);
    // OBJ has a vertex per corner, in the order of the triangles.
    let target = dir.path().join("b.obj");
    let report = reordered(&source, &target, "list");
    tristrip().arg("verify").arg(&source).arg(&target).assert().success();
    let text = fs::read_to_string(&target).unwrap();
    let mut next = 1;
    for corner in text.lines().filter_map(|line| line.strip_prefix("f ")).flat_map(|line| line.split(' ')) {
        let [v, vt, vn]: [usize; 3] =
            corner.split('/').map(|n| n.parse().unwrap()).collect::<Vec<_>>().try_into().unwrap();
        assert!(v <= next && v == vt && v == vn, "{corner} after {next}");
        next = next.max(v + 1);
    }
    let all: usize =
        report["vertex_order"].as_array().unwrap().iter().map(|g| numbers(&g["new_to_old"]).len()).sum();
    assert_eq!(next, all + 1);
}

#[test]
fn scenes_keep_everything_except_the_order() {
    let dir = tempfile::tempdir().unwrap();
    for layout in ["degenerate", "restart", "list"] {
        let target = dir.path().join(format!("{layout}.glb"));
        let report = reordered(&model("milktruck.glb"), &target, layout);
        assert!(check_map(&model("milktruck.glb"), &target, &report) > 2900);
        assert_eq!(report["vertex_order"].as_array().unwrap().len(), 4);
    }
    // The same scene, except for indices, modes and the order of vertices.
    let document = |path: &Path| -> Value {
        let glb = fs::read(path).unwrap();
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap());
        serde_json::from_slice(&glb[20..20 + usize::try_from(length).unwrap()]).unwrap()
    };
    let (old, new) = (document(&model("milktruck.glb")), document(&dir.path().join("list.glb")));
    for key in ["nodes", "materials", "textures", "images", "scenes", "animations", "samplers"] {
        assert_eq!(old[key], new[key], "{key}");
    }
}

#[test]
fn misses_and_strips_are_the_same_in_any_order() {
    let dir = tempfile::tempdir().unwrap();
    let target = dir.path().join("hand.ply");
    let plain = json(tristrip().args(["strip", "--json", "-m", "sequential"]).arg(model("hand.ply")));
    assert_eq!(plain["vertex_order"], Value::Null);
    let report = reordered(&model("hand.ply"), &target, "restart");
    assert!(check_map(&model("hand.ply"), &target, &report) > 0);
    // The strips of the file as stored.
    let again = json(tristrip().args(["strip", "--json", "-m", "sequential"]).arg(&target));
    for key in [
        "triangles",
        "strips",
        "vertices_sent",
        "indices_restart",
        "acmr_fifo_16",
        "acmr_fifo_32",
        "atvr_fifo_16",
    ] {
        assert_eq!(plain[key], report[key], "{key}");
    }
    assert_eq!(plain["triangles"], again["triangles"]);
    // The file ends with the row of strips: the first uses are 0, 1, 2 and so on.
    let bytes = fs::read(&target).unwrap();
    let length = usize::try_from(report["indices_restart"].as_u64().unwrap()).unwrap();
    let row =
        bytes[bytes.len() - 4 * length..].chunks_exact(4).map(|b| i32::from_le_bytes(b.try_into().unwrap()));
    let (mut next, mut found) = (0, tristrip::Strips::default());
    let mut strip = Vec::new();
    for vertex in row.chain([-1]) {
        if vertex == -1 {
            found.push(&strip);
            strip.clear();
            continue;
        }
        assert!(vertex <= next, "{vertex} before {next}");
        next = next.max(vertex + 1);
        strip.push(u32::try_from(vertex).unwrap());
    }
    let misses = tristrip::vertex_cache::VertexCacheStatistics::of(
        &found,
        tristrip::vertex_cache::VertexCache::fifo(16),
        tristrip::vertex_cache::FlushPolicy::Keep,
    );
    let close = |key: &str, found: f64| (report[key].as_f64().unwrap() - found).abs() < 1e-6;
    assert!(close("acmr_fifo_16", misses.acmr()) && close("atvr_fifo_16", misses.atvr()));
}

#[test]
fn the_joined_strip_keeps_its_length() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["wingnut.ply", "self_intersect_a.ply"] {
        let target = dir.path().join("a.ply");
        let report = reordered(&model(name), &target, "degenerate");
        let bytes = fs::read(&target).unwrap();
        let length = usize::try_from(report["indices_degenerate"].as_u64().unwrap()).unwrap();
        let row = bytes[bytes.len() - 4 * length..]
            .chunks_exact(4)
            .map(|b| u32::from_le_bytes(b.try_into().unwrap()));
        let mut next = 0;
        for vertex in row {
            assert!(vertex <= next, "{name}: {vertex} before {next}");
            next = next.max(vertex + 1);
        }
        let mesh = &report["mesh"];
        let used = mesh["vertices"].as_u64().unwrap() - mesh["unreferenced_vertices"].as_u64().unwrap();
        assert_eq!(u64::from(next), used, "{name}");
    }
}

#[test]
fn empty_and_small_models_are_accepted() {
    let dir = tempfile::tempdir().unwrap();
    let empty = dir.path().join("empty.ply");
    let header = "ply\nformat ascii 1.0\nelement vertex N\nproperty float x\nproperty float y\nproperty float z\n\
        element face 0\nproperty list uchar int vertex_indices\nend_header\n";
    for (count, rows) in [("0", ""), ("2", "0 0 0\n1 2 3\n")] {
        fs::write(&empty, header.replace('N', count) + rows).unwrap();
        for (target, layout) in [("a.ply", "restart"), ("a.glb", "degenerate"), ("b.glb", "separate")] {
            let report = reordered(&empty, &dir.path().join(target), layout);
            assert_eq!(report["vertex_order"][0]["moved"], 0);
            assert_eq!(numbers(&report["vertex_order"][0]["new_to_old"]).len().to_string(), count);
        }
    }
    let mut command = tristrip();
    command
        .args(["strip", "-", "--reorder-vertices", "-o"])
        .arg(dir.path().join("b.ply"))
        .write_stdin(SQUARE);
    command
        .assert()
        .success()
        .stderr(contains("reorder ").and(contains("of 4 vertices into the order of first use")));
}

#[test]
fn vertices_unused_after_welding_come_last() {
    let dir = tempfile::tempdir().unwrap();
    let (source, target) = (dir.path().join("seam.obj"), dir.path().join("seam.ply"));
    fs::write(&source, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n").unwrap();
    let mut command = tristrip();
    command.args(["strip", "--json", "--weld", "--reorder-vertices"]).arg(&source).arg("-o").arg(&target);
    let report = json(&mut command);
    assert_eq!(numbers(&report["vertex_order"][0]["new_to_old"])[4..], [3, 4]);
    assert_eq!(load(&target).parts[0].mesh.vertex_count(), 6);
}

#[test]
fn parts_that_keep_their_order_are_reported() {
    let dir = tempfile::tempdir().unwrap();
    let (source, target) = (dir.path().join("a.gltf"), dir.path().join("a.glb"));
    // A triangle whose first vertex has the last number, and points that use the same vertices.
    let text = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1},
        {"attributes":{"POSITION":0},"mode":0}]}],"buffers":[{"byteLength":39,"uri":"a.bin"}],
        "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":3}],"accessors":[
        {"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
        {"bufferView":1,"componentType":5121,"count":3,"type":"SCALAR"}]}"#;
    let mut bin: Vec<u8> =
        [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    bin.extend([2, 0, 1]);
    fs::write(&source, text).unwrap();
    fs::write(dir.path().join("a.bin"), bin).unwrap();
    let report = reordered(&source, &target, "degenerate");
    let why = "points or lines use the same vertices";
    assert_eq!(report["vertex_order"][0]["kept"], why);
    assert!(report["notes"].to_string().contains(&format!("vertices not reordered in 1 part: {why}")));
    assert_eq!(numbers(&report["vertex_order"][0]["new_to_old"]), [0, 1, 2]);
    tristrip().arg("verify").arg(&source).arg(&target).assert().success();
    // PLY has no points, so the vertices can be reordered.
    let report = reordered(&source, &dir.path().join("a.ply"), "restart");
    assert_eq!(report["vertex_order"][0]["kept"], Value::Null);
}

#[test]
fn any_number_of_threads_gives_the_same_order() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = |threads: &str| {
        let path = dir.path().join(format!("{threads}.glb"));
        let mut command = tristrip();
        command.args(["strip", "-q", "--reorder-vertices", "--threads", threads]).arg(model("milktruck.glb"));
        command.arg("-o").arg(&path).assert().success();
        fs::read(path).unwrap()
    };
    let one = bytes("1");
    assert!(one == bytes("2") && one == bytes("7"));
}
