//! `tristrip verify`: proofs, differences, and their messages.

use std::fs;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::str::contains;
use serde_json::Value;

#[test]
fn the_same_faces_in_another_order_are_proven() {
    let dir = tempfile::tempdir().unwrap();
    let (source, result) = (dir.path().join("a.obj"), dir.path().join("b.obj"));
    fs::write(&source, SQUARE).unwrap();
    fs::write(&result, "v 1 1 0\nv 0 1 0\nv -0.0 0 0\nv 1 0 0\nf 3 1 2\nf 1 3 4\n").unwrap();
    let report = json(tristrip().args(["verify", "--json"]).arg(&source).arg(&result));
    let expected =
        ["source", "result", "seconds", "proven", "faces", "triangles", "difference", "notes", "error"];
    assert_eq!(keys(&report), expected);
    assert_eq!(keys(&report["seconds"]), ["load", "verify"]);
    assert_eq!((&report["proven"], &report["faces"]), (&Value::from(true), &Value::from(2)));
    tristrip()
        .arg("verify")
        .arg(&source)
        .arg(&result)
        .assert()
        .success()
        .stdout(contains("b.obj draws every face of"));
}

#[test]
fn missing_extra_and_flipped_triangles_are_counted_and_located() {
    let dir = tempfile::tempdir().unwrap();
    let (source, result) = (dir.path().join("a.obj"), dir.path().join("b.obj"));
    fs::write(&source, SQUARE).unwrap();
    fs::write(&result, SQUARE.replace("f 1 2 3", "f 3 2 1")).unwrap();
    let assert = tristrip().args(["verify", "--json"]).arg(&source).arg(&result).assert().code(1);
    let assert = assert.stderr(contains("not proven: triangles missing: 0, extra: 0, flipped: 1"));
    let report: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert_eq!(report["proven"], false);
    let difference = &report["difference"];
    assert_eq!(keys(difference), ["kind", "missing", "extra", "flipped", "face", "first"]);
    assert_eq!((&difference["kind"], &difference["flipped"]), (&Value::from("triangles"), &Value::from(1)));
    assert_eq!(difference["first"].as_array().unwrap().len(), 3);
}

#[test]
fn exactly_one_missing_triangle_has_no_plural_verb() {
    let dir = tempfile::tempdir().unwrap();
    let source = dir.path().join("a.obj");
    fs::write(&source, SQUARE).unwrap();
    let assert = tristrip()
        .arg("verify")
        .arg(&source)
        .arg(model("../issues/one_triangle_missing.obj"))
        .assert()
        .code(1);
    assert.stderr(contains("not proven: triangles missing: 1, extra: 0, flipped: 0; the first is at"));
}

#[test]
fn polygons_are_compared_by_their_boundaries() {
    let dir = tempfile::tempdir().unwrap();
    let (source, result) = (dir.path().join("a.obj"), dir.path().join("b.obj"));
    fs::write(&source, SQUARE.replace("f 1 2 3\nf 1 3 4", "f 1 2 3 4")).unwrap();
    for (faces, proven) in
        [("f 1 2 4\nf 2 3 4", true), ("f 4 1 2 3", true), ("f 1 2 4\nf 2 4 3", false), ("f 1 2 4", false)]
    {
        fs::write(&result, SQUARE.replace("f 1 2 3\nf 1 3 4", faces)).unwrap();
        let code = i32::from(!proven);
        tristrip().args(["verify", "-q"]).arg(&source).arg(&result).assert().code(code);
    }
}

#[test]
fn unreadable_files_are_reported_by_name() {
    tristrip()
        .args(["verify", "none.ply"])
        .arg(model("hand.ply"))
        .assert()
        .code(1)
        .stderr(contains("tristrip: none.ply: no such file or directory"));
    let assert =
        tristrip().args(["verify", "--json", "-q", "-", "none.obj"]).write_stdin(SQUARE).assert().code(1);
    let report: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert_eq!(report["error"], "none.obj: no such file or directory");
    assert_eq!(report["proven"], Value::Null);
}
