//! Packing on demand: how source files are found and read, and the cache keys of their results.
//!
//! A key is a hash of everything that a result depends on: the resolved path of the file, its
//! version, the versions of the files that a `.gltf`, GLB or OBJ may refer to, the options, and the
//! version of this crate. A result is therefore never older than its source files. If files change
//! while they are read, the result is not kept.
//!
//! A model is read through the directory handle. The files that a `.gltf`, GLB or OBJ refers to are
//! opened by their paths, with links resolved. Hidden files and files outside the directory of the
//! document are rejected. However, a user who can change links in the served directory at that
//! moment could redirect these paths to files outside.

use std::fmt::Write;
use std::sync::Arc;

use sha2::{Digest, Sha256};
use tristrip_io::{Format, Model};
use tristrip_pipeline::pack;

use crate::deadline::Deadline;
use crate::folder::Folder;
use crate::glb_start::{first_bytes, json_of};
use crate::paths::SitePath;

/// The version of packed files and thumbnails. Increase it if the same file gives different bytes
/// within one package version.
const PACKING_VERSION: u32 = 1;
/// The number of bytes at the start of a GLB that are searched for URIs.
const MAX_JSON_BYTES: u64 = 64 << 10;
/// The maximum depth of directories next to a document that are searched, and the maximum number of
/// files and directories.
const MAX_DEPTH: usize = 4;
const MAX_ENTRIES: usize = 10_000;

/// A model file in the directory of a server.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    pub(crate) path: SitePath,
    pub(crate) format: Format,
    /// Everything that a result of this file depends on.
    key: String,
}

impl Source {
    /// Finds a file with the extension of a model and the versions of its related files. May block.
    pub(crate) fn find(folder: &Folder, path: &SitePath) -> Option<Self> {
        let format = Format::from_path(path.as_str())?;
        let version = folder.version(path).ok()?;
        let real = folder.real_path(path).ok()?;
        let mut key = format!(
            "{} {} {PACKING_VERSION}\n{}\n{}\n",
            env!("CARGO_PKG_NAME"),
            env!("CARGO_PKG_VERSION"),
            real.display(),
            version.tag()
        );
        if names_files(folder, path, format) {
            let mut left = MAX_ENTRIES;
            let (parent, _) = path.as_str().rsplit_once('/').unwrap_or_default();
            add_versions(folder, parent, MAX_DEPTH, &mut left, &mut key);
        }
        Some(Self { path: path.clone(), format, key })
    }

    /// Returns the cache key of the result for these options.
    pub(crate) fn key(&self, options: &str) -> String {
        let mut hash = Sha256::new();
        hash.update(options.as_bytes());
        hash.update([0]);
        hash.update(self.key.as_bytes());
        hash.finalize()[..20].iter().fold(String::new(), |mut text, byte| {
            // Writing to a string does not fail.
            write!(text, "{byte:02x}").unwrap_or_default();
            text
        })
    }

    /// Checks that nothing has changed since the file was found. May block.
    pub(crate) fn is_current(&self, folder: &Folder) -> bool {
        Self::find(folder, &self.path).is_some_and(|now| now.key == self.key)
    }

    /// Reads the model with its materials and images.
    pub(crate) fn read(&self, folder: &Folder, most_bytes: u64) -> Result<Model, String> {
        let found = folder.version(&self.path).map_err(|error| error.to_string())?.bytes;
        if found > most_bytes {
            return Err(format!("found a file of {found} bytes, expected at most {most_bytes}"));
        }
        let bytes = folder.read(&self.path, most_bytes).map_err(|error| error.to_string())?;
        let left = most_bytes - bytes.len() as u64;
        let root = format!("{}/", folder.path().display());
        // Messages do not reveal where the directory is.
        let message = |error: tristrip_io::Error| error.to_string().replace(&root, "");
        let real = folder.real_path(&self.path).map_err(|error| error.to_string())?;
        tristrip_io::read_beside(&Arc::new(bytes), self.format, &real, left).map_err(message)
    }

    /// Packs the file.
    pub(crate) fn pack(
        &self,
        folder: &Folder,
        most_bytes: u64,
        options: &pack::Options,
        deadline: Deadline,
    ) -> Result<Vec<u8>, String> {
        let model = self.read(folder, most_bytes)?;
        pack::run(&model, options, &deadline).map(|packed| packed.bytes).map_err(|error| error.to_string())
    }
}

/// Checks whether a model may refer to other files. A GLB may if its JSON contains a URI or is too
/// long to search.
fn names_files(folder: &Folder, path: &SitePath, format: Format) -> bool {
    match format {
        Format::Obj | Format::Gltf => true,
        Format::Glb => {
            let start = folder.open_file(path).and_then(|(file, _)| first_bytes(&file, MAX_JSON_BYTES));
            let key = b"\"uri\"";
            let has_uri =
                |start: &[u8]| json_of(start).is_none_or(|json| json.windows(key.len()).any(|at| at == key));
            start.is_ok_and(|start| has_uri(&start))
        }
        _ => false,
    }
}

/// Adds the versions of all files below a directory that are not models: buffers, material
/// libraries, images.
fn add_versions(folder: &Folder, path: &str, depth: usize, left: &mut usize, key: &mut String) {
    for entry in folder.entries(path, left).unwrap_or_default() {
        let Some(version) = entry.version else {
            if depth > 0 {
                add_versions(folder, entry.path.as_str(), depth - 1, left, key);
            }
            continue;
        };
        if Format::from_path(entry.path.as_str()).is_some() {
            continue;
        }
        // Writing to a string does not fail.
        writeln!(key, "{} {}", entry.path.as_str(), version.tag()).unwrap_or_default();
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::time::Duration;

    use super::*;

    fn key(folder: &Folder, path: &str) -> String {
        Source::find(folder, &SitePath::new(path).unwrap()).unwrap().key("")
    }

    #[test]
    fn keys_follow_all_files_that_a_result_depends_on() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
        fs::create_dir_all(dir.path().join("a/textures")).unwrap();
        write("a/a.gltf", "{}");
        write("a/a.ply", "ply");
        write("a/textures/a.png", "png");
        let glb = |json: &str| format!("glTF\x02\0\0\0\0\0\0\0{}\0\0\0JSON{json}", json.len() as u8 as char);
        write("a/alone.glb", &glb("{}"));
        write("a/b.glb", &glb(r#"{"images":[{"uri":"textures/a.png"}]}"#));
        let folder = Folder::open(dir.path()).unwrap();
        let keys = || ["a/a.gltf", "a/a.ply", "a/b.glb", "a/alone.glb"].map(|path| key(&folder, path));
        let before = keys();
        assert_eq!(before, keys());
        let found = Source::find(&folder, &SitePath::new("a/a.gltf").unwrap()).unwrap();
        write("a/b.ply", "another model");
        assert_eq!(key(&folder, "a/a.gltf"), before[0]);
        assert!(found.is_current(&folder));
        write("a/textures/a.png", "another image");
        assert_ne!(key(&folder, "a/a.gltf"), before[0]);
        assert!(!found.is_current(&folder));
        assert_eq!(key(&folder, "a/a.ply"), before[1]);
        assert!(key(&folder, "a/b.glb") != before[2] && key(&folder, "a/alone.glb") == before[3]);
        let source = Source::find(&folder, &SitePath::new("a/a.ply").unwrap()).unwrap();
        assert_ne!(source.key("other options"), before[1]);
        assert!(Source::find(&folder, &SitePath::new("a/textures/a.png").unwrap()).is_none());
        assert!(Source::find(&folder, &SitePath::new("none.ply").unwrap()).is_none());
    }

    #[test]
    fn files_beside_a_model_are_limited_and_not_hidden() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| fs::write(dir.path().join(name), text).unwrap();
        let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
        let material = "newmtl red\nKd 1 0 0\n";
        write("shown.obj", &format!("mtllib a.mtl\n{triangle}"));
        write("large.obj", &format!("mtllib large.mtl\n{triangle}"));
        write("hidden.obj", &format!("mtllib .a.mtl\n{triangle}"));
        write("a.mtl", material);
        write(".a.mtl", material);
        write("large.mtl", &format!("{material}{}", "#".repeat(1000)));
        let folder = Folder::open(dir.path()).unwrap();
        let materials = |path: &str| {
            let source = Source::find(&folder, &SitePath::new(path).unwrap()).unwrap();
            source.read(&folder, 500).unwrap().materials.unwrap()
        };
        assert!(!materials("shown.obj").is_empty());
        assert!(materials("large.obj").is_empty() && materials("hidden.obj").is_empty());
        let image = r#"{"asset":{"version":"2.0"},"images":[{"uri":"IMAGE"}]}"#;
        write("a.gltf", &image.replace("IMAGE", "%2ehidden.png"));
        fs::write(dir.path().join(".hidden.png"), b"\x89PNG\r\n\x1a\nsecret").unwrap();
        let source = Source::find(&folder, &SitePath::new("a.gltf").unwrap()).unwrap();
        let notes = source.read(&folder, 500).unwrap().notes;
        assert!(notes.iter().any(|note| note.starts_with("images not embedded: 1")), "{notes:?}");
    }

    #[test]
    fn messages_do_not_say_where_the_folder_is() {
        let dir = tempfile::tempdir().unwrap();
        let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"none.bin","byteLength":4}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "bufferViews":[{"buffer":0,"byteLength":4}],"accessors":[{"bufferView":0,"componentType":5126,"count":1,"type":"VEC3"}]}"#;
        fs::write(dir.path().join("a.gltf"), gltf).unwrap();
        fs::write(dir.path().join("large.ply"), "ply or not").unwrap();
        let folder = Folder::open(dir.path()).unwrap();
        let error = |path: &str| {
            let source = Source::find(&folder, &SitePath::new(path).unwrap()).unwrap();
            source.pack(&folder, 9, &pack::Options::default(), Deadline::after(Duration::MAX)).unwrap_err()
        };
        assert_eq!(error("large.ply"), "found a file of 10 bytes, expected at most 9");
        let source = Source::find(&folder, &SitePath::new("a.gltf").unwrap()).unwrap();
        let message = source.read(&folder, 1 << 20).unwrap_err();
        assert!(message.contains("none.bin") && !message.contains(dir.path().to_str().unwrap()), "{message}");
    }
}
