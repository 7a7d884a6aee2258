//! The metrics of strips, as they appear in reports.

use serde::Serialize;
use tristrip::vertex_cache::VertexCache;

/// The metrics of the strips of a model. The field names are the keys of the JSON report. Ratios
/// are rounded to six decimals.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StripMetrics {
    /// The number of triangles T that are drawn, without degenerate ones.
    pub triangles: usize,
    /// The number of strips S.
    pub strips: usize,
    /// The number of strips of one triangle.
    pub isolated: usize,
    /// The number of vertices repeated inside a strip or at its start.
    pub swaps: usize,
    /// The sum of the strip lengths, including swaps and winding repeats (OpenGL cost); at least T
    /// + 2.
    pub vertices_sent: usize,
    /// `vertices_sent` without swaps (GL cost).
    pub gl_cost: usize,
    /// The number of indices in layout `restart`, in one index buffer for all parts:
    /// `vertices_sent` + S − 1.
    pub indices_restart: usize,
    /// The number of indices in layout `degenerate`, in one index buffer per part.
    pub indices_degenerate: usize,
    /// `vertices_sent` divided by T.
    pub vertices_per_triangle: f64,
    /// `indices_restart` divided by T.
    pub indices_restart_per_triangle: f64,
    /// `indices_degenerate` divided by T.
    pub indices_degenerate_per_triangle: f64,
    /// Misses per triangle in a FIFO vertex cache of 16 entries, in drawing order. The cache is not
    /// flushed between strips.
    pub acmr_fifo_16: f64,
    /// Misses per triangle in a FIFO vertex cache of 32 entries.
    pub acmr_fifo_32: f64,
    /// Misses per used vertex in a FIFO vertex cache of 16 entries.
    pub atvr_fifo_16: f64,
    /// Misses per used vertex in a FIFO vertex cache of 32 entries.
    pub atvr_fifo_32: f64,
    /// Misses per triangle in the vertex cache that the method optimizes for; only for `cache`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acmr: Option<f64>,
    /// Misses per used vertex in the vertex cache that the method optimizes for; only for `cache`.
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
