//! What the collapses of a whole model reached.

use tristrip::simplify::Stopped;

use crate::figures::rounded;

/// The collapses of a model, summed over its parts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Collapses {
    /// The number of collapses; those of several parts that close a border together are one.
    pub collapse_count: usize,
    /// Triangles of the source.
    pub triangles_before: usize,
    /// Triangles of the result.
    pub triangles_after: usize,
    /// The requested number of triangles; `None` for no limit.
    pub target_triangles: Option<usize>,
    /// The maximum error in the scene; `None` for no limit.
    pub target_error: Option<f32>,
    /// Whether there are at most as many triangles as requested.
    pub reached: bool,
    /// The greatest error of a collapse in the scene, where the part has the largest scale.
    pub surface_error: f32,
    /// The reasons for which vertices stayed, where there are more triangles than requested; `None` where the goal was reached.
    pub stopped: Option<Stopped>,
    /// The diagonal of the bounding box of all triangles in the scene.
    pub diagonal: f64,
    /// Small components that vanished within the error limit.
    pub vanished_components: usize,
    /// Vertices that stayed because they touch parts in other places of the scene.
    pub locked_vertices: usize,
}

impl Collapses {
    /// Returns the greatest error in percent of the diagonal.
    pub fn surface_error_percent(&self) -> f64 {
        percent_of(self.surface_error, self.diagonal)
    }
}

/// Returns a distance in percent of a model's diagonal.
pub(crate) fn percent_of(distance: f32, diagonal: f64) -> f64 {
    if diagonal > 0.0 { rounded(100.0 * f64::from(distance) / diagonal) } else { 0.0 }
}
