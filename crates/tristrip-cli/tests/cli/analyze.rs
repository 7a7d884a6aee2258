//! `tristrip analyze`: lists, every layout of strips, fans, scenes, vertex caches, the chart, and
//! bad inputs.

use std::fs;
use std::path::{Path, PathBuf};

use super::{SQUARE, json, keys, model, tristrip};
use predicates::prelude::*;
use predicates::str::{contains, is_empty};
use serde_json::Value;

const KEYS: [&str; 21] = [
    "file",
    "seconds",
    "drawn",
    "triangles",
    "vertices",
    "indices",
    "restarts",
    "degenerate",
    "strips",
    "isolated",
    "swaps",
    "vertices_sent",
    "indices_per_triangle",
    "lengths",
    "flushed",
    "vertex_caches",
    "parts",
    "by_part",
    "notes",
    "plot",
    "error",
];

fn analyze(file: &Path, flags: &[&str]) -> Value {
    json(tristrip().args(["analyze", "--json"]).args(flags).arg(file))
}

fn figure(report: &Value, key: &str) -> u64 {
    report[key].as_u64().unwrap_or_else(|| panic!("{key}: {}", report[key]))
}

fn misses(report: &Value, cache: &str) -> u64 {
    let row =
        report["vertex_caches"].as_array().into_iter().flatten().find(|row| row["vertex_cache"] == cache);
    figure(row.unwrap_or_else(|| panic!("no {cache}: {report}")), "misses")
}

/// Writes strips of the hand in a layout; returns the path and the report of `strip`.
fn hand(dir: &Path, layout: &str, extension: &str) -> (PathBuf, Value) {
    let path = dir.join(format!("{layout}.{extension}"));
    let mut command = tristrip();
    command.args(["strip", "--json", "-m", "sequential", "--layout", layout, "-o"]).arg(&path);
    let report = json(command.arg(model("hand.ply")));
    (path, report)
}

#[test]
fn json_has_the_documented_keys_in_order() {
    let report = analyze(&model("milktruck.glb"), &[]);
    assert_eq!(keys(&report), KEYS);
    assert_eq!(keys(&report["seconds"]), ["load", "analyze"]);
    assert_eq!(keys(&report["vertex_caches"][0]), ["vertex_cache", "misses", "acmr", "atvr"]);
    let part = [&["name", "material"], &KEYS[2..12], &["misses"]].concat();
    assert_eq!(keys(&report["by_part"][0]), part);
}

#[test]
fn triangle_lists_and_polygons_are_drawn_as_a_list() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("square.obj");
    fs::write(&path, SQUARE).unwrap();
    let report = analyze(&path, &["--vertex-caches", "fifo:1,lru:2..3"]);
    assert_eq!((&report["drawn"], &report["strips"]), (&Value::from("list"), &Value::Null));
    assert_eq!(["triangles", "vertices", "indices"].map(|key| figure(&report, key)), [2, 4, 6]);
    // 0 1 2 0 2 3
    assert_eq!(["fifo:1", "lru:2", "lru:3"].map(|cache| misses(&report, cache)), [6, 5, 4]);
    assert_eq!(
        (&report["vertex_caches"][2]["acmr"], &report["vertex_caches"][2]["atvr"]),
        (&2.0.into(), &1.0.into())
    );
    assert_eq!(report["lengths"], Value::Array(Vec::new()));
    fs::write(&path, SQUARE.replace("f 1 2 3\nf 1 3 4", "f 1 2 3 4\nf 1 1 2")).unwrap();
    let polygons = analyze(&path, &[]);
    assert_eq!(["triangles", "indices", "degenerate"].map(|key| figure(&polygons, key)), [2, 9, 1]);
    let assert = tristrip().arg("analyze").arg(&path).assert().success();
    assert
        .stdout(contains("drawn as a list").and(contains("fifo:16")).and(contains("strips by number").not()));
}

#[test]
fn every_layout_is_analyzed_as_written() {
    let dir = tempfile::tempdir().unwrap();
    for extension in ["glb", "ply"] {
        let (path, written) = hand(dir.path(), "restart", extension);
        let restart = analyze(&path, &[]);
        for key in ["triangles", "strips", "isolated", "swaps", "vertices_sent"] {
            assert_eq!(restart[key], written[key], "{extension} {key}");
        }
        assert_eq!(restart["indices"], written["indices_restart"]);
        assert_eq!(figure(&restart, "restarts"), figure(&written, "strips") - 1);
        assert_eq!(figure(&restart, "degenerate"), figure(&written, "swaps"));
        assert_eq!(restart["vertex_caches"][1]["acmr"], written["acmr_fifo_16"]);
        assert_eq!(restart["vertex_caches"][3]["atvr"], written["atvr_fifo_32"]);
        let bins = restart["lengths"].as_array().unwrap();
        let sum = |key| bins.iter().map(|bin| figure(bin, key)).sum::<u64>();
        assert_eq!(
            (sum("strips"), sum("triangles")),
            (figure(&restart, "strips"), figure(&restart, "triangles"))
        );
        assert_eq!(keys(&bins[0]), ["from", "to", "strips", "triangles"]);

        let (path, written) = hand(dir.path(), "degenerate", extension);
        let joined = analyze(&path, &[]);
        assert_eq!(
            (&joined["strips"], &joined["indices"]),
            (&written["strips"], &written["indices_degenerate"])
        );
        assert_eq!((figure(&joined, "restarts"), &joined["lengths"]), (0, &restart["lengths"]));

        let (path, _) = hand(dir.path(), "separate", extension);
        let separate = analyze(&path, &["--flush"]);
        for key in ["triangles", "strips", "swaps", "vertices_sent", "lengths"] {
            assert_eq!(separate[key], restart[key], "{extension} {key}");
        }
        let flushed = analyze(&dir.path().join(format!("restart.{extension}")), &["--flush"]);
        assert_eq!(flushed["vertex_caches"], separate["vertex_caches"]);
        assert!(misses(&flushed, "fifo:16") > misses(&restart, "fifo:16"));
        assert_eq!((&flushed["flushed"], &restart["flushed"]), (&true.into(), &false.into()));

        let (path, _) = hand(dir.path(), "list", extension);
        assert_eq!(analyze(&path, &[])["drawn"], "list");
    }
}

#[test]
fn figures_are_sums_over_primitives() {
    let report = analyze(&model("milktruck.glb"), &["--vertex-caches", "lru:4..9"]);
    let parts = report["by_part"].as_array().unwrap();
    assert_eq!(figure(&report, "parts"), parts.len() as u64);
    assert!(parts.len() > 1);
    for key in ["triangles", "indices"] {
        assert_eq!(figure(&report, key), parts.iter().map(|part| figure(part, key)).sum::<u64>());
    }
    for (i, row) in report["vertex_caches"].as_array().unwrap().iter().enumerate() {
        let of_parts = parts.iter().map(|part| part["misses"][i].as_u64().unwrap());
        assert_eq!(figure(row, "misses"), of_parts.sum::<u64>());
    }
    let assert = tristrip().arg("analyze").arg(model("milktruck.glb")).assert().success();
    assert.stdout(contains("Wheels / wheels").and(contains("drawn as")));
}

#[test]
fn fans_are_analyzed_as_fans() {
    // Five vertices; indices 0 1 2 3, a restart, 0 3 4.
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAACAvwAAgD8AAAAAAAECA/8AAwQ=";
    let scene = format!(
        r#"{{"asset": {{"version": "2.0"}},
        "buffers": [{{"byteLength": 68, "uri": "data:application/octet-stream;base64,{data}"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 60}}, {{"buffer": 0, "byteOffset": 60, "byteLength": 8}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 5,
                       "min": [-1, 0, 0], "max": [1, 1, 0]}},
                      {{"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 8}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "indices": 1, "mode": 6}},
                                   {{"attributes": {{"POSITION": 0}}, "mode": 5}}]}}]}}"#
    );
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("fan.gltf");
    fs::write(&path, scene).unwrap();
    let report = analyze(&path, &["--vertex-caches", "fifo:2"]);
    assert_eq!((&report["drawn"], &report["vertices"]), (&"mixed".into(), &5.into()));
    let [fan, strip] = [0, 1].map(|i| &report["by_part"][i]);
    assert_eq!(
        (&fan["drawn"], &fan["strips"], &strip["drawn"]),
        (&"fans".into(), &Value::Null, &"strips".into())
    );
    let keys = ["triangles", "indices", "restarts", "degenerate"];
    assert_eq!(keys.map(|key| figure(fan, key)), [3, 8, 1, 0]);
    assert_eq!(keys.map(|key| figure(strip, key)), [3, 5, 0, 0]);
    // 0 1 2 3, then 0 (evicted, a miss), 3 (a hit) and 4.
    assert_eq!((&fan["misses"], &strip["misses"]), (&vec![6].into(), &vec![5].into()));
    assert_eq!(report["vertex_caches"][0]["acmr"], 1.833_333);
}

#[test]
fn a_chart_is_drawn() {
    let dir = tempfile::tempdir().unwrap();
    let (path, _) = hand(dir.path(), "restart", "glb");
    let chart = dir.path().join("caches.svg");
    let mut command = tristrip();
    command.args(["analyze", "--json", "--plot"]).arg(&chart).arg(&path).arg(model("hand.ply"));
    let reports = json(&mut command);
    assert_eq!(reports[1]["plot"], chart.display().to_string());
    let text = fs::read_to_string(&chart).unwrap();
    assert!(text.starts_with("<svg width=\"900\""));
    for words in ["hand.ply, FIFO", "restart.glb, LRU", "each vertex once", "Lengths of strips: restart.glb"]
    {
        assert!(text.contains(words), "{words}");
    }
    command.assert().success();
    assert_eq!(fs::read_to_string(&chart).unwrap(), text);
    // A list has no strip lengths.
    let mut command = tristrip();
    command.args(["analyze", "--vertex-caches", "fifo:4..9", "--plot"]).arg(&chart).arg(model("hand.ply"));
    command.assert().success();
    let text = fs::read_to_string(&chart).unwrap();
    assert!(text.contains("FIFO") && !text.contains("LRU") && !text.contains("Lengths"));
}

#[test]
fn a_chart_that_cannot_be_written_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("none/caches.svg");
    let mut command = tristrip();
    command.args(["analyze", "--json", "-q", "--plot"]).arg(&chart).arg(model("fish_control.ply"));
    let assert = command.assert().code(1).stderr(contains("caches.svg: no such file or directory"));
    let report: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert!(report["error"].as_str().unwrap().contains("caches.svg"));
    assert_eq!(report["plot"], Value::Null);
    assert!(figure(&report, "triangles") > 0);
}

#[test]
fn bad_inputs_are_reported_and_the_others_processed() {
    let dir = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let whole = fs::read(model("milktruck.glb")).unwrap();
    let bad = [
        file("empty.ply", b""),
        file("cut.glb", &whole[..whole.len() / 2]),
        file("nan.obj", SQUARE.replacen("0 0 0", "nan 0 0", 1).as_bytes()),
        file("outside.obj", SQUARE.replace("f 1 3 4", "f 1 3 9").as_bytes()),
        dir.path().to_owned(),
        dir.path().join("none.ply"),
    ];
    let chart = dir.path().join("a.svg");
    for path in &bad {
        let mut command = tristrip();
        command.args(["analyze", "--json", "--plot"]).arg(&chart).arg(path).arg(model("fish_control.ply"));
        let assert = command.assert().code(1).stderr(contains("tristrip: "));
        let reports: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
        assert_eq!(keys(&reports[0]), ["file", "seconds", "error"]);
        assert!(reports[0]["error"].is_string());
        assert!(reports[1]["error"].is_null() && reports[1]["plot"].is_string());
        let assert = tristrip().args(["analyze", "-q"]).arg(path).assert().code(1);
        assert.stdout(is_empty());
    }
}

#[test]
fn the_figures_of_a_file_without_faces_are_zero() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("points.obj");
    fs::write(&path, "v 0 0 0\nv 1 0 0\n").unwrap();
    let chart = dir.path().join("a.svg");
    let report = json(tristrip().args(["analyze", "--json", "--plot"]).arg(&chart).arg(&path));
    assert_eq!(["triangles", "vertices", "indices"].map(|key| figure(&report, key)), [0; 3]);
    assert!(report["vertex_caches"].as_array().unwrap().iter().all(|row| row["acmr"] == 0.0));
    tristrip().args(["analyze", "-"]).write_stdin(SQUARE).assert().success().stdout(contains("fifo:16"));
}
