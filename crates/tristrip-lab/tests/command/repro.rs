//! `tristrip-lab repro`: pages, charts and JSON of papers, on the available models.

use std::fs;
use std::path::Path;

use super::{json, keys, lab, model};
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

/// Reproduces papers with the models of one directory, and writes to another.
fn repro(papers: &str, models: &Path, output: &Path) -> Command {
    let mut command = lab();
    command.args(["repro", "--papers", papers, "--models"]).arg(models).arg("-o").arg(output);
    command
}

/// Creates a directory with a small model under the names of models in papers.
fn models() -> std::io::Result<tempfile::TempDir> {
    let dir = tempfile::tempdir()?;
    for name in ["goblet", "hand", "triceratops"] {
        fs::copy(model("fish_control.ply"), dir.path().join(format!("{name}.ply")))?;
    }
    fs::write(dir.path().join("porsche.ply"), "ply\nnonsense\n")?;
    for name in ["dodge", "dragon", "empty"] {
        fs::write(dir.path().join(format!("{name}.obj")), "v 0 0 0\n")?;
    }
    Ok(dir)
}

#[test]
fn available_models_are_measured_and_missing_ones_marked() {
    let (models, output) = (models().unwrap(), tempfile::tempdir().unwrap());
    // Some meshes have no faces.
    let report = json(repro("003,004", models.path(), output.path()).arg("--json"));
    assert_eq!(keys(&report), ["models", "papers", "notes", "outputs", "error"]);
    let papers = report["papers"].as_array().unwrap();
    let paper_keys = ["key", "authors", "title", "year", "page", "tables", "charts", "claims", "left_out"];
    assert_eq!(keys(&papers[0]), paper_keys);
    let rows = papers[0]["tables"][2]["rows"].as_array().unwrap();
    let verdict = |name: &str| rows.iter().find(|row| row["model"] == name).unwrap()["verdict"].clone();
    // The counts match neither model.
    assert_eq!(verdict("Goblet"), "stand-in: goblet");
    assert_eq!(verdict("Hand"), "stand-in: hand");
    assert_eq!(verdict("Heart"), "model not available");
    assert_eq!(verdict("Bunny"), "model not available");
    let cell = &rows[0]["columns"][2];
    assert_eq!(keys(cell), ["column", "flags", "published", "measured", "verdict"]);
    assert!(cell["published"] == 0.91 && cell["measured"].as_f64().unwrap() > 0.5);
    // A file that is not a model causes a note, not a failure.
    assert_eq!(report["notes"].as_array().unwrap().len(), 1);
    assert!(report["notes"][0].as_str().unwrap().starts_with("porsche: "));
    for file in ["003.md", "003-figure-7.svg", "004.md", "004-figure-9.svg", "004-figure-27.svg"] {
        assert!(output.path().join("reproduction").join(file).is_file(), "{file}");
    }
    assert!(!output.path().join("reproduction/000.md").exists());
    for page in ["003.md", "004.md"] {
        let page = fs::read_to_string(output.path().join("reproduction").join(page)).unwrap();
        assert!(!page.contains("NaN") && !page.contains("inf |"), "{page}");
    }
}

#[test]
fn pages_are_the_same_every_time() {
    let (models, output) = (models().unwrap(), tempfile::tempdir().unwrap());
    let read = |name: &str| fs::read(output.path().join("docs/reproduction").join(name)).unwrap();
    let all = || ["000.md", "000-figure-16.svg", "000-figure-20.svg"].map(read);
    let docs = output.path().join("docs");
    repro("000", models.path(), &docs).args(["--threads", "1"]).assert().success();
    let first = all();
    repro("000", models.path(), &docs)
        .args(["--threads", "3"])
        .assert()
        .success()
        .stdout(contains("paper 000"))
        .stderr(contains("triceratops").and(contains("note")));
    assert_eq!(first, all());
    let page = String::from_utf8(first[0].clone()).unwrap();
    assert!(page.contains("stand-in: triceratops") && page.contains("model not available"));
    assert!(!page.contains(&*models.path().to_string_lossy()), "the page contains no path");
}

#[test]
fn pages_with_more_measurements_are_kept() {
    let (all, output) = (models().unwrap(), tempfile::tempdir().unwrap());
    let read = |name: &str| fs::read(output.path().join("reproduction").join(name)).unwrap();
    let files = ["003.md", "003-figure-7.svg"];
    repro("003", all.path(), output.path()).assert().success();
    let before = files.map(read);
    fs::remove_file(all.path().join("hand.ply")).unwrap();
    let report = json(repro("003", all.path(), output.path()).arg("--json"));
    assert_eq!(files.map(read), before, "a run without the hand keeps the page");
    let note = report["notes"].to_string();
    assert!(note.contains("003.md and its figures were kept: ") && note.contains("Hand"), "{note}");
    assert_eq!(
        (&report["outputs"], &report["papers"][0]["page"]),
        (&serde_json::json!([]), &serde_json::Value::Null)
    );
    // With all models again, the page is written.
    fs::copy(model("wingnut.ply"), all.path().join("hand.ply")).unwrap();
    repro("003", all.path(), output.path()).assert().success();
    assert_ne!(files.map(read), before);
    // Without any model, nothing is written.
    let (none, empty) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let report = json(repro("003", none.path(), empty.path()).arg("--json"));
    assert!(report["notes"][0].as_str().unwrap().ends_with("were not written: none of the models was found"));
    assert_eq!(fs::read_dir(empty.path().join("reproduction")).unwrap().count(), 0);
}

#[test]
fn nothing_is_measured_if_a_folder_cannot_be_read_or_written() {
    let (models, output) = (models().unwrap(), tempfile::tempdir().unwrap());
    let file = output.path().join("file");
    fs::write(&file, "old").unwrap();
    repro("004", models.path(), &file).assert().code(1).stderr(contains("file: "));
    assert_eq!(fs::read(&file).unwrap(), b"old");
    let deep = output.path().join("a/b");
    repro("004", models.path(), &deep).assert().code(1).stderr(contains("no such file or directory"));
    let missing = output.path().join("nowhere");
    let report =
        repro("004", &missing, output.path()).arg("--json").assert().code(1).get_output().stdout.clone();
    let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
    assert!(report["error"].as_str().unwrap().contains("nowhere: no such file or directory"));
}

#[test]
fn levels_of_detail_are_measured() {
    let (models, output) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fs::copy(model("wingnut.ply"), models.path().join("bunny.ply")).unwrap();
    fs::write(models.path().join("cow.obj"), "v 0 0 0\n").unwrap();
    let report = json(repro("001", models.path(), output.path()).arg("--json"));
    let paper = &report["papers"][0];
    let rows = paper["tables"][2]["rows"].as_array().unwrap();
    let bunny = rows.iter().find(|row| row["model"] == "Bunny").unwrap();
    assert_eq!(bunny["verdict"], "stand-in: bunny");
    let measured = |column: usize| bunny["columns"][column]["measured"].as_f64().unwrap_or(f64::NAN);
    // No filter, STSS, DTFS and repair, in percent of single triangles.
    assert!((1..4).all(|column| measured(column) < measured(column - 1)), "{bunny}");
    let series = paper["charts"][0]["panels"][0]["series"].as_array().unwrap();
    assert!(series.iter().all(|series| series["points"].as_array().is_some_and(|points| points.len() > 50)));
    for file in ["001.md", "001-figure-9.svg", "001-figure-11.svg"] {
        let text = fs::read_to_string(output.path().join("reproduction").join(file)).unwrap();
        assert!(!text.contains("NaN"), "{file}");
    }
}

#[test]
fn a_section_is_measured_by_itself_and_keeps_the_rest_of_the_page() {
    let (models, output) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    fs::copy(model("wingnut.ply"), models.path().join("bunny.ply")).unwrap();
    fs::copy(model("fish_control.ply"), models.path().join("triceratops.ply")).unwrap();
    let path = output.path().join("reproduction");
    let section = |name: &str| {
        let mut command = repro("000", models.path(), output.path());
        command.args(["--section", name]);
        command
    };
    let report = json(section("skip-strips").args(["--json", "--threads", "1"]));
    let tables = report["papers"][0]["tables"].as_array().unwrap();
    assert_eq!(
        tables.iter().map(|table| table["name"].as_str().unwrap()).collect::<Vec<_>>(),
        ["table 3", "table 4", "merge trees"]
    );
    let measured = |row: usize, column: usize| tables[0]["rows"][row]["columns"][column]["measured"].clone();
    // The published fraction of the 6090 triangles, and all of them.
    assert!((measured(0, 0).as_f64().unwrap() - 6090.0 * 10.2 / 69.4).abs() < 20.0);
    assert_eq!([measured(2, 0), measured(2, 1)].map(|figure| figure.as_f64()), [Some(6090.0), Some(18270.0)]);
    let page = || fs::read_to_string(path.join("000.md")).unwrap();
    let first = page();
    assert!(first.contains("## Table 3\n") && !first.contains("## Table 1\n"), "{first}");
    assert!(first.contains("stand-in: bunny") && first.contains("](000-figure-21.png)"));
    assert!(!first.contains("NaN") && !first.contains("inf |"));
    for file in ["000-figure-21.png", "000-figure-23.png"] {
        assert!(fs::read(path.join(file)).unwrap().starts_with(b"\x89PNG"), "{file}");
    }
    assert!(!path.join("000-figure-16.svg").exists());

    // The other section is added, and each section is kept when the other one is measured, also
    // without its models.
    section("strips").assert().success();
    let both = page();
    assert!(both.contains("## Table 1\n") && both.contains("stand-in: triceratops"), "{both}");
    assert!(
        both.contains("## Claims in the text\n") && both.contains("## Claims in the text: skip-strips\n")
    );
    fs::remove_file(models.path().join("triceratops.ply")).unwrap();
    let picture = || fs::read(path.join("000-figure-21.png")).unwrap();
    let before = picture();
    section("skip-strips").args(["--threads", "3"]).assert().success();
    assert_eq!((page(), picture()), (both.clone(), before));
    let report = json(repro("000", models.path(), output.path()).arg("--json"));
    assert!(report["notes"][0].as_str().unwrap().contains("were kept"), "{report}");
    assert_eq!(page(), both);
}

#[test]
fn papers_and_sections_are_known_by_their_names() {
    for (arguments, message) in [
        (
            &["repro", "--papers", "004,999", "-o", "docs"][..],
            "unknown paper \"999\"; known papers: 000, 001, 002, 003, 004",
        ),
        (&["repro", "--papers", "004"][..], "--output"),
        (
            &["repro", "--section", "skip", "-o", "docs"][..],
            "unknown section \"skip\"; known sections of these papers: levels, skip-strips, strips",
        ),
        (
            &["repro", "--papers", "003", "--section", "skip-strips", "-o", "docs"][..],
            "unknown section \"skip-strips\"; known sections of these papers: strips",
        ),
    ] {
        lab().args(arguments).assert().code(2).stderr(contains("error: ").and(contains(message)));
    }
}
