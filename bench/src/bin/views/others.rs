//! Alternatives to Skip Strips in the same run: the time and the vertices sent for the same frames
//! of a flight.
//!
//! ```text
//! frames of a flight ─▶ Alternative: follow (timed in every frame), finish (timed in samples)
//!                         ─▶ Drawn, proven ─▶ a row of the table
//! skip     display strips, repaired strips, a list of the same triangles
//! levels   `blocks` at one level of the whole model
//! rival    meshoptimizer: the whole model simplified per frame
//! cut      meshoptimizer's clusterlod: a cut through a cluster hierarchy
//! ```

mod alternative;
mod cut;
mod levels;
mod report;
mod rival;
mod skip;

use std::collections::HashMap;
use std::time::Instant;

use tristrip::Mesh;
use tristrip::lod::ViewCriteria;
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::median;

use crate::building::BuiltModel;
use crate::clusters::ClusterHierarchy;
use crate::distance::SurfacePoints;
use crate::frames::Frame;
use crate::proof::Borders;
pub(super) use alternative::OtherFigures;
use alternative::{Alternative, Drawn};
use cut::{CutAlternative, Detail};
use levels::{LevelStrips, LevelsAlternative};
pub(super) use report::{best, page, table};
use rival::{Order, SimplifyAlternative};
pub(super) use skip::REPAIRED;
use skip::{DisplayAlternative, ListAlternative, RepairedAlternative};

/// The data of a model for all alternatives, built once.
pub(super) struct Others {
    levels: LevelStrips,
    clusters: ClusterHierarchy,
    borders: Borders,
    points: SurfacePoints,
}

impl Others {
    /// Builds the data for the alternatives.
    pub(super) fn build(built: &BuiltModel) -> Result<Self, Failure> {
        Ok(Self {
            levels: LevelStrips::build(&built.mesh, &built.strips)?,
            clusters: ClusterHierarchy::build(&built.mesh)?,
            borders: Borders::of(&built.mesh)?,
            points: SurfacePoints::of(&built.mesh),
        })
    }
}

/// Draws the frames of a flight with all alternatives.
pub(super) fn fly_all(
    flight: &'static str,
    built: &BuiltModel,
    others: &Others,
    frames: &[Frame],
    criteria: &ViewCriteria,
) -> Result<Vec<OtherFigures>, Failure> {
    let cut = |detail| CutAlternative::new(&others.clusters, &others.borders, criteria, detail);
    let mut alternatives: Vec<Box<dyn Alternative>> = vec![
        Box::new(DisplayAlternative::new(built, criteria)),
        Box::new(RepairedAlternative::new(built, criteria)?),
        Box::new(ListAlternative::new(built, criteria)),
        Box::new(LevelsAlternative::new(&others.levels, criteria)?),
        Box::new(SimplifyAlternative::new(&built.mesh, Order::Strips)?),
        Box::new(SimplifyAlternative::new(&built.mesh, Order::Cache)?),
        Box::new(cut(Detail::Allowed)),
        Box::new(cut(Detail::AsMany)),
    ];
    let mut run = Run {
        flight,
        mesh: &built.mesh,
        frames,
        points: &others.points,
        allowed: criteria.pixels.into(),
        measured: HashMap::new(),
    };
    alternatives.iter_mut().map(|alternative| run.fly(&mut **alternative)).collect()
}

/// A flight that all alternatives draw.
struct Run<'a> {
    flight: &'static str,
    mesh: &'a Mesh,
    frames: &'a [Frame],
    points: &'a SurfacePoints,
    allowed: f64,
    /// The measured distances in pixels, by surface and frame.
    measured: HashMap<(&'static str, usize), [f64; 2]>,
}

impl Run<'_> {
    fn fly(&mut self, alternative: &mut dyn Alternative) -> Result<OtherFigures, Failure> {
        let name = alternative.name();
        let say = |error: Failure| -> Failure { format!("{}, {name}: {error}", self.flight).into() };
        let (mut following, mut finishing, mut drawn, mut measured) = (vec![], vec![], vec![], vec![]);
        for (number, frame) in self.frames.iter().enumerate() {
            let start = Instant::now();
            alternative.follow(frame).map_err(say)?;
            if number > 0 {
                following.push(1e3 * start.elapsed().as_secs_f64());
            }
            if frame.is_sample {
                let start = Instant::now();
                alternative.finish(frame).map_err(say)?;
                finishing.push(1e3 * start.elapsed().as_secs_f64());
                let of_frame = alternative.drawn(frame).map_err(say)?;
                let pixels = || self.points.pixels(frame, self.mesh, &of_frame.triangles);
                let key = (alternative.surface(), number);
                measured.push(*self.measured.entry(key).or_insert_with(pixels));
                drawn.push(of_frame);
            }
        }
        let median_of = |figure: fn(&Drawn) -> f64| median(drawn.iter().map(figure).collect());
        let per_triangle =
            |vertices: usize, drawn: &Drawn| vertices as f64 / drawn.triangles.len().max(1) as f64;
        Ok(OtherFigures {
            flight: self.flight,
            name,
            triangles: median_of(|drawn| drawn.triangles.len() as f64),
            vertices_sent: median_of(|drawn| drawn.vertices_sent as f64),
            fraction: median(
                drawn.iter().map(|drawn| per_triangle(drawn.vertices_sent, drawn) / 3.0).collect(),
            ),
            transformed: median(drawn.iter().map(|drawn| per_triangle(drawn.transformed, drawn)).collect()),
            milliseconds: median(following) + median(finishing),
            bytes: alternative.bytes().map(|bytes| bytes as f64 / self.mesh.vertex_count().max(1) as f64),
            allowed: self.allowed,
            stated: median_of(|drawn| drawn.pixels),
            measured: [0, 1].map(|i| median(measured.iter().map(|pixels| pixels[i]).collect())),
        })
    }
}
