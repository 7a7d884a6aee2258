//! `tristrip repro`: the tables and figures of papers, published beside measured.
//!
//! ```text
//! papers/*.json ─▶ paper ─▶ lab (all methods on all models, proven) ─▶ judge, statistics ─▶ page ─▶ docs/reproduction/KEY.md
//!  tables, claims, figures                                          └▶ draw, chart      ─▶      docs/reproduction/*.svg
//! ```
//! Pages have no times in them, so that they are the same bytes on every machine. A model that is not in the folder leaves its rows
//! without a figure and fails nothing; a result that is not proven fails everything.

mod draw;
mod judge;
mod lab;
mod levels;
mod page;
mod paper;
mod statistics;
mod verdict;

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::console::Console;
use crate::failure::Failure;
use crate::stages::Pool;
use crate::task::ReproTask;
use crate::text::{counted, table};
use judge::PaperReport;
use lab::Lab;
pub(crate) use paper::keys;

/// The folder of the pages within the output directory.
const FOLDER: &str = "reproduction";

/// What `tristrip repro` says.
#[derive(Debug, Default, Serialize)]
struct ReproReport {
    models: String,
    papers: Vec<PaperReport>,
    notes: Vec<String>,
    /// The files that were written.
    outputs: Vec<String>,
    error: Option<String>,
}

/// Reproduces papers; tells whether all was proven and written.
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
    // Before anything is measured, since that takes minutes.
    let folder = make_folder(&task.output)?;
    let papers = paper::load(&task.papers)?;
    let mut lab = Lab::new(&task.models)?;
    for paper in &papers {
        judge::want(paper, &mut lab);
        paper.charts.iter().for_each(|chart| draw::want(chart, &mut lab));
    }
    report.notes = lab.measure(pool, console)?;
    for paper in &papers {
        let charts = paper.charts.iter().map(|chart| draw::draw(chart, &lab)).collect::<Result<_, _>>()?;
        let mut judged = judge::judge(paper, charts, &lab);
        let text = page::page(paper, &judged);
        for chart in &judged.charts {
            report.outputs.push(write(&folder.join(&chart.file), &chart.svg)?);
        }
        let path = write(&folder.join(format!("{}.md", paper.key)), &text)?;
        judged.page = Some(path.clone());
        report.outputs.push(path);
        report.papers.push(judged);
    }
    Ok(())
}

/// Makes the folder of the pages, and the directory that was named above it; a missing one above that is more likely a slip.
fn make_folder(output: &Path) -> Result<PathBuf, Failure> {
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

/// Counts the verdicts of each paper, those of rows and of claims.
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
            format!("{worse} worse in something"),
            format!("{} without the model", verdicts.len() - matched - better - worse),
            paper.page.clone().unwrap_or_default(),
        ]);
        rows.push(row);
    }
    table(&rows, 1..5) + &format!("{} written\n", counted(report.outputs.len(), "file"))
}
