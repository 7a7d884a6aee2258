//! An alternative way to draw the frames of a flight, its output, and its measurements.

use tristrip::Strips;
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip_bench::failure::Failure;

use crate::frames::Frame;

/// The vertex cache for counting transformed vertices.
const CACHE: VertexCache = VertexCache::fifo(16);

/// An alternative way to draw the frames of a flight.
pub(super) trait Alternative {
    /// Returns the name in the table.
    fn name(&self) -> &'static str;

    /// Moves from the previous frame to this one. Timed in every frame but the first.
    fn follow(&mut self, frame: &Frame) -> Result<(), Failure>;

    /// Does the remaining work before a frame can be drawn. Timed only in samples, because it is
    /// slow.
    fn finish(&mut self, _frame: &Frame) -> Result<(), Failure> {
        Ok(())
    }

    /// Returns the name of the drawn surface. Alternatives with the same name draw the same
    /// triangles in a frame.
    fn surface(&self) -> &'static str;

    /// Proves the drawn triangles, and returns them.
    fn drawn(&mut self, frame: &Frame) -> Result<Drawn, Failure>;

    /// Returns the size of the model, and of a view of it, in bytes.
    fn bytes(&self) -> [usize; 2];
}

/// The drawn data of a frame.
pub(super) struct Drawn {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) vertices_sent: usize,
    /// The number of vertices that a GPU transforms.
    pub(super) transformed: usize,
    /// The stated error of the alternative, in pixels.
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

/// The measurements of an alternative in a flight, as medians.
pub(crate) struct OtherFigures {
    pub(crate) flight: &'static str,
    pub(crate) name: &'static str,
    pub(crate) triangles: f64,
    pub(crate) vertices_sent: f64,
    /// The vertices sent, as a fraction of three per triangle.
    pub(crate) fraction: f64,
    /// The vertices transformed per triangle.
    pub(crate) transformed: f64,
    pub(crate) milliseconds: f64,
    /// The bytes per vertex of the full mesh, for the model and for a view.
    pub(crate) bytes: [f64; 2],
    /// The allowed error, and the stated error of the alternative, in pixels.
    pub(crate) allowed: f64,
    pub(crate) stated: f64,
    /// The root mean square and the maximum of the measured distances, in pixels.
    pub(crate) measured: [f64; 2],
}
