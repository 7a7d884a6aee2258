//! `docs/lab.md` agrees with the command: the samples of reports, and the keys.

use std::fs;
use std::path::PathBuf;

use super::{json, keys, lab, model};
use serde_json::Value;

fn document() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/lab.md")
}

/// The command of the sample in each section.
const SAMPLES: [&str; 2] =
    ["fly fish_control.ply --frames 30 --json", "repro --papers 000 --models . -o . --json"];

/// Sets all times of a report to the same value, and cuts arrays to their first entry, except
/// coordinates.
fn sample_of(value: &mut Value) {
    match value {
        Value::Array(entries) => {
            let coordinates = entries.len() <= 3 && entries.iter().all(Value::is_number);
            entries.truncate(if coordinates { 3 } else { 1 });
            entries.iter_mut().for_each(sample_of);
        }
        Value::Object(entries) => {
            for (key, entry) in entries.iter_mut() {
                match entry {
                    Value::Object(times) if key == "seconds" => {
                        let measured = times.values_mut().filter(|time| !time.is_null());
                        measured.for_each(|time| *time = 0.01.into());
                    }
                    entry => sample_of(entry),
                }
            }
        }
        _ => (),
    }
}

/// The samples are regenerated when `TRISTRIP_BLESS` is set.
#[test]
fn the_samples_of_reports_are_what_the_command_prints() {
    let dir = tempfile::tempdir().unwrap();
    fs::copy(model("fish_control.ply"), dir.path().join("fish_control.ply")).unwrap();
    let mut expected = fs::read_to_string(document()).unwrap();
    for line in SAMPLES {
        let mut report = json(lab().args(line.split_whitespace()).current_dir(&dir));
        sample_of(&mut report);
        let name = line.split_whitespace().next().unwrap();
        let heading = format!("### `tristrip-lab {name}`\n\n");
        let report = serde_json::to_string_pretty(&report).unwrap();
        let sample = format!("`tristrip-lab {line}` prints\n\n```json\n{report}\n```\n\n");
        let (before, section) = expected.split_once(&heading).expect("a section for each sample");
        let rest = section.strip_prefix("`tristrip-lab ").and_then(|sample| sample.split_once("\n```\n\n"));
        expected = format!("{before}{heading}{sample}{}", rest.map_or(section, |(_, rest)| rest));
    }
    if std::env::var_os("TRISTRIP_BLESS").is_some() {
        fs::write(document(), &expected).unwrap();
    }
    let found = fs::read_to_string(document()).unwrap();
    assert!(found == expected, "the samples of docs/lab.md differ from what the command prints");
}

#[test]
fn every_json_key_is_described() {
    let described = fs::read_to_string(document()).unwrap();
    let (fish, dir) = (model("fish_control.ply"), tempfile::tempdir().unwrap());
    let mut command = lab();
    command.args(["levels", "--json", "--table", "--compare", "--sweep", "linear", "-m", "input"]);
    let levels = json(command.arg(&fish));
    let (row, recovery) = (&levels["table"][0], &levels["recovery"][0]);
    let mut command = lab();
    command.args(["pareto", "--json", "--effort", "0", "-o"]).arg(dir.path().join("a.svg"));
    let pareto = json(command.arg(&fish));
    let flown = json(lab().args(["fly", "--json", "--frames", "3", "-m", "input"]).arg(&fish));
    let frame = &flown["frames"][0];
    let reports = [
        &levels,
        &levels["seconds"],
        row,
        &row["vertices_sent"],
        &row["refinement"],
        &levels["compare"][0],
        recovery,
        &recovery["tests"][0],
        &pareto,
        &pareto["pareto"][0],
        &flown,
        &flown["seconds"],
        &flown["summary"],
        &flown["summary"]["median"],
        frame,
        &frame["seconds"],
    ];
    for key in reports.into_iter().flat_map(keys) {
        assert!(described.contains(&format!("`{key}`")), "docs/lab.md does not describe `{key}`");
    }
}
