//! `tristrip level` and `tristrip camera-level`: one level or one view drawn with the strips of the full mesh.

mod report;

use tristrip::lod::{Camera, ModelKind, ViewCriteria};
use tristrip_io::Model;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{
    EncodeOptions, Encoded, Error, Event, LevelGoal, LevelsOptions, MethodReport, ModelLevels, Observer,
    levels_observed, rounded,
};

use crate::batch;
use crate::console::Console;
use crate::failure::Failure;
use crate::figures;
use crate::job::Job;
use crate::output::{self, WriteReport};
use crate::search::interrupted;
use crate::stage::{Stages, load_job, show_search};
use crate::task::LevelTask;
use report::LodReport;

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &LevelTask, console: &mut Console) -> bool {
    let new_report = |job: &Job| LodReport::new(job.input.name(), MethodReport::of(&task.options), task);
    let process =
        |job: &Job, console: &mut Console, report: &mut LodReport| run_stages(job, task, console, report);
    let show = |job: &Job, report: &LodReport, title: &str, console: &mut Console| {
        let figures = report.figures.as_ref().map(figures::summary).unwrap_or_default();
        console.result(&format!("{title}{figures}"), job.output.is_none());
    };
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

/// Runs all stages on one input; after a failure the report has the results of the stages before.
fn run_stages(
    job: &Job,
    task: &LevelTask,
    console: &mut Console,
    report: &mut LodReport,
) -> Result<(), Failure> {
    if interrupted() {
        return Err(Failure::Input("not done: interrupted".into()));
    }
    let (model, load) = load_job(job, console)?;
    report.seconds.load = Some(load);
    let options = LevelsOptions::default().with_stripify(task.options);
    let options = options.with_base(task.base).with_price(task.price).with_verify(task.verify);
    let show = |event: Event<'_>, seconds: f64| show_building(event, seconds, console, report);
    let stages = Stages::new(console, load, show).with_budget(task.budget);
    let levels = levels_observed(&model, &options, &stages)?;
    if let Some(camera) = &task.camera {
        return draw_view((&model, &levels), camera, job, task, console, report);
    }
    let level = levels.level_of(task.goal)?;
    report.level = Some(level);
    let triangles = levels.triangle_count(level)?;
    if let LevelGoal::Triangles(wanted) = task.goal
        && triangles > wanted
    {
        let note =
            format!("{} asked for: the base mesh has {}", counted(wanted, "triangle"), count(triangles));
        console.note(&note);
        report.notes.push(note);
    }
    draw(&model, &levels, level, job, task, console, report)
}

/// Prints and reports an event of the strips and collapses.
fn show_building(event: Event<'_>, seconds: f64, console: &Console, report: &mut LodReport) {
    match event {
        Event::Prepared => report.seconds.dual = Some(seconds),
        Event::Surveyed { parts, notes, .. } => {
            (report.parts, report.notes) = (Some(parts), notes.to_vec());
        }
        Event::Stripified { strips, stopped } => {
            report.seconds.stripify = Some(seconds);
            let method = report.method.description();
            let what = format!("{} of the full mesh ({method})", counted(strips, "strip"));
            report.stopped = stopped;
            show_search(&what, seconds, stopped, console, &mut report.notes);
        }
        Event::Simplified(collapses) => {
            report.seconds.simplify = Some(seconds);
            report.diagonal = Some(collapses.diagonal);
            report.levels = Some(collapses.collapse_count);
            report.triangles_full = Some(collapses.triangles_before);
            report.triangles_base = Some(collapses.triangles_after);
            let base = counted(collapses.triangles_after, "triangle");
            let what = format!("{} to a base mesh of {base}", counted(collapses.collapse_count, "collapse"));
            console.stage("simplify", &what, Some(seconds));
        }
        Event::Note(note) => report.notes.push(note.into()),
        _ => (),
    }
}

/// Prints and reports an event of what is drawn: its name, and how it is drawn.
fn show_drawn(
    event: Event<'_>,
    seconds: f64,
    (name, drawn): (&str, &str),
    console: &Console,
    report: &mut LodReport,
) {
    match event {
        Event::Filtered => report.seconds.filter = Some(seconds),
        Event::Measured(figures) => {
            let strips = counted(figures.strips, "strip");
            let triangles = counted(figures.triangles, "triangle");
            console.stage(
                "filter",
                &format!("{name}: {triangles} in {strips} ({drawn})"),
                report.seconds.filter,
            );
            report.figures = Some(figures.clone());
        }
        Event::Proven { .. } => {
            (report.seconds.verify, report.proven) = (Some(seconds), Some(true));
            let kind = name.split(' ').next().unwrap_or_default();
            let what = format!("proven: exactly the {kind}'s triangles and winding");
            console.stage("verify", &what, Some(seconds));
        }
        _ => (),
    }
}

/// Draws a level, and writes the file.
fn draw(
    model: &Model,
    levels: &ModelLevels,
    level: usize,
    job: &Job,
    task: &LevelTask,
    console: &mut Console,
    report: &mut LodReport,
) -> Result<(), Failure> {
    let name = format!("level {}", count(level));
    let drawn = format!("model {}, filter {}", task.model, task.filter);
    let show = |event: Event<'_>, seconds: f64| show_drawn(event, seconds, (&name, &drawn), console, report);
    let stages = Stages::new(console, 0.0, show);
    let displayed = match task.model {
        ModelKind::Progressive | ModelKind::Naive => {
            levels.display(level, task.filter, task.repair(), &stages)?
        }
        kind => levels.display_of(kind, level, &stages)?,
    };
    report.surface_error = Some(displayed.surface_error);
    report.surface_error_percent = Some(displayed.surface_error_percent);
    if let Some(view) = task.view {
        let pixels = f64::from(view.pixels_of(displayed.surface_error));
        console.stage("error", &format!("{pixels:.3} pixels of the view"), None);
        report.pixels = Some(rounded(pixels));
    }
    if !task.verify {
        console.stage("verify", "skipped", None);
    }
    write(job, task, !displayed.strips.is_empty(), console, report, |options, observer| {
        levels.encode(model, &displayed, options, observer)
    })
}

/// Draws the view of a camera, and writes the file.
fn draw_view(
    (model, levels): (&Model, &ModelLevels),
    (camera, criteria): &(Camera, ViewCriteria),
    job: &Job,
    task: &LevelTask,
    console: &mut Console,
    report: &mut LodReport,
) -> Result<(), Failure> {
    let drawn = format!("model {}", task.model);
    let show = |event: Event<'_>, seconds: f64| show_drawn(event, seconds, ("view", &drawn), console, report);
    let view = levels.view(model, camera, criteria, &Stages::new(console, 0.0, show))?;
    view.notes.iter().for_each(|note| console.note(note));
    report.notes.extend_from_slice(&view.notes);
    if !task.verify {
        console.stage("verify", "skipped", None);
    }
    write(job, task, !view.strips.is_empty(), console, report, |options, observer| {
        levels.encode_view(model, &view, options, observer)
    })
}

/// Writes the file of a job that has one.
fn write(
    job: &Job,
    task: &LevelTask,
    has_strips: bool,
    console: &mut Console,
    report: &mut LodReport,
    encode: impl FnOnce(&EncodeOptions, &dyn Observer) -> Result<Encoded, Error>,
) -> Result<(), Failure> {
    let Some(target) = &job.output else { return Ok(()) };
    let options = EncodeOptions::new(target.format).with_layout(target.layout).with_verify(task.verify);
    let fields = WriteReport {
        write: &mut report.seconds.write,
        verify: &mut report.seconds.verify,
        notes: &mut report.notes,
        vertex_order: None,
    };
    output::write(target, has_strips, console, fields, |observer| encode(&options, observer))?;
    report.output = Some(target.name());
    report.layout = Some(target.layout.name());
    Ok(())
}
