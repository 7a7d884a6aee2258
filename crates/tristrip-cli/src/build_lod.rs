//! `tristrip build-lod`: builds the model of view-dependent detail, and writes it as `.tlod`.

use std::path::Path;

use serde::Serialize;
use tristrip_io::Model;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{
    Event, MethodReport, Stopped, ViewModel, ViewModelOptions, ViewModelReport, view_model,
};
use tristrip_render::text;

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::stage::{Stages, load_timed, show_search, timed};
use crate::task::BuildLodTask;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct BuildSeconds {
    load: Option<f64>,
    dual: Option<f64>,
    stripify: Option<f64>,
    collapse: Option<f64>,
    verify: Option<f64>,
    write: Option<f64>,
}

/// The report of the input; the keys are those of the JSON output.
#[derive(Debug, Serialize)]
struct BuildReport {
    file: String,
    #[serde(flatten)]
    method: MethodReport,
    order: &'static str,
    proven: Option<bool>,
    seconds: BuildSeconds,
    #[serde(flatten)]
    model: ViewModelReport,
    /// Why the search for strips was stopped early, if it was.
    stopped: Option<Stopped>,
    parts: Option<usize>,
    notes: Vec<String>,
    output: Option<String>,
    error: Option<String>,
}

impl InputReport for BuildReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Builds the model of the input; returns whether this succeeded.
pub(crate) fn run(task: &BuildLodTask, console: &mut Console) -> bool {
    let new_report = |task: &BuildLodTask| BuildReport {
        file: task.input.name(),
        method: MethodReport::of(&task.options),
        order: task.order.name(),
        proven: None,
        seconds: BuildSeconds::default(),
        model: ViewModelReport::default(),
        stopped: None,
        parts: None,
        notes: Vec::new(),
        output: None,
        error: None,
    };
    let process =
        |task: &BuildLodTask, console: &mut Console, report: &mut BuildReport| build(task, console, report);
    let show = |_: &BuildLodTask, report: &BuildReport, _: &str, console: &mut Console| {
        console.result(&summary(report), false);
    };
    let reports = batch::process_all(std::slice::from_ref(task), None, console, new_report, process, show);
    batch::finish(reports, console)
}

/// Takes the input through all stages; the report holds the stages reached.
fn build(task: &BuildLodTask, console: &mut Console, report: &mut BuildReport) -> Result<(), Failure> {
    let (model, load) = load_timed(&task.input, console)?;
    report.parts = Some(model.parts.len());
    report.seconds.load = Some(load);
    let built = built(model, task, load, console, report)?;
    console.doing("verify");
    let (encoded, seconds) = timed(|| built.encode());
    let encoded = encoded?;
    report.model.height = Some(encoded.height);
    report.proven = Some(true);
    report.seconds.verify = Some(report.seconds.verify.unwrap_or(0.0) + seconds);
    let what = format!("proven: the file holds the same model, of height {}", count(encoded.height as usize));
    console.stage("verify", &what, Some(seconds));
    write(&task.output, &encoded.bytes, console, report)
}

/// Builds the strips of all parts together, proves them, and builds their merge tree.
fn built(
    model: Model,
    task: &BuildLodTask,
    load: f64,
    console: &Console,
    report: &mut BuildReport,
) -> Result<ViewModel, Failure> {
    let show = |event: Event<'_>, seconds: f64| match event {
        Event::Prepared => report.seconds.dual = Some(seconds),
        Event::Surveyed { notes, .. } => report.notes = notes.to_vec(),
        Event::Stripified { strips, stopped } => {
            (report.seconds.stripify, report.stopped) = (Some(seconds), stopped);
            let what = format!("{} ({})", counted(strips, "strip"), report.method.description());
            show_search(&what, seconds, stopped, console, &mut report.notes);
        }
        Event::Proven { faces } => {
            report.seconds.verify = Some(seconds);
            let what = format!("proven: the strips draw exactly the {}", counted(faces, "face"));
            console.stage("verify", &what, Some(seconds));
        }
        Event::Merged { collapses, levels } => {
            report.seconds.collapse = Some(seconds);
            let (collapses, levels) = (counted(collapses, "collapse"), counted(levels, "level"));
            let what = format!("{collapses} in {levels} ({})", task.order.name());
            console.stage("collapse", &what, Some(seconds));
        }
        _ => (),
    };
    let options = ViewModelOptions::default().with_stripify(task.options).with_order(task.order);
    let stages = Stages::new(console, load, show).with_budget(task.budget);
    let built = view_model(model, &options, &stages)?;
    report.model = built.report();
    Ok(built)
}

/// Writes the file under a temporary name, and renames it.
fn write(path: &Path, bytes: &[u8], console: &Console, report: &mut BuildReport) -> Result<(), Failure> {
    let (written, seconds) = timed(|| tristrip_io::replace_file(path, bytes));
    written.map_err(|error| Failure::writing(&error))?;
    let what = format!("{}, {}", path.display(), text::bytes(bytes.len()));
    console.stage("write", &what, Some(seconds));
    report.model.bytes = Some(bytes.len());
    report.seconds.write = Some(seconds);
    report.output = Some(path.display().to_string());
    Ok(())
}

/// Returns a table of the counts.
fn summary(report: &BuildReport) -> String {
    let model = &report.model;
    let row = |name: &str, n: Option<usize>| vec![format!("  {name}"), count(n.unwrap_or(0))];
    let rows = [
        row("vertices", model.vertices),
        row("triangles", model.triangles),
        row("strips", model.strips),
        row("collapses", model.collapses),
        row("levels of the merge tree", model.levels),
        row("height", model.height.map(|height| height as usize)),
    ];
    text::table(&rows, 1..2)
}
