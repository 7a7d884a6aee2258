//! The tables and figures of papers, with published and measured values.
//!
//! ```text
//! papers/*.json ─▶ runner: all methods on all models, proven ─┬▶ comparison, statistics ─▶ page
//!  tables, claims, figures                                    │         docs/reproduction/KEY.md
//!                                                             └▶ draw, chart
//!                                                                       docs/reproduction/*.svg
//! ```
//! Pages contain no times and have the same bytes on every machine. If a model is missing in the
//! directory, its rows have no measured values; this is not an error. A result that is not proven
//! is an error.

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
mod papers;
mod printed;
mod recipe;
mod recovery_figures;
mod runner;
mod searches;
mod statistics;
mod table_values;
mod verdict;
mod view_data;
mod view_figures;
mod wire_figures;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::Error;
use coverage::Coverage;
pub use observer::ReproObserver;
use page::PageSection;
use paper::Paper;
pub use paper_report::PaperReport;
pub use papers::{keys, published, sections};
use runner::Runner;
use tristrip_pipeline::text::counted;

/// The subdirectory of the output directory for the pages.
const FOLDER: &str = "reproduction";

/// The result of a reproduction; the keys are those of the JSON report.
#[derive(Debug, Default, Serialize)]
#[non_exhaustive]
pub struct ReproReport {
    /// The directory of the models.
    pub models: String,
    /// The papers, each with published and measured values.
    pub papers: Vec<PaperReport>,
    /// The models that could not be read, and the pages that were not written, each with the
    /// reason.
    pub notes: Vec<String>,
    /// The written files.
    pub outputs: Vec<String>,
    /// Why the reproduction stopped early; `None` if it did not.
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

/// The selected papers, by their [`keys`], and all or one of their [`sections`].
///
/// ```
/// use tristrip_lab::repro::Selection;
/// let selection = Selection { papers: ["000".into()].into(), section: Some("skip-strips".into()) };
/// assert!(selection.contains("000", "skip-strips") && !selection.contains("000", "strips"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Selection {
    /// The keys of the papers.
    pub papers: BTreeSet<String>,
    /// The name of the section; `None` for all. Nothing is reproduced for papers without a section
    /// of this name.
    pub section: Option<String>,
}

impl Selection {
    /// Checks whether a section of a paper is selected.
    pub fn contains(&self, key: &str, section: &str) -> bool {
        self.papers.contains(key) && self.section.as_ref().is_none_or(|wanted| wanted == section)
    }
}

/// Reproduces papers with the models of a directory. Writes a page per paper, and its figures, into
/// the subdirectory `reproduction` of an output directory.
///
/// Sections of a page that are not selected are kept. A page without any measurement is not
/// written. A page that was measured on more models is kept, with a note. After an error, the
/// report has the pages that were written before.
///
/// # Errors
/// A file or directory cannot be read or written, a result is not proven, or the observer
/// cancelled.
///
/// ```no_run
/// use std::path::Path;
/// use tristrip_lab::repro::{ReproReport, Selection, keys, reproduce};
/// let selection = Selection { papers: keys().map(String::from).collect(), section: None };
/// let mut report = ReproReport::default();
/// reproduce(&selection, Path::new("models"), Path::new("docs"), &(), &mut report)?;
/// # Ok::<(), tristrip_lab::Error>(())
/// ```
pub fn reproduce(
    selection: &Selection,
    models: &Path,
    output: &Path,
    observer: &dyn ReproObserver,
    report: &mut ReproReport,
) -> Result<(), Error> {
    report.models = models.display().to_string();
    // Create the directory before the measurements, which take minutes.
    let folder = create_folder(output)?;
    let papers = papers::load(&selection.papers)?;
    let is_selected = |paper: &Paper| selection.contains(&paper.key, &paper.section);
    let mut runner = Runner::new(models)?;
    for paper in papers.iter().filter(|paper| is_selected(paper)) {
        comparison::request(paper, &mut runner);
        paper.charts.iter().for_each(|chart| draw::request(chart, &mut runner));
    }
    report.notes = runner.measure(observer)?;
    for sections in papers.chunk_by(|a, b| a.key == b.key) {
        let compared =
            sections.iter().map(|paper| is_selected(paper).then(|| compare(paper, &runner)).transpose());
        let compared = compared.collect::<Result<Vec<_>, _>>()?;
        if compared.iter().any(Option::is_some) {
            write_page(sections, compared, &folder, report)?;
        }
    }
    Ok(())
}

/// Compares a section with the measurements, and draws its figures.
fn compare(paper: &Paper, runner: &Runner) -> Result<PaperReport, Error> {
    let charts = paper.charts.iter().map(|chart| draw::draw(chart, runner)).collect::<Result<_, _>>()?;
    Ok(comparison::compare(paper, charts, runner))
}

/// Writes the page of a paper and its figures, and reports its sections as one paper.
fn write_page(
    papers: &[Paper],
    compared: Vec<Option<PaperReport>>,
    folder: &Path,
    report: &mut ReproReport,
) -> Result<(), Error> {
    let sections = papers.iter().zip(&compared).enumerate();
    let sections: Vec<PageSection<'_>> = sections
        .map(|(number, (paper, report))| PageSection {
            paper,
            report: report.as_ref(),
            is_first: number == 0,
        })
        .collect();
    let measured = page::page(&sections, "");
    let path = folder.join(format!("{}.md", papers[0].key));
    let old = if path.exists() {
        std::fs::read_to_string(&path).map_err(|error| Error::io(&path, error))?
    } else {
        String::new()
    };
    let text = page::page(&sections, &old);
    let mut compared = compared.into_iter().flatten().reduce(PaperReport::with).unwrap_or_default();
    if let Some(why) = reason_to_keep(&measured, &old) {
        report.notes.push(format!("{} and its figures {why}", path.display()));
    } else {
        for chart in &compared.charts {
            let path = folder.join(&chart.file);
            // The page refers to the file, so an empty chart is written if there is none.
            if chart.is_measured || !path.exists() {
                report.outputs.push(write(&path, &chart.contents)?);
            }
        }
        let path = write(&path, text.as_bytes())?;
        compared.page = Some(path.clone());
        report.outputs.push(path);
    }
    report.papers.push(compared);
    Ok(())
}

/// Returns why a page is not written: nothing was measured for it, or the existing page was
/// measured on more models.
fn reason_to_keep(measured: &str, old: &str) -> Option<String> {
    let new = Coverage::of(measured);
    if new.is_empty() {
        return Some("were not written: none of the models was found".into());
    }
    let old = Coverage::of(old);
    let missing = new.missing(&old);
    let why = |first: &&str| {
        let rows = counted(missing.len(), "row");
        format!(
            "were kept: {rows} of the page were measured on models that were not found now; the first is {first}"
        )
    };
    missing.first().map(why)
}

/// Creates the output directory and its subdirectory for pages. A missing parent of the output
/// directory is an error, because it is probably a typing error.
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

fn write(path: &Path, contents: &[u8]) -> Result<String, Error> {
    tristrip_io::replace_file(path, contents).map_err(tristrip_pipeline::Error::from)?;
    Ok(path.display().to_string())
}

impl PaperReport {
    /// Adds another section of the paper to the report.
    fn with(mut self, section: Self) -> Self {
        self.tables.extend(section.tables);
        self.charts.extend(section.charts);
        self.claims.extend(section.claims);
        self.left_out.extend(section.left_out);
        self
    }

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
