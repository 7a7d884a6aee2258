//! Encodes a mesh with its collapses as a stream.
//!
//! # Algorithm
//! 1. The plan: collapses become splits of fans (module `plan`), and what no collapse removes is the base mesh.
//! 2. Rehearsals: all decisions are made without being written, so that the weights of the estimates can be fitted (module `fit`).
//! 3. The batches, from the base mesh on. In each, the groups of splits are sorted by the fans that they split. Before a batch the
//!    positions get as many bits as the error of the level is worth; the last batches have all.
//! 4. Chunks: the coder is closed at the end of a batch if there is enough for a chunk, and within a batch where a chunk would become too large.
//!
//! # Complexity
//! O(n) time, three times that of decoding and more; about 150 bytes per triangle.

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

/// The fits of the weights.
const REHEARSALS: usize = 2;

/// A chunk of a stream.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StreamChunk {
    /// Its bytes, head and checksum included.
    pub bytes: Vec<u8>,
    /// The level that it leads to: the collapses that are undone.
    pub level: u32,
    /// The triangles of that level.
    pub triangles: u32,
    /// The error of that level in mesh units, that of the positions included.
    pub error: f32,
}

impl StreamChunk {
    /// Returns its bytes with another number of the mesh.
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

/// A mesh as a stream, chunk by chunk: the base mesh first.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct EncodedStream {
    /// The chunks.
    pub chunks: Vec<StreamChunk>,
    /// The triangles of the base mesh, over the vertices of the input.
    pub base: Vec<u32>,
    /// How far a position of the full mesh may be from that of the input, in mesh units.
    pub position_error: f32,
    grid: Grid,
    position_bits: u32,
}

impl EncodedStream {
    /// Returns the position of the full mesh that a decoder gives for one of the input.
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

    /// Returns all bytes.
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

/// Encodes a mesh with its collapses. `level_ends` are the numbers of collapses, from the full mesh on, after which a batch ends; the points that a batch removes may not have a
/// common triangle, as those of `simplify::refinement_batches`. `stream` is the number of the mesh among those of a file. Degenerate triangles and unused vertices are left out.
///
/// # Errors
/// The sequence is not one of the mesh, a batch removes points that have a common triangle, a position or an attribute is not finite, or there are too many attributes.
///
/// ```
#[doc = include_str!("example.txt")]
/// // Seven bytes per vertex, in twelve of a position alone.
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

/// Finds the vertices that a stream cannot restore: those whose collapse does more than to move the corners of one fan, since a surface touches itself there or attributes differ
/// all around. With these locked, a simplification finds other collapses.
///
/// ```
#[doc = include_str!("example.txt")]
/// assert!(tristrip::stream::unsplittable(&batches.sequence).is_empty());
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn unsplittable(sequence: &CollapseSequence) -> Vec<u32> {
    Plan::new(sequence).unsplittable
}

/// Writes the decisions as chunks.
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
