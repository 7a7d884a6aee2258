//! `tristrip strip`: reports, files, streams, several inputs, and errors.

use std::fs;

use super::{SQUARE, json, keys, model, tristrip};
use predicates::prelude::*;
use predicates::str::{contains, is_empty};
use serde_json::Value;

const FIGURES: [&str; 15] = [
    "triangles",
    "strips",
    "isolated",
    "swaps",
    "vertices_sent",
    "gl_cost",
    "indices_restart",
    "indices_degenerate",
    "vertices_per_triangle",
    "indices_restart_per_triangle",
    "indices_degenerate_per_triangle",
    "acmr_fifo_16",
    "acmr_fifo_32",
    "atvr_fifo_16",
    "atvr_fifo_32",
];

#[test]
fn cache_optimizes_for_its_vertex_cache_and_reports_its_misses() {
    let run = |objective: &str, cache: &str| {
        let mut command = tristrip();
        let method = format!("cache:objective={objective},vertex-cache={cache}");
        command.args(["strip", "--json", "-m", &method]);
        let report = json(command.arg(model("wingnut.ply")));
        assert_eq!(report["proven"], true);
        assert_eq!(
            (report["objective"].as_str(), report["vertex_cache"].as_str()),
            (Some(objective), Some(cache))
        );
        (report["indices_restart"].as_u64().unwrap(), report["acmr"].as_f64().unwrap(), report)
    };
    let [indices, balanced, misses] =
        ["indices", "balanced", "misses"].map(|objective| run(objective, "fifo:16"));
    assert!(indices.0 < balanced.0 && balanced.0 < misses.0);
    assert!(indices.1 > balanced.1 && balanced.1 > misses.1);
    assert_eq!(misses.2["acmr"], misses.2["acmr_fifo_16"]);
    let larger = run("misses", "fifo:24");
    assert!(larger.1 < misses.1 && larger.2["atvr"].as_f64().unwrap() >= 1.0);
    let report = json(tristrip().args(["strip", "--json"]).arg(model("wingnut.ply")));
    assert!(report.get("acmr").is_none() && report.get("vertex_cache").is_none());
    let mut command = tristrip();
    command.args(["strip", "-m", "cache:vertex-cache=lru:8"]).arg(model("wingnut.ply"));
    command.assert().success().stdout(contains("misses, lru:8 (ACMR)"));
}

#[test]
fn json_has_the_documented_keys_in_order() {
    let report = json(tristrip().args(["strip", "--json"]).arg(model("fish_control.ply")));
    let mut expected = vec!["file", "seconds", "method", "cost", "effort", "seed", "proven"];
    expected.extend(FIGURES);
    expected.extend([
        "stopped",
        "bound",
        "mesh",
        "parts",
        "notes",
        "output",
        "layout",
        "drawn",
        "before",
        "after",
        "vertex_order",
        "error",
    ]);
    assert_eq!(keys(&report), expected);
    assert_eq!(keys(&report["seconds"]), ["load", "dual", "stripify", "verify", "write"]);
    let mesh = [
        "vertices",
        "faces",
        "triangles",
        "components",
        "boundary_edges",
        "non_manifold_edges",
        "inconsistent_edges",
        "isolated_faces",
        "degenerate_faces",
        "duplicate_faces",
        "unreferenced_vertices",
        "cut_polygons",
        "fanned_polygons",
        "welded_vertices",
    ];
    assert_eq!(keys(&report["mesh"]), mesh);
}

#[test]
fn figures_are_consistent() {
    for name in ["fish_control.ply", "milktruck.glb", "catmark_bishop.ply"] {
        let report = json(tristrip().args(["strip", "--json"]).arg(model(name)));
        let figure = |key: &str| report[key].as_u64().unwrap();
        assert_eq!(report["proven"], true);
        assert_eq!(report["method"], "best");
        assert_eq!(figure("indices_restart"), figure("vertices_sent") + figure("strips") - 1);
        assert_eq!(figure("gl_cost"), figure("vertices_sent") - figure("swaps"));
        assert_eq!(figure("vertices_sent"), figure("triangles") + 2 * figure("strips") + figure("swaps"));
        assert!(figure("indices_degenerate") > figure("vertices_sent"));
        assert!(report["acmr_fifo_32"].as_f64() <= report["acmr_fifo_16"].as_f64());
        assert!(report["atvr_fifo_16"].as_f64() >= Some(1.0));
        assert_eq!(report["mesh"]["triangles"], report["triangles"]);
    }
}

#[test]
fn the_report_contains_the_method_and_its_options() {
    let mut command = tristrip();
    let method = "stripe-local:triangulation=partial,ties=random,seed=7";
    command.args(["strip", "--json", "--method", method]);
    let report = json(command.arg(model("fish_control.ply")));
    assert_eq!(keys(&report)[2..7], ["method", "triangulation", "ties", "seed", "proven"]);
    assert_eq!(
        (&report["triangulation"], &report["ties"]),
        (&Value::from("partial"), &Value::from("random"))
    );
    let report = json(tristrip().args(["strip", "--json", "-m", "stripe"]).arg(model("fish_control.ply")));
    assert_eq!(report["method"], "stripe-global");
    assert_eq!((&report["patches"], &report["cutoff"]), (&Value::from("rows"), &Value::from(5)));
}

#[test]
fn text_goes_to_stdout_and_stages_to_stderr() {
    let stages = contains("load ").and(contains("mesh ")).and(contains("dual ")).and(contains("stripify "));
    let proven = contains("every face exactly once, with its original winding (112 faces)");
    tristrip()
        .arg("strip")
        .arg(model("fish_control.ply"))
        .assert()
        .success()
        .stdout(contains("indices, restart").and(contains("% of the list")).and(contains("ATVR")))
        .stderr(stages.and(proven));
    let quiet = || {
        let mut command = tristrip();
        command.args(["strip", "-q"]).arg(model("fish_control.ply"));
        command
    };
    let both =
        tristrip().args(["strip", "-q"]).args([model("fish_control.ply"), model("milktruck.glb")]).assert();
    both.success().stdout(contains("fish_control.ply\n").and(contains("milktruck.glb\n")));
    quiet().assert().success().stdout(contains("indices, restart")).stderr("");
    let dir = tempfile::tempdir().unwrap();
    quiet().arg("-o").arg(dir.path().join("a.glb")).assert().success().stdout("").stderr("");
}

#[test]
fn every_format_and_layout_is_written_and_proven() {
    let dir = tempfile::tempdir().unwrap();
    for source in ["fish_control.ply", "milktruck.glb"] {
        for (file, layout) in [
            ("a.glb", "degenerate"),
            ("b.glb", "restart"),
            ("c.glb", "separate"),
            ("d.glb", "list"),
            ("e.ply", "restart"),
            ("f.ply", "degenerate"),
            ("g.ply", "separate"),
            ("h.ply", "list"),
            ("i.obj", "list"),
        ] {
            let path = dir.path().join(file);
            let mut command = tristrip();
            command.args(["strip", "--json", "--layout", layout]).arg(model(source)).arg("-o").arg(&path);
            let report = json(&mut command);
            assert_eq!(report["layout"], layout);
            assert_eq!(report["output"], path.display().to_string());
            assert!(report["seconds"]["write"].as_f64() > Some(0.0));
            tristrip().arg("verify").arg(model(source)).arg(&path).assert().success();
        }
    }
}

#[test]
fn the_default_layout_depends_on_the_format() {
    let dir = tempfile::tempdir().unwrap();
    for (file, layout) in [("a.glb", "degenerate"), ("a.ply", "restart"), ("a.OBJ", "list")] {
        let mut command = tristrip();
        command.args(["strip", "--json"]).arg(model("fish_control.ply")).arg("-o").arg(dir.path().join(file));
        assert_eq!(json(&mut command)["layout"], layout);
    }
}

#[test]
fn a_flat_shaded_model_is_written_as_a_list() {
    let dir = tempfile::tempdir().unwrap();
    let triangle =
        |i: usize| format!("v {i} 0 0\nv {i} 1 0\nv {i} 0 1\nf {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3);
    let (input, output) = (dir.path().join("flat.obj"), dir.path().join("flat.glb"));
    fs::write(&input, (0..30).map(triangle).collect::<String>()).unwrap();
    let run = |extra: &[&str]| {
        let mut command = tristrip();
        command.args(["strip", "--json"]).args(extra).arg(&input).arg("-o").arg(&output);
        json(&mut command)
    };
    let report = run(&[]);
    assert_eq!(report["drawn"].to_string(), r#"{"found":0,"stored":0,"list":1}"#);
    assert_eq!((&report["before"]["indices"], &report["after"]["indices"]), (&90.into(), &90.into()));
    assert_eq!(report["before"]["bytes"], fs::metadata(&input).unwrap().len());
    assert_eq!(report["after"]["bytes"], fs::metadata(&output).unwrap().len());
    assert!(report["notes"][0].as_str().unwrap().starts_with("1 part drawn as faces"));
    let report = run(&["--layout", "degenerate"]);
    assert_eq!((&report["drawn"]["found"], &report["before"]["indices"]), (&1.into(), &90.into()));
    assert!(report["after"]["indices"].as_u64() > Some(90));
    let restart = run(&["--layout", "restart"]);
    assert!(restart["notes"].to_string().contains("three.js"));
    let text = tristrip().arg("strip").arg(&input).arg("-o").arg(&output).assert().success();
    text.stdout(contains("before").and(contains("after")))
        .stderr(contains("flat.glb, ").and(contains(", faces")));
}

#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    let dir = tempfile::tempdir().unwrap();
    for name in ["milktruck.glb", "hand.ply", "self_intersect_a.ply"] {
        for method in ["best", "sgi", "stripe", "stripe-local"] {
            let bytes = |threads: &str| {
                let path = dir.path().join(format!("{threads}.glb"));
                let mut command = tristrip();
                command.args(["strip", "-q", "--threads", threads, "-m", method]).arg(model(name));
                command.arg("-o").arg(&path).assert().success();
                fs::read(path).unwrap()
            };
            let one = bytes("1");
            assert!(one == bytes("2") && one == bytes("7"), "{name} by {method}");
        }
    }
}

#[test]
fn meshes_are_read_from_stdin_and_written_to_stdout() {
    let file = fs::read(model("fish_control.ply")).unwrap();
    let piped = tristrip()
        .args(["strip", "-", "-o", "-", "--to", "glb"])
        .write_stdin(file.clone())
        .assert()
        .success()
        .stderr(contains("proven").and(contains("indices, restart")));
    let glb = piped.get_output().stdout.clone();
    assert!(glb.starts_with(b"glTF"));
    tristrip()
        .arg("verify")
        .arg(model("fish_control.ply"))
        .arg("-")
        .write_stdin(glb)
        .assert()
        .success()
        .stdout(contains("proven: - draws every face of ").and(contains("(112 faces)")));
    tristrip().args(["strip", "-", "--from", "ply", "-q"]).write_stdin(file).assert().success();
    tristrip()
        .args(["strip", "-", "--from", "off"])
        .write_stdin(SQUARE)
        .assert()
        .code(1)
        .stderr(contains("tristrip: -: "));
}

#[test]
fn a_bad_input_does_not_stop_the_others() {
    let dir = tempfile::tempdir().unwrap();
    let bad = dir.path().join("bad.obj");
    fs::write(&bad, "v 0 0 zero\n").unwrap();
    let out = dir.path().join("out");
    let assert = tristrip()
        .args(["strip", "--json", "--to", "ply", "-o"])
        .arg(&out)
        .arg(model("fish_control.ply"))
        .arg(&bad)
        .arg(dir.path().join("none.ply"))
        .arg(model("milktruck.glb"))
        .assert()
        .code(1)
        .stderr(contains("bad.obj: line 1: found `zero`, expected a number for z"))
        .stderr(contains("none.ply: no such file or directory"));
    let reports: Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    let reports = reports.as_array().unwrap();
    let proven: Vec<_> = reports.iter().map(|report| report["proven"].as_bool()).collect();
    assert_eq!(proven, [Some(true), None, None, Some(true)]);
    assert_eq!(reports[1]["error"], "line 1: found `zero`, expected a number for z");
    assert_eq!(reports[0]["error"], Value::Null);
    assert_eq!(keys(&reports[1]), ["file", "seconds", "error"], "no outcome of what could not be read");
    let mut written: Vec<_> = fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name()).collect();
    written.sort();
    assert_eq!(written, ["fish_control.ply", "milktruck.ply"]);
}

#[test]
fn bad_inputs_have_messages_and_exit_code_1() {
    let dir = tempfile::tempdir().unwrap();
    let empty = dir.path().join("empty.ply");
    fs::write(&empty, "").unwrap();
    let fails = |path: &std::path::Path, message: &str| {
        let name = format!("tristrip: {}: ", path.display());
        tristrip()
            .arg("strip")
            .arg(path)
            .assert()
            .code(1)
            .stdout(is_empty())
            .stderr(contains(name).and(contains(message)));
    };
    fails(&empty, "byte 0: found an empty file, expected a non-empty PLY file");
    fails(dir.path(), "found a directory, expected a file");
    fails(&dir.path().join("none.obj"), "no such file or directory");
    let nan = dir.path().join("nan.obj");
    fs::write(&nan, "v nan 0 0\nf 1 1 1\n").unwrap();
    fails(&nan, "nan");
}

#[test]
fn a_model_without_faces_is_not_an_error() {
    let report = json(tristrip().args(["strip", "--json", "-"]).write_stdin("v 0 0 0\n"));
    assert_eq!((&report["triangles"], &report["proven"]), (&Value::from(0), &Value::from(true)));
    assert_eq!(report["indices_restart"], 0);
    tristrip().args(["strip", "-"]).write_stdin("v 0 0 0\n").assert().success();
}

#[test]
fn outputs_that_cannot_be_written_are_errors() {
    let dir = tempfile::tempdir().unwrap();
    for (target, message) in [
        ("no/place.glb", "no/place.glb: no such file or directory"),
        ("no/such/", "no/such: no such file or directory"),
        ("x.glb/", "x.glb: several inputs need a directory, but this is a file"),
    ] {
        fs::write(dir.path().join("x.glb"), "a file").unwrap();
        let target = format!("{}/{target}", dir.path().display());
        tristrip()
            .arg("strip")
            .arg(model("fish_control.ply"))
            .args(["-o", &target])
            .assert()
            .failure()
            .stderr(contains(message));
    }
    let locked = dir.path().join("locked.glb");
    fs::write(&locked, "old").unwrap();
    let mut permissions = fs::metadata(&locked).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&locked, permissions).unwrap();
    tristrip()
        .arg("strip")
        .arg(model("fish_control.ply"))
        .arg("-o")
        .arg(&locked)
        .assert()
        .code(1)
        .stderr(contains("locked.glb: the file is read-only"));
    assert_eq!(fs::read(&locked).unwrap(), b"old");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_device_is_an_error_and_a_closed_pipe_is_not() {
    let full = || std::process::Stdio::from(fs::OpenOptions::new().write(true).open("/dev/full").unwrap());
    let run = |stdout: std::process::Stdio| {
        std::process::Command::new(assert_cmd::cargo::cargo_bin!("tristrip"))
            .args(["strip", "--json"])
            .arg(model("fish_control.ply"))
            .stdout(stdout)
            .output()
            .unwrap()
    };
    let output = run(full());
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("standard output: "));
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let output = run(writer.into());
    assert_eq!(output.status.code(), Some(0));
}

#[test]
fn welding_joins_strips_across_seams_and_stays_proven() {
    // Two triangles whose common edge has separate vertices on each side.
    let seam = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 4 5 6\n";
    let strips = |weld: &[&str]| json(tristrip().args(["strip", "--json", "-"]).args(weld).write_stdin(seam));
    assert_eq!(strips(&[])["strips"], 2);
    let welded = strips(&["--weld"]);
    assert_eq!((&welded["strips"], &welded["proven"]), (&Value::from(1), &Value::from(true)));
    assert_eq!(welded["mesh"]["welded_vertices"], 2);
}

#[test]
fn dropped_and_unusual_elements_are_reported() {
    let odd = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nf 2 3 1\nf 1 1 2\n";
    tristrip()
        .args(["strip", "-"])
        .write_stdin(odd)
        .assert()
        .success()
        .stderr(contains("1 degenerate face dropped"))
        .stderr(contains("1 duplicate face kept"))
        .stderr(contains("1 vertex not used by any face"));
    tristrip()
        .args(["strip", "-", "--no-verify"])
        .write_stdin(odd)
        .assert()
        .success()
        .stderr(contains("verify    skipped"));
}

#[test]
fn malformed_files_give_a_message_and_never_a_panic() {
    let bad = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/bad");
    let files: Vec<_> = fs::read_dir(bad).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() >= 60);
    for file in files {
        let name = format!("tristrip: {}: ", file.display());
        tristrip().args(["strip", "-q"]).arg(&file).assert().code(1).stdout("").stderr(contains(name));
    }
}

#[test]
fn vertices_with_different_morph_targets_are_not_welded() {
    let file = model("../issues/weld_morph_targets.glb");
    for command in ["strip", "compare"] {
        let report = json(tristrip().args([command, "--weld", "--json"]).arg(&file));
        assert_eq!(report["mesh"]["welded_vertices"], 0);
        assert_eq!(report["mesh"]["components"], 2);
        assert!(report["notes"][0].as_str().unwrap().starts_with("not welded: "), "{}", report["notes"]);
    }
}

#[test]
fn no_directory_is_created_under_the_name_of_a_file() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out.glb");
    let inputs = [model("fish_control.ply"), model("hand.ply")];
    tristrip()
        .arg("strip")
        .args(&inputs)
        .arg("-o")
        .arg(&out)
        .assert()
        .code(2)
        .stderr(contains("names a file"));
    assert!(!out.exists());
}
