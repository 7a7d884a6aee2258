//! `tristrip build-lod`: a view-dependent LOD model in one file.

use std::fs;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::{contains, is_empty};
use serde_json::Value;
use tristrip_io::tlod::{TlodLimits, TlodModel, read};

fn open(path: &std::path::Path) -> TlodModel {
    let file = fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    read(file, &TlodLimits::default()).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn the_file_holds_the_mesh_its_strips_and_its_collapses() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("fish.tlod");
    let build = |order: &str| {
        let mut command = tristrip();
        command.args(["build-lod", "--json", "--order", order]).arg(model("fish_control.ply"));
        json(command.arg("-o").arg(&path))
    };
    let report = build("quadric");
    let expected = [
        "file",
        "seconds",
        "method",
        "cost",
        "effort",
        "seed",
        "order",
        "proven",
        "vertices",
        "triangles",
        "strips",
        "collapses",
        "levels",
        "stopped",
        "parts",
        "notes",
        "height",
        "bytes",
        "output",
        "error",
    ];
    assert_eq!(keys(&report), expected);
    assert_eq!(keys(&report["seconds"]), ["load", "dual", "stripify", "collapse", "verify", "write"]);
    assert_eq!((&report["proven"], &report["error"]), (&Value::from(true), &Value::Null));
    let read = open(&path);
    let counts = ["vertices", "triangles", "strips", "collapses", "bytes"].map(|key| report[key].as_u64());
    let found = [
        read.mesh.vertex_count(),
        read.mesh.faces().face_count(),
        read.strips.len(),
        read.sequence.len(),
        fs::metadata(&path).unwrap().len() as usize,
    ];
    assert_eq!(counts, found.map(|count| Some(count as u64)));
    assert_eq!((read.mesh.vertex_count(), read.mesh.faces().face_count()), (112, 220));
    // The same input gives the same bytes; another order gives other collapses.
    let bytes = fs::read(&path).unwrap();
    build("quadric");
    assert!(fs::read(&path).unwrap() == bytes);
    assert_eq!(build("shortest-edge")["order"], "shortest-edge");
    assert!(open(&path).sequence != read.sequence);
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
}

#[test]
fn stages_go_to_standard_error_and_the_table_to_standard_output() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("square.tlod");
    let mut command = tristrip();
    command.args(["build-lod", "-", "--method", "sgi", "-o"]).arg(&path).write_stdin(SQUARE);
    let stages = contains("stripify")
        .and(contains("(method sgi, "))
        .and(contains("proven: the file contains the same model"));
    command.assert().success().stdout(contains("levels of the merge tree")).stderr(stages);
    assert_eq!(open(&path).strips.len(), 1);
    let mut quiet = tristrip();
    quiet.args(["build-lod", "-q", "-", "-o"]).arg(&path).write_stdin(SQUARE);
    quiet.assert().success().stdout(is_empty()).stderr(is_empty());
}

#[test]
fn the_parts_of_a_scene_become_one_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("truck.tlod");
    let mut command = tristrip();
    let report = json(command.args(["build-lod", "--json"]).arg(model("milktruck.glb")).arg("-o").arg(&path));
    assert_eq!((&report["parts"], &report["triangles"]), (&Value::from(4), &Value::from(2856)));
    let notes = report["notes"].to_string();
    for note in [
        "not written: nodes with a transform: 4",
        "parts joined into one: 4",
        "attributes dropped that not all parts have with the same type: TEXCOORD_0",
    ] {
        assert!(notes.contains(note), "{notes}");
    }
    let mesh = open(&path).mesh;
    assert_eq!(mesh.attributes().iter().map(|attribute| &attribute.name[..]).collect::<Vec<_>>(), ["NORMAL"]);
}

#[test]
fn failures_leave_the_old_file() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("old.tlod");
    fs::write(&path, "old").unwrap();
    let mut command = tristrip();
    command.args(["build-lod", "--json", "no.ply", "-o"]).arg(&path);
    let assert = command.assert().code(1).stderr(contains("no.ply: no such file"));
    let report: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert_eq!(
        (&report["output"], &report["error"]),
        (&Value::Null, &Value::from("no such file or directory"))
    );
    assert_eq!(fs::read(&path).unwrap(), b"old");
    let mut command = tristrip();
    command.args(["build-lod", "-", "-o"]).arg(dir.path().join("none/a.tlod")).write_stdin(SQUARE);
    command.assert().code(1).stderr(contains("a.tlod: no such file"));
}

#[test]
fn flags_that_do_not_fit_are_wrong_usage() {
    for (flags, message) in [
        (&["a.ply", "-o", "a.glb"][..], "a.glb: build-lod writes .tlod; use this extension"),
        (&["a.ply", "-o", "-"], "-: build-lod writes .tlod; use this extension"),
        (&["a.ply", "-o", "a.tlod", "--weld"], "--weld cannot be used with build-lod"),
        (&["a.ply", "-o", "a.tlod", "-m", "best:cutoff=5"], "found `cutoff` in `best:cutoff=5`"),
        (&["a.ply", "-o", "a.tlod", "--order", "none"], "possible values: quadric, shortest-edge"),
        (&["a.ply"], "--output <OUTPUT>"),
        (&["a.ply", "b.ply", "-o", "a.tlod"], "unexpected argument 'b.ply'"),
    ] {
        tristrip().arg("build-lod").args(flags).assert().code(2).stdout(is_empty()).stderr(contains(message));
    }
}

#[test]
fn a_tlod_file_is_no_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("fish.tlod");
    let source = model("fish_control.ply");
    tristrip().args(["build-lod", "-m", "stripe"]).arg(&source).arg("-o").arg(&path).assert().success();
    let renamed = dir.path().join("fish.ply");
    fs::copy(&path, &renamed).unwrap();
    for input in [&renamed, &path] {
        let refused = tristrip().arg("strip").arg(input).assert().code(1);
        refused.stderr(contains("found a view-dependent .tlod model, expected a mesh or a scene"));
    }
}
