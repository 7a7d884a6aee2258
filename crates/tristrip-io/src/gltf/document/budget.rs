//! Limits on decoded values and on triangles drawn repeatedly from the same indices.
//!
//! Decoding time and memory must be bounded by the file size. Four features of glTF break this
//! bound: compressed buffer views; accessors without a buffer view, whose values are zeros; several
//! accessors over the same bytes; and several primitives with the same indices. For the first
//! three, a budget limits the decoded bytes, with a small allowance. For the fourth, a budget
//! limits the triangles. Writing indices does not change these counts, so a file that was read can
//! be read again after writing.

use crate::error::Error;
use crate::gltf::document::byte_ranges::SharedBytes;

/// Maximum number of bytes to which the compressed buffer views of a file may decompress, plus 32
/// per byte of its buffers.
pub(in crate::gltf) const DECOMPRESSED_LIMIT: u64 = 8 << 20;

/// Maximum number of bytes of decoded positions and indices, plus 16 per byte of the file's
/// buffers.
pub(in crate::gltf) const GEOMETRY_LIMIT: u64 = 1 << 20;

/// Maximum number of bytes of other decoded vertex attributes, plus 4 per byte of the file's
/// buffers. Attributes beyond the limit are not decoded; a note counts them.
pub(in crate::gltf) const ATTRIBUTE_LIMIT: u64 = 64 << 20;

/// Maximum number of triangles that the primitives of a file may draw, plus 16 per distinct
/// triangle and [`TRIANGLES_PER_PRIMITIVE`] per primitive.
pub(in crate::gltf) const TRIANGLE_LIMIT: u64 = 1 << 18;

/// The number of triangles that each primitive adds to [`TRIANGLE_LIMIT`], up to
/// [`ALL_PRIMITIVES`].
const TRIANGLES_PER_PRIMITIVE: u64 = 1 << 10;

/// The maximum number of triangles that all primitives together add to [`TRIANGLE_LIMIT`].
const ALL_PRIMITIVES: u64 = 1 << 23;

/// How often each index array may be drawn, on average.
const TIMES_DRAWN: u64 = 16;

/// A limit on the number of decoded bytes.
#[derive(Debug)]
pub(in crate::gltf) struct DecodeBudget {
    limit: u64,
    used: u64,
}

impl DecodeBudget {
    /// Allows `free` bytes plus `factor` bytes per byte of the buffers.
    pub(in crate::gltf) fn new(free: u64, factor: u64, buffers: &[SharedBytes]) -> Self {
        let input: u64 = buffers.iter().map(|b| b.len() as u64).sum();
        Self { limit: free.saturating_add(input.saturating_mul(factor)), used: 0 }
    }

    /// Charges `count` values to the budget. `at` names what is decoded, for the error.
    ///
    /// # Errors
    /// The budget is exceeded.
    pub(in crate::gltf) fn charge(&mut self, at: &str, count: usize, bytes_each: usize) -> Result<(), Error> {
        let used = self.used.saturating_add((count as u64).saturating_mul(bytes_each as u64));
        if used > self.limit {
            let at = format!("{at}, bytes decoded so far");
            return Err(Error::LimitExceeded { at, found: used, limit: self.limit });
        }
        self.used = used;
        Ok(())
    }

    /// Charges `count` values if the budget allows it, and returns whether it did.
    pub(in crate::gltf) fn try_charge(&mut self, count: usize, bytes_each: usize) -> bool {
        self.charge("", count, bytes_each).is_ok()
    }
}

/// A limit on the number of drawn triangles.
#[derive(Default)]
pub(in crate::gltf) struct DrawBudget {
    primitives: u64,
    /// Triangles of the distinct index arrays.
    different: u64,
    drawn: u64,
}

impl DrawBudget {
    /// Charges the triangles of a primitive; `is_new` means that no earlier primitive had the same
    /// indices.
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
        let at = format!("{at}, triangles drawn so far, including repeated indices");
        Err(Error::LimitExceeded { at, found: self.drawn, limit })
    }
}
