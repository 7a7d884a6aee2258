//! Skip Strips with display strips, with repaired strips, and as a triangle list.

use tristrip::Effort;
use tristrip::lod::{RepairOptions, RepairedView, SkipView, ViewCriteria};
use tristrip_bench::failure::Failure;

use super::alternative::{Alternative, Drawn};
use crate::building::BuiltModel;

use crate::frames::Frame;
use crate::proof::sorted;

/// The display strips of `dtfs`.
pub(super) struct DisplayAlternative {
    view: SkipView,
    criteria: ViewCriteria,
}

impl DisplayAlternative {
    pub(super) fn new(built: &BuiltModel, criteria: &ViewCriteria) -> Self {
        Self { view: built.model.view(), criteria: *criteria }
    }
}

impl Alternative for DisplayAlternative {
    fn name(&self) -> &'static str {
        "Skip Strips, dtfs"
    }

    fn surface(&self) -> &'static str {
        "view"
    }

    fn follow(&mut self, frame: &Frame) -> Result<(), Failure> {
        self.view.update(&frame.camera, &self.criteria)?;
        Ok(())
    }

    fn drawn(&mut self, _frame: &Frame) -> Result<Drawn, Failure> {
        let strips = self.view.display_strips();
        if sorted(strips.triangles()) != sorted(self.view.renamed_triangles()) {
            return Err("display strips draw other triangles".into());
        }
        Ok(Drawn::of_strips(&strips, self.criteria.pixels.into()))
    }

    fn bytes(&self) -> [usize; 2] {
        [self.view.model().memory_by_part().iter().sum(), self.view.memory()]
    }
}

/// The name of repaired strips.
pub(crate) const REPAIRED: &str = "Skip Strips, repaired";
/// The effort of repaired strips.
const EFFORT: u8 = 3;

/// Strips that are repaired from frame to frame.
pub(super) struct RepairedAlternative {
    view: RepairedView,
    criteria: ViewCriteria,
}

impl RepairedAlternative {
    pub(super) fn new(built: &BuiltModel, criteria: &ViewCriteria) -> Result<Self, Failure> {
        let options = RepairOptions::default().with_effort(Effort::new(EFFORT).unwrap_or_default());
        let view = RepairedView::new(&built.model, &built.strips, built.sequence.clone(), options)?;
        Ok(Self { view, criteria: *criteria })
    }
}

impl Alternative for RepairedAlternative {
    fn name(&self) -> &'static str {
        REPAIRED
    }

    fn surface(&self) -> &'static str {
        "view"
    }

    fn follow(&mut self, frame: &Frame) -> Result<(), Failure> {
        self.view.update(&frame.camera, &self.criteria)?;
        self.view.strips();
        Ok(())
    }

    fn drawn(&mut self, _frame: &Frame) -> Result<Drawn, Failure> {
        let drawn = Drawn::of_strips(self.view.strips(), self.criteria.pixels.into());
        if sorted(drawn.triangles.iter().copied()) != sorted(self.view.view().renamed_triangles()) {
            return Err("repaired strips draw other triangles".into());
        }
        Ok(drawn)
    }

    fn bytes(&self) -> [usize; 2] {
        [self.view.view().model().memory_by_part().iter().sum(), self.view.memory()]
    }
}

/// The triangles of the view as a list, rewritten in each frame.
pub(super) struct ListAlternative {
    view: SkipView,
    criteria: ViewCriteria,
    triangles: Vec<[u32; 3]>,
}

impl ListAlternative {
    pub(super) fn new(built: &BuiltModel, criteria: &ViewCriteria) -> Self {
        Self { view: built.model.view_without_strips(), criteria: *criteria, triangles: Vec::new() }
    }
}

impl Alternative for ListAlternative {
    fn name(&self) -> &'static str {
        "the same triangles, a list"
    }

    fn surface(&self) -> &'static str {
        "view"
    }

    fn follow(&mut self, frame: &Frame) -> Result<(), Failure> {
        self.view.update(&frame.camera, &self.criteria)?;
        Ok(())
    }

    fn finish(&mut self, _frame: &Frame) -> Result<(), Failure> {
        self.triangles = self.view.renamed_triangles();
        Ok(())
    }

    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure> {
        if self.triangles.len() != frame.triangle_count {
            return Err("the list has other triangles than the view with strips".into());
        }
        Ok(Drawn::of_list(self.triangles.clone(), self.criteria.pixels.into()))
    }

    fn bytes(&self) -> [usize; 2] {
        let model = self.view.model().memory_by_part().iter().sum();
        [model, self.view.memory() + size_of_val(&self.triangles[..])]
    }
}
