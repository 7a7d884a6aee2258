//! A cut through a hierarchy of clusters, by the same error in pixels. What is outside of the image is not drawn at all.

use tristrip::lod::ViewCriteria;
use tristrip_bench::failure::Failure;

use super::{Alternative, Drawn};
use crate::clusters::{Borders, ClusterHierarchy, Cut};
use crate::frames::Frame;

pub(super) struct CutAlternative<'a> {
    hierarchy: &'a ClusterHierarchy,
    borders: &'a Borders,
    pixels: f64,
    cut: Cut,
}

impl<'a> CutAlternative<'a> {
    pub(super) fn new(
        hierarchy: &'a ClusterHierarchy,
        borders: &'a Borders,
        criteria: &ViewCriteria,
    ) -> Self {
        Self { hierarchy, borders, pixels: criteria.pixels().into(), cut: Cut::default() }
    }

    fn choose(&self, frame: &Frame, is_culled: bool, cut: &mut Cut) {
        // The distance per length at which that length covers the allowed pixels.
        let needed = frame.pixels_per_slope / self.pixels;
        self.hierarchy.choose(
            |sphere, error| {
                let near = frame.distance(sphere.center) - f64::from(sphere.radius);
                f64::from(error) * needed <= near.max(0.0)
            },
            |sphere| !is_culled || frame.sees(sphere.center, sphere.radius),
            cut,
        );
    }
}

impl Alternative for CutAlternative<'_> {
    fn name(&self) -> &'static str {
        "meshopt clusterlod"
    }

    fn follow(&mut self, frame: &Frame) -> Result<(), Failure> {
        let mut cut = std::mem::take(&mut self.cut);
        self.choose(frame, true, &mut cut);
        self.cut = cut;
        Ok(())
    }

    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure> {
        let mut whole = Cut::default();
        self.choose(frame, false, &mut whole);
        let triangles: Vec<_> = self.hierarchy.strips(&whole).triangles().collect();
        let cracks = self.borders.cracks(&triangles);
        if cracks > 0 {
            return Err(format!("a cut of the clusters has {cracks} edges with one triangle").into());
        }
        let drawn = Drawn::of_strips(&self.hierarchy.strips(&self.cut), self.pixels);
        Ok(Drawn { transformed: self.hierarchy.vertex_count(&self.cut), ..drawn })
    }

    fn bytes(&self) -> [usize; 2] {
        [self.hierarchy.memory(), self.cut.memory()]
    }
}
