//! `tristrip unpack`: reads a level of detail from a progressive GLB.

use std::io::Read;

use serde::Serialize;
use tristrip_io::gltf::ProgressiveGlb;
use tristrip_io::{Drawing, Format};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{EncodeOptions, Unpacked, UnpackedReport, encode_observed, unpack};

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::output::{self, WriteReport};
use crate::stage::{Seconds, timed};
use crate::task::UnpackTask;

/// The report of the input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct UnpackReport {
    file: String,
    proven: Option<bool>,
    seconds: Seconds,
    #[serde(flatten)]
    unpacked: UnpackedReport,
    notes: Vec<String>,
    output: Option<String>,
    error: Option<String>,
}

impl InputReport for UnpackReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Reads the level; returns whether this succeeded.
pub(crate) fn run(task: &UnpackTask, console: &mut Console) -> bool {
    let new_report =
        |task: &UnpackTask| UnpackReport { file: task.job.input.name(), ..UnpackReport::default() };
    let process = |task: &UnpackTask, console: &mut Console, report: &mut UnpackReport| {
        unpack_job(task, console, report)
    };
    let show = |task: &UnpackTask, report: &UnpackReport, _: &str, console: &mut Console| {
        console.result(&summary(report), task.job.output.is_none());
    };
    let reports = batch::process_all(std::slice::from_ref(task), None, console, new_report, process, show);
    batch::finish(reports, console)
}

/// Reads all bytes of an input.
fn read(input: &Input) -> Result<Vec<u8>, Failure> {
    let name = input.name();
    let failed = |source| Failure::reading(&name, &tristrip_io::Error::Io { path: name.clone(), source });
    let mut bytes = Vec::new();
    if let Some(path) = &input.path {
        bytes = std::fs::read(path).map_err(failed)?;
    } else {
        std::io::stdin().lock().read_to_end(&mut bytes).map_err(failed)?;
    }
    Ok(bytes)
}

/// Opens a progressive GLB, which may be cut off.
pub(crate) fn open(input: &Input) -> Result<ProgressiveGlb, Failure> {
    opened(input, read(input)?)
}

fn opened(input: &Input, bytes: Vec<u8>) -> Result<ProgressiveGlb, Failure> {
    let name = input.name();
    let opened = ProgressiveGlb::open(bytes).map_err(|error| Failure::reading(&name, &error))?;
    opened.ok_or_else(|| Failure::Input(
            "no progressive GLB: `pack` writes them, but a model that a stream would not make smaller as a plain GLB".into(),
        ))
}

fn unpack_job(task: &UnpackTask, console: &mut Console, report: &mut UnpackReport) -> Result<(), Failure> {
    let UnpackTask { job, goal, verify } = task;
    console.doing("load");
    let folder = job.input.path.as_ref().and_then(|path| path.parent());
    let (unpacked, seconds) = timed(|| {
        let bytes = read(&job.input)?;
        Ok::<_, Failure>(unpack(&opened(&job.input, bytes)?, *goal, folder)?)
    });
    let unpacked = unpacked?;
    report.seconds.load = Some(seconds);
    report.unpacked = unpacked.report();
    let Unpacked { mut model, level, full_level, triangles, full_triangles, problem, .. } = unpacked;
    report.notes.clone_from(&model.notes);
    let what = format!(
        "level {} of {}: {} of {}",
        count(level),
        count(full_level),
        count(triangles),
        counted(full_triangles, "triangle")
    );
    console.stage("load", &what, Some(seconds));
    model.notes.iter().for_each(|note| console.note(note));
    if let Some(problem) = problem {
        console.warning(&report.file, &problem);
        report.notes.push(problem);
    }
    let Some(target) = &job.output else { return Ok(()) };
    if target.format == Format::Glb {
        let images = tristrip_io::embed_images(&mut model, job.input.path.as_deref());
        images.map_err(|error| Failure::reading(&report.file, &error))?;
    }
    let options = EncodeOptions::new(target.format).with_verify(*verify);
    let drawings = vec![Drawing::Faces; model.parts.len()];
    let fields = WriteReport {
        write: &mut report.seconds.write,
        verify: &mut report.seconds.verify,
        notes: &mut report.notes,
        vertex_order: None,
    };
    output::write(target, false, console, fields, |observer| {
        encode_observed(&model, &drawings, &options, observer)
    })?;
    report.output = Some(target.name());
    report.proven = verify.then_some(true);
    Ok(())
}

/// Returns a line on the level.
fn summary(report: &UnpackReport) -> String {
    let unpacked = &report.unpacked;
    let number = |n: Option<usize>| count(n.unwrap_or(0));
    format!(
        "  level {} of {}, {} of {} triangles, from {} bytes in {} chunks\n",
        number(unpacked.level),
        number(unpacked.levels),
        number(unpacked.triangles),
        number(unpacked.triangles_full),
        number(unpacked.bytes),
        number(unpacked.chunks)
    )
}
