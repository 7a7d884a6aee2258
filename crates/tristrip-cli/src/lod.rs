//! `tristrip lod`: any level of detail, drawn with the strips of the full mesh.
//!
//! ```text
//! load ─ strips of the full mesh ─ their triangles ─ simplify ─▶ collapses of each part ─ levels of the model
//!                  └──────────────── renamed for a level ─ filter ─▶ display strips ─ prove ─ write ─ read again, prove
//! ```

mod detail;
mod levels;
mod measure;
mod picture;
mod report;
mod totals;

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
pub(crate) use detail::Detail;
pub(crate) use levels::Levels;
pub(crate) use measure::{Refinement, Row, Sent, rows};
use report::{LodReport, LodSeconds};
pub(crate) use totals::totals;

/// Levels of a table, and of a curve, from the base mesh to the full one.
const TABLE_STEPS: usize = 20;
const CURVE_STEPS: usize = 100;

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &LodTask, pool: &Pool, console: &mut Console) -> bool {
    let new_report = |job: &Job| LodReport::new(job.input.name(), MethodReport::of(&task.options), task);
    let process =
        |job: &Job, console: &mut Console, report: &mut LodReport| detail(job, task, pool, console, report);
    let show = |job: &Job, report: &LodReport, title: &str, console: &mut Console| {
        let requested = job.output.is_none() || task.table || task.compare;
        console.result(&format!("{title}{}", summary(report, task)), requested);
    };
    let mut reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    if let Some(path) = &task.plot {
        let done = reports.iter().filter(|report| report.error.is_none());
        let measured: Vec<_> = done.map(|report| (short_name(&report.file), &report.rows[..])).collect();
        if !measured.is_empty() {
            let chart = picture::draw(&measured);
            if batch::write_chart(path, chart, &mut reports, console) {
                for report in reports.iter_mut().filter(|report| report.error.is_none()) {
                    report.plot = Some(path.display().to_string());
                }
            }
        }
    }
    batch::finish(reports, console)
}

/// Takes one input through all stages; the report holds what was reached.
fn detail(
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
    let details = collapse(task, parts, &strips, pool, console, report)?;
    let levels = Levels::new(details.iter().map(Detail::sequence).collect());

    // 3. The display strips of the level.
    let level = task.level.of(levels.len())?;
    let of_parts = levels.of_parts(level);
    console.doing("filter");
    let (displays, seconds) = timed(|| {
        let pairs: Vec<_> = details.iter().zip(&of_parts).collect();
        pool.map(&pairs, |(detail, level)| {
            detail.display(**level, &detail.map(**level), task.filter, task.repair())
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
    let what = format!("level {}: {triangles} in {strips} by {}", count(level), task.filter.name());
    console.stage("filter", &what, Some(seconds));
    report.figures = Some(figures);

    // 4. The proof that they draw what the collapses leave.
    if task.verify {
        console.doing("verify");
        let (proof, seconds) = timed(|| prove(pool, &details, &of_parts, &displays));
        proof?;
        report.seconds.verify = Some(seconds);
        report.proven = Some(true);
        console.stage("verify", "proven: draws exactly what the collapses leave, wound right", Some(seconds));
    } else {
        console.stage("verify", "not asked for", None);
    }

    // 5. The tables.
    if task.table || task.plot.is_some() {
        console.doing("table");
        let steps = if task.plot.is_some() { CURVE_STEPS } else { TABLE_STEPS };
        let at = levels.evenly(steps);
        let (measured, seconds) = timed(|| rows(pool, &details, &levels, &at, task.repair(), task.verify));
        report.rows = measured?;
        console.stage("table", &format!("{}, every filter", counted(at.len(), "level")), Some(seconds));
        if task.table {
            let every = levels.evenly(TABLE_STEPS);
            report.table =
                Some(report.rows.iter().filter(|row| every.contains(&row.level)).cloned().collect());
        }
    }

    if task.compare {
        console.doing("all levels");
        let (all, seconds) = timed(|| totals(pool, &details, &levels, task.repair()));
        console.stage(
            "compare",
            &format!("{}, every filter", counted(levels.len() + 1, "level")),
            Some(seconds),
        );
        report.compare = Some(all?);
    }

    // 6. The file.
    let Some(target) = &job.output else { return Ok(()) };
    write(target, &loaded.model, &details, &of_parts, &displays, task.verify, console, report)
}

/// Finds the strips of the full mesh, and proves them.
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

/// Simplifies the triangles of the strips to the base mesh, and says how that went.
fn collapse<'a>(
    task: &LodTask,
    parts: Vec<Part<'a>>,
    strips: &[Strips],
    pool: &Pool,
    console: &Console,
    report: &mut LodReport,
) -> Result<Vec<Detail<'a>>, Failure> {
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
    let details = parts.into_iter().zip(strips).zip(done);
    let details = details.map(|((part, strips), done)| Detail::new(part.compact, strips, done));
    Ok(details.collect())
}

/// Proves the display strips of every part.
fn prove(pool: &Pool, details: &[Detail<'_>], levels: &[usize], displays: &[Strips]) -> Result<(), Failure> {
    let all: Vec<_> = details.iter().zip(levels).zip(displays).collect();
    let proofs = pool.map(&all, |((detail, level), display)| detail.prove(**level, display));
    proofs.into_iter().collect()
}

/// Writes the display strips of a level, over the vertices that they use.
#[allow(clippy::too_many_arguments, reason = "what a level is, and what is done with it")]
fn write(
    target: &Output,
    model: &Model,
    details: &[Detail<'_>],
    levels: &[usize],
    displays: &[Strips],
    verify: bool,
    console: &mut Console,
    report: &mut LodReport,
) -> Result<(), Failure> {
    let left = details.iter().zip(levels).map(|(detail, &level)| detail.left(level)).collect();
    let failure = |error| Failure::writing(&error);
    let smaller = tristrip_io::with_triangles(model, left, target.format).map_err(failure)?;
    let outward = details.iter().zip(displays).map(|(detail, display)| detail.outward(display));
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

/// Says what was drawn, and the tables that were asked for.
fn summary(report: &LodReport, task: &LodTask) -> String {
    let figures = report.figures.as_ref().map(Figures::summary).unwrap_or_default();
    let table = if task.table { report.table.as_deref().map(measure::as_text) } else { None };
    let totals = report.compare.as_deref().map(totals::as_text);
    [Some(figures), table, totals].into_iter().flatten().collect()
}
