//! `tristrip convert`: converts between formats and strip layouts, without building new strips.

use serde::Serialize;
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{ConvertOptions, Event, meshes, strips_as_stored};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{self, WriteReport};
use crate::stage::{Seconds, Stages, load_job};
use crate::task::ConvertTask;

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
pub(crate) fn run(task: &ConvertTask, console: &mut Console) -> bool {
    let new_report = |job: &Job| ConvertReport { file: job.input.name(), ..ConvertReport::default() };
    let process =
        |job: &Job, console: &mut Console, report: &mut ConvertReport| convert(job, task, console, report);
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, |_, _, _, _| ());
    batch::finish(reports, console)
}

fn convert(
    job: &Job,
    task: &ConvertTask,
    console: &mut Console,
    report: &mut ConvertReport,
) -> Result<(), Failure> {
    let (model, load) = load_job(job, console)?;
    let meshes = meshes(&model);
    let faces = meshes.iter().map(|mesh| mesh.faces().face_count()).sum();
    report.seconds.load = Some(load);
    report.faces = Some(faces);
    report.triangles = Some(meshes.iter().map(|mesh| mesh.faces().triangle_count()).sum());
    report.parts = Some(meshes.len());
    report.notes.clone_from(&model.notes);
    let size = format!("{}, {}", counted(meshes.len(), "part"), counted(faces, "face"));
    console.stage("load", &size, Some(load));
    model.notes.iter().for_each(|note| console.note(note));
    let Some(target) = &job.output else { return Ok(()) };

    let mut options = ConvertOptions::new(target.format).with_verify(task.verify);
    if task.as_strips {
        options = options.with_layout(target.layout);
    }
    let show = |event: Event<'_>, seconds: f64| match event {
        Event::Prepared => report.seconds.dual = Some(seconds),
        Event::Stripified { strips, .. } => {
            (report.seconds.stripify, report.strips) = (Some(seconds), Some(strips));
            let what = format!("{} in the input's order", counted(strips, "strip"));
            console.stage("strips", &what, report.seconds.dual.map(|dual| dual + seconds));
        }
        _ => (),
    };
    let strips = strips_as_stored(&model, &options, &Stages::new(console, load, show))?;
    let any = report.strips.is_some();
    let fields = WriteReport {
        write: &mut report.seconds.write,
        verify: &mut report.seconds.verify,
        notes: &mut report.notes,
        vertex_order: None,
    };
    let drawn = strips.iter().any(Option::is_some);
    output::write(target, drawn, console, fields, |observer| options.encode(&model, &strips, observer))?;
    report.output = Some(target.name());
    report.layout = any.then(|| target.layout.name());
    report.proven = task.verify.then_some(true);
    Ok(())
}
