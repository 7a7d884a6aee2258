//! Malformed glTF: each file of `testdata/bad` gives exactly the error listed in
//! `expected-gltf.txt`.
//!
//! `TRISTRIP_BLESS=1` writes a new list; review the difference before committing it.

use std::fmt::Write;
use std::path::Path;

use tristrip_io::gltf;

#[test]
fn bad_files_give_the_listed_errors() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/bad");
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| Path::new(name).extension().is_some_and(|e| e == "glb" || e == "gltf"))
        .collect();
    names.sort();
    assert!(names.len() >= 20);
    let mut found = String::new();
    for name in names {
        let message = match gltf::read(std::fs::read(folder.join(&name)).unwrap(), Some(&folder)) {
            Ok(model) => format!("read, with {} parts", model.parts.len()),
            Err(error) => error.to_string(),
        };
        writeln!(found, "{name}\t{message}").unwrap();
    }
    let list = folder.join("expected-gltf.txt");
    if std::env::var_os("TRISTRIP_BLESS").is_some_and(|v| v == "1") {
        std::fs::write(&list, &found).unwrap();
    }
    assert_eq!(found, std::fs::read_to_string(&list).unwrap());
}
