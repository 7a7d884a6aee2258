//! `repair` as a level model: each cursor repairs its own copy of the strips of the full mesh.

use std::sync::Arc;

use super::{Repair, RepairOptions};
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::level_mesh::LevelMesh;
use crate::lod::level::level_model::{LevelCursor, LevelModel};
use crate::lod::level::level_table::LevelTable;
use crate::strip::Strips;

/// The strips of a mesh at all levels, stored as the strips of the full mesh and the collapses.
/// Each cursor repairs its strips as it moves.
///
/// ```
/// use std::sync::Arc;
/// use tristrip::{CollapseSequence, Rename, Strips};
/// use tristrip::lod::{LevelModel, RepairOptions, RepairedStrips};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 4, 5]);
/// let rename = [Rename { removed: 1, kept: 0 }];
/// let sequence = CollapseSequence::from_collapses(6, strips.to_list(), [(&rename[..], 0.5)])?;
/// let model = Arc::new(RepairedStrips::new(sequence, strips, RepairOptions::default())?);
/// let mut cursor = model.start();
/// cursor.set_level(0)?;
/// assert_eq!(cursor.strips().vertices(), [5, 4, 3, 2, 0]);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct RepairedStrips {
    /// The cursor at the full mesh. All other cursors are copies of it.
    full: Repair,
}

impl RepairedStrips {
    /// Builds the model from the strips of the full mesh.
    ///
    /// # Errors
    /// The strips do not draw every triangle of the full mesh exactly once with its winding, or
    /// there are too many triangles.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let model = RepairedStrips::new(sequence, strips, RepairOptions::default())?;
    /// assert_eq!((model.levels().triangle_count(0)?, model.levels().triangle_count(2)?), (1, 3));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(
        sequence: impl Into<Arc<CollapseSequence>>,
        strips: Strips,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        let mut full = Repair::new(sequence, &strips, options)?;
        full.display = Some(strips);
        Ok(Self { full })
    }

    /// Returns a cursor at the level of the full mesh.
    pub(crate) fn cursor(&self) -> Repair {
        self.full.clone()
    }
}

/// Creates the strips of a mesh without triangles.
impl Default for RepairedStrips {
    fn default() -> Self {
        let sequence = Arc::new(CollapseSequence::default());
        let mesh = LevelMesh::new(&sequence);
        Self { full: Repair::linked(&sequence, mesh, &[], 0, RepairOptions::default()) }
    }
}

impl LevelModel for RepairedStrips {
    fn levels(&self) -> &LevelTable {
        &self.full.levels
    }

    fn memory(&self) -> usize {
        LevelCursor::memory(&self.full) + self.full.sequence.memory() + self.full.levels.memory()
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        Box::new(self.cursor())
    }
}
