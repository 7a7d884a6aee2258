//! Embeds images from separate files, so the model can be written to another directory.
//!
//! Each file becomes a new buffer with one view; the writer merges it with the others. Images that
//! cannot be read keep their URI.

use std::collections::HashMap;
use std::sync::Arc;

use serde_json::json;

use crate::error::Error;
use crate::gltf::document::buffer_files::BufferFiles;
use crate::gltf::document::byte_ranges::{SharedBytes, whole_of};
use crate::gltf::document::json::Value;
use crate::gltf::document::references::ExtensionNumbers;
use crate::gltf::document::scene::Scene;
use crate::gltf::document::{Located, entries_mut, list_mut};

/// The result of embedding image files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct EmbeddedImages {
    /// Number of images that are now embedded.
    pub embedded: usize,
    /// The images that are still references, each with its location and the reason.
    pub left: Vec<String>,
}

/// Embeds the images of a scene that are in separate files.
///
/// # Errors
/// `images`, `buffers` or `bufferViews` of the document is not an array.
pub(crate) fn embed(scene: &mut Scene, files: &mut BufferFiles<'_>) -> Result<EmbeddedImages, Error> {
    let mut out = EmbeddedImages::default();
    let root = &scene.document.root;
    let mut found = Vec::new();
    let bytes_named = ExtensionNumbers::of(root).names_bytes;
    for (index, image) in Located::entries(root, "images")?.enumerate() {
        let Some(uri) = image.field("uri") else { continue };
        let loaded = match uri.text() {
            Ok(text) if text.starts_with("data:") => continue,
            // Buffers cannot be merged if an extension refers to bytes of one.
            Ok(_) if bytes_named => {
                Err(uri.wrong("no extension that refers to bytes of a buffer, or embedded images"))
            }
            Ok(text) => files.load(&uri).and_then(|bytes| match mime_type(&bytes) {
                Some(mime_type) => Ok((text.to_owned(), bytes, mime_type)),
                None => Err(uri.wrong("a PNG, JPEG, WebP, KTX2, DDS or AVIF file")),
            }),
            Err(error) => Err(error),
        };
        match loaded {
            Ok((uri, bytes, mime_type)) => found.push((index, uri, bytes, mime_type)),
            Err(error) => out.left.push(error.to_string()),
        }
    }
    out.embedded = found.len();
    let mut views: HashMap<String, usize> = HashMap::new();
    for (index, uri, bytes, mime_type) in found {
        let view = match views.get(&uri) {
            Some(&view) => view,
            None => *views.entry(uri).or_insert(append(scene, bytes)?),
        };
        let image = entries_mut(&mut scene.document.root, "images")?.get_mut(index);
        if let Some(members) = image.and_then(Value::as_object_mut) {
            members.remove("uri");
            members.insert("bufferView", view);
            members.insert("mimeType", mime_type);
        }
    }
    Ok(out)
}

/// Appends a buffer with one view and returns the index of the view.
fn append(scene: &mut Scene, bytes: Arc<Vec<u8>>) -> Result<usize, Error> {
    let (owner, range) = whole_of(bytes);
    let length = range.len();
    scene.buffers.push(SharedBytes { owner, range });
    let buffers = list_mut(&mut scene.document.root, "buffers")?;
    buffers.push(json!({ "byteLength": length }).into());
    let buffer = buffers.len() - 1;
    let views = list_mut(&mut scene.document.root, "bufferViews")?;
    views.push(json!({ "buffer": buffer, "byteLength": length }).into());
    Ok(views.len() - 1)
}

/// Returns the MIME type of an image from its magic bytes: the types of core glTF and of the
/// texture extensions.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    let at = |offset: usize, magic: &[u8]| bytes.get(offset..).is_some_and(|rest| rest.starts_with(magic));
    let types: [(bool, &str); 6] = [
        (at(0, b"\x89PNG\r\n\x1a\n"), "image/png"),
        (at(0, b"\xff\xd8\xff"), "image/jpeg"),
        (at(0, b"RIFF") && at(8, b"WEBP"), "image/webp"),
        (at(0, b"\xabKTX 20\xbb\r\n\x1a\n"), "image/ktx2"),
        (at(0, b"DDS "), "image/vnd-ms.dds"),
        (at(4, b"ftypavif"), "image/avif"),
    ];
    types.iter().find(|(is, _)| *is).map(|&(_, name)| name)
}
