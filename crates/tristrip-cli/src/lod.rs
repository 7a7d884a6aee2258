//! `tristrip lod`: levels of detail drawn with the strips of the full mesh.
//!
//! ```text
//! load ─ strips of the full mesh ─ their triangles ─ simplify ─▶ collapses of each part ─ levels of the model
//!                  └──────── vertices renamed for a level ─ filter ─▶ display strips ─ prove ─ write ─ read again, prove
//! ```

mod chart;
pub(crate) mod levels;
pub(crate) mod measure;
pub(crate) mod part;
mod report;
pub(crate) mod rows;
pub(crate) mod totals;

use tristrip::Strips;
use tristrip_io::{Drawing, Model};

use crate::batch;
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::Figures;
use crate::input::short_name;
use crate::method::{Chosen, MethodReport};
use crate::output::{self, ModelDrawing};
use crate::search::{SearchWatch, interrupted};
use crate::simplify::{Part, diagonal, ends, locked_note, percent_of, simplify_all};
use crate::stages::{self, FoundStrips, Pool, Prepared, find_strips, timed};
use crate::survey::Loaded;
use crate::task::{Job, LodTask, Output};
use crate::text::{count, counted};
use crate::values::{Amount, layout_name};
use levels::Levels;
use measure::measure_levels;
use part::LodPart;
use report::{LodReport, LodSeconds};
use totals::totals;

/// Steps of a table, and of a curve of the chart, from the base mesh to the full mesh.
const TABLE_STEPS: usize = 20;
const CURVE_STEPS: usize = 100;

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &LodTask, pool: &Pool, console: &mut Console) -> bool {
    let new_report = |job: &Job| LodReport::new(job.input.name(), MethodReport::of(&task.options), task);
    let process = |job: &Job, console: &mut Console, report: &mut LodReport| {
        run_stages(job, task, pool, console, report)
    };
    let show = |job: &Job, report: &LodReport, title: &str, console: &mut Console| {
        let requested = job.output.is_none() || task.table || task.compare;
        console.result(&format!("{title}{}", summary(report, task)), requested);
    };
    let mut reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    if let Some(path) = &task.plot {
        let done = reports.iter().filter(|report| report.error.is_none());
        let measured: Vec<_> = done.map(|report| (short_name(&report.file), &report.rows[..])).collect();
        if !measured.is_empty() {
            let chart = chart::draw(&measured);
            if batch::write_chart(path, chart, &mut reports, console) {
                for report in reports.iter_mut().filter(|report| report.error.is_none()) {
                    report.plot = Some(path.display().to_string());
                }
            }
        }
    }
    batch::finish(reports, console)
}

/// Runs all stages on one input; after a failure the report has the results of the stages before.
fn run_stages(
    job: &Job,
    task: &LodTask,
    pool: &Pool,
    console: &mut Console,
    report: &mut LodReport,
) -> Result<(), Failure> {
    if interrupted() {
        return Err(Failure::Input("not done: interrupted".into()));
    }
    // 1. The strips of the full mesh.
    let loaded = Loaded::new(&job.input, task.options, console)?;
    let surveyed = loaded.survey(pool, console);
    let (load, dual) = (surveyed.seconds.load, surveyed.seconds.dual);
    report.seconds = LodSeconds { load, dual, ..LodSeconds::default() };
    report.notes.clone_from(&surveyed.notes);
    report.parts = Some(surveyed.parts.len());
    let prepared = surveyed.parts;
    let strips = full_strips(task, &loaded, &prepared, pool, console, report)?;

    // 2. The collapses.
    let meshes = prepared.iter().map(|part| part.mesh);
    let parts = Part::of_all(meshes.zip(strips.iter().map(Strips::to_list)).collect())?;
    let parts = simplify_parts(task, parts, &strips, pool, console, report)?;
    let levels = Levels::new(parts.iter().map(LodPart::sequence).collect());

    // 3. The display strips of the level.
    let level = task.level.of(levels.len())?;
    let of_parts = levels.of_parts(level);
    console.doing("filter");
    let (displays, seconds) = timed(|| {
        let pairs: Vec<_> = parts.iter().zip(&of_parts).collect();
        pool.map(&pairs, |(part, level)| {
            part.display(**level, &part.index_map(**level), task.filter, task.repair())
        })
    });
    let displays = displays.into_iter().collect::<Result<Vec<_>, _>>()?;
    report.seconds.filter = Some(seconds);
    report.level = Some(level);
    let error = levels.error(&of_parts);
    report.surface_error = Some(error);
    report.surface_error_percent = Some(percent_of(error, report.diagonal.unwrap_or(0.0)));
    let figures = Figures::of(pool, &prepared, &displays, &loaded.options);
    let (strips, triangles) = (counted(figures.strips, "strip"), counted(figures.triangles, "triangle"));
    let what = format!("level {}: {triangles} in {strips} (filter {})", count(level), task.filter.name());
    console.stage("filter", &what, Some(seconds));
    report.figures = Some(figures);

    // 4. The proof that they draw exactly the triangles of the level.
    if task.verify {
        console.doing("verify");
        let (proof, seconds) = timed(|| prove(pool, &parts, &of_parts, &displays));
        proof?;
        report.seconds.verify = Some(seconds);
        report.proven = Some(true);
        console.stage("verify", "proven: exactly the level's triangles and winding", Some(seconds));
    } else {
        console.stage("verify", "skipped", None);
    }

    // 5. The tables.
    if task.table || task.plot.is_some() {
        console.doing("table");
        let steps = if task.plot.is_some() { CURVE_STEPS } else { TABLE_STEPS };
        let at = levels.evenly(steps);
        let (measured, seconds) =
            timed(|| measure_levels(pool, &parts, &levels, &at, task.repair(), task.verify));
        report.rows = measured?;
        console.stage("table", &format!("{}, all filters", counted(at.len(), "level")), Some(seconds));
        if task.table {
            let in_table = levels.evenly(TABLE_STEPS);
            report.table =
                Some(report.rows.iter().filter(|row| in_table.contains(&row.level)).cloned().collect());
        }
    }

    if task.compare {
        console.doing("all levels");
        let (all, seconds) = timed(|| totals(pool, &parts, &levels, task.repair()));
        console.stage(
            "compare",
            &format!("{}, all filters", counted(levels.len() + 1, "level")),
            Some(seconds),
        );
        report.compare = Some(all?);
    }

    // 6. The file.
    let Some(target) = &job.output else { return Ok(()) };
    write(target, &loaded.model, &parts, &of_parts, &displays, task.verify, console, report)
}

/// Computes the strips of the full mesh and proves them.
fn full_strips(
    task: &LodTask,
    loaded: &Loaded,
    parts: &[Prepared<'_>],
    pool: &Pool,
    console: &Console,
    report: &mut LodReport,
) -> Result<Vec<Strips>, Failure> {
    console.doing("stripify");
    let watch = SearchWatch::new(console.progress(), task.budget, &loaded.options);
    let (found, seconds) = timed(|| find_strips(pool, parts, &loaded.options, &watch));
    let FoundStrips { strips, chosen } = found?;
    report.stopped = watch.stopped();
    report.seconds.stripify = Some(seconds);
    report.chosen = Some(Chosen::of(&chosen));
    let count = strips.iter().map(Strips::len).sum();
    let method = report.method.description(&Chosen::of(&chosen));
    let what = format!("{} of the full mesh ({method})", counted(count, "strip"));
    console.stage("stripify", &what, Some(seconds));
    if let Some(stopped) = report.stopped {
        console.note(stopped.note());
        report.notes.push(stopped.note().into());
    }
    if task.verify {
        stages::prove(pool, parts, &strips, &loaded.options)?;
    }
    Ok(strips)
}

/// Simplifies the triangles of the strips to the base mesh, and reports the result.
fn simplify_parts<'a>(
    task: &LodTask,
    parts: Vec<Part<'a>>,
    strips: &[Strips],
    pool: &Pool,
    console: &Console,
    report: &mut LodReport,
) -> Result<Vec<LodPart<'a>>, Failure> {
    console.doing("simplify");
    let triangles: Vec<usize> = parts.iter().map(Part::triangle_count).collect();
    let shares = Amount::Ratio(task.base).shares(&triangles);
    let (done, seconds) = timed(|| simplify_all(pool, &parts, &shares, None));
    let done = done?;
    report.seconds.simplify = Some(seconds);
    report.diagonal = Some(diagonal(&parts));
    report.levels = Some(done.iter().map(|done| done.sequence.len()).sum());
    report.triangles_full = Some(triangles.iter().sum());
    let base = done.iter().map(|done| done.sequence.triangle_count(0)).sum();
    report.triangles_base = Some(base);
    let collapses = counted(report.levels.unwrap_or(0), "collapse");
    let what = format!("{collapses} to a base mesh of {}", counted(base, "triangle"));
    console.stage("simplify", &what, Some(seconds));
    let locked = parts.iter().map(Part::locked_count).sum();
    for note in locked_note(locked).into_iter().chain(ends(&done, Some(&shares))) {
        console.note(&note);
        report.notes.push(note);
    }
    Ok(LodPart::all(parts, strips, done))
}

/// Proves the display strips of every part.
fn prove(pool: &Pool, parts: &[LodPart<'_>], levels: &[usize], displays: &[Strips]) -> Result<(), Failure> {
    let all: Vec<_> = parts.iter().zip(levels).zip(displays).collect();
    let proofs = pool.map(&all, |((part, level), display)| part.prove(**level, display));
    proofs.into_iter().collect()
}

/// Writes the display strips of a level, over the vertices that they use.
#[allow(clippy::too_many_arguments, reason = "the level, the target and the report")]
fn write(
    target: &Output,
    model: &Model,
    parts: &[LodPart<'_>],
    levels: &[usize],
    displays: &[Strips],
    verify: bool,
    console: &mut Console,
    report: &mut LodReport,
) -> Result<(), Failure> {
    let triangles = parts.iter().zip(levels).map(|(part, &level)| part.triangles(level)).collect();
    let failure = |error| Failure::writing(&error);
    let smaller = tristrip_io::with_triangles(model, triangles, target.format).map_err(failure)?;
    let outward = parts.iter().zip(displays).map(|(part, display)| part.outward(display));
    let strips = outward.enumerate().map(|(part, strips)| smaller.strips(part, &strips));
    let strips: Vec<Strips> = strips.collect::<Result<_, _>>().map_err(failure)?;
    let drawings: Vec<_> = strips.iter().map(Drawing::Strips).collect();
    let drawing = ModelDrawing { model: &smaller.model, drawings: &drawings, layout: target.layout };
    let written = output::write(target, &smaller.model, drawing, verify, console)?;
    written.record(&mut report.seconds.write, &mut report.seconds.verify, &mut report.notes);
    report.output = Some(target.name());
    report.layout = Some(layout_name(target.layout));
    Ok(())
}

/// Formats the summary of a report, with the requested tables.
fn summary(report: &LodReport, task: &LodTask) -> String {
    let figures = report.figures.as_ref().map(Figures::summary).unwrap_or_default();
    let table = if task.table { report.table.as_deref().map(measure::as_text) } else { None };
    let totals = report.compare.as_deref().map(totals::as_text);
    [Some(figures), table, totals].into_iter().flatten().collect()
}
