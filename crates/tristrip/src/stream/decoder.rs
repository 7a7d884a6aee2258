//! Decodes a stream as its bytes arrive.

use super::chunk::{ChunkHead, MAX_HEAD_BYTES, checksum};
use super::fault::{ChunkFault, StreamError};
use super::part::StreamPart;
use crate::text::counted;

/// Decoder limits. Streams that exceed them are rejected.
///
/// ```
/// use tristrip::stream::StreamLimits;
/// let small = StreamLimits { triangles: 1000, ..StreamLimits::default() };
/// assert!(small.triangles < StreamLimits::default().triangles);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamLimits {
    /// Maximum number of meshes. Each mesh uses about 60 kB in addition to its triangles, plus 20
    /// kB per attribute.
    pub meshes: usize,
    /// Maximum number of triangles of all meshes together.
    pub triangles: usize,
    /// Maximum size of a chunk in bytes.
    pub chunk_bytes: usize,
    /// Work limit: vertices visited by batches plus corners around split vertices. Decoding time is
    /// proportional to it. Typical models require about 12 per vertex, but a malicious stream can
    /// request any amount in a few bytes.
    pub corners: u64,
}

impl Default for StreamLimits {
    /// Returns limits of 256 meshes, 2²⁶ triangles, 2²⁸ bytes per chunk, and 2³⁰ corners.
    fn default() -> Self {
        Self { meshes: 256, triangles: 1 << 26, chunk_bytes: 1 << 28, corners: 1 << 30 }
    }
}

/// A chunk inside a byte slice, with the fields of its header.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ChunkView<'a> {
    /// The bytes of the chunk, including header and checksum.
    pub bytes: &'a [u8],
    /// The index of the mesh.
    pub stream: u32,
    /// The level after this chunk is decoded.
    pub level: u32,
    /// The number of triangles at that level.
    pub triangles: u32,
    /// The error of that level, in mesh units.
    pub error: f32,
}

/// Splits bytes into chunks. The bytes must begin at the start of a chunk. Stops at the first
/// incomplete chunk or invalid header. The contents are not checked; [`Decoder::update`] checks
/// them.
///
/// ```
#[doc = include_str!("example.txt")]
/// use tristrip::stream::chunks;
/// let bytes = stream.bytes();
/// assert_eq!(chunks(&bytes).last().map(|chunk| chunk.triangles), Some(128));
/// assert_eq!(chunks(&bytes[..bytes.len() - 1]).count(), stream.chunks.len() - 1);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn chunks(mut bytes: &[u8]) -> impl Iterator<Item = ChunkView<'_>> {
    std::iter::from_fn(move || {
        let (head, _, head_bytes) = ChunkHead::read(bytes)?.ok()?;
        let (chunk, rest) = bytes.split_at_checked(head_bytes.checked_add(head.payload_bytes as usize)?)?;
        bytes = rest;
        let ChunkHead { stream, level, triangles, error, .. } = head;
        Some(ChunkView { bytes: chunk, stream, level, triangles, error })
    })
}

/// Decodes the chunks of a stream as their bytes arrive, split at any byte.
///
/// ```
#[doc = include_str!("example.txt")]
/// use tristrip::stream::{Decoder, StreamLimits};
/// let mut decoder = Decoder::new(StreamLimits::default());
/// let bytes = stream.bytes();
/// let (some, rest) = bytes.split_at(bytes.len() / 2);
/// decoder.update(some)?;
/// let triangles = decoder.parts().map(|part| part.triangle_count()).sum::<usize>();
/// assert!(triangles < 128);
/// decoder.update(rest)?;
/// assert_eq!(decoder.parts().map(|part| part.triangle_count()).sum::<usize>(), 128);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Decoder {
    limits: StreamLimits,
    counts_bits: bool,
    keeps_strips: bool,
    /// The bytes received so far of the next chunk.
    incomplete_chunk: Vec<u8>,
    /// The number of bytes of all decoded chunks.
    offset: u64,
    chunk_count: usize,
    parts: Vec<Option<StreamPart>>,
    fault: Option<StreamError>,
}

impl Decoder {
    /// Creates a decoder that has received no bytes.
    ///
    /// ```
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// assert_eq!(Decoder::new(StreamLimits::default()).chunk_count(), 0);
    /// ```
    pub fn new(limits: StreamLimits) -> Self {
        Self {
            limits,
            counts_bits: false,
            keeps_strips: false,
            incomplete_chunk: Vec::new(),
            offset: 0,
            chunk_count: 0,
            parts: Vec::new(),
            fault: None,
        }
    }

    /// Counts the bits of each component while decoding; see [`StreamPart::costs`].
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let decoder = Decoder::new(StreamLimits::default());
    /// let mut decoder = decoder.counting_bits();
    /// decoder.update(&stream.bytes())?;
    /// assert!(decoder.parts().all(|part| part.costs().is_some()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn counting_bits(mut self) -> Self {
        self.counts_bits = true;
        self
    }

    /// Maintains triangle strips of the meshes during refinement; see [`StreamPart::strips`].
    /// Decoding is about five times slower.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default()).keeping_strips();
    /// decoder.update(&stream.bytes())?;
    /// assert!(decoder.parts().all(|part| part.strips().is_some()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn keeping_strips(mut self) -> Self {
        self.keeps_strips = true;
        self
    }

    /// Changes the limits for the chunks that follow. For example, a client can raise the limits in
    /// proportion to the bytes received.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits { triangles: 0, ..StreamLimits::default() });
    /// decoder.set_limits(StreamLimits::default());
    /// assert!(decoder.update(&stream.bytes()).is_ok());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_limits(&mut self, limits: StreamLimits) {
        self.limits = limits;
    }

    /// Appends bytes and decodes all complete chunks. Returns the number of chunks decoded.
    ///
    /// # Errors
    /// A chunk is damaged or exceeds the limits. The chunks decoded before it remain valid. If a
    /// chunk passes its checksum but is invalid, the part of the chunk decoded before the error
    /// remains as well. All later calls return the same error.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// let bytes = stream.bytes();
    /// let decoded: usize = bytes.chunks(100).map(|bytes| decoder.update(bytes)).sum::<Result<_, _>>()?;
    /// assert_eq!(decoded, stream.chunks.len());
    /// // These bytes are not a chunk.
    /// assert!(decoder.update(&[0xFF; 64]).is_err());
    /// assert_eq!(decoder.parts().count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update(&mut self, mut bytes: &[u8]) -> Result<usize, StreamError> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        let mut decoded = 0;
        let mut incomplete = std::mem::take(&mut self.incomplete_chunk);
        loop {
            // Complete chunks are decoded in place, unless their first bytes arrived in an earlier
            // call.
            let taken = if incomplete.is_empty() {
                self.next_chunk(bytes)
            } else {
                let head = bytes.len().min(MAX_HEAD_BYTES);
                let known = incomplete.len();
                incomplete.extend(&bytes[..head]);
                if let Some(Ok((chunk, _, length))) = ChunkHead::read(&incomplete) {
                    incomplete.truncate(known);
                    let rest = (length + chunk.payload_bytes as usize).saturating_sub(known);
                    let is_allowed = chunk.payload_bytes as usize <= self.limits.chunk_bytes;
                    let rest = if is_allowed { rest.min(bytes.len()) } else { head };
                    incomplete.extend(&bytes[..rest]);
                }
                self.next_chunk(&incomplete).map(|taken| taken.map(|taken| taken.saturating_sub(known)))
            };
            match taken {
                Ok(Some(taken)) => {
                    bytes = &bytes[taken..];
                    incomplete.clear();
                    decoded += 1;
                }
                Ok(None) => {
                    if incomplete.is_empty() {
                        incomplete.extend(bytes);
                    }
                    self.incomplete_chunk = incomplete;
                    return Ok(decoded);
                }
                Err(fault) => {
                    self.fault = Some(fault.clone());
                    return Err(fault);
                }
            }
        }
    }

    /// Decodes the chunk at the start of `bytes`. Returns its length, or `None` if it is
    /// incomplete.
    fn next_chunk(&mut self, bytes: &[u8]) -> Result<Option<usize>, StreamError> {
        self.decode_chunk(bytes).map_err(|ChunkFault { found, expected, exceeded }| {
            let at = format!("chunk {} at byte {}", self.chunk_count, self.offset);
            StreamError { at, found, expected, exceeded }
        })
    }

    fn decode_chunk(&mut self, bytes: &[u8]) -> Result<Option<usize>, ChunkFault> {
        let (head, expected, head_bytes) = match ChunkHead::read(bytes) {
            None => return Ok(None),
            Some(Err(_)) => {
                return Err(ChunkFault::new("a number of more than 32 bits", "the head of a chunk"));
            }
            Some(Ok(read)) => read,
        };
        let length = head.payload_bytes as usize;
        if length > self.limits.chunk_bytes {
            let limit = self.limits.chunk_bytes;
            let words = (counted(length, "byte"), format!("at most {limit}"));
            return Err(ChunkFault::limit(words, "bytes of a chunk", (length as u64, limit as u64)));
        }
        if head.stream as usize >= self.limits.meshes {
            let limit = self.limits.meshes;
            let words = (format!("mesh {}", head.stream), format!("a number below {limit}"));
            return Err(ChunkFault::limit(words, "meshes", (u64::from(head.stream) + 1, limit as u64)));
        }
        let Some(payload) = bytes.get(head_bytes..head_bytes + length) else { return Ok(None) };
        let found = checksum(&bytes[..head_bytes - 4], payload);
        if found != expected {
            let expected = format!("{expected:08x}: the chunk is damaged");
            return Err(ChunkFault::new(format!("checksum {found:08x}"), expected));
        }
        let others: usize = self.parts().map(StreamPart::triangle_count).sum();
        let index = head.stream as usize;
        if self.parts.len() <= index {
            self.parts.resize_with(index + 1, || None);
        }
        let corners =
            |parts: &[Option<StreamPart>]| parts.iter().flatten().map(StreamPart::corner_count).sum::<u64>();
        let own_corners = self.parts[index].as_ref().map_or(0, StreamPart::corner_count);
        let most_corners = self.limits.corners.saturating_sub(corners(&self.parts) - own_corners);
        let own = self.parts[index].as_ref().map_or(0, StreamPart::triangle_count);
        let most = self.limits.triangles.saturating_sub(others - own);
        if head.triangles as usize > most {
            let words = (counted(head.triangles, "triangle"), format!("at most {most}"));
            return Err(ChunkFault::limit(words, "triangles", (head.triangles.into(), most as u64)));
        }
        let result = match &mut self.parts[index] {
            Some(part) => part.refine(&head, payload, (most, most_corners)),
            empty => StreamPart::new(&head, payload, self.counts_bits).map(|part| *empty = Some(part)),
        };
        if let Some(part) = self.parts[index].as_mut().filter(|_| self.keeps_strips) {
            part.keep_strips();
        }
        result?;
        self.chunk_count += 1;
        self.offset += (head_bytes + length) as u64;
        Ok(Some(head_bytes + length))
    }

    /// Returns the meshes whose base mesh has been decoded, in the order of their indices.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// assert_eq!(decoder.parts().count(), 0);
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// assert_eq!(decoder.parts().count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parts(&self) -> impl Iterator<Item = &StreamPart> {
        self.parts.iter().flatten()
    }

    /// Returns a mesh by its index, or `None` if its base mesh has not been decoded yet.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.bytes())?;
    /// assert!(decoder.part(0).is_some() && decoder.part(1).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn part(&self, stream: usize) -> Option<&StreamPart> {
        self.parts.get(stream)?.as_ref()
    }

    /// Returns the number of chunks decoded.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.chunks[0].bytes)?;
    /// assert_eq!(decoder.chunk_count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn chunk_count(&self) -> usize {
        self.chunk_count
    }

    /// Returns the number of bytes of the decoded chunks, which is the offset to resume from.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// // Without its last byte, the last chunk is incomplete.
    /// let bytes = stream.bytes();
    /// decoder.update(&bytes[..bytes.len() - 1])?;
    /// let other = decoder.clone();
    /// decoder.update(&bytes[bytes.len() - 1..])?;
    /// assert!(other.offset() < decoder.offset() && decoder.offset() == bytes.len() as u64);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn offset(&self) -> u64 {
        self.offset
    }
}
