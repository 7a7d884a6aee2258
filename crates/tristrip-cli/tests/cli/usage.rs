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
    refused(&["level", "a.ply", "--base", "-1"], "found `-1`, expected a ratio from 0 to 1");
    refused(&["level", "a.ply", "--level", "-1"], "invalid value '-1' for '--level <LEVEL>'");
}

/// With the feature, `serve.rs` tests the server.
#[cfg(not(feature = "serve"))]
#[test]
fn a_build_without_the_server_says_how_to_get_it() {
    let command = "`cargo install --path crates/tristrip-cli --features serve --profile dist`";
    let serve = ["serve", "models", "--port", "80", "--tls-key=key.pem"];
    for arguments in [&serve[..], &["serve"], &["view", "a.ply", "--no-open"], &["view"]] {
        refused(arguments, command);
        let help = tristrip().args([arguments[0], "--help"]).assert().success();
        // The help is wrapped.
        let help = String::from_utf8_lossy(&help.get_output().stdout).replace('\n', " ");
        assert!(help.contains(command), "{help}");
    }
}

#[test]
fn parameters_belong_to_their_methods() {
    for (method, message) in [
        ("magic", "found `magic`, expected best, sequential, fewest, cache"),
        (
            "best:ties=random",
            "found `ties` in `best:ties=random`, expected one of the parameters cost, effort and seed",
        ),
        ("sgi:seed=1", "found `seed` in `sgi:seed=1`, expected the parameter last-tie"),
        ("sequential:cutoff=5", "expected no parameters for sequential"),
        (
            "stripe:cutoff=0",
            "parameter `cutoff`: found `0` in `stripe:cutoff=0`, expected an integer of at least 1",
        ),
        ("stripe:patches=all", "found `all` in `stripe:patches=all`, expected one of: rows, full"),
        ("best:effort=10", "found `10` in `best:effort=10`, expected an integer from 0 to 9"),
        ("cache:vertex-cache=fifo:0", "`fifo:N` or `lru:N`, N from 1 to 65536"),
        ("best:cost", "found `cost` in `best:cost`, expected PARAMETER=VALUE"),
    ] {
        refused(&["strip", "a.ply", "-m", method], message);
        refused(&["strip", "a.ply", "-m", method], "`tristrip help methods` describes all methods");
    }
    refused(
        &["strip", "a.ply", "-m", "eta", "--effort", "3"],
        "--effort applies to the methods best, fewest and cache, not to eta",
    );
    refused(
        &["strip", "a.ply", "-m", "best:effort=3", "--effort", "3"],
        "--effort cannot be used with the parameter effort of --method",
    );
    refused(&["strip", "a.ply", "-m", "best", "--effort", "10"], "10 is not in 0..=9");
    refused(&["strip", "a.ply", "-m", "sgi", "--budget", "1s"], "--budget applies to");
    refused(&["strip", "a.ply", "-m", "best", "--budget", "soon"], "--budget");
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
    refused(&["strip", "a.ply", "b.ply", "-o", "-", "--to", "glb"], "-o -: found 2 inputs, expected one");
    refused(&["strip", "a.ply", "-o", "-", "--to", "glb", "--json"], "both write to standard output");
    refused(&["strip", "a.ply", "--layout", "list"], "--output");
    refused(&["strip", "a.ply", "--reorder-vertices"], "--output");
    refused(
        &["strip", "a/x.ply", "b/x.obj", "-o", "out/"],
        "both a/x.ply and b/x.obj would be written to this file",
    );
    refused(&["convert", "a.ply"], "--output <OUTPUT>");
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
    refused(
        &["analyze", "a", "b", "c", "d", "--plot", "a.svg"],
        "--plot: found 4 inputs, expected at most 3",
    );
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
    refused(&["level", "a.ply", "--level", "140%"], "found `140%`, expected a number such as 120");
    refused(&["level", "a.ply", "--base", "0..1"], "found `0..1`, expected a ratio from 0 to 1");
    refused(&["level", "a.ply", "--filter", "fog"], "possible values: none, stss, dtfs");
    let effort = ["level", "a.ply", "--filter", "dtfs", "--filter-effort", "3"];
    refused(&effort, "--filter-effort applies to --filter repair, not to dtfs");
    refused(&["level", "a.ply", "--filter-effort", "10"], "10 is not in 0..=9");
    refused(&["level", "a.ply", "--model", "magic"], "possible values: progressive");
    refused(&["level", "a.ply", "-m", "sgi", "--effort", "3"], "--effort applies to");
    refused(&["level", "a.ply", "-o", "b.obj", "--layout", "restart"], "OBJ has no strips");
    refused(&["paint", "a.ply"], "unrecognized subcommand");
}

#[test]
fn help_has_a_short_and_a_long_form() {
    for subcommand in ["strip", "compare", "analyze", "verify", "convert", "simplify", "level"] {
        let length = |flag: &str| {
            let output = tristrip().args([subcommand, flag]).assert().success().get_output().stdout.clone();
            output.len()
        };
        assert!(length("-h") < length("--help"), "{subcommand}");
    }
    tristrip()
        .arg("--help")
        .assert()
        .success()
        .stdout(contains("Exit codes: 0 success, all results verified; "));
    tristrip()
        .arg("--version")
        .assert()
        .success()
        .stdout(format!("tristrip {}\n", env!("CARGO_PKG_VERSION")));
    for subcommand in ["strip", "verify", "man"] {
        let version = tristrip().args([subcommand, "--version"]).assert().success();
        version.stdout(format!("tristrip {}\n", env!("CARGO_PKG_VERSION")));
    }
    tristrip()
        .assert()
        .code(2)
        .stderr(contains("Usage: tristrip [OPTIONS] <COMMAND>").and(contains("Levels of detail:")));
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
    let (whole, level) = (page(&[]), page(&["level"]));
    assert!(whole.contains(".TH tristrip 1") && whole.contains("Exit codes"));
    assert!(["strip", "compare", "simplify"].iter().all(|name| whole.contains(name)));
    assert!(level.contains(".TH tristrip-level 1") && level.contains("filter\\-effort"), "{level}");
    refused(&["man", "paint"], "found subcommand `paint`, expected one of: strip, compare, ");
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
