//! How [`Blocks`](super::Blocks) are built.

use crate::lod::RepairOptions;
use crate::lod::level_model::LevelTable;

/// Entries per triangle of the strips of keys, on average over the test models; restarts included.
const ENTRIES_PER_TRIANGLE: f64 = 1.17;

/// The most bytes per triangle that keys may take.
const MOST_KEY_BYTES: u32 = 256;

/// How [`Blocks`](super::Blocks) are built.
///
/// ```
/// use tristrip::lod::{BlockOptions, RepairOptions};
/// let options = BlockOptions::default().with_repair(RepairOptions::default().with_seed(7)).with_key_bytes(4);
/// assert_eq!((options.repair().seed(), options.key_bytes()), (7, 4));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BlockOptions {
    repair: RepairOptions,
    key_bytes: u32,
}

impl Default for BlockOptions {
    /// Strips repaired at the default effort, and keys of 9 bytes per triangle.
    fn default() -> Self {
        Self { repair: RepairOptions::default(), key_bytes: 9 }
    }
}

impl BlockOptions {
    /// Sets how the strips of the keys are repaired.
    ///
    /// ```
    /// # use tristrip::lod::{BlockOptions, RepairOptions};
    /// let options = BlockOptions::default().with_repair(RepairOptions::default().with_seed(3));
    /// assert_eq!(options.repair().seed(), 3);
    /// ```
    #[must_use]
    pub fn with_repair(self, repair: RepairOptions) -> Self {
        Self { repair, ..self }
    }

    /// Sets about how many bytes per triangle of the full mesh the buffers of all keys take, from 1 to 256: with more bytes there are more keys, and
    /// fewer vertices are sent.
    ///
    /// ```
    /// # use tristrip::lod::BlockOptions;
    /// assert_eq!([0, 12, 999].map(|bytes| BlockOptions::default().with_key_bytes(bytes).key_bytes()), [1, 12, 256]);
    /// ```
    #[must_use]
    pub fn with_key_bytes(self, key_bytes: u32) -> Self {
        Self { key_bytes: key_bytes.clamp(1, MOST_KEY_BYTES), ..self }
    }

    /// Returns how the strips of the keys are repaired.
    ///
    /// ```
    /// # use tristrip::lod::{BlockOptions, RepairOptions};
    /// assert_eq!(BlockOptions::default().repair(), RepairOptions::default());
    /// ```
    pub fn repair(&self) -> RepairOptions {
        self.repair
    }

    /// Returns about how many bytes per triangle of the full mesh the buffers of all keys take.
    ///
    /// ```
    /// # use tristrip::lod::BlockOptions;
    /// assert_eq!(BlockOptions::default().key_bytes(), 9);
    /// ```
    pub fn key_bytes(&self) -> u32 {
        self.key_bytes
    }

    /// Returns the levels of the keys, from the full mesh on.
    #[allow(clippy::cast_sign_loss, reason = "numbers of triangles are not negative")]
    pub(super) fn key_levels(&self, levels: &LevelTable, entry_bits: u32) -> Vec<usize> {
        let mut level = levels.collapse_count();
        let full = levels.triangles_at(level) as f64;
        // The buffers of all keys have about 2 / (3 x) times the entries of the full mesh.
        let x = 2.0 / 3.0 * ENTRIES_PER_TRIANGLE * f64::from(entry_bits) / 8.0 / f64::from(self.key_bytes);
        let mut keys = vec![level];
        while level > 0 {
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
