//! Decodes a stream as its bytes arrive.

use super::base::{BaseFault, code_triangles};
use super::chunk::{ChunkHead, MOST_HEAD_BYTES, Reader, checksum};
use super::head::{Head, code_weights};
use super::places::USUAL_WEIGHTS;
use super::range_coder::{BitCoder, RangeDecoder};
use super::refiner::{Refiner, StreamCosts};
use super::surface::Surface;
use crate::collapse::{CollapseSequence, Rename};
use crate::error::Error;
use crate::mesh::{Faces, Mesh};

/// A fault of a stream.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{at}: found {found}, expected {expected}")]
#[non_exhaustive]
pub struct StreamError {
    /// The chunk and the byte at which it starts.
    pub at: String,
    /// What is there.
    pub found: String,
    /// What should be there.
    pub expected: String,
}

/// What a stream may ask for at most; streams of more are refused.
///
/// ```
/// use tristrip::stream::StreamLimits;
/// let small = StreamLimits { triangles: 1000, ..StreamLimits::default() };
/// assert!(small.triangles < StreamLimits::default().triangles);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamLimits {
    /// Meshes.
    pub meshes: usize,
    /// Triangles of all meshes.
    pub triangles: usize,
    /// Bytes of a chunk.
    pub chunk_bytes: usize,
}

impl Default for StreamLimits {
    /// 4,096 meshes, 2²⁶ triangles, and 256 megabytes per chunk.
    fn default() -> Self {
        Self { meshes: 4096, triangles: 1 << 26, chunk_bytes: 1 << 28 }
    }
}

/// A mesh that a stream has built so far.
#[derive(Debug, Clone)]
pub struct StreamPart {
    head: Head,
    refiner: Refiner,
    error: f32,
    /// The error before and the levels after each chunk.
    errors: Vec<(f32, u32)>,
}

/// Decodes the chunks of a stream as their bytes arrive, in pieces of any size.
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
    /// What has arrived of the next chunk.
    waiting: Vec<u8>,
    /// The bytes of all chunks before.
    offset: u64,
    chunk_count: usize,
    parts: Vec<Option<StreamPart>>,
    fault: Option<StreamError>,
}

impl Decoder {
    /// Creates a decoder that has read nothing.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(tristrip::stream::Decoder::new(tristrip::stream::StreamLimits::default()).chunk_count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(limits: StreamLimits) -> Self {
        Self {
            limits,
            counts_bits: false,
            waiting: Vec::new(),
            offset: 0,
            chunk_count: 0,
            parts: Vec::new(),
            fault: None,
        }
    }

    /// Counts the bits of each component while decoding; see [`StreamPart::costs`].
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// let mut decoder = tristrip::stream::Decoder::new(tristrip::stream::StreamLimits::default()).counting_bits();
    /// decoder.update(&stream.bytes())?;
    /// assert!(decoder.part(0).and_then(|part| part.costs()).is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn counting_bits(mut self) -> Self {
        self.counts_bits = true;
        self
    }

    /// Takes the next bytes, and decodes the chunks that are complete. Returns how many that were.
    ///
    /// # Errors
    /// A chunk is damaged, or asks for more than the limits. What chunks before it have built stays; all further bytes are refused with the same error.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert!(decoder.update(&[0xFF; 40]).is_err());
    /// assert_eq!(decoder.part(0).map(|part| part.triangle_count()), Some(128));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn update(&mut self, mut bytes: &[u8]) -> Result<usize, StreamError> {
        if let Some(fault) = &self.fault {
            return Err(fault.clone());
        }
        let mut decoded = 0;
        let mut waiting = std::mem::take(&mut self.waiting);
        loop {
            // Complete chunks are decoded where they lie, unless their first bytes have waited.
            let taken = if waiting.is_empty() {
                self.next_chunk(bytes)
            } else {
                let head = bytes.len().min(MOST_HEAD_BYTES);
                let known = waiting.len();
                waiting.extend(&bytes[..head]);
                if let Some(Ok((chunk, _, length))) = ChunkHead::read(&waiting) {
                    let rest = (length + chunk.payload_bytes as usize).saturating_sub(known);
                    if chunk.payload_bytes as usize <= self.limits.chunk_bytes {
                        waiting.truncate(known);
                        waiting.extend(&bytes[..rest.min(bytes.len())]);
                    }
                }
                self.next_chunk(&waiting).map(|taken| taken.map(|taken| taken.saturating_sub(known)))
            };
            match taken {
                Ok(Some(taken)) => {
                    bytes = &bytes[taken..];
                    waiting.clear();
                    decoded += 1;
                }
                Ok(None) => {
                    if waiting.is_empty() {
                        waiting.extend(bytes);
                    }
                    self.waiting = waiting;
                    return Ok(decoded);
                }
                Err(fault) => {
                    self.fault = Some(fault.clone());
                    return Err(fault);
                }
            }
        }
    }

    /// Decodes the chunk at the start of bytes; returns its length, or `None` if it is not complete.
    fn next_chunk(&mut self, bytes: &[u8]) -> Result<Option<usize>, StreamError> {
        let at = format!("chunk {} at byte {}", self.chunk_count, self.offset);
        let fault =
            |found: String, expected: &str| StreamError { at: at.clone(), found, expected: expected.into() };
        let (head, expected, head_bytes) = match ChunkHead::read(bytes) {
            None => return Ok(None),
            Some(Err(_)) => return Err(fault("a number of more than 32 bits".into(), "the head of a chunk")),
            Some(Ok(read)) => read,
        };
        let length = head.payload_bytes as usize;
        if length > self.limits.chunk_bytes {
            return Err(fault(format!("{length} bytes"), &format!("at most {}", self.limits.chunk_bytes)));
        }
        if head.stream as usize >= self.limits.meshes {
            return Err(fault(
                format!("mesh {}", head.stream),
                &format!("at most {} meshes", self.limits.meshes),
            ));
        }
        let Some(payload) = bytes.get(head_bytes..head_bytes + length) else { return Ok(None) };
        let found = checksum(&bytes[..head_bytes - 4], payload);
        if found != expected {
            return Err(fault(
                format!("checksum {found:08x}"),
                &format!("{expected:08x}: the chunk is damaged"),
            ));
        }
        let others: usize = self.parts().map(StreamPart::triangle_count).sum();
        let index = head.stream as usize;
        if self.parts.len() <= index {
            self.parts.resize_with(index + 1, || None);
        }
        let own = self.parts[index].as_ref().map_or(0, StreamPart::triangle_count);
        let most = self.limits.triangles.saturating_sub(others - own);
        if head.triangles as usize > most {
            return Err(fault(format!("{} triangles", head.triangles), &format!("at most {most}")));
        }
        let result = match &mut self.parts[index] {
            Some(part) => part.refine(&head, payload),
            empty => StreamPart::new(&head, payload, self.counts_bits).map(|part| *empty = Some(part)),
        };
        result.map_err(|(found, expected)| fault(found, &expected))?;
        self.chunk_count += 1;
        self.offset += (head_bytes + length) as u64;
        Ok(Some(head_bytes + length))
    }

    /// Returns the meshes whose base has arrived, in the order of their numbers.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(decoder.parts().count(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn parts(&self) -> impl Iterator<Item = &StreamPart> {
        self.parts.iter().flatten()
    }

    /// Returns a mesh, if its base has arrived.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert!(decoder.part(1).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn part(&self, stream: usize) -> Option<&StreamPart> {
        self.parts.get(stream)?.as_ref()
    }

    /// The number of chunks decoded.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(decoder.chunk_count(), stream.chunks.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn chunk_count(&self) -> usize {
        self.chunk_count
    }

    /// The number of bytes of the chunks decoded: where to resume.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(decoder.offset(), stream.bytes().len() as u64);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn offset(&self) -> u64 {
        self.offset
    }
}

type Fault = (String, String);

impl StreamPart {
    /// Decodes the base mesh.
    fn new(chunk: &ChunkHead, payload: &[u8], counts_bits: bool) -> Result<Self, Fault> {
        let mut reader = Reader { bytes: payload };
        let head = Head::read(&mut reader).map_err(|fault| (fault.found, fault.expected.into()))?;
        if head.base_triangles != chunk.triangles || chunk.visits != 0 || chunk.level != 0 {
            let found = format!("a base mesh of {} triangles at level {}", head.base_triangles, chunk.level);
            return Err((found, format!("{} at level 0", chunk.triangles)));
        }
        let mut coder = RangeDecoder::new(reader.bytes);
        let weights = code_weights(&mut coder, &USUAL_WEIGHTS);
        let mut refiner = Refiner::new(&weights, head.channel_models());
        (refiner.position_bits, refiner.unknown_bits) = (head.position_bits, head.unknown_bits);
        let faults = |fault: BaseFault| match fault {
            BaseFault::NoSuchEdge => {
                ("an edge of two triangles twice".into(), "edges of at most two triangles".into())
            }
            BaseFault::TooShort => {
                ("the end of the chunk".into(), format!("{} triangles", head.base_triangles))
            }
        };
        let (opposite, _) = code_triangles(&mut coder, head.base_triangles as usize, &[]).map_err(faults)?;
        refiner.surface = Surface::new(&opposite);
        refiner.code_base(&mut coder, None);
        if coder.is_past_end() {
            return Err(("the end of the chunk".into(), "all vertices of the base mesh".into()));
        }
        let base = 8.0 * payload.len() as f64;
        refiner.costs = counts_bits.then(|| (StreamCosts { base, ..StreamCosts::default() }, 0.0));
        Ok(Self { head, refiner, error: chunk.error, errors: Vec::new() })
    }

    /// Decodes a refinement.
    fn refine(&mut self, chunk: &ChunkHead, payload: &[u8]) -> Result<(), Fault> {
        let mut coder = RangeDecoder::new(payload);
        let refiner = &mut self.refiner;
        refiner.account(&coder, |_| None);
        for _ in 0..chunk.visits {
            if refiner.next == refiner.end {
                refiner.begin_batch(&mut coder, 0, 0, |_| [0; 3]);
            }
            if refiner.end == 0 {
                return Err(("a refinement of nothing".into(), "a base mesh with triangles".into()));
            }
            refiner.visit(&mut coder, &[]);
            if coder.is_past_end() || refiner.surface.triangle_count() > chunk.triangles as usize {
                break;
            }
        }
        let found = (refiner.group_count, refiner.surface.triangle_count() as u32);
        if coder.is_past_end() || found != (chunk.level, chunk.triangles) {
            let words = |(level, triangles): (u32, u32)| format!("level {level} of {triangles} triangles");
            return Err((words(found), words((chunk.level, chunk.triangles))));
        }
        self.errors.push((self.error, refiner.group_count));
        self.error = chunk.error;
        Ok(())
    }

    /// The level so far: the collapses that are undone.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.level(), part.full_level());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn level(&self) -> usize {
        self.refiner.group_count as usize
    }

    /// The level of the full mesh, as the stream says.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.full_level(), batches.sequence.len());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn full_level(&self) -> usize {
        self.head.levels as usize
    }

    /// The triangles so far.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.triangle_count(), 128);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn triangle_count(&self) -> usize {
        self.refiner.surface.triangle_count()
    }

    /// The triangles of the full mesh, as the stream says.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.full_triangle_count(), 128);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn full_triangle_count(&self) -> usize {
        self.head.triangles as usize
    }

    /// The error of the level, in mesh units.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// // Half a step of the grid, along all three axes.
    /// assert!(part.error() >= stream.position_error && part.error() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn error(&self) -> f32 {
        self.error
    }

    /// The bits of each component so far, if they are [counted](Decoder::counting_bits).
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert!(part.costs().is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn costs(&self) -> Option<StreamCosts> {
        self.refiner.costs.map(|(costs, _)| costs)
    }

    /// The bits of a coordinate that are known so far, and those of the full mesh.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.position_bits(), [14, 14]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn position_bits(&self) -> [u32; 2] {
        [self.head.position_bits - self.refiner.unknown_bits, self.head.position_bits]
    }

    /// The names of the attributes.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.attribute_names().count(), 0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn attribute_names(&self) -> impl Iterator<Item = &str> {
        self.head.channels.iter().map(|channel| channel.name.as_str())
    }

    /// The vertices of the full mesh, as the stream says.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.full_vertex_count(), 81);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn full_vertex_count(&self) -> usize {
        self.head.vertices as usize
    }

    /// The vertices so far.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.vertex_count(), 81);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn vertex_count(&self) -> usize {
        self.refiner.vertex_count as usize
    }

    /// Returns the vertices of the triangles so far.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.triangles().len(), 3 * 128);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn triangles(&self) -> Vec<u32> {
        let surface = &self.refiner.surface;
        surface.corners().map(|corner| self.refiner.vertices[surface.fan(corner) as usize]).collect()
    }

    /// Returns the positions of the vertices so far.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.positions().len(), 81);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn positions(&self) -> Vec<[f32; 3]> {
        let mut positions = vec![[0.0; 3]; self.vertex_count()];
        for (&vertex, fan) in self.refiner.vertices.iter().zip(&self.refiner.fans) {
            positions[vertex as usize] = self.head.grid.position(fan.place, self.refiner.unknown_bits);
        }
        positions
    }

    /// Returns a checksum of the mesh so far: the CRC-32 of the vertices of the triangles, then the grid positions of the vertices, then the integers of each attribute,
    /// all as 32-bit numbers with the lowest byte first. Decoders that agree return the same after each chunk.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// let mut other = tristrip::stream::Decoder::new(tristrip::stream::StreamLimits::default());
    /// stream.bytes().chunks(10).try_for_each(|bytes| other.update(bytes).map(|_| ()))?;
    /// assert_eq!(other.part(0).map(|part| part.fingerprint()), Some(part.fingerprint()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn fingerprint(&self) -> u32 {
        let mut hasher = crc32fast::Hasher::new();
        let mut add = |number: u32| hasher.update(&number.to_le_bytes());
        self.triangles().into_iter().for_each(&mut add);
        let mut places = vec![[0; 3]; self.vertex_count()];
        for (&vertex, fan) in self.refiner.vertices.iter().zip(&self.refiner.fans) {
            places[vertex as usize] = fan.place;
        }
        places.into_iter().flatten().for_each(|x: i32| add(x as u32));
        self.refiner.values.iter().flatten().for_each(|&x| add(x as u32));
        hasher.finalize()
    }

    /// Returns the mesh so far.
    ///
    /// # Errors
    /// None is known.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.mesh()?.faces().face_count(), 128);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn mesh(&self) -> Result<Mesh, Error> {
        let mesh = Mesh::new(self.positions(), Faces::from_triangles(self.triangles())?)?;
        let channels = self.head.channels.iter().zip(&self.refiner.values);
        channels
            .into_iter()
            .try_fold(mesh, |mesh, (channel, values)| mesh.with_attribute(channel.attribute(values)))
    }

    /// Returns the collapses that lead from the mesh so far to the base mesh, over its vertices.
    ///
    /// # Errors
    /// None is known.
    ///
    /// ```
    #[doc = include_str!("decoded_example.txt")]
    /// assert_eq!(part.sequence()?.triangle_count(0)?, stream.base.len() / 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sequence(&self) -> Result<CollapseSequence, Error> {
        let refiner = &self.refiner;
        let vertex = |fan: u32| refiner.vertices[fan as usize];
        let mut renames: Vec<Vec<Rename>> = Vec::new();
        let mut start = 0;
        for &end in &refiner.record_ends {
            let mut group = Vec::new();
            for &[kept, removed] in &refiner.record[start as usize..end as usize] {
                let rename = Rename { removed: vertex(removed), kept: vertex(kept) };
                if !group.contains(&rename) {
                    group.push(rename);
                }
            }
            renames.push(group);
            start = end;
        }
        let error_of = |level: usize| {
            let chunk = self.errors.partition_point(|&(_, end)| end as usize <= level);
            self.errors.get(chunk).map_or(self.error, |&(error, _)| error)
        };
        let collapses = renames.iter().enumerate().rev().map(|(level, group)| (&group[..], error_of(level)));
        CollapseSequence::from_collapses(self.vertex_count(), self.triangles(), collapses)
    }
}
