//! Searches of `tristrip strip`: bounds, repeatable results, budgets and interrupts.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

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

/// Returns whether a process has a handler of SIGINT, by the mask of caught signals that Linux shows.
#[cfg(target_os = "linux")]
fn handles_interrupts(process: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    u64::from_str_radix(mask.trim(), 16).unwrap() & 1 << (2 - 1) != 0
}

/// Sends Ctrl-C during a search: the best result so far is proven and written.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_stops_a_search_with_a_proven_result() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("wingnut.glb");
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_tristrip"))
        .args(["strip", "--json", "-m", "best", "--effort", "9", "-o"])
        .arg(&out)
        .arg(model("wingnut.ply"))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    // The search takes seconds. It has started once the process handles the signal.
    while !handles_interrupts(child.id()) {
        assert!(child.try_wait().unwrap().is_none(), "the search ended before it was interrupted");
        std::thread::yield_now();
    }
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&report["stopped"], &report["proven"]), (&"interrupt".into(), &true.into()));
    assert!(out.exists());
}
