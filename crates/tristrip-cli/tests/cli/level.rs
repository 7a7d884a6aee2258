//! `tristrip level`: levels of detail drawn with the strips of the full mesh.

use std::fs;
use std::path::Path;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::str::contains;
use serde_json::Value;

const FILTERS: [&str; 5] = ["none", "stss", "dtfs", "linked", "repair"];

/// Returns the report of a fast method on a test model.
fn lod(name: &str, arguments: &[&str]) -> Value {
    json(tristrip().args(["level", "--json", "-m", "stripe"]).args(arguments).arg(model(name)))
}

fn number(report: &Value, key: &str) -> u64 {
    report[key].as_u64().unwrap_or_else(|| panic!("{key} is no number"))
}

fn path(path: &Path) -> &str {
    path.to_str().unwrap_or_else(|| panic!("no text: {}", path.display()))
}

#[test]
fn levels_range_from_the_base_mesh_to_the_full_mesh() {
    let of = |level: &str| lod("hand.ply", &["--level", level]);
    let (base, some, full) = (of("0"), of("40%"), of("100%"));
    let levels = number(&full, "levels");
    assert_eq!(
        lod("hand.ply", &[])["level"],
        of("10%")["level"],
        "the default shows a level of detail, not the full mesh"
    );
    assert_eq!((number(&base, "level"), number(&full, "level")), (0, levels));
    assert_eq!(number(&some, "level"), (4 * levels + 5) / 10);
    assert_eq!(number(&full, "triangles"), number(&full, "triangles_full"));
    assert_eq!(number(&base, "triangles"), number(&base, "triangles_base"));
    // The hand is closed: each vertex adds two triangles.
    for report in [&base, &some, &full] {
        assert_eq!(number(report, "triangles"), number(&base, "triangles") + 2 * number(report, "level"));
        assert_eq!(report["proven"], true);
    }
    assert!(
        number(&base, "triangles") <= 799 && base["surface_error"].as_f64() > some["surface_error"].as_f64()
    );
    assert_eq!(full["surface_error"], 0.0);
    // The full mesh is drawn by its own strips.
    let strip = json(tristrip().args(["strip", "--json", "-m", "stripe"]).arg(model("hand.ply")));
    assert!(number(&full, "vertices_sent") <= number(&strip, "vertices_sent"));
    let unfiltered = lod("hand.ply", &["--filter", "none", "--level", "100%"]);
    assert_eq!(
        (&unfiltered["vertices_sent"], &unfiltered["strips"]),
        (&strip["vertices_sent"], &strip["strips"])
    );
}

#[test]
fn a_level_is_selected_by_what_it_has_to_reach() {
    let full = number(&lod("hand.ply", &["--level", "100%"]), "triangles");
    let of_count = lod("hand.ply", &["--triangles", "1000"]);
    assert_eq!((number(&of_count, "triangles"), &of_count["pixels"]), (1000, &Value::Null));
    // Goals use the coarsest base mesh unless --base is given. They are met as far as the base mesh
    // allows.
    let few = lod("hand.ply", &["--triangles", "200"]);
    assert_eq!((number(&few, "triangles"), number(&few, "level") > 0), (200, true));
    let limited = lod("hand.ply", &["--triangles", "200", "--base", "10%"]);
    assert_eq!((number(&limited, "level"), &limited["triangles"]), (0, &limited["triangles_base"]));
    let notes = |report: &Value| report["notes"].to_string();
    assert!(notes(&limited).contains("requested 200 triangles, but the base mesh has"), "{limited}");
    assert!(!notes(&few).contains("requested"));
    let error = |report: &Value| report["surface_error"].as_f64().unwrap();
    let of_error = lod("hand.ply", &["--error", "0.2%"]);
    assert!(
        of_error["surface_error_percent"].as_f64().unwrap() <= 0.2
            && number(&of_error, "triangles") < full / 4
    );
    // At twice the distance, twice the error covers as many pixels.
    let at =
        |distance: &str| lod("hand.ply", &["--model", "blocks", "--pixels", "1.5", "--distance", distance]);
    let diagonal = of_error["diagonal"].as_f64().unwrap();
    let [near, far] = [2.0, 4.0].map(|times| at(&(times * diagonal).to_string()));
    for report in [&near, &far] {
        let pixels = report["pixels"].as_f64().unwrap();
        assert!((1.2..=1.5).contains(&pixels), "{pixels}");
        assert_eq!(report["proven"], true);
    }
    assert!(error(&far) > 1.6 * error(&near) && number(&far, "triangles") < number(&near, "triangles"));
    // With half the field of view, the hand looks about twice as large.
    let zoomed =
        json(tristrip().args(["level", "--json", "-m", "stripe", "--pixels", "1.5", "--distance"]).args([
            &(4.0 * diagonal).to_string(),
            "--field-of-view",
            "23.4",
            path(&model("hand.ply")),
        ]));
    assert!((0.85..1.15).contains(&(error(&zoomed) / error(&near))));
}

#[test]
fn goals_of_levels_exclude_each_other() {
    for arguments in [
        &["--level", "10%", "--triangles", "5"][..],
        &["--error", "1%", "--triangles", "5"],
        &["--pixels", "1", "--distance", "2", "--error", "1%"],
        &["--pixels", "1"],
        &["--distance", "1"],
        &["--pixels", "1", "--distance", "-1"],
        &["--pixels", "1", "--distance", "0"],
        &["--pixels", "1", "--distance", "1", "--field-of-view", "180"],
        &["--pixels", "-1", "--distance", "1"],
        &["--pixels", "nan", "--distance", "1"],
        &["--pixels", "1", "--distance", "1", "--rows", "0"],
        &["--level", "10%", "--field-of-view", "30"],
        &["--rows", "500"],
        &["--triangles", "5", "--pixels", "1", "--distance", "5"],
    ] {
        tristrip().arg("level").args(arguments).arg(model("hand.ply")).assert().code(2);
    }
}

#[test]
fn collapses_cost_what_the_price_says() {
    let of = |price: &str| {
        let report = lod("hand.ply", &["--base", "10%", "--level", "0", "--price", price]);
        assert_eq!(report["proven"], true);
        (report["surface_error"].as_f64(), report["vertices_sent"].as_u64())
    };
    let [distance, planes, quadric] = ["distance", "planes", "quadric"].map(of);
    assert_eq!(lod("hand.ply", &["--base", "10%", "--level", "0"])["vertices_sent"].as_u64(), distance.1);
    assert!(quadric != distance && quadric != planes && planes != distance);
    // Chains and single meshes have the same collapses.
    let mut command = tristrip();
    command.args(["simplify", "--json", "--ratio", "10%", "--error", "100%", "--price", "quadric"]);
    assert_eq!(json(command.arg(model("hand.ply")))["surface_error"].as_f64(), quadric.0);
    let mut command = tristrip();
    command.args(["chain", "--ratios", "100%,10%", "--error", "100%", "--price", "quadric"]);
    command.arg(model("hand.ply")).assert().success();
}

#[test]
fn the_report_has_its_keys() {
    let report = lod("fish_control.ply", &["--level", "50%"]);
    let found = keys(&report);
    let expected = [
        "file",
        "seconds",
        "method",
        "ties",
        "patches",
        "cutoff",
        "seed",
        "levels",
        "triangles_base",
        "triangles_full",
        "diagonal",
        "stopped",
        "parts",
        "notes",
        "model",
        "filter",
        "filter_effort",
        "proven",
        "level",
        "surface_error",
        "surface_error_percent",
        "pixels",
        "triangles",
        "strips",
    ];
    assert_eq!(found[..expected.len()], expected);
    assert_eq!(found[found.len() - 3..], ["output", "layout", "error"]);
    assert_eq!((&report["model"], &report["filter"]), (&"progressive".into(), &"repair".into()));
}

#[test]
fn a_written_level_draws_the_remaining_triangles() {
    let dir = tempfile::tempdir().unwrap();
    for (file, layout) in
        [("a.ply", "restart"), ("a.glb", "degenerate"), ("b.glb", "separate"), ("a.obj", "list")]
    {
        let output = dir.path().join(file);
        for filter in FILTERS {
            let flags = ["--level", "30%", "--filter", filter, "--layout", layout, "-o", path(&output)];
            let report = lod("hand.ply", &flags);
            assert_eq!((&report["proven"], &report["layout"]), (&true.into(), &layout.into()));
            let stored = json(tristrip().args(["analyze", "--json"]).arg(&output));
            assert_eq!(stored["triangles"], report["triangles"]);
            let again = json(tristrip().args(["strip", "--json", "-m", "input"]).arg(&output));
            assert_eq!(again["mesh"]["unreferenced_vertices"], 0);
        }
    }
}

#[test]
fn the_base_mesh_equals_that_of_simplify() {
    let base = lod("hand.ply", &["--level", "0", "--base", "10%"]);
    let mut command = tristrip();
    let simple = json(command.args(["simplify", "--json", "--ratio", "10%"]).arg(model("hand.ply")));
    // Another triangle order breaks ties between equal errors differently.
    assert_eq!(base["triangles"], simple["triangles_after"]);
    let errors = [&base, &simple].map(|report| report["surface_error"].as_f64().unwrap_or(f64::NAN));
    assert!((0.5..2.0).contains(&(errors[0] / errors[1])), "{errors:?}");
}

#[test]
fn parts_share_levels_and_the_scene_is_kept() {
    let dir = tempfile::tempdir().unwrap();
    let output = dir.path().join("truck.glb");
    let report = lod("milktruck.glb", &["--level", "25%", "--base", "50%", "-o", path(&output)]);
    assert_eq!((&report["parts"], &report["proven"]), (&4.into(), &true.into()));
    assert!(!report["notes"].to_string().contains("locked"), "{report}");
    let stored = json(tristrip().args(["analyze", "--json"]).arg(&output));
    assert_eq!(stored["triangles"], report["triangles"]);
    let ply = dir.path().join("truck.ply");
    lod("milktruck.glb", &["--level", "25%", "--base", "50%", "-o", path(&ply)]);
    let stored = json(tristrip().args(["analyze", "--json"]).arg(&ply));
    assert_eq!(stored["triangles"], report["triangles"]);
}

#[test]
fn every_level_model_draws_the_level() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["progressive-mesh", "naive", "progressive", "sets"] {
        let file = folder.path().join(format!("{name}.glb"));
        let report = lod("hand.ply", &["--model", name, "--level", "40%", "-o", path(&file)]);
        assert_eq!((&report["model"], &report["proven"]), (&name.into(), &true.into()));
        let has_filter = ["naive", "progressive"].contains(&name);
        assert_eq!(report["filter"], if has_filter { "repair" } else { "none" });
        // Single triangles are written as a list, in which none has a restart or a degenerate
        // triangle after it.
        assert_eq!(report["layout"], if name == "progressive-mesh" { "list" } else { "degenerate" });
        let written = json(tristrip().args(["strip", "-m", "input", "--json"]).arg(&file));
        assert_eq!(written["triangles"], report["triangles"]);
    }
    let filtered = ["level", "--model", "sets", "--filter", "dtfs"];
    let refused = tristrip().args(filtered).arg(model("hand.ply")).assert().code(2);
    refused.stderr(contains("--filter dtfs applies to --model progressive and naive, not to sets"));
    tristrip()
        .args(["level", "--model", "sets", "--filter", "none"])
        .arg(model("hand.ply"))
        .assert()
        .success();
}

#[test]
fn levels_are_the_same_for_any_number_of_threads() {
    let dir = tempfile::tempdir().unwrap();
    let bytes = ["1", "2", "7"].map(|threads| {
        let output = dir.path().join(threads).with_extension("glb");
        let flags = ["--level", "60%", "--threads", threads, "-o", path(&output)];
        lod("milktruck.glb", &flags);
        fs::read(output).unwrap()
    });
    assert!(bytes[0] == bytes[1] && bytes[1] == bytes[2]);
}

#[test]
fn models_without_faces_or_extent_are_accepted() {
    let soup = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\nf 4 5 6\nf 1 1 2\n";
    for text in ["v 1 2 3\n", SQUARE, soup] {
        for level in ["0", "50%", "100%"] {
            let mut command = tristrip();
            command.args(["level", "-", "--json", "--level", level]).write_stdin(text);
            let report = json(&mut command);
            assert_eq!(report["proven"], true);
        }
    }
}

#[test]
fn missing_levels_and_files_are_errors() {
    let mut command = tristrip();
    command.args(["level", "-m", "sgi", "--level", "999999"]).arg(model("hand.ply"));
    command.assert().code(1).stderr(contains("level: found 999,999, expected at most 7,"));
    tristrip().args(["level", "missing.ply"]).assert().code(1).stderr(contains("no such file or directory"));
    let dir = tempfile::tempdir().unwrap();
    let bad = dir.path().join("bad.obj");
    fs::write(&bad, "v 0 0 zero\n").unwrap();
    let mut command = tristrip();
    command.args(["level", "--json", "-m", "sgi"]).arg(&bad).arg(model("fish_control.ply"));
    let output = command.assert().code(1).get_output().stdout.clone();
    let reports: Value = serde_json::from_slice(&output).unwrap();
    assert!(reports[0]["error"].is_string() && reports[0]["levels"].is_null());
    assert!(reports[1]["error"].is_null() && reports[1]["proven"] == true);
}
