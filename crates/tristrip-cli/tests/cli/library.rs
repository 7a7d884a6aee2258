//! The command as a library: several runs in one process, and runs under another name.

use std::ffi::OsString;
use std::fs;

use super::model;

/// Regression: the second run with one thread failed, since a thread never leaves a pool.
#[test]
fn a_process_runs_several_commands() {
    let dir = tempfile::tempdir().unwrap();
    let strip = |threads: &str, name: &str| {
        let output = dir.path().join(name);
        let mut arguments =
            ["tristrip", "strip", "-q", "--threads", threads, "-o"].map(OsString::from).to_vec();
        arguments.extend([output.clone().into(), model("fish_control.ply").into()]);
        assert_eq!(tristrip_cli::run(arguments), 0, "{name}");
        fs::read(output).unwrap()
    };
    let first = strip("1", "a.glb");
    assert_eq!(tristrip_cli::run(["tristrip", "bound", "-q", "none.ply", "--threads", "1"]), 1);
    for (threads, name) in [("1", "b.glb"), ("3", "c.glb"), ("1", "d.glb")] {
        assert_eq!(strip(threads, name), first, "{name}");
    }
    assert_eq!(tristrip_cli::run(["tristrip", "strip", "-q"]), 2);
    assert_eq!(tristrip_cli::run(["tristrip", "--version"]), 0);
}

#[cfg(unix)]
#[test]
fn the_name_does_not_depend_on_the_program() {
    use std::os::unix::process::CommandExt;

    use predicates::str::contains;

    let command = || {
        let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin!("tristrip"));
        command.arg0("/usr/bin/python3");
        assert_cmd::Command::from_std(command)
    };
    command().arg("-h").assert().code(0).stdout(contains("Usage: tristrip [OPTIONS] <COMMAND>"));
    command().args(["bound", "-h"]).assert().code(0).stdout(contains("Usage: tristrip bound"));
    command().arg("--version").assert().code(0).stdout(format!("tristrip {}\n", env!("CARGO_PKG_VERSION")));
    command().arg("bound").assert().code(2).stderr(contains("Usage: tristrip bound"));
    command().arg("--unknown").assert().code(2).stderr(contains("Usage: tristrip"));
}
