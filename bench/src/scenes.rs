//! glTF scenes, and their results with gltfpack.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::failure::Failure;

/// Lists the `.glb` and `.gltf` scenes of a directory and its subdirectories, by name.
///
/// # Errors
/// A directory cannot be read.
pub fn find(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let subject = |error| format!("{}: {error}", folder.display());
    let entries = fs::read_dir(folder).map_err(subject)?.collect::<Result<Vec<_>, _>>().map_err(subject)?;
    let mut paths: Vec<PathBuf> = entries.into_iter().map(|entry| entry.path()).collect();
    paths.sort();
    let mut found = Vec::new();
    for path in paths {
        if path.is_dir() {
            found.extend(find(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
            found.push(path);
        }
    }
    Ok(found)
}

/// Returns the name of a scene.
pub fn name(source: &Path) -> String {
    source.file_stem().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Simplifies a scene to a ratio of its triangles with gltfpack, which keeps attributes, materials
/// and nodes. Returns a GLB.
///
/// # Errors
/// The program cannot be run, or fails.
pub fn packed(program: &Path, source: &Path, share: f64) -> Result<Vec<u8>, Failure> {
    let folder = tempfile::tempdir()?;
    let result = folder.path().join("packed.glb");
    let run = Command::new(program)
        .args(["-noq", "-kv", "-km", "-kn", "-si", &share.to_string(), "-i"])
        .arg(source)
        .arg("-o")
        .arg(&result)
        .output()
        .map_err(|error| format!("{}: {error}", program.display()))?;
    if !run.status.success() {
        let message = String::from_utf8_lossy(&run.stderr);
        return Err(format!("{}: {}", program.display(), message.trim()).into());
    }
    Ok(fs::read(&result)?)
}
