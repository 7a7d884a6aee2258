//! The report of `tristrip level` and `tristrip camera-level`: the keys are those of the JSON output.

use serde::Serialize;
use tristrip_pipeline::{Figures, MethodReport, Stopped};

use crate::batch::{InputReport, Outcome};
use crate::task::LevelTask;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct LodSeconds {
    pub(crate) load: Option<f64>,
    pub(crate) dual: Option<f64>,
    pub(crate) stripify: Option<f64>,
    pub(crate) simplify: Option<f64>,
    pub(crate) filter: Option<f64>,
    pub(crate) verify: Option<f64>,
    pub(crate) write: Option<f64>,
}

/// The report of one input.
#[derive(Debug, Serialize)]
pub(crate) struct LodReport {
    pub(crate) file: String,
    #[serde(flatten)]
    pub(crate) method: MethodReport,
    pub(crate) model: String,
    pub(crate) filter: String,
    /// The effort of the filter `repair`.
    pub(crate) filter_effort: u8,
    pub(crate) proven: Option<bool>,
    pub(crate) seconds: LodSeconds,
    /// The number of collapses, which is the highest level.
    pub(crate) levels: Option<usize>,
    pub(crate) triangles_base: Option<usize>,
    pub(crate) triangles_full: Option<usize>,
    /// The level drawn.
    pub(crate) level: Option<usize>,
    pub(crate) surface_error: Option<f32>,
    pub(crate) surface_error_percent: Option<f64>,
    pub(crate) diagonal: Option<f64>,
    /// The surface error in pixels of the view, if there is one.
    pub(crate) pixels: Option<f64>,
    /// Figures of the display strips.
    #[serde(flatten)]
    pub(crate) figures: Option<Figures>,
    pub(crate) stopped: Option<Stopped>,
    pub(crate) parts: Option<usize>,
    pub(crate) notes: Vec<String>,
    pub(crate) output: Option<String>,
    pub(crate) layout: Option<&'static str>,
    pub(crate) error: Option<String>,
}

impl LodReport {
    /// Creates the report of an input that is yet to be processed.
    pub(crate) fn new(file: String, method: MethodReport, task: &LevelTask) -> Self {
        Self {
            file,
            method,
            model: task.model.name().into(),
            filter: task.filter.to_string(),
            filter_effort: task.filter_effort.level(),
            proven: None,
            seconds: LodSeconds::default(),
            levels: None,
            triangles_base: None,
            triangles_full: None,
            level: None,
            surface_error: None,
            surface_error_percent: None,
            diagonal: None,
            pixels: None,
            figures: None,
            stopped: None,
            parts: None,
            notes: Vec::new(),
            output: None,
            layout: None,
            error: None,
        }
    }
}

impl InputReport for LodReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}
