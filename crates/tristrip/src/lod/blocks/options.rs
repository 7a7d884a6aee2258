//! Options for building [`Blocks`](super::Blocks).

use crate::effort::Effort;
use crate::lod::RepairOptions;
use crate::lod::level::level_table::LevelTable;
use crate::packed::bits_for;
use crate::strip::Strips;

use super::records::FLAG_BITS;

/// The maximum number of bytes per triangle. Larger values have no further effect.
const MAX_MEMORY: u32 = 256;

/// Slots written per collapse and vertices per record, averaged over the test models.
const SLOTS_PER_COLLAPSE: f64 = 3.0;
const VERTICES_PER_COLLAPSE: f64 = 2.8;

/// Options for building [`Blocks`](super::Blocks).
///
/// ```
/// use tristrip::lod::{BlockOptions, RepairOptions};
/// let options = BlockOptions::default().with_repair(RepairOptions::default().with_seed(7)).with_memory(30);
/// assert_eq!((options.repair.seed, options.memory), (7, 30));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct BlockOptions {
    /// The options for repairing the strips of the keys.
    pub repair: RepairOptions,
    /// The approximate size of the model in bytes per triangle of the full mesh, up to 256.
    pub memory: u32,
    /// Whether strips are split to keep uploads small.
    pub small_uploads: bool,
}

impl Default for BlockOptions {
    /// Returns options for 18 bytes per triangle and keys repaired at effort 1.
    fn default() -> Self {
        Self {
            repair: RepairOptions::default().with_effort(Effort::new(1).unwrap_or_default()),
            memory: 18,
            small_uploads: false,
        }
    }
}

impl BlockOptions {
    crate::setters! {
        /// Sets how the strips of the keys are repaired.
        ///
        /// ```
        /// # use tristrip::lod::{BlockOptions, RepairOptions};
        /// let options = BlockOptions::default().with_repair(RepairOptions::default().with_seed(3));
        /// assert_eq!(options.repair.seed, 3);
        /// ```
        with_repair(repair: RepairOptions);

        /// Sets the approximate size of the model, up to 256 bytes per triangle of the full mesh. A
        /// larger model has more keys and sends fewer vertices. The collapses alone take about 12
        /// bytes per triangle. If the size is near or below this value, the model has few keys.
        ///
        /// ```
        /// # use tristrip::lod::BlockOptions;
        /// assert_eq!(BlockOptions::default().with_memory(30).memory, 30);
        /// ```
        with_memory(memory: u32);

        /// Splits strips to keep uploads small. A move across 1 % of the levels then changes a
        /// small part of the buffer, in few ranges. This sends about a quarter more vertices. Use
        /// it for buffers that are expensive to upload.
        ///
        /// ```
        /// # use tristrip::lod::BlockOptions;
        /// assert!(BlockOptions::default().with_small_uploads(true).small_uploads);
        /// ```
        with_small_uploads(small_uploads: bool);
    }

    /// Returns the levels of the keys for strips of the full mesh, starting with the full mesh.
    #[allow(clippy::cast_sign_loss, reason = "numbers of triangles are not negative")]
    pub(super) fn key_levels(&self, levels: &LevelTable, strips: &Strips, largest: u32) -> Vec<usize> {
        let mut level = levels.collapse_count();
        let full = levels.triangles_at(level) as f64;
        let bytes = |bits: f64| bits / 8.0;
        let entry_count = strips.vertices_sent() + strips.len();
        let slot_bits = f64::from(bits_for(entry_count as u32) + FLAG_BITS);
        let vertex_bits = f64::from(bits_for(largest));
        let per_collapse = bytes(SLOTS_PER_COLLAPSE * slot_bits + VERTICES_PER_COLLAPSE * vertex_bits);
        let others = level as f64 * per_collapse + levels.memory() as f64;
        let for_keys = (f64::from(self.memory.min(MAX_MEMORY)) * full - others).max(full);
        // All key buffers together have about 2 / (3 x) times the entries of the full mesh.
        let of_full = bytes(entry_count as f64 * f64::from(bits_for(largest + 1)));
        let x = 2.0 / 3.0 * of_full / for_keys;
        let mut keys = vec![level];
        // Without triangles there is nothing to draw.
        while level > 0 && levels.triangles_at(level) > 0 {
            let triangles = levels.triangles_at(level) as f64;
            let fall = (x * (triangles * full).sqrt()).min(triangles / 2.0);
            level = levels.level_of_triangles((triangles - fall) as usize).min(level - 1);
            if level > 0 {
                keys.push(level);
            }
        }
        keys
    }
}
