//! Reads a directory of real models and compares the counts with the table in its README. The
//! environment variable `TRISTRIP_MODELS` names the directory; without it, the test is skipped.

use std::collections::HashSet;
use std::path::PathBuf;

use tristrip_io::{Format, read_path};

#[test]
fn real_models_have_the_counts_of_their_table() {
    let Some(folder) = std::env::var_os("TRISTRIP_MODELS").map(PathBuf::from) else { return };
    let table = std::fs::read_to_string(folder.join("README.md")).unwrap();
    let mut read_count = 0;
    for row in table.lines() {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, file, vertices, welded, faces, _, triangles, ..] = cells[..] else { continue };
        let format = Format::from_path(file);
        if !matches!(format, Some(Format::Ply | Format::Obj)) {
            continue;
        }
        let model = read_path(folder.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        let meshes = || model.parts.iter().map(|part| &part.mesh);
        let count = |text: &str| text.parse::<usize>().unwrap_or_else(|_| panic!("{file}: {text}"));
        assert_eq!(meshes().map(|mesh| mesh.faces().face_count()).sum::<usize>(), count(faces), "{file}");
        assert_eq!(
            meshes().map(|mesh| mesh.faces().triangle_count()).sum::<usize>(),
            count(triangles),
            "{file}"
        );
        if format == Some(Format::Ply) {
            assert_eq!(meshes().map(tristrip::Mesh::vertex_count).sum::<usize>(), count(vertices), "{file}");
        }
        let distinct: HashSet<[u32; 3]> = meshes()
            .flat_map(tristrip::Mesh::positions)
            .map(|position| position.map(|x| (x + 0.0).to_bits()))
            .collect();
        assert_eq!(distinct.len(), count(welded), "{file}");
        read_count += 1;
    }
    assert!(read_count > 50, "only {read_count} models");
}
