//! `tristrip simplify`: reduces the number of triangles by half-edge collapses.

use std::path::Path;

use serde::Serialize;
use tristrip_io::{Format, Model};
use tristrip_pipeline::simplify::Deviations;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Stage, simplify};
use tristrip_render::images::{Mode, TexturedModel, rows_of_sides};
use tristrip_render::text::table;

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::{Job, Output};
use crate::output::{self, drawn_as};
use crate::report::{self, Batch};
use crate::stage::{load_job, show_mesh, show_proof_of_collapses, timed};
use crate::task::SimplifyTask;

/// The width and height in pixels of each view of a picture.
const PICTURE_SIZE: u32 = 256;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[
    ("load", &[Stage::Load]),
    ("dual", &[Stage::Prepare]),
    ("simplify", &[Stage::Simplify, Stage::Rebuild]),
    ("fit", &[Stage::Fit]),
    ("compare", &[Stage::Compare]),
    ("verify", &[Stage::Prove, Stage::ReadBack]),
    ("write", &[Stage::Encode, Stage::Write]),
];

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Simplified {
    #[serde(flatten)]
    outcome: simplify::Outcome,
    /// The file that was written; `null` without `-o`.
    output: Option<String>,
    /// The PNG image of the model before and after; only with `--picture`.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
}

/// Simplifies all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &SimplifyTask, console: &mut Console) -> bool {
    let process = |job: &Job, console: &mut Console, clock: &StageClock| simplify(job, task, console, clock);
    let show = |job: &Job, simplified: &Simplified, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(&simplified.outcome)), job.output.is_none());
    };
    let reports = Batch::new(SECONDS).process(&task.jobs, console, |job| job.input.name(), process, show);
    report::finish(&reports, console)
}

fn simplify(
    job: &Job,
    task: &SimplifyTask,
    console: &mut Console,
    clock: &StageClock,
) -> Result<Simplified, Failure> {
    let model = load_job(job, console, clock)?;
    let format = job.output.as_ref().map_or(Format::Ply, |output| output.format);
    let options = task.options.with_format(format);
    let mut outcome = clock.observe_and_print(|observer| simplify::run(&model, &options, observer))?;
    show_result(&outcome, &job.input.name(), model.notes.len(), console);
    let mut picture = None;
    if let Some(path) = &task.picture {
        draw(path, [&model, &outcome.redrawn.model], console, &mut outcome.notes)?;
        picture = Some(path.display().to_string());
    }
    if let Some(target) = &job.output {
        let writing = clock.part();
        let encoded = output::encode(target, &writing, |observer| {
            outcome.encode(format, task.options.verify, observer)
        })?;
        output::write(target, drawn_as(target, false), &encoded, &mut outcome.notes, &writing, console)?;
    }
    // The report does not need the model.
    outcome.redrawn.model = Model::default();
    Ok(Simplified { outcome, output: job.output.as_ref().map(Output::name), picture })
}

/// Draws the model before and after simplification, and writes the picture.
fn draw(path: &Path, models: [&Model; 2], console: &Console, notes: &mut Vec<String>) -> Result<(), Failure> {
    console.doing("picture");
    let (drawn, seconds) = timed(|| {
        let [before, after] = [TexturedModel::new(models[0])?, TexturedModel::new(models[1])?];
        let picture = rows_of_sides(&[&before, &after], Mode::Textured, PICTURE_SIZE)?;
        Ok::<_, Failure>((picture, before))
    });
    let (picture, before) = drawn?;
    notes.extend(before.notes().iter().map(|note| format!("picture: {note}")));
    tristrip_io::replace_file(path, &picture).map_err(|error| Failure::writing(&error))?;
    console.stage("picture", &format!("{}, before and after from 8 sides", path.display()), Some(seconds));
    Ok(())
}

/// Prints the results of the collapses. The first `read` notes are already printed. The deviations
/// are in the summary.
fn show_result(outcome: &simplify::Outcome, name: &str, read: usize, console: &Console) {
    show_mesh(&outcome.mesh, &outcome.notes, read, console);
    let collapses = &outcome.collapses;
    let left = counted(collapses.triangles_after, "triangle");
    let done = counted(collapses.collapse_count, "collapse");
    console.stage("result", &format!("{left} after {done}"), None);
    if let Some(positions) = outcome.moved_positions {
        let what = format!("{} moved closer to the original", counted(positions, "position"));
        console.stage("result", &what, None);
    }
    show_proof_of_collapses(outcome.proven, console);
    if let Some(warning) = &outcome.warning {
        console.warning(name, warning);
    }
}

/// Formats a distance with about four digits.
fn distance(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x) { format!("{x:.4}") } else { format!("{x:.2e}") }
}

/// Returns a table of the sizes before and after.
fn summary(outcome: &simplify::Outcome) -> String {
    let row = |name: &str, before: usize, after: usize| {
        let share = 100.0 * after as f64 / before.max(1) as f64;
        vec![format!("  {name}"), count(before), count(after), format!("{share:.1} %")]
    };
    let head = vec![String::new(), "before".into(), "after".into(), String::new()];
    let collapses = &outcome.collapses;
    let rows = [
        head,
        row("triangles", collapses.triangles_before, collapses.triangles_after),
        row("vertices", outcome.vertices_before, outcome.vertices_after),
    ];
    let deviations = outcome.deviations.as_ref().map(|found| format!("  {}\n", deviation_line(found)));
    table(&rows, 1..4) + &deviations.unwrap_or_default() + &normals_line(outcome)
}

/// Returns a line about rebuilt normals, or an empty text if there are none.
fn normals_line(outcome: &simplify::Outcome) -> String {
    let counts = outcome.normals;
    let rebuilt = [
        (counts.repaired, "where they no longer match"),
        (counts.flat, "flat"),
        (counts.creased, "smooth up to the creases"),
    ];
    let rebuilt: Vec<String> = rebuilt
        .iter()
        .filter(|(parts, _)| *parts > 0)
        .map(|(parts, how)| format!("{how} in {}", counted(*parts, "part")))
        .collect();
    if rebuilt.is_empty() { String::new() } else { format!("  normals rebuilt: {}\n", rebuilt.join(", ")) }
}

/// Returns a line with the deviation of the result from the original.
fn deviation_line(found: &Deviations) -> String {
    let deviation = |what: &str, units: f64, percent: f64| {
        format!("{what} {} ({percent:.3} % of the diagonal)", distance(units))
    };
    let largest = deviation("largest deviation", found.largest_deviation, found.largest_deviation_percent);
    let rms = deviation("RMS", found.rms_deviation, found.rms_deviation_percent);
    let uv = found.uv_deviation_percent.map(|uv| format!(", texture {uv:.2} %")).unwrap_or_default();
    let texels = found.uv_deviation_texels.map(|texels| format!(" ({texels:.1} texels)")).unwrap_or_default();
    format!("{largest}, {rms}, normals {:.1}°{uv}{texels}", found.normal_deviation_degrees)
}
