//! End-to-end tests of the command: arguments, files and streams in; bytes, text, JSON and exit
//! codes out.

#![expect(clippy::panic, reason = "a test that panics fails")]

mod analyze;
mod build_lod;
mod camera_level;
mod chain;
mod compare;
mod convert;
mod defaults;
mod documents;
mod help;
mod level;
mod library;
mod materials;
mod picture;
mod progressive;
mod reorder;
mod search;
#[cfg(feature = "serve")]
mod serve;
mod simplify;
mod strip;
mod usage;
mod verify;

use std::path::PathBuf;

use assert_cmd::Command;
use serde_json::Value;

/// All subcommands, in the order of `docs/cli.md`.
const SUBCOMMANDS: [&str; 19] = [
    "strip",
    "simplify",
    "convert",
    "chain",
    "level",
    "camera-level",
    "build-lod",
    "pack",
    "unpack",
    "serve",
    "view",
    "analyze",
    "compare",
    "bound",
    "inspect",
    "verify",
    "help",
    "completions",
    "man",
];

/// Returns the command under test.
fn tristrip() -> Command {
    Command::new(assert_cmd::cargo::cargo_bin!("tristrip"))
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

/// Returns the keys of an object, in the order printed.
fn keys(value: &Value) -> Vec<&str> {
    value.as_object().into_iter().flat_map(|object| object.keys()).map(String::as_str).collect()
}

/// A square of two triangles as OBJ.
const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
