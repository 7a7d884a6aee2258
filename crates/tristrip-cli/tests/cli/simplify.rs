//! `tristrip simplify`: goals, errors, shared vertices and outputs.

use std::fs;
use std::path::Path;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;

/// Simplifies a test model into a file, and returns the report.
fn simplify(name: &str, arguments: &[&str], output: &Path) -> Value {
    json(tristrip().args(["simplify", "--json"]).args(arguments).arg(model(name)).arg("-o").arg(output))
}

fn number(report: &Value, key: &str) -> u64 {
    report[key].as_u64().unwrap_or_else(|| panic!("{key} is no number"))
}

#[test]
fn the_report_has_its_keys_and_describes_the_file() {
    let dir = tempfile::tempdir().unwrap();
    for extension in ["ply", "obj", "glb"] {
        let path = dir.path().join("small").with_extension(extension);
        let report = simplify("hand.ply", &["--ratio", "5%"], &path);
        let expected = [
            "file",
            "seconds",
            "proven",
            "target_triangles",
            "target_error",
            "reached",
            "triangles_before",
            "triangles_after",
            "collapses",
            "surface_error",
            "surface_error_percent",
            "diagonal",
            "vanished_components",
            "locked_vertices",
            "vertices_kept",
            "vertices_before",
            "vertices_after",
            "largest_deviation",
            "largest_deviation_percent",
            "rms_deviation",
            "rms_deviation_percent",
            "normal_deviation_degrees",
            "uv_deviation_percent",
            "uv_deviation_texels",
            "normals",
            "parts",
            "warning",
            "notes",
            "output",
            "error",
        ];
        assert_eq!(keys(&report), expected);
        assert_eq!(
            keys(&report["seconds"]),
            ["load", "dual", "simplify", "fit", "compare", "verify", "write"]
        );
        assert_eq!((&report["proven"], &report["reached"]), (&Value::from(true), &Value::from(true)));
        assert_eq!((number(&report, "triangles_before"), number(&report, "target_triangles")), (15_982, 799));
        let (left, collapses) = (number(&report, "triangles_after"), number(&report, "collapses"));
        assert!(left <= 799 && left > 700, "{left}");
        // The hand is closed: a collapse removes two triangles and a vertex.
        assert_eq!(15_982 - left, 2 * collapses);
        assert_eq!(number(&report, "vertices_after"), 7993 - collapses);
        let stored = json(tristrip().args(["analyze", "--json"]).arg(&path));
        assert_eq!(
            (&stored["triangles"], &stored["vertices"]),
            (&Value::from(left), &report["vertices_after"])
        );
        let again = json(tristrip().args(["strip", "--json", "-m", "input"]).arg(&path));
        assert_eq!(again["mesh"]["unreferenced_vertices"], 0);
        assert_eq!((&again["mesh"]["components"], &again["mesh"]["boundary_edges"]), (&1.into(), &0.into()));
    }
}

#[test]
fn each_stage_has_a_line_and_the_results_follow() {
    let mut command = tristrip();
    command.args(["simplify", "--triangles", "9000", "--fit"]).arg(model("hand.ply"));
    let assert = command.assert().success();
    let text = String::from_utf8(assert.get_output().stderr.clone()).unwrap();
    let names: Vec<_> = text.lines().skip(1).map(|line| line.split_whitespace().next().unwrap()).collect();
    let stages = ["load", "dual", "mesh", "simplify", "verify", "fit", "rebuild", "compare"];
    let results = ["mesh", "result", "result", "proven"];
    assert_eq!(names, [&stages[..], &results].concat(), "{text}");
}

#[test]
fn an_error_limit_holds_alone_and_with_a_triangle_count() {
    let run = |arguments: &[&str]| {
        json(tristrip().args(["simplify", "--json"]).args(arguments).arg(model("hand.ply")))
    };
    let by_error = run(&["--error", "0.05%"]);
    assert!(by_error["target_triangles"].is_null() && by_error["reached"] == true);
    assert!(by_error["surface_error"].as_f64() <= by_error["target_error"].as_f64());
    assert!(by_error["surface_error_percent"].as_f64() <= Some(0.0501));
    let left = number(&by_error, "triangles_after");
    assert!(left > 10 && left < 15_982, "{left}");
    // The same limit in mesh units, and reached before the triangle count.
    let units = by_error["target_error"].to_string();
    assert_eq!(number(&run(&["--error", &units]), "triangles_after"), left);
    let both = run(&["--error", "0.05%", "--triangles", "10"]);
    assert_eq!((number(&both, "triangles_after"), &both["reached"]), (left, &Value::from(false)));
    let warning = both["warning"].as_str().unwrap();
    assert!(
        warning.contains("(10 requested)") && warning.contains("the error limit of 0.05 % of the diagonal"),
        "{warning}"
    );
    assert!(
        both["vertices_kept"]["error"].as_u64() > Some(0)
            && by_error["vertices_kept"].is_null()
            && by_error["warning"].is_null()
    );
    let none = run(&["--ratio", "1"]);
    assert_eq!((number(&none, "collapses"), &none["surface_error"]), (0, &Value::from(0.0)));
}

#[test]
fn a_goal_out_of_reach_is_not_an_error() {
    let mut command = tristrip();
    command.args(["simplify", "-", "--triangles", "0"]).write_stdin(SQUARE);
    command
        .assert()
        .success()
        .stderr(contains("warning: ").and(contains("stopped at 2 triangles (0 requested)")))
        .stdout(contains("triangles"));
    // A warning is shown in quiet mode, too.
    let mut command = tristrip();
    command.args(["simplify", "-q", "-", "--triangles", "0"]).write_stdin(SQUARE);
    command.assert().success().stderr(contains("(0 requested)"));
}

#[test]
fn one_percent_of_the_diagonal_is_the_default_limit() {
    let run = |arguments: &[&str]| {
        json(tristrip().args(["simplify", "--json"]).args(arguments).arg(model("hand.ply")))
    };
    let default = run(&[]);
    let limit = default["diagonal"].as_f64().unwrap() / 100.0;
    assert!((default["target_error"].as_f64().unwrap() / limit - 1.0).abs() < 1e-6);
    assert!(default["surface_error"].as_f64() <= default["target_error"].as_f64());
    assert_eq!(number(&run(&["--error", "1%"]), "triangles_after"), number(&default, "triangles_after"));
    let held = run(&["--ratio", "0.1%"]);
    assert_eq!(
        (&held["reached"], number(&held, "triangles_after")),
        (&false.into(), number(&default, "triangles_after"))
    );
    let free = run(&["--ratio", "0.1%", "--error", "100%"]);
    assert!(free["reached"] == true && number(&free, "triangles_after") <= 16, "{free}");
    // The reported values were measured on the result.
    assert!(free["largest_deviation_percent"].as_f64() > held["largest_deviation_percent"].as_f64());
    assert!(held["largest_deviation"].as_f64() > held["rms_deviation"].as_f64());
    assert!(held["normal_deviation_degrees"].as_f64() > Some(1.0) && held["uv_deviation_percent"].is_null());
}

/// The edges of the body are rounded: with few triangles its flat sides end at vertices with
/// normals between two sides.
#[test]
fn normals_that_no_longer_fit_are_repaired() {
    let dir = tempfile::tempdir().unwrap();
    let glb = dir.path().join("truck.glb");
    let of = |mode: &str| simplify("milktruck.glb", &["--ratio", "20%", "--normals", mode], &glb);
    let [auto, keep] = ["auto", "keep"].map(of);
    assert!(number(&auto["normals"], "repaired") >= 1, "{auto}");
    assert_eq!(number(&auto["normals"], "kept") + number(&auto["normals"], "repaired"), 4);
    assert_eq!((&keep["normals"]["kept"], &keep["normals"]["repaired"]), (&4.into(), &0.into()));
    assert_eq!(auto["triangles_after"], keep["triangles_after"]);
    let degrees = [&auto, &keep].map(|report| report["normal_deviation_degrees"].as_f64().unwrap());
    assert!(degrees[0] < degrees[1] - 0.2, "{degrees:?}");
}

#[test]
fn parts_stay_connected_and_the_scene_unchanged() {
    let dir = tempfile::tempdir().unwrap();
    let (glb, ply) = (dir.path().join("truck.glb"), dir.path().join("truck.ply"));
    let report = simplify("milktruck.glb", &["--ratio", "50%"], &glb);
    assert_eq!(report["parts"], 4);
    assert_eq!(number(&report, "locked_vertices"), 0);
    let notes = report["notes"].to_string();
    assert!(!notes.contains("unused"), "{notes}");
    let before = fs::metadata(model("milktruck.glb")).unwrap().len();
    assert!(fs::metadata(&glb).unwrap().len() < before - 20_000);
    let stored = json(tristrip().args(["analyze", "--json"]).arg(&glb));
    assert_eq!(stored["triangles"], report["triangles_after"]);
    let bytes = fs::read(&glb).unwrap();
    let has = |word: &[u8]| bytes.windows(word.len()).any(|window| window == word);
    assert!(has(b"\"materials\"") && has(b"\"matrix\""));
    // No unused vertex is kept in any format.
    let again = json(tristrip().args(["strip", "--json", "-m", "input"]).arg(&glb));
    assert_eq!(again["mesh"]["unreferenced_vertices"], 0);
    let report = simplify("milktruck.glb", &["--triangles", "1500"], &ply);
    assert_eq!(number(&report, "target_triangles"), 1500);
    let again = json(tristrip().args(["strip", "--json", "-m", "input"]).arg(&ply));
    assert_eq!(again["mesh"]["unreferenced_vertices"], 0);
}

#[test]
fn locked_borders_are_named_where_they_hold_a_model() {
    let fan = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
    for goal in [["simplify", "--triangles", "1"], ["chain", "--ratios", "1%"]] {
        let mut command = tristrip();
        command.args(goal).args(["--lock-borders", "-"]).write_stdin(fan);
        command.assert().success().stderr(contains("4 vertices at locked open borders; "));
    }
}

#[test]
fn the_sides_of_a_narrow_gap_collapse_together() {
    // Two sheets of 40 × 4 and 40 × 6 squares, bent, with a gap of 0.001 between x = 0 and x =
    // 0.001; each with a material of its own or not.
    let sheets = |materials: bool| {
        let mut lines = Vec::new();
        let mut first = 1;
        for (name, columns, end, side) in [("left", 4, 0.0, -1.0), ("right", 6, 0.001, 1.0)] {
            lines.extend(materials.then(|| format!("usemtl {name}")));
            for (x, y) in
                (0..=40).flat_map(|y| (0..=columns).map(move |x| (f64::from(x), f64::from(y) / 4.0)))
            {
                let z = 0.3 * (1.7 * y).sin() + 0.02 * (x * 7.0 % 5.0);
                lines.push(format!("v {} {y} {z}", end + side * 5.0 * x / f64::from(columns)));
            }
            for i in 0..40 * columns {
                let a = first + i / columns * (columns + 1) + i % columns;
                let [b, c, d] = [a + 1, a + columns + 2, a + columns + 1];
                lines.push(if side > 0.0 {
                    format!("f {a} {b} {c} {d}")
                } else {
                    format!("f {b} {a} {d} {c}")
                });
            }
            first += 41 * (columns + 1);
        }
        lines.join("\n")
    };
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("small.obj");
    // The positions along the border where vertices remain, on both sides.
    let sides = |materials: bool, rules: &[&str]| {
        let mut small = tristrip();
        small.args(["simplify", "--quiet", "--error", "0.2", "-", "-o"]).arg(&path).args(rules);
        small.write_stdin(sheets(materials)).assert().success();
        let text = fs::read_to_string(&path).unwrap();
        let vertices = text.lines().filter_map(|line| line.strip_prefix("v "));
        let (mut left, mut right) = (Vec::new(), Vec::new());
        for vertex in vertices {
            let [x, y, _] =
                vertex.split(' ').map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>().try_into().unwrap();
            if x == 0.0 {
                left.push(y);
            } else if (x - 0.001).abs() < 1e-6 {
                right.push(y);
            }
        }
        (left, right)
    };
    for materials in [false, true] {
        let (left, right) = sides(materials, &["--weld-distance", "0.002"]);
        // The complete border may disappear, unless materials meet there.
        assert!(left == right && left.len() < 20 && left.is_empty() != materials, "{left:?} {right:?}");
        let (left, right) = sides(materials, &[]);
        assert!(left != right, "apart: {left:?}");
    }
}

#[test]
fn results_are_deterministic_for_every_mesh() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["fish_control.ply", "wingnut.ply", "chair_nonmanifold.ply", "milktruck.glb"] {
        if !model(name).exists() {
            continue;
        }
        let bytes = ["1", "2", "7"].map(|threads| {
            let path = dir.path().join(threads).with_extension("ply");
            simplify(name, &["--ratio", "20%", "--threads", threads], &path);
            fs::read(path).unwrap()
        });
        assert!(bytes[0] == bytes[1] && bytes[1] == bytes[2], "{name}");
    }
}

#[test]
fn models_without_faces_or_extent_are_accepted() {
    let dir = tempfile::tempdir().unwrap();
    let soup = (0..20).map(|i| format!("v {i} 0 0\nv {i} 1 0\nv {i} 0 1\n")).collect::<Vec<_>>().concat();
    let faces = (0..20)
        .map(|i| format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3))
        .collect::<Vec<_>>()
        .concat();
    let flat = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n";
    for (number, text) in ["v 1 2 3\n", flat, &[soup, faces].concat()].iter().enumerate() {
        for extension in ["ply", "obj", "glb"] {
            let path = dir.path().join(number.to_string()).with_extension(extension);
            let mut command = tristrip();
            command.args(["simplify", "-", "--ratio", "10%", "-o"]).arg(&path).write_stdin(*text);
            command.assert().success();
            assert!(path.exists());
        }
    }
}

#[test]
fn bad_inputs_and_outputs_are_reported_and_the_others_processed() {
    let dir = tempfile::tempdir().unwrap();
    let bad = dir.path().join("bad.ply");
    fs::write(&bad, "ply\nnonsense\n").unwrap();
    let mut command = tristrip();
    command.args(["simplify", "--json", "--ratio", "50%"]).arg(&bad).arg(model("wingnut.ply"));
    let output = command.assert().code(1).get_output().stdout.clone();
    let reports: Value = serde_json::from_slice(&output).unwrap();
    assert!(reports[0]["error"].is_string() && reports[0]["triangles_after"].is_null());
    assert!(reports[1]["error"].is_null() && reports[1]["reached"] == true);
    let nowhere = dir.path().join("no/such/folder/a.ply");
    let mut command = tristrip();
    command.args(["simplify", "--ratio", "50%"]).arg(model("wingnut.ply")).arg("-o").arg(nowhere);
    command.assert().code(1).stderr(contains("no such file or directory"));
    tristrip().args(["simplify", "missing.ply", "--ratio", "5%"]).assert().code(1);
}

/// A triangle that an animation of 32 keyframes rotates back and forth, in a directory.
fn turning_triangle(folder: &Path) -> std::io::Result<std::path::PathBuf> {
    let floats = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].into_iter();
    let times = (0..32_u8).map(f32::from);
    let rotations = [[0.0, 0.0, 0.0, 1.0], [0.6, 0.0, 0.0, 0.8]].into_iter().cycle().take(32);
    let all = floats.chain(times).chain(rotations.flatten());
    let bytes: Vec<u8> = all.flat_map(f32::to_le_bytes).collect();
    fs::write(folder.join("turning.bin"), &bytes)?;
    let view = |start: usize, length: usize| serde_json::json!({"buffer": 0, "byteOffset": start, "byteLength": length});
    let accessor = |view: usize, count: usize, kind: &str| serde_json::json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
    let json = serde_json::json!({
        "asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{"samplers": [{"input": 1, "output": 2}], "channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}]}],
        "accessors": [accessor(0, 3, "VEC3"), accessor(1, 32, "SCALAR"), accessor(2, 32, "VEC4")],
        "bufferViews": [view(0, 36), view(36, 128), view(164, 512)],
        "buffers": [{"uri": "turning.bin", "byteLength": bytes.len()}],
    });
    let path = folder.join("turning.gltf");
    fs::write(&path, json.to_string())?;
    Ok(path)
}

#[test]
fn compact_rounds_rotations_and_nothing_else_does() {
    let folder = tempfile::tempdir().unwrap();
    let source = turning_triangle(folder.path()).unwrap();
    let written = |arguments: &[&str]| {
        let out = folder.path().join("out.gltf");
        tristrip().arg("simplify").arg(&source).args(arguments).arg("-o").arg(&out).assert().success();
        let json: Value = serde_json::from_slice(&fs::read(out).unwrap()).unwrap();
        let output = json["animations"][0]["samplers"][0]["output"].as_u64().unwrap() as usize;
        (
            json["accessors"][output]["componentType"].clone(),
            json["buffers"][0]["byteLength"].as_u64().unwrap(),
        )
    };
    let (exact, rounded) = (written(&[]), written(&["--compact"]));
    assert_eq!((exact.0, rounded.0), (5126.into(), 5122.into()));
    assert_eq!(exact.1, rounded.1 + 256);
}

#[test]
fn fit_moves_positions_and_reports_them() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("small.glb");
    let [before, after] = [&[][..], &["--fit"]].map(|fit: &[&str]| {
        simplify("hand.ply", &[fit, &["--ratio", "5%", "--error", "100%"]].concat(), &out)
    });
    assert!(before.get("moved_positions").is_none() && before["seconds"]["fit"].is_null());
    let moved = number(&after, "moved_positions");
    // The hand is closed: almost all positions move.
    assert!(moved <= number(&after, "vertices_after") && moved > 300, "{moved}");
    assert!(after["seconds"]["fit"].is_number() && after["proven"] == true);
    assert_eq!(number(&before, "triangles_after"), number(&after, "triangles_after"));
    for key in ["rms_deviation", "largest_deviation"] {
        let [before, after] = [&before, &after].map(|report| report[key].as_f64().unwrap());
        assert!(
            after < if key == "rms_deviation" { 0.75 * before } else { before },
            "{key}: {before} {after}"
        );
    }
    let mut command = tristrip();
    let command = command.args(["simplify", "--ratio", "5%", "--fit"]).arg(model("hand.ply"));
    command.assert().success().stderr(contains("positions moved closer to the original"));
    // Levels of detail share the vertices of the input.
    let mut command = tristrip();
    let command = command.args(["chain", "--ratios", "100%,50%", "--fit"]).arg(model("hand.ply")).arg("-o");
    command.arg(&out).assert().failure().code(2);
}
