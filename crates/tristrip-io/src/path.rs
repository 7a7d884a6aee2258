//! Reads and writes files by path. A file is written under a temporary name and then renamed, so a
//! failed write leaves the old file unchanged.

use std::collections::HashSet;
use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use tristrip::Layout;

use crate::any_format::{read_with_files, write};
use crate::error::Error;
use crate::format::Format;
use crate::gltf::BufferFiles;
use crate::gltf::edit::images::{EmbeddedImages, embed};
use crate::materials::SideFile;
use crate::model::{Drawing, Model};
use crate::obj::scene_library::{library_of, library_of_added};

/// Reads a model from a file. The format follows from the extension, or from the content if the
/// extension is unknown. Separate buffers of a `.gltf` are looked up in the directory of the path.
/// If the path is a symbolic link, they are also looked up in the directory of its target. Files
/// outside these directories are never read.
///
/// # Errors
/// The file cannot be read or is a directory, or its content is rejected by [`read`](crate::read).
///
/// ```
/// let wrong = tristrip_io::read_path("no/such/model.ply").unwrap_err();
/// assert!(wrong.to_string().starts_with("no/such/model.ply: "));
/// ```
pub fn read_path(path: impl AsRef<Path>) -> Result<Model, Error> {
    Ok(read_file(path, None)?.model)
}

/// A model and the file that it was read from.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ReadFile {
    /// The model.
    pub model: Model,
    /// The bytes of the file; a glTF model shares them.
    pub bytes: Arc<Vec<u8>>,
    /// The format of the file.
    pub format: Format,
}

/// Reads a model like [`read_path`], and returns it with the bytes of the file. `format` overrides
/// the detected format.
///
/// # Errors
/// The file cannot be read, is a directory, or is not a valid file of the format.
///
/// ```
/// use tristrip_io::{Format, read_file};
/// # let dir = tempfile::tempdir().unwrap();
/// # let path = dir.path().join("model.dat");
/// std::fs::write(&path, "OFF\n0 0 0\n")?;
/// assert_eq!(read_file(&path, None)?.format, Format::Off);
/// assert!(read_file(&path, Some(Format::Ply)).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_file(path: impl AsRef<Path>, format: Option<Format>) -> Result<ReadFile, Error> {
    let path = path.as_ref();
    let io_error = |source| Error::Io { path: path.display().to_string(), source };
    if fs::metadata(path).map_err(io_error)?.is_dir() {
        return Err(io_error(io::Error::new(
            io::ErrorKind::IsADirectory,
            "found a directory, expected a file",
        )));
    }
    let bytes = fs::read(path).map_err(io_error)?;
    let format = format.or_else(|| Format::from_path(path)).unwrap_or_else(|| Format::from_bytes(&bytes));
    let bytes = Arc::new(bytes);
    let target = target_of(path);
    let folders = folders(path, &target);
    let model = read_with_files(&bytes, format, &mut BufferFiles::new(&folders))?;
    Ok(ReadFile { model, bytes, format })
}

/// Reads a model from bytes, with its materials and images, for a program that serves the result to
/// others.
///
/// Referenced files must be in the directory of `path` or below it. Hidden files and directories,
/// whose names start with a dot, are not read. The total size of all files may be at most
/// `max_bytes`. [`Model::notes`] and [`Model::materials`] list skipped images and libraries; a
/// skipped buffer is an error.
///
/// # Errors
/// A buffer cannot be read, or the content is rejected by [`read`](crate::read).
///
/// ```
/// use std::sync::Arc;
/// use tristrip_io::{Format, read_beside};
/// # let dir = tempfile::tempdir().unwrap();
/// # let path = dir.path().join("model.obj");
/// std::fs::write(dir.path().join("a.mtl"), "newmtl red\nKd 1 0 0\n")?;
/// let obj = Arc::new(b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n".to_vec());
/// let has_materials = |max_bytes| {
///     let model = read_beside(&obj, Format::Obj, &path, max_bytes)?;
///     Ok::<_, tristrip_io::Error>(!model.materials.unwrap_or_default().is_empty())
/// };
/// assert!(has_materials(100)? && !has_materials(10)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read_beside(
    bytes: &Arc<Vec<u8>>,
    format: Format,
    path: &Path,
    max_bytes: u64,
) -> Result<Model, Error> {
    let target = target_of(path);
    let folders = folders(path, &target);
    let mut files = BufferFiles::limited(&folders, max_bytes);
    let mut model = read_with_files(bytes, format, &mut files)?;
    if model.scene.is_none() {
        load_libraries(&mut model, &mut files);
    }
    embed_from(&mut model, &mut files)?;
    Ok(model)
}

/// Returns the target of a path. For a pipe, this is the path itself.
fn target_of(path: &Path) -> PathBuf {
    fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

/// Returns the directories of a document, which may have been opened through a symbolic link.
fn folders<'a>(path: &'a Path, target: &'a Path) -> Vec<&'a Path> {
    [path, target].into_iter().filter_map(Path::parent).collect()
}

/// Embeds the images of a model that are in separate files, so a GLB can be written to any
/// directory. `path` is the file that the model was read from, if known. Images are looked up in
/// its directories, as buffers are by [`read_path`]. An image that cannot be read keeps its URI. A
/// note counts the images.
///
/// # Errors
/// `images`, `buffers` or `bufferViews` of the document is not an array.
///
/// ```
/// # let dir = tempfile::tempdir().unwrap();
/// # let path = dir.path().join("model.gltf");
/// std::fs::write(dir.path().join("a.png"), b"\x89PNG\r\n\x1a\n")?;
/// let images = r#""images":[{"uri":"a.png"},{"uri":"b.png"}]"#;
/// std::fs::write(&path, format!(r#"{{"asset":{{"version":"2.0"}},{images}}}"#))?;
/// let mut model = tristrip_io::read_path(&path)?;
/// let images = tristrip_io::embed_images(&mut model, Some(&path))?;
/// assert_eq!((images.embedded, images.left.len()), (1, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn embed_images(model: &mut Model, path: Option<&Path>) -> Result<EmbeddedImages, Error> {
    match path {
        Some(path) => {
            let target = target_of(path);
            embed_from(model, &mut BufferFiles::new(&folders(path, &target)))
        }
        None => embed_from(model, &mut BufferFiles::new(&[])),
    }
}

fn embed_from(model: &mut Model, files: &mut BufferFiles<'_>) -> Result<EmbeddedImages, Error> {
    let Some(scene) = &mut model.scene else { return Ok(EmbeddedImages::default()) };
    let images = embed(scene, files)?;
    if images.embedded > 0 {
        model.notes.push(format!("images embedded from separate files: {}", images.embedded));
    }
    if let Some(first) = images.left.first() {
        let count = images.left.len();
        model.notes.push(format!("images not embedded: {count}, such as {first}"));
    }
    Ok(images)
}

/// Reads the material libraries of an OBJ model and their images. The files must be in the
/// directory of `path` or below it; `path` is the file that the model was read from. A glTF model,
/// or one with materials that a program added, gets a new library for an OBJ file named `stem`.
/// Files that are not found are added to the problems of [`Model::materials`].
///
/// ```
/// # let dir = tempfile::tempdir().unwrap();
/// # let path = dir.path().join("model.obj");
/// std::fs::write(dir.path().join("a.mtl"), "newmtl red\nKd 1 0 0\nmap_Kd none.png\n")?;
/// std::fs::write(&path, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")?;
/// let mut model = tristrip_io::read_path(&path)?;
/// tristrip_io::load_materials(&mut model, Some(&path), "out");
/// let materials = model.materials.unwrap_or_default();
/// assert_eq!((materials.files.len(), materials.problems.len()), (1, 1));
/// assert!(!materials.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn load_materials(model: &mut Model, path: Option<&Path>, stem: &str) {
    if let Some(scene) = &model.scene {
        model.materials = Some(library_of(scene, &model.parts, stem));
        return;
    }
    if let Some(added) =
        model.materials.as_ref().filter(|known| known.libraries.is_empty() && !known.is_empty())
    {
        model.materials = Some(library_of_added(added, stem));
        return;
    }
    let target = path.map(target_of);
    let folders = match (path, &target) {
        (Some(path), Some(target)) => folders(path, target),
        _ => Vec::new(),
    };
    load_libraries(model, &mut BufferFiles::new(&folders));
}

fn load_libraries(model: &mut Model, files: &mut BufferFiles<'_>) {
    let Some(materials) = &mut model.materials else { return };
    let mut load = |name: &str, problems: &mut Vec<String>| match files.load_named(name) {
        Ok(Some(bytes)) => Some(bytes),
        Ok(None) => {
            problems.push(format!("{name}: not a file in the directory of the OBJ"));
            None
        }
        Err(error) => {
            problems.push(error.to_string());
            None
        }
    };
    let mut seen: HashSet<String> = HashSet::new();
    for library in materials.libraries.clone() {
        let Some(bytes) = load(&library, &mut materials.problems) else { continue };
        for name in materials.add_library(&library, bytes) {
            if !seen.insert(name.clone()) {
                continue;
            }
            if let Some(bytes) = load(&name, &mut materials.problems) {
                materials.files.push(SideFile { name, bytes });
            }
        }
    }
}

/// Writes a model to a file in the format of its extension. Uses [`write()`] and [`replace_file`].
///
/// # Errors
/// The extension is unknown, or [`write()`] or [`replace_file`] fails.
///
/// ```
/// use tristrip_io::{Drawing, Format, read, read_path, write_path};
/// # let dir = tempfile::tempdir().unwrap();
/// # let path = dir.path().join("square.glb");
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n", Format::Obj)?;
/// let strips = tristrip::stripify(&model.parts[0].mesh, &tristrip::StripifyOptions::default())?;
/// write_path(&path, &model, &[Drawing::Strips(&strips)], tristrip::Layout::Separate)?;
/// assert!(read_path(&path)?.parts[0].stripped);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn write_path(
    path: impl AsRef<Path>,
    model: &Model,
    drawings: &[Drawing],
    layout: Layout,
) -> Result<(), Error> {
    let path = path.as_ref();
    let Some(format) = Format::from_path(path) else {
        let message = format!("{}: unknown extension, expected .obj, .ply or .glb", path.display());
        return Err(Error::Unsupported(message));
    };
    replace_file(path, &write(model, drawings, format, layout)?)
}

/// Writes bytes to a temporary file in the same directory and renames it. Readers see either the
/// old file or the complete new one. If the write fails, the old file is unchanged, and no
/// temporary file remains. Symbolic links are followed; devices and pipes are written directly.
///
/// # Errors
/// The path cannot be written, or is a directory or a read-only file.
///
/// ```
/// # let dir = tempfile::tempdir().unwrap();
/// # let path = dir.path().join("model.obj");
/// tristrip_io::replace_file(&path, b"v 0 0 0\n")?;
/// assert_eq!(std::fs::read(&path).unwrap(), b"v 0 0 0\n");
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn replace_file(path: impl AsRef<Path>, bytes: &[u8]) -> Result<(), Error> {
    let path = path.as_ref();
    replace(path, bytes).map_err(|source| Error::Io { path: path.display().to_string(), source })
}

fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let old = match fs::metadata(path) {
        Ok(old) => Some(old),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(error),
    };
    if let Some(old) = &old {
        if old.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "found a directory, expected a file"));
        }
        if old.permissions().readonly() {
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
        }
        if !old.is_file() {
            return fs::OpenOptions::new().write(true).open(path)?.write_all(bytes);
        }
    }
    let target = if old.is_some() { fs::canonicalize(path)? } else { path.to_path_buf() };
    let dir = match target.parent() {
        Some(dir) if !dir.as_os_str().is_empty() => dir.to_path_buf(),
        _ => PathBuf::from("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(".tristrip-").suffix(".tmp");
    #[cfg(unix)]
    let permissions = {
        use std::os::unix::fs::PermissionsExt;
        // The user's umask applies to these permissions of a new file.
        old.as_ref().map_or_else(|| fs::Permissions::from_mode(0o666), fs::Metadata::permissions)
    };
    #[cfg(unix)]
    builder.permissions(permissions.clone());
    // An early return removes the temporary file. The error keeps only its kind, without the
    // temporary path; the caller adds the path that the user gave.
    let without_path = |error: io::Error| io::Error::from(error.kind());
    let mut file = builder.tempfile_in(&dir).map_err(without_path)?;
    file.write_all(bytes)?;
    #[cfg(unix)]
    if old.is_some() {
        file.as_file().set_permissions(permissions)?;
    }
    file.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file_count(dir: &Path) -> usize {
        fs::read_dir(dir).unwrap().count()
    }

    #[test]
    fn read_errors_name_the_file() {
        let dir = tempfile::tempdir().unwrap();
        let message = |path: &Path| read_path(path).unwrap_err().to_string();
        assert!(message(dir.path()).ends_with("found a directory, expected a file"));
        assert!(message(&dir.path().join("none.ply")).contains("none.ply: "));
        let empty = dir.path().join("empty.off");
        fs::write(&empty, "").unwrap();
        assert_eq!(message(&empty), "byte 0: found an empty file, expected a non-empty OFF file");
    }

    #[test]
    fn a_file_without_extension_is_read_by_its_content() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("model");
        fs::write(&path, "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").unwrap();
        assert_eq!(read_path(&path).unwrap().parts[0].mesh.faces().face_count(), 1);
    }

    #[test]
    fn failed_writes_leave_no_files() {
        let dir = tempfile::tempdir().unwrap();
        let message = |path: &Path| replace_file(path, b"x").unwrap_err().to_string();
        assert!(message(dir.path()).ends_with("found a directory, expected a file"));
        assert!(message(&dir.path().join("no/where.ply")).contains("no/where.ply: "));
        let locked = dir.path().join("locked.ply");
        fs::write(&locked, "old").unwrap();
        let mut permissions = fs::metadata(&locked).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(&locked, permissions).unwrap();
        assert!(message(&locked).ends_with("the file is read-only"));
        assert_eq!(fs::read(&locked).unwrap(), b"old");
        let model = Model::default();
        assert!(write_path(dir.path().join("a.stl"), &model, &[], Layout::List).is_err());
        assert!(write_path(dir.path().join("a"), &model, &[], Layout::List).is_err());
        assert_eq!(file_count(dir.path()), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_permissions_kept() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let (real, link) = (dir.path().join("real"), dir.path().join("link"));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        replace_file(&link, b"new").unwrap();
        assert_eq!(fs::read(&real).unwrap(), b"new");
        assert_eq!(fs::metadata(&real).unwrap().permissions().mode() & 0o777, 0o640);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(file_count(dir.path()), 2);
        replace_file("/dev/null", b"x").unwrap();
    }
}
