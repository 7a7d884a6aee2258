//! `tristrip analyze`: what a graphics processor does with a file as it stands. No strips are looked for.

mod buffers;
mod picture;
mod stored;

use std::path::Path;

use serde::Serialize;
use tristrip::strip::{Between, Buffer, BufferUse};
use tristrip_io::Part;

use crate::console::Console;
use crate::failure::Failure;
use crate::figures::rounded;
use crate::input::{load, short_name};
use crate::stages::{Pool, timed};
use crate::task::{AnalyzeTask, Input};
use crate::text::{count, counted, table};
pub(crate) use buffers::BufferList;
use picture::Curve;
use stored::{Bin, Drawn, Figures, Lengths, Stored, vertices_of};

/// Parts that the text shows one by one.
const PARTS_SHOWN: usize = 24;

/// Width of the longest bar of the text, in characters.
const BAR: usize = 40;

/// What `tristrip analyze` says of one input.
#[derive(Debug, Serialize)]
struct AnalyzeReport {
    file: String,
    seconds: AnalyzeSeconds,
    #[serde(flatten)]
    figures: Option<Figures>,
    indices_per_triangle: Option<f64>,
    lengths: Vec<Bin>,
    flushed: bool,
    buffers: Vec<BufferRow>,
    parts: Option<usize>,
    by_part: Vec<PartRow>,
    notes: Vec<String>,
    plot: Option<String>,
    error: Option<String>,
}

/// Times in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct AnalyzeSeconds {
    load: Option<f64>,
    analyze: Option<f64>,
}

/// One buffer, over all parts.
#[derive(Debug, Serialize)]
struct BufferRow {
    buffer: String,
    misses: usize,
    acmr: f64,
    atvr: f64,
}

/// One part of a file.
#[derive(Debug, Serialize)]
struct PartRow {
    name: Option<String>,
    material: Option<String>,
    #[serde(flatten)]
    figures: Figures,
    /// In the order of the report's buffers.
    misses: Vec<usize>,
}

/// Looks at all inputs, one after the other, and draws the picture; tells whether all was done.
pub(crate) fn run(task: &AnalyzeTask, pool: &Pool, console: &mut Console) -> bool {
    let (mut reports, mut curves) = (Vec::with_capacity(task.inputs.len()), Vec::new());
    for input in &task.inputs {
        let mut report = AnalyzeReport::new(input.name(), task.between);
        console.begin(&report.file, None);
        let done = analyze(input, task, pool, console, &mut report);
        console.end();
        match done {
            Ok(curve) => {
                let title = if task.inputs.len() > 1 { format!("{}\n", report.file) } else { String::new() };
                console.result(&format!("{title}{}", report.as_text()), true);
                curves.extend(curve);
            }
            Err(failure) => {
                console.error(&format!("{}: {failure}", report.file));
                report.error = Some(failure.to_string());
            }
        }
        reports.push(report);
    }
    if let Some(path) = task.plot.as_ref().filter(|_| !curves.is_empty()) {
        let drawn = draw(&curves, task.between, path);
        if let Err(failure) = &drawn {
            console.error(&failure.to_string());
        }
        for report in reports.iter_mut().filter(|report| report.error.is_none()) {
            match &drawn {
                Ok(()) => report.plot = Some(path.display().to_string()),
                Err(failure) => report.error = Some(failure.to_string()),
            }
        }
    }
    console.json(&reports, task.inputs.len() > 1);
    reports.iter().all(|report| report.error.is_none())
}

/// Looks at one input; gives its curve where a picture was asked for.
fn analyze(
    input: &Input,
    task: &AnalyzeTask,
    pool: &Pool,
    console: &mut Console,
    report: &mut AnalyzeReport,
) -> Result<Option<Curve>, Failure> {
    console.doing("load");
    let (model, seconds) = timed(|| load(input));
    let model = model?;
    report.seconds.load = Some(seconds);
    report.parts = Some(model.parts.len());
    report.notes.clone_from(&model.notes);
    console.stage("load", &counted(model.parts.len(), "part"), Some(seconds));
    model.notes.iter().for_each(|note| console.note(note));

    console.doing("analyze");
    let buffers = &task.buffers.0;
    let parts: Vec<&Part> = model.parts.iter().collect();
    let (measured, seconds) = timed(|| {
        pool.map(&parts, |&part| {
            let stored = Stored::of(part);
            let each = stored.with_each(buffers, task.between);
            let curve = task.curve.as_ref().map(|list| stored.with_each(&list.0, task.between));
            (stored, each, curve)
        })
    });
    report.seconds.analyze = Some(seconds);
    console.stage("analyze", &counted(buffers.len(), "buffer"), Some(seconds));

    let (mut stored, mut curves) = (Vec::new(), Vec::new());
    for (part, (one, each, curve)) in model.parts.iter().zip(measured) {
        report.by_part.push(PartRow {
            name: part.name.clone(),
            material: part.material.clone(),
            figures: one.figures,
            misses: each.iter().map(|used| used.misses).collect(),
        });
        stored.push(one);
        curves.extend(curve);
    }
    let figures = Figures { vertices: vertices_of(&stored), ..stored.iter().map(|one| one.figures).sum() };
    let (triangles, vertices) = (figures.triangles, figures.vertices);
    let total = |misses| BufferUse { misses, triangles, vertices };
    let sum = |i: usize| total(report.by_part.iter().map(|part| part.misses[i]).sum());
    report.buffers = buffers.iter().enumerate().map(|(i, &buffer)| BufferRow::of(buffer, sum(i))).collect();
    report.indices_per_triangle = Some(match figures.triangles {
        0 => 0.0,
        triangles => rounded(figures.indices as f64 / triangles as f64),
    });
    let lengths: Lengths = stored.into_iter().map(|one| one.lengths).sum();
    report.lengths = lengths.bins().to_vec();
    report.figures = Some(figures);
    Ok(task.curve.as_ref().map(|list| {
        let sum = |i: usize| total(curves.iter().map(|curve| curve[i].misses).sum());
        let each = list.0.iter().enumerate().map(|(i, &buffer)| (buffer, sum(i))).collect();
        Curve { file: short_name(&report.file), each, lengths }
    }))
}

fn draw(curves: &[Curve], between: Between, path: &Path) -> Result<(), Failure> {
    let text = picture::draw(curves, between == Between::Flush)?;
    tristrip_io::replace_file(path, text.as_bytes()).map_err(|error| Failure::writing(&error))
}

impl BufferRow {
    fn of(buffer: Buffer, used: BufferUse) -> Self {
        let (acmr, atvr) = (rounded(used.acmr()), rounded(used.atvr()));
        Self { buffer: buffer.to_string(), misses: used.misses, acmr, atvr }
    }
}

impl AnalyzeReport {
    fn new(file: String, between: Between) -> Self {
        Self {
            file,
            seconds: AnalyzeSeconds::default(),
            figures: None,
            indices_per_triangle: None,
            lengths: Vec::new(),
            flushed: between == Between::Flush,
            buffers: Vec::new(),
            parts: None,
            by_part: Vec::new(),
            notes: Vec::new(),
            plot: None,
            error: None,
        }
    }

    fn as_text(&self) -> String {
        let Some(figures) = &self.figures else { return String::new() };
        let mut text = table(&figure_rows(figures), 1..2);
        text.push('\n');
        text.push_str(&table(&self.buffer_rows(), 1..4));
        if !self.lengths.is_empty() {
            text.push_str("\n  strips by their triangles\n");
            text.push_str(&table(&length_rows(&self.lengths), 1..2));
        }
        if self.by_part.len() > 1 {
            text.push('\n');
            text.push_str(&table(&self.part_rows(), 3..7));
            let more = self.by_part.len().saturating_sub(PARTS_SHOWN);
            if more > 0 {
                text.push_str("  and ");
                text.push_str(&counted(more, "part"));
                text.push_str(" more; --json has them all\n");
            }
        }
        text
    }

    fn buffer_rows(&self) -> Vec<Vec<String>> {
        let how = if self.flushed { "  buffer, flushed between strips" } else { "  buffer" };
        let head = [how, "misses", "ACMR", "ATVR"].map(String::from).to_vec();
        let row = |row: &BufferRow| {
            vec![
                format!("  {}", row.buffer),
                count(row.misses),
                format!("{:.3}", row.acmr),
                format!("{:.3}", row.atvr),
            ]
        };
        std::iter::once(head).chain(self.buffers.iter().map(row)).collect()
    }

    fn part_rows(&self) -> Vec<Vec<String>> {
        let buffer = self.buffers.first().map_or(String::new(), |row| format!("ACMR {}", row.buffer));
        let head = ["  part", "name", "drawn as", "triangles", "strips", "indices", &buffer];
        let row = |(number, part): (usize, &PartRow)| {
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
        let rows = self.by_part.iter().enumerate().take(PARTS_SHOWN).map(row);
        std::iter::once(head.map(String::from).to_vec()).chain(rows).collect()
    }
}

fn figure_rows(figures: &Figures) -> Vec<Vec<String>> {
    let triangles = figures.triangles.max(1) as f64;
    let mut rows = Vec::new();
    let mut row =
        |name: &str, n: usize, remark: String| rows.push(vec![format!("  {name}"), count(n), remark]);
    row("triangles", figures.triangles, format!("drawn as {}", drawn_as(figures.drawn)));
    row("vertices in use", figures.vertices, String::new());
    row("indices", figures.indices, format!("{:.3} a triangle", figures.indices as f64 / triangles));
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

fn drawn_as(drawn: Drawn) -> &'static str {
    match drawn {
        Drawn::List => "a list",
        Drawn::Strips => "strips",
        Drawn::Fans => "fans",
        Drawn::Mixed => "lists, strips or fans by part",
    }
}

fn length_rows(bins: &[Bin]) -> Vec<Vec<String>> {
    let most = bins.iter().map(|bin| bin.strips).max().unwrap_or(0).max(1);
    let bar = |bin: &Bin| "#".repeat((bin.strips * BAR).div_ceil(most));
    bins.iter().map(|bin| vec![format!("  {}", bin.name()), count(bin.strips), bar(bin)]).collect()
}
