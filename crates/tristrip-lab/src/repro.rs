//! The tables and figures of papers, with published and measured values.
//!
//! ```text
//! papers/*.json ─▶ paper ─▶ runner (all methods on all models, proven) ─▶ comparison, statistics ─▶ page ─▶ docs/reproduction/KEY.md
//!  tables, claims, figures                                              └▶ draw, chart           ─▶       docs/reproduction/*.svg
//! ```
//! Pages contain no times, so that they have the same bytes on every machine. If a model is not in the folder, its rows have no measured
//! values, which is not an error; a result that is not proven is an error.

mod comparison;
mod components;
mod coverage;
mod draw;
mod identity;
mod level_figures;
mod measured;
mod observer;
mod page;
mod paper;
mod paper_report;
mod printed;
mod recipe;
mod recovery_figures;
mod runner;
mod searches;
mod statistics;
mod verdict;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::Error;
use coverage::Coverage;
pub use observer::ReproObserver;
pub use paper::{keys, published};
pub use paper_report::PaperReport;
use runner::Runner;
use tristrip_pipeline::text::counted;

/// The subfolder of the output directory for the pages.
const FOLDER: &str = "reproduction";

/// What was reproduced; the keys are those of the JSON report.
#[derive(Debug, Default, Serialize)]
#[non_exhaustive]
pub struct ReproReport {
    /// The folder of the models.
    pub models: String,
    /// The papers, each with published and measured values.
    pub papers: Vec<PaperReport>,
    /// The models that could not be read, and the pages that were not written, each with the reason.
    pub notes: Vec<String>,
    /// The written files.
    pub outputs: Vec<String>,
    /// Why the reproduction ended early, if it did.
    pub error: Option<String>,
}

/// The counts of verdicts of a paper, over rows and claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct VerdictCounts {
    /// Equal within the tolerance.
    pub matched: usize,
    /// Better than published.
    pub better: usize,
    /// Worse than published, or different.
    pub worse: usize,
    /// Without a comparable model.
    pub without_model: usize,
}

/// Reproduces papers, by their [`keys`], with the models of a folder: writes a page per paper and its figures into the folder `reproduction`
/// of a directory. A page for which nothing was measured is not written, and a page that was measured on more models is kept, with a note.
/// After an error, the report has what was written before.
///
/// # Errors
/// A file or directory cannot be read or written, a result is not proven, or the observer cancelled.
///
/// ```no_run
/// use std::path::Path;
/// use tristrip_lab::repro::{ReproReport, keys, reproduce};
/// let papers = keys().map(String::from).collect();
/// let mut report = ReproReport::default();
/// reproduce(&papers, Path::new("models"), Path::new("docs"), &(), &mut report)?;
/// # Ok::<(), tristrip_lab::Error>(())
/// ```
pub fn reproduce(
    papers: &BTreeSet<String>,
    models: &Path,
    output: &Path,
    observer: &dyn ReproObserver,
    report: &mut ReproReport,
) -> Result<(), Error> {
    report.models = models.display().to_string();
    // Before the measurements, which take minutes.
    let folder = create_folder(output)?;
    let papers = paper::load(papers)?;
    let mut runner = Runner::new(models)?;
    for paper in &papers {
        comparison::request(paper, &mut runner);
        paper.charts.iter().for_each(|chart| draw::request(chart, &mut runner));
    }
    report.notes = runner.measure(observer)?;
    for paper in &papers {
        let charts = paper.charts.iter().map(|chart| draw::draw(chart, &runner)).collect::<Result<_, _>>()?;
        let mut compared = comparison::compare(paper, charts, &runner);
        let text = page::page(paper, &compared);
        let path = folder.join(format!("{}.md", paper.key));
        if let Some(why) = reason_to_keep(&path, &text)? {
            report.notes.push(format!("{} and its figures {why}", path.display()));
        } else {
            for chart in &compared.charts {
                let path = folder.join(&chart.file);
                // The page needs the file, so that an empty chart is written if there is none.
                if chart.is_measured() || !path.exists() {
                    report.outputs.push(write(&path, &chart.svg)?);
                }
            }
            let path = write(&path, &text)?;
            compared.page = Some(path.clone());
            report.outputs.push(path);
        }
        report.papers.push(compared);
    }
    Ok(())
}

/// Returns why a page is not written: nothing was measured for it, or the page that is there was measured on more models.
fn reason_to_keep(path: &Path, text: &str) -> Result<Option<String>, Error> {
    let new = Coverage::of(text);
    if new.is_empty() {
        return Ok(Some("were not written: none of the models was found".into()));
    }
    if !path.exists() {
        return Ok(None);
    }
    let old = std::fs::read_to_string(path).map_err(|error| Error::io(path, error))?;
    let old = Coverage::of(&old);
    let missing = new.missing(&old);
    let why = |first: &&str| {
        let rows = counted(missing.len(), "row");
        format!(
            "were kept: {rows} of the page have measurements on models that were not found now, the first is {first}"
        )
    };
    Ok(missing.first().map(why))
}

/// Creates the folder of the pages and the output directory. A missing parent of the output directory is an error, because it is
/// probably a typing mistake.
fn create_folder(output: &Path) -> Result<PathBuf, Error> {
    let folder = output.join(FOLDER);
    for directory in [output, &folder] {
        if directory.exists() && !directory.is_dir() {
            return Err(Error::NotADirectory(directory.display().to_string()));
        }
        if !directory.is_dir() {
            std::fs::create_dir(directory).map_err(|error| Error::io(directory, error))?;
        }
    }
    Ok(folder)
}

fn write(path: &Path, text: &str) -> Result<String, Error> {
    tristrip_io::replace_file(path, text.as_bytes()).map_err(tristrip_pipeline::Error::from)?;
    Ok(path.display().to_string())
}

impl PaperReport {
    /// Counts the verdicts of rows and claims.
    pub fn verdicts(&self) -> VerdictCounts {
        let rows = self.tables.iter().flat_map(|table| &table.rows).map(|row| row.verdict.clone());
        let verdicts: Vec<String> =
            rows.chain(self.claims.iter().map(|claim| claim.verdict.to_string())).collect();
        let count = |is: &dyn Fn(&str) -> bool| verdicts.iter().filter(|verdict| is(verdict)).count();
        let is_worse = |verdict: &str| verdict.contains("worse") || verdict.contains("differs");
        let worse = count(&is_worse);
        let better = count(&|verdict| verdict.starts_with("better") && !is_worse(verdict));
        let matched = count(&|verdict| verdict == "matched");
        VerdictCounts { matched, better, worse, without_model: verdicts.len() - matched - better - worse }
    }
}
