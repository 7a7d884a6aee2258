//! Progressive GLB: base meshes that every viewer draws, followed by a stream of chunks that refines
//! them (`docs/formats/progressive-glb.md`).
//!
//! # Algorithm
//! Writing ([`write_progressive`]): the scene with its drawings is packed in memory. The chunks are
//! appended after all other bytes, the extensions are added, and the file is written once.
//!
//! Reading: the document reader refines base meshes to the full meshes (`refine.rs`).
//! [`ProgressiveGlb`] gives access to the chunks, even in a truncated file, and builds the scene of
//! any decoded level.
//!
//! # Complexity
//! Linear in the bytes of the file.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use serde_json::json;
use tristrip::Layout;
use tristrip::stream::StreamLimits;
use tristrip::text::counted;

use crate::error::Error;
use crate::gltf::document::container::{self, CHUNK_HEADER_BYTES, GlbContainer, GlbContent};
use crate::gltf::document::json::{Members, Value};
use crate::gltf::document::scene::PrimitiveRef;
use crate::gltf::document::{Document, Located, entries_mut, list_mut};
use crate::gltf::pack::{Rounding, pack_content};
use crate::gltf::read::read_refined;
use crate::gltf::stream::refine::{
    EXTENSION, StreamInDocument, StreamMeshes, StreamedPart, VERSION, change_primitive, limits,
};
use crate::gltf::write::keep::compact::set_buffer;
use crate::gltf::write::keep::draw;
use crate::model::{Drawing, Model};

/// A GLB in memory, and the start of its stream.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct WrittenGlb {
    /// The file.
    pub bytes: Vec<u8>,
    /// The offset of the first chunk, or the file size if there is no stream.
    pub chunk_start: usize,
}

/// Writes a progressive GLB: the drawings of a model with a scene, packed without rounding (see
/// [`pack`](crate::gltf::pack())), and the chunks of the stream that refines them. `parts` contains
/// the source of each refined part. Without chunks, the result is a plain GLB.
///
/// # Errors
/// The model has no scene, the number of drawings or sources differs from the number of parts, a
/// strip uses a vertex that does not exist, or the result exceeds 4 GiB.
///
/// ```
/// use tristrip::stream::{StreamOptions, encode};
/// use tristrip_io::gltf::{ProgressiveGlb, StreamedPart, with_scene, write_progressive};
/// use tristrip_io::{Drawing, Format, read};
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let faces = "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n";
/// let model = read([corners, faces].concat().as_bytes(), Format::Obj)?;
/// let model = with_scene(&model)?;
/// let mesh = &model.parts[0].mesh;
/// let options = tristrip::simplify::SimplifyOptions::default();
/// let corners = mesh.faces().corners().to_vec();
/// let tree = tristrip::simplify::refinement_batches(mesh, corners, &options)?;
/// let stream = encode(mesh, &tree.sequence, &tree.level_ends, 0, &StreamOptions::default())?;
/// let base = tristrip_io::with_triangles(&model, vec![stream.base.clone()], Format::Glb)?.model;
/// let parts = [Some(StreamedPart { stream: 0, part: None })];
/// let glb = write_progressive(&base, &[Drawing::Faces], &parts, &stream.bytes())?;
/// assert_eq!(read(&glb.bytes, Format::Glb)?.parts[0].mesh.faces().triangle_count(), 4);
/// let opened = ProgressiveGlb::open(glb.bytes)?;
/// let is_same_start = |opened: &ProgressiveGlb| opened.chunk_start() == glb.chunk_start;
/// assert!(opened.is_some_and(|opened| opened.is_complete() && is_same_start(&opened)));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn write_progressive(
    model: &Model,
    drawings: &[Drawing<'_>],
    parts: &[Option<StreamedPart>],
    chunks: &[u8],
) -> Result<WrittenGlb, Error> {
    model.check_drawings(drawings)?;
    let Some(scene) = &model.scene else {
        return Err(Error::Unsupported("cannot write a progressive GLB of a model without a scene".into()));
    };
    scene.check_part_count(parts.len())?;
    let content = pack_content(draw(scene, model, drawings, Layout::Degenerate)?.joined(), Rounding::None)?;
    if chunks.is_empty() {
        let bytes = content.write()?;
        return Ok(WrittenGlb { chunk_start: bytes.len(), bytes });
    }
    let GlbContent { mut document, buffer } = content;
    add_stream(&mut document.root, (&scene.primitives, parts), buffer.len()..buffer.len() + chunks.len())?;
    let json = document.to_bytes();
    let bytes = container::write(&json, &[buffer.as_slice(), chunks])?;
    Ok(WrittenGlb { bytes, chunk_start: container::bin_start(json.len()) + buffer.len() })
}

/// Adds a stream at the end of a document's only buffer, and the references of the refined parts.
fn add_stream(
    root: &mut Members,
    (primitives, parts): (&[PrimitiveRef], &[Option<StreamedPart>]),
    chunks: Range<usize>,
) -> Result<(), Error> {
    let view = json!({ "buffer": 0, "byteOffset": chunks.start, "byteLength": chunks.len() });
    let views = list_mut(root, "bufferViews")?;
    views.push(view.into());
    let view = views.len() - 1;
    let names = list_mut(root, "extensionsUsed")?;
    if !names.iter().any(|name| name.as_str() == Some(EXTENSION)) {
        names.push(EXTENSION.into());
    }
    add_extension(root, json!({ "version": VERSION, "bufferView": view }).into())?;
    for (source, part) in primitives.iter().zip(parts) {
        let Some(StreamedPart { stream, part }) = *part else { continue };
        let value = match part {
            Some(part) => json!({ "stream": stream, "part": part }),
            None => json!({ "stream": stream }),
        };
        let mut result = Ok(());
        change_primitive(root, source.mesh, source.primitive, |primitive| {
            if let Some(members) = primitive.as_object_mut() {
                result = add_extension(members, value.into());
            }
        })?;
        result?;
    }
    set_buffer(root, chunks.end)
}

/// Reads the base meshes of a progressive GLB, as drawn by viewers without the extension. A GLB
/// without a stream is read as by [`read`](crate::gltf::read()). The model shares the bytes.
///
/// # Errors
/// The document is invalid.
///
/// ```
/// use std::sync::Arc;
/// use tristrip_io::{Drawing, Format, gltf, read, write};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// let glb = write(&model, &[Drawing::Faces], Format::Glb, tristrip::Layout::List)?;
/// assert_eq!(gltf::read_base(&Arc::new(glb))?.parts[0].mesh, model.parts[0].mesh);
/// # Ok::<(), tristrip_io::Error>(())
/// ```
pub fn read_base(bytes: &Arc<Vec<u8>>) -> Result<Model, Error> {
    read_refined(Arc::clone(bytes), &[], &StreamMeshes::new())
}

fn add_extension(members: &mut Members, value: Value) -> Result<(), Error> {
    if !members.contains_key("extensions") {
        members.insert("extensions", Value::from(json!({})));
    }
    match members.get_mut("extensions").and_then(Value::as_object_mut) {
        Some(extensions) => extensions.insert(EXTENSION, value),
        None => return Err(Error::format("extensions", "another value", "an object")),
    }
    Ok(())
}

/// Returns the stream of a document, with its offset in the binary chunk and its length.
fn stream_in_bin(root: &Members) -> Result<Option<(StreamInDocument, usize, usize)>, Error> {
    let Some(stream) = StreamInDocument::find(root)? else { return Ok(None) };
    let view = Located::entry(root, "bufferViews", stream.view)?;
    let (offset, length) = (view.size_or("byteOffset", 0)?, view.need("byteLength")?.size()?);
    if view.size_or("buffer", 0)? != 0 {
        return Err(view.wrong("a view of the GLB's binary chunk"));
    }
    match Located::entry(root, "buffers", 0)?.field("uri") {
        Some(uri) => Err(uri.wrong("the GLB's binary chunk")),
        None => Ok(Some((stream, offset, length))),
    }
}

/// The byte range of the chunks in the file of a progressive GLB, as stated in its JSON.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChunkRange {
    bytes: Range<u64>,
    streams: BTreeSet<u32>,
}

impl ChunkRange {
    /// Finds the chunks of a GLB from its first bytes: the header and the JSON. Returns `None` if
    /// it has no stream.
    ///
    /// # Errors
    /// The JSON is truncated or invalid.
    ///
    /// ```
    /// use tristrip_io::gltf::ChunkRange;
    /// let json = br#"{"asset":{"version":"2.0"}}  "#;
    /// let mut start = b"glTF\x02\0\0\0\x30\0\0\0\x1c\0\0\0JSON".to_vec();
    /// start.extend(&json[..28]);
    /// assert_eq!(ChunkRange::find(start)?, None);
    /// # Ok::<(), tristrip_io::Error>(())
    /// ```
    pub fn find(start: impl Into<Vec<u8>>) -> Result<Option<Self>, Error> {
        let file = Arc::new(start.into());
        let Some(container) = container::open_start(Arc::clone(&file)) else {
            let found = format!("the end of the file after {}", counted(file.len(), "byte"));
            return Err(Error::format("GLB", found, "a header and JSON"));
        };
        let document = Document::parse(container.json_bytes())?;
        let Some((stream, offset, length)) = stream_in_bin(&document.root)? else { return Ok(None) };
        // The header of the binary chunk follows the JSON.
        let first = (container.json.end as u64 + CHUNK_HEADER_BYTES as u64).saturating_add(offset as u64);
        Ok(Some(Self { bytes: first..first.saturating_add(length as u64), streams: stream.numbers() }))
    }

    /// Returns the byte range of the chunks in the complete file.
    pub fn bytes(&self) -> Range<u64> {
        self.bytes.clone()
    }

    /// Returns the stream indices of the meshes that primitives use.
    pub fn streams(&self) -> &BTreeSet<u32> {
        &self.streams
    }

    /// Returns limits for a decoder when `present_bytes` bytes of the chunks are available.
    pub fn limits(&self, present_bytes: u64) -> StreamLimits {
        let length = self.bytes.end - self.bytes.start;
        limits(usize::try_from(length.min(present_bytes)).unwrap_or(usize::MAX))
    }
}

/// A progressive GLB, complete or truncated. Its stream is not decoded.
///
/// ```
/// use tristrip_io::gltf::ProgressiveGlb;
/// use tristrip_io::{Drawing, Format, read, write};
/// // A GLB without a stream.
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// let glb = write(&model, &[Drawing::Faces], Format::Glb, tristrip::Layout::List)?;
/// assert!(ProgressiveGlb::open(glb)?.is_none());
/// # Ok::<(), tristrip_io::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ProgressiveGlb {
    /// The file, or a valid GLB of the available bytes.
    glb: Arc<Vec<u8>>,
    /// The chunks in `glb`.
    chunks: Range<usize>,
    /// The offset of the chunks in the file.
    start: usize,
    /// The size of the chunks in the complete file.
    length: usize,
    primitive_count: usize,
    streams: BTreeSet<u32>,
}

impl ProgressiveGlb {
    /// Opens a file without copying its bytes. Returns `None` if it is not a GLB with a stream.
    ///
    /// # Errors
    /// The JSON is truncated or invalid, or the file ends before the chunks.
    pub fn open(bytes: impl Into<Arc<Vec<u8>>>) -> Result<Option<Self>, Error> {
        let file = bytes.into();
        let Some(GlbContainer { json, bin, .. }) = container::open_start(Arc::clone(&file)) else {
            return if container::is_glb(&file) {
                container::open(file, &mut Vec::new()).map(|_| None)
            } else {
                Ok(None)
            };
        };
        let container = GlbContainer { file: Arc::clone(&file), json, bin };
        let mut document = Document::parse(container.json_bytes())?;
        let Some((stream, offset, length)) = stream_in_bin(&document.root)? else { return Ok(None) };
        let view = Located::entry(&document.root, "bufferViews", stream.view)?;
        let Some(bin) = container.bin.clone().filter(|bin| bin.len() >= offset) else {
            let found = format!("the end of the file after {}", counted(file.len(), "byte"));
            return Err(Error::format(
                view.at,
                found,
                format!("{} of base meshes before the stream", counted(offset, "byte")),
            ));
        };
        let start = bin.start + offset;
        let present = (bin.end - start).min(length);
        let whole = Self {
            glb: Arc::clone(&file),
            chunks: start..start + present,
            start,
            length,
            primitive_count: stream.primitives.len(),
            streams: stream.numbers(),
        };
        if container::open(Arc::clone(&file), &mut Vec::new()).is_ok() && present == length {
            return Ok(Some(whole));
        }
        // Build a valid GLB from the available bytes.
        for (list, number, bytes) in [("bufferViews", stream.view, present), ("buffers", 0, offset + present)]
        {
            let entry = entries_mut(&mut document.root, list)?.get_mut(number).and_then(Value::as_object_mut);
            entry.into_iter().for_each(|members| members.insert("byteLength", bytes));
        }
        let json = document.to_bytes();
        let glb = container::write(&json, &[&file[bin.start..start + present]])?;
        let chunks = glb.len() - (offset + present).next_multiple_of(4) + offset;
        Ok(Some(Self { glb: Arc::new(glb), chunks: chunks..chunks + present, ..whole }))
    }

    /// Returns the available bytes of the chunks.
    ///
    /// See [`write_progressive`] for an example.
    pub fn chunks(&self) -> &[u8] {
        &self.glb[self.chunks.clone()]
    }

    /// Returns the number of bytes before the first chunk.
    pub fn chunk_start(&self) -> usize {
        self.start
    }

    /// Checks whether all chunks are available.
    pub fn is_complete(&self) -> bool {
        self.chunks.len() == self.length
    }

    /// Returns the size of all chunks in the complete file, in bytes.
    pub fn chunk_bytes(&self) -> usize {
        self.length
    }

    /// Returns the number of refined primitives.
    pub fn primitive_count(&self) -> usize {
        self.primitive_count
    }

    /// Returns the stream indices of the meshes that primitives use.
    pub fn streams(&self) -> &BTreeSet<u32> {
        &self.streams
    }

    /// Returns limits for a decoder of the chunks.
    pub fn limits(&self) -> StreamLimits {
        limits(self.chunks.len())
    }

    /// Returns the scene with the given meshes in place of the base meshes; keys are stream
    /// indices. A base mesh is kept if its mesh is missing or has no triangles. Images of the
    /// document are read from `base_dir`.
    ///
    /// # Errors
    /// The document is invalid, or a mesh does not have the attributes of a primitive that uses it.
    pub fn model(&self, meshes: &StreamMeshes, base_dir: Option<&Path>) -> Result<Model, Error> {
        let folders: Vec<&Path> = base_dir.into_iter().collect();
        read_refined(Arc::clone(&self.glb), &folders, meshes)
    }
}
