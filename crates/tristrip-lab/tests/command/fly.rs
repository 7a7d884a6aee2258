//! `tristrip-lab fly`.

use std::fs;
use std::path::Path;

use super::{json, lab, model};
use predicates::prelude::*;
use predicates::str::{contains, is_empty};
use serde_json::Value;
use tristrip_pipeline::{parse_method, view_model};

fn fly(arguments: &[&str]) -> assert_cmd::Command {
    let mut command = lab();
    command.args(["fly", "-m", "stripe", "--frames", "12"]).args(arguments).arg(model("hand.ply"));
    command
}

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn file_names(directory: &Path) -> Vec<String> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_flight_reports_every_frame() {
    let report = json(fly(&["--json"]).arg("--pixels").arg("2"));
    let frames = report["frames"].as_array().unwrap();
    assert_eq!((frames.len(), &report["proven"], &report["path"]), (12, &true.into(), &"orbit".into()));
    assert!(frames.iter().all(|frame| frame["proven"] == true && frame["complete"] == true));
    assert!(frames.iter().all(|frame| number(&frame["vertices_sent"]) > number(&frame["triangles"])));
    // The first frame starts from the base mesh. No frame draws the full mesh.
    assert!(number(&frames[0]["splits"]) > 100 && number(&frames[0]["collapses"]) == 0);
    let full = number(&report["triangles_full"]);
    assert!(frames.iter().all(|frame| number(&frame["triangles"]) < full));
    assert_eq!(number(&report["summary"]["frame_count"]), 12);
    let fine = json(fly(&["--json"]).args(["--pixels", "0.2", "--no-frustum", "--no-back-faces"]));
    assert!(number(&fine["frames"][5]["triangles"]) > number(&frames[5]["triangles"]));
    let limited = json(fly(&["--json"]).args(["--pixels", "0.2", "--triangles", "1000"]));
    let limited = limited["frames"].as_array().unwrap();
    assert!(limited.iter().all(|frame| number(&frame["triangles"]) <= 1000));
    let looking = json(&mut fly(&["--json", "--pixels", "2", "--foveation", "1", "--attention", "0.5,0"]));
    let looking = looking["frames"].as_array().unwrap();
    assert!(looking.iter().zip(frames).all(|(a, b)| number(&a["triangles"]) < number(&b["triangles"])));
    let slow = json(fly(&["--json"]).args(["--steps", "50", "--no-verify"]));
    assert_eq!((&slow["frames"][0]["complete"], &slow["proven"]), (&false.into(), &Value::Null));
    assert!(number(&slow["summary"]["frames_incomplete"]) > 0);
}

#[test]
fn every_path_and_filter_flies() {
    for path in ["orbit", "dolly", "flyover"] {
        for filter in ["none", "stss", "dtfs", "linked"] {
            let report = json(&mut fly(&["--json", "--path", path, "--filter", filter, "--light", "0,1,-1"]));
            assert_eq!((&report["proven"], &report["filter"]), (&true.into(), &filter.into()));
        }
    }
}

#[test]
fn pages_charts_and_pictures_are_written() {
    let dir = tempfile::tempdir().unwrap();
    let arguments =
        ["--report", "a.md", "--plot", "a.svg", "--video", "v", "--image", "96x54", "--video-every", "5"];
    fly(&arguments).current_dir(&dir).assert().success();
    let page = fs::read_to_string(dir.path().join("a.md")).unwrap();
    assert!(page.starts_with("# Flight: hand.ply\n") && page.contains("12 frames, 12 proven"), "{page}");
    assert!(fs::read_to_string(dir.path().join("a.svg")).unwrap().starts_with("<svg"));
    assert_eq!(file_names(&dir.path().join("v")), ["0000.png", "0001.png", "0002.png"]);
    fly(&["--video", "v", "--image", "96x54", "--shaded"]).current_dir(&dir).assert().success();
    assert_eq!(file_names(&dir.path().join("v")).len(), 12);
    for name in ["0000.png", "0011.png"] {
        assert!(fs::read(dir.path().join("v").join(name)).unwrap().starts_with(b"\x89PNG"));
    }
}

#[test]
fn a_path_is_read_from_a_file() {
    let dir = tempfile::tempdir().unwrap();
    let write = |text: &str| fs::write(dir.path().join("path.json"), text).unwrap();
    let run = || fly(&["--path", "path.json", "--json"]).current_dir(&dir).assert();
    write(
        r#"[{"eye": [0, 0, 900], "look_at": [0, 0, 0]}, {"eye": [0, 0, 9], "look_at": [0, 0, 0], "field_of_view": 30}]"#,
    );
    run().success();
    for (text, message) in [
        ("[{\"eye\": [0, 0, 9]}]", "path.json: missing field `look_at` at line 1"),
        ("[]", "path.json: cameras: found 0, expected 1 to 10000"),
        ("[{\"eye\": [0, 0, 1e99], \"look_at\": [0, 0, 0]}]", "path.json: camera 0: parameter `eye`: found"),
        (
            "[{\"eye\": [0, 0, 1], \"look_at\": [0, 0, 0], \"field_of_view\": 180}]",
            "found 180, expected an angle",
        ),
    ] {
        write(text);
        run().code(1).stderr(contains(message));
    }
    fs::remove_file(dir.path().join("path.json")).unwrap();
    run().code(1).stderr(contains("path.json: no such file or directory"));
}

#[test]
fn outputs_that_cannot_be_written_are_errors() {
    let dir = tempfile::tempdir().unwrap();
    for (flag, name) in [("--report", "missing/a.md"), ("--plot", "missing/a.svg"), ("--video", "missing/v")]
    {
        let run = fly(&[flag, name, "--image", "8x8"]).current_dir(&dir).assert();
        run.code(1).stderr(contains(name).or(contains("missing")));
    }
    assert_eq!(file_names(dir.path()), Vec::<String>::new());
}

#[test]
fn wrong_flags_are_refused() {
    for (arguments, message) in [
        (&["--frames", "0"][..], "--frames: found 0, expected 1 to 100000"),
        (&["--field-of-view", "0"], "found 0, expected an angle between 0 and 180 degrees"),
        (&["--field-of-view", "NaN"], "found NaN, expected an angle"),
        (&["--pixels", "-1"], "--pixels: found -1, expected a finite number of at least 0"),
        (&["--pixels", "inf"], "--pixels: found inf, expected a finite number"),
        (&["--foveation", "nan"], "--foveation: found NaN, expected a finite number"),
        (&["--fov", "0"], "--field-of-view: found 0, expected"),
        (&["--report", "-"], "--report: found -, expected a file"),
        (&["--steps", "0"], "'--steps <N>': number would be zero"),
        (&["--triangles", "many"], "invalid value 'many' for '--triangles <COUNT>'"),
        (&["--image", "0x9"], "expected columns and rows from 1 to 8192"),
        (&["--light", "0,0,0"], "--light: found [0.0, 0.0, 0.0], expected a direction"),
        (&["--foveation", "-1"], "found -1, expected a finite number of at least 0"),
        (&["--foveation", "NaN"], "found NaN, expected a finite number of at least 0"),
        (&["--foveation", "1", "--attention", "0.5,2"], "expected fractions from 0 to 1"),
        (&["--attention", "0.5,0.5"], "--foveation <GROWTH>"),
        (&["--path", "circle"], "expected orbit, dolly, flyover or a .json file of cameras"),
        (&["--path", "a.json", "--up", "z"], "--up cannot be used with a file of cameras"),
        (&["--plot", "a.png"], "--plot writes SVG"),
        (&["--shaded"], "--video <DIRECTORY>"),
    ] {
        let run = lab().args(["fly", "a.ply"]).args(arguments).assert();
        run.code(2).stdout(is_empty()).stderr(contains("error: ").and(contains(message)));
    }
}

#[test]
fn a_flight_over_a_file_is_that_over_its_mesh() {
    let dir = tempfile::tempdir().unwrap();
    let (path, page) = (dir.path().join("fish.tlod"), dir.path().join("fish.md"));
    let source = model("fish_control.ply");
    let options = view_model::Options::default().with_stripify(parse_method("stripe").unwrap());
    let built = view_model::run(tristrip_io::read_path(&source).unwrap(), &options, &()).unwrap();
    fs::write(&path, built.model.encode().unwrap().bytes).unwrap();
    let fly = |input: &Path, method: &[&str]| {
        let mut command = lab();
        command.args(["fly", "--json", "--frames", "5"]).args(method).arg("--report").arg(&page).arg(input);
        let report = json(&mut command);
        (report, fs::read_to_string(&page).unwrap())
    };
    let (of_file, of_mesh) = (fly(&path, &[]), fly(&source, &["-m", "stripe"]));
    let drawn = |report: &Value| {
        let frames = report["frames"].as_array().unwrap().iter();
        frames.map(|frame| (frame["triangles"].clone(), frame["vertices_sent"].clone())).collect::<Vec<_>>()
    };
    assert_eq!(drawn(&of_file.0), drawn(&of_mesh.0));
    let refused = lab().args(["fly", "-m", "stripe"]).arg(&path).assert().code(2);
    refused.stderr(contains("fish.tlod: --method cannot be used: the file has its own strips"));
    assert_ne!(of_file.1, of_mesh.1, "the page of a file names no method");
}
