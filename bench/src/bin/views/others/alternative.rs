//! A way to draw the frames of a flight, what it draws, and what was measured of it.

use tristrip::Strips;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip_bench::failure::Failure;

use crate::frames::Frame;

/// The vertex cache by which transformed vertices are counted.
const CACHE: VertexCache = VertexCache::fifo(16);

/// A way to draw the frames of a flight.
pub(super) trait Alternative {
    /// Returns the name that the table shows.
    fn name(&self) -> &'static str;

    /// Moves from the frame before to this one. Timed in every frame but the first.
    fn follow(&mut self, frame: &Frame) -> Result<(), Failure>;

    /// Does what else a frame takes before it can be drawn. Timed in samples only, because it takes long.
    fn finish(&mut self, _frame: &Frame) -> Result<(), Failure> {
        Ok(())
    }

    /// Names the surface that is drawn: alternatives of one name draw the same triangles in a frame.
    fn surface(&self) -> &'static str;

    /// Proves what is drawn, and returns it.
    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure>;

    /// Returns the bytes of the model, and of a view of it.
    fn bytes(&self) -> [usize; 2];
}

/// What is drawn in a frame.
pub(super) struct Drawn {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) vertices_sent: usize,
    /// The vertices that a graphics processor transforms.
    pub(super) transformed: usize,
    /// The error that the alternative states, in pixels.
    pub(super) pixels: f64,
}

impl Drawn {
    pub(super) fn of_strips(strips: &Strips, pixels: f64) -> Self {
        Self {
            triangles: strips.triangles().collect(),
            vertices_sent: strips.vertices_sent(),
            transformed: VertexCacheStatistics::of(strips, CACHE, FlushPolicy::Keep).misses,
            pixels,
        }
    }

    pub(super) fn of_list(triangles: Vec<[u32; 3]>, pixels: f64) -> Self {
        let transformed = VertexCacheStatistics::of_list(&triangles, CACHE).misses;
        Self { vertices_sent: 3 * triangles.len(), triangles, transformed, pixels }
    }
}

/// What was measured of an alternative in a flight: medians.
pub(crate) struct OtherFigures {
    pub(crate) flight: &'static str,
    pub(crate) name: &'static str,
    pub(crate) triangles: f64,
    pub(crate) vertices_sent: f64,
    /// Vertices sent, as a fraction of three per triangle.
    pub(crate) fraction: f64,
    /// Vertices transformed per triangle.
    pub(crate) transformed: f64,
    pub(crate) milliseconds: f64,
    /// Bytes per vertex of the full mesh, of the model and of a view.
    pub(crate) bytes: [f64; 2],
    /// The error allowed, and the error that the alternative states, in pixels.
    pub(crate) allowed: f64,
    pub(crate) stated: f64,
    /// The root mean square and the maximum of the distances measured, in pixels.
    pub(crate) measured: [f64; 2],
}
