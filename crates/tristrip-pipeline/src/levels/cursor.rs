//! A model at a level: one cursor per part. The cursors move together in the order of all
//! collapses.

use std::fmt;
use std::sync::Arc;

use tristrip::lod::{LevelCursor, LevelModel};
use tristrip::{CollapseSequence, Strips};

use super::part::LevelPart;
use crate::error::Error;
use crate::parts::map;
use crate::simplify::LevelOrder;

/// The parts of a model at a level, as level models of one kind.
///
/// ```
/// use tristrip::lod::ModelKind;
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::levels;
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let levels = levels::run(&model, &levels::Options::default(), &())?.model;
/// let mut cursor = levels.cursor(ModelKind::Sets)?;
/// cursor.set_level(0)?;
/// assert_eq!(cursor.of_parts_mut()[0].strips().triangles().count(), 1);
/// # Ok::<(), tristrip_pipeline::Error>(())
/// ```
pub struct ModelCursor {
    order: Arc<LevelOrder>,
    models: Vec<Arc<dyn LevelModel>>,
    level: usize,
    levels: Vec<usize>,
    /// The parts that the last move changed, without repeats.
    moved: Vec<u32>,
    cursors: Vec<Box<dyn LevelCursor>>,
}

impl ModelCursor {
    /// Builds a level model of each part, at the full mesh.
    pub(super) fn new(
        order: &Arc<LevelOrder>,
        parts: &[LevelPart],
        build: impl Fn(&Strips, &Arc<CollapseSequence>) -> Result<Arc<dyn LevelModel>, tristrip::Error> + Sync,
    ) -> Result<Self, Error> {
        let built = map(parts, |part| build(part.strips(), part.sequence()));
        Self::start(Arc::clone(order), built.into_iter().collect::<Result<_, _>>()?)
    }

    fn start(order: Arc<LevelOrder>, models: Vec<Arc<dyn LevelModel>>) -> Result<Self, Error> {
        let level = order.collapse_count();
        let levels = order.of_parts(level)?;
        let cursors = models.iter().cloned().map(LevelModel::start).collect();
        Ok(Self { order, models, level, levels, moved: Vec::new(), cursors })
    }

    /// Returns another cursor over the same level models, for another instance or view. It starts
    /// at the full mesh.
    ///
    /// # Errors
    /// A valid cursor does not cause an error, because its order and its level models were checked
    /// when it was built.
    ///
    /// ```
    /// use tristrip::lod::ModelKind;
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::levels;
    /// let model = read(b"v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n", Format::Obj)?;
    /// let mut far = levels::run(&model, &levels::Options::default(), &())?.model.cursor(ModelKind::Blocks)?;
    /// let near = far.another()?;
    /// far.set_level(0)?;
    /// assert!(near.level() > far.level());
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn another(&self) -> Result<Self, Error> {
        Self::start(Arc::clone(&self.order), self.models.clone())
    }

    /// Returns the level of the model.
    pub fn level(&self) -> usize {
        self.level
    }

    /// Moves to a level of the model. The time is one step per collapse between the two levels,
    /// plus the time to move the cursors of the parts.
    ///
    /// # Errors
    /// [`Error::Level`]: the level does not exist. The cursor does not move.
    pub fn set_level(&mut self, level: usize) -> Result<(), Error> {
        let last = self.order.collapse_count();
        if level > last {
            return Err(Error::Level { found: level, last });
        }
        self.moved.clear();
        for number in last - self.level..last - level.min(self.level) {
            for &part in self.order.parts_of(number) {
                self.levels[part as usize] -= 1;
                self.moved.push(part);
            }
        }
        for number in last - level.max(self.level)..last - self.level {
            for &part in self.order.parts_of(number) {
                self.levels[part as usize] += 1;
                self.moved.push(part);
            }
        }
        self.level = level;
        if self.cursors.len() > 1 {
            self.moved.sort_unstable();
        }
        self.moved.dedup();
        for &part in &self.moved {
            self.cursors[part as usize].set_level(self.levels[part as usize])?;
        }
        Ok(())
    }

    /// Returns the cursors of the parts, in order, for access to their strips.
    pub fn of_parts_mut(&mut self) -> &mut [Box<dyn LevelCursor>] {
        &mut self.cursors
    }

    /// Returns the number of bytes of memory that the level models use, without the cursors.
    pub fn model_memory(&self) -> usize {
        self.models.iter().map(|model| model.memory()).sum()
    }

    /// Returns the number of bytes of memory that the cursors of the parts use.
    pub fn cursor_memory(&self) -> usize {
        self.cursors.iter().map(|cursor| cursor.memory()).sum()
    }
}

impl fmt::Debug for ModelCursor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ModelCursor").field("level", &self.level).finish_non_exhaustive()
    }
}
