//! `tristrip repro`: the tables and figures of papers, with published and measured values.
//!
//! ```text
//! papers/*.json ─▶ paper ─▶ runner (all methods on all models, proven) ─▶ comparison, statistics ─▶ page ─▶ docs/reproduction/KEY.md
//!  tables, claims, figures                                              └▶ draw, chart           ─▶       docs/reproduction/*.svg
//! ```
//! Pages contain no times, so that they have the same bytes on every machine. If a model is not in the folder, its rows have no measured
//! values, which is not an error; a result that is not proven is an error.

mod comparison;
mod draw;
mod identity;
mod level_figures;
mod measured;
mod page;
pub(crate) mod paper;
mod paper_report;
mod recipe;
mod runner;
mod statistics;
mod verdict;

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::console::Console;
use crate::failure::Failure;
use crate::stages::Pool;
use crate::task::ReproTask;
use crate::text::{counted, table};
pub(crate) use paper::keys;
use paper_report::PaperReport;
use runner::Runner;

/// The subfolder of the output directory for the pages.
const FOLDER: &str = "reproduction";

/// The report of `tristrip repro`.
#[derive(Debug, Default, Serialize)]
struct ReproReport {
    models: String,
    papers: Vec<PaperReport>,
    notes: Vec<String>,
    /// The written files.
    outputs: Vec<String>,
    error: Option<String>,
}

/// Reproduces papers. Returns whether everything was proven and written.
pub(crate) fn run(task: &ReproTask, pool: &Pool, console: &mut Console) -> bool {
    let mut report = ReproReport { models: task.models.display().to_string(), ..ReproReport::default() };
    let done = reproduce(task, pool, console, &mut report);
    console.end();
    match done {
        Ok(()) => console.result(&summary(&report), false),
        Err(failure) => {
            console.error(&failure.to_string());
            report.error = Some(failure.to_string());
        }
    }
    let all_done = report.error.is_none();
    console.json(&[report], false);
    all_done
}

fn reproduce(
    task: &ReproTask,
    pool: &Pool,
    console: &mut Console,
    report: &mut ReproReport,
) -> Result<(), Failure> {
    // Before the measurements, which take minutes.
    let folder = create_folder(&task.output)?;
    let papers = paper::load(&task.papers)?;
    let mut runner = Runner::new(&task.models)?;
    for paper in &papers {
        comparison::request(paper, &mut runner);
        paper.charts.iter().for_each(|chart| draw::request(chart, &mut runner));
    }
    report.notes = runner.measure(pool, console)?;
    for paper in &papers {
        let charts = paper.charts.iter().map(|chart| draw::draw(chart, &runner)).collect::<Result<_, _>>()?;
        let mut compared = comparison::compare(paper, charts, &runner);
        let text = page::page(paper, &compared);
        for chart in &compared.charts {
            report.outputs.push(write(&folder.join(&chart.file), &chart.svg)?);
        }
        let path = write(&folder.join(format!("{}.md", paper.key)), &text)?;
        compared.page = Some(path.clone());
        report.outputs.push(path);
        report.papers.push(compared);
    }
    Ok(())
}

/// Creates the folder of the pages and the output directory. A missing parent of the output directory is an error, because it is
/// probably a typing mistake.
fn create_folder(output: &Path) -> Result<PathBuf, Failure> {
    let folder = output.join(FOLDER);
    for directory in [output, &folder] {
        if directory.exists() && !directory.is_dir() {
            return Err(Failure::Output(format!(
                "{}: found a file, expected a directory",
                directory.display()
            )));
        }
        if !directory.is_dir() {
            std::fs::create_dir(directory).map_err(|error| Failure::system(directory, &error))?;
        }
    }
    Ok(folder)
}

fn write(path: &Path, text: &str) -> Result<String, Failure> {
    tristrip_io::replace_file(path, text.as_bytes()).map_err(|error| Failure::writing(&error))?;
    Ok(path.display().to_string())
}

/// Formats the counts of verdicts per paper, of rows and claims.
fn summary(report: &ReproReport) -> String {
    let mut rows = Vec::new();
    for paper in &report.papers {
        let of_rows = paper.tables.iter().flat_map(|table| &table.rows).map(|row| row.verdict.clone());
        let verdicts: Vec<_> =
            of_rows.chain(paper.claims.iter().map(|claim| claim.verdict.to_string())).collect();
        let count = |is: &dyn Fn(&str) -> bool| verdicts.iter().filter(|verdict| is(verdict)).count();
        let is_worse = |verdict: &str| verdict.contains("worse") || verdict.contains("differs");
        let worse = count(&is_worse);
        let better = count(&|verdict| verdict.starts_with("better") && !is_worse(verdict));
        let matched = count(&|verdict| verdict == "matched");
        let mut row = vec![format!("paper {}", paper.key)];
        row.extend([
            format!("{matched} matched"),
            format!("{better} better"),
            format!("{worse} worse or different"),
            format!("{} without model", verdicts.len() - matched - better - worse),
            paper.page.clone().unwrap_or_default(),
        ]);
        rows.push(row);
    }
    table(&rows, 1..5) + &format!("{} written\n", counted(report.outputs.len(), "file"))
}
