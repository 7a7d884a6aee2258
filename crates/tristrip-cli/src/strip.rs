//! `tristrip strip`: builds strips, verifies and writes them, and reports their metrics.

use std::path::Path;

use serde::Serialize;
use tristrip_io::Model;
use tristrip_pipeline::text::count;
use tristrip_pipeline::{DrawnParts, FileCost, encode, strip};
use tristrip_render::images::{self, RenderOptions};
use tristrip_render::text as render_text;

use crate::bound::gap_line;
use crate::clock::{STRIP_SECONDS, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::summary;
use crate::input::file_bytes;
use crate::job::{Job, Output};
use crate::output::{self, drawn_as};
use crate::reorder::GroupOrder;
use crate::report::{self, Batch};
use crate::search::check_interrupt;
use crate::stage::{load_job, show_mesh, show_proof, timed};
use crate::task::StripTask;

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Stripped {
    #[serde(flatten)]
    strips: strip::Outcome,
    /// The file that was written; `null` without `-o`.
    output: Option<String>,
    /// The layout of the strips; `null` without `-o`.
    layout: Option<&'static str>,
    /// The number of parts by what they are drawn as in the file; `null` without `-o`.
    drawn: Option<DrawnParts>,
    /// The input as it was read; `null` without `-o`.
    before: Option<FileCost>,
    /// The file that was written; `null` without `-o`.
    after: Option<FileCost>,
    /// The new vertex order of each group of parts that share vertices; `null` without
    /// `--reorder-vertices`.
    vertex_order: Option<Vec<GroupOrder>>,
    /// The PNG image of the strips; only with `--picture`.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
}

/// Returns the row of a file in a table.
fn file_row(name: &str, cost: &FileCost) -> Vec<String> {
    let bytes = cost.bytes.map_or_else(|| "unknown".into(), |bytes| render_text::bytes(bytes as usize));
    vec![format!("  {name}"), count(cost.indices), format!("{:.3}", cost.acmr_fifo_16), bytes]
}

/// Returns a table that compares the input with the written file, or an empty text if no file was
/// written.
fn before_and_after(stripped: &Stripped) -> String {
    let (Some(before), Some(after)) = (&stripped.before, &stripped.after) else { return String::new() };
    let head = ["", "indices", "ACMR, FIFO 16", "file"].map(str::to_owned).to_vec();
    render_text::table(&[head, file_row("before", before), file_row("after", after)], 1..4)
}

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &StripTask, console: &mut Console) -> bool {
    let show = |job: &Job, stripped: &Stripped, title: &str, console: &mut Console| {
        let metrics = summary(&stripped.strips.metrics);
        let files = before_and_after(stripped);
        console.result(&format!("{title}{metrics}{files}"), job.output.is_none());
    };
    let process = |job: &Job, console: &mut Console, clock: &StageClock| strip(job, task, console, clock);
    let batch = Batch { budget: task.budget, ..Batch::new(STRIP_SECONDS) };
    let reports = batch.process(&task.jobs, console, |job| job.input.name(), process, show);
    report::finish(&reports, console)
}

/// Runs all stages on one input.
fn strip(
    job: &Job,
    task: &StripTask,
    console: &mut Console,
    clock: &StageClock,
) -> Result<Stripped, Failure> {
    check_interrupt()?;
    let model = load_job(job, console, clock)?;
    let options = strip::Options::default().with_stripify(task.options).with_verify(task.verify);
    let strips = clock.observe_and_print(|observer| strip::run(&model, &options, observer))?;
    show_strips(&strips, model.notes.len(), console);
    let mut stripped = Stripped {
        strips,
        output: None,
        layout: None,
        drawn: None,
        before: None,
        after: None,
        vertex_order: None,
        picture: None,
    };
    if let Some(target) = &job.output {
        write((job, target), task, &model, &mut stripped, console, clock)?;
    }
    if let Some(path) = &task.picture {
        draw(path, &model, &stripped.strips, console)?;
        stripped.picture = Some(path.display().to_string());
    }
    // The report does not need the strips.
    stripped.strips.strips = Vec::new();
    Ok(stripped)
}

/// Prints the results of the strips. The first `read` notes are already printed.
fn show_strips(strips: &strip::Outcome, read: usize, console: &Console) {
    let strip::Outcome { mesh, notes, method, metrics, bound, proven, .. } = strips;
    show_mesh(mesh, notes, read, console);
    let what = format!("{} ({})", count(metrics.strips), method.description());
    console.stage("strips", &what, None);
    if let Some(gap) = bound {
        console.stage("bound", &gap_line(gap), None);
    }
    show_proof(*proven, mesh, console);
}

/// Writes each part as strips or as a list, whichever needs fewer indices. If requested, the
/// vertices are reordered by first use.
fn write(
    (job, target): (&Job, &Output),
    task: &StripTask,
    model: &Model,
    stripped: &mut Stripped,
    console: &mut Console,
    clock: &StageClock,
) -> Result<(), Failure> {
    let options = encode::Options::new(target.format).with_layout(target.layout).with_list(task.list);
    let options = options.with_reorder(task.reorder).with_verify(task.verify);
    let writing = clock.part();
    let strip::File { encoded, drawn, mut before, mut after, .. } =
        output::encode(target, &writing, |observer| stripped.strips.encode(model, &options, observer))?;
    before.bytes = file_bytes(&job.input);
    // As for an input, a `.gltf` has no size: it is more than one file.
    after.bytes = after.bytes.filter(|_| !target.separate);
    stripped.vertex_order = encoded.groups.as_ref().map(|groups| groups.iter().map(GroupOrder::of).collect());
    let how = drawn_as(target, drawn.found + drawn.stored > 0);
    output::write(target, how, &encoded, &mut stripped.strips.notes, &writing, console)?;
    (stripped.drawn, stripped.before, stripped.after) = (Some(drawn), Some(before), Some(after));
    (stripped.output, stripped.layout) = (Some(target.name()), Some(target.layout.name()));
    Ok(())
}

/// Draws the strips and writes the picture.
fn draw(path: &Path, model: &Model, strips: &strip::Outcome, console: &Console) -> Result<(), Failure> {
    console.doing("picture");
    let options = RenderOptions::default();
    let positions = model.parts.iter().map(|part| part.mesh.positions());
    let parts: Vec<_> = positions.zip(&strips.strips).collect();
    let (picture, seconds) = timed(|| images::strips(&parts, &options));
    tristrip_io::replace_file(path, &picture?).map_err(|error| Failure::writing(&error))?;
    let what = format!("{}, {} × {} pixels", path.display(), options.width, options.height);
    console.stage("picture", &what, Some(seconds));
    Ok(())
}
