//! The buffers of a document: the GLB's binary chunk, data URIs, and files.

use std::ops::Range;
#[cfg(not(feature = "fs"))]
use std::path::Path;
use std::sync::Arc;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use crate::error::Error;
use crate::gltf::BufferFiles;
use crate::gltf::document::byte_ranges::{SharedBytes, whole_of};
use crate::gltf::document::json::Value;
use crate::gltf::document::{Document, Located, entries_mut, index};
use crate::gltf::write::separate::SeparateFiles;

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// Loads all buffers and removes their `uri`s from the document, because the bytes are stored
/// instead. Fallback buffers stay empty even if the file has their bytes. `beside` has the external
/// buffer of a document that is not in a directory.
pub(in crate::gltf) fn load(
    document: &mut Document,
    file: &Arc<Vec<u8>>,
    bin: Option<&Range<usize>>,
    files: &mut BufferFiles<'_>,
    beside: Option<&SeparateFiles>,
    is_fallback: &[bool],
) -> Result<Vec<SharedBytes>, Error> {
    let mut buffers = Vec::new();
    for (index, buffer) in Located::entries(&document.root, "buffers")?.enumerate() {
        let length_at = buffer.need("byteLength")?;
        let length = length_at.size()?;
        if is_fallback.get(index).copied().unwrap_or(false) {
            buffers.push(SharedBytes::default());
            continue;
        }
        let (owner, range) = match buffer.field("uri") {
            None => match bin {
                Some(bin) if index == 0 => (Arc::clone(file), bin.clone()),
                _ => {
                    let expected = "a URI, or the BIN chunk of a GLB for the first buffer";
                    return Err(Error::format(format!("{}.uri", buffer.at), "nothing", expected));
                }
            },
            Some(uri) => whole_of(match (uri.text()?.strip_prefix("data:"), beside) {
                (Some(data), _) => Arc::new(decode_data_uri(&uri, data)?),
                (None, Some(beside)) if uri.text()? == beside.uri => Arc::new(beside.buffer.clone()),
                (None, _) => files.load(&uri)?,
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

pub(in crate::gltf) fn decode_data_uri(uri: &Located<'_>, data: &str) -> Result<Vec<u8>, Error> {
    let Some((_, text)) = data.split_once(";base64,") else {
        return Err(uri.wrong("a data URI in base64"));
    };
    BASE64
        .decode(text)
        .map_err(|e| Error::format(uri.at.clone(), e.to_string().trim_end_matches('.'), "base64"))
}

/// Removes the `uri` of each buffer, and the text of data URIs.
fn remove_uris(document: &mut Document) -> Result<(), Error> {
    let has_uri = |buffer: &&mut Value| buffer.get("uri").is_some();
    let mut data = false;
    for buffer in entries_mut(&mut document.root, "buffers")?.iter_mut().filter(has_uri) {
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

/// Returns a view's buffer and byte range; the reader has checked both.
pub(in crate::gltf) fn view_range(
    v: usize,
    view: &Value,
    buffers: &[SharedBytes],
) -> Result<(usize, Range<usize>), Error> {
    let field = |name| view.get(name).and_then(index);
    let (buffer, start, length) =
        (field("buffer").unwrap_or(0), field("byteOffset").unwrap_or(0), field("byteLength").unwrap_or(0));
    let fits =
        buffers.get(buffer).is_some_and(|b| start.checked_add(length).is_some_and(|end| end <= b.len()));
    if fits {
        return Ok((buffer, start..start + length));
    }
    Err(Error::format(format!("bufferViews[{v}]"), "a range outside the buffer", "a range within the buffer"))
}

/// Rejects references to files, in a build that cannot read files.
#[cfg(not(feature = "fs"))]
pub(crate) struct NoBufferFiles<'a>(std::marker::PhantomData<&'a Path>);

#[cfg(not(feature = "fs"))]
impl<'a> NoBufferFiles<'a> {
    pub(crate) fn new(_folders: &'a [&'a Path]) -> Self {
        Self(std::marker::PhantomData)
    }

    #[allow(clippy::unused_self, reason = "same interface as `BufferFiles`")]
    pub(in crate::gltf) fn later_folders(&self) -> Vec<std::path::PathBuf> {
        Vec::new()
    }

    #[allow(clippy::unused_self, reason = "same interface as `BufferFiles`")]
    pub(in crate::gltf) fn load(&mut self, uri: &Located<'_>) -> Result<Arc<Vec<u8>>, Error> {
        Err(uri.wrong("a data URI, because this program cannot read files"))
    }
}
