//! The valid triangles of simplified strips: the places where three vertices in a row are different.
//!
//! Which they are follows no pattern that a processor could foresee, so that a test for each place would cost more than all the rest.
//! The places are therefore gathered without a branch, a block at a time.

#![allow(clippy::needless_bitwise_bool, reason = "a lazy operator would be a branch")]

use crate::lod::RESTART;

/// Places in a block.
pub(super) const BLOCK: usize = 64;

/// A valid triangle of an index map.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Valid {
    /// Twice the number of its strip, and the parity of its place there. Strips are counted from one.
    pub(super) key: u32,
    /// Its place in the block.
    pub(super) place: u32,
}

/// What is gathered of one block, and the key of the place after it.
pub(super) struct Gatherer {
    valid: [Valid; BLOCK],
    key: u32,
}

impl Gatherer {
    pub(super) fn new() -> Self {
        Self { valid: [Valid::default(); BLOCK], key: 2 }
    }

    /// Gathers the valid triangles of the next block.
    pub(super) fn gather(&mut self, block: &[u32]) -> &[Valid] {
        let mut count = 0;
        let mut is_valid = [false; BLOCK];
        let corners = block.iter().zip(&block[1..]).zip(&block[2..]);
        for (is_valid, ((&a, &b), &c)) in is_valid.iter_mut().zip(corners) {
            let is_inside = (a != RESTART) & (b != RESTART) & (c != RESTART);
            *is_valid = (a != b) & (b != c) & (a != c) & is_inside;
        }
        let mut key = self.key;
        for (place, (&vertex, &is_valid)) in block[..block.len() - 2].iter().zip(&is_valid).enumerate() {
            // Never beyond the block: `count` is at most `place`.
            self.valid[count % BLOCK] = Valid { key, place: place as u32 };
            count += usize::from(is_valid);
            key = if vertex == RESTART { (key | 1).wrapping_add(1) } else { key ^ 1 };
        }
        self.key = key;
        &self.valid[..count]
    }
}

/// Walks over the blocks of a map, each with the two entries that follow it.
pub(super) fn blocks(map: &[u32]) -> impl Iterator<Item = &[u32]> {
    let last = map.len().saturating_sub(2);
    (0..last).step_by(BLOCK).map(|start| &map[start..map.len().min(start + BLOCK + 2)])
}
