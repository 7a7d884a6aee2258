//! Wrong usage: exit code 2, a message that names the flag, and no output. Help and version.

use super::{model, tristrip};
use predicates::prelude::*;
use predicates::str::{contains, is_empty};

fn refused(arguments: &[&str], message: &str) {
    tristrip()
        .args(arguments)
        .assert()
        .code(2)
        .stdout(is_empty())
        .stderr(contains("error: ").and(contains(message)));
}

#[test]
fn negative_numbers_are_values_out_of_range() {
    refused(&["simplify", "a.ply", "--ratio", "-1"], "found `-1`, expected a ratio from 0 to 1");
    refused(&["simplify", "a.ply", "--triangles", "-3"], "invalid value '-3' for '--triangles <N>'");
    refused(&["simplify", "a.ply", "--error", "-0.5"], "found `-0.5`, expected a distance");
    refused(&["lod", "a.ply", "--base", "-1"], "found `-1`, expected a ratio from 0 to 1");
    refused(&["lod", "a.ply", "--level", "-1"], "invalid value '-1' for '--level <LEVEL>'");
}

/// With the feature, `serve.rs` tests the server.
#[cfg(not(feature = "serve"))]
#[test]
fn a_build_without_the_server_says_how_to_get_it() {
    let command = "`cargo install --path crates/tristrip-cli --features serve --profile dist`";
    let serve = ["serve", "models", "--port", "80", "--tls-key=key.pem"];
    for arguments in [&serve[..], &["serve"], &["view", "a.ply", "--no-open"], &["view"]] {
        refused(arguments, command);
        let mut help = tristrip();
        help.arg(arguments[0]).arg("--help").assert().success().stdout(contains(command));
    }
}

#[test]
fn options_belong_to_their_methods() {
    refused(
        &["strip", "a.ply", "--ties", "random"],
        "--ties belongs to --method stripe-local or stripe-global, not to best",
    );
    refused(&["strip", "a.ply", "-m", "sgi", "--triangulation", "static"], "--triangulation belongs to");
    refused(&["strip", "a.ply", "-m", "stripe-local", "--patches", "rows"], "--patches belongs to");
    refused(&["strip", "a.ply", "-m", "sequential", "--cutoff", "5"], "--cutoff belongs to");
    refused(&["strip", "a.ply", "-m", "sgi", "--seed", "1"], "--seed belongs to --method best, fewest");
    refused(&["strip", "a.ply", "-m", "stripe", "--last-tie", "first"], "--last-tie belongs to --method sgi");
    refused(
        &["strip", "a.ply", "-m", "eta", "--effort", "3"],
        "--effort belongs to --method best, fewest or cache",
    );
    refused(&["strip", "a.ply", "-m", "best", "--effort", "10"], "10 is not in 0..=9");
    refused(&["strip", "a.ply", "-m", "fewest", "--cost", "gl"], "--cost belongs to --method best");
    refused(&["strip", "a.ply", "-m", "sgi", "--budget", "1s"], "--budget belongs to");
    refused(&["strip", "a.ply", "-m", "best", "--budget", "soon"], "--budget");
    refused(&["strip", "a.ply", "-m", "best", "--tunnel-length", "3"], "--tunnel-length belongs to");
    refused(&["strip", "a.ply", "-m", "tunnel", "--threshold", "3"], "--threshold belongs to --method eta");
    refused(&["strip", "a.ply", "-m", "tunnel", "--start", "sgi"], "--start belongs to --method eta");
    refused(
        &["strip", "a.ply", "-m", "guided-tunnels", "--acceptance", "breadth-first"],
        "--acceptance belongs to --method eta, not to guided-tunnels",
    );
    refused(&["strip", "a.ply", "-m", "tunnel", "--localization", "none"], "--localization belongs to");
    refused(&["strip", "a.ply", "-m", "stripe", "--cutoff", "0"], "--cutoff");
    refused(
        &["strip", "a.ply", "-m", "best", "--vertex-cache", "fifo:8"],
        "--vertex-cache belongs to --method cache",
    );
    refused(
        &["strip", "a.ply", "--objective", "misses"],
        "--objective belongs to --method cache, not to best",
    );
    refused(
        &["strip", "a.ply", "-m", "cache", "--vertex-cache", "fifo:0"],
        "`fifo:N` or `lru:N`, N from 1 to 65536",
    );
    refused(&["strip", "a.ply", "-m", "magic"], "possible values: best");
}

#[test]
fn outputs_fit_their_formats() {
    refused(&["strip", "a.ply", "-o", "b.xyz"], "b.xyz: unknown extension");
    refused(&["strip", "a.ply", "-o", "b.stl"], "cannot write STL; use .glb, .gltf, .ply or .obj");
    refused(
        &["strip", "a.ply", "-o", "b.bin", "--to", "gltf"],
        "glTF has its buffer in this file; use .gltf",
    );
    refused(&["strip", "a.ply", "-o", "-", "--to", "gltf"], "cannot hold the two files of a .gltf");
    refused(&["strip", "a.ply", "-o", "b.obj", "--layout", "restart"], "OBJ has no strips");
    refused(&["strip", "a.ply", "-o", "-"], "-o - needs --to");
    refused(&["strip", "a.ply", "b.ply", "-o", "-", "--to", "glb"], "-o - takes one input");
    refused(&["strip", "a.ply", "-o", "-", "--to", "glb", "--json"], "both write to standard output");
    refused(&["strip", "a.ply", "--layout", "list"], "--output");
    refused(&["strip", "a.ply", "--reorder-vertices"], "--output");
    refused(
        &["strip", "a/x.ply", "b/x.obj", "-o", "out/"],
        "both a/x.ply and b/x.obj would be written to this file",
    );
    refused(&["convert", "a.ply"], "-o is needed");
}

#[test]
fn an_output_does_not_replace_an_input() {
    let dir = tempfile::tempdir().unwrap();
    let inside = dir.path().join("a.ply");
    std::fs::copy(model("fish_control.ply"), &inside).unwrap();
    let mut command = tristrip();
    command.args(["strip", "--to", "ply", "-o"]).arg(dir.path()).arg(&inside);
    command.assert().code(2).stderr(contains("the output would replace the input"));
    let mut command = tristrip();
    command.arg("strip").args([&inside, &inside]).arg("-o").arg(&inside);
    command.assert().code(2).stderr(contains("several inputs need a directory"));
}

#[test]
fn flags_are_checked() {
    refused(&["strip"], "<INPUT>");
    refused(&["strip", "-", "-"], "standard input (-) can be read only once");
    refused(&["verify", "-", "-"], "standard input (-) can be read only once");
    refused(&["verify", "a.ply"], "<RESULT>");
    refused(&["strip", "a.ply", "--threads", "0"], "--threads");
    refused(&["strip", "a.ply", "--from", "doc"], "possible values: obj");
    refused(&["compare", "a.ply", "--json", "--markdown"], "cannot be used with");
    refused(
        &["analyze", "a.ply", "--vertex-caches", "fifo:0"],
        "found `fifo:0`, expected KIND:N or KIND:N..M",
    );
    refused(&["analyze", "a.ply", "--vertex-caches", "fifo:4,mru:8"], "found `mru:8`");
    refused(&["analyze", "a.ply", "--vertex-caches", "fifo:1..65536"], "more than 1024 vertex caches");
    refused(&["analyze", "a.ply", "--plot", "a.png"], "--plot writes SVG");
    refused(&["analyze", "a", "b", "c", "d", "--plot", "a.svg"], "--plot takes at most 3 inputs");
    refused(&["strip", "a.ply", "--pareto", "a.png"], "--pareto writes SVG");
    refused(&["strip", "a", "b", "c", "d", "--pareto", "a.svg"], "--pareto takes at most 3 inputs");
    let both = ["strip", "a.ply", "--pareto", "a.svg", "--to", "ply", "-o", "a.svg"];
    refused(&both, "-o and --pareto name the same file");
    refused(&["strip", "a.ply", "--pareto", "a.svg", "--objective", "misses"], "--objective belongs to");
    refused(&["simplify", "a.ply", "--weight", "uv=-1"], "uv=-1");
    refused(&["simplify", "a.ply", "--ratio", "1.5"], "found `1.5`, expected a ratio from 0 to 1");
    refused(&["simplify", "a.ply", "--ratio", "5%", "--triangles", "9"], "cannot be used with");
    refused(&["simplify", "a.ply", "--triangles", "few"], "--triangles");
    refused(&["simplify", "a.ply", "--error=-1%"], "found `-1%`, expected a distance");
    refused(&["simplify", "a.ply", "--ratio", "5%", "-o", "b.stl"], "cannot write STL");
    refused(&["simplify", "a.ply", "--ratio", "5%", "--layout", "list"], "--layout");
    refused(
        &["simplify", "a.ply", "--ratio", "5%", "-o", "-", "--to", "glb", "--json"],
        "both write to standard output",
    );
    refused(&["lod", "a.ply", "--level", "140%"], "found `140%`, expected a number such as 120");
    refused(&["lod", "a.ply", "--base", "0..1"], "found `0..1`, expected a ratio from 0 to 1");
    refused(&["lod", "a.ply", "--filter", "fog"], "possible values: none, stss, dtfs");
    let effort = ["lod", "a.ply", "--filter", "dtfs", "--filter-effort", "3"];
    refused(&effort, "--filter-effort belongs to --filter repair, not to dtfs");
    refused(&["lod", "a.ply", "--filter-effort", "10"], "10 is not in 0..=9");
    refused(&["lod", "a.ply", "--model", "magic"], "possible values: progressive");
    refused(&["lod", "a.ply", "--plot", "a.png"], "--plot writes SVG");
    refused(&["lod", "a", "b", "c", "d", "--plot", "a.svg"], "--plot takes at most 3 inputs");
    refused(
        &["lod", "a.ply", "--to", "ply", "-o", "a.svg", "--plot", "a.svg"],
        "-o and --plot name the same file",
    );
    refused(&["lod", "a.ply", "-m", "sgi", "--effort", "3"], "--effort belongs to");
    refused(&["lod", "a.ply", "-o", "b.obj", "--layout", "restart"], "OBJ has no strips");
    refused(&["paint", "a.ply"], "unrecognized subcommand");
}

#[test]
fn help_has_a_short_and_a_long_form() {
    for subcommand in ["strip", "compare", "analyze", "verify", "convert", "simplify", "lod"] {
        let length = |flag: &str| {
            let output = tristrip().args([subcommand, flag]).assert().success().get_output().stdout.clone();
            output.len()
        };
        assert!(length("-h") < length("--help"), "{subcommand}");
    }
    tristrip().arg("--help").assert().success().stdout(contains("Exit codes: 0 done and proven"));
    tristrip()
        .arg("--version")
        .assert()
        .success()
        .stdout(format!("tristrip {}\n", env!("CARGO_PKG_VERSION")));
    for subcommand in ["strip", "verify", "man"] {
        let version = tristrip().args([subcommand, "--version"]).assert().success();
        version.stdout(format!("tristrip {}\n", env!("CARGO_PKG_VERSION")));
    }
    tristrip().assert().code(2).stderr(contains("Usage: tristrip [OPTIONS] <COMMAND>"));
}

#[test]
fn shared_flags_may_stand_before_the_subcommand() {
    let fish = model("fish_control.ply");
    let before = tristrip().args(["-q", "--json", "--threads", "1", "strip"]).arg(&fish).assert().success();
    let after =
        tristrip().arg("strip").arg(&fish).args(["-q", "--json", "--threads", "1"]).assert().success();
    let report = |assert: &assert_cmd::assert::Assert| -> serde_json::Value {
        serde_json::from_slice(&assert.get_output().stdout).unwrap()
    };
    assert_eq!(report(&before.stderr(""))["vertices_sent"], report(&after.stderr(""))["vertices_sent"]);
    refused(&["--json", "strip", "a.ply", "-o", "-", "--to", "glb"], "both write to standard output");
    refused(&["--json", "compare", "a.ply", "--markdown"], "cannot be used with");
}

#[test]
fn a_pattern_in_quotes_has_a_hint() {
    let hint = contains("models/*.obj: no such file or directory; a pattern in quotes is not expanded");
    tristrip().args(["strip", "models/*.obj"]).assert().code(1).stderr(hint);
    let plain = tristrip().args(["strip", "none.obj"]).assert().code(1);
    plain.stderr(contains("none.obj: no such file or directory\n"));
}

#[test]
fn completions_and_man_pages_name_every_flag() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let output = tristrip().args(["completions", shell]).assert().success().get_output().stdout.clone();
        let text = String::from_utf8(output).unwrap();
        assert!(
            ["strip", "reorder-vertices", "filter-effort"].iter().all(|name| text.contains(name)),
            "{shell}"
        );
    }
    let page = |arguments: &[&str]| {
        let output = tristrip().arg("man").args(arguments).assert().success().get_output().stdout.clone();
        String::from_utf8(output).unwrap()
    };
    let (whole, lod) = (page(&[]), page(&["lod"]));
    assert!(whole.contains(".TH tristrip 1") && whole.contains("Exit codes"));
    assert!(["strip", "compare", "simplify"].iter().all(|name| whole.contains(name)));
    assert!(lod.contains(".TH tristrip-lod 1") && lod.contains("filter\\-effort"), "{lod}");
    refused(&["man", "paint"], "unknown subcommand \"paint\"");
    refused(&["completions", "cmd"], "possible values: bash");
}

#[test]
fn colours_are_for_terminals() {
    let error = |variables: &[(&str, &str)]| {
        let mut command = tristrip();
        command.args(["strip", "none.ply"]).env_remove("NO_COLOR").env_remove("CLICOLOR_FORCE");
        let assert = command.envs(variables.iter().copied()).assert().code(1);
        String::from_utf8(assert.get_output().stderr.clone()).unwrap()
    };
    assert!(!error(&[]).contains('\x1b'), "no terminal");
    assert!(error(&[("CLICOLOR_FORCE", "1")]).contains("\x1b[1m\x1b[31mtristrip:\x1b[0m none.ply"));
    assert!(!error(&[("CLICOLOR_FORCE", "1"), ("NO_COLOR", "1")]).contains('\x1b'));
}
