//! `tristrip pack`: writes a model as a progressive GLB.

use serde::Serialize;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Stage, pack};
use tristrip_render::text;

use crate::clock::{PACKING, SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::write_file;
use crate::report::{self, Batch};
use crate::stage::load_job;
use crate::task::PackTask;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys =
    &[("load", &[Stage::Load]), ("pack", PACKING), ("write", &[Stage::Write])];

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Packed {
    #[serde(flatten)]
    outcome: pack::Outcome,
    /// The file that was written; `null` without `-o`.
    output: Option<String>,
}

/// Packs all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &PackTask, console: &mut Console) -> bool {
    let process = |job: &Job, console: &mut Console, clock: &StageClock| pack(job, task, console, clock);
    let show = |_: &Job, packed: &Packed, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(&packed.outcome)), false);
    };
    let reports = Batch::new(SECONDS).process(&task.jobs, console, |job| job.input.name(), process, show);
    report::finish(&reports, console)
}

fn pack(job: &Job, task: &PackTask, console: &mut Console, clock: &StageClock) -> Result<Packed, Failure> {
    let model = load_job(job, console, clock)?;
    let mut outcome = clock.observe_and_print(|observer| pack::run(&model, &task.options, observer))?;
    let what = format!(
        "{}, {}, {} in the base meshes",
        counted(outcome.chunks, "chunk"),
        counted(outcome.meshes, "mesh"),
        counted(outcome.base_triangles, "triangle")
    );
    console.stage("result", &what, None);
    if let Some(triangles) = outcome.proven {
        let what = format!("the file contains exactly {}", counted(triangles, "triangle"));
        console.stage("proven", &what, None);
    }
    outcome.notes.iter().skip(model.notes.len()).for_each(|note| console.note(note));
    // The report does not need the bytes.
    let bytes = std::mem::take(&mut outcome.bytes);
    let Some(output) = &job.output else { return Ok(Packed { outcome, output: None }) };
    clock.timed(Stage::Write, || write_file(output, &bytes, console))?;
    let what = format!("{}, {}", output.name(), text::bytes(bytes.len()));
    console.stage("write", &what, clock.seconds(&[Stage::Write]));
    Ok(Packed { outcome, output: Some(output.name()) })
}

/// Returns a table of the counts.
fn summary(packed: &pack::Outcome) -> String {
    let row = |name: &str, n: usize| vec![format!("  {name}"), count(n)];
    let rows = [
        row("vertices", packed.vertices),
        row("triangles", packed.triangles),
        row("triangles of base meshes", packed.base_triangles),
        row("chunks", packed.chunks),
        row("bytes", packed.file_bytes),
        row("bytes before the first chunk", packed.base_bytes),
        vec!["  bits per vertex".into(), format!("{:.2}", packed.bits_per_vertex.unwrap_or(0.0))],
    ];
    text::table(&rows, 1..2)
}
