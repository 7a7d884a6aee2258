//! Every file in `testdata/bad` gives the error listed in the tables there, and every listed file
//! exists.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use tristrip_io::read_path;

const FOLDER: &str = "../../testdata/bad";

/// Reads the tables `expected*.txt`: a file name, a tab, the message.
fn expected() -> BTreeMap<String, String> {
    let mut out = BTreeMap::new();
    for entry in fs::read_dir(FOLDER).unwrap() {
        let path = entry.unwrap().path();
        if !is_table(&path) {
            continue;
        }
        for line in fs::read_to_string(&path).unwrap().lines().filter(|line| !line.starts_with('#')) {
            let (file, message) = line.split_once('\t').unwrap_or_else(|| panic!("{line}"));
            let before = out.insert(file.to_owned(), message.to_owned());
            assert!(before.is_none(), "{file} is listed twice");
        }
    }
    out
}

fn is_table(path: &Path) -> bool {
    let name = path.file_name().unwrap().to_string_lossy();
    name.starts_with("expected") && name.ends_with(".txt")
}

#[test]
fn every_bad_file_gives_its_message() {
    let expected = expected();
    let mut wrong = String::new();
    let mut seen = 0;
    for entry in fs::read_dir(FOLDER).unwrap() {
        let path = entry.unwrap().path();
        // The external buffers of glTF files are not test files.
        if is_table(&path) || path.extension().is_some_and(|extension| extension == "bin") {
            continue;
        }
        seen += 1;
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let found = match read_path(&path) {
            Ok(model) => format!("(read, {} parts)", model.parts.len()),
            Err(error) => error.to_string(),
        };
        if expected.get(&name) != Some(&found) {
            wrong.extend([name.as_str(), "\t", found.as_str(), "\n"]);
        }
    }
    assert!(wrong.is_empty(), "these differ from the tables:\n{wrong}");
    assert_eq!(seen, expected.len(), "some listed files do not exist");
}

#[test]
fn errors_for_very_long_lines_are_short() {
    use tristrip_io::{Format, read};
    let long = "x".repeat(1 << 20);
    for (format, text) in [
        (Format::Obj, format!("v 0 0 {long}\n")),
        (Format::Obj, format!("{long}\n")),
        (Format::Ply, format!("ply\n{long}\n")),
        (Format::Off, format!("OFF\n{long}\n")),
        (Format::Stl, format!("solid\n{long}\n")),
    ] {
        let message = read(text.as_bytes(), format).unwrap_err().to_string();
        assert!(message.starts_with("line ") && message.len() < 200, "{message}");
    }
}
