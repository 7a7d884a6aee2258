//! The strips of the keys: those of the full mesh, and below it the same, repaired.

use std::sync::Arc;

use super::BlockOptions;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::index_map::RESTART;
use crate::lod::level::level_model::LevelCursor;
use crate::lod::repair::Repair;
use crate::strip::Strips;

/// The strips of the keys, which are asked for from the full mesh on.
pub(super) struct KeyStrips<'a> {
    full: &'a Strips,
    sequence: &'a Arc<CollapseSequence>,
    repair: Repair,
}

impl<'a> KeyStrips<'a> {
    /// # Errors
    /// As [`Repair::new`].
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
    /// There is no such level.
    pub(super) fn at(&mut self, level: usize) -> Result<Vec<u32>, Error> {
        if level == self.sequence.len() {
            return Ok(self.full.to_restart(RESTART));
        }
        self.repair.set_level(level)?;
        Ok(self.repair.strips().to_restart(RESTART))
    }
}
