//! The list of models for the gallery, `/models.json`: what is in the folder, with sizes and numbers of triangles where they are cheap to find.
//!
//! # Algorithm
//! 1. The folder is scanned, folders in it too, within a depth and a number of files and folders. Names that no URL can have are left out.
//! 2. A GLB is progressive if its JSON says so. The numbers of triangles and vertices are then in the first chunk of each mesh, which are read alone: the file is read from its start until all of them are there.
//! 3. What was found in a file is kept until the file changes; the whole list is kept for two seconds.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::sync::Mutex;

use serde::Serialize;
use tristrip::stream::{Decoder, StreamPart, chunks};
use tristrip_io::Format;
use tristrip_io::gltf::ProgressiveGlb;

use crate::folder::{Folder, Version};
use crate::glb_start::{first_bytes, json_of};
use crate::paths::SitePath;

/// The depth of folders, and the files and folders that are looked at.
const MOST_DEPTH: usize = 16;
const MOST_ENTRIES: usize = 10_000;
/// The first bytes of a file that are read, and the most, to find its numbers.
const FIRST_BYTES: u64 = 64 << 10;
const MOST_BYTES: u64 = 64 << 20;

/// What a client gets of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    /// A progressive GLB.
    Progressive,
    /// A file that is packed when it is asked for.
    Packed,
    /// A GLB without a stream.
    Static,
}

/// A model of the list.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct Listed {
    pub(crate) name: String,
    pub(crate) url: String,
    pub(crate) kind: Kind,
    pub(crate) bytes: u64,
    pub(crate) triangles: Option<usize>,
    pub(crate) vertices: Option<usize>,
    pub(crate) thumbnail: String,
}

/// The list of models.
#[derive(Debug, Default, Serialize)]
pub(crate) struct Catalogue {
    pub(crate) models: Vec<Listed>,
    pub(crate) notes: Vec<String>,
}

/// What a GLB holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Contents {
    pub(crate) is_progressive: bool,
    /// The triangles and vertices of the full meshes.
    pub(crate) size: Option<(usize, usize)>,
}

impl Listed {
    /// Describes a file that is served as it is.
    pub(crate) fn file(path: &SitePath, bytes: u64, contents: Contents) -> Self {
        let kind = if contents.is_progressive { Kind::Progressive } else { Kind::Static };
        Self::new(path, format!("files/{}", path.encoded()), kind, bytes, contents)
    }

    fn new(path: &SitePath, url: String, kind: Kind, bytes: u64, contents: Contents) -> Self {
        Self {
            name: path.as_str().to_owned(),
            url,
            kind,
            bytes,
            triangles: contents.size.map(|(triangles, _)| triangles),
            vertices: contents.size.map(|(_, vertices)| vertices),
            thumbnail: format!("thumbnails/{}.png", path.encoded()),
        }
    }
}

/// Scans a folder, and remembers what was in its files.
#[derive(Debug, Default)]
pub(crate) struct Scanner {
    known: Mutex<HashMap<SitePath, (Version, Contents)>>,
}

impl Scanner {
    /// Lists the models of a folder by their paths. It may block.
    pub(crate) fn scan(&self, folder: &Folder, packs: bool) -> Catalogue {
        let (mut files, mut left, mut notes) = (Vec::new(), MOST_ENTRIES, Vec::new());
        collect(folder, "", MOST_DEPTH, &mut left, &mut files);
        if left == 0 {
            notes.push(format!("only the first {MOST_ENTRIES} files and folders were looked at"));
        }
        files.sort_by(|(a, ..), (b, ..)| a.cmp(b));
        let mut known = self.known.lock().map(|mut known| std::mem::take(&mut *known)).unwrap_or_default();
        let mut found = HashMap::new();
        let (mut models, mut unpacked) = (Vec::new(), 0_usize);
        for (path, version, format) in files {
            let mut contents = Contents::default();
            if format == Format::Glb {
                let before = known.remove(&path).filter(|(before, _)| *before == version);
                contents = match before {
                    Some((_, contents)) => contents,
                    None => folder.open_file(&path).map_or(contents, |(file, _)| contents_of(&file)),
                };
                found.insert(path.clone(), (version, contents));
            }
            if packs && !contents.is_progressive {
                let url = format!("packed/{}.glb", path.encoded());
                models.push(Listed::new(&path, url, Kind::Packed, version.bytes, contents));
            } else if format == Format::Glb {
                models.push(Listed::file(&path, version.bytes, contents));
            } else {
                unpacked += 1;
            }
        }
        if let Ok(mut known) = self.known.lock() {
            *known = found;
        }
        if unpacked > 0 {
            let files = if unpacked == 1 { "file" } else { "files" };
            notes.push(format!("{unpacked} {files} can be packed with --pack-on-demand"));
        }
        Catalogue { models, notes }
    }
}

/// Collects the model files below a folder.
fn collect(
    folder: &Folder,
    path: &str,
    depth: usize,
    left: &mut usize,
    files: &mut Vec<(SitePath, Version, Format)>,
) {
    for entry in folder.entries(path, left).unwrap_or_default() {
        let Some(version) = entry.version else {
            if depth > 0 {
                collect(folder, entry.path.as_str(), depth - 1, left, files);
            }
            continue;
        };
        if let Some(format) = Format::from_path(entry.path.as_str()) {
            files.push((entry.path, version, format));
        }
    }
}

/// Finds what a GLB holds; a file that is not one holds nothing that is known.
fn contents_of(file: &File) -> Contents {
    let mut contents = Contents::default();
    let mut bytes = FIRST_BYTES;
    loop {
        let Ok(start) = first_bytes(file, bytes) else { return contents };
        let is_whole = (start.len() as u64) < bytes;
        if !contents.is_progressive {
            match says_progressive(&start) {
                Some(false) => return contents,
                Some(true) => contents.is_progressive = true,
                None => (),
            }
        }
        if contents.is_progressive {
            contents.size = size_of(start);
        }
        if contents.size.is_some() || is_whole || bytes >= MOST_BYTES {
            return contents;
        }
        bytes *= 4;
    }
}

/// Checks whether the JSON of a GLB names the extension; `None` if it has not been read to its end.
fn says_progressive(start: &[u8]) -> Option<bool> {
    if !start.starts_with(b"glTF") || start.len() < 16 {
        return Some(false);
    }
    let json = json_of(start)?;
    let name = b"TRISTRIP_progressive";
    Some(json.windows(name.len()).any(|window| window == name))
}

/// Decodes the base meshes, whose heads have the sizes of the full ones; `None` if they are not all there.
fn size_of(start: Vec<u8>) -> Option<(usize, usize)> {
    let glb = ProgressiveGlb::open(start).ok()??;
    let mut decoder = Decoder::new(glb.limits());
    let mut missing: BTreeSet<u32> = glb.streams().clone();
    for chunk in chunks(glb.chunks()) {
        decoder.update(chunk.bytes).ok()?;
        missing.remove(&chunk.stream);
        if missing.is_empty() {
            let sum = |count: fn(&StreamPart) -> usize| decoder.parts().map(count).sum();
            return Some((sum(StreamPart::full_triangle_count), sum(StreamPart::full_vertex_count)));
        }
    }
    None
}

/// Finds what a GLB in memory holds.
pub(crate) fn contents_of_bytes(bytes: &[u8]) -> Contents {
    if says_progressive(bytes) != Some(true) {
        return Contents::default();
    }
    Contents { is_progressive: true, size: size_of(bytes.to_vec()) }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use tristrip_pipeline::{PackOptions, pack};

    use super::*;

    fn grid() -> Vec<u8> {
        let row = |y: usize| (0..60).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
        let square = |i: usize| (i..i + 59).map(|i| format!("f {} {} {} {}\n", i + 1, i + 2, i + 62, i + 61));
        (0..60).flat_map(row).chain((0..59).flat_map(|y| square(60 * y))).collect::<String>().into_bytes()
    }

    fn names(catalogue: &Catalogue) -> Vec<(&str, Kind)> {
        catalogue.models.iter().map(|model| (model.name.as_str(), model.kind)).collect()
    }

    fn folder_of_models(dir: &Path) -> Folder {
        let model = tristrip_io::read(&grid(), Format::Obj).unwrap();
        let packed = pack(&model, &PackOptions::default(), &()).unwrap();
        let plain =
            tristrip_io::write(&model, &[tristrip_io::Drawing::Faces], Format::Glb, tristrip::Layout::List);
        fs::create_dir_all(dir.join("b c")).unwrap();
        fs::write(dir.join("b c/grid.glb"), &packed.bytes).unwrap();
        fs::write(dir.join("a.glb"), plain.unwrap()).unwrap();
        fs::write(dir.join("z.obj"), grid()).unwrap();
        fs::write(dir.join("broken.glb"), "not a model").unwrap();
        fs::write(dir.join("notes.txt"), "no model").unwrap();
        fs::write(dir.join(".hidden.glb"), "").unwrap();
        Folder::open(dir).unwrap()
    }

    #[test]
    fn models_are_listed_by_path() {
        let dir = tempfile::tempdir().unwrap();
        let folder = folder_of_models(dir.path());
        let scanner = Scanner::default();
        let list = scanner.scan(&folder, false);
        assert_eq!(
            names(&list),
            [("a.glb", Kind::Static), ("b c/grid.glb", Kind::Progressive), ("broken.glb", Kind::Static)]
        );
        assert_eq!(list.notes, ["1 file can be packed with --pack-on-demand"]);
        let grid = &list.models[1];
        assert_eq!((grid.triangles, grid.vertices), (Some(59 * 59 * 2), Some(3600)));
        assert_eq!(grid.url, "files/b%20c/grid.glb");
        assert_eq!(grid.thumbnail, "thumbnails/b%20c/grid.glb.png");
        let list = scanner.scan(&folder, true);
        let packed = |name| (name, Kind::Packed);
        assert_eq!(
            names(&list),
            [packed("a.glb"), ("b c/grid.glb", Kind::Progressive), packed("broken.glb"), packed("z.obj")]
        );
        assert_eq!(list.models[3].url, "packed/z.obj.glb");
        assert!(list.notes.is_empty());
        fs::write(dir.path().join("b c/grid.glb"), "damaged").unwrap();
        assert_eq!(names(&scanner.scan(&folder, false))[1], ("b c/grid.glb", Kind::Static));
    }

    #[test]
    fn sizes_are_found_in_the_first_bytes() {
        let model = tristrip_io::read(&grid(), Format::Obj).unwrap();
        let packed = pack(&model, &PackOptions::default(), &()).unwrap();
        let size = Some((59 * 59 * 2, 3600));
        assert_eq!(contents_of_bytes(&packed.bytes), Contents { is_progressive: true, size });
        assert_eq!(size_of(packed.bytes[..packed.chunk_start].to_vec()), None);
        assert_eq!(says_progressive(&packed.bytes[..30]), None);
        assert_eq!(says_progressive(b"glTF"), Some(false));
    }
}
