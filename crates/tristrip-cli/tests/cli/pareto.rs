//! `tristrip strip --pareto`: figures, optimality, the chart, and write errors.

use std::fs;
use std::path::Path;

use super::{SQUARE, json, keys, model, tristrip};
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::{contains, is_empty};
use serde_json::Value;

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
    let mut command = tristrip();
    command.args(["strip", "--pareto"]).arg(chart).args(flags).arg(model(name));
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
fn points_equal_the_reports_of_the_methods() {
    let dir = tempfile::tempdir().unwrap();
    let report = json(pareto(&dir.path().join("a.svg"), "wingnut.ply", &["-m", "sgi"]).arg("--json"));
    assert_eq!((&report["method"], report.get("acmr")), (&"sgi".into(), None));
    for (label, flags) in [
        ("sgi", &["-m", "sgi"][..]),
        ("stripe", &["-m", "stripe"]),
        ("quad-rows", &["-m", "quad-rows"]),
        ("guided-tunnels", &["-m", "guided-tunnels"]),
        ("best 2", &["-m", "best", "--effort", "2"]),
        ("fewest 5", &["-m", "fewest"]),
        ("cache misses 2", &["-m", "cache:objective=misses"]),
    ] {
        let alone = json(tristrip().args(["strip", "--json"]).args(flags).arg(model("wingnut.ply")));
        let point = point(&report, label);
        assert_eq!(point["indices_restart_per_triangle"], alone["indices_restart_per_triangle"], "{label}");
        assert_eq!(point["acmr"], alone["acmr_fifo_16"], "{label}");
        assert_eq!(point["method"], alone["method"]);
        assert_eq!(point.get("objective"), Some(alone.get("objective").unwrap_or(&Value::Null)));
    }
    let mut command = tristrip();
    let stored =
        json(command.args(["analyze", "--json", "--vertex-caches", "fifo:16"]).arg(model("wingnut.ply")));
    let list = point(&report, "list");
    assert_eq!(figures(list), (3.0, stored["vertex_caches"][0]["acmr"].as_f64().unwrap()));
    assert_eq!((&list["effort"], &list["vertex_cache"]), (&Value::Null, &"fifo:16".into()));
}

#[test]
fn the_flags_of_searches_apply_to_all_methods() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("a.svg");
    let flags = ["-m", "tunnel", "--effort", "1", "--vertex-cache", "fifo:32", "--seed", "7", "--no-verify"];
    let report = json(pareto(&chart, "fish_control.ply", &flags).arg("--json"));
    assert_eq!(report["proven"], Value::Null);
    let own = point(&report, "tunnel 9");
    assert_eq!((&own["acmr"], &own["vertex_cache"]), (&report["acmr_fifo_32"], &"fifo:32".into()));
    for label in ["best 1", "fewest 1", "cache indices 1", "cache balanced 1", "cache misses 1"] {
        assert_eq!(point(&report, label)["effort"], 1);
    }
    let flags = ["--budget", "0s", "--effort", "9", "--json"];
    let stopped = json(&mut pareto(&chart, "wingnut.ply", &flags));
    assert_eq!(point(&stopped, "best 9")["stopped"], "budget");
    assert!(stopped["notes"].to_string().contains("chart: these searches were stopped early: "));
    let report = json(tristrip().args(["strip", "--json"]).arg(model("fish_control.ply")));
    assert_eq!(report["pareto"], Value::Null);
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
fn a_chart_is_drawn_beside_the_output() {
    let dir = tempfile::tempdir().unwrap();
    let [chart, output] = ["a.svg", "out"].map(|name| dir.path().join(name));
    let mut command = pareto(&chart, "wingnut.ply", &["--effort", "1"]);
    let assert = command.arg(model("fish_control.ply")).arg("-o").arg(&output).assert().success();
    assert
        .stdout(contains("method").and(contains("cache misses 1")).and(contains("optimal")))
        .stderr(contains("each proven"));
    assert!(output.join("wingnut.glb").is_file() && output.join("fish_control.glb").is_file());
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
    let output = dir.path().join("a.ply");
    let mut command =
        pareto(&dir.path().join("none/a.svg"), "fish_control.ply", &["-q", "--json", "--effort", "1"]);
    let assert = command.arg("-o").arg(&output).assert().code(1);
    let assert = assert.stderr(contains("a.svg: no such file or directory"));
    let report: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert!(report["error"].as_str().unwrap().contains("a.svg"));
    assert_eq!((points(&report).len(), &report["proven"]), (12, &true.into()));
    assert!(output.is_file());
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
    let mut command = tristrip();
    command.args(["strip", "-q", "none.ply", "--pareto"]).arg(&none).assert().code(1).stdout(is_empty());
    assert!(!none.exists());
}

#[test]
fn small_and_empty_models_have_a_chart() {
    let dir = tempfile::tempdir().unwrap();
    let chart = dir.path().join("a.svg");
    for (source, more) in [(SQUARE, 12), ("v 0 0 0\nv 1 0 0\n", 13)] {
        let mut command = tristrip();
        command.args(["strip", "-", "--json", "--pareto"]).arg(&chart).write_stdin(source);
        let report = json(&mut command);
        let strips = points(&report).iter().filter(|point| point["label"] != "list");
        assert!(strips.clone().all(|point| point["optimal"] == true));
        // Without faces, the list has as few indices as the strips.
        let label = format!("\ninput, sequential, sgi and {more} more\n");
        assert!(fs::read_to_string(&chart).unwrap().contains(&label));
    }
}
