//! Builds the strips of the keys by repairing the strips of the full mesh for each coarser key.

use std::sync::Arc;

use super::BlockOptions;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::index_map::RESTART;
use crate::lod::level::level_model::LevelCursor;
use crate::lod::repair::Repair;
use crate::strip::Strips;

/// The strips of the keys, requested in order from the full mesh.
pub(super) struct KeyStrips<'a> {
    full: &'a Strips,
    sequence: &'a Arc<CollapseSequence>,
    repair: Repair,
}

impl<'a> KeyStrips<'a> {
    /// Starts at the full mesh.
    ///
    /// # Errors
    /// The strips do not draw every triangle of the full mesh exactly once with its winding, or
    /// there are too many triangles.
    pub(super) fn new(
        full: &'a Strips,
        sequence: &'a Arc<CollapseSequence>,
        options: &BlockOptions,
    ) -> Result<Self, Error> {
        let repair = Repair::new(Arc::clone(sequence), full, options.repair)?;
        Ok(Self { full, sequence, repair })
    }

    /// Returns the index map of the strips of a level.
    ///
    /// # Errors
    /// The level does not exist.
    pub(super) fn at(&mut self, level: usize) -> Result<Vec<u32>, Error> {
        if level == self.sequence.len() {
            return Ok(self.full.to_restart(RESTART));
        }
        self.repair.set_level(level)?;
        Ok(self.repair.strips().to_restart(RESTART))
    }
}
