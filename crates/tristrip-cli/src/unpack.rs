//! `tristrip unpack`: reads a level of detail from a progressive GLB.

use std::io::Read;
use std::path::Path;

use serde::Serialize;
use tristrip_io::gltf::ProgressiveGlb;
use tristrip_io::{Drawing, Format};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Stage, encode, unpack};

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Input;
use crate::output;
use crate::report::{self, Batch};
use crate::task::UnpackTask;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[
    ("load", &[Stage::Load, Stage::Decode]),
    ("verify", &[Stage::ReadBack]),
    ("write", &[Stage::Encode, Stage::Write]),
];

/// The report on the input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Unpacked {
    /// Whether the written file draws exactly the triangles of the level when it is read back;
    /// `null` without `-o`, and if verification was disabled.
    proven: Option<bool>,
    #[serde(flatten)]
    outcome: unpack::Outcome,
    /// The file that was written; `null` without `-o`.
    output: Option<String>,
}

/// Reads the level; returns whether it succeeded.
pub(crate) fn run(task: &UnpackTask, console: &mut Console) -> bool {
    let show = |task: &UnpackTask, unpacked: &Unpacked, _: &str, console: &mut Console| {
        console.result(&summary(&unpacked.outcome), task.job.output.is_none());
    };
    let tasks = std::slice::from_ref(task);
    let reports = Batch::new(SECONDS).process(tasks, console, |task| task.job.input.name(), unpack, show);
    report::finish(&reports, console)
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

/// Opens a progressive GLB, which may be truncated.
pub(crate) fn open(input: &Input) -> Result<ProgressiveGlb, Failure> {
    let name = input.name();
    let opened = ProgressiveGlb::open(read(input)?).map_err(|error| Failure::reading(&name, &error))?;
    opened.ok_or_else(|| {
        let found = "found a file without a stream, expected a progressive GLB from `pack`";
        Failure::Input(format!("{found}; `pack` writes a plain GLB if a stream would not be smaller"))
    })
}

fn unpack(task: &UnpackTask, console: &mut Console, clock: &StageClock) -> Result<Unpacked, Failure> {
    let UnpackTask { job, goal, verify } = task;
    let glb = clock.timed(Stage::Load, || open(&job.input))?;
    let base_dir = job.input.path.as_ref().and_then(|path| path.parent()).map(Path::to_path_buf);
    let options = unpack::Options::default().with_goal(*goal).with_base_dir(base_dir);
    let mut outcome = clock.observe(|observer| unpack::run(&glb, &options, observer))?;
    drop(glb);
    let unpack::Outcome { level, levels, triangles, triangles_full, .. } = outcome;
    let what = format!(
        "level {} of {}: {} of {}",
        count(level),
        count(levels),
        count(triangles),
        counted(triangles_full, "triangle")
    );
    console.stage("load", &what, clock.seconds(&[Stage::Load, Stage::Decode]));
    let mut model = std::mem::take(&mut outcome.model);
    model.notes.iter().for_each(|note| console.note(note));
    let printed = model.notes.len();
    if let Some(problem) = &outcome.problem {
        console.warning(&job.input.name(), problem);
    }
    let Some(target) = &job.output else { return Ok(Unpacked { proven: None, outcome, output: None }) };
    if target.format == Format::Glb {
        let images = tristrip_io::embed_images(&mut model, job.input.path.as_deref());
        images.map_err(|error| Failure::reading(&job.input.name(), &error))?;
        model.notes.iter().skip(printed).for_each(|note| console.note(note));
        outcome.notes.extend(model.notes.iter().skip(printed).cloned());
    }
    let options = encode::Options::new(target.format).with_verify(*verify);
    let drawings = vec![Drawing::Faces; model.parts.len()];
    let writing = clock.part();
    let encoded =
        output::encode(target, &writing, |observer| encode::run(&model, &drawings, &options, observer))?;
    let how = output::drawn_as(target, false);
    output::write(target, how, &encoded, &mut outcome.notes, &writing, console)?;
    Ok(Unpacked { proven: verify.then_some(true), outcome, output: Some(target.name()) })
}

/// Returns a line that describes the level.
fn summary(unpacked: &unpack::Outcome) -> String {
    format!(
        "  level {} of {}, {} of {}, from {} in {}\n",
        count(unpacked.level),
        count(unpacked.levels),
        count(unpacked.triangles),
        counted(unpacked.triangles_full, "triangle"),
        counted(unpacked.bytes, "byte"),
        counted(unpacked.chunks, "chunk")
    )
}
