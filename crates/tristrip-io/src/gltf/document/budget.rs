//! Limits on what a document may make of its bytes: decoded values, and triangles that are drawn from the same indices again
//! and again.
//!
//! What a reader decodes must be paid for by the bytes of the file, in time and in memory. Four things are not: compressed
//! buffer views; accessors without a buffer view, which are zeros; several accessors over the same bytes; and several primitives
//! with the same indices. The first three count as decoded bytes, against a small allowance. The fourth counts as triangles.
//! Writing indices does not change this count, so that what was read can be read again.

use crate::error::Error;
use crate::gltf::document::byte_ranges::SharedBytes;

/// The number of bytes that the compressed buffer views of any file may take when decompressed; 32 for each byte of its buffers
/// are added.
pub(in crate::gltf) const DECOMPRESSED_LIMIT: u64 = 8 << 20;

/// The number of bytes that positions and indices of any file may take when decoded; 16 for each byte of its buffers are
/// added.
pub(in crate::gltf) const GEOMETRY_LIMIT: u64 = 1 << 20;

/// The number of bytes that the other vertex attributes of any file may take when decoded; 4 for each byte of its buffers are
/// added. Attributes beyond the limit are not decoded, and counted in the notes.
pub(in crate::gltf) const ATTRIBUTE_LIMIT: u64 = 64 << 20;

/// The number of triangles that the primitives of any file may draw; 16 for each triangle of different indices, and
/// [`TRIANGLES_PER_PRIMITIVE`] are added.
pub(in crate::gltf) const TRIANGLE_LIMIT: u64 = 1 << 18;

/// The number of triangles that each primitive adds to [`TRIANGLE_LIMIT`], 8,388,608 for all primitives at most.
const TRIANGLES_PER_PRIMITIVE: u64 = 1 << 10;

/// What all primitives may add.
const ALL_PRIMITIVES: u64 = 1 << 23;

/// How often each array of indices may be drawn, on average.
const TIMES_DRAWN: u64 = 16;

/// A limit on the bytes that are decoded.
#[derive(Debug)]
pub(in crate::gltf) struct DecodeBudget {
    limit: u64,
    used: u64,
}

impl DecodeBudget {
    /// Allows `free` bytes, and `factor` bytes per byte of the buffers.
    pub(in crate::gltf) fn new(free: u64, factor: u64, buffers: &[SharedBytes]) -> Self {
        let input: u64 = buffers.iter().map(|b| b.len() as u64).sum();
        Self { limit: free.saturating_add(input.saturating_mul(factor)), used: 0 }
    }

    /// Charges `count` values to the budget.
    ///
    /// # Errors
    /// The budget is exceeded; `at` says what was to be decoded.
    pub(in crate::gltf) fn charge(&mut self, at: &str, count: usize, bytes_each: usize) -> Result<(), Error> {
        let used = self.used.saturating_add((count as u64).saturating_mul(bytes_each as u64));
        if used > self.limit {
            let at = format!("{at}, bytes decoded so far");
            return Err(Error::LimitExceeded { at, found: used, limit: self.limit });
        }
        self.used = used;
        Ok(())
    }

    /// Charges `count` values to the budget if it has room for them, and returns whether it has.
    pub(in crate::gltf) fn try_charge(&mut self, count: usize, bytes_each: usize) -> bool {
        self.charge("", count, bytes_each).is_ok()
    }
}

/// A limit on the triangles that are drawn.
#[derive(Default)]
pub(in crate::gltf) struct DrawBudget {
    primitives: u64,
    /// Triangles of the different arrays of indices.
    different: u64,
    drawn: u64,
}

impl DrawBudget {
    /// Charges the triangles of a primitive; `is_new` if no earlier primitive had the same indices.
    ///
    /// # Errors
    /// The primitives so far draw too many triangles from the same indices.
    pub(in crate::gltf) fn charge(&mut self, at: &str, triangles: u64, is_new: bool) -> Result<(), Error> {
        self.primitives += 1;
        self.drawn = self.drawn.saturating_add(triangles);
        self.different += if is_new { triangles } else { 0 };
        let by_primitives = self.primitives.saturating_mul(TRIANGLES_PER_PRIMITIVE).min(ALL_PRIMITIVES);
        let by_indices = self.different.saturating_mul(TIMES_DRAWN);
        let limit = TRIANGLE_LIMIT.saturating_add(by_primitives).saturating_add(by_indices);
        if self.drawn <= limit {
            return Ok(());
        }
        let at = format!("{at}, triangles drawn so far, with the same indices again");
        Err(Error::LimitExceeded { at, found: self.drawn, limit })
    }
}
