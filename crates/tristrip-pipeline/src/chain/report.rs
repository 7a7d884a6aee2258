//! The levels of a chain with the keys of the JSON report.

use serde::Serialize;

use super::{Chain, ChainLevel};

/// A level.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LevelReport {
    /// The number of the level; 0 is the finest.
    pub level: usize,
    /// The ratio of triangles requested.
    pub ratio: f64,
    /// The number of triangles requested.
    pub target_triangles: usize,
    /// The number of triangles drawn.
    pub triangles: usize,
    /// The number of vertices, from the first on, that the level uses.
    pub vertices: usize,
    /// The greatest error of the collapses of the level, in mesh units.
    pub surface_error: f32,
    /// The same in percent of the diagonal of the model.
    pub surface_error_percent: f64,
    /// The ratio of the screen that the model's bounding sphere covers, down to which the level is drawn.
    pub screen_coverage: f64,
    /// Whether there are at most as many triangles as requested.
    pub reached: bool,
    /// The size of the level's file, or of the indices and vertices that it uses of a file with all levels.
    pub bytes: Option<usize>,
    /// The file of the level; `None` where one file has all levels.
    pub output: Option<String>,
}

impl LevelReport {
    fn new(number: usize, level: &ChainLevel) -> Self {
        Self {
            level: number,
            ratio: level.ratio.value(),
            target_triangles: level.target_triangles,
            triangles: level.triangles,
            vertices: level.vertices,
            surface_error: level.surface_error,
            surface_error_percent: level.surface_error_percent,
            screen_coverage: level.screen_coverage,
            reached: level.reached,
            bytes: None,
            output: None,
        }
    }
}

impl Chain {
    /// Reports the levels, which are in no file yet.
    pub fn level_reports(&self) -> Vec<LevelReport> {
        (0..).zip(&self.levels).map(|(number, level)| LevelReport::new(number, level)).collect()
    }
}
