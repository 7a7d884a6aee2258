//! `blocks` at one level of the whole model: the level whose error is allowed at the nearest vertex
//! in the image.

use std::sync::Arc;

use tristrip::lod::{
    BlockOptions, Blocks, BlocksCursor, Hysteresis, LevelCursor, LevelModel, View, ViewCriteria,
};
use tristrip::simplify::{SimplifyOptions, simplify_triangles};
use tristrip::{CollapseSequence, Mesh, Strips};
use tristrip_bench::failure::Failure;

use super::alternative::{Alternative, Drawn};

use crate::frames::Frame;
use crate::proof::sorted;

/// `blocks` over standard simplification, which orders collapses only by their errors.
pub(super) struct LevelStrips {
    sequence: Arc<CollapseSequence>,
    model: Arc<Blocks>,
}

impl LevelStrips {
    pub(super) fn build(mesh: &Mesh, strips: &Strips) -> Result<Self, Failure> {
        let simplified = simplify_triangles(mesh, strips.to_list(), &SimplifyOptions::default())?;
        let sequence = Arc::new(simplified.sequence);
        let model = Blocks::new(strips, Arc::clone(&sequence), &BlockOptions::default())?;
        Ok(Self { sequence, model: Arc::new(model) })
    }
}

pub(super) struct LevelsAlternative<'a> {
    sequence: &'a CollapseSequence,
    model: &'a Blocks,
    cursor: BlocksCursor<u32>,
    pixels: f32,
}

impl<'a> LevelsAlternative<'a> {
    pub(super) fn new(levels: &'a LevelStrips, criteria: &ViewCriteria) -> Result<Self, Failure> {
        let cursor = levels.model.cursor()?;
        Ok(Self { sequence: &levels.sequence, model: &levels.model, cursor, pixels: criteria.pixels })
    }
}

impl Alternative for LevelsAlternative<'_> {
    fn name(&self) -> &'static str {
        "blocks, one level"
    }

    fn surface(&self) -> &'static str {
        "level"
    }

    fn follow(&mut self, frame: &Frame) -> Result<(), Failure> {
        let Some(nearest) = frame.nearest else {
            // No vertex is visible.
            return Ok(self.cursor.set_level(0)?);
        };
        let view =
            View::of_camera(nearest as f32, frame.camera.field_of_view(), frame.camera.image()[1] as f32)?;
        self.cursor.follow_pixels(self.pixels, view, Hysteresis::default())?;
        Ok(())
    }

    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure> {
        let level = self.cursor.level();
        let error = self.cursor.levels().error(level)?;
        let drawn = Drawn::of_strips(self.cursor.strips(), frame.pixels_at_nearest(error.into()));
        if sorted(drawn.triangles.iter().copied()) != sorted(self.sequence.drawn(level)?) {
            return Err("blocks draw other triangles than their level has".into());
        }
        Ok(drawn)
    }

    fn bytes(&self) -> [usize; 2] {
        [self.model.memory(), size_of_val(self.cursor.indices())]
    }
}
