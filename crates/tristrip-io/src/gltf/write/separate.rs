//! Splits a GLB into two files: the document as JSON, and its buffer. The document refers to the
//! buffer by a relative URI.

use std::fmt::Write;
use std::sync::Arc;

use crate::error::Error;
use crate::gltf::document::container;
use crate::gltf::document::json::Value;
use crate::gltf::document::{Document, entries_mut, index};

/// A document and its buffer as separate files.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SeparateFiles {
    /// The `.gltf` file.
    pub json: Vec<u8>,
    /// The URI of its buffer: the file name, percent-encoded.
    pub uri: String,
    /// The buffer, to be written into the directory of the document. Empty if the document has
    /// none.
    pub buffer: Vec<u8>,
}

/// Splits a GLB into a document and a buffer with this file name. Everything except the URI of the
/// buffer is the same as in the GLB.
///
/// # Errors
/// The bytes are not a GLB or the JSON of a `.gltf`.
///
/// ```
/// use tristrip_io::{Drawing, Format, gltf, read, write};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// let glb = write(&model, &[Drawing::Faces], Format::Glb, tristrip::Layout::List)?;
/// let files = gltf::separate(glb, "my model.bin")?;
/// assert_eq!(files.uri, "my%20model.bin");
/// let again = gltf::read_separate(&files)?;
/// assert_eq!(again.parts[0].mesh, model.parts[0].mesh);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn separate(glb: Vec<u8>, file_name: &str) -> Result<SeparateFiles, Error> {
    let container = container::open(Arc::new(glb), &mut Vec::new())?;
    let mut document = Document::parse(container.json_bytes())?;
    let uri = escaped(file_name);
    let mut buffer = Vec::new();
    if let Some(bin) = &container.bin {
        let bytes = &container.file[bin.clone()];
        let first = entries_mut(&mut document.root, "buffers")?.first_mut().and_then(Value::as_object_mut);
        if let Some(members) = first.filter(|members| !members.contains_key("uri")) {
            // The chunk is padded.
            let length = members.get("byteLength").and_then(index).unwrap_or(bytes.len());
            buffer = bytes[..length.min(bytes.len())].to_vec();
            members.insert("uri", uri.as_str());
        }
    }
    Ok(SeparateFiles { json: document.to_bytes(), uri, buffer })
}

/// Returns a file name as a relative URI.
fn escaped(file_name: &str) -> String {
    let mut out = String::with_capacity(file_name.len());
    for byte in file_name.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => out.push(byte.into()),
            // Writing to a string cannot fail.
            _ => drop(write!(out, "%{byte:02X}")),
        }
    }
    out
}
