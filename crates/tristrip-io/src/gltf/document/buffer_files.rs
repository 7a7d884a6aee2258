//! Opens the files that a document refers to. They must be in the directory of the document or
//! below it.
//!
//! A document opened through a symbolic link has two directories: the link's and the target's. The
//! file is opened in the first directory that contains it.

use std::collections::HashMap;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::error::Error;
use crate::gltf::document::Located;

/// The directories of a document, and the files already read.
pub(crate) struct BufferFiles<'a> {
    folders: &'a [&'a Path],
    files: HashMap<PathBuf, Arc<Vec<u8>>>,
    /// Bytes that may still be read, from files that are not hidden. `None`: no limit.
    left: Option<u64>,
}

impl<'a> BufferFiles<'a> {
    /// Looks for files in `folders`, in order.
    pub(crate) fn new(folders: &'a [&'a Path]) -> Self {
        Self { folders, files: HashMap::new(), left: None }
    }

    /// Reads at most `max_bytes` bytes, and no file whose path has a component that begins with a
    /// dot.
    pub(crate) fn limited(folders: &'a [&'a Path], max_bytes: u64) -> Self {
        Self { left: Some(max_bytes), ..Self::new(folders) }
    }

    /// Returns the directories in which the document may look for files later. Empty if the size is
    /// limited, because the limit ends with this value.
    pub(in crate::gltf) fn later_folders(&self) -> Vec<PathBuf> {
        let folders = if self.left.is_some() { &[] } else { self.folders };
        folders.iter().map(|folder| folder.to_path_buf()).collect()
    }

    /// Reads a file in one of the document's directories; each file is read once.
    pub(in crate::gltf) fn load(&mut self, uri: &Located<'_>) -> Result<Arc<Vec<u8>>, Error> {
        let outside = || uri.wrong("a data URI, or a file in the directory of the document");
        let relative =
            percent_decode(uri.text()?).and_then(|text| relative_path(&text)).ok_or_else(outside)?;
        if self.folders.is_empty() {
            return Err(uri.wrong("a data URI, because the directory of the document is unknown"));
        }
        self.load_relative(&relative)?.ok_or_else(outside)
    }

    /// Reads a file by the name given in a text file. Returns `None` if the name leads outside the
    /// directories or no directory is known.
    pub(crate) fn load_named(&mut self, name: &str) -> Result<Option<Arc<Vec<u8>>>, Error> {
        match relative_path(name) {
            Some(relative) if !self.folders.is_empty() => self.load_relative(&relative),
            _ => Ok(None),
        }
    }

    /// Reads a file in one of the directories. Returns `None` if a link leads outside them or the
    /// path is not a file.
    fn load_relative(&mut self, relative: &Path) -> Result<Option<Arc<Vec<u8>>>, Error> {
        if self.left.is_some() && is_hidden(relative) {
            return Ok(None);
        }
        let folders = self.folders;
        let first = folders.first().copied().unwrap_or(Path::new(""));
        let io_error = |source| Error::Io { path: first.join(relative).display().to_string(), source };
        let folders: Vec<PathBuf> =
            folders.iter().map(real_folder).collect::<Result<_, _>>().map_err(io_error)?;
        let path = find(&folders, relative).map_err(io_error)?;
        // A link may lead outside the directories even if the name does not.
        if !folders.iter().any(|folder| path.starts_with(folder)) || !path.is_file() {
            return Ok(None);
        }
        if let Some(bytes) = self.files.get(&path) {
            return Ok(Some(Arc::clone(bytes)));
        }
        let left = self.left.unwrap_or(u64::MAX);
        let exceeded = |found| Error::LimitExceeded {
            at: first.join(relative).display().to_string(),
            found,
            limit: left,
        };
        let file = File::open(&path).map_err(io_error)?;
        let found = file.metadata().map_err(io_error)?.len();
        if found > left {
            return Err(exceeded(found));
        }
        let mut bytes = Vec::new();
        // The file may have grown since `metadata`.
        file.take(left.saturating_add(1)).read_to_end(&mut bytes).map_err(io_error)?;
        let found = bytes.len() as u64;
        let rest = left.checked_sub(found).ok_or_else(|| exceeded(found))?;
        self.left = self.left.map(|_| rest);
        let bytes = Arc::new(bytes);
        self.files.insert(path, Arc::clone(&bytes));
        Ok(Some(bytes))
    }
}

fn is_hidden(relative: &Path) -> bool {
    let is_dotted = |name: &std::ffi::OsStr| name.as_encoded_bytes().starts_with(b".");
    relative.components().any(|component| matches!(component, Component::Normal(name) if is_dotted(name)))
}

/// Returns a directory with links resolved; the empty path means the current directory.
fn real_folder(folder: &&Path) -> std::io::Result<PathBuf> {
    if folder.as_os_str().is_empty() { Path::new(".").canonicalize() } else { folder.canonicalize() }
}

/// Returns the canonical path of a file in the first directory that has it. The error is that of
/// the first directory.
fn find(folders: &[PathBuf], relative: &Path) -> std::io::Result<PathBuf> {
    let mut found = folders.iter().map(|folder| folder.join(relative).canonicalize());
    let first = found.next().unwrap_or_else(|| Err(std::io::ErrorKind::NotFound.into()));
    first.or_else(|error| found.find_map(Result::ok).ok_or(error))
}

/// Returns a relative path if it has no `..`, root or drive.
fn relative_path(decoded: &str) -> Option<PathBuf> {
    if decoded.contains(['\\', ':', '\0']) {
        return None;
    }
    let path = PathBuf::from(decoded);
    let mut named = false;
    for component in path.components() {
        match component {
            Component::Normal(_) => named = true,
            Component::CurDir => {}
            _ => return None,
        }
    }
    named.then_some(path)
}

fn percent_decode(text: &str) -> Option<String> {
    let mut out = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        if first == b'%' {
            let digits = std::str::from_utf8(after.get(..2)?).ok()?;
            if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
                return None;
            }
            out.push(u8::from_str_radix(digits, 16).ok()?);
            rest = &after[2..];
        } else {
            out.push(first);
            rest = after;
        }
    }
    String::from_utf8(out).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relative_paths_stay_inside_the_folder() {
        let ok = |uri| relative_path(&percent_decode(uri)?).map(|p| p.display().to_string());
        assert_eq!(ok("a%20b/c.bin").as_deref(), Some("a b/c.bin"));
        assert_eq!(ok("./c.bin").as_deref(), Some("./c.bin"));
        for bad in [
            "",
            ".",
            "../c.bin",
            "a/../../c.bin",
            "/etc/passwd",
            "%2e%2e/c.bin",
            "a\\b",
            "c:b",
            "http://x/y",
            "file:///etc/passwd",
            "%",
            "%zz",
            "%+1",
            "a%00b",
            "%ff",
        ] {
            assert_eq!(ok(bad), None, "{bad}");
        }
    }
}
