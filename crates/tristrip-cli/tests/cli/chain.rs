//! `tristrip chain`: one scene, a file per level, levels that are not reached, and flags that do
//! not fit.

use std::fs;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::str::contains;
use serde_json::Value;

const FOUR: &str = "100%,50%,25%,10%";

fn numbers(report: &Value, key: &str) -> Vec<f64> {
    let levels = report["chain"].as_array().into_iter().flatten();
    levels.map(|level| level[key].as_f64().unwrap_or_else(|| panic!("{key} is no number"))).collect()
}

#[test]
fn one_glb_has_all_levels() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("truck.lod.glb");
    let source = model("milktruck.glb");
    let report = json(tristrip().args(["chain", "--json"]).arg(&source).arg("-o").arg(&path));
    let found = keys(&report);
    let expected = [
        "target_error",
        "triangles_before",
        "vertices_before",
        "diagonal",
        "chain",
        "locked_vertices",
        "parts",
        "warning",
        "notes",
        "output",
        "layout",
        "error",
    ];
    assert_eq!(found[found.len() - expected.len()..], expected);
    assert_eq!(keys(&report["seconds"]), ["load", "dual", "simplify", "stripify", "verify", "write"]);
    let level = [
        "level",
        "ratio",
        "target_triangles",
        "triangles",
        "vertices",
        "surface_error",
        "surface_error_percent",
        "screen_coverage",
        "reached",
        "bytes",
        "output",
    ];
    assert_eq!(keys(&report["chain"][0]), level);
    assert_eq!((&report["proven"], &report["layout"]), (&true.into(), &"degenerate".into()));
    assert_eq!(numbers(&report, "ratio"), [1.0, 0.5, 0.25, 0.1]);
    // The error limit ends the two coarsest levels at the same collapse.
    assert!(numbers(&report, "triangles")[..3].is_sorted_by(|a, b| a > b));
    for key in ["triangles", "vertices", "bytes"] {
        assert!(numbers(&report, key).is_sorted_by(|a, b| a >= b), "{key}");
    }
    assert!(numbers(&report, "screen_coverage").is_sorted_by(|a, b| a > b));
    let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
    assert!(text.contains("\"MSFT_lod\":{\"ids\":[") && text.contains("MSFT_screencoverage"));
    // A scene that already has levels cannot get more.
    let mut again = tristrip();
    again.args(["chain", "--ratios", FOUR]).arg(&path).arg("-o").arg(dir.path().join("again.glb"));
    again.assert().code(1).stderr(contains("already has levels of detail"));
}

#[test]
fn collapses_have_the_rules_of_simplify() {
    let source = model("milktruck.glb");
    let mut sizes = Vec::new();
    let weld = ["--weld-distance", "1%"];
    for rules in [&[][..], &["--weight", "normal=0,uv=0"], &["--permissive"], &["--lock-borders"], &weld] {
        let chain =
            json(tristrip().args(["chain", "--json", "--ratios", "50%,20%"]).args(rules).arg(&source));
        let simple = json(tristrip().args(["simplify", "--json", "--ratio", "20%"]).args(rules).arg(&source));
        let (coarsest, after) = (&chain["chain"][1], &simple["triangles_after"]);
        assert_eq!((&coarsest["triangles"], &coarsest["surface_error"]), (after, &simple["surface_error"]));
        sizes.push((after.to_string(), coarsest["surface_error"].to_string()));
    }
    assert!(sizes[1..].iter().all(|size| *size != sizes[0]), "each rule has an effect: {sizes:?}");
}

#[test]
fn a_directory_gets_a_file_per_level() {
    let dir = tempfile::tempdir().unwrap();
    let levels = dir.path().join("levels");
    for format in ["glb", "ply", "obj", "gltf"] {
        let mut command = tristrip();
        command.args(["chain", "--json", "--ratios", FOUR, "--to", format]).arg(model("hand.ply"));
        let report = json(command.arg("-o").arg(format!("{}/", levels.display())));
        for (level, figures) in report["chain"].as_array().unwrap().iter().enumerate() {
            let file = levels.join(format!("hand_{level}.{format}"));
            assert_eq!(figures["output"], file.display().to_string());
            let mut size = fs::metadata(&file).unwrap().len();
            if format == "gltf" {
                size += fs::metadata(file.with_extension("bin")).unwrap().len();
            }
            assert_eq!(figures["bytes"], size);
            let analyzed = json(tristrip().args(["analyze", "--json"]).arg(&file));
            assert_eq!(analyzed["triangles"], figures["triangles"], "{format}, level {level}");
        }
        assert_eq!((&report["output"], numbers(&report, "triangles")[0]), (&Value::Null, 15_982.0));
    }
    // The finest level draws the source.
    tristrip().arg("verify").arg(model("hand.ply")).arg(levels.join("hand_0.ply")).assert().success();
}

#[test]
fn a_level_that_is_not_reached_is_reported_and_is_no_failure() {
    let mut command = tristrip();
    command.args(["chain", "--json", "--ratios", FOUR, "--error", "0.05%"]).arg(model("hand.ply"));
    let report = json(&mut command);
    let reached: Vec<bool> =
        report["chain"].as_array().unwrap().iter().filter_map(|l| l["reached"].as_bool()).collect();
    assert!(reached[0] && !reached[3], "{reached:?}");
    assert!(numbers(&report, "surface_error_percent").iter().all(|&error| error <= 0.05));
    let warning = report["warning"].as_str().unwrap();
    assert!(warning.contains("not reached: ") && warning.contains("error limit of 0.05 %"), "{warning}");
    command = tristrip();
    command.args(["chain", "--ratios", FOUR, "--error", "0.05%"]).arg(model("hand.ply"));
    let text = command.assert().success().stderr(contains("warning: ")).get_output().stdout.clone();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("level 3") && text.contains("not reached"), "{text}");
}

#[test]
fn lists_are_ordered_for_vertex_caches_by_default() {
    let method = |arguments: &[&str]| {
        let dir = tempfile::tempdir().unwrap();
        let mut command = tristrip();
        command
            .args(["chain", "--json", "--ratios", "50%,10%"])
            .args(arguments)
            .arg(model("fish_control.ply"));
        let report = json(command.arg("-o").arg(dir.path().join("fish.glb")));
        (report["method"].as_str().unwrap().to_owned(), report["layout"].as_str().unwrap().to_owned())
    };
    let named = |method: &str, layout: &str| (method.to_owned(), layout.to_owned());
    assert_eq!(method(&[]), named("best", "degenerate"));
    assert_eq!(method(&["--layout", "list"]), named("cache", "list"));
    assert_eq!(method(&["--layout", "list", "--method", "best"]), named("best", "list"));
    assert_eq!(method(&["--layout", "restart"]), named("best", "restart"));
}

#[test]
fn flags_that_do_not_fit_are_wrong_usage() {
    let usage = |arguments: &[&str], why: &str| {
        let mut command = tristrip();
        command.arg("chain").arg(model("fish_control.ply")).args(arguments);
        command.assert().code(2).stderr(contains(why.to_owned()));
    };
    usage(&["--ratios", "50%,100%"], "ratios that decrease");
    usage(&["--level", "40%"], "unexpected argument '--level'");
    usage(&["--weld-distance", "-1"], "expected a distance");
    usage(&["-o", "fish.ply"], "PLY holds one level");
    usage(&["-o", "fish.obj"], "OBJ holds one level");
}

#[test]
fn files_of_levels_replace_no_input() {
    let dir = tempfile::tempdir().unwrap();
    let write = |name: &str| fs::write(dir.path().join(name), SQUARE).unwrap();
    ["a.obj", "a_1.obj"].into_iter().for_each(write);
    let mut command = tristrip();
    command
        .current_dir(&dir)
        .args(["chain", "--ratios", "100%,50%", "--to", "obj", "-o", "."])
        .args(["a.obj", "a_1.obj"]);
    command.assert().code(2).stderr(contains("would replace the input"));
    command = tristrip();
    command
        .current_dir(&dir)
        .args(["chain", "-q", "--ratios", "100%,50%", "--to", "obj", "-o", ".", "a_1.obj"]);
    command.assert().success();
    assert!(dir.path().join("a_1_0.obj").exists() && dir.path().join("a_1_1.obj").exists());
}
