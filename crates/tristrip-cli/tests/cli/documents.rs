//! The documents agree with the command: its help, its JSON keys, and the code of the README.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use super::{SUBCOMMANDS, json, keys, model, tristrip};

fn document(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// `docs/cli.md` is regenerated when `TRISTRIP_BLESS` is set. It has the help of a build with all
/// features.
#[cfg(feature = "tls")]
#[test]
fn the_docs_contain_the_help() {
    let mut expected = String::from(
        "# The command\n\nGenerated from the help of each subcommand and topic; `TRISTRIP_BLESS=1 cargo test -p tristrip-cli \
         --all-features` regenerates it.\n",
    );
    let subcommands = SUBCOMMANDS.into_iter().map(|name| vec![name, "--help"]);
    let topics = ["methods", "levels", "simplification", "files", "server"].map(|name| vec!["help", name]);
    for arguments in [vec!["--help"]].into_iter().chain(subcommands).chain(topics) {
        let assert = tristrip().env_remove("COLUMNS").args(&arguments).assert().success();
        let help = String::from_utf8(assert.get_output().stdout.clone()).unwrap();
        let lines: Vec<&str> = help.lines().map(str::trim_end).collect();
        let words = ["tristrip"].into_iter().chain(arguments.into_iter().filter(|word| *word != "--help"));
        let title = words.collect::<Vec<_>>().join(" ");
        for text in ["\n## `", &title, "`\n\n```text\n", &lines.join("\n"), "\n```\n"] {
            expected.push_str(text);
        }
    }
    let path = document("docs/cli.md");
    if std::env::var_os("TRISTRIP_BLESS").is_some() {
        fs::write(&path, &expected).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap() == expected,
        "docs/cli.md differs from the help of the command"
    );
}

/// The command of the sample in each section of FORMAT.md.
const SAMPLES: [&str; 13] = [
    "strip fish_control.ply -o fish.glb --json",
    "compare fish_control.ply --json",
    "bound fish_control.ply --json",
    "analyze fish.glb --vertex-caches fifo:16 --json",
    "verify fish_control.ply fish.glb --json",
    "convert fish_control.ply -o fish.obj --json",
    "simplify fish_control.ply --ratio 50% -o small.ply --json",
    "level fish_control.ply --level 50% -o level.glb --json",
    "chain fish_control.ply --ratios 100%,50%,10% -o levels.glb --json",
    "build-lod fish_control.ply -o fish.tlod --json",
    "pack fish_control.ply -o packed.glb --json",
    "unpack packed.glb --level 50% -o part.ply --json",
    "inspect packed.glb --json",
];

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
                        times
                            .values_mut()
                            .filter(|time| !time.is_null())
                            .for_each(|time| *time = 0.01.into());
                    }
                    entry => sample_of(entry),
                }
            }
        }
        _ => (),
    }
}

/// The samples of FORMAT.md are regenerated when `TRISTRIP_BLESS` is set.
#[test]
fn the_samples_of_reports_are_what_the_command_prints() {
    let dir = tempfile::tempdir().unwrap();
    fs::copy(model("fish_control.ply"), dir.path().join("fish_control.ply")).unwrap();
    let path = document("FORMAT.md");
    let mut expected = fs::read_to_string(&path).unwrap();
    for line in SAMPLES {
        let mut report = json(tristrip().args(line.split_whitespace()).current_dir(&dir));
        sample_of(&mut report);
        let name = line.split_whitespace().next().unwrap();
        let heading = format!("### `tristrip {name}`\n\n");
        let report = serde_json::to_string_pretty(&report).unwrap();
        let sample = format!("`tristrip {line}` prints\n\n```json\n{report}\n```\n\n");
        let (before, section) = expected.split_once(&heading).expect("a section for each subcommand");
        let rest = section.strip_prefix("`tristrip ").and_then(|sample| sample.split_once("\n```\n\n"));
        expected = format!("{before}{heading}{sample}{}", rest.map_or(section, |(_, rest)| rest));
    }
    if std::env::var_os("TRISTRIP_BLESS").is_some() {
        fs::write(&path, &expected).unwrap();
    }
    let found = fs::read_to_string(&path).unwrap();
    assert!(found == expected, "the samples of FORMAT.md differ from what the command prints");
}

#[test]
fn every_json_key_is_described() {
    let described = fs::read_to_string(document("FORMAT.md")).unwrap();
    let fish = model("fish_control.ply");
    let dir = tempfile::tempdir().unwrap();
    let strip = json(tristrip().args(["strip", "--json", "-m", "stripe-local"]).arg(&fish));
    let global = json(tristrip().args(["strip", "--json", "-m", "stripe"]).arg(&fish));
    let best = json(tristrip().args(["strip", "--json", "-m", "best", "--effort", "3"]).arg(&fish));
    let eta = json(tristrip().args(["strip", "--json", "-m", "eta"]).arg(&fish));
    let bound = json(tristrip().args(["bound", "--json"]).arg(&fish));
    let analyze = json(tristrip().args(["analyze", "--json"]).arg(&fish));
    let compare = json(tristrip().args(["compare", "--json"]).arg(&fish));
    let verify = json(tristrip().args(["verify", "--json"]).arg(&fish).arg(&fish));
    let mut command = tristrip();
    let convert =
        json(command.args(["convert", "--json"]).arg(&fish).arg("-o").arg(dir.path().join("a.obj")));
    let mut command = tristrip();
    command
        .args(["strip", "--json", "--reorder-vertices"])
        .arg(&fish)
        .arg("-o")
        .arg(dir.path().join("a.ply"));
    let ordered = json(&mut command);
    let cached = json(tristrip().args(["strip", "--json", "-m", "cache"]).arg(&fish));
    let lod = json(tristrip().args(["level", "--json"]).arg(&fish));
    let levels = [&lod, &lod["seconds"]];
    let chain = json(tristrip().args(["chain", "--json", "--ratios", "100%,50%"]).arg(&fish));
    let chain = [&chain, &chain["seconds"], &chain["chain"][0]];
    let mut command = tristrip();
    let built =
        json(command.args(["build-lod", "--json"]).arg(&fish).arg("-o").arg(dir.path().join("a.tlod")));
    let glb = dir.path().join("packed.glb");
    let packed = json(tristrip().args(["pack", "--json"]).arg(&fish).arg("-o").arg(&glb));
    let unpacked = json(tristrip().args(["unpack", "--json"]).arg(&glb));
    let inspected = json(tristrip().args(["inspect", "--json"]).arg(&glb));
    let streams = [
        &packed,
        &packed["seconds"],
        &unpacked,
        &inspected,
        &inspected["seconds"],
        &inspected["components"][0],
        &inspected["chunks"][0],
    ];
    let simplified = json(tristrip().args(["simplify", "--json", "--ratio", "50%"]).arg(&fish));
    let whole = [
        &simplified,
        &simplified["seconds"],
        &built,
        &built["seconds"],
        &strip,
        &global,
        &best,
        &cached,
        &eta,
        &bound,
        &analyze,
        &compare,
        &verify,
        &convert,
    ];
    let inner = [&strip["mesh"], &strip["seconds"], &best["bound"], &bound["bound"], &bound["components"][0]];
    let analyzed = [&analyze["seconds"], &analyze["vertex_caches"][0], &analyze["by_part"][0]];
    let ordered = [&ordered["vertex_order"][0]];
    let reports =
        [&levels[..], &chain[..], &streams[..], &whole[..], &inner[..], &analyzed[..], &ordered[..]].concat();
    for key in reports.into_iter().flat_map(keys) {
        assert!(described.contains(&format!("`{key}`")), "FORMAT.md does not describe `{key}`");
    }
}

#[test]
fn the_rust_code_of_the_readme_is_in_the_examples() {
    let readme = fs::read_to_string(document("README.md")).unwrap();
    let blocks = readme.split("```rust\n").skip(1).filter_map(|rest| rest.split("```").next());
    let blocks: Vec<&str> = blocks.collect();
    let examples = ["crates/tristrip/examples/index_buffer.rs", "crates/tristrip-cli/examples/strip_file.rs"];
    assert_eq!(blocks.len(), examples.len());
    for (block, name) in blocks.into_iter().zip(examples) {
        let example = fs::read_to_string(document(name)).unwrap();
        for line in block.lines().filter_map(|line| line.split("//").next()) {
            assert!(example.lines().any(|other| other.trim() == line.trim()), "not in {name}: {line}");
        }
    }
}
