//! Other ways to the same picture, in the same run: what the frames of a flight take and send if they are not drawn by Skip Strips.
//!
//! ```text
//! frames of a flight ─▶ Alternative: follow (timed in every frame), finish (timed in samples) ─▶ Drawn, proven ─▶ a row of the table
//!                         skip       display strips, repaired strips, a list of the same triangles
//!                         levels     `blocks` at one level of the whole model
//!                         rival      meshoptimizer: the whole model simplified per frame
//!                         cut        meshoptimizer's clusterlod: a cut through a hierarchy of clusters
//! ```

mod cut;
mod levels;
mod rival;
mod skip;

use std::time::Instant;

use tristrip::lod::ViewCriteria;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Mesh, Strips};
use tristrip_bench::failure::Failure;
use tristrip_bench::measure::median;
use tristrip_bench::text::Table;

use crate::building::BuiltModel;
use crate::clusters::{Borders, ClusterHierarchy};
use crate::frames::Frame;
use cut::CutAlternative;
use levels::{LevelStrips, LevelsAlternative};
use rival::{Order, SimplifyAlternative};
use skip::{DisplayAlternative, ListAlternative, RepairedAlternative};

/// The vertex cache by which transformed vertices are counted.
const CACHE: VertexCache = VertexCache::fifo(16);

/// What the page says before the table.
pub(super) const TEXT: &str = "\
The same frames, drawn in other ways in the same run: medians over sampled frames, times over all frames but the first where a frame is short.
";

/// A way to draw the frames of a flight.
trait Alternative {
    /// Returns the name that the table shows.
    fn name(&self) -> &'static str;

    /// Moves from the frame before to this one. Timed in every frame but the first.
    fn follow(&mut self, frame: &Frame) -> Result<(), Failure>;

    /// Does what else a frame takes before it can be drawn. Timed in samples only, because it takes long.
    fn finish(&mut self, _frame: &Frame) -> Result<(), Failure> {
        Ok(())
    }

    /// Proves what is drawn, and returns it.
    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure>;

    /// Returns the bytes of the model, and of a view of it.
    fn bytes(&self) -> [usize; 2];
}

/// What is drawn in a frame.
struct Drawn {
    triangles: Vec<[u32; 3]>,
    vertices_sent: usize,
    /// The vertices that a graphics processor transforms.
    transformed: usize,
    /// The error that the alternative states, in pixels.
    pixels: f64,
}

impl Drawn {
    fn of_strips(strips: &Strips, pixels: f64) -> Self {
        Self {
            triangles: strips.triangles().collect(),
            vertices_sent: strips.vertices_sent(),
            transformed: VertexCacheStatistics::of(strips, CACHE, FlushPolicy::Keep).misses,
            pixels,
        }
    }

    fn of_list(triangles: Vec<[u32; 3]>, pixels: f64) -> Self {
        let transformed = VertexCacheStatistics::of_list(&triangles, CACHE).misses;
        Self { vertices_sent: 3 * triangles.len(), triangles, transformed, pixels }
    }
}

/// What the alternatives to Skip Strips need of a model, built once.
pub(super) struct Others {
    levels: LevelStrips,
    clusters: ClusterHierarchy,
    borders: Borders,
}

impl Others {
    /// Builds what the alternatives need.
    pub(super) fn build(built: &BuiltModel) -> Result<Self, Failure> {
        Ok(Self {
            levels: LevelStrips::build(&built.mesh, &built.strips)?,
            clusters: ClusterHierarchy::build(&built.mesh)?,
            borders: Borders::of(&built.mesh)?,
        })
    }
}

/// What was measured of an alternative in a flight: medians.
pub(super) struct OtherFigures {
    flight: &'static str,
    name: &'static str,
    triangles: f64,
    vertices_sent: f64,
    transformed: f64,
    milliseconds: f64,
    /// Bytes per vertex of the full mesh, of the model and of a view.
    bytes: [f64; 2],
    /// The error that the alternative states, in pixels.
    pixels: f64,
}

/// Draws the frames of a flight in all ways.
pub(super) fn fly_all(
    flight: &'static str,
    built: &BuiltModel,
    others: &Others,
    frames: &[Frame],
    criteria: &ViewCriteria,
) -> Result<Vec<OtherFigures>, Failure> {
    let mut alternatives: Vec<Box<dyn Alternative>> = vec![
        Box::new(DisplayAlternative::new(built, criteria)),
        Box::new(RepairedAlternative::new(built, criteria)?),
        Box::new(ListAlternative::new(built, criteria)),
        Box::new(LevelsAlternative::new(&others.levels, criteria)?),
        Box::new(SimplifyAlternative::new(&built.mesh, Order::Strips)?),
        Box::new(SimplifyAlternative::new(&built.mesh, Order::Cache)?),
        Box::new(CutAlternative::new(&others.clusters, &others.borders, criteria)),
    ];
    let fly = |alternative: &mut Box<dyn Alternative>| fly(flight, &mut **alternative, &built.mesh, frames);
    alternatives.iter_mut().map(fly).collect()
}

fn fly(
    flight: &'static str,
    alternative: &mut dyn Alternative,
    mesh: &Mesh,
    frames: &[Frame],
) -> Result<OtherFigures, Failure> {
    let (mut following, mut finishing, mut drawn) = (Vec::new(), Vec::new(), Vec::new());
    for (number, frame) in frames.iter().enumerate() {
        let start = Instant::now();
        alternative.follow(frame)?;
        if number > 0 {
            following.push(1e3 * start.elapsed().as_secs_f64());
        }
        if frame.is_sample {
            let start = Instant::now();
            alternative.finish(frame)?;
            finishing.push(1e3 * start.elapsed().as_secs_f64());
            drawn.push(alternative.drawn(frame)?);
        }
    }
    let median_of = |figure: &dyn Fn(&Drawn) -> f64| median(drawn.iter().map(figure).collect::<Vec<_>>());
    Ok(OtherFigures {
        flight,
        name: alternative.name(),
        triangles: median_of(&|drawn| drawn.triangles.len() as f64),
        vertices_sent: median_of(&|drawn| drawn.vertices_sent as f64),
        transformed: median_of(&|drawn| drawn.transformed as f64),
        milliseconds: median(following) + median(finishing),
        bytes: alternative.bytes().map(|bytes| bytes as f64 / mesh.vertex_count() as f64),
        pixels: median_of(&|drawn| drawn.pixels),
    })
}

/// Returns a row per flight and alternative.
pub(super) fn table<'a>(figures: impl IntoIterator<Item = &'a OtherFigures>) -> Table {
    let heads = [
        "flight",
        "drawn by",
        "triangles",
        "vertices sent",
        "of 3 T",
        "transformed / T",
        "ms",
        "bytes",
        "view bytes",
        "stated px",
    ];
    let mut table = Table::new(2, &heads);
    for row in figures {
        table.push(vec![
            row.flight.into(),
            row.name.into(),
            format!("{:.0}", row.triangles),
            format!("{:.0}", row.vertices_sent),
            format!("{:.3}", row.vertices_sent / (3.0 * row.triangles)),
            format!("{:.3}", row.transformed / row.triangles),
            format!("{:.3}", row.milliseconds),
            format!("{:.1}", row.bytes[0]),
            format!("{:.1}", row.bytes[1]),
            format!("{:.3}", row.pixels),
        ]);
    }
    table
}
