//! Decodes a progressive GLB while it downloads. The bytes may arrive in pieces of any size.
//!
//! ```text
//! header, JSON ─▶ range of the chunks
//! base meshes, textures ─▶ kept │ chunks ─▶ decoder ─▶ meshes │ up to three zeros
//! ```
//! The bytes before the first chunk are kept; the current scene is built from them and the meshes
//! in the decoder. A GLB without a stream is kept completely.
//!
//! # Complexity
//! Linear in the bytes of the file. Memory is proportional to the received bytes and the triangles
//! that they may encode.

use std::path::Path;

use tristrip::stream::{Decoder, StreamLimits, StreamPart};
use tristrip::text::counted;

use crate::error::Error;
use crate::gltf::document::container::json_end;
use crate::gltf::read::read;
use crate::gltf::stream::progressive::{ChunkRange, ProgressiveGlb};
use crate::gltf::stream::refine::{StreamMeshes, stream_error};
use crate::model::Model;

/// Limits of an [`ArrivingGlb`]; files that exceed them are rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct ArrivalLimits {
    /// Maximum number of bytes before the first chunk, or in a file without a stream; 1 GiB by
    /// default. These bytes are kept in memory.
    pub kept_bytes: u64,
    /// The limits of the decoder. The number of received bytes also limits the number of triangles.
    pub stream: StreamLimits,
}

impl Default for ArrivalLimits {
    fn default() -> Self {
        Self { kept_bytes: 1 << 30, stream: StreamLimits::default() }
    }
}

impl ArrivalLimits {
    /// Sets the maximum number of kept bytes.
    #[must_use]
    pub fn with_kept_bytes(self, kept_bytes: u64) -> Self {
        Self { kept_bytes, ..self }
    }

    /// Sets the limits of the decoder.
    #[must_use]
    pub fn with_stream(self, stream: StreamLimits) -> Self {
        Self { stream, ..self }
    }
}

/// Decodes a GLB, progressive or not, while it downloads.
///
/// ```
/// use tristrip_io::gltf::{ArrivalLimits, ArrivingGlb};
/// use tristrip_io::{Drawing, Format, read, write};
/// // A GLB without a stream.
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?;
/// let glb = write(&model, &[Drawing::Faces], Format::Glb, tristrip::Layout::List)?;
/// let mut arriving = ArrivingGlb::new(ArrivalLimits::default());
/// for byte in &glb {
///     assert!(!arriving.is_complete());
///     arriving.update(std::slice::from_ref(byte))?;
/// }
/// assert!(arriving.finish().is_ok());
/// assert!(arriving.model(None)?.is_some_and(|model| model.parts.len() == 1));
/// # Ok::<(), tristrip_io::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ArrivingGlb {
    limits: ArrivalLimits,
    keeps_strips: bool,
    /// The received bytes before the first chunk.
    start: Vec<u8>,
    stage: ArrivalStage,
    /// The number of received bytes.
    offset: u64,
    fault: Option<ArrivalFault>,
}

/// The expected next section of the file.
#[derive(Debug, Clone)]
enum ArrivalStage {
    /// The header and the JSON. `end` is known from byte 20 on.
    Json {
        end: Option<u64>,
    },
    /// The bytes before the chunks.
    Base(ChunkRange),
    Chunks {
        range: ChunkRange,
        decoder: Box<Decoder>,
    },
    /// The rest of a GLB without a stream, up to its last byte.
    Plain {
        end: u64,
    },
}

/// A stored error, returned by all later calls.
#[derive(Debug, Clone)]
enum ArrivalFault {
    Format { at: String, found: String, expected: String },
    Limit { at: String, found: u64, limit: u64 },
}

impl ArrivalFault {
    fn of(error: Error) -> Self {
        match error {
            Error::Format { at, found, expected } => Self::Format { at, found, expected },
            Error::LimitExceeded { at, found, limit } => Self::Limit { at, found, limit },
            other => Self::Format {
                at: "the JSON of the GLB".into(),
                found: other.to_string(),
                expected: "a valid document".into(),
            },
        }
    }

    fn error(&self) -> Error {
        match self.clone() {
            Self::Format { at, found, expected } => Error::Format { at, found, expected },
            Self::Limit { at, found, limit } => Error::LimitExceeded { at, found, limit },
        }
    }
}

impl ArrivingGlb {
    /// Creates a decoder for a new file.
    pub fn new(limits: ArrivalLimits) -> Self {
        Self {
            limits,
            keeps_strips: false,
            start: Vec::new(),
            stage: ArrivalStage::Json { end: None },
            offset: 0,
            fault: None,
        }
    }

    /// Maintains triangle strips during refinement ([`StreamPart::strips`]); decoding is about five
    /// times slower.
    #[must_use]
    pub fn keeping_strips(mut self) -> Self {
        self.keeps_strips = true;
        self
    }

    /// Appends the next bytes of the file and decodes the chunks that they complete. Returns the
    /// number of these chunks. Bytes after the chunks are ignored.
    ///
    /// # Errors
    /// The bytes are not a GLB, its document or a chunk is invalid, or the file exceeds a limit.
    /// Chunks before the error remain decoded. All later calls return the same error.
    pub fn update(&mut self, bytes: &[u8]) -> Result<usize, Error> {
        if let Some(fault) = &self.fault {
            return Err(fault.error());
        }
        self.advance(bytes).map_err(|error| {
            let fault = ArrivalFault::of(error);
            let error = fault.error();
            self.fault = Some(fault);
            error
        })
    }

    fn advance(&mut self, mut bytes: &[u8]) -> Result<usize, Error> {
        let mut decoded = 0;
        loop {
            match &mut self.stage {
                ArrivalStage::Json { end } => {
                    // The header of the JSON chunk, which ends at byte 20, contains its length.
                    let wanted = end.unwrap_or(20);
                    let arrived = self.keep(wanted, &mut bytes)?;
                    match json_end(&self.start)? {
                        Some(known) if arrived && self.start.len() as u64 >= known => {
                            self.stage = self.after_json()?;
                        }
                        Some(known) if arrived => self.stage = ArrivalStage::Json { end: Some(known) },
                        _ => return Ok(decoded),
                    }
                }
                ArrivalStage::Base(range) => {
                    let wanted = range.bytes().start;
                    if !self.keep(wanted, &mut bytes)? {
                        return Ok(decoded);
                    }
                    let ArrivalStage::Base(range) =
                        std::mem::replace(&mut self.stage, ArrivalStage::Json { end: None })
                    else {
                        return Ok(decoded);
                    };
                    let decoder = Decoder::new(self.limits.stream);
                    let decoder = if self.keeps_strips { decoder.keeping_strips() } else { decoder };
                    self.stage = ArrivalStage::Chunks { range, decoder: Box::new(decoder) };
                }
                ArrivalStage::Chunks { range, decoder } => {
                    let left = range.bytes().end.saturating_sub(self.offset);
                    let taken = usize::try_from(left).map_or(bytes.len(), |left| left.min(bytes.len()));
                    let arrived = self.offset + taken as u64 - range.bytes().start.min(self.offset);
                    let triangles = range.limits(arrived).triangles.min(self.limits.stream.triangles);
                    decoder.set_limits(StreamLimits { triangles, ..self.limits.stream });
                    if taken > 0 {
                        decoded += decoder.update(&bytes[..taken]).map_err(|fault| stream_error(&fault))?;
                    }
                    self.offset += bytes.len() as u64;
                    let length = range.bytes().end - range.bytes().start;
                    if self.offset >= range.bytes().end && decoder.offset() < length {
                        let at = format!("chunk {} of the stream", decoder.chunk_count());
                        return Err(Error::format(at, "the end of the stream", "a complete chunk"));
                    }
                    return Ok(decoded);
                }
                ArrivalStage::Plain { end } => {
                    let wanted = *end;
                    self.keep(wanted, &mut bytes)?;
                    self.offset += bytes.len() as u64;
                    return Ok(decoded);
                }
            }
        }
    }

    /// Keeps the bytes of the file up to `end`. Returns whether they are complete.
    fn keep(&mut self, end: u64, bytes: &mut &[u8]) -> Result<bool, Error> {
        if end > self.limits.kept_bytes {
            let at = "bytes before the first chunk".into();
            return Err(Error::LimitExceeded { at, found: end, limit: self.limits.kept_bytes });
        }
        let missing = (end as usize).saturating_sub(self.start.len()).min(bytes.len());
        let (kept, rest) = bytes.split_at(missing);
        self.start.extend_from_slice(kept);
        self.offset += missing as u64;
        *bytes = rest;
        Ok(self.start.len() as u64 >= end)
    }

    /// Returns the stage after the JSON.
    fn after_json(&self) -> Result<ArrivalStage, Error> {
        if let Some(range) = ChunkRange::find(&self.start[..])? {
            return Ok(ArrivalStage::Base(range));
        }
        let length = self.start.get(8..12).and_then(|bytes| bytes.try_into().ok());
        Ok(ArrivalStage::Plain { end: length.map_or(0, u32::from_le_bytes).into() })
    }

    /// Checks that the file is complete. Call it at the end of the download.
    ///
    /// # Errors
    /// The file is incomplete, or the last update failed.
    pub fn finish(&self) -> Result<(), Error> {
        if let Some(fault) = &self.fault {
            return Err(fault.error());
        }
        if self.is_complete() {
            return Ok(());
        }
        let expected = match &self.stage {
            ArrivalStage::Json { .. } => "the header and the JSON of a GLB".into(),
            ArrivalStage::Base(range) => {
                format!("{} before the stream", counted(range.bytes().start, "byte"))
            }
            ArrivalStage::Chunks { range, decoder } => {
                let length = range.bytes().end - range.bytes().start;
                format!("{} of chunks; complete up to byte {}", counted(length, "byte"), decoder.offset())
            }
            ArrivalStage::Plain { end } => counted(end, "byte"),
        };
        Err(Error::format(
            "file",
            format!("the end of the file after {}", counted(self.offset, "byte")),
            expected,
        ))
    }

    /// Returns whether all data for drawing was received: all chunks, or all bytes of a file
    /// without a stream.
    pub fn is_complete(&self) -> bool {
        match &self.stage {
            ArrivalStage::Json { .. } | ArrivalStage::Base(_) => false,
            ArrivalStage::Chunks { range, decoder } => {
                decoder.offset() == range.bytes().end - range.bytes().start
            }
            ArrivalStage::Plain { end } => self.start.len() as u64 >= *end,
        }
    }

    /// Returns the number of received bytes: the offset of the next byte to pass to
    /// [`update`](Self::update).
    pub fn offset(&self) -> u64 {
        self.offset
    }

    /// Returns the range of the chunks in the file. `None` until the JSON is complete, and for a
    /// file without a stream.
    pub fn chunk_range(&self) -> Option<&ChunkRange> {
        match &self.stage {
            ArrivalStage::Base(range) | ArrivalStage::Chunks { range, .. } => Some(range),
            ArrivalStage::Json { .. } | ArrivalStage::Plain { .. } => None,
        }
    }

    /// Returns whether the base meshes are complete and can be drawn.
    pub fn has_base(&self) -> bool {
        matches!(self.stage, ArrivalStage::Chunks { .. }) || self.is_complete()
    }

    /// Returns the decoder of the chunks, once all bytes before them were received.
    pub fn decoder(&self) -> Option<&Decoder> {
        match &self.stage {
            ArrivalStage::Chunks { decoder, .. } => Some(decoder),
            ArrivalStage::Json { .. } | ArrivalStage::Base(_) | ArrivalStage::Plain { .. } => None,
        }
    }

    /// Returns the meshes whose first chunk was received, with their stream indices.
    pub fn parts(&self) -> impl Iterator<Item = (u32, &StreamPart)> {
        let numbers = 0..self.limits.stream.meshes;
        let decoder = self.decoder();
        numbers.filter_map(move |number| Some((number as u32, decoder?.part(number)?)))
    }

    /// Returns the current scene, with base meshes where no chunk has refined them. Returns `None`
    /// until the base meshes are complete. Images of the document are looked up in `base_dir`.
    ///
    /// # Errors
    /// The document is invalid, or a mesh does not have the attributes of a primitive that uses it.
    pub fn model(&self, base_dir: Option<&Path>) -> Result<Option<Model>, Error> {
        if !self.has_base() {
            return Ok(None);
        }
        if self.decoder().is_none() {
            return read(self.start.clone(), base_dir).map(Some);
        }
        let Some(glb) = ProgressiveGlb::open(self.start.clone())? else { return Ok(None) };
        let meshes = self.parts().map(|(number, part)| Ok((number, part.mesh()?)));
        let meshes: StreamMeshes = meshes.collect::<Result<_, Error>>()?;
        glb.model(&meshes, base_dir).map(Some)
    }
}
