//! `tristrip fly`, and `tristrip lod` with a camera.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::{json, model, tristrip};
use predicates::prelude::*;
use predicates::str::{contains, is_empty};
use serde_json::Value;

fn fly(arguments: &[&str]) -> assert_cmd::Command {
    let mut command = tristrip();
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
    // The first frame comes from the base mesh; no frame draws the full mesh.
    assert!(number(&frames[0]["splits"]) > 100 && number(&frames[0]["collapses"]) == 0);
    let full = number(&report["triangles_full"]);
    assert!(frames.iter().all(|frame| number(&frame["triangles"]) < full));
    assert_eq!(number(&report["summary"]["frame_count"]), 12);
    let fine = json(fly(&["--json"]).args(["--pixels", "0.2", "--no-frustum", "--no-back-faces"]));
    assert!(number(&fine["frames"][5]["triangles"]) > number(&frames[5]["triangles"]));
    let limited = json(fly(&["--json"]).args(["--pixels", "0.2", "--triangles", "1k"]));
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
        (&["--steps", "0"], "--steps: found 0, expected at least 1"),
        (&["--triangles", "many"], "expected a number such as 50000, 200k or 2M"),
        (&["--image", "0x9"], "expected columns and rows from 1 to 8192"),
        (&["--light", "0,0,0"], "--light: found [0.0, 0.0, 0.0], expected a direction"),
        (&["--foveation", "-1"], "found -1, expected a finite number of at least 0"),
        (&["--foveation", "NaN"], "found NaN, expected a finite number of at least 0"),
        (&["--foveation", "1", "--attention", "0.5,2"], "expected two fractions from 0 to 1"),
        (&["--attention", "0.5,0.5"], "--foveation <GROWTH>"),
        (&["--path", "circle"], "expected orbit, dolly, flyover or a .json file of cameras"),
        (&["--path", "a.json", "--up", "z"], "--up cannot be used with a file of cameras"),
        (&["--plot", "a.png"], "--plot writes SVG"),
        (&["--shaded"], "--video <DIRECTORY>"),
    ] {
        let run = tristrip().args(["fly", "a.ply"]).args(arguments).assert();
        run.code(2).stdout(is_empty()).stderr(contains("error: ").and(contains(message)));
    }
}

#[test]
fn a_camera_draws_one_view() {
    let dir = tempfile::tempdir().unwrap();
    let view = |distance: &str, more: &[&str]| {
        let camera = ["--camera", distance, "--look-at", "0,0,0"];
        let mut command = tristrip();
        command.args(["lod", "--json", "-m", "stripe", "--model", "skip"]).args(camera).args(more);
        json(command.arg(model("hand.ply")).current_dir(&dir))
    };
    let near = view("0,0,30", &["--pixels", "0.5", "-o", "frame.glb"]);
    assert_eq!(
        (&near["proven"], &near["level"], &near["output"]),
        (&true.into(), &Value::Null, &"frame.glb".into())
    );
    let drawn = json(tristrip().args(["analyze", "--json", "frame.glb"]).current_dir(&dir));
    assert_eq!(drawn["triangles"], near["triangles"]);
    let far = view("0,0,3000", &["--field-of-view", "30", "--image", "640x480"]);
    assert!(number(&far["triangles"]) < number(&near["triangles"]));
    assert_eq!(view("0,0,3000", &["--fov", "30", "--image", "640x480"])["triangles"], far["triangles"]);
    // Each of the criteria changes what is drawn.
    let close = |more: &[&str]| view("0,0,2", &[&["--fov", "12", "--pixels", "0.5"], more].concat());
    let usual = close(&[]);
    for more in [
        &["--no-frustum"][..],
        &["--no-back-faces"],
        &["--no-silhouettes"],
        &["--light", "0,1,0"],
        &["--foveation", "0.5"],
        &["--triangles", "500"],
    ] {
        let other = close(more);
        assert_eq!(other["proven"], true);
        assert_ne!(other["triangles"], usual["triangles"], "{more:?}");
    }
    let few = close(&["--triangles", "1k"]);
    assert!((900..=1000).contains(&number(&few["triangles"])), "{}", few["triangles"]);
    assert!(!few["notes"].to_string().contains("asked for"), "{}", few["notes"]);
    let aside = close(&["--foveation", "0.5", "--attention", "0,1"]);
    assert_ne!(aside["triangles"], close(&["--foveation", "0.5"])["triangles"]);
    let none = close(&["--triangles", "0"]);
    assert!(none["notes"].to_string().contains("0 triangles asked for: the view has"), "{}", none["notes"]);
}

/// The parts of a model share the triangles of a view.
#[test]
fn parts_share_the_triangles_of_a_view() {
    let dir = tempfile::tempdir().unwrap();
    // Two grids of 200 triangles with hills, of two materials.
    let mut text = String::new();
    for part in 0..2 {
        for (x, y) in (0..11).flat_map(|y| (0..11).map(move |x| (x, y))) {
            writeln!(text, "v {} {} {}", x + 20 * part, y, (x * x + 3 * y) % 7).unwrap();
        }
        writeln!(text, "usemtl m{part}").unwrap();
        for (x, y) in (0..10).flat_map(|y| (0..10).map(move |x| (x, y))) {
            let v = 121 * part + 11 * y + x + 1;
            writeln!(text, "f {} {} {}\nf {} {} {}", v, v + 1, v + 11, v + 11, v + 1, v + 12).unwrap();
        }
    }
    fs::write(dir.path().join("two.obj"), text).unwrap();
    let view = |more: &[&str]| {
        let camera = ["--model", "skip", "--camera", "15,5,40", "--look-at", "15,5,0", "--pixels", "0.1"];
        json(tristrip().args(["lod", "two.obj", "--json"]).args(camera).args(more).current_dir(&dir))
    };
    let (all, some) = (view(&[]), view(&["--triangles", "200"]));
    assert!(number(&all["triangles"]) > 350 && some["parts"] == 2, "{all}");
    assert!((120..=200).contains(&number(&some["triangles"])), "{}", some["triangles"]);
}

#[test]
fn a_part_that_a_node_scales_has_the_detail_of_its_size() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("hand.gltf");
    tristrip().arg("convert").arg(model("hand.ply")).arg("-o").arg(&path).assert().success();
    let scene = fs::read_to_string(&path).unwrap();
    let seen_at = |scale: f64, more: &[&str]| {
        let mut scene: Value = serde_json::from_str(&scene).unwrap();
        scene["nodes"][0]["scale"] = serde_json::json!([scale, scale, scale]);
        fs::write(&path, scene.to_string()).unwrap();
        let camera = format!("0,0,{}", 3.0 * scale);
        let mut command = tristrip();
        command.args(["lod", "--json", "-m", "stripe", "--model", "skip", "--look-at", "0,0,0", "--camera"]);
        json(command.arg(camera).args(more).arg(&path))["triangles"].clone()
    };
    // The picture is the same, and so is everything that a power of two scales.
    for more in [&["--pixels", "2"][..], &["--pixels", "0.5", "--triangles", "1000"]] {
        let one = seen_at(1.0, more);
        assert!(number(&one) > 100, "{one}");
        assert_eq!([4.0, 0.25].map(|scale| seen_at(scale, more)), [one.clone(), one]);
    }
}

#[test]
fn cameras_of_levels_are_checked() {
    let camera = ["--model", "skip", "--camera", "0,0,9", "--look-at", "0,0,0"];
    for (arguments, message) in [
        (&["--camera", "0,0,NaN", "--look-at", "0,0,0"][..], "expected three finite numbers"),
        (&["--model", "skip", "--camera", "0,0,9"], "--look-at <X,Y,Z>"),
        (
            &["--camera", "0,0,9", "--look-at", "0,0,0"],
            "--camera belongs to --model skip, not to progressive",
        ),
        (&["--model", "skip", "--camera", "1,1,1", "--look-at", "1,1,1"], "expected another point"),
        (&["--model", "skip", "--no-frustum"], "--camera <X,Y,Z>"),
        (&["--model", "skip", "--light", "0,1,0"], "--camera <X,Y,Z>"),
        (&["--model", "skip", "--image", "9x9"], "--camera <X,Y,Z>"),
        (
            &["--model", "skip", "--camera", "0,0,9", "--look-at", "0,0,0", "--light", "0,0,0"],
            "expected a direction",
        ),
        (
            &["--triangles", "5", "--pixels", "1", "--distance", "5"],
            "--triangles cannot be used with --pixels",
        ),
        (&["--chain", "100%,50%", "--no-frustum"], "cannot be used with"),
    ] {
        let run = tristrip().args(["lod", "a.ply"]).args(arguments).assert();
        run.code(2).stdout(is_empty()).stderr(contains(message));
    }
    for more in [
        &["--level", "5"][..],
        &["--error", "1"],
        &["--pixels", "1", "--distance", "5"],
        &["--chain", "100%,50%"],
    ] {
        let run = tristrip().args(["lod", "a.ply"]).args(camera).args(more).assert();
        run.code(2).stderr(contains("cannot be used with"));
    }
    let wide = tristrip().args(["lod", "a.ply"]).args(camera).args(["--field-of-view", "0"]).assert();
    wide.code(2).stderr(contains("found 0, expected an angle"));
}
