//! `tristrip convert`: formats and layouts, without new strips.

use std::fs;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::str::contains;
use serde_json::Value;

#[test]
fn polygons_stay_polygons_if_the_format_has_them() {
    let dir = tempfile::tempdir().unwrap();
    let (obj, ply) = (dir.path().join("fish.obj"), dir.path().join("fish.ply"));
    let report =
        json(tristrip().args(["convert", "--json"]).arg(model("fish_control.ply")).arg("-o").arg(&obj));
    let expected = [
        "file",
        "proven",
        "seconds",
        "faces",
        "triangles",
        "strips",
        "parts",
        "notes",
        "output",
        "layout",
        "error",
    ];
    assert_eq!(keys(&report), expected);
    assert_eq!((&report["faces"], &report["triangles"]), (&Value::from(112), &Value::from(220)));
    assert_eq!((&report["proven"], &report["layout"]), (&Value::from(true), &Value::Null));
    tristrip().arg("convert").arg(&obj).arg("-o").arg(&ply).assert().success();
    let again = json(tristrip().args(["strip", "--json"]).arg(&ply));
    assert_eq!(again["mesh"]["faces"], 112);
}

#[test]
fn the_number_of_strips_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let (ply, glb) = (dir.path().join("a.ply"), dir.path().join("a.glb"));
    let first = json(tristrip().args(["strip", "--json"]).arg(model("wingnut.ply")).arg("-o").arg(&ply));
    let mut convert = tristrip();
    let second =
        json(convert.args(["convert", "--json", "--layout", "restart"]).arg(&ply).arg("-o").arg(&glb));
    assert_eq!(second["layout"], "restart");
    assert!(second["strips"].as_u64() <= first["strips"].as_u64());
    tristrip().arg("verify").arg(model("wingnut.ply")).arg(&glb).assert().success();
}

#[test]
fn streams_and_directories_work_as_for_strip() {
    let dir = tempfile::tempdir().unwrap();
    let piped =
        tristrip().args(["convert", "-", "-o", "-", "--to", "ply"]).write_stdin(SQUARE).assert().success();
    assert!(piped.get_output().stdout.starts_with(b"ply\n"));
    tristrip()
        .args(["convert", "--to", "obj", "-o"])
        .arg(dir.path())
        .arg(model("fish_control.ply"))
        .arg(model("catmark_bishop.ply"))
        .assert()
        .success()
        .stderr(contains("proven"));
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 2);
}

#[test]
fn losses_of_a_format_are_reported() {
    let dir = tempfile::tempdir().unwrap();
    let mut command = tristrip();
    command.args(["convert", "--json"]).arg(model("milktruck.glb")).arg("-o").arg(dir.path().join("a.ply"));
    let notes = json(&mut command)["notes"].to_string();
    assert!(notes.contains("parts joined into one") && notes.contains("nodes with a transform"), "{notes}");
}

#[test]
fn polygons_are_cut_into_fans_only_where_no_strips_draw_them() {
    let dir = tempfile::tempdir().unwrap();
    let quad = dir.path().join("quad.obj");
    fs::write(&quad, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").unwrap();
    let notes = |command: &str| {
        let output = dir.path().join("quad.glb");
        json(tristrip().args([command, "--json"]).arg(&quad).arg("-o").arg(output))["notes"].to_string()
    };
    assert!(notes("convert").contains("polygons cut into fans: 1"), "{}", notes("convert"));
    assert!(!notes("strip").contains("polygons"), "{}", notes("strip"));
}

#[test]
fn strips_stay_strips_without_a_layout() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name);
    let first =
        json(tristrip().args(["strip", "--json"]).arg(model("wingnut.ply")).arg("-o").arg(path("a.ply")));
    for (from, to, layout) in [
        ("a.ply", "b.glb", Value::from("degenerate")),
        ("b.glb", "c.ply", Value::from("restart")),
        ("c.ply", "d.glb", Value::from("degenerate")),
        ("d.glb", "e.obj", Value::Null),
        ("e.obj", "f.ply", Value::Null),
    ] {
        let report = json(tristrip().args(["convert", "--json"]).arg(path(from)).arg("-o").arg(path(to)));
        assert_eq!(report["layout"], layout, "{from} to {to}");
        assert_eq!(report["strips"].is_null(), layout.is_null());
        assert!(report["strips"].is_null() || report["strips"].as_u64() <= first["strips"].as_u64());
    }
    tristrip().arg("verify").arg(model("wingnut.ply")).arg(path("f.ply")).assert().success();
}
