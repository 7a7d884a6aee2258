//! Skip Strips as a level model: every level of the sequence is a view.

use std::sync::Arc;

use super::{SkipStrips, SkipView};
use crate::error::Error;
use crate::lod::filter::Filter;
use crate::lod::level::level_model::{LevelCursor, LevelModel};
use crate::lod::level::level_table::LevelTable;
use crate::strip::Strips;

/// A cursor over the levels of a [`SkipStrips`] model.
#[derive(Debug, Clone)]
pub struct SkipLevelCursor {
    view: SkipView,
    level: usize,
    strips: Option<Strips>,
}

impl LevelModel for SkipStrips {
    fn levels(&self) -> &LevelTable {
        &self.levels
    }

    fn memory(&self) -> usize {
        self.memory_by_part().iter().sum()
    }

    fn start(self: Arc<Self>) -> Box<dyn LevelCursor> {
        let level = self.levels.collapse_count();
        Box::new(SkipLevelCursor { view: SkipView::new(self, Some(Filter::Dtfs), true), level, strips: None })
    }
}

impl LevelCursor for SkipLevelCursor {
    fn levels(&self) -> &LevelTable {
        &self.view.model().levels
    }

    fn level(&self) -> usize {
        self.level
    }

    fn set_level(&mut self, level: usize) -> Result<(), Error> {
        self.levels().check(level)?;
        self.view.move_between(self.level, level);
        (self.level, self.strips) = (level, None);
        Ok(())
    }

    fn strips(&mut self) -> &Strips {
        self.strips.get_or_insert_with(|| self.view.display_strips())
    }

    fn memory(&self) -> usize {
        self.view.memory() + self.strips.as_ref().map_or(0, Strips::memory)
    }
}
