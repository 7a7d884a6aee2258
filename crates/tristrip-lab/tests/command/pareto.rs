//! `tristrip-lab pareto`: metrics, optimality, the chart, and write errors.

use std::fs;
use std::path::Path;

use super::{SQUARE, json, keys, lab, model};
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::{contains, is_empty};
use serde_json::Value;
use tristrip_pipeline::{parse_method, strip};

const KEYS: [&str; 9] = [
    "label",
    "method",
    "objective",
    "effort",
    "vertex_cache",
    "indices_restart_per_triangle",
    "acmr",
    "optimal",
    "stopped",
];

fn pareto(chart: &Path, name: &str, flags: &[&str]) -> Command {
    let mut command = lab();
    command.args(["pareto", "-o"]).arg(chart).args(flags).arg(model(name));
    command
}

fn points(report: &Value) -> &[Value] {
    report["pareto"].as_array().map_or_else(|| panic!("no points: {report}"), Vec::as_slice)
}

fn point<'a>(report: &'a Value, label: &str) -> &'a Value {
    let found = points(report).iter().find(|point| point["label"] == label);
    found.unwrap_or_else(|| panic!("no {label}: {report}"))
}

fn figures(point: &Value) -> (f64, f64) {
    let figure = |key: &str| point[key].as_f64().unwrap_or_else(|| panic!("{key}: {point}"));
    (figure("indices_restart_per_triangle"), figure("acmr"))
}

#[test]
fn every_method_has_a_point_and_the_optimal_ones_are_marked() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("a.svg");
    for (name, flags) in [
        ("wingnut.ply", &["--effort", "1"][..]),
        ("milktruck.glb", &["--effort", "1", "--weld", "--vertex-cache", "lru:8"]),
        ("catmark_bishop.ply", &[]),
    ] {
        let report = json(pareto(&chart, name, flags).arg("--json"));
        let all: Vec<_> = points(&report).iter().map(figures).collect();
        assert_eq!(all.len(), if flags.is_empty() { 16 } else { 12 });
        for (i, (point, &(x, y))) in points(&report).iter().zip(&all).enumerate() {
            assert_eq!(keys(point), KEYS);
            // No other point is to the left and not above, or below and not to the right.
            let dominated = all.iter().any(|&(a, b)| (a < x && b <= y) || (a <= x && b < y));
            assert_eq!(point["optimal"], !dominated, "{name} {i}: {point}");
        }
        assert_eq!(report["error"], Value::Null);
    }
}

#[test]
fn points_equal_the_results_of_the_methods() {
    let dir = tempfile::tempdir().unwrap();
    let report = json(pareto(&dir.path().join("a.svg"), "wingnut.ply", &[]).arg("--json"));
    let source = tristrip_io::read_path(model("wingnut.ply")).unwrap();
    for (label, flags) in [
        ("sgi", "sgi"),
        ("stripe", "stripe"),
        ("quad-rows", "quad-rows"),
        ("guided-tunnels", "guided-tunnels"),
        ("best 2", "best"),
        ("fewest 5", "fewest"),
        ("cache misses 2", "cache:objective=misses"),
    ] {
        let options = strip::Options::default().with_stripify(parse_method(flags).unwrap());
        let alone = serde_json::to_value(strip::run(&source, &options, &()).unwrap().metrics).unwrap();
        let point = point(&report, label);
        assert_eq!(point["indices_restart_per_triangle"], alone["indices_restart_per_triangle"], "{label}");
        assert_eq!(point["acmr"], alone["acmr_fifo_16"], "{label}");
    }
    let list = point(&report, "list");
    assert_eq!(list["indices_restart_per_triangle"], 3.0);
    assert_eq!((&list["effort"], &list["vertex_cache"]), (&Value::Null, &"fifo:16".into()));
}

#[test]
fn options_apply_to_all_methods() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("a.svg");
    let flags = ["--effort", "1", "--vertex-cache", "fifo:32", "--seed", "7"];
    let report = json(pareto(&chart, "fish_control.ply", &flags).arg("--json"));
    for label in ["best 1", "fewest 1", "cache indices 1", "cache balanced 1", "cache misses 1"] {
        assert_eq!(
            (&point(&report, label)["effort"], &point(&report, label)["vertex_cache"]),
            (&1.into(), &"fifo:32".into())
        );
    }
}

#[test]
fn the_chart_is_the_same_for_any_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    let drawn = |threads: &str| {
        let chart = dir.path().join(format!("{threads}.svg"));
        let flags = ["-q", "--json", "--effort", "1", "--threads", threads];
        let report = json(&mut pareto(&chart, "milktruck.glb", &flags));
        (fs::read(&chart).unwrap(), report["pareto"].clone())
    };
    assert_eq!(drawn("1"), drawn("3"));
}

#[test]
fn a_chart_has_a_panel_per_input() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("a.svg");
    let mut command = pareto(&chart, "wingnut.ply", &["--effort", "1"]);
    let assert = command.arg(model("fish_control.ply")).assert().success();
    assert
        .stdout(contains("method").and(contains("cache misses 1")).and(contains("optimal")))
        .stderr(contains("each proven"));
    let text = fs::read_to_string(&chart).unwrap();
    assert!(text.starts_with("<svg width=\"900\" height=\"680\""), "one panel below the other");
    for words in
        ["wingnut.ply", "fish_control.ply", "cache balanced 1", "Outside: ", "misses per triangle (fifo:16)"]
    {
        assert!(text.contains(words), "{words}");
    }
}

#[test]
fn a_chart_that_cannot_be_written_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let mut command =
        pareto(&dir.path().join("none/a.svg"), "fish_control.ply", &["-q", "--json", "--effort", "1"]);
    let assert = command.assert().code(1).stderr(contains("a.svg: no such file or directory"));
    let report: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert!(report["error"].as_str().unwrap().contains("a.svg"));
    assert_eq!(points(&report).len(), 12);
    pareto(&dir.path().join("a.png"), "fish_control.ply", &[])
        .assert()
        .code(2)
        .stderr(contains("-o writes SVG"));
}

#[test]
fn bad_inputs_are_reported_and_the_others_drawn() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("a.svg");
    let mut command = pareto(&chart, "fish_control.ply", &["-q", "--json", "--effort", "1"]);
    let assert = command.arg(dir.path().join("none.ply")).assert().code(1);
    let reports: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert!(reports[0]["error"].is_null() && reports[1]["error"].is_string());
    assert_eq!(reports[1]["pareto"], Value::Null);
    assert!(fs::read_to_string(&chart).unwrap().starts_with("<svg width=\"900\" height=\"340\""));
    // No chart if no input was processed.
    let none = dir.path().join("none.svg");
    let mut command = lab();
    command.args(["pareto", "-q", "none.ply", "-o"]).arg(&none).assert().code(1).stdout(is_empty());
    assert!(!none.exists());
}

#[test]
fn small_and_empty_models_have_a_chart() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("a.svg");
    for (source, more) in [(SQUARE, 12), ("v 0 0 0\nv 1 0 0\n", 13)] {
        let file = dir.path().join("model.obj");
        fs::write(&file, source).unwrap();
        let report = json(lab().args(["pareto", "--json", "-o"]).arg(&chart).arg(&file));
        let strips = points(&report).iter().filter(|point| point["label"] != "list");
        assert!(strips.clone().all(|point| point["optimal"] == true));
        // Without faces, the list has as few indices as the strips.
        let label = format!("\ninput, sequential, sgi and {more} more\n");
        assert!(fs::read_to_string(&chart).unwrap().contains(&label));
    }
}
