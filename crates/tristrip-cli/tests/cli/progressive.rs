//! `tristrip pack`, `unpack`, `inspect`: progressive GLB.

use std::fs;
use std::path::{Path, PathBuf};

use super::{SQUARE, json, keys, model, tristrip};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;

/// Packs a test model into a directory.
fn packed(name: &str, dir: &Path) -> PathBuf {
    let path = dir.join(name).with_extension("glb");
    tristrip().args(["pack", "--quiet"]).arg(model(name)).arg("-o").arg(&path).assert().success();
    path
}

/// Packing an OBJ builds a scene first, which once replaced the notes of the reader.
#[test]
fn packing_keeps_the_notes_of_the_reader_and_its_own() {
    let dir = tempfile::tempdir().unwrap();
    let (source, path) = (dir.path().join("square.obj"), dir.path().join("square.glb"));
    fs::write(&source, format!("vn 0 0 1\n{SQUARE}")).unwrap();
    let report = json(tristrip().args(["pack", "--json"]).arg(&source).arg("-o").arg(&path));
    let notes: Vec<&str> = report["notes"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(notes[0], "unused normals dropped: 1");
    assert!(notes.len() > 1, "{notes:?}");
    let printed = tristrip().arg("pack").arg(&source).arg("-o").arg(&path).assert().success();
    notes.iter().fold(printed, |printed, note| printed.stderr(contains(*note).count(1)));
}

#[test]
fn a_packed_file_is_read_by_all_subcommands() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("fish.glb");
    let report =
        json(tristrip().args(["pack", "--json"]).arg(model("fish_control.ply")).arg("-o").arg(&path));
    let expected = [
        "file",
        "seconds",
        "proven",
        "parts",
        "meshes",
        "chunks",
        "vertices",
        "triangles",
        "base_triangles",
        "bytes",
        "base_bytes",
        "bits_per_vertex",
        "position_error",
        "notes",
        "output",
        "error",
    ];
    assert_eq!(keys(&report), expected);
    assert_eq!(keys(&report["seconds"]), ["load", "pack", "write"]);
    assert_eq!((&report["proven"], &report["triangles"]), (&Value::from(true), &Value::from(220)));
    assert_eq!(report["bytes"], fs::metadata(&path).unwrap().len());
    assert!(report["base_triangles"].as_u64() < Some(220));
    let strip = json(tristrip().args(["strip", "--json"]).arg(&path));
    assert_eq!(strip["mesh"]["faces"], 220);
    // The same bytes again, with any number of threads.
    let again = dir.path().join("again.glb");
    tristrip()
        .args(["pack", "--threads", "1"])
        .arg(model("fish_control.ply"))
        .arg("-o")
        .arg(&again)
        .assert()
        .success();
    assert!(fs::read(&path).unwrap() == fs::read(&again).unwrap());
}

#[test]
fn levels_are_unpacked() {
    let dir = tempfile::tempdir().unwrap();
    let path = packed("fish_control.ply", dir.path());
    let ply = dir.path().join("part.ply");
    let unpack = |flags: &[&str]| {
        json(tristrip().args(["unpack", "--json"]).args(flags).arg(&path).arg("-o").arg(&ply))
    };
    let half = unpack(&["--level", "50%"]);
    let expected = [
        "file",
        "seconds",
        "proven",
        "parts",
        "level",
        "levels",
        "triangles",
        "triangles_full",
        "surface_error",
        "bytes",
        "chunks",
        "ended_early",
        "notes",
        "output",
        "error",
    ];
    assert_eq!(keys(&half), expected);
    let number = |report: &Value, key: &str| report[key].as_u64().unwrap();
    assert!(number(&half, "level").abs_diff(number(&half, "levels") / 2) <= 1);
    let strip = json(tristrip().args(["strip", "--json"]).arg(&ply));
    assert_eq!(strip["mesh"]["faces"], half["triangles"]);
    let full = unpack(&[]);
    assert_eq!((&full["level"], &full["triangles"]), (&full["levels"], &Value::from(220)));
    let few = unpack(&["--triangles", "150"]);
    assert!((148..=150).contains(&number(&few, "triangles")));
    let first = unpack(&["--bytes", "1"]);
    assert_eq!((&first["chunks"], &first["level"]), (&Value::from(0), &Value::from(0)));
    tristrip()
        .args(["unpack", "--level", "999"])
        .arg(&path)
        .assert()
        .code(1)
        .stderr(contains("level: found 999"));
}

#[test]
fn a_file_that_is_cut_off_gives_a_warning() {
    let dir = tempfile::tempdir().unwrap();
    let path = packed("fish_control.ply", dir.path());
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() - 9]).unwrap();
    let ply = dir.path().join("part.ply");
    let report = json(tristrip().args(["unpack", "--json"]).arg(&path).arg("-o").arg(&ply));
    assert_eq!(report["ended_early"], true);
    let warning = contains("warning").and(contains("the file ends within its stream"));
    tristrip().arg("unpack").arg(&path).assert().success().stderr(warning);
    tristrip()
        .arg("inspect")
        .arg(&path)
        .assert()
        .success()
        .stderr(contains("the file ends within its stream"));
    // The reader of other subcommands needs complete files.
    tristrip().arg("strip").arg(&path).assert().code(1);
    fs::write(&path, &bytes[..100]).unwrap();
    tristrip().arg("unpack").arg(&path).assert().code(1).stderr(contains("the file"));
}

/// Regression: notes about images that cannot be embedded were neither printed nor reported.
#[test]
fn missing_images_are_noted_when_a_level_is_unpacked() {
    let dir = tempfile::tempdir().unwrap();
    let (gltf, glb) = (dir.path().join("fish.gltf"), dir.path().join("fish.glb"));
    let fish = model("fish_control.ply");
    tristrip().args(["convert", "-q"]).arg(fish).arg("-o").arg(&gltf).assert().success();
    let json_text = fs::read_to_string(&gltf).unwrap();
    let images = r#"{"images":[{"uri":"none.png"}],"textures":[{"source":0}],"#;
    fs::write(&gltf, json_text.replacen('{', images, 1)).unwrap();
    tristrip().args(["pack", "-q"]).arg(&gltf).arg("-o").arg(&glb).assert().success();
    let out = dir.path().join("level.glb");
    let unpack = || {
        let mut unpack = tristrip();
        unpack.arg("unpack").arg(&glb).arg("-o").arg(&out);
        unpack
    };
    let notes = json(unpack().arg("--json"))["notes"].to_string();
    assert!(notes.contains("none.png"), "{notes}");
    unpack().assert().success().stderr(contains("none.png"));
}

#[test]
fn chunks_and_costs_are_shown() {
    let dir = tempfile::tempdir().unwrap();
    let path = packed("fish_control.ply", dir.path());
    let plot = dir.path().join("rate.svg");
    let report = json(tristrip().args(["inspect", "--json"]).arg(&path).arg("--plot").arg(&plot));
    let expected = [
        "file",
        "seconds",
        "meshes",
        "vertices",
        "triangles",
        "levels",
        "position_bits",
        "base_bytes",
        "chunk_bytes",
        "bits_per_vertex",
        "components",
        "chunks",
        "notes",
        "plot",
        "error",
    ];
    assert_eq!(keys(&report), expected);
    let components = report["components"].as_array().unwrap();
    let bits: f64 = components.iter().filter_map(|component| component["bits"].as_f64()).sum();
    let bytes = report["base_bytes"].as_f64().unwrap() + report["chunk_bytes"].as_f64().unwrap();
    assert!((bits - 8.0 * bytes).abs() < 8.0, "{bits}, {bytes}");
    assert!(fs::read_to_string(&plot).unwrap().contains("Error against bytes: fish_control.glb"));
    let table = contains("marks").and(contains("ends at byte")).and(contains("whole file"));
    tristrip().args(["inspect", "--chunks"]).arg(&path).assert().success().stdout(table);
}

#[test]
fn wrong_inputs_and_usage_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let obj = dir.path().join("square.obj");
    fs::write(&obj, SQUARE).unwrap();
    for command in ["unpack", "inspect"] {
        tristrip()
            .arg(command)
            .arg(&obj)
            .assert()
            .code(1)
            .stderr(contains("expected a progressive GLB from `pack`"));
        tristrip().arg(command).arg(dir.path()).assert().code(1);
        tristrip().arg(command).arg(dir.path().join("none.glb")).assert().code(1);
    }
    let pack = |flags: &[&str]| tristrip().arg("pack").arg(&obj).args(flags).assert();
    pack(&["-o", "out.ply"]).code(2).stderr(contains("pack writes .glb"));
    pack(&["-o", "out.glb", "--position-bits", "17"]).code(2);
    pack(&[]).code(2);
    let nowhere = dir.path().join("none/out.glb");
    pack(&["-o", nowhere.to_str().unwrap()]).code(1);
    tristrip().args(["unpack", "--level", "101%"]).arg(&obj).assert().code(2);
    tristrip().args(["unpack", "--level", "1", "--bytes", "1"]).arg(&obj).assert().code(2);
    // A square has nothing to refine.
    let out = dir.path().join("out.glb");
    pack(&["-o", out.to_str().unwrap()]).success().stderr(contains("1 part not refined"));
}
