//! Help: commands by task, lengths, and topics.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::collections::BTreeSet;

use super::{SUBCOMMANDS, tristrip};
use predicates::prelude::*;
use predicates::str::contains;

/// The maximum number of lines of `-h` and of `--help`, at 100 columns.
const MAX_SHORT: usize = 30;
const MAX_LONG: usize = 130;
/// The subcommands that print text about the command itself.
const TEXTS: [&str; 3] = ["help", "completions", "man"];

/// Returns the standard output of a command that succeeds, at the default width of 100 columns.
fn text(arguments: &[&str]) -> String {
    let mut command = tristrip();
    let assert = command.env_remove("COLUMNS").args(arguments).assert().success();
    String::from_utf8(assert.get_output().stdout.clone()).unwrap()
}

#[test]
fn every_help_is_short_and_explains_what_is_left_out() {
    for subcommand in SUBCOMMANDS.into_iter().chain([""]) {
        let with = |flag| {
            let arguments = [subcommand, flag];
            text(if subcommand.is_empty() { &arguments[1..] } else { &arguments })
        };
        let (short, long) = (with("-h"), with("--help"));
        for (help, most) in [(&short, MAX_SHORT), (&long, MAX_LONG)] {
            let count = help.lines().count();
            assert!(count <= most, "{subcommand}: {count} lines, expected at most {most}:\n{help}");
            for line in help.lines() {
                assert!(line.chars().count() <= 100, "{subcommand}: {line}");
            }
        }
        let flags = |help: &str| -> BTreeSet<String> {
            let words = help.split_whitespace().filter(|word| word.starts_with("--"));
            words.map(|word| word.trim_end_matches([',', '.', ':', ';', ')', '`']).to_owned()).collect()
        };
        assert!(flags(&short).is_subset(&flags(&long)), "{subcommand}");
        let explained = if subcommand.is_empty() { text(&["help"]) } else { text(&["help", subcommand]) };
        assert_eq!(explained, long, "{subcommand}");
    }
}

/// Returns the help of a subcommand in one line.
fn long_help(subcommand: &str) -> String {
    text(&[subcommand, "--help"]).split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn help_offers_what_a_command_accepts_and_shows_what_it_needs() {
    // `build-lod` refuses --weld, and `convert` needs -o.
    assert!(!long_help("build-lod").contains("--weld") && long_help("strip").contains("--weld"));
    assert!(long_help("convert").contains("[OPTIONS] --output <OUTPUT> <INPUT>..."));
    assert!(long_help("strip").contains("[OPTIONS] <INPUT>..."));
}

#[test]
fn commands_are_listed_by_task() {
    let help = text(&["-h"]);
    let titles: Vec<&str> = help.lines().filter(|line| line.ends_with(':')).collect();
    let tasks = ["Shrink files:", "Levels of detail:", "Stream and view:", "Inspect and verify:"];
    assert_eq!(titles[..4], tasks);
    let listed: Vec<&str> = help
        .lines()
        .skip_while(|line| *line != tasks[0])
        .take_while(|line| !line.starts_with("Help:"))
        .filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next())
        .collect();
    let distinct: BTreeSet<&str> = listed.iter().copied().collect();
    assert_eq!(listed.len(), distinct.len(), "each command once");
    assert_eq!(distinct, SUBCOMMANDS.into_iter().filter(|name| !TEXTS.contains(name)).collect());
    assert!(help.contains(&format!("\nHelp: {}\n", TEXTS.join(", "))));
    let failed = tristrip().assert().code(2);
    let shown = String::from_utf8(failed.get_output().stderr.clone()).unwrap();
    assert_eq!(shown, help, "without arguments");
}

#[test]
fn topics_explain_methods_levels_simplification_and_the_server() {
    for topic in ["methods", "levels", "simplification", "files", "server"] {
        let text = text(&["help", topic]);
        assert!(text.lines().count() > 20, "{topic}");
        for line in text.lines() {
            assert!(line.chars().count() <= 100 && line.trim_end() == line, "{topic}: {line}");
        }
    }
    let methods = text(&["help", "methods"]);
    for words in ["stripe-global", "patches=rows, cutoff=5", "tunnel-length", "look-ahead", "fifo:16"] {
        assert!(methods.contains(words), "{words}");
    }
    tristrip().args(["help", "--help"]).assert().success().stdout(contains("simplification"));
    let unknown = tristrip().args(["help", "paint"]).assert().code(2);
    unknown.stderr(contains("invalid value 'paint'").and(contains("methods")));
}
