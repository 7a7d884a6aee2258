//! `tristrip-lab pack` and `unpack`: the transmission format of paper 001.

use std::path::Path;

use serde::Serialize;
use tristrip_io::{Drawing, Format};
use tristrip_lab::wire::{self, Published};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Joined, encode, join, levels, levels::Level, unpack::StreamGoal};
use tristrip_render::text;

use crate::args::{PackArgs, UnpackArgs};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{load, timed};

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct WireSeconds {
    load: Option<f64>,
    pack: Option<f64>,
}

/// The report of `pack`; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct PackReport {
    file: String,
    proven: Option<bool>,
    seconds: WireSeconds,
    #[serde(flatten)]
    packed: Option<Published>,
    notes: Vec<String>,
    output: Option<String>,
    error: Option<String>,
}

/// The report of `unpack`; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct UnpackReport {
    file: String,
    seconds: WireSeconds,
    #[serde(flatten)]
    unpacked: Option<wire::Level>,
    notes: Vec<String>,
    output: Option<String>,
    error: Option<String>,
}

/// Encodes a mesh.
pub(crate) fn pack(args: &PackArgs, console: &Console) -> Result<(), Failure> {
    if Format::from_path(&args.output).is_some() {
        let output = args.output.display();
        let message = format!("{output}: pack writes its own format; use an extension such as .ps");
        return Err(Failure::Usage(message));
    }
    let mut report = PackReport { file: args.input.display().to_string(), ..PackReport::default() };
    let done = packed(args, console, &mut report);
    report.error = failed(done, console)?;
    finish(report.error.is_some(), &[report], console)
}

fn packed(args: &PackArgs, console: &Console, report: &mut PackReport) -> Result<(), Failure> {
    let (model, seconds) = load(&args.input, console)?;
    report.seconds.load = Some(seconds);
    let Joined { mesh, notes, .. } = join(model)?;
    report.notes = notes;
    let options = levels::Options::default().with_verify(!args.no_verify);
    let (packed, seconds) = timed(|| wire::pack(&mesh, &options));
    let packed = packed?;
    report.seconds.pack = Some(seconds);
    let base = counted(packed.base_triangles, "triangle");
    let what = format!("{} after a base mesh of {base}", counted(packed.levels, "split"));
    console.stage("pack", &what, Some(seconds));
    if let Some(triangles) = packed.proven {
        let what = format!("proven: the file draws exactly the {}", counted(triangles, "triangle"));
        console.stage("verify", &what, None);
    }
    report.proven = packed.proven.map(|_| true);
    tristrip_io::replace_file(&args.output, &packed.file)?;
    let what = format!("{}, {}", args.output.display(), text::bytes(packed.bytes));
    report.packed = Some(packed);
    console.stage("write", &what, None);
    report.output = Some(args.output.display().to_string());
    Ok(())
}

/// Reads a level.
pub(crate) fn unpack(args: &UnpackArgs, console: &Console) -> Result<(), Failure> {
    let mut report = UnpackReport { file: args.input.display().to_string(), ..UnpackReport::default() };
    let done = unpacked(args, console, &mut report);
    report.error = failed(done, console)?;
    finish(report.error.is_some(), &[report], console)
}

fn unpacked(args: &UnpackArgs, console: &Console, report: &mut UnpackReport) -> Result<(), Failure> {
    let goal = match (args.level, args.triangles, args.bytes) {
        (Some(level), ..) => StreamGoal::Level(level),
        (_, Some(triangles), _) => StreamGoal::Triangles(triangles),
        (.., Some(bytes)) => StreamGoal::Bytes(bytes),
        _ => StreamGoal::Level(Level::Percent(100.0)),
    };
    let (read, seconds) = timed(|| read(&args.input, goal));
    let unpacked = read?;
    report.seconds.load = Some(seconds);
    let level = report.unpacked.insert(unpacked);
    let (of, all) = (count(level.levels), counted(level.triangles_full, "triangle"));
    let what = format!("level {} of {of}: {} of {all}", count(level.level), count(level.triangles));
    console.result(&format!("{what}\n"))?;
    if level.ended_early {
        let note = "the file ends before the full mesh";
        console.note(note);
        report.notes.push(note.into());
    }
    let Some(output) = &args.output else { return Ok(()) };
    let Some(format) = Format::from_path(output) else {
        let known = "use .ply, .obj or .glb";
        return Err(Failure::Usage(format!("{}: unknown format; {known}", output.display())));
    };
    let drawings = vec![Drawing::Faces; level.model.parts.len()];
    let encoded = encode::run(&level.model, &drawings, &encode::Options::new(format), &())?;
    tristrip_io::replace_file(output, &encoded.bytes)?;
    report.output = Some(output.display().to_string());
    Ok(())
}

fn read(path: &Path, goal: StreamGoal) -> Result<wire::Level, Failure> {
    let bytes = std::fs::read(path)
        .map_err(|source| tristrip_io::Error::Io { path: path.display().to_string(), source })?;
    Ok(wire::unpack(&bytes, goal)?)
}

/// Prints the message of a failure and returns it for the report. Wrong usage is returned as a
/// failure.
fn failed(done: Result<(), Failure>, console: &Console) -> Result<Option<String>, Failure> {
    match done {
        Ok(()) => Ok(None),
        Err(Failure::Failed(message)) => {
            console.error(&message);
            Ok(Some(message))
        }
        Err(other) => Err(other),
    }
}

fn finish<T: Serialize>(has_failed: bool, reports: &[T], console: &Console) -> Result<(), Failure> {
    console.json(reports)?;
    if has_failed { Err(Failure::Reported) } else { Ok(()) }
}
