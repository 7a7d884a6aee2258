//! `tristrip strip`: builds strips, verifies them, writes them, and reports their metrics.

use serde::Serialize;
use tristrip::{Method, Strips};
use tristrip_io::{Drawing, Model, Reordered};

use crate::batch::{self, InputReport, Outcome};
use crate::bound::{BoundGap, Bounds};
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::{Figures, MeshFigures};
use crate::input::short_name;
use crate::method::{Chosen, MethodReport};
use crate::output::{self, ModelDrawing};
use crate::pareto::{self, ParetoPoint, Searches};
use crate::reorder::{self, GroupReport};
use crate::search::{SearchWatch, Stopped, interrupted};
use crate::stages::{FoundStrips, Pool, Seconds, find_strips, prove, timed};
use crate::survey::{Loaded, Surveyed};
use crate::task::{Job, Output, ParetoTask, StripTask};
use crate::text::counted;
use crate::values::layout_name;

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Serialize)]
struct StripReport {
    file: String,
    #[serde(flatten)]
    method: MethodReport,
    /// The methods used, with their numbers of parts; `null` if no strips were built.
    chosen: Option<Chosen>,
    /// `null` if the proof was not requested or not reached.
    proven: Option<bool>,
    seconds: Seconds,
    #[serde(flatten)]
    figures: Option<Figures>,
    /// Why the search was stopped early, if it was.
    stopped: Option<Stopped>,
    /// The gap between the result of a search and its lower bound; `null` for methods that do not search.
    bound: Option<BoundGap>,
    mesh: Option<MeshFigures>,
    parts: Option<usize>,
    notes: Vec<String>,
    output: Option<String>,
    layout: Option<&'static str>,
    /// The new vertex order; `null` unless requested.
    vertex_order: Option<Vec<GroupReport>>,
    /// The costs of all methods; `null` unless requested.
    pareto: Option<Vec<ParetoPoint>>,
    error: Option<String>,
}

impl InputReport for StripReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &StripTask, pool: &Pool, console: &mut Console) -> bool {
    let new_report = |job: &Job| StripReport {
        file: job.input.name(),
        method: MethodReport::of(&task.options),
        chosen: None,
        proven: None,
        seconds: Seconds::default(),
        figures: None,
        stopped: None,
        bound: None,
        mesh: None,
        parts: None,
        notes: Vec::new(),
        output: None,
        layout: None,
        vertex_order: None,
        pareto: None,
        error: None,
    };
    let show = |job: &Job, report: &StripReport, title: &str, console: &mut Console| {
        let figures = report.figures.as_ref().map(Figures::summary).unwrap_or_default();
        let methods = report.pareto.as_deref().map(pareto::as_text).unwrap_or_default();
        console.result(&format!("{title}{figures}{methods}"), job.output.is_none());
    };
    let process =
        |job: &Job, console: &mut Console, report: &mut StripReport| strip(job, task, pool, console, report);
    let mut reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    if let Some(ParetoTask { path, .. }) = &task.pareto {
        let points =
            reports.iter().filter_map(|report| Some((short_name(&report.file), report.pareto.as_deref()?)));
        let points: Vec<_> = points.collect();
        if !points.is_empty() {
            let chart = pareto::draw(&points);
            batch::write_chart(path, chart, &mut reports, console);
        }
    }
    batch::finish(reports, console)
}

/// Takes one input through all stages; the report holds the stages reached.
fn strip(
    job: &Job,
    task: &StripTask,
    pool: &Pool,
    console: &mut Console,
    report: &mut StripReport,
) -> Result<(), Failure> {
    if interrupted() {
        return Err(Failure::Input("not processed: interrupted".into()));
    }
    let loaded = Loaded::new(&job.input, task.options, console)?;
    let (model, options) = (&loaded.model, loaded.options);
    let Surveyed { parts, mesh, notes, seconds } = loaded.survey(pool, console);
    let faces = mesh.faces;
    (report.seconds, report.notes) = (seconds, notes);
    (report.parts, report.mesh) = (Some(parts.len()), Some(mesh));

    console.doing("stripify");
    let watch = SearchWatch::new(console.progress(), task.budget, &options);
    let (found, seconds) = timed(|| find_strips(pool, &parts, &options, &watch));
    let FoundStrips { strips, chosen } = found?;
    report.stopped = watch.stopped();
    drop(watch);
    report.seconds.stripify = Some(seconds);
    let figures = Figures::of(pool, &parts, &strips, &options);
    let chosen = Chosen::of(&chosen);
    let what = format!("{} ({})", counted(figures.strips, "strip"), report.method.description(&chosen));
    console.stage("stripify", &what, Some(seconds));
    report.chosen = Some(chosen);
    if let Some(stopped) = report.stopped {
        console.note(stopped.note());
        report.notes.push(stopped.note().into());
    }
    if matches!(options.method(), Method::Best | Method::Fewest) {
        console.doing("bound");
        let (bounds, seconds) = timed(|| Bounds::of(pool, &parts));
        report.bound = bounds.gap(&options, &figures);
        if let Some(gap) = &report.bound {
            console.stage("bound", &gap.line(), Some(seconds));
        }
    }
    report.figures = Some(figures);

    if task.verify {
        console.doing("verify");
        let (proof, seconds) = timed(|| prove(pool, &parts, &strips, &options));
        proof?;
        report.seconds.verify = Some(seconds);
        report.proven = Some(true);
        console.stage("verify", &proven(faces), Some(seconds));
    } else {
        console.stage("verify", "skipped", None);
    }
    // Only the chart of all methods still needs the prepared parts; otherwise free them before writing.
    let parts = task.pareto.as_ref().map(|wanted| (wanted, parts));
    if let Some(target) = &job.output {
        write(target, task, model, strips, console, report)?;
    }
    let Some((wanted, parts)) = parts else { return Ok(()) };
    let searches = Searches { effort: wanted.effort, budget: task.budget };
    let (points, seconds) = timed(|| pareto::measure(pool, &parts, &options, searches, console));
    let (points, notes) = points?;
    console.stage("pareto", &pareto::line(&points), Some(seconds));
    notes.iter().for_each(|note| console.note(note));
    report.notes.extend(notes);
    report.pareto = Some(points);
    Ok(())
}

/// Writes the strips, with the vertices in order of first use if requested.
fn write(
    target: &Output,
    task: &StripTask,
    source: &Model,
    strips: Vec<Strips>,
    console: &mut Console,
    report: &mut StripReport,
) -> Result<(), Failure> {
    let (mut model, mut strips, mut layout, mut reorder_seconds) = (source, strips, target.layout, 0.0);
    let reordered;
    if task.reorder {
        console.doing("reorder");
        let (result, seconds) = timed(|| tristrip_io::reorder(source, &strips, target.format, layout));
        let Reordered { model: moved, strips: renamed, layout: fitting, groups } =
            result.map_err(|error| Failure::writing(&error))?;
        console.stage("reorder", &reorder::line(&groups), Some(seconds));
        let kept = reorder::kept(&groups);
        kept.iter().for_each(|note| console.note(note));
        report.notes.extend(kept);
        report.vertex_order = Some(groups.iter().map(GroupReport::of).collect());
        reordered = moved;
        (model, strips, layout, reorder_seconds) = (&reordered, renamed, fitting, seconds);
    }
    let drawings: Vec<_> = strips.iter().map(Drawing::Strips).collect();
    let drawing = ModelDrawing { model, drawings: &drawings, layout };
    let mut written = output::write(target, source, drawing, task.verify, console)?;
    written.write_seconds += reorder_seconds;
    written.record(&mut report.seconds.write, &mut report.seconds.verify, &mut report.notes);
    report.output = Some(target.name());
    report.layout = Some(layout_name(target.layout));
    Ok(())
}

/// Returns a line on what was proven.
fn proven(faces: usize) -> String {
    match faces {
        0 => "proven: draws no faces, as the source".into(),
        1 => "proven: draws exactly the one face, with its winding".into(),
        _ => format!("proven: draws exactly the {}, each once, with its winding", counted(faces, "face")),
    }
}
