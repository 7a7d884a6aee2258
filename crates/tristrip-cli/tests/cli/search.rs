//! Searches of `tristrip strip`: bounds, repeatable results, budgets, interrupts and the lines of
//! stages.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

#[cfg(target_os = "linux")]
use std::io::{BufRead, BufReader};
#[cfg(target_os = "linux")]
use std::process::{Child, Command, Stdio};

use super::{json, keys, model, tristrip};
use serde_json::Value;

#[test]
fn searches_report_the_gap_to_their_bound() {
    let report = json(tristrip().args(["strip", "--json", "-m", "fewest"]).arg(model("hand.ply")));
    let bound = &report["bound"];
    assert_eq!(keys(bound), ["figure", "found", "bound", "gap", "optimal"]);
    assert_eq!((&bound["figure"], &bound["found"]), (&Value::from("strips"), &report["strips"]));
    assert_eq!((&bound["bound"], &bound["gap"], &bound["optimal"]), (&1.into(), &0.into(), &true.into()));
    assert_eq!(report["stopped"], Value::Null);
    for (cost, figure) in [
        ("restart", "indices_restart"),
        ("opengl", "vertices_sent"),
        ("degenerate", "indices_degenerate"),
        ("gl", "gl_cost"),
    ] {
        let mut command = tristrip();
        let method = format!("best:cost={cost}");
        command.args(["strip", "--json", "-m", &method, "--effort", "3"]);
        let report = json(command.arg(model("fish_control.ply")));
        assert_eq!((&report["cost"], &report["effort"]), (&cost.into(), &3.into()));
        assert_eq!(
            (&report["bound"]["figure"], &report["bound"]["found"]),
            (&figure.into(), &report[figure])
        );
        assert!(report["bound"]["bound"].as_u64() <= report[figure].as_u64());
    }
    let quick = json(tristrip().args(["strip", "--json"]).arg(model("fish_control.ply")));
    assert_eq!(quick["bound"], Value::Null, "the bound takes longer than the default search");
}

#[test]
fn best_is_repeatable_and_never_worse_than_the_fast_methods() {
    for name in ["fish_control.ply", "wingnut.ply", "catmark_bishop.ply"] {
        let cost = |arguments: &[&str]| {
            let report = json(tristrip().args(["strip", "--json"]).args(arguments).arg(model(name)));
            assert_eq!(report["proven"], true);
            report["indices_restart"].as_u64().unwrap()
        };
        let best = cost(&["-m", "best", "--effort", "2"]);
        assert_eq!(best, cost(&["-m", "best", "--effort", "2", "--threads", "1"]));
        for other in ["sequential", "input", "stripe", "quad-rows"] {
            assert!(best <= cost(&["-m", other]), "{name}: {other}");
        }
    }
}

#[test]
fn a_budget_stops_a_search_with_a_proven_result() {
    let report = json(
        tristrip()
            .args(["strip", "--json", "-m", "best", "--effort", "9", "--budget", "1ms"])
            .arg(model("wingnut.ply")),
    );
    assert_eq!((&report["stopped"], &report["proven"]), (&"budget".into(), &true.into()));
    assert!(report["notes"].as_array().unwrap().iter().any(|n| n.as_str().unwrap().contains("budget")));
}

/// Returns whether a process has a handler of SIGINT, by the mask of caught signals that Linux
/// shows.
#[cfg(target_os = "linux")]
fn handles_interrupts(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() & 1 << (2 - 1) != 0
}

/// Starts a search that takes seconds.
#[cfg(target_os = "linux")]
fn long_search(arguments: &[&std::ffi::OsStr]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_tristrip"))
        .args(["strip", "--json", "-m", "best", "--effort", "9"])
        .args(arguments)
        .arg(model("wingnut.ply"))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Sends Ctrl-C to a process once it handles the signal, which means that its search has started.
#[cfg(target_os = "linux")]
fn interrupt(child: &mut Child) {
    while !handles_interrupts(child.id()) {
        assert!(child.try_wait().unwrap().is_none(), "the search ended before it was interrupted");
        std::thread::yield_now();
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
}

/// Sends Ctrl-C during a search: the best result so far is proven and written.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_stops_a_search_with_a_proven_result() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("wingnut.glb");
    let mut child = long_search(&["-o".as_ref(), out.as_os_str()]);
    interrupt(&mut child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["stopped"], &report["proven"]), (&"interrupt".into(), &true.into()));
    assert!(out.exists());
}

/// Regression: the lines of all stages were printed when the operation returned. Here the lines of
/// the stages before the search are read while it runs: Ctrl-C still stops it.
#[cfg(target_os = "linux")]
#[test]
fn lines_of_stages_are_printed_when_they_end() {
    let mut child = long_search(&[]);
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let before: Vec<_> = lines.by_ref().take(4).collect();
    interrupt(&mut child);
    let after: Vec<_> = lines.collect();
    let output = child.wait_with_output().unwrap();
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["stopped"], "interrupt", "the search ended before its lines were printed");
    let names = |lines: &[String]| -> Vec<String> {
        lines.iter().map(|line| line.split_whitespace().next().unwrap().to_owned()).collect()
    };
    assert_eq!(names(&before[1..]), ["load", "dual", "mesh"], "{before:?}");
    let expected = ["stripify", "measure", "bound", "verify", "mesh", "note", "strips", "bound", "proven"];
    assert_eq!(names(&after), expected, "{after:?}");
    let has_time = |line: &String| line.ends_with(" ms") || line.ends_with(" s");
    assert!(before[1..].iter().chain(&after[..4]).all(has_time), "{before:?} {after:?}");
}
