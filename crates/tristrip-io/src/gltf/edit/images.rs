//! Images in separate files are embedded: a file that is written to another folder then has its textures.
//!
//! Each file becomes a buffer of its own with one view, which the writer joins with the others. Images that cannot be read keep
//! their URI.

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

/// What became of the images of a model that are in separate files.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct EmbeddedImages {
    /// The number of images that the model now holds.
    pub embedded: usize,
    /// The images that it still refers to: where, and why.
    pub left: Vec<String>,
}

/// Takes the images of a scene that are files into the scene.
///
/// # Errors
/// The document's lists are not arrays.
pub(crate) fn embed(scene: &mut Scene, files: &mut BufferFiles<'_>) -> Result<EmbeddedImages, Error> {
    let mut out = EmbeddedImages::default();
    let root = &scene.document.root;
    let mut found = Vec::new();
    let bytes_named = ExtensionNumbers::of(root).names_bytes;
    for (index, image) in Located::entries(root, "images")?.enumerate() {
        let Some(uri) = image.field("uri") else { continue };
        let loaded = match uri.text() {
            Ok(text) if text.starts_with("data:") => continue,
            // A buffer cannot be joined with others if an extension names bytes of it.
            Ok(_) if bytes_named => {
                Err(uri.wrong("no extension that names bytes of a buffer beside images in files"))
            }
            Ok(text) => files.load(&uri).and_then(|bytes| match mime_type(&bytes) {
                Some(mime_type) => Ok((text.to_owned(), bytes, mime_type)),
                None => Err(uri.wrong("a file in PNG, JPEG, WebP, KTX2, DDS or AVIF")),
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

/// Appends a buffer with one view; returns the view.
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

/// Returns the type of an image by its first bytes: those of core glTF, and of the extensions for textures.
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
