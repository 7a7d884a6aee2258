//! `tristrip-lab repro`: the tables and figures of papers, with published and measured values side
//! by side.

use std::collections::BTreeSet;
use std::path::PathBuf;

use tristrip_lab::repro::{PaperReport, ReproObserver, ReproReport, Selection, keys, reproduce, sections};
use tristrip_pipeline::Observer;
use tristrip_pipeline::text::counted;
use tristrip_render::text::table;

use crate::args::ReproArgs;
use crate::console::Console;
use crate::failure::Failure;

/// Prints the name of each measured model.
struct Measuring<'a>(&'a Console);

impl Observer for Measuring<'_> {}

impl ReproObserver for Measuring<'_> {
    fn model(&self, name: &str) {
        self.0.line(name);
    }
}

/// Reproduces papers.
pub(crate) fn run(args: &ReproArgs, console: &Console) -> Result<(), Failure> {
    let selection = selection(args)?;
    let models = args.models.clone().unwrap_or_else(default_models);
    let mut report = ReproReport::default();
    let done = reproduce(&selection, &models, &args.output, &Measuring(console), &mut report);
    if let Err(error) = done {
        let Failure::Failed(message) = Failure::from(error) else { return Err(Failure::Reported) };
        console.error(&message);
        report.error = Some(message);
        console.json(&[report])?;
        return Err(Failure::Reported);
    }
    report.notes.iter().for_each(|note| console.note(note));
    console.result(&summary(&report))?;
    console.json(&[report])
}

/// Checks the papers and the section.
fn selection(args: &ReproArgs) -> Result<Selection, Failure> {
    let known: Vec<&str> = keys().collect();
    if let Some(unknown) = args.papers.iter().find(|name| !known.contains(&name.as_str())) {
        let known = known.join(", ");
        return Err(Failure::Usage(format!("unknown paper {unknown:?}; known papers: {known}")));
    }
    let papers: BTreeSet<String> = if args.papers.is_empty() {
        known.iter().map(ToString::to_string).collect()
    } else {
        args.papers.iter().cloned().collect()
    };
    if let Some(section) = &args.section {
        let known: BTreeSet<String> = papers.iter().flat_map(|paper| sections(paper)).collect();
        if !known.contains(section) {
            let known = Vec::from_iter(known).join(", ");
            let message = format!("unknown section {section:?}; known sections of these papers: {known}");
            return Err(Failure::Usage(message));
        }
    }
    Ok(Selection { papers, section: args.section.clone() })
}

/// Returns the model directory next to the checkout if it exists, else the directory of the
/// project, relative to the checkout.
fn default_models() -> PathBuf {
    let shared = PathBuf::from("../shared/models");
    if shared.is_dir() { shared } else { "testdata/models".into() }
}

/// Formats the counts of verdicts per paper, over rows and claims.
fn summary(report: &ReproReport) -> String {
    let row = |paper: &PaperReport| {
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
