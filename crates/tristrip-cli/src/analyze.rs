//! `tristrip analyze`: index and vertex-cache statistics of a file as stored. It builds no strips.

use std::cell::RefCell;

use serde::Serialize;
use tristrip::vertex_cache::FlushPolicy;
use tristrip_pipeline::Stage;
use tristrip_pipeline::analyze::{self, CacheMisses, DrawMode, LengthBin, StoredIndices, StoredPart};
use tristrip_pipeline::text::{count, counted};
use tristrip_render::analysis::{self, Curve};
use tristrip_render::text::table;

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::short_name;
use crate::job::Input;
use crate::report::{self, Batch};
use crate::stage::load_input;
use crate::task::AnalyzeTask;

/// The maximum number of parts listed in the text.
const MAX_LISTED_PARTS: usize = 24;

/// The length of the longest bar of the histogram, in characters.
const MAX_BAR: usize = 40;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[("load", &[Stage::Load]), ("analyze", &[Stage::Analyze])];

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Analyzed {
    #[serde(flatten)]
    outcome: analyze::Outcome,
    /// The SVG chart that was written; `null` without `--plot`.
    plot: Option<String>,
}

/// Analyzes all inputs in order and draws the chart. Returns whether all succeeded.
pub(crate) fn run(task: &AnalyzeTask, console: &mut Console) -> bool {
    let flushed = task.options.flush_policy == FlushPolicy::Flush;
    let curves = RefCell::new(Vec::new());
    let process = |input: &Input, console: &mut Console, clock: &StageClock| {
        let (outcome, curve) = analyze(input, task, console, clock)?;
        curves.borrow_mut().extend(curve);
        Ok(Analyzed { outcome, plot: None })
    };
    let show = |_: &Input, analyzed: &Analyzed, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", as_text(&analyzed.outcome)), true);
    };
    let mut reports = Batch::new(SECONDS).process(&task.inputs, console, Input::name, process, show);
    let curves = curves.into_inner();
    if let Some(path) = task.plot.as_ref().filter(|_| !curves.is_empty()) {
        let chart = analysis::draw(&curves, flushed).map_err(Failure::from);
        if report::write_chart(path, chart, &mut reports, console) {
            let analyzed = reports.iter_mut().filter_map(|report| report.outcome.as_mut());
            analyzed.for_each(|analyzed| analyzed.plot = Some(path.display().to_string()));
        }
    }
    report::finish(&reports, console)
}

/// Analyzes one input; returns its curve if a chart was requested.
fn analyze(
    input: &Input,
    task: &AnalyzeTask,
    console: &mut Console,
    clock: &StageClock,
) -> Result<(analyze::Outcome, Option<Curve>), Failure> {
    let model = load_input(input, console, clock)?;
    let found = clock.observe(|observer| analyze::run(&model, &task.options, observer))?;
    let for_curve = task.curve.clone().map(|list| task.options.clone().with_vertex_caches(list));
    let curve = for_curve.map(|options| clock.observe(|observer| analyze::run(&model, &options, observer)));
    let caches = counted(found.vertex_caches.len(), "vertex cache");
    console.stage("analyze", &caches, clock.seconds(&[Stage::Analyze]));
    let curve = curve.transpose()?.map(|analysis| Curve { file: short_name(&input.name()), analysis });
    Ok((found, curve))
}

fn as_text(found: &analyze::Outcome) -> String {
    let mut text = table(&stored_rows(&found.stored), 1..2);
    text.push('\n');
    text.push_str(&table(&cache_rows(found), 1..4));
    if !found.lengths.is_empty() {
        text.push_str("\n  strips by number of triangles\n");
        text.push_str(&table(&length_rows(&found.lengths), 1..2));
    }
    if found.by_part.len() > 1 {
        text.push('\n');
        text.push_str(&table(&part_rows(found), 3..7));
        let more = found.by_part.len().saturating_sub(MAX_LISTED_PARTS);
        if more > 0 {
            text.push_str("  and ");
            text.push_str(&count(more));
            text.push_str(" more; --json lists all parts\n");
        }
    }
    text
}

fn cache_rows(found: &analyze::Outcome) -> Vec<Vec<String>> {
    let name = if found.flushed { "  vertex cache, flushed between strips" } else { "  vertex cache" };
    let head = [name, "misses", "ACMR", "ATVR"].map(String::from).to_vec();
    let row = |row: &CacheMisses| {
        vec![
            format!("  {}", row.vertex_cache),
            count(row.misses),
            format!("{:.3}", row.acmr),
            format!("{:.3}", row.atvr),
        ]
    };
    std::iter::once(head).chain(found.vertex_caches.iter().map(row)).collect()
}

fn part_rows(found: &analyze::Outcome) -> Vec<Vec<String>> {
    let acmr = found.vertex_caches.first().map_or(String::new(), |row| format!("ACMR {}", row.vertex_cache));
    let head = ["  part", "name", "drawn as", "triangles", "strips", "indices", &acmr];
    let row = |(number, part): (usize, &StoredPart)| {
        let stored = &part.stored;
        let names = [&part.name, &part.material].map(Option::as_deref).into_iter().flatten();
        let misses = part.misses.first().copied().unwrap_or(0);
        vec![
            format!("  {number}"),
            names.collect::<Vec<_>>().join(" / ").chars().filter(|c| !c.is_control()).take(32).collect(),
            stored.drawn.name().into(),
            count(stored.triangles),
            stored.strips.map(count).unwrap_or_default(),
            count(stored.indices),
            format!("{:.3}", misses as f64 / stored.triangles.max(1) as f64),
        ]
    };
    let rows = found.by_part.iter().enumerate().take(MAX_LISTED_PARTS).map(row);
    std::iter::once(head.map(String::from).to_vec()).chain(rows).collect()
}

fn stored_rows(stored: &StoredIndices) -> Vec<Vec<String>> {
    let triangles = stored.triangles.max(1) as f64;
    let mut rows = Vec::new();
    let mut row =
        |name: &str, n: usize, remark: String| rows.push(vec![format!("  {name}"), count(n), remark]);
    row("triangles", stored.triangles, format!("drawn as {}", drawn_as(stored.drawn)));
    row("used vertices", stored.vertices, String::new());
    row("indices", stored.indices, format!("{:.3} per triangle", stored.indices as f64 / triangles));
    row("restarts", stored.restarts, String::new());
    row("degenerate triangles", stored.degenerate, String::new());
    if let Some(strips) = stored.strips {
        let sent = stored.vertices_sent.unwrap_or(0);
        row("strips", strips, String::new());
        row("isolated triangles", stored.isolated.unwrap_or(0), String::new());
        row("swaps", stored.swaps.unwrap_or(0), String::new());
        row("vertices sent (OpenGL)", sent, String::new());
    }
    rows
}

fn drawn_as(drawn: DrawMode) -> &'static str {
    match drawn {
        DrawMode::List => "a list",
        DrawMode::Strips => "strips",
        DrawMode::Fans => "fans",
        _ => "lists, strips or fans, depending on the part",
    }
}

fn length_rows(bins: &[LengthBin]) -> Vec<Vec<String>> {
    let most = bins.iter().map(|bin| bin.strips).max().unwrap_or(0).max(1);
    let bar = |bin: &LengthBin| "#".repeat((bin.strips * MAX_BAR).div_ceil(most));
    bins.iter().map(|bin| vec![format!("  {}", bin.name()), count(bin.strips), bar(bin)]).collect()
}
