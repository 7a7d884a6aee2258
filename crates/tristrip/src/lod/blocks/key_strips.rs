//! The strips of the keys: those of the full mesh, and below it the same, repaired.

use std::sync::Arc;

use super::BlockOptions;
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::index_map::RESTART;
use crate::lod::level_model::LevelCursor;
use crate::lod::repair::Repair;
use crate::strip::Strips;

/// The strips of the keys, which are asked for from the full mesh on.
pub(super) struct KeyStrips<'a> {
    full: &'a Strips,
    sequence: &'a Arc<CollapseSequence>,
    options: &'a BlockOptions,
    repair: Option<Repair>,
}

impl<'a> KeyStrips<'a> {
    pub(super) fn new(
        full: &'a Strips,
        sequence: &'a Arc<CollapseSequence>,
        options: &'a BlockOptions,
    ) -> Self {
        Self { full, sequence, options, repair: None }
    }

    /// Returns the index map of the strips of a level.
    ///
    /// # Errors
    /// As [`Repair::new`].
    pub(super) fn at(&mut self, level: usize) -> Result<Vec<u32>, Error> {
        if level == self.sequence.len() {
            return Ok(self.full.to_restart(RESTART));
        }
        let repair = match self.repair.take() {
            Some(repair) => repair,
            None => Repair::new(Arc::clone(self.sequence), self.full, self.options.repair())?,
        };
        let repair = self.repair.insert(repair);
        repair.set_level(level)?;
        Ok(repair.strips().to_restart(RESTART))
    }
}
