//! `tristrip convert`: other formats and strip layouts, no new strips.

use tristrip::{Mesh, Method, Options};
use tristrip_io::{Drawing, Format, Part};

use crate::console::Console;
use crate::failure::Failure;
use crate::input::{load, meshes};
use crate::output::{self, Drawn};
use crate::report::{ConvertReport, Seconds};
use crate::stages::{Pool, find_strips, prepare, timed};
use crate::task::{ConvertTask, Job, layout_name};
use crate::text::counted;

/// Converts all inputs, one after the other; tells whether all were done.
pub(crate) fn run(task: &ConvertTask, pool: &Pool, console: &mut Console) -> bool {
    let mut reports = Vec::with_capacity(task.jobs.len());
    for job in &task.jobs {
        let mut report = ConvertReport {
            file: job.input.name(),
            proven: None,
            seconds: Seconds::default(),
            faces: None,
            triangles: None,
            strips: None,
            parts: None,
            notes: Vec::new(),
            output: None,
            layout: None,
            error: None,
        };
        console.begin(&report.file, None);
        let done = convert(job, task, pool, console, &mut report);
        console.end();
        if let Err(failure) = done {
            if matches!(failure, Failure::Unproven(_)) {
                report.proven = Some(false);
            }
            console.error(&format!("{}: {failure}", report.file));
            report.error = Some(failure.to_string());
        }
        reports.push(report);
    }
    console.json(&reports, task.jobs.len() > 1);
    reports.iter().all(|report| report.error.is_none())
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

    // Strips of the input stay strips where the format has them; a layout that was asked for makes strips of every part.
    let has_strips = job.output.as_ref().is_none_or(|output| output.format != Format::Obj);
    let as_strips = |part: &Part| task.as_strips || (part.stripped && has_strips);
    let stripped: Vec<&Mesh> =
        model.parts.iter().filter(|&part| as_strips(part)).map(|part| &part.mesh).collect();
    let mut strips = Vec::new();
    let any = task.as_strips || !stripped.is_empty();
    if any {
        console.doing("strips of the input's order");
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
    let drawn = Drawn { model: &model, drawings: &drawings, layout: target.layout };
    let written = output::write(target, &model, drawn, task.verify, console)?;
    report.seconds.write = Some(written.write_seconds);
    report.seconds.verify = written.verify_seconds;
    report.notes.extend(written.losses);
    report.output = Some(target.name());
    report.layout = any.then(|| layout_name(target.layout));
    report.proven = task.verify.then_some(true);
    Ok(())
}
