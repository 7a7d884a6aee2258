//! `tristrip convert`: converts between formats and strip layouts, without building new strips.

use serde::Serialize;
use tristrip::{Mesh, Method, Options};
use tristrip_io::{Drawing, Format, Part};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{load, meshes};
use crate::output::{self, ModelDrawing};
use crate::stages::{Pool, Seconds, find_strips, prepare, timed};
use crate::task::{ConvertTask, Job};
use crate::text::counted;
use crate::values::layout_name;

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct ConvertReport {
    file: String,
    proven: Option<bool>,
    seconds: Seconds,
    faces: Option<usize>,
    triangles: Option<usize>,
    strips: Option<usize>,
    parts: Option<usize>,
    notes: Vec<String>,
    output: Option<String>,
    layout: Option<&'static str>,
    error: Option<String>,
}

impl InputReport for ConvertReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Converts all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &ConvertTask, pool: &Pool, console: &mut Console) -> bool {
    let new_report = |job: &Job| ConvertReport { file: job.input.name(), ..ConvertReport::default() };
    let process = |job: &Job, console: &mut Console, report: &mut ConvertReport| {
        convert(job, task, pool, console, report)
    };
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, |_, _, _, _| ());
    batch::finish(reports, console)
}

fn convert(
    job: &Job,
    task: &ConvertTask,
    pool: &Pool,
    console: &mut Console,
    report: &mut ConvertReport,
) -> Result<(), Failure> {
    console.doing("load");
    let (model, seconds) = timed(|| load(&job.input));
    let model = model?;
    let meshes = meshes(&model);
    let faces = meshes.iter().map(|mesh| mesh.faces().face_count()).sum();
    report.seconds.load = Some(seconds);
    report.faces = Some(faces);
    report.triangles = Some(meshes.iter().map(|mesh| mesh.faces().triangle_count()).sum());
    report.parts = Some(meshes.len());
    report.notes.clone_from(&model.notes);
    let size = format!("{}, {}", counted(meshes.len(), "part"), counted(faces, "face"));
    console.stage("load", &size, Some(seconds));
    model.notes.iter().for_each(|note| console.note(note));

    // Strips of the input stay strips if the format has strips; with --layout, every part becomes strips.
    let has_strips = job.output.as_ref().is_none_or(|output| output.format != Format::Obj);
    let as_strips = |part: &Part| task.as_strips || (part.stripped && has_strips);
    let stripped: Vec<&Mesh> =
        model.parts.iter().filter(|&part| as_strips(part)).map(|part| &part.mesh).collect();
    let mut strips = Vec::new();
    let any = task.as_strips || !stripped.is_empty();
    if any {
        console.doing("strips in the input's order");
        let (parts, dual_seconds) = timed(|| prepare(pool, &stripped, false));
        let options = Options::default().with_method(Method::Input);
        let (found, seconds) = timed(|| find_strips(pool, &parts, &options, &()));
        strips = found?.strips;
        report.seconds.dual = Some(dual_seconds);
        report.seconds.stripify = Some(seconds);
        let strip_count = strips.iter().map(tristrip::Strips::len).sum();
        report.strips = Some(strip_count);
        let what = format!("{} in the input's order", counted(strip_count, "strip"));
        console.stage("strips", &what, Some(dual_seconds + seconds));
    }
    let mut of_parts = strips.iter();
    let next = |part| if as_strips(part) { of_parts.next() } else { None };
    let drawings: Vec<_> =
        model.parts.iter().map(next).map(|strips| strips.map_or(Drawing::Faces, Drawing::Strips)).collect();
    let Some(target) = &job.output else { return Ok(()) };
    let drawing = ModelDrawing { model: &model, drawings: &drawings, layout: target.layout };
    let written = output::write(target, &model, drawing, task.verify, console)?;
    written.record(&mut report.seconds.write, &mut report.seconds.verify, &mut report.notes);
    report.output = Some(target.name());
    report.layout = any.then(|| layout_name(target.layout));
    report.proven = task.verify.then_some(true);
    Ok(())
}
