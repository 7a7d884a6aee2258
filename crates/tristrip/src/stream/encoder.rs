//! Encodes a mesh and its collapses as a stream.
//!
//! # Algorithm
//! 1. Plan: collapses become splits of fans (module `plan`). The base mesh consists of everything
//!    that no collapse removes.
//! 2. Rehearsals: all decisions are made without writing them, in order to fit the weights of the
//!    predictions (module `fit`).
//! 3. Batches are written, starting from the base mesh. Within a batch, groups of splits are sorted
//!    by the fans that they split. Before each batch, positions gain as many bits as the error of
//!    the level justifies; the last batches have all bits.
//! 4. Chunks: the coder is closed at the end of a batch if the chunk is large enough, and within a
//!    batch before a chunk becomes too large.
//!
//! # Complexity
//! O(n) time, at least three times that of decoding; about 150 bytes per triangle.

use super::chunk::ChunkHead;
use super::fit::Fit;
use super::grid::Grid;
use super::head::Head;
use super::options::StreamOptions;
use super::places::USUAL_WEIGHTS;
use super::plan::Plan;
use super::run::{EncodingRun, Pass, Rehearsing};
use super::source::StreamSource;
use crate::collapse::CollapseSequence;
use crate::entropy::range_coder::RangeEncoder;
use crate::error::Error;
use crate::mesh::Mesh;

/// The number of passes that fit the weights.
const REHEARSALS: usize = 2;

/// A chunk of a stream.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StreamChunk {
    /// The bytes of the chunk, including header and checksum.
    pub bytes: Vec<u8>,
    /// The level after this chunk is decoded, as the number of collapses undone.
    pub level: u32,
    /// The number of triangles at that level.
    pub triangles: u32,
    /// The error of that level in mesh units, including the error of quantized positions.
    pub error: f32,
}

impl StreamChunk {
    /// Returns the bytes of the chunk with another mesh index.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// use tristrip::stream::{Decoder, StreamLimits};
    /// let mut decoder = Decoder::new(StreamLimits::default());
    /// decoder.update(&stream.chunks[0].of_stream(7)).map_err(|fault| fault.to_string())?;
    /// assert!(decoder.part(0).is_none() && decoder.part(7).is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of_stream(&self, stream: u32) -> Vec<u8> {
        match ChunkHead::read(&self.bytes) {
            Some(Ok((head, _, length))) => ChunkHead { stream, ..head }.with_payload(&self.bytes[length..]),
            _ => self.bytes.clone(),
        }
    }
}

/// An encoded mesh as a sequence of chunks. The first chunk is the base mesh.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct EncodedStream {
    /// The chunks in the order of the stream.
    pub chunks: Vec<StreamChunk>,
    /// The triangles of the base mesh, as indices of the input vertices.
    pub base: Vec<u32>,
    /// The maximum error of a decoded position of the full mesh, in mesh units.
    pub position_error: f32,
    grid: Grid,
    position_bits: u32,
}

impl EncodedStream {
    /// Returns the position that a decoder reconstructs at full detail for an input position.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let corner = mesh.positions()[0];
    /// assert!((0..3).all(|axis| (stream.decoded(corner)[axis] - corner[axis]).abs() <= stream.position_error));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn decoded(&self, position: [f32; 3]) -> [f32; 3] {
        self.grid.position(self.grid.place(position, self.position_bits), 0)
    }

    /// Returns the bytes of all chunks, concatenated.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// assert_eq!(stream.bytes().len(), stream.chunks.iter().map(|chunk| chunk.bytes.len()).sum::<usize>());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn bytes(&self) -> Vec<u8> {
        self.chunks.iter().flat_map(|chunk| chunk.bytes.iter().copied()).collect()
    }
}

/// Encodes a mesh and its collapses. `level_ends` are the ends of batches, as numbers of collapses
/// counted from the full mesh. Points removed by the same batch must not share a triangle;
/// `simplify::refinement_batches` returns such batches. `stream` is the index of the mesh in its
/// file. Degenerate triangles and unused vertices are left out.
///
/// # Errors
/// An option is out of range; the sequence does not belong to the mesh; a batch removes points that
/// share a triangle; a position or an attribute is not finite; there are too many attributes.
///
/// ```
#[doc = include_str!("example.txt")]
/// // Seven bytes per vertex; a position as floats takes twelve.
/// assert!(stream.bytes().len() < 81 * 7);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn encode(
    mesh: &Mesh,
    sequence: &CollapseSequence,
    level_ends: &[u32],
    stream: u32,
    options: &StreamOptions,
) -> Result<EncodedStream, Error> {
    let source = StreamSource::new(mesh, sequence, level_ends, options)?;
    let mut weights = USUAL_WEIGHTS;
    for _ in 0..REHEARSALS {
        let mut run = EncodingRun::new(&source, &weights);
        run.refiner.fit = Some(Fit::new(&weights));
        run.all(&mut Rehearsing::default(), options)?;
        if let Some(fit) = run.refiner.fit.take() {
            weights = fit.solve(&weights);
        }
    }
    let mut run = EncodingRun::new(&source, &weights);
    let mut writing = Writing { stream, coder: RangeEncoder::new(), chunks: Vec::new(), head: Vec::new() };
    run.all(&mut writing, options)?;
    run.check()?;
    Ok(EncodedStream {
        chunks: writing.chunks,
        base: source.plan.base(),
        position_error: source.grid.error(0),
        grid: source.grid,
        position_bits: source.position_bits,
    })
}

/// Returns the vertices that a stream cannot restore. Collapsing such a vertex moves corners of
/// more than one fan, because the surface touches itself there or the attributes differ all around
/// the vertex. Lock them to make a simplification choose other collapses.
///
/// ```
#[doc = include_str!("example.txt")]
/// assert!(tristrip::stream::unsplittable(&batches.sequence).is_empty());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn unsplittable(sequence: &CollapseSequence) -> Vec<u32> {
    Plan::new(sequence).unsplittable
}

/// A pass that writes its decisions as chunks.
struct Writing {
    stream: u32,
    coder: RangeEncoder,
    chunks: Vec<StreamChunk>,
    head: Vec<u8>,
}

impl Pass for Writing {
    type Coder = RangeEncoder;
    fn coder(&mut self) -> &mut RangeEncoder {
        &mut self.coder
    }
    fn len(&self) -> usize {
        self.coder.len()
    }
    fn begin(&mut self, head: &Head) {
        head.write(&mut self.head);
    }
    fn end(&mut self, head: ChunkHead) {
        let coder = std::mem::replace(&mut self.coder, RangeEncoder::new());
        let mut payload = std::mem::take(&mut self.head);
        payload.extend(coder.finish());
        let head = ChunkHead { stream: self.stream, ..head };
        let ChunkHead { level, triangles, error, .. } = head;
        self.chunks.push(StreamChunk { bytes: head.with_payload(&payload), level, triangles, error });
    }
}
