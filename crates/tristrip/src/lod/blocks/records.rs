//! Records what each collapse writes into the slots of the index buffers, in the order of the
//! levels. The records can be read in both directions.
//!
//! ```text
//! words      [slot 17] [slot 90 *] [slot 18 r**]    * last word of a rename  ** also of a collapse
//! vertices   5 → 4                 4                r a restart
//! ```
//! A rename stores the vertex before the collapse. It also stores the vertex after the collapse,
//! unless the slot becomes a restart. A word contains a slot and three flags. The loop that applies
//! collapses has no branches other than its end condition.

use std::ops::Range;

use super::live_buffer::Change;
use crate::error::Error;
use crate::index::Index;
use crate::lod::level::index_map::RESTART;
use crate::packed::{Packed, bits_for};

/// The flags of a word, below its slot. The last word of a collapse is also the last of a rename.
const END_OF_RENAME: u32 = 1;
const END_OF_COLLAPSE: u32 = 2;
const RESTART_AFTER: u32 = 4;
pub(super) const FLAG_BITS: u32 = 3;

/// A position between two collapses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Position {
    word: usize,
    vertex: usize,
}

/// The records of all collapses in order, starting at the full mesh, during construction.
#[derive(Debug)]
pub(super) struct RecordList {
    words: Vec<u32>,
    vertices: Packed,
    /// The value that represents a restart: the largest vertex plus one.
    restart: u32,
    vertex_count: usize,
}

impl RecordList {
    /// Creates a list for collapses of vertices up to `largest`.
    pub(super) fn new(largest: u32) -> Self {
        Self { words: Vec::new(), vertices: Packed::default(), restart: largest + 1, vertex_count: 0 }
    }

    /// Returns the position after the last collapse.
    pub(super) fn end(&self) -> Position {
        Position { word: self.words.len(), vertex: self.vertex_count }
    }

    /// Appends what a collapse writes, at least one slot.
    ///
    /// # Errors
    /// A slot index is too large.
    pub(super) fn push(&mut self, changes: &[Change]) -> Result<(), Error> {
        for renamed in changes.chunk_by(|a, b| (a.fine, a.coarse) == (b.fine, b.coarse)) {
            let Change { fine, coarse, .. } = renamed[0];
            self.push_vertex(fine);
            let flag = if coarse == RESTART { RESTART_AFTER } else { 0 };
            if coarse != RESTART {
                self.push_vertex(coarse);
            }
            for change in renamed {
                if change.slot >> (u32::BITS - FLAG_BITS) != 0 {
                    let (found, limit) = (u64::from(change.slot), u64::from(u32::MAX >> FLAG_BITS));
                    return Err(Error::LimitExceeded { what: "slots of an index buffer", found, limit });
                }
                self.words.push(change.slot << FLAG_BITS | flag);
            }
            self.flag_last(END_OF_RENAME);
        }
        self.flag_last(END_OF_COLLAPSE);
        Ok(())
    }

    fn push_vertex(&mut self, vertex: u32) {
        // A collapse without renames can have a restart before it.
        self.vertices.push(vertex.min(self.restart), bits_for(self.restart));
        self.vertex_count += 1;
    }

    fn flag_last(&mut self, flag: u32) {
        if let Some(last) = self.words.last_mut() {
            *last |= flag;
        }
    }

    /// Packs the words into as few bits as the largest one needs.
    pub(super) fn pack(self) -> BlockRecords {
        let word_bits = bits_for(self.words.iter().copied().max().unwrap_or(0));
        let mut words = Packed::default();
        self.words.iter().for_each(|&word| words.push(word, word_bits));
        BlockRecords { words, word_bits, vertices: self.vertices, restart: self.restart }
    }
}

/// The records of all collapses in order, starting at the full mesh.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BlockRecords {
    words: Packed,
    word_bits: u32,
    vertices: Packed,
    restart: u32,
}

impl BlockRecords {
    #[inline]
    fn word(&self, i: usize) -> u32 {
        self.words.get(i * self.word_bits as usize, self.word_bits)
    }

    #[inline]
    fn vertex<I: Index>(&self, i: usize) -> I {
        let bits = bits_for(self.restart);
        index_of(self.vertices.get(i * bits as usize, bits), self.restart)
    }

    /// Applies `count` collapses, starting at the position, to the buffer of their key.
    pub(super) fn collapse<I: Index>(&self, count: usize, position: &mut Position, buffer: &mut [I]) {
        let (mut left, Position { word: mut next, mut vertex }) = (count, *position);
        while left > 0 {
            let word = self.word(next);
            // A restart has no vertex of its own: the one before it is read and ignored.
            let coarse = self.vertex(vertex + usize::from(word & RESTART_AFTER == 0));
            buffer[(word >> FLAG_BITS) as usize] =
                if word & RESTART_AFTER == 0 { coarse } else { I::RESTART };
            next += 1;
            vertex += vertices_behind(word);
            left -= usize::from(word & END_OF_COLLAPSE != 0);
        }
        *position = Position { word: next, vertex };
    }

    /// Undoes `count` collapses before the position, in the buffer of their key.
    pub(super) fn split<I: Index>(&self, count: usize, position: &mut Position, buffer: &mut [I]) {
        let (mut left, Position { word: mut next, mut vertex }) = (count, *position);
        // Stop at the last word of the collapse before the first one to undo.
        while next > 0 {
            let word = self.word(next - 1);
            if word & END_OF_COLLAPSE != 0 {
                if left == 0 {
                    break;
                }
                left -= 1;
            }
            next -= 1;
            vertex -= vertices_behind(word);
            buffer[(word >> FLAG_BITS) as usize] = self.vertex(vertex);
        }
        *position = Position { word: next, vertex };
    }

    /// Returns the slots written between two positions, possibly with repeats.
    pub(super) fn slots(&self, between: Range<Position>) -> impl Iterator<Item = usize> {
        (between.start.word..between.end.word).map(|i| (self.word(i) >> FLAG_BITS) as usize)
    }

    /// Returns the memory in bytes.
    pub(super) fn memory(&self) -> usize {
        self.words.memory() + self.vertices.memory()
    }
}

/// Returns the number of vertices of a rename for its last word, and 0 for other words.
#[inline]
fn vertices_behind(word: u32) -> usize {
    (word & END_OF_RENAME) as usize * (2 - usize::from(word & RESTART_AFTER != 0))
}

/// Converts an entry of a packed buffer or record to an index. All vertices fit into the index
/// type.
#[inline]
pub(super) fn index_of<I: Index>(entry: u32, restart: u32) -> I {
    let index = I::from_vertex(entry).unwrap_or(I::RESTART);
    if entry == restart { I::RESTART } else { index }
}
