//! The buffers of a document: the GLB's own bytes, data URIs, and files in the document's folder, never outside it.
//!
//! A document that was opened through a link has two folders: that of the link, where the path that was given says that its
//! files are, and that of the file which the link leads to. The first that has the file is used.

use std::collections::HashMap;
use std::io::Read;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::document::{Document, Located, list_mut};
use super::json::Value;
use super::shared_bytes::{SharedBytes, whole_of};
use crate::error::Error;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Loads every buffer, and removes the `uri` of each from the document: the bytes are kept, not their text.
pub(super) fn load(
    document: &mut Document,
    file: &Arc<Vec<u8>>,
    bin: Option<&Range<usize>>,
    folders: &[&Path],
) -> Result<Vec<SharedBytes>, Error> {
    let mut buffers = Vec::new();
    let mut files: HashMap<PathBuf, Arc<Vec<u8>>> = HashMap::new();
    for (index, buffer) in Located::entries(&document.root, "buffers")?.enumerate() {
        let length_at = buffer.need("byteLength")?;
        let length = length_at.size()?;
        let (owner, range) = match buffer.field("uri") {
            None => match bin {
                Some(bin) if index == 0 => (Arc::clone(file), bin.clone()),
                _ => {
                    let expected = "a URI, or the BIN chunk of a GLB for the first buffer";
                    return Err(Error::format(format!("{}.uri", buffer.at), "nothing", expected));
                }
            },
            Some(uri) => whole_of(match uri.text()?.strip_prefix("data:") {
                Some(data) => Arc::new(decode_data_uri(&uri, data)?),
                None => load_file(&uri, folders, &mut files)?,
            }),
        };
        if range.len() < length {
            let expected = format!("at most {}, the size of the buffer", range.len());
            return Err(length_at.wrong(expected));
        }
        buffers.push(SharedBytes { owner, range: range.start..range.start + length });
    }
    if !buffers.is_empty() {
        remove_uris(document)?;
    }
    Ok(buffers)
}

fn decode_data_uri(uri: &Located<'_>, data: &str) -> Result<Vec<u8>, Error> {
    let Some((_, text)) = data.split_once(";base64,") else {
        return Err(uri.wrong("a data URI in base64"));
    };
    BASE64
        .decode(text)
        .map_err(|e| Error::format(uri.at.clone(), e.to_string().trim_end_matches('.'), "base64"))
}

/// Removes the `uri` of each buffer, and the text of those that hold data.
fn remove_uris(document: &mut Document) -> Result<(), Error> {
    let has_uri = |buffer: &&mut Value| buffer.get("uri").is_some();
    let mut data = false;
    for buffer in list_mut(&mut document.root, "buffers")?.iter_mut().filter(has_uri) {
        data |= buffer.get("uri").and_then(Value::as_str).is_some_and(|uri| uri.starts_with("data:"));
        if let Some(members) = buffer.as_object_mut() {
            members.remove("uri");
        }
    }
    if data {
        *document = std::mem::take(document).compacted()?;
    }
    Ok(())
}

/// Reads a file in one of the document's folders, once for all buffers that name it.
fn load_file(
    uri: &Located<'_>,
    folders: &[&Path],
    files: &mut HashMap<PathBuf, Arc<Vec<u8>>>,
) -> Result<Arc<Vec<u8>>, Error> {
    let text = uri.text()?;
    let Some(relative) = relative_path(text) else {
        return Err(uri.wrong("a data URI, or a file in the folder of the document"));
    };
    let Some(first) = folders.first() else {
        return Err(uri.wrong("a data URI: the folder of the document is not known"));
    };
    let io_error = |source| Error::Io { path: first.join(&relative).display().to_string(), source };
    let folders: Vec<PathBuf> =
        folders.iter().map(real_folder).collect::<Result<_, _>>().map_err(io_error)?;
    let path = find(&folders, &relative).map_err(io_error)?;
    // A link may lead outside the folders although the name does not.
    if !folders.iter().any(|folder| path.starts_with(folder)) || !path.is_file() {
        return Err(uri.wrong("a data URI, or a file in the folder of the document"));
    }
    if let Some(bytes) = files.get(&path) {
        return Ok(Arc::clone(bytes));
    }
    let mut bytes = Vec::new();
    std::fs::File::open(&path).and_then(|mut f| f.read_to_end(&mut bytes)).map_err(io_error)?;
    let bytes = Arc::new(bytes);
    files.insert(path, Arc::clone(&bytes));
    Ok(bytes)
}

/// Returns a folder without links; a document named without a folder is in the current one.
fn real_folder(folder: &&Path) -> std::io::Result<PathBuf> {
    if folder.as_os_str().is_empty() { Path::new(".").canonicalize() } else { folder.canonicalize() }
}

/// Finds a file in the first folder that has it, links followed; the error is that of the first folder.
fn find(folders: &[PathBuf], relative: &Path) -> std::io::Result<PathBuf> {
    let mut found = folders.iter().map(|folder| folder.join(relative).canonicalize());
    let first = found.next().unwrap_or_else(|| Err(std::io::ErrorKind::NotFound.into()));
    first.or_else(|error| found.find_map(Result::ok).ok_or(error))
}

/// Returns the path of a relative URI, if it has no `..`, root or drive.
fn relative_path(uri: &str) -> Option<PathBuf> {
    let decoded = percent_decode(uri)?;
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
        let ok = |uri| relative_path(uri).map(|p| p.display().to_string());
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
