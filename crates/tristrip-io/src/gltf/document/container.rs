//! The GLB container: a header, a JSON chunk, and a binary chunk. A `.gltf` file is treated as a
//! JSON chunk without a binary chunk. [`GlbContent`] is a GLB before it is written: a document with
//! a single buffer.

use std::ops::Range;
use std::sync::Arc;

use crate::error::Error;
use crate::gltf::document::Document;
use crate::gltf::document::byte_ranges::SharedBytes;
use tristrip::text::counted;

const MAGIC: &[u8; 4] = b"glTF";
const JSON_CHUNK: u32 = 0x4E4F_534A;
const BIN_CHUNK: u32 = 0x004E_4942;
/// The byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
const HEADER_BYTES: usize = 12;
pub(in crate::gltf) const CHUNK_HEADER_BYTES: usize = 8;

/// A file and the byte ranges of its two chunks.
pub(in crate::gltf) struct GlbContainer {
    pub(in crate::gltf) file: Arc<Vec<u8>>,
    pub(in crate::gltf) json: Range<usize>,
    pub(in crate::gltf) bin: Option<Range<usize>>,
}

impl GlbContainer {
    /// Returns the JSON, which shares the bytes of the file, without a byte order mark and without
    /// the trailing zeros and white space that some writers pad it with.
    pub(in crate::gltf) fn json_bytes(&self) -> SharedBytes {
        let Range { mut start, mut end } = self.json;
        if self.file[start..end].starts_with(BYTE_ORDER_MARK) {
            start += BYTE_ORDER_MARK.len();
        }
        while end > start && matches!(self.file[end - 1], 0 | b' ' | b'\t' | b'\r' | b'\n') {
            end -= 1;
        }
        SharedBytes { owner: Arc::clone(&self.file), range: start..end }
    }
}

/// A document and the bytes of its only buffer.
#[derive(Clone)]
pub(in crate::gltf) struct GlbContent {
    pub(in crate::gltf) document: Document,
    /// Empty for a document without buffers.
    pub(in crate::gltf) buffer: SharedBytes,
}

impl GlbContent {
    /// Returns the buffers of the document: one, or none.
    pub(in crate::gltf) fn buffers(&self) -> Vec<SharedBytes> {
        Vec::from_iter((self.buffer.len() > 0).then(|| self.buffer.clone()))
    }

    /// Returns the size of the file in bytes.
    pub(in crate::gltf) fn file_bytes(&self) -> usize {
        file_bytes(self.document.to_bytes().len(), self.buffer.len())
    }

    /// Writes the file.
    pub(in crate::gltf) fn write(&self) -> Result<Vec<u8>, Error> {
        write(&self.document.to_bytes(), &[self.buffer.as_slice()])
    }
}

/// Checks whether a file starts with the GLB magic.
pub(in crate::gltf) fn is_glb(file: &[u8]) -> bool {
    file.starts_with(MAGIC)
}

/// Returns the offset of the end of the JSON in a GLB from the file's first bytes, or `None` if
/// more bytes are needed.
///
/// # Errors
/// The bytes are not the start of a GLB of version 2 that begins with JSON.
pub(in crate::gltf) fn json_end(start: &[u8]) -> Result<Option<u64>, Error> {
    if !start.starts_with(&MAGIC[..start.len().min(MAGIC.len())]) {
        let found = format!("\"{}\"", start[..start.len().min(4)].escape_ascii());
        return Err(Error::format("byte 0", found, "`glTF` of a GLB"));
    }
    if let Some(version) = word(start, 4) {
        check_version(version)?;
    }
    if let Some(kind) = word(start, HEADER_BYTES + 4) {
        check_json(kind)?;
        let length = word(start, HEADER_BYTES).map(u64::from);
        return Ok(length.map(|length| (HEADER_BYTES + CHUNK_HEADER_BYTES) as u64 + length));
    }
    Ok(None)
}

fn check_version(version: u32) -> Result<(), Error> {
    if version == 2 {
        return Ok(());
    }
    Err(Error::format("byte 4", format!("GLB version {version}"), "2"))
}

/// Checks the type of the first chunk.
fn check_json(kind: u32) -> Result<(), Error> {
    if kind == JSON_CHUNK {
        return Ok(());
    }
    let found = format!("chunk type {kind:#010x}");
    Err(Error::format(format!("byte {}", HEADER_BYTES + 4), found, "0x4e4f534a (JSON)"))
}

/// Finds the chunks of a GLB that may be truncated: its JSON, and the available part of the binary
/// chunk. Returns `None` if the JSON is truncated.
pub(in crate::gltf) fn open_start(file: Arc<Vec<u8>>) -> Option<GlbContainer> {
    let end = usize::try_from(json_end(&file).ok()??).ok()?;
    let json = HEADER_BYTES + CHUNK_HEADER_BYTES..end;
    if json.end > file.len() {
        return None;
    }
    let is_bin = word(&file, json.end.checked_add(4)?) == Some(BIN_CHUNK);
    let bin = word(&file, json.end).filter(|_| is_bin).map(|size| {
        let start = json.end + CHUNK_HEADER_BYTES;
        start..start.saturating_add(size as usize).min(file.len())
    });
    Some(GlbContainer { file, json, bin })
}

/// Finds the chunks of a GLB, or treats a whole `.gltf` file as JSON.
pub(in crate::gltf) fn open(file: Arc<Vec<u8>>, notes: &mut Vec<String>) -> Result<GlbContainer, Error> {
    if !is_glb(&file) {
        return open_json(file);
    }
    let header = |at: usize, what: &str| {
        word(&file, at).ok_or_else(|| {
            let found = format!("the end of the file after {}", counted(file.len(), "byte"));
            Error::format(format!("byte {at}"), found, what)
        })
    };
    check_version(header(4, "the GLB version")?)?;
    let length = header(8, "the length of the file")? as usize;
    let least = HEADER_BYTES + CHUNK_HEADER_BYTES;
    if length > file.len() || length < least {
        let expected = match file.len() {
            n if n < least => {
                format!("at least {least}, two headers; the file has {}", counted(n, "byte"))
            }
            n => format!("{least} to {n}, the length of the file"),
        };
        return Err(Error::format("byte 8", format!("length {length}"), expected));
    }
    if length < file.len() {
        notes.push(format!("dropped bytes after the end of the GLB: {}", file.len() - length));
    }
    let (kind, json) = chunk(&file, HEADER_BYTES, length)?;
    check_json(kind)?;
    let mut bin = None;
    let mut at = json.end;
    let mut unknown_count = 0;
    while at < length {
        // The last chunk may be followed by padding shorter than a chunk header.
        if length - at < CHUNK_HEADER_BYTES && file[at..length].iter().all(|&b| b == 0 || b == b' ') {
            break;
        }
        let (kind, body) = chunk(&file, at, length)?;
        at = body.end;
        if kind == BIN_CHUNK && bin.is_none() {
            bin = Some(body);
        } else {
            unknown_count += 1;
        }
    }
    if unknown_count > 0 {
        notes.push(format!("dropped GLB chunks of unknown type: {unknown_count}"));
    }
    Ok(GlbContainer { file, json, bin })
}

fn open_json(file: Arc<Vec<u8>>) -> Result<GlbContainer, Error> {
    let start = if file.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
    let first = file[start..].iter().find(|b| !b.is_ascii_whitespace());
    if first != Some(&b'{') {
        let found = match file.len() {
            0 => "an empty file".to_owned(),
            n => format!("\"{}\"", file[..n.min(4)].escape_ascii()),
        };
        return Err(Error::format("byte 0", found, "`glTF` of a GLB or `{` of JSON"));
    }
    let json = 0..file.len();
    Ok(GlbContainer { file, json, bin: None })
}

/// Returns the type and the body's byte range of the chunk at byte `at`.
fn chunk(file: &[u8], at: usize, end: usize) -> Result<(u32, Range<usize>), Error> {
    let left = end - at;
    let (Some(length), Some(kind), true) = (word(file, at), word(file, at + 4), left >= CHUNK_HEADER_BYTES)
    else {
        return Err(Error::format(format!("byte {at}"), counted(left, "byte"), "8 bytes of a chunk header"));
    };
    let body = at + CHUNK_HEADER_BYTES;
    if length as usize > end - body {
        let expected = format!("at most {}, the remaining size of the file", end - body);
        return Err(Error::format(format!("byte {at}"), format!("chunk length {length}"), expected));
    }
    Ok((kind, body..body + length as usize))
}

fn word(file: &[u8], at: usize) -> Option<u32> {
    let bytes = file.get(at..at.checked_add(4)?)?;
    Some(u32::from_le_bytes(bytes.try_into().ok()?))
}

/// Returns the offset of the buffer in a GLB whose JSON has `json` bytes.
pub(in crate::gltf) fn bin_start(json: usize) -> usize {
    HEADER_BYTES + CHUNK_HEADER_BYTES + json.next_multiple_of(4) + CHUNK_HEADER_BYTES
}

/// Returns the size of a GLB with JSON and a buffer of these sizes.
pub(in crate::gltf) fn file_bytes(json: usize, bin: usize) -> usize {
    let start = bin_start(json);
    if bin == 0 { start - CHUNK_HEADER_BYTES } else { start + bin.next_multiple_of(4) }
}

/// Writes a GLB from its JSON and the slices of its buffer, which are concatenated.
pub(in crate::gltf) fn write(json: &[u8], slices: &[&[u8]]) -> Result<Vec<u8>, Error> {
    let json_bytes = json.len().next_multiple_of(4);
    let bin: usize = slices.iter().map(|s| s.len()).sum();
    let bin_bytes = bin.next_multiple_of(4);
    let length = file_bytes(json.len(), bin);
    let Ok(length_word) = u32::try_from(length) else {
        let limit = u64::from(u32::MAX);
        return Err(Error::LimitExceeded { at: "GLB length".into(), found: length as u64, limit });
    };
    let mut out = Vec::with_capacity(length);
    out.extend_from_slice(MAGIC);
    out.extend_from_slice(&2u32.to_le_bytes());
    out.extend_from_slice(&length_word.to_le_bytes());
    out.extend_from_slice(&(json_bytes as u32).to_le_bytes());
    out.extend_from_slice(&JSON_CHUNK.to_le_bytes());
    out.extend_from_slice(json);
    out.resize(HEADER_BYTES + CHUNK_HEADER_BYTES + json_bytes, b' ');
    if bin > 0 {
        out.extend_from_slice(&(bin_bytes as u32).to_le_bytes());
        out.extend_from_slice(&BIN_CHUNK.to_le_bytes());
        for slice in slices {
            out.extend_from_slice(slice);
        }
        out.resize(length, 0);
    }
    Ok(out)
}
