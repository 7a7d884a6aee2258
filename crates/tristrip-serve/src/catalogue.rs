//! The list of models for the gallery, `/models.json`: the models of the directory with their
//! sizes, and with triangle counts where these can be read quickly.
//!
//! # Algorithm
//! 1. Scan the directory and its subdirectories, up to a maximum depth and a maximum number of
//!    entries. Skip names that no URL can contain.
//! 2. Read the header and the JSON of each GLB. The JSON states whether the GLB is progressive. The
//!    triangle and vertex counts of a progressive GLB are in the first chunk of each mesh: read the
//!    stream from its start until all these chunks are found. Skip the base meshes and textures
//!    before the stream.
//! 3. A scan reads a limited number of bytes. A note counts the remaining files; the next scan
//!    reads them.
//! 4. The result for a file is cached until the file changes, and the complete list for two
//!    seconds.
//! 5. A scan stops early when no client waits for it. The results so far are kept.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use tristrip::stream::{Decoder, StreamPart, chunks};
use tristrip_io::Format;
use tristrip_io::gltf::ChunkRange;
use tristrip_pipeline::text::counted;

use crate::folder::{Folder, Version};
use crate::glb_start::{HEAD_BYTES, bytes_at, json_bytes};
use crate::paths::SitePath;

/// The maximum depth of directories, and the maximum number of files and directories per scan.
const MAX_DEPTH: usize = 16;
const MAX_ENTRIES: usize = 10_000;
/// The bytes of all files that a scan reads.
const SCAN_BYTES: u64 = 256 << 20;
/// The maximum size of the JSON of a GLB in bytes. A GLB with more JSON is listed as not
/// progressive, without counts.
const MAX_JSON_BYTES: u64 = 16 << 20;
/// The size of the first piece of a stream that is read to find its counts, and the maximum of all
/// pieces.
const PIECE_BYTES: u64 = 16 << 10;
const MAX_STREAM_BYTES: u64 = 16 << 20;

/// How a model is served.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Kind {
    /// A progressive GLB.
    Progressive,
    /// A file that is packed on request.
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

/// The contents of a GLB.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Contents {
    pub(crate) is_progressive: bool,
    /// The numbers of triangles and vertices of the full meshes.
    pub(crate) size: Option<(usize, usize)>,
}

impl Listed {
    /// Describes a file that is served unchanged.
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

/// Scans a directory and caches the contents of its files.
#[derive(Debug)]
pub(crate) struct Scanner {
    known: Mutex<HashMap<SitePath, (Version, Contents)>>,
    /// The bytes of all files that a scan reads.
    most_bytes: u64,
}

impl Default for Scanner {
    fn default() -> Self {
        Self { known: Mutex::default(), most_bytes: SCAN_BYTES }
    }
}

/// A recursive walk through a directory.
struct Walk<'a> {
    folder: &'a Folder,
    /// Returns whether a client still waits for the result.
    is_wanted: &'a dyn Fn() -> bool,
    /// The number of files and directories that may still be visited.
    left: usize,
    files: Vec<(SitePath, Version, Format)>,
}

impl Scanner {
    /// Lists the models of a directory, sorted by path; returns `None` if no client waits for the
    /// result any more. May block.
    pub(crate) fn scan(
        &self,
        folder: &Folder,
        packs: bool,
        is_wanted: &dyn Fn() -> bool,
    ) -> Option<Catalogue> {
        let mut walk = Walk { folder, is_wanted, left: MAX_ENTRIES, files: Vec::new() };
        walk.collect("", MAX_DEPTH)?;
        let Walk { left, mut files, .. } = walk;
        let mut notes = Vec::new();
        if left == 0 {
            notes.push(format!("scanned only the first {MAX_ENTRIES} files and directories"));
        }
        files.sort_by(|(a, ..), (b, ..)| a.cmp(b));
        let mut bytes_left = self.most_bytes;
        let (mut models, mut unpacked, mut unread) = (Vec::new(), 0_usize, 0_usize);
        for (path, version, format) in &files {
            if !is_wanted() {
                return None;
            }
            let contents = match format {
                Format::Glb => self.contents(folder, path, *version, &mut bytes_left).unwrap_or_else(|| {
                    unread += 1;
                    Contents::default()
                }),
                _ => Contents::default(),
            };
            if packs && !contents.is_progressive {
                let url = format!("packed/{}.glb", path.encoded());
                models.push(Listed::new(path, url, Kind::Packed, version.bytes, contents));
            } else if *format == Format::Glb {
                models.push(Listed::file(path, version.bytes, contents));
            } else {
                unpacked += 1;
            }
        }
        // Forget files that no longer exist.
        let paths: HashSet<&SitePath> = files.iter().map(|(path, ..)| path).collect();
        self.known().retain(|path, _| paths.contains(path));
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{} {what}", counted(count, "file")));
            }
        };
        note(unread, "not read yet; reload the list to complete it");
        note(unpacked, "can be packed with --pack-on-demand");
        Some(Catalogue { models, notes })
    }

    /// Returns the contents of a GLB, cached or read now; `None` if the byte limit of the scan is
    /// reached.
    fn contents(
        &self,
        folder: &Folder,
        path: &SitePath,
        version: Version,
        bytes_left: &mut u64,
    ) -> Option<Contents> {
        if let Some((known, contents)) = self.known().get(path)
            && *known == version
        {
            return Some(*contents);
        }
        let mut is_over = false;
        let contents = folder.open_file(path).map_or(Contents::default(), |(file, _)| {
            contents_of(version.bytes, |offset, length| {
                is_over |= length > *bytes_left;
                *bytes_left = bytes_left.checked_sub(length)?;
                bytes_at(&file, offset, length).ok()
            })
        });
        if is_over {
            return None;
        }
        self.known().insert(path.clone(), (version, contents));
        Some(contents)
    }

    fn known(&self) -> MutexGuard<'_, HashMap<SitePath, (Version, Contents)>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Walk<'_> {
    /// Collects the model files below a directory; `None` if no client waits for them any more.
    fn collect(&mut self, path: &str, depth: usize) -> Option<()> {
        if !(self.is_wanted)() {
            return None;
        }
        for entry in self.folder.entries(path, &mut self.left).unwrap_or_default() {
            let Some(version) = entry.version else {
                if depth > 0 {
                    self.collect(entry.path.as_str(), depth - 1)?;
                }
                continue;
            };
            if let Some(format) = Format::from_path(entry.path.as_str()) {
                self.files.push((entry.path, version, format));
            }
        }
        Some(())
    }
}

/// Reads the contents of a GLB with this file size. For other files and unreadable files, returns
/// the default.
fn contents_of(file_bytes: u64, mut read: impl FnMut(u64, u64) -> Option<Vec<u8>>) -> Contents {
    let mut contents = Contents::default();
    let find = || {
        let mut start = read(0, HEAD_BYTES.min(file_bytes))?;
        let length = json_bytes(&start).filter(|length| *length <= MAX_JSON_BYTES)?;
        start.extend(read(HEAD_BYTES, length)?);
        let name = b"TRISTRIP_progressive";
        // Most files need no parsing.
        if start.windows(name.len()).any(|window| window == name) {
            let range = ChunkRange::find(start).ok()??;
            contents.is_progressive = true;
            contents.size = size_of(&range, file_bytes, read);
        }
        Some(())
    };
    find();
    contents
}

/// Decodes the base meshes, whose headers contain the sizes of the full meshes. Returns `None` if a
/// base mesh is missing.
fn size_of(
    range: &ChunkRange,
    file_bytes: u64,
    mut read: impl FnMut(u64, u64) -> Option<Vec<u8>>,
) -> Option<(usize, usize)> {
    let Range { start: mut at, end } = range.bytes();
    let end = end.min(file_bytes);
    let mut decoder = Decoder::new(range.limits(end.saturating_sub(at)));
    let mut missing: BTreeSet<u32> = range.streams().clone();
    let end = end.min(at.saturating_add(MAX_STREAM_BYTES));
    let (mut bytes, mut piece) = (Vec::new(), PIECE_BYTES);
    while at < end {
        let length = piece.min(end - at);
        bytes.extend(read(at, length)?);
        at += length;
        piece *= 2;
        let mut used = 0;
        for chunk in chunks(&bytes) {
            decoder.update(chunk.bytes).ok()?;
            used += chunk.bytes.len();
            missing.remove(&chunk.stream);
            if missing.is_empty() {
                let sum = |count: fn(&StreamPart) -> usize| decoder.parts().map(count).sum();
                return Some((sum(StreamPart::full_triangle_count), sum(StreamPart::full_vertex_count)));
            }
        }
        bytes.drain(..used);
    }
    None
}

/// Reads the contents of a GLB in memory.
pub(crate) fn contents_of_bytes(bytes: &[u8]) -> Contents {
    contents_of(bytes.len() as u64, |offset, length| {
        let offset = usize::try_from(offset).ok()?;
        let rest = bytes.get(offset..)?;
        Some(rest[..rest.len().min(usize::try_from(length).ok()?)].to_vec())
    })
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use tristrip_pipeline::pack;

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
        let packed = pack::run(&model, &pack::Options::default(), &()).unwrap();
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
        let list = scanner.scan(&folder, false, &|| true).unwrap();
        assert_eq!(
            names(&list),
            [("a.glb", Kind::Static), ("b c/grid.glb", Kind::Progressive), ("broken.glb", Kind::Static)]
        );
        assert_eq!(list.notes, ["1 file can be packed with --pack-on-demand"]);
        let grid = &list.models[1];
        assert_eq!((grid.triangles, grid.vertices), (Some(59 * 59 * 2), Some(3600)));
        assert_eq!(grid.url, "files/b%20c/grid.glb");
        assert_eq!(grid.thumbnail, "thumbnails/b%20c/grid.glb.png");
        let list = scanner.scan(&folder, true, &|| true).unwrap();
        let packed = |name| (name, Kind::Packed);
        assert_eq!(
            names(&list),
            [packed("a.glb"), ("b c/grid.glb", Kind::Progressive), packed("broken.glb"), packed("z.obj")]
        );
        assert_eq!(list.models[3].url, "packed/z.obj.glb");
        assert!(list.notes.is_empty());
        fs::write(dir.path().join("b c/grid.glb"), "damaged").unwrap();
        assert_eq!(
            names(&scanner.scan(&folder, false, &|| true).unwrap())[1],
            ("b c/grid.glb", Kind::Static)
        );
    }

    #[test]
    fn sizes_are_found_without_the_bytes_before_the_stream() {
        let model = tristrip_io::read(&grid(), Format::Obj).unwrap();
        let packed = pack::run(&model, &pack::Options::default(), &()).unwrap();
        let size = Some((59 * 59 * 2, 3600));
        let whole = Contents { is_progressive: true, size };
        assert_eq!(contents_of_bytes(&packed.bytes), whole);
        let without_chunks = Contents { size: None, ..whole };
        assert_eq!(contents_of_bytes(&packed.bytes[..packed.base_bytes]), without_chunks);
        assert_eq!(contents_of_bytes(&packed.bytes[..30]), Contents::default());
        assert_eq!(contents_of_bytes(b"glTF"), Contents::default());
        let mut read = Vec::new();
        let found = contents_of(packed.bytes.len() as u64, |offset, length| {
            read.push(offset..offset + length);
            packed.bytes.get(offset as usize..(offset + length) as usize).map(<[u8]>::to_vec)
        });
        assert_eq!(found, whole);
        let json = u64::from(u32::from_le_bytes(packed.bytes[12..16].try_into().unwrap()));
        assert_eq!(read[..2], [0..20, 20..20 + json]);
        assert!(read.len() == 3 && read[2].start == packed.base_bytes as u64, "{read:?}");
        assert!(read[2].end - read[2].start <= PIECE_BYTES, "{read:?}");
        // A file that only mentions the extension.
        let json = br#"{"asset":{"version":"2.0","generator":"TRISTRIP_progressive"}}  "#;
        let words = [2, 20 + json.len() as u32, json.len() as u32].map(u32::to_le_bytes).concat();
        let named = [b"glTF", &words[..], b"JSON", json].concat();
        assert_eq!(contents_of_bytes(&named), Contents::default());
        // A header that announces more JSON than any scan reads.
        let mut long = packed.bytes.clone();
        long[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(contents_of_bytes(&long), Contents::default());
    }

    #[test]
    fn a_scan_reads_a_limited_number_of_bytes_and_the_next_one_goes_on() {
        let dir = tempfile::tempdir().unwrap();
        let folder = folder_of_models(dir.path());
        let grid = fs::read(dir.path().join("b c/grid.glb")).unwrap();
        (0..5).for_each(|i| fs::write(dir.path().join(format!("{i}.glb")), &grid).unwrap());
        // Enough for two or three of the files.
        let scanner = Scanner { most_bytes: 2 * grid.len() as u64 + 1000, ..Scanner::default() };
        let known = |list: &Catalogue| list.models.iter().filter(|model| model.triangles.is_some()).count();
        let mut before = 0;
        loop {
            let list = scanner.scan(&folder, false, &|| true).unwrap();
            assert_eq!(list.models.len(), 8);
            let now = known(&list);
            assert!(now > before && now <= before + 6, "{now} after {before}");
            before = now;
            let is_whole = !list.notes[0].contains("not read yet");
            assert_eq!(is_whole, now == 6, "{:?}", list.notes);
            if is_whole {
                break;
            }
        }
    }

    #[test]
    fn a_scan_ends_when_nobody_wants_it_and_keeps_what_it_found() {
        use std::cell::Cell;
        let dir = tempfile::tempdir().unwrap();
        let folder = folder_of_models(dir.path());
        let scanner = Scanner::default();
        // Two folders, and four files.
        for most in 0..6_usize {
            let asked = Cell::new(0_usize);
            let is_wanted = || {
                asked.set(asked.get() + 1);
                asked.get() <= most
            };
            assert!(scanner.scan(&folder, false, &is_wanted).is_none(), "{most}");
            assert_eq!(asked.get(), most + 1);
            assert_eq!(scanner.known().len(), usize::min(3, most.saturating_sub(2)), "{most}");
        }
        // Found again without reading a byte.
        let scanner = Scanner { most_bytes: 0, known: Mutex::new(std::mem::take(&mut scanner.known())) };
        let list = scanner.scan(&folder, false, &|| true).unwrap();
        assert_eq!(list.notes, ["1 file can be packed with --pack-on-demand"]);
        fs::remove_file(dir.path().join("a.glb")).unwrap();
        scanner.scan(&folder, false, &|| true).unwrap();
        assert_eq!(scanner.known().len(), 2);
    }
}
