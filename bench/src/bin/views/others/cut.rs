//! A cut through a cluster hierarchy. Clusters outside the image are not drawn.

use tristrip::lod::ViewCriteria;
use tristrip_bench::failure::Failure;

use super::alternative::{Alternative, Drawn};
use crate::clusters::{ClusterHierarchy, Cut};
use crate::frames::Frame;
use crate::proof::Borders;

/// The number of cuts that are tried to reach a number of triangles.
const CUTS: usize = 16;
/// The maximum error that is tried, relative to the allowed error.
const MAX_SCALE: f64 = 100.0;

/// The choice of the error in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Detail {
    /// The error that the criteria allow.
    Allowed,
    /// The minimum error at which a cut has no more triangles than the Skip Strips view.
    AsMany,
}

pub(super) struct CutAlternative<'a> {
    hierarchy: &'a ClusterHierarchy,
    borders: &'a Borders,
    detail: Detail,
    allowed: f64,
    /// The error of the cut.
    pixels: f64,
    cut: Cut,
}

impl<'a> CutAlternative<'a> {
    pub(super) fn new(
        hierarchy: &'a ClusterHierarchy,
        borders: &'a Borders,
        criteria: &ViewCriteria,
        detail: Detail,
    ) -> Self {
        let allowed = f64::from(criteria.pixels);
        Self { hierarchy, borders, detail, allowed, pixels: allowed, cut: Cut::default() }
    }
}

/// Chooses the clusters of a frame for an error in pixels.
fn choose(hierarchy: &ClusterHierarchy, frame: &Frame, pixels: f64, is_culled: bool, cut: &mut Cut) {
    let needed = frame.pixels_per_slope / pixels;
    hierarchy.choose(
        |sphere, error| {
            let near = frame.distance(sphere.center) - f64::from(sphere.radius);
            f64::from(error) * needed <= near.max(0.0)
        },
        |sphere| !is_culled || frame.sees(sphere.center, sphere.radius),
        cut,
    );
}

impl Alternative for CutAlternative<'_> {
    fn name(&self) -> &'static str {
        match self.detail {
            Detail::Allowed => "clusterlod",
            Detail::AsMany => "clusterlod, as many triangles",
        }
    }

    fn surface(&self) -> &'static str {
        self.name()
    }

    fn follow(&mut self, frame: &Frame) -> Result<(), Failure> {
        if self.detail == Detail::Allowed {
            choose(self.hierarchy, frame, self.pixels, true, &mut self.cut);
        }
        Ok(())
    }

    fn finish(&mut self, frame: &Frame) -> Result<(), Failure> {
        if self.detail == Detail::Allowed {
            return Ok(());
        }
        let (mut low, mut high) = (0.0, MAX_SCALE * self.allowed);
        for _ in 0..CUTS {
            let middle = f64::midpoint(low, high);
            choose(self.hierarchy, frame, middle, true, &mut self.cut);
            if self.hierarchy.triangle_count(&self.cut) > frame.triangle_count {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.pixels = high;
        choose(self.hierarchy, frame, high, true, &mut self.cut);
        Ok(())
    }

    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure> {
        let mut whole = Cut::default();
        choose(self.hierarchy, frame, self.pixels, false, &mut whole);
        let triangles: Vec<_> = self.hierarchy.strips(&whole).triangles().collect();
        let cracks = self.borders.cracks(&triangles);
        if cracks > 0 {
            return Err(format!("a cut of the clusters has {cracks} edges with one triangle").into());
        }
        let drawn = Drawn::of_strips(&self.hierarchy.strips(&self.cut), self.pixels);
        if drawn.triangles.len() != self.hierarchy.triangle_count(&self.cut) {
            return Err("the strips of a cut draw other triangles than its clusters have".into());
        }
        Ok(Drawn { transformed: self.hierarchy.vertex_count(&self.cut), ..drawn })
    }

    fn bytes(&self) -> [usize; 2] {
        [self.hierarchy.memory(), self.cut.memory()]
    }
}
