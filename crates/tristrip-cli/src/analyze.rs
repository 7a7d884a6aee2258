//! `tristrip analyze`: index and vertex-cache statistics of a file as stored. No strips are built.

use std::cell::RefCell;

use serde::Serialize;
use tristrip::vertex_cache::FlushPolicy;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{DrawMode, LengthBin, PartReport, StoredFigures, VertexCacheReport};
use tristrip_render::analysis::{self, Curve};
use tristrip_render::text::table;

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::short_name;
use crate::job::Input;
use crate::stage::{load_timed, timed};
use crate::task::AnalyzeTask;

/// The maximum number of parts listed in the text.
const MAX_LISTED_PARTS: usize = 24;

/// The length of the longest bar of the text, in characters.
const MAX_BAR: usize = 40;

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct AnalyzeReport {
    file: String,
    seconds: AnalyzeSeconds,
    #[serde(flatten)]
    figures: Option<StoredFigures>,
    indices_per_triangle: Option<f64>,
    lengths: Vec<LengthBin>,
    flushed: bool,
    vertex_caches: Vec<VertexCacheReport>,
    parts: Option<usize>,
    by_part: Vec<PartReport>,
    notes: Vec<String>,
    plot: Option<String>,
    error: Option<String>,
}

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct AnalyzeSeconds {
    load: Option<f64>,
    analyze: Option<f64>,
}

impl InputReport for AnalyzeReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: None, error: &mut self.error }
    }
}

/// Analyzes all inputs in order, and draws the chart; returns whether all succeeded.
pub(crate) fn run(task: &AnalyzeTask, console: &mut Console) -> bool {
    let flushed = task.options.flush_policy == FlushPolicy::Flush;
    let new_report =
        |input: &Input| AnalyzeReport { file: input.name(), flushed, ..AnalyzeReport::default() };
    let curves = RefCell::new(Vec::new());
    let process = |input: &Input, console: &mut Console, report: &mut AnalyzeReport| {
        curves.borrow_mut().extend(analyze(input, task, console, report)?);
        Ok(())
    };
    let show = |_: &Input, report: &AnalyzeReport, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", report.as_text()), true);
    };
    let mut reports = batch::process_all(&task.inputs, None, console, new_report, process, show);
    let curves = curves.into_inner();
    if let Some(path) = task.plot.as_ref().filter(|_| !curves.is_empty())
        && batch::write_chart(
            path,
            analysis::draw(&curves, flushed).map_err(Failure::from),
            &mut reports,
            console,
        )
    {
        for report in reports.iter_mut().filter(|report| report.error.is_none()) {
            report.plot = Some(path.display().to_string());
        }
    }
    batch::finish(reports, console)
}

/// Analyzes one input; returns its curve if a chart was requested.
fn analyze(
    input: &Input,
    task: &AnalyzeTask,
    console: &mut Console,
    report: &mut AnalyzeReport,
) -> Result<Option<Curve>, Failure> {
    let (model, seconds) = load_timed(input, console)?;
    report.seconds.load = Some(seconds);
    report.parts = Some(model.parts.len());
    report.notes.clone_from(&model.notes);
    console.stage("load", &counted(model.parts.len(), "part"), Some(seconds));
    model.notes.iter().for_each(|note| console.note(note));

    console.doing("analyze");
    let for_curve = task.curve.clone().map(|list| task.options.clone().with_vertex_caches(list));
    let (analysis, seconds) = timed(|| tristrip_pipeline::analyze(&model, &task.options));
    let (curve, curve_seconds) =
        timed(|| for_curve.map(|options| tristrip_pipeline::analyze(&model, &options).vertex_caches));
    report.seconds.analyze = Some(seconds + curve_seconds);
    let caches = counted(analysis.vertex_caches.len(), "vertex cache");
    console.stage("analyze", &caches, report.seconds.analyze);

    report.by_part = analysis.part_reports(&model);
    report.vertex_caches = analysis.cache_reports();
    report.indices_per_triangle = Some(analysis.indices_per_triangle());
    report.lengths = analysis.lengths.bins().to_vec();
    report.figures = Some(analysis.figures);
    let lengths = analysis.lengths;
    Ok(curve.map(|each| Curve { file: short_name(&report.file), each, lengths }))
}

impl AnalyzeReport {
    fn as_text(&self) -> String {
        let Some(figures) = &self.figures else { return String::new() };
        let mut text = table(&figure_rows(figures), 1..2);
        text.push('\n');
        text.push_str(&table(&self.cache_rows(), 1..4));
        if !self.lengths.is_empty() {
            text.push_str("\n  strips by number of triangles\n");
            text.push_str(&table(&length_rows(&self.lengths), 1..2));
        }
        if self.by_part.len() > 1 {
            text.push('\n');
            text.push_str(&table(&self.part_rows(), 3..7));
            let more = self.by_part.len().saturating_sub(MAX_LISTED_PARTS);
            if more > 0 {
                text.push_str("  and ");
                text.push_str(&counted(more, "part"));
                text.push_str(" more; --json lists all\n");
            }
        }
        text
    }

    fn cache_rows(&self) -> Vec<Vec<String>> {
        let name = if self.flushed { "  vertex cache, flushed between strips" } else { "  vertex cache" };
        let head = [name, "misses", "ACMR", "ATVR"].map(String::from).to_vec();
        let row = |row: &VertexCacheReport| {
            vec![
                format!("  {}", row.vertex_cache),
                count(row.misses),
                format!("{:.3}", row.acmr),
                format!("{:.3}", row.atvr),
            ]
        };
        std::iter::once(head).chain(self.vertex_caches.iter().map(row)).collect()
    }

    fn part_rows(&self) -> Vec<Vec<String>> {
        let acmr =
            self.vertex_caches.first().map_or(String::new(), |row| format!("ACMR {}", row.vertex_cache));
        let head = ["  part", "name", "drawn as", "triangles", "strips", "indices", &acmr];
        let row = |(number, part): (usize, &PartReport)| {
            let figures = &part.figures;
            let names = [&part.name, &part.material].map(Option::as_deref).into_iter().flatten();
            let misses = part.misses.first().copied().unwrap_or(0);
            vec![
                format!("  {number}"),
                names.collect::<Vec<_>>().join(" / ").chars().filter(|c| !c.is_control()).take(32).collect(),
                figures.drawn.name().into(),
                count(figures.triangles),
                figures.strips.map(count).unwrap_or_default(),
                count(figures.indices),
                format!("{:.3}", misses as f64 / figures.triangles.max(1) as f64),
            ]
        };
        let rows = self.by_part.iter().enumerate().take(MAX_LISTED_PARTS).map(row);
        std::iter::once(head.map(String::from).to_vec()).chain(rows).collect()
    }
}

fn figure_rows(figures: &StoredFigures) -> Vec<Vec<String>> {
    let triangles = figures.triangles.max(1) as f64;
    let mut rows = Vec::new();
    let mut row =
        |name: &str, n: usize, remark: String| rows.push(vec![format!("  {name}"), count(n), remark]);
    row("triangles", figures.triangles, format!("drawn as {}", drawn_as(figures.drawn)));
    row("used vertices", figures.vertices, String::new());
    row("indices", figures.indices, format!("{:.3} per triangle", figures.indices as f64 / triangles));
    row("restarts", figures.restarts, String::new());
    row("degenerate triangles", figures.degenerate, String::new());
    if let Some(strips) = figures.strips {
        let sent = figures.vertices_sent.unwrap_or(0);
        row("strips", strips, String::new());
        row("isolated triangles", figures.isolated.unwrap_or(0), String::new());
        row("swaps", figures.swaps.unwrap_or(0), String::new());
        row("vertices sent (OpenGL)", sent, String::new());
    }
    rows
}

fn drawn_as(drawn: DrawMode) -> &'static str {
    match drawn {
        DrawMode::List => "a list",
        DrawMode::Strips => "strips",
        DrawMode::Fans => "fans",
        _ => "lists, strips or fans by part",
    }
}

fn length_rows(bins: &[LengthBin]) -> Vec<Vec<String>> {
    let most = bins.iter().map(|bin| bin.strips).max().unwrap_or(0).max(1);
    let bar = |bin: &LengthBin| "#".repeat((bin.strips * MAX_BAR).div_ceil(most));
    bins.iter().map(|bin| vec![format!("  {}", bin.name()), count(bin.strips), bar(bin)]).collect()
}
