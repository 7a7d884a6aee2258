//! The documents agree with the command: its help and its JSON reports.

use std::fs;
use std::path::PathBuf;

use serde_json::Value;

use super::{SUBCOMMANDS, json, model, tristrip};

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

/// The page of the reports: a section per subcommand with a table of the keys and a sample.
const REPORTS: &str = "docs/reports.md";

/// The command of the sample in each section of the page.
const SAMPLES: [&str; 14] = [
    "strip fish_control.ply -o fish.glb --json",
    "compare fish_control.ply --json",
    "bound fish_control.ply --json",
    "analyze fish.glb --vertex-caches fifo:16 --json",
    "verify fish_control.ply fish.glb --json",
    "convert fish_control.ply -o fish.obj --json",
    "simplify fish_control.ply --ratio 50% -o small.ply --json",
    "level fish_control.ply --level 50% -o level.glb --json",
    "camera-level fish_control.ply --eye 0,0,9 --look-at 0,0,0 -o view.glb --json",
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

/// Returns the section of a subcommand, with what is before and after it.
fn section<'a>(page: &'a str, name: &str) -> [&'a str; 3] {
    let heading = format!("\n## `tristrip {name}`\n");
    let start = page.find(&heading).unwrap_or_else(|| panic!("no section on {name}")) + heading.len();
    let end = page[start..].find("\n## ").map_or(page.len(), |length| start + length + 1);
    [&page[..start], &page[start..end], &page[end..]]
}

/// Replaces the first block in the section of a subcommand from `start` to `end`.
fn with_block(page: &str, name: &str, [start, end]: [&str; 2], block: &str) -> String {
    let [before, section, after] = section(page, name);
    let place = section.split_once(start).and_then(|(head, rest)| Some((head, rest.split_once(end)?.1)));
    let (head, tail) = place.unwrap_or_else(|| panic!("no {start:?} to {end:?} in the section on {name}"));
    [before, head, start, block, end, tail, after].concat()
}

/// The samples, and with the feature `schema` the tables, are regenerated when `TRISTRIP_BLESS` is
/// set.
#[test]
fn the_page_of_reports_is_what_the_command_prints() {
    let dir = tempfile::tempdir().unwrap();
    fs::copy(model("fish_control.ply"), dir.path().join("fish_control.ply")).unwrap();
    let path = document(REPORTS);
    let mut expected = fs::read_to_string(&path).unwrap();
    for line in SAMPLES {
        let mut report = json(tristrip().args(line.split_whitespace()).current_dir(&dir));
        sample_of(&mut report);
        let (name, rest) = line.split_once(' ').unwrap();
        let report = serde_json::to_string_pretty(&report).unwrap();
        let sample = format!("{rest}` prints\n\n```json\n{report}");
        let start = format!("\n`tristrip {name} ");
        expected = with_block(&expected, name, [&start, "\n```\n"], &sample);
    }
    #[cfg(feature = "schema")]
    for (name, schema) in tristrip_cli::report_schemas() {
        let mut rows = String::from("|---|---|---|\n");
        tables::add_rows(&schema, "", &mut rows);
        let ends = ["\n| key | type | meaning |\n", "\n\n"];
        expected = with_block(&expected, name, ends, rows.trim_end());
    }
    if std::env::var_os("TRISTRIP_BLESS").is_some() {
        fs::write(&path, &expected).unwrap();
    }
    let found = fs::read_to_string(&path).unwrap();
    assert!(found == expected, "{REPORTS} differs from the reports of the command");
}

/// The rows of a table, from the JSON Schema of a report.
#[cfg(feature = "schema")]
mod tables {
    use std::fmt::Write as _;

    use serde_json::Value;

    /// A row per key, also of the objects in it: `mesh`, `mesh.faces`, `chain`, `chain[].ratio`.
    pub(super) fn add_rows(schema: &Value, path: &str, rows: &mut String) {
        let required = schema["required"].as_array().map_or(&[][..], Vec::as_slice);
        for (key, of_key) in schema["properties"].as_object().into_iter().flatten() {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            let meaning = of_key["description"].as_str().unwrap_or_default();
            assert!(!meaning.is_empty() && !meaning.contains("[`"), "{path}: {meaning:?}");
            let meaning = meaning.replace('\n', " ").replace("`None`", "`null`").replace('|', "\\|");
            let mut kind = Kind::of(of_key);
            if !required.contains(&key.as_str().into()) {
                kind.names.retain(|name| name != "`null`");
                kind.names.push("absent".into());
            }
            let _ = writeln!(rows, "| `{path}` | {} | {meaning} |", kind.text());
            if let Some(object) = kind.object {
                add_rows(object, &format!("{path}{}", kind.brackets), rows);
            }
        }
    }

    /// The type of a value.
    #[derive(Default)]
    struct Kind<'a> {
        /// The alternatives.
        names: Vec<String>,
        /// The object that has further keys, and `[]` if it is in an array.
        object: Option<&'a Value>,
        brackets: &'static str,
    }

    impl<'a> Kind<'a> {
        fn of(schema: &'a Value) -> Self {
            let mut kind = Self::default();
            kind.add(schema);
            kind
        }

        fn add(&mut self, schema: &'a Value) {
            let alternatives = schema.get("oneOf").or_else(|| schema.get("anyOf"));
            if let Some(alternatives) = alternatives {
                alternatives.as_array().into_iter().flatten().for_each(|schema| self.add(schema));
            } else if let Some(value) = schema.get("const") {
                self.names.push(format!("`{}`", value.as_str().unwrap_or_default()));
            } else if let Some(values) = schema["enum"].as_array() {
                self.names
                    .extend(values.iter().map(|value| format!("`{}`", value.as_str().unwrap_or("null"))));
            } else {
                let types =
                    schema["type"].as_array().map_or(std::slice::from_ref(&schema["type"]), Vec::as_slice);
                types.iter().for_each(|name| self.add_type(name.as_str().unwrap_or_default(), schema));
            }
        }

        fn add_type(&mut self, name: &str, schema: &'a Value) {
            self.names.push(match name {
                "null" => "`null`".into(),
                "array" => {
                    let entries = Self::of(&schema["items"]);
                    (self.object, self.brackets) = (entries.object, "[]");
                    let length = schema["minItems"].as_u64().map(|length| format!("{length} "));
                    let plural = entries.text().replacen("array", "arrays", 1);
                    let plural = if plural.contains(' ') { plural } else { format!("{plural}s") };
                    format!("array of {}{plural}", length.unwrap_or_default())
                }
                "object" => {
                    self.object = Some(schema);
                    name.into()
                }
                "string" | "integer" | "number" | "boolean" => name.into(),
                _ => panic!("no type: {schema}"),
            });
        }

        fn text(&self) -> String {
            match self.names.split_last() {
                Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
                _ => self.names.concat(),
            }
        }
    }
}

/// Adds the paths of the keys in a report: `mesh`, `mesh.faces`, `chain`, `chain[].ratio`.
fn add_paths(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Array(entries) => {
            entries.iter().for_each(|entry| add_paths(entry, &format!("{path}[]"), found));
        }
        Value::Object(entries) => {
            for (key, entry) in entries {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                add_paths(entry, &path, found);
                found.push(path);
            }
        }
        _ => (),
    }
}

#[test]
fn every_json_key_is_described() {
    let page = fs::read_to_string(document(REPORTS)).unwrap();
    let dir = tempfile::tempdir().unwrap();
    fs::copy(model("fish_control.ply"), dir.path().join("fish.ply")).unwrap();
    for line in [
        "strip fish.ply -m stripe-local",
        "strip fish.ply -m stripe",
        "strip fish.ply -m best --effort 3",
        "strip fish.ply -m cache",
        "strip fish.ply -m eta",
        "strip fish.ply -m sgi",
        "strip fish.ply --reorder-vertices -o fish.glb --picture fish.png",
        "compare fish.ply",
        "bound fish.ply",
        "analyze fish.glb",
        "verify fish.ply fish.glb",
        "convert fish.ply -o fish.obj",
        "simplify fish.ply --ratio 50% --fit --picture small.png",
        "level fish.ply",
        "camera-level fish.ply --eye 0,0,9 --look-at 0,0,0",
        "chain fish.ply --ratios 100%,50%",
        "build-lod fish.ply -o fish.tlod",
        "pack fish.ply -o packed.glb",
        "unpack packed.glb",
        "inspect packed.glb",
    ] {
        let report = json(tristrip().args(line.split_whitespace()).arg("--json").current_dir(&dir));
        let name = line.split(' ').next().unwrap();
        let [_, section, _] = section(&page, name);
        let mut paths = Vec::new();
        add_paths(&report, "", &mut paths);
        for path in paths {
            assert!(section.contains(&format!("\n| `{path}` |")), "{name}: {REPORTS} lacks `{path}`");
        }
    }
}
