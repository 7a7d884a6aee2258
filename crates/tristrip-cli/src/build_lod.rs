//! `tristrip build-lod`: builds the model of view-dependent detail, and writes it as `.tlod`.

use std::path::Path;
use std::time::Duration;

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip::lod::SkipStrips;
use tristrip::simplify::{SimplifyOptions, merge_tree};
use tristrip_io::tlod::{self, TlodLimits, TlodModel};
use tristrip_io::{Model, Part};
use tristrip_lab::text;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Event, Joined, MethodReport, Stopped, StripOptions, join, strip_observed};

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
    vertices: Option<usize>,
    triangles: Option<usize>,
    strips: Option<usize>,
    collapses: Option<usize>,
    /// The levels of the merge tree.
    levels: Option<usize>,
    /// The longest chain of collapses that each need the one before.
    height: Option<u32>,
    /// The size of the file.
    bytes: Option<usize>,
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
        vertices: None,
        triangles: None,
        strips: None,
        collapses: None,
        levels: None,
        height: None,
        bytes: None,
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
    let (joined, seconds) = timed(|| join(model));
    let load = load + seconds;
    report.seconds.load = Some(load);
    let built = collapse(joined?, load, task, console, report)?;
    let bytes = encode(&built, console, report)?;
    write(&task.output, &bytes, console, report)
}

/// Builds the strips of a mesh, proves them, and builds its merge tree.
fn collapse(
    Joined { mesh, notes, .. }: Joined,
    load: f64,
    task: &BuildLodTask,
    console: &mut Console,
    report: &mut BuildReport,
) -> Result<TlodModel, Failure> {
    let part = Part { mesh, ..Part::default() };
    let model = Model { parts: vec![part], notes, ..Model::default() };
    let strips = strips(&model, task.options, task.budget, load, console, report)?;
    let Some(Part { mesh, .. }) = model.parts.into_iter().next() else { return Err(no_strips()) };
    let triangles = strips.to_list();
    console.doing("collapse");
    let options = SimplifyOptions::default();
    let (tree, seconds) = timed(|| merge_tree(&mesh, triangles, task.order, &options));
    let tree = tree?;
    let levels = tree.level_ends.len();
    report.vertices = Some(mesh.vertex_count());
    report.triangles = Some(tree.sequence.triangles().len() / 3);
    report.strips = Some(strips.len());
    report.collapses = Some(tree.sequence.len());
    report.levels = Some(levels);
    report.seconds.collapse = Some(seconds);
    let what = format!(
        "{} in {} ({})",
        counted(tree.sequence.len(), "collapse"),
        counted(levels, "level"),
        task.order.name()
    );
    console.stage("collapse", &what, Some(seconds));
    TlodModel::new(mesh, strips, tree.sequence).map_err(|error| Failure::Unproven(error.to_string()))
}

/// Builds the strips of a model of one part, and proves that they draw its faces.
fn strips(
    model: &Model,
    options: StripifyOptions,
    budget: Option<Duration>,
    load: f64,
    console: &Console,
    report: &mut BuildReport,
) -> Result<tristrip::Strips, Failure> {
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
        _ => (),
    };
    let stages = Stages::new(console, load, show).with_budget(budget);
    let stripped = strip_observed(model, &StripOptions::default().with_stripify(options), &stages)?;
    stripped.strips.into_iter().next().ok_or_else(no_strips)
}

/// Returns the error of strips for another number of parts than one, which the pipeline never returns.
fn no_strips() -> Failure {
    Failure::Unproven("found no strips, expected those of one mesh".into())
}

/// Encodes a model, reads the bytes back, and compares. Also measures the height of the model.
fn encode(model: &TlodModel, console: &Console, report: &mut BuildReport) -> Result<Vec<u8>, Failure> {
    console.doing("verify");
    let (proof, seconds) = timed(|| {
        let bytes = encoded(model)?;
        let again = tlod::read(&bytes[..], &TlodLimits::default())
            .map_err(|error| Failure::Unproven(format!("the file, read back: {error}")))?;
        // Bytes are compared, not models: a value that is not a number differs from itself.
        if encoded(&again)? != bytes {
            return Err(Failure::Unproven("the file, read back, is another model".into()));
        }
        let height = SkipStrips::of_levels(&again.strips, &again.sequence)?.height();
        Ok((bytes, height))
    });
    let (bytes, height) = proof?;
    report.height = Some(height);
    report.proven = Some(true);
    report.seconds.verify = Some(report.seconds.verify.unwrap_or(0.0) + seconds);
    let what = format!("proven: the file holds the same model, of height {}", count(height as usize));
    console.stage("verify", &what, Some(seconds));
    Ok(bytes)
}

fn encoded(model: &TlodModel) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    tlod::write(model, &mut bytes).map_err(|error| Failure::writing(&error))?;
    Ok(bytes)
}

/// Writes the file under a temporary name, and renames it.
fn write(path: &Path, bytes: &[u8], console: &Console, report: &mut BuildReport) -> Result<(), Failure> {
    let (written, seconds) = timed(|| tristrip_io::replace_file(path, bytes));
    written.map_err(|error| Failure::writing(&error))?;
    let what = format!("{}, {}", path.display(), text::bytes(bytes.len()));
    console.stage("write", &what, Some(seconds));
    report.bytes = Some(bytes.len());
    report.seconds.write = Some(seconds);
    report.output = Some(path.display().to_string());
    Ok(())
}

/// Returns a table of the counts.
fn summary(report: &BuildReport) -> String {
    let row = |name: &str, n: Option<usize>| vec![format!("  {name}"), count(n.unwrap_or(0))];
    let rows = [
        row("vertices", report.vertices),
        row("triangles", report.triangles),
        row("strips", report.strips),
        row("collapses", report.collapses),
        row("levels of the merge tree", report.levels),
        row("height", report.height.map(|height| height as usize)),
    ];
    text::table(&rows, 1..2)
}
