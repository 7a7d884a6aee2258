//! The metrics of strips, as reports have them.

use serde::Serialize;
use tristrip::vertex_cache::VertexCache;

/// The metrics of the strips of a model; the keys are those of the JSON report. Ratios are rounded to six decimals.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct StripMetrics {
    /// Real triangles.
    pub triangles: usize,
    /// Number of strips.
    pub strips: usize,
    /// Strips of one triangle.
    pub isolated: usize,
    /// Vertices repeated inside strips.
    pub swaps: usize,
    /// Vertices sent, swaps and winding repeats included (OpenGL cost).
    pub vertices_sent: usize,
    /// Vertices sent with free swaps (GL cost).
    pub gl_cost: usize,
    /// Indices with a restart between strips.
    pub indices_restart: usize,
    /// Indices of the strips joined by degenerate triangles.
    pub indices_degenerate: usize,
    /// Vertices sent per triangle.
    pub vertices_per_triangle: f64,
    /// Indices with restarts per triangle.
    pub indices_restart_per_triangle: f64,
    /// Indices with degenerate joins per triangle.
    pub indices_degenerate_per_triangle: f64,
    /// Misses per triangle of a FIFO vertex cache of 16 entries.
    pub acmr_fifo_16: f64,
    /// Misses per triangle of a FIFO vertex cache of 32 entries.
    pub acmr_fifo_32: f64,
    /// Misses per used vertex of a FIFO vertex cache of 16 entries.
    pub atvr_fifo_16: f64,
    /// Misses per used vertex of a FIFO vertex cache of 32 entries.
    pub atvr_fifo_32: f64,
    /// Misses per triangle of the vertex cache that the method optimizes for; `None` for other methods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acmr: Option<f64>,
    /// Misses per used vertex of the vertex cache that the method optimizes for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub atvr: Option<f64>,
    /// The vertex cache that the method optimizes for, and its misses.
    #[serde(skip)]
    pub optimized_cache: Option<(VertexCache, usize)>,
    /// Misses of a FIFO vertex cache of 16 entries.
    #[serde(skip)]
    pub misses_fifo_16: usize,
    /// Misses of a FIFO vertex cache of 32 entries.
    #[serde(skip)]
    pub misses_fifo_32: usize,
}

/// Rounds a ratio to six decimals, the precision of reports.
///
/// ```
/// assert_eq!(tristrip_pipeline::rounded(2.0 / 3.0).to_string(), "0.666667");
/// ```
pub fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}
