//! The report of `tristrip chain`: the keys are those of the JSON output.

use serde::Serialize;
use tristrip_pipeline::text::count;
use tristrip_pipeline::{Collapses, LevelReport, MethodReport};
use tristrip_render::text::{bytes, table};

use crate::batch::{InputReport, Outcome};

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct ChainSeconds {
    pub(crate) load: Option<f64>,
    pub(crate) dual: Option<f64>,
    pub(crate) simplify: Option<f64>,
    pub(crate) stripify: Option<f64>,
    pub(crate) verify: Option<f64>,
    pub(crate) write: Option<f64>,
}

/// The report of one input.
#[derive(Debug, Serialize)]
pub(crate) struct ChainReport {
    pub(crate) file: String,
    #[serde(flatten)]
    pub(crate) method: MethodReport,
    pub(crate) proven: Option<bool>,
    pub(crate) seconds: ChainSeconds,
    /// The maximum error in mesh units.
    pub(crate) target_error: Option<f32>,
    pub(crate) triangles_before: Option<usize>,
    /// Used vertices.
    pub(crate) vertices_before: Option<usize>,
    pub(crate) diagonal: Option<f64>,
    /// The levels, the finest first.
    pub(crate) chain: Vec<LevelReport>,
    pub(crate) locked_vertices: Option<usize>,
    pub(crate) parts: Option<usize>,
    /// A sentence on the levels that were not reached.
    pub(crate) warning: Option<String>,
    pub(crate) notes: Vec<String>,
    /// The file with all levels; `null` where each level has its own.
    pub(crate) output: Option<String>,
    pub(crate) layout: Option<&'static str>,
    pub(crate) error: Option<String>,
}

/// Returns the row of a level in the table.
fn row(level: &LevelReport) -> Vec<String> {
    let figures = &level.figures;
    vec![
        format!("  level {}", level.level),
        count(figures.triangles),
        count(figures.vertices),
        format!("{:.3} %", figures.surface_error_percent),
        format!("{:.2} %", 100.0 * figures.screen_coverage),
        level.bytes.map_or_else(|| "-".into(), bytes),
        if figures.reached {
            String::new()
        } else {
            format!("{} not reached", count(figures.target_triangles))
        },
    ]
}

impl ChainReport {
    /// Creates the report of an input that is yet to be processed.
    pub(crate) fn new(file: String, method: MethodReport) -> Self {
        Self {
            file,
            method,
            proven: None,
            seconds: ChainSeconds::default(),
            target_error: None,
            triangles_before: None,
            vertices_before: None,
            diagonal: None,
            chain: Vec::new(),
            locked_vertices: None,
            parts: None,
            warning: None,
            notes: Vec::new(),
            output: None,
            layout: None,
            error: None,
        }
    }

    /// Fills in what the collapses reached.
    pub(crate) fn record(&mut self, collapses: &Collapses) {
        self.target_error = collapses.target_error;
        self.triangles_before = Some(collapses.triangles_before);
        self.diagonal = Some(collapses.diagonal);
        self.locked_vertices = Some(collapses.locked_vertices);
    }

    /// Returns a table of the levels.
    pub(crate) fn summary(&self) -> String {
        if self.chain.is_empty() {
            return String::new();
        }
        let head = ["", "triangles", "vertices", "error", "down to coverage", "size", ""];
        let rows: Vec<Vec<String>> =
            std::iter::once(head.map(str::to_owned).to_vec()).chain(self.chain.iter().map(row)).collect();
        table(&rows, 1..6)
    }
}

impl InputReport for ChainReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}
