//! `tristrip pack`: writes a model as a progressive GLB.

use serde::Serialize;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Packed, PackedReport, pack};
use tristrip_render::text;

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::write_file;
use crate::stage::{load_job, timed};
use crate::task::PackTask;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct PackSeconds {
    load: Option<f64>,
    pack: Option<f64>,
    write: Option<f64>,
}

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct PackReport {
    file: String,
    proven: Option<bool>,
    seconds: PackSeconds,
    parts: Option<usize>,
    #[serde(flatten)]
    packed: PackedReport,
    notes: Vec<String>,
    output: Option<String>,
    error: Option<String>,
}

impl InputReport for PackReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Packs all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &PackTask, console: &mut Console) -> bool {
    let new_report = |job: &Job| PackReport { file: job.input.name(), ..PackReport::default() };
    let process =
        |job: &Job, console: &mut Console, report: &mut PackReport| pack_job(job, task, console, report);
    let show = |_: &Job, report: &PackReport, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(report)), false);
    };
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

fn pack_job(
    job: &Job,
    task: &PackTask,
    console: &mut Console,
    report: &mut PackReport,
) -> Result<(), Failure> {
    let (model, load) = load_job(job, console)?;
    report.seconds.load = Some(load);
    report.parts = Some(model.parts.len());
    report.notes.clone_from(&model.notes);
    console.stage("load", &counted(model.parts.len(), "part"), Some(load));
    model.notes.iter().for_each(|note| console.note(note));
    console.doing("pack");
    let (packed, seconds) = timed(|| pack(&model, &task.options, &()));
    let packed: Packed = packed?;
    report.seconds.pack = Some(seconds);
    report.proven = packed.proven.map(|_| true);
    let what = format!(
        "{} of {} behind base meshes of {}",
        counted(packed.chunks, "chunk"),
        counted(packed.meshes, "mesh"),
        counted(packed.base_triangles, "triangle")
    );
    console.stage("pack", &what, Some(seconds));
    if let Some(triangles) = packed.proven {
        let what = format!("proven: the file holds exactly the {}", counted(triangles, "triangle"));
        console.stage("verify", &what, None);
    }
    packed.notes.iter().for_each(|note| console.note(note));
    packed.losses.iter().for_each(|loss| console.note(loss));
    let bytes = packed.bytes.len();
    report.packed = packed.report();
    report.notes.extend(packed.notes);
    report.notes.extend(packed.losses);
    if let Some(output) = &job.output {
        let (written, seconds) = timed(|| write_file(output, &packed.bytes, console));
        written?;
        console.stage("write", &format!("{}, {}", output.name(), text::bytes(bytes)), Some(seconds));
        report.seconds.write = Some(seconds);
        report.output = Some(output.name());
    }
    Ok(())
}

/// Returns a table of the counts.
fn summary(report: &PackReport) -> String {
    let packed = &report.packed;
    let row = |name: &str, n: Option<usize>| vec![format!("  {name}"), count(n.unwrap_or(0))];
    let rows = [
        row("vertices", packed.vertices),
        row("triangles", packed.triangles),
        row("triangles of base meshes", packed.base_triangles),
        row("chunks", packed.chunks),
        row("bytes", packed.bytes),
        row("bytes before the first chunk", packed.base_bytes),
        vec!["  bits per vertex".into(), format!("{:.2}", packed.bits_per_vertex.unwrap_or(0.0))],
    ];
    text::table(&rows, 1..2)
}
