//! The strips of the full mesh, divided into chunks and segments, and the segments that contain
//! each vertex.
//!
//! ```text
//! strips      a b c d e … │ restart │ f g h …
//! chunks      ├──────────────────────────┤├──────────
//! segments    ├──────┤├──────┤├──────┤├──┤├──────┤├──
//! ```
//! Each chunk has its own region of the index buffer, and display strips end at the ends of chunks.
//! A segment is scanned again if one of its vertices has changed. Display strips continue across
//! segments.
//!
//! A chunk ends at the end of a strip. A strip that is longer than a chunk is cut after an even
//! number of vertices, which preserves the winding of the rest.
//!
//! # Complexity
//! O(n) time. 4 bytes and one packed segment number per strip vertex.

use super::vertex_tree::{NodeNumbers, VertexTree};
use crate::csr::Csr;
use crate::lod::filter::BLOCK;
use crate::lod::level::index_map::RESTART;
use crate::packed::PackedRows;
use crate::strip::Strips;

/// A chunk with at least this many entries is closed at the end of the strip. Chunks are short
/// because a change moves the rest of its chunk.
const CHUNK: usize = 64;
/// A strip that would make a chunk longer than this starts a new chunk.
const MAX_CHUNK: usize = 768;
/// Strips longer than [`MAX_CHUNK`] are cut into parts of about this many entries. Each part sends
/// two additional vertices.
const PART: usize = 512;
/// The number of entries that filters read beyond a segment.
pub(super) const AHEAD: usize = 4;

/// The strips of the full mesh, with nodes as vertices.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct OriginalStrips {
    /// All strips, with [`RESTART`] after each.
    entries: Vec<u32>,
    chunks: Vec<EntryRange>,
    /// The segments affected by the name of each node.
    segments_of: PackedRows,
}

/// A range of entries with its own region of the index buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct EntryRange {
    pub(super) start: u32,
    pub(super) end: u32,
    /// The index of its first segment, counted over all chunks.
    pub(super) first_segment: u32,
    /// The number of entries after its end that complete its last triangles, if its strip
    /// continues.
    pub(super) ahead: u32,
}

impl EntryRange {
    /// Returns the number of segments of a chunk.
    pub(super) fn segment_count(&self) -> usize {
        ((self.end - self.start + self.ahead) as usize).div_ceil(BLOCK)
    }
}

impl OriginalStrips {
    /// Divides strips into chunks and segments.
    pub(super) fn new(strips: &Strips, tree: &VertexTree, numbers: &NodeNumbers) -> Self {
        let mut entries = Vec::with_capacity(strips.vertices_sent() + strips.len());
        let mut chunks = ChunkList::default();
        for strip in strips.iter() {
            chunks.add(entries.len(), strip.len());
            entries.extend(strip.iter().map(|&v| numbers.of(v)));
            entries.push(RESTART);
        }
        let chunks = chunks.finish(entries.len());
        let keyed = chunks.iter().flat_map(|chunk| {
            let positions = chunk.start..(chunk.end + chunk.ahead);
            let entries = &entries;
            positions.flat_map(move |position| {
                let node = entries[position as usize];
                let at = position - chunk.start;
                // The triangles and pairs that contain an entry begin at most three entries before
                // it.
                let segment = |at: u32| chunk.first_segment + at / BLOCK as u32;
                let [first, last] = [segment(at.saturating_sub(AHEAD as u32 - 1)), segment(at)];
                (first..=last).filter(move |_| node != RESTART).map(move |segment| (node, segment))
            })
        });
        let rows = Csr::group_items(keyed, tree.len());
        let mut all = Vec::with_capacity(rows.item_count());
        let mut ends = Vec::with_capacity(tree.len());
        for row in rows.rows() {
            let start = all.len();
            for &segment in row {
                if !all[start..].contains(&segment) {
                    all.push(segment);
                }
            }
            ends.push(all.len());
        }
        drop(rows);
        let row = |node: usize| &all[if node == 0 { 0 } else { ends[node - 1] }..ends[node]];
        let segments_of = PackedRows::of((0..ends.len()).map(row));
        Self { entries, chunks, segments_of }
    }

    pub(super) fn chunks(&self) -> &[EntryRange] {
        &self.chunks
    }

    pub(super) fn segment_count(&self) -> usize {
        self.chunks.last().map_or(0, |last| last.first_segment as usize + last.segment_count())
    }

    /// Returns the nodes of a chunk, including those that complete its last triangles.
    pub(super) fn entries(&self, chunk: &EntryRange) -> &[u32] {
        &self.entries[chunk.start as usize..(chunk.end + chunk.ahead) as usize]
    }

    /// Returns the nodes of all strips, with [`RESTART`] after each strip.
    pub(super) fn all(&self) -> &[u32] {
        &self.entries
    }

    /// Iterates over the segments affected by the names of a range of nodes. A segment can occur
    /// several times.
    #[inline]
    pub(super) fn segments_of(&self, nodes: std::ops::Range<u32>) -> impl Iterator<Item = u32> {
        self.segments_of.rows(nodes)
    }

    /// Returns the memory in bytes of the strips, and of everything else.
    pub(super) fn memory(&self) -> [usize; 2] {
        [size_of_val(&self.entries[..]), size_of_val(&self.chunks[..]) + self.segments_of.memory()]
    }
}

/// The starts of the chunks found so far.
#[derive(Debug, Default)]
struct ChunkList {
    /// The start of each chunk, and whether it lies inside a strip.
    starts: Vec<(u32, bool)>,
}

impl ChunkList {
    /// Adds a strip that starts at a position.
    fn add(&mut self, position: usize, length: usize) {
        let open = self.starts.last().map(|&(start, _)| position - start as usize);
        if open.is_none_or(|open| open >= CHUNK || open > 0 && open + length > MAX_CHUNK) {
            self.starts.push((position as u32, false));
        }
        if length > MAX_CHUNK {
            let parts = length.div_ceil(PART);
            let starts = (1..parts).map(|part| (part * length / parts) & !1);
            self.starts.extend(starts.map(|start| ((position + start) as u32, true)));
        }
    }

    /// Returns the chunks of `entry_count` entries.
    fn finish(self, entry_count: usize) -> Vec<EntryRange> {
        let mut segment = 0;
        let ends = self.starts[1.min(self.starts.len())..].iter().copied();
        let ends = ends.chain([(entry_count as u32, false)]);
        let chunk = |(&(start, _), (end, goes_on)): (&(u32, bool), (u32, bool))| {
            let chunk = EntryRange { start, end, first_segment: segment, ahead: if goes_on { 2 } else { 0 } };
            segment += chunk.segment_count() as u32;
            chunk
        };
        self.starts.iter().zip(ends).map(chunk).collect()
    }
}
