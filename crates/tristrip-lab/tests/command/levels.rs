//! `tristrip-lab levels`: filters and level models compared.

use std::fs;
use std::path::Path;

use super::{SQUARE, json, keys, lab, model, number};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use serde_json::Value;

const FILTERS: [&str; 5] = ["none", "stss", "dtfs", "linked", "repair"];

/// Returns the report of a fast method on a test model.
fn levels(name: &str, arguments: &[&str]) -> Value {
    json(lab().args(["levels", "--json", "-m", "stripe"]).args(arguments).arg(model(name)))
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap_or_else(|| panic!("no text: {}", path.display()))
}

#[test]
fn the_report_has_its_keys() {
    let report = levels("fish_control.ply", &["--table"]);
    let expected = [
        "file",
        "method",
        "ties",
        "patches",
        "cutoff",
        "seed",
        "filter_effort",
        "seconds",
        "levels",
        "triangles_base",
        "triangles_full",
        "table",
        "compare",
        "recovery",
        "plot",
        "notes",
        "error",
    ];
    assert_eq!(keys(&report), expected);
    let row = &report["table"][0];
    assert_eq!(keys(row), ["level", "percent", "triangles", "vertices_sent", "refinement"]);
    assert_eq!(keys(&row["vertices_sent"]), [&["triangles"][..], &FILTERS].concat());
}

#[test]
fn prices_give_other_levels() {
    let of = |price: &str| {
        levels("hand.ply", &["--base", "10%", "--compare", "--price", price])["compare"].clone()
    };
    let [distance, planes, quadric] = ["distance", "planes", "quadric"].map(of);
    assert_eq!(levels("hand.ply", &["--base", "10%", "--compare"])["compare"], distance);
    assert!(quadric != distance && quadric != planes && planes != distance);
}

#[test]
fn models_without_faces_or_extent_are_accepted() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("model.obj");
    let soup = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\nf 4 5 6\nf 1 1 2\n";
    for text in ["v 1 2 3\n", SQUARE, soup] {
        fs::write(&file, text).unwrap();
        let report = json(lab().args(["levels", "--json", "--table"]).arg(&file));
        assert_eq!((&report["error"], report["table"].is_array()), (&Value::Null, true));
    }
}

#[test]
fn an_input_that_cannot_be_read_does_not_stop_the_others() {
    let mut command = lab();
    command
        .args(["levels", "--json", "--compare", "-m", "sgi", "missing.ply"])
        .arg(model("fish_control.ply"));
    let assert = command.assert().code(1).stderr(contains("missing.ply: no such file or directory"));
    let reports: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert!(reports[0]["error"].is_string() && reports[0]["levels"].is_null());
    assert!(reports[1]["error"].is_null() && reports[1]["compare"].is_array());
}

#[test]
fn a_table_has_every_filter_from_the_base_to_the_full_mesh() {
    let report = levels("wingnut.ply", &["--table", "--base", "10%"]);
    let rows = report["table"].as_array().unwrap();
    assert_eq!((rows.len(), &rows[20]["level"]), (21, &report["levels"]));
    let sent = |row: &Value, filter: &str| number(&row["vertices_sent"], filter);
    for row in rows {
        assert_eq!(sent(row, "triangles"), 3 * number(row, "triangles"));
        assert_eq!(sent(row, "none"), sent(&rows[20], "none"), "strips keep their length");
        assert!(sent(row, "linked") <= sent(row, "dtfs"));
        assert!(sent(row, "stss") <= sent(row, "none"));
    }
    let all = |filter: &str| rows.iter().map(|row| sent(row, filter)).sum::<u64>();
    assert!(all("repair") < all("linked"));
    let text = lab().args(["levels", "--table", "-m", "sgi"]).arg(model("wingnut.ply")).assert().success();
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    assert!(text.contains("Vertices sent") && text.contains("linked") && text.contains("100 %"), "{text}");
}

#[test]
fn a_comparison_sums_all_levels() {
    let report = levels("fish_control.ply", &["--compare", "--base", "40%"]);
    let totals = report["compare"].as_array().unwrap();
    let names: Vec<&str> = totals.iter().filter_map(|total| total["filter"].as_str()).collect();
    assert_eq!(names, [&["triangles"][..], &FILTERS].concat());
    assert!(totals.iter().all(|total| number(total, "vertices_sent") > 0));
    assert_eq!((&totals[0]["percent"], &totals[0]["vertices_per_triangle"]), (&100.0.into(), &3.0.into()));
    let text = lab().args(["levels", "--compare", "-m", "sgi"]).arg(model("wingnut.ply")).assert().success();
    let text = String::from_utf8(text.get_output().stdout.clone()).unwrap();
    assert!(text.contains("sum over all levels") && text.contains("100.0 %"), "{text}");
}

#[test]
fn recovery_is_measured_for_every_model() {
    let folder = tempfile::tempdir().unwrap();
    let chart = folder.path().join("recovery.svg");
    let measured = ["--compare", "--sweep", "exponential,linear", "--plot", path(&chart)];
    let report = levels("hand.ply", &measured);
    let models = report["recovery"].as_array().unwrap();
    let names: Vec<&str> = models.iter().filter_map(|model| model["model"].as_str()).collect();
    let expected =
        ["progressive-mesh", "naive", "progressive", "mts", "sets", "lod-strips", "blocks", "skip"];
    assert_eq!(names, expected);
    let levels = number(&report, "levels");
    for model in models {
        assert!(number(model, "memory") > 0 && number(model, "cursor_memory") > 0);
        let tests = model["tests"].as_array().unwrap();
        let of: Vec<_> =
            tests.iter().map(|test| (test["sweep"].as_str().unwrap(), number(test, "share"))).collect();
        let shares = [1, 3, 6, 10, 15, 20];
        let expected: Vec<_> =
            ["linear", "exponential"].iter().flat_map(|sweep| shares.map(|share| (*sweep, share))).collect();
        assert_eq!(of, expected);
        for test in tests {
            assert_eq!(number(test, "moves"), 2 * (levels * number(test, "share") / 100).max(1));
            assert!(test["microseconds"].as_f64().unwrap() >= 0.0);
        }
    }
    assert!(fs::read_to_string(&chart).unwrap().contains("microseconds per move"));
    // Times are also printed as text.
    let shown = lab().args(["levels", "-m", "stripe", "--sweep", "linear"]).arg(model("hand.ply")).assert();
    shown.success().stdout(contains("Recovery of a share of all levels").and(contains("lod-strips")));
    lab().arg("levels").arg(model("hand.ply")).assert().code(2);
    lab().args(["levels", "--sweep", "square"]).arg(model("hand.ply")).assert().code(2);
}

#[test]
fn a_chart_shows_every_model() {
    let dir = tempfile::tempdir().unwrap();
    let plot = dir.path().join("levels.svg");
    let mut command = lab();
    command
        .args(["levels", "-m", "sgi", "--plot"])
        .arg(&plot)
        .arg(model("hand.ply"))
        .arg(model("wingnut.ply"));
    command.assert().success();
    let svg = fs::read_to_string(&plot).unwrap();
    for words in ["hand.ply", "wingnut.ply", "as triangles", "dtfs", "linked", "vertices sent"] {
        assert!(svg.contains(words), "{words}");
    }
    let again = dir.path().join("again.svg");
    let mut command = lab();
    command.args(["levels", "-m", "sgi", "--threads", "1", "--plot"]).arg(&again);
    command.arg(model("hand.ply")).arg(model("wingnut.ply")).assert().success();
    assert_eq!(svg, fs::read_to_string(&again).unwrap());
    let missing = dir.path().join("no/such/folder/a.svg");
    let mut command = lab();
    command.args(["levels", "-m", "sgi", "--plot"]).arg(missing).arg(model("fish_control.ply"));
    command.assert().code(1).stderr(contains("no such file or directory"));
}
