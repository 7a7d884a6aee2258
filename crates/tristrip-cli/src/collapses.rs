//! What the stages around the collapses of a model print and report: the survey, the proof, warnings and notes.

use tristrip_pipeline::Event;

use crate::console::Console;

/// The fields of a report that these stages fill in.
pub(crate) struct CollapseFields<'a> {
    pub(crate) file: &'a str,
    /// The times of the stages.
    pub(crate) dual: &'a mut Option<f64>,
    pub(crate) verify: &'a mut Option<f64>,
    pub(crate) parts: &'a mut Option<usize>,
    /// Used vertices.
    pub(crate) vertices_before: &'a mut Option<usize>,
    pub(crate) warning: &'a mut Option<String>,
    pub(crate) notes: &'a mut Vec<String>,
    pub(crate) proven: &'a mut Option<bool>,
}

impl CollapseFields<'_> {
    /// Prints and reports an event.
    pub(crate) fn show(self, event: Event<'_>, seconds: f64, console: &Console) {
        match event {
            Event::Prepared => *self.dual = Some(seconds),
            Event::Surveyed { parts, mesh, notes } => {
                *self.parts = Some(parts);
                *self.notes = notes.to_vec();
                *self.vertices_before = Some(mesh.vertices - mesh.unreferenced_vertices);
            }
            Event::Note(note) => self.notes.push(note.into()),
            Event::Warning(warning) => {
                console.warning(self.file, warning);
                *self.warning = Some(warning.into());
            }
            Event::Proven { .. } => {
                (*self.verify, *self.proven) = (Some(seconds), Some(true));
                let what = "proven: replaying the collapses removes exactly these triangles";
                console.stage("verify", what, Some(seconds));
            }
            _ => (),
        }
    }
}

/// Returns the [`CollapseFields`] of a report, which has them by the same names.
macro_rules! collapse_fields {
    ($report:expr) => {
        $crate::collapses::CollapseFields {
            file: &$report.file,
            dual: &mut $report.seconds.dual,
            verify: &mut $report.seconds.verify,
            parts: &mut $report.parts,
            vertices_before: &mut $report.vertices_before,
            warning: &mut $report.warning,
            notes: &mut $report.notes,
            proven: &mut $report.proven,
        }
    };
}
pub(crate) use collapse_fields;
