//! The valid triangles of simplified strips: the positions where three consecutive vertices are
//! different.
//!
//! Valid positions are unpredictable, so a branch per position would dominate the run time. The
//! positions are therefore gathered without branches, one block at a time.

#![allow(clippy::needless_bitwise_bool, reason = "a lazy operator would be a branch")]

use crate::lod::level::index_map::RESTART;

/// The key of the first position of a map.
pub(super) const FIRST_KEY: u32 = 2;

/// The number of entries per block.
pub(crate) const BLOCK: usize = 64;

/// A valid triangle of an index map.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Valid {
    /// Twice the index of its strip, counted from one, plus the parity of its position in the
    /// strip.
    pub(super) key: u32,
    /// Its position in the block.
    pub(super) position: u32,
}

/// The valid triangles of one block.
pub(crate) struct Gatherer {
    valid: [Valid; BLOCK],
}

impl Gatherer {
    pub(crate) fn new() -> Self {
        Self { valid: [Valid::default(); BLOCK] }
    }

    /// Gathers the valid triangles of the first block of `rest`. `key` is the key of its first
    /// position; it becomes the key of the position after the block.
    pub(super) fn gather(&mut self, rest: &[u32], key: &mut u32) -> &[Valid] {
        let Some(positions) = rest.len().checked_sub(2) else { return &[] };
        let block = &rest[..positions.min(BLOCK) + 2];
        let mut count = 0;
        let mut is_valid = [false; BLOCK];
        let corners = block.iter().zip(&block[1..]).zip(&block[2..]);
        for (is_valid, ((&a, &b), &c)) in is_valid.iter_mut().zip(corners) {
            let is_inside = (a != RESTART) & (b != RESTART) & (c != RESTART);
            *is_valid = (a != b) & (b != c) & (a != c) & is_inside;
        }
        let mut now = *key;
        for (position, (&vertex, &is_valid)) in block[..block.len() - 2].iter().zip(&is_valid).enumerate() {
            // The index is in range: `count` is at most `position`.
            self.valid[count % BLOCK] = Valid { key: now, position: position as u32 };
            count += usize::from(is_valid);
            now = if vertex == RESTART { (now | 1).wrapping_add(1) } else { now ^ 1 };
        }
        *key = now;
        &self.valid[..count]
    }
}
