//! End-to-end tests of `tristrip-lab`: arguments and files in; bytes, text, JSON and exit codes
//! out.

#![expect(clippy::panic, reason = "a test that panics fails")]

mod documents;
mod fly;
mod levels;
mod pareto;
mod repro;
mod wire;

use std::path::PathBuf;

use assert_cmd::Command;
use serde_json::Value;

/// Returns the command under test.
fn lab() -> Command {
    Command::new(assert_cmd::cargo::cargo_bin!("tristrip-lab"))
}

/// Returns the path of a test model.
fn model(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../testdata/models").join(name)
}

/// Runs a command that must succeed, and parses its standard output as JSON.
fn json(command: &mut Command) -> Value {
    let output = command.assert().success().get_output().stdout.clone();
    serde_json::from_slice(&output).unwrap_or_else(|error| panic!("standard output is not JSON: {error}"))
}

/// Returns the keys of an object, in printed order.
fn keys(value: &Value) -> Vec<&str> {
    value.as_object().into_iter().flat_map(|object| object.keys()).map(String::as_str).collect()
}

/// Returns a number of a report.
fn number(report: &Value, key: &str) -> u64 {
    report[key].as_u64().unwrap_or_else(|| panic!("{key} is no number: {report}"))
}

/// A square of two triangles as OBJ.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
