//! `tristrip repro`: the tables and figures of papers, with published and measured values.

use std::sync::Mutex;

use tristrip::StripifyOptions;
use tristrip_lab::repro::{ReproObserver, ReproReport, reproduce};
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Observer, Search};
use tristrip_render::text::table;

use crate::console::Console;
use crate::failure::Failure;
use crate::search::{SearchWatch, interrupted};
use crate::task::ReproTask;

/// Shows the model and the recipe that are measured.
struct Measuring<'a>(Mutex<&'a mut Console>);

impl Measuring<'_> {
    fn show(&self, show: impl FnOnce(&mut Console)) {
        if let Ok(mut console) = self.0.lock() {
            show(&mut console);
        }
    }
}

impl Observer for Measuring<'_> {
    fn search(&self, options: &StripifyOptions) -> Box<dyn Search + '_> {
        match self.0.lock() {
            Ok(console) => Box::new(SearchWatch::new(console.progress(), None, options)),
            Err(_) => Box::new(()),
        }
    }

    fn is_cancelled(&self) -> bool {
        interrupted()
    }
}

impl ReproObserver for Measuring<'_> {
    fn model(&self, name: &str) {
        self.show(|console| console.begin(name, None));
    }

    fn recipe(&self, flags: &str) {
        self.show(|console| console.doing(flags));
    }

    fn model_done(&self) {
        self.show(Console::end);
    }
}

/// Reproduces papers. Returns whether everything was proven and written.
pub(crate) fn run(task: &ReproTask, console: &mut Console) -> bool {
    let mut report = ReproReport::default();
    let observer = Measuring(Mutex::new(console));
    let done = reproduce(&task.selection, &task.models, &task.output, &observer, &mut report);
    let Ok(console) = observer.0.into_inner() else { return false };
    console.end();
    match done.map_err(Failure::from) {
        Ok(()) => {
            report.notes.iter().for_each(|note| console.note(note));
            console.result(&summary(&report), false);
        }
        Err(failure) => {
            console.error(&failure.to_string());
            report.error = Some(failure.to_string());
        }
    }
    let all_done = report.error.is_none();
    console.json(&[report], false);
    all_done
}

/// Formats the counts of verdicts per paper, of rows and claims.
fn summary(report: &ReproReport) -> String {
    let row = |paper: &tristrip_lab::repro::PaperReport| {
        let counts = paper.verdicts();
        vec![
            format!("paper {}", paper.key),
            format!("{} matched", counts.matched),
            format!("{} better", counts.better),
            format!("{} worse or different", counts.worse),
            format!("{} without model", counts.without_model),
            paper.page.clone().unwrap_or_else(|| "not written".into()),
        ]
    };
    let rows: Vec<_> = report.papers.iter().map(row).collect();
    table(&rows, 1..5) + &format!("{} written\n", counted(report.outputs.len(), "file"))
}
