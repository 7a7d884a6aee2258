//! `tristrip build-lod`: builds a view-dependent LOD model and writes it as `.tlod`.

use serde::Serialize;
use tristrip_pipeline::Stage;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::view_model::{self, ViewModel};
use tristrip_render::text;

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::report::{self, Batch};
use crate::stage::{load_input, show_mesh, show_proof};
use crate::task::BuildLodTask;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[
    ("load", &[Stage::Load]),
    ("dual", &[Stage::Prepare]),
    ("stripify", &[Stage::Stripify]),
    ("collapse", &[Stage::Simplify]),
    ("verify", &[Stage::Prove, Stage::ReadBack]),
    ("write", &[Stage::Write]),
];

/// The report on the input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Built {
    #[serde(flatten)]
    outcome: view_model::Outcome,
    #[serde(flatten)]
    file: view_model::File,
    /// The file that was written.
    output: String,
}

/// Builds the model of the input; returns whether it succeeded.
pub(crate) fn run(task: &BuildLodTask, console: &mut Console) -> bool {
    let show = |_: &BuildLodTask, built: &Built, _: &str, console: &mut Console| {
        console.result(&summary(built), false);
    };
    let batch = Batch { budget: task.budget, ..Batch::new(SECONDS) };
    let tasks = std::slice::from_ref(task);
    let reports = batch.process(tasks, console, |task| task.input.name(), build, show);
    report::finish(&reports, console)
}

/// Runs all stages on the input.
fn build(task: &BuildLodTask, console: &mut Console, clock: &StageClock) -> Result<Built, Failure> {
    let model = load_input(&task.input, console, clock)?;
    let read = model.notes.len();
    let options = view_model::Options::default().with_stripify(task.options).with_order(task.order);
    let mut outcome = clock.observe_and_print(|observer| view_model::run(model, &options, observer))?;
    show_result(&outcome, read, console);
    let mut file = encode(&outcome.model, clock, console)?;
    // The report does not need the model or the bytes.
    outcome.model = ViewModel::default();
    let path = &task.output;
    let written = clock.timed(Stage::Write, || tristrip_io::replace_file(path, &file.bytes));
    written.map_err(|error| Failure::writing(&error))?;
    let what = format!("{}, {}", path.display(), text::bytes(file.file_bytes));
    console.stage("write", &what, clock.seconds(&[Stage::Write]));
    file.bytes = Vec::new();
    Ok(Built { outcome, file, output: path.display().to_string() })
}

/// Prints the results of the strips and the collapses. The first `read` notes are already printed.
fn show_result(outcome: &view_model::Outcome, read: usize, console: &Console) {
    show_mesh(&outcome.mesh, &outcome.notes, read, console);
    let what = format!("{} ({})", count(outcome.strips), outcome.method.description());
    console.stage("strips", &what, None);
    show_proof(outcome.proven, &outcome.mesh, console);
    let (collapses, levels) = (counted(outcome.collapses, "collapse"), counted(outcome.levels, "level"));
    let what = format!("{collapses} in {levels} ({})", outcome.order);
    console.stage("result", &what, None);
}

/// Encodes the model and reads the bytes back.
fn encode(model: &ViewModel, clock: &StageClock, console: &Console) -> Result<view_model::File, Failure> {
    let encoding = clock.part();
    let file = encoding.timed(Stage::ReadBack, || model.encode())?;
    let what = format!("proven: the file contains the same model (height {})", count(file.height as usize));
    console.stage("verify", &what, encoding.seconds(&[Stage::ReadBack]));
    Ok(file)
}

/// Returns a table of the counts.
fn summary(Built { outcome, file, .. }: &Built) -> String {
    let row = |name: &str, n: usize| vec![format!("  {name}"), count(n)];
    let rows = [
        row("vertices", outcome.vertices),
        row("triangles", outcome.triangles),
        row("strips", outcome.strips),
        row("collapses", outcome.collapses),
        row("levels of the merge tree", outcome.levels),
        row("height", file.height as usize),
    ];
    text::table(&rows, 1..2)
}
