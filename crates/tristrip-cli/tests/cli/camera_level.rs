//! `tristrip camera-level`: the view of one camera.

use std::fmt::Write as _;
use std::fs;

use super::{json, model, tristrip};
use predicates::str::{contains, is_empty};
use serde_json::Value;

fn number(value: &Value) -> u64 {
    value.as_u64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_camera_draws_one_view() {
    let dir = tempfile::tempdir().unwrap();
    let view = |distance: &str, more: &[&str]| {
        let camera = ["--eye", distance, "--look-at", "0,0,0"];
        let mut command = tristrip();
        command.args(["camera-level", "--json", "-m", "stripe"]).args(camera).args(more);
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
    // Each criterion changes what is drawn.
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
    assert!(!few["notes"].to_string().contains("requested"), "{}", few["notes"]);
    let aside = close(&["--foveation", "0.5", "--attention", "0,1"]);
    assert_ne!(aside["triangles"], close(&["--foveation", "0.5"])["triangles"]);
    let none = close(&["--triangles", "0"]);
    assert!(
        none["notes"].to_string().contains("requested 0 triangles, but the view has"),
        "{}",
        none["notes"]
    );
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
        let camera = ["--eye", "15,5,40", "--look-at", "15,5,0", "--pixels", "0.1"];
        json(tristrip().args(["camera-level", "two.obj", "--json"]).args(camera).args(more).current_dir(&dir))
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
        command.args(["camera-level", "--json", "-m", "stripe", "--look-at", "0,0,0", "--eye"]);
        json(command.arg(camera).args(more).arg(&path))["triangles"].clone()
    };
    // A power of two scales everything exactly, so the view is the same.
    for more in [&["--pixels", "2"][..], &["--pixels", "0.5", "--triangles", "1000"]] {
        let one = seen_at(1.0, more);
        assert!(number(&one) > 100, "{one}");
        assert_eq!([4.0, 0.25].map(|scale| seen_at(scale, more)), [one.clone(), one]);
    }
}

#[test]
fn cameras_of_levels_are_checked() {
    let camera = ["--eye", "0,0,9", "--look-at", "0,0,0"];
    for (arguments, message) in [
        (&["--eye", "0,0,NaN", "--look-at", "0,0,0"][..], "expected three finite numbers"),
        (&["--eye", "0,0,9"], "--look-at <X,Y,Z>"),
        (&["--eye", "1,1,1", "--look-at", "1,1,1"], "expected another point"),
        (&["--no-frustum"], "--eye <X,Y,Z>"),
        (&["--light", "0,1,0"], "--eye <X,Y,Z>"),
        (&["--image", "9x9"], "--eye <X,Y,Z>"),
        (&["--eye", "0,0,9", "--look-at", "0,0,0", "--light", "0,0,0"], "expected a direction"),
    ] {
        let run = tristrip().args(["camera-level", "a.ply"]).args(arguments).assert();
        run.code(2).stdout(is_empty()).stderr(contains(message));
    }
    for more in [&["--level", "5"][..], &["--error", "1"], &["--distance", "5"], &["--model", "sets"]] {
        let run = tristrip().args(["camera-level", "a.ply"]).args(camera).args(more).assert();
        run.code(2).stderr(contains("unexpected argument"));
    }
    let wide =
        tristrip().args(["camera-level", "a.ply"]).args(camera).args(["--field-of-view", "0"]).assert();
    wide.code(2).stderr(contains("found 0, expected an angle"));
}
