//! `tristrip simplify`: reduces the number of triangles by half-edge collapses.

use std::path::Path;

use serde::Serialize;
use tristrip_io::{Format, Model};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Event, SimplifyFigures, simplify_observed};
use tristrip_render::images::{Mode, TexturedModel, rows_of_sides};
use tristrip_render::text::table;

use crate::batch::{self, InputReport, Outcome};
use crate::collapses::CollapseFields;
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{self, WriteReport};
use crate::stage::{Stages, load_job, timed};
use crate::task::SimplifyTask;

/// The width and height in pixels of each view of a picture.
const PICTURE_SIZE: u32 = 256;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct SimplifySeconds {
    load: Option<f64>,
    dual: Option<f64>,
    simplify: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<f64>,
    compare: Option<f64>,
    verify: Option<f64>,
    write: Option<f64>,
}

/// The report of one input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct SimplifyReport {
    file: String,
    proven: Option<bool>,
    seconds: SimplifySeconds,
    #[serde(flatten)]
    figures: SimplifyFigures,
    notes: Vec<String>,
    output: Option<String>,
    /// The picture of the model before and after, if it was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    picture: Option<String>,
    error: Option<String>,
}

impl InputReport for SimplifyReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Simplifies all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &SimplifyTask, console: &mut Console) -> bool {
    let new_report = |job: &Job| SimplifyReport { file: job.input.name(), ..SimplifyReport::default() };
    let process =
        |job: &Job, console: &mut Console, report: &mut SimplifyReport| simplify(job, task, console, report);
    let show = |job: &Job, report: &SimplifyReport, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(&report.figures)), job.output.is_none());
    };
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

fn simplify(
    job: &Job,
    task: &SimplifyTask,
    console: &mut Console,
    report: &mut SimplifyReport,
) -> Result<(), Failure> {
    let (model, load) = load_job(job, console)?;
    report.seconds.load = Some(load);
    let format = job.output.as_ref().map_or(Format::Ply, |output| output.format);
    let options = task.options.with_format(format);
    let show = |event: Event<'_>, seconds: f64| show(event, seconds, console, report);
    let simplified = simplify_observed(&model, &options, &Stages::new(console, load, show))?;
    if !task.options.verify {
        console.stage("verify", "skipped", None);
    }
    report.figures.vertices_after = Some(simplified.redrawn.used);
    report.figures.normals = Some(simplified.normals);
    if let Some(path) = &task.picture {
        draw(path, [&model, &simplified.redrawn.model], console, &mut report.notes)?;
        report.picture = Some(path.display().to_string());
    }
    let Some(target) = &job.output else { return Ok(()) };
    let fields = WriteReport {
        write: &mut report.seconds.write,
        verify: &mut report.seconds.verify,
        notes: &mut report.notes,
        vertex_order: None,
    };
    output::write(target, false, console, fields, |observer| simplified.encode(observer))?;
    report.output = Some(target.name());
    Ok(())
}

/// Draws the model before and after, and writes the picture.
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

/// Prints and reports an event.
fn show(event: Event<'_>, seconds: f64, console: &Console, report: &mut SimplifyReport) {
    match event {
        Event::Simplified(collapses) => {
            report.seconds.simplify = Some(seconds);
            report.figures.record(collapses);
            console.stage("simplify", &line(&report.figures), Some(seconds));
        }
        Event::Fitted { positions } => {
            report.seconds.fit = Some(seconds);
            report.figures.moved_positions = Some(positions);
            let what = format!("{} closer to the original", counted(positions, "position"));
            console.stage("fit", &what, Some(seconds));
        }
        Event::Compared(change) => {
            report.seconds.compare = Some(seconds);
            report.figures.compare(change);
            console.stage("compare", &change_line(&report.figures), Some(seconds));
        }
        other => {
            let fields = CollapseFields {
                file: &report.file,
                dual: &mut report.seconds.dual,
                verify: &mut report.seconds.verify,
                parts: &mut report.figures.parts,
                vertices_before: &mut report.figures.vertices_before,
                warning: &mut report.figures.warning,
                notes: &mut report.notes,
                proven: &mut report.proven,
            };
            fields.show(other, seconds, console);
        }
    }
}

/// Returns a line on the triangles left and the collapses.
fn line(report: &SimplifyFigures) -> String {
    let collapses = counted(report.collapses.unwrap_or(0), "collapse");
    format!("{} after {collapses}", counted(report.triangles_after.unwrap_or(0), "triangle"))
}

/// Formats a distance with about four digits.
fn distance(x: f64) -> String {
    if x == 0.0 || (1e-3..1e5).contains(&x) { format!("{x:.4}") } else { format!("{x:.2e}") }
}

/// Returns a table of the sizes before and after.
fn summary(report: &SimplifyFigures) -> String {
    let row = |name: &str, before: Option<usize>, after: Option<usize>| {
        let (before, after) = (before.unwrap_or(0), after.unwrap_or(0));
        let share = 100.0 * after as f64 / before.max(1) as f64;
        vec![format!("  {name}"), count(before), count(after), format!("{share:.1} %")]
    };
    let head = vec![String::new(), "before".into(), "after".into(), String::new()];
    let rows = [
        head,
        row("triangles", report.triangles_before, report.triangles_after),
        row("vertices", report.vertices_before, report.vertices_after),
    ];
    table(&rows, 1..4) + &format!("  {}\n", change_line(report)) + &normals_line(report)
}

/// Returns a line on the normals that were rebuilt, if there are any.
fn normals_line(report: &SimplifyFigures) -> String {
    let counts = report.normals.unwrap_or_default();
    let rebuilt = [
        (counts.repaired, "where they no longer fitted"),
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

/// Returns a line on how far the result is from the original.
fn change_line(report: &SimplifyFigures) -> String {
    let deviation = |what: &str, units: Option<f64>, percent: Option<f64>| {
        let (units, percent) = (units.unwrap_or(0.0), percent.unwrap_or(0.0));
        format!("{what} {} ({percent:.3} % of the diagonal)", distance(units))
    };
    let largest = deviation("largest deviation", report.largest_deviation, report.largest_deviation_percent);
    let rms = deviation("RMS", report.rms_deviation, report.rms_deviation_percent);
    let normals = report.normal_deviation_degrees.unwrap_or(0.0);
    let uv = report.uv_deviation_percent.map(|uv| format!(", texture {uv:.2} %")).unwrap_or_default();
    let texels =
        report.uv_deviation_texels.map(|texels| format!(" ({texels:.1} texels)")).unwrap_or_default();
    format!("{largest}, {rms}, normals {normals:.1}°{uv}{texels}")
}
