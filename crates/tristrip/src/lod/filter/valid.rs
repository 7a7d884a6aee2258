//! The valid triangles of simplified strips: the places where three vertices in a row are different.
//!
//! Which they are follows no pattern that a processor could foresee, so that a test for each place would cost more than all the rest.
//! The places are therefore gathered without a branch, a block at a time.

#![allow(clippy::needless_bitwise_bool, reason = "a lazy operator would be a branch")]

use crate::lod::index_map::RESTART;

/// The key of the first place of a map.
pub(super) const FIRST_KEY: u32 = 2;

/// Places in a block.
pub(crate) const BLOCK: usize = 64;

/// A valid triangle of an index map.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Valid {
    /// Twice the number of its strip, and the parity of its place there. Strips are counted from one.
    pub(super) key: u32,
    /// Its place in the block.
    pub(super) place: u32,
}

/// What is gathered of one block.
pub(crate) struct Gatherer {
    valid: [Valid; BLOCK],
}

impl Gatherer {
    pub(crate) fn new() -> Self {
        Self { valid: [Valid::default(); BLOCK] }
    }

    /// Gathers the valid triangles of the block with which the rest of a map begins. `key` is that of its first place, and becomes that of
    /// the place after it.
    pub(super) fn gather(&mut self, rest: &[u32], key: &mut u32) -> &[Valid] {
        let Some(places) = rest.len().checked_sub(2) else { return &[] };
        let block = &rest[..places.min(BLOCK) + 2];
        let mut count = 0;
        let mut is_valid = [false; BLOCK];
        let corners = block.iter().zip(&block[1..]).zip(&block[2..]);
        for (is_valid, ((&a, &b), &c)) in is_valid.iter_mut().zip(corners) {
            let is_inside = (a != RESTART) & (b != RESTART) & (c != RESTART);
            *is_valid = (a != b) & (b != c) & (a != c) & is_inside;
        }
        let mut now = *key;
        for (place, (&vertex, &is_valid)) in block[..block.len() - 2].iter().zip(&is_valid).enumerate() {
            // Never beyond the block: `count` is at most `place`.
            self.valid[count % BLOCK] = Valid { key: now, place: place as u32 };
            count += usize::from(is_valid);
            now = if vertex == RESTART { (now | 1).wrapping_add(1) } else { now ^ 1 };
        }
        *key = now;
        &self.valid[..count]
    }
}
