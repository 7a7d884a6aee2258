//! The figures of a simplification, with the keys of the JSON report.

use serde::Serialize;
use tristrip::simplify::Stopped;

use super::Simplified;
use super::normals::NormalCounts;
use crate::collapses::Collapses;
use crate::figures::rounded;
use crate::surface_change::SurfaceChange;

/// The figures of a simplification; `None` for those of a stage that did not run.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct SimplifyFigures {
    /// The requested number of triangles; `None` for no limit.
    pub target_triangles: Option<usize>,
    /// The maximum error in mesh units; `None` for no limit.
    pub target_error: Option<f32>,
    /// Whether there are at most as many triangles as requested.
    pub reached: Option<bool>,
    /// Triangles of the source.
    pub triangles_before: Option<usize>,
    /// Triangles of the result.
    pub triangles_after: Option<usize>,
    /// Used vertices of the source.
    pub vertices_before: Option<usize>,
    /// Used vertices of the result.
    pub vertices_after: Option<usize>,
    /// The number of collapses.
    pub collapses: Option<usize>,
    /// The number of positions that a fit moved; `None` without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moved_positions: Option<usize>,
    /// The greatest error of a collapse, in mesh units.
    pub surface_error: Option<f32>,
    /// The same in percent of the diagonal.
    pub surface_error_percent: Option<f64>,
    /// The largest distance from the original surface found, in mesh units.
    pub largest_deviation: Option<f64>,
    /// The same in percent of the diagonal.
    pub largest_deviation_percent: Option<f64>,
    /// The root mean square of the distances, in mesh units.
    pub rms_deviation: Option<f64>,
    /// The same in percent of the diagonal.
    pub rms_deviation_percent: Option<f64>,
    /// The root mean square of the angles between normals.
    pub normal_deviation_degrees: Option<f64>,
    /// The root mean square of the distances between texture coordinates, in percent of the texture; `None` without any.
    pub uv_deviation_percent: Option<f64>,
    /// The same in texels of the textures of the base colours; `None` without any.
    pub uv_deviation_texels: Option<f64>,
    /// The numbers of parts by what happened to their normals.
    pub normals: Option<NormalCounts>,
    /// The diagonal of the model's bounding box, in mesh units.
    pub diagonal: Option<f64>,
    /// Small components that vanished within the error limit.
    pub vanished_components: Option<usize>,
    /// Vertices that stayed because they touch parts in other places of the scene.
    pub locked_vertices: Option<usize>,
    /// The number of parts.
    pub parts: Option<usize>,
    /// The number of vertices by the reason for which they stayed; `None` where the goal was reached.
    pub stopped: Option<StoppedReport>,
    /// A sentence on the goal, if it was not reached.
    pub warning: Option<String>,
}

/// The numbers of vertices by the reason for which they stayed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct StoppedReport {
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

impl From<Stopped> for StoppedReport {
    fn from(stopped: Stopped) -> Self {
        let Stopped { error, locked, seam, non_manifold, topology, fold_over, .. } = stopped;
        Self { error, locked, seam, non_manifold, topology, fold_over }
    }
}

impl SimplifyFigures {
    /// Takes over all figures of a result.
    ///
    /// ```
    /// use tristrip_io::{Format, read};
    /// use tristrip_pipeline::{Amount, Goal, SimplifyFigures, SimplifyOptions, simplify};
    /// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
    /// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
    /// let goal = Goal { amount: Some(Amount::Triangles(2)), ..Goal::default() };
    /// let figures = SimplifyFigures::of(&simplify(&model, &SimplifyOptions::new(goal))?);
    /// assert_eq!((figures.vertices_before, figures.vertices_after, figures.reached), (Some(5), Some(4), Some(true)));
    /// # Ok::<(), tristrip_pipeline::Error>(())
    /// ```
    pub fn of(simplified: &Simplified) -> Self {
        let mut figures = Self::default();
        figures.record(&simplified.collapses);
        if let Some(change) = &simplified.change {
            figures.compare(change);
        }
        figures.vertices_before = Some(simplified.mesh.vertices - simplified.mesh.unreferenced_vertices);
        figures.vertices_after = Some(simplified.redrawn.used);
        figures.moved_positions = simplified.moved_positions;
        figures.normals = Some(simplified.normals);
        figures.parts = Some(simplified.redrawn.model.parts.len());
        figures.warning.clone_from(&simplified.warning);
        figures
    }

    /// Takes over what the collapses reached.
    pub fn record(&mut self, collapses: &Collapses) {
        self.target_triangles = collapses.target_triangles;
        self.target_error = collapses.target_error;
        self.reached = Some(collapses.reached);
        self.triangles_before = Some(collapses.triangles_before);
        self.triangles_after = Some(collapses.triangles_after);
        self.collapses = Some(collapses.collapse_count);
        self.surface_error = Some(collapses.surface_error);
        self.surface_error_percent = Some(collapses.surface_error_percent());
        self.diagonal = Some(collapses.diagonal);
        self.vanished_components = Some(collapses.vanished_components);
        self.locked_vertices = Some(collapses.locked_vertices);
        self.stopped = collapses.stopped.map(StoppedReport::from);
    }

    /// Takes over how far the surface is from the original; after [`SimplifyFigures::record`], which has the diagonal.
    pub fn compare(&mut self, change: &SurfaceChange) {
        let diagonal = self.diagonal.filter(|&diagonal| diagonal > 0.0);
        let percent =
            |distance: f64| Some(rounded(diagonal.map_or(0.0, |diagonal| 100.0 * distance / diagonal)));
        self.largest_deviation = Some(rounded(change.largest));
        self.largest_deviation_percent = percent(change.largest);
        self.rms_deviation = Some(rounded(change.rms));
        self.rms_deviation_percent = percent(change.rms);
        self.normal_deviation_degrees = Some(rounded(change.normal_degrees));
        self.uv_deviation_percent = change.uv.map(|uv| rounded(100.0 * uv));
        self.uv_deviation_texels = change.uv_texels.map(rounded);
    }
}
