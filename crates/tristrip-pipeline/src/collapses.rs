//! What the collapses of a whole model reached.

use serde::Serialize;
use tristrip::simplify::Stopped;

use crate::metrics::rounded;

/// The collapses of a model, summed over its parts; the keys are those of the JSON report.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Collapses {
    /// The requested number of triangles; `None` for no limit.
    pub target_triangles: Option<usize>,
    /// The maximum error in the scene; `None` for no limit.
    pub target_error: Option<f32>,
    /// Whether there are at most as many triangles as requested.
    pub reached: bool,
    /// Triangles of the source.
    pub triangles_before: usize,
    /// Triangles of the result.
    pub triangles_after: usize,
    /// The number of collapses. Those of several parts that close a border together count once.
    #[serde(rename = "collapses")]
    pub collapse_count: usize,
    /// The greatest error of a collapse in the scene, where the part has the largest scale.
    pub surface_error: f32,
    /// The same in percent of the diagonal.
    pub surface_error_percent: f64,
    /// The diagonal of the bounding box of all triangles in the scene.
    pub diagonal: f64,
    /// Small components that vanished within the error limit.
    pub vanished_components: usize,
    /// Vertices that were kept because they touch parts in other places of the scene.
    pub locked_vertices: usize,
    /// The number of vertices by the reason for which they were kept, where there are more triangles than requested; `None` where the
    /// goal was reached.
    pub vertices_kept: Option<KeptVertices>,
}

/// The numbers of vertices by the reason for which a simplification kept them, each counted once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct KeptVertices {
    /// The error would be too large.
    pub error: usize,
    /// They are locked.
    pub locked: usize,
    /// They are on seams of attributes.
    pub seam: usize,
    /// Their edges have more than two faces.
    pub non_manifold: usize,
    /// The surface would tear.
    pub topology: usize,
    /// A triangle would flip.
    pub fold_over: usize,
}

impl From<Stopped> for KeptVertices {
    fn from(stopped: Stopped) -> Self {
        let Stopped { error, locked, seam, non_manifold, topology, fold_over, .. } = stopped;
        Self { error, locked, seam, non_manifold, topology, fold_over }
    }
}

/// Returns a distance in percent of a model's diagonal.
pub(crate) fn percent_of(distance: f64, diagonal: f64) -> f64 {
    if diagonal > 0.0 { rounded(100.0 * distance / diagonal) } else { 0.0 }
}
