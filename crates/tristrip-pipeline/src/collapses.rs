//! The results of collapsing a whole model.

use serde::Serialize;
use tristrip::simplify::Stopped;

use crate::metrics::rounded;

/// The collapses of a model, summed over its parts. The field names are the keys of the JSON
/// report.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Collapses {
    /// The requested number of triangles of all parts; `None` if only an error was given.
    pub target_triangles: Option<usize>,
    /// The maximum allowed error of a collapse, in the units of the scene: the requested one, or 1
    /// % of `diagonal`. `None` for no limit.
    pub target_error: Option<f32>,
    /// Whether there are at most `target_triangles` triangles. If not, `warning` states the reason;
    /// this is not an error.
    pub reached: bool,
    /// The number of triangles of the input; a polygon counts as a fan.
    pub triangles_before: usize,
    /// The number of triangles of the result.
    pub triangles_after: usize,
    /// The number of half-edge collapses. Collapses on both sides of an attribute seam, or of a
    /// border between parts, count once.
    #[serde(rename = "collapses")]
    pub collapse_count: usize,
    /// The maximum error of a collapse in the scene, before vertices are moved. A part that is
    /// placed several times counts at its largest scale.
    pub surface_error: f32,
    /// `surface_error` in percent of `diagonal`.
    pub surface_error_percent: f64,
    /// The length of the diagonal of the bounding box of all triangles in the scene.
    pub diagonal: f64,
    /// The number of small components that were removed within the error limit.
    pub vanished_components: usize,
    /// The number of vertices that were kept because they touch a part placed by other nodes.
    pub locked_vertices: usize,
    /// The number of remaining vertices per reason for keeping them. Each vertex counts once.
    /// `None` if the goal was reached.
    pub vertices_kept: Option<KeptVertices>,
}

/// The number of vertices that a simplification kept, per reason. Each vertex counts once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct KeptVertices {
    /// Vertices whose removal would exceed the error limit.
    pub error: usize,
    /// Locked vertices.
    pub locked: usize,
    /// Vertices whose removal would open an attribute seam.
    pub seam: usize,
    /// Vertices at edges of more than two faces.
    pub non_manifold: usize,
    /// Vertices whose removal would close a hole or remove a component.
    pub topology: usize,
    /// Vertices whose removal would flip a triangle.
    pub fold_over: usize,
}

impl From<Stopped> for KeptVertices {
    fn from(stopped: Stopped) -> Self {
        let Stopped { error, locked, seam, non_manifold, topology, fold_over, .. } = stopped;
        Self { error, locked, seam, non_manifold, topology, fold_over }
    }
}

/// Returns a distance in percent of the diagonal of a model.
pub(crate) fn percent_of(distance: f64, diagonal: f64) -> f64 {
    if diagonal > 0.0 { rounded(100.0 * distance / diagonal) } else { 0.0 }
}
