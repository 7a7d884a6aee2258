//! `tristrip-lab pack` and `unpack`: the transmission of paper 001.

use std::fs;

use super::{json, lab, model};
use predicates::str::contains;
use serde_json::Value;

#[test]
fn the_published_format_is_packed_and_unpacked() {
    let dir = tempfile::tempdir().unwrap();
    let (path, ply) = (dir.path().join("fish.ps"), dir.path().join("part.ply"));
    let mut pack = lab();
    pack.args(["pack", "--json"]).arg(model("fish_control.ply"));
    let report = json(pack.arg("-o").arg(&path));
    assert_eq!(report["proven"], true);
    assert_eq!(report["bytes"], fs::metadata(&path).unwrap().len());
    let unpack =
        |flags: &[&str]| json(lab().args(["unpack", "--json"]).args(flags).arg(&path).arg("-o").arg(&ply));
    let full = unpack(&[]);
    assert_eq!((&full["level"], &full["triangles"]), (&full["levels"], &Value::from(220)));
    let [source, result] =
        [model("fish_control.ply"), ply.clone()].map(|path| tristrip_io::read_path(path).unwrap());
    assert!(tristrip_pipeline::verify::run(&source, &result, &()).unwrap().proven);
    let base = unpack(&["--level", "0"]);
    assert_eq!(base["triangles"], report["base_triangles"]);
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    assert_eq!(unpack(&[])["ended_early"], true);
    fs::write(&path, &bytes[..10]).unwrap();
    lab().arg("unpack").arg(&path).assert().code(1);
}

#[test]
fn wrong_inputs_and_usage_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let pack = |output: &str| {
        let mut command = lab();
        command.arg("pack").arg(model("fish_control.ply")).args(["-o", output]).current_dir(&dir).assert()
    };
    pack("out.glb").code(2).stderr(contains("its own format"));
    pack("none/out.ps").code(1).stderr(contains("no such file or directory"));
    lab().arg("unpack").arg(model("fish_control.ply")).assert().code(1);
    lab().args(["unpack", "a.ps", "--level", "1", "--bytes", "1"]).assert().code(2);
}
