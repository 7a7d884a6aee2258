//! `tristrip strip`: finds strips, proves them, writes them, and says what they cost.

use std::path::Path;

use tristrip::{Method, Strips};
use tristrip_io::{Drawing, Model, Reordered};

use crate::bound::Bounds;
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::Figures;
use crate::input::short_name;
use crate::method::{Chosen, MethodReport};
use crate::output::{self, Drawn};
use crate::pareto::{self, Searches};
use crate::reorder::{self, GroupReport};
use crate::report::{Seconds, StripReport};
use crate::search::{SearchWatch, interrupted};
use crate::stages::{Found, Pool, find_strips, prove, timed};
use crate::survey::{Loaded, Surveyed};
use crate::task::{Job, Output, ParetoTask, StripTask, layout_name};
use crate::text::counted;

/// Works on all inputs, one after the other; tells whether all were done.
pub(crate) fn run(task: &StripTask, pool: &Pool, console: &mut Console) -> bool {
    let mut reports = Vec::with_capacity(task.jobs.len());
    for job in &task.jobs {
        let mut report = StripReport {
            file: job.input.name(),
            method: MethodReport::of(&task.options),
            chosen: None,
            proven: None,
            seconds: Seconds::default(),
            figures: None,
            stopped: None,
            bound: None,
            mesh: None,
            parts: None,
            notes: Vec::new(),
            output: None,
            layout: None,
            vertex_order: None,
            pareto: None,
            error: None,
        };
        console.begin(&report.file, None);
        let done = strip(job, task, pool, console, &mut report);
        console.end();
        if let Err(failure) = done {
            if matches!(failure, Failure::Unproven(_)) {
                report.proven = Some(false);
            }
            console.error(&format!("{}: {failure}", report.file));
            report.error = Some(failure.to_string());
        } else if let Some(figures) = &report.figures {
            // One report follows the other where there are many, each under its name.
            let title = if task.jobs.len() > 1 { format!("{}\n", report.file) } else { String::new() };
            let methods = report.pareto.as_deref().map(pareto::as_text).unwrap_or_default();
            console.result(&format!("{title}{}{methods}", figures.summary()), job.output.is_none());
        }
        reports.push(report);
    }
    if let Some(ParetoTask { path, .. }) = &task.pareto {
        draw(&mut reports, path, console);
    }
    console.json(&reports, task.jobs.len() > 1);
    reports.iter().all(|report| report.error.is_none())
}

/// Takes one input through all stages; the report holds what was reached.
fn strip(
    job: &Job,
    task: &StripTask,
    pool: &Pool,
    console: &mut Console,
    report: &mut StripReport,
) -> Result<(), Failure> {
    if interrupted() {
        return Err(Failure::Input("not done: interrupted".into()));
    }
    let loaded = Loaded::new(&job.input, task.options, console)?;
    let (model, options) = (&loaded.model, loaded.options);
    let Surveyed { parts, mesh, notes, seconds } = loaded.survey(pool, console);
    let faces = mesh.faces;
    (report.seconds, report.notes) = (seconds, notes);
    (report.parts, report.mesh) = (Some(parts.len()), Some(mesh));

    console.doing("stripify");
    let watch = SearchWatch::new(console.progress(), task.budget, &options);
    let (found, seconds) = timed(|| find_strips(pool, &parts, &options, &watch));
    let Found { strips, chosen } = found?;
    report.stopped = watch.stopped();
    drop(watch);
    report.seconds.stripify = Some(seconds);
    let figures = Figures::of(pool, &parts, &strips, &options);
    let chosen = Chosen::of(&chosen);
    let what = format!("{} by {}", counted(figures.strips, "strip"), report.method.label());
    console.stage("stripify", &what, Some(seconds));
    report.chosen = Some(chosen);
    if let Some(stopped) = report.stopped {
        console.note(stopped.note());
        report.notes.push(stopped.note().into());
    }
    if matches!(options.method(), Method::Best | Method::Fewest) {
        console.doing("bound");
        let (bounds, seconds) = timed(|| Bounds::of(pool, &parts));
        report.bound = bounds.gap(&options, &figures);
        if let Some(gap) = &report.bound {
            console.stage("bound", &gap.line(), Some(seconds));
        }
    }
    report.figures = Some(figures);

    if task.verify {
        console.doing("verify");
        let (proof, seconds) = timed(|| prove(pool, &parts, &strips, &options));
        proof?;
        report.seconds.verify = Some(seconds);
        report.proven = Some(true);
        console.stage("verify", &proven(faces), Some(seconds));
    } else {
        console.stage("verify", "not asked for", None);
    }
    // Nothing but the picture of all methods needs the parts any more.
    let parts = task.pareto.as_ref().map(|wanted| (wanted, parts));
    if let Some(target) = &job.output {
        write(target, task, model, strips, console, report)?;
    }
    let Some((wanted, parts)) = parts else { return Ok(()) };
    let searches = Searches { effort: wanted.effort, budget: task.budget };
    let (points, seconds) = timed(|| pareto::measure(pool, &parts, &options, searches, console));
    let (points, notes) = points?;
    console.stage("pareto", &pareto::line(&points), Some(seconds));
    notes.iter().for_each(|note| console.note(note));
    report.notes.extend(notes);
    report.pareto = Some(points);
    Ok(())
}

/// Draws the points of all inputs that were done into one picture.
fn draw(reports: &mut [StripReport], path: &Path, console: &Console) {
    let name = |report: &StripReport| short_name(&report.file);
    let measured = reports.iter().filter_map(|report| Some((name(report), report.pareto.as_deref()?)));
    let measured: Vec<_> = measured.collect();
    if measured.is_empty() {
        return;
    }
    let drawn = pareto::draw(&measured).and_then(|text| {
        tristrip_io::replace_file(path, text.as_bytes()).map_err(|error| Failure::writing(&error))
    });
    let Err(failure) = drawn else { return };
    console.error(&failure.to_string());
    for report in reports.iter_mut().filter(|report| report.error.is_none()) {
        report.error = Some(failure.to_string());
    }
}

/// Writes the strips, and the vertices in their order if that was asked for.
fn write(
    target: &Output,
    task: &StripTask,
    source: &Model,
    strips: Vec<Strips>,
    console: &mut Console,
    report: &mut StripReport,
) -> Result<(), Failure> {
    let (mut model, mut strips, mut layout, mut reorder_seconds) = (source, strips, target.layout, 0.0);
    let reordered;
    if task.reorder {
        console.doing("reorder");
        let (found, seconds) = timed(|| tristrip_io::reorder(source, &strips, target.format, layout));
        let Reordered { model: moved, strips: renamed, layout: fitting, groups } =
            found.map_err(|error| Failure::writing(&error))?;
        console.stage("reorder", &reorder::line(&groups), Some(seconds));
        let kept = reorder::kept(&groups);
        kept.iter().for_each(|note| console.note(note));
        report.notes.extend(kept);
        report.vertex_order = Some(groups.iter().map(GroupReport::of).collect());
        reordered = moved;
        (model, strips, layout, reorder_seconds) = (&reordered, renamed, fitting, seconds);
    }
    let drawings: Vec<_> = strips.iter().map(Drawing::Strips).collect();
    let drawn = Drawn { model, drawings: &drawings, layout };
    let written = output::write(target, source, drawn, task.verify, console)?;
    report.seconds.write = Some(reorder_seconds + written.write_seconds);
    if let (Some(strips), Some(file)) = (&mut report.seconds.verify, written.verify_seconds) {
        *strips += file;
    }
    report.notes.extend(written.losses);
    report.output = Some(target.name());
    report.layout = Some(layout_name(target.layout));
    Ok(())
}

/// Says what was proven.
fn proven(faces: usize) -> String {
    match faces {
        0 => "proven: draws nothing, as the source has no faces".into(),
        1 => "proven: draws exactly the one face, with its winding".into(),
        _ => format!("proven: draws exactly the {}, each once, wound right", counted(faces, "face")),
    }
}
