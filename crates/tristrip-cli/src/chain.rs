//! `tristrip chain`: several levels of detail over one vertex buffer, in one GLB or in a file each.

mod report;

use tristrip_io::{Format, Model};
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Chain, EncodeOptions, Event, MethodReport, chain_observed};

use crate::batch;
use crate::collapses::collapse_fields;
use crate::console::Console;
use crate::failure::Failure;
use crate::job::{Job, Output};
use crate::output::{self, SearchReport, WriteReport};
use crate::search::interrupted;
use crate::stage::{Stages, load_job};
use crate::task::ChainTask;
use report::ChainReport;

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &ChainTask, console: &mut Console) -> bool {
    let new_report = |job: &Job| ChainReport::new(job.input.name(), MethodReport::of(&task.options.stripify));
    let process =
        |job: &Job, console: &mut Console, report: &mut ChainReport| run_stages(job, task, console, report);
    let show = |job: &Job, report: &ChainReport, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", report.summary()), job.output.is_none());
    };
    let reports = batch::process_all(&task.jobs, None, console, new_report, process, show);
    batch::finish(reports, console)
}

/// Builds the levels of one input and writes them; after a failure the report has the results of the stages before.
fn run_stages(
    job: &Job,
    task: &ChainTask,
    console: &mut Console,
    report: &mut ChainReport,
) -> Result<(), Failure> {
    if interrupted() {
        return Err(Failure::Input("not done: interrupted".into()));
    }
    let (model, load) = load_job(job, console)?;
    report.seconds.load = Some(load);
    let format = job.output.as_ref().map_or(Format::Glb, |output| output.format);
    let options = task.options.clone().with_format(format);
    let show = |event: Event<'_>, seconds: f64| show(event, seconds, console, report);
    let chain = chain_observed(&model, &options, &Stages::new(console, load, show))?;
    if !task.options.verify {
        console.stage("verify", "skipped", None);
    }
    report.chain = chain.level_reports();
    let Some(target) = &job.output else { return Ok(()) };
    report.layout = Some(target.layout.name());
    if target.in_directory {
        for level in 0..chain.levels.len() {
            let target = target.of_level(level);
            let bytes = write_level(&model, &chain, level, &target, task, console, report)?;
            let level = &mut report.chain[level];
            (level.bytes, level.output) = (Some(bytes), Some(target.name()));
        }
        return Ok(());
    }
    let bytes = write_scene(&model, &chain, target, task, console, report)?;
    report.chain.iter_mut().zip(bytes).for_each(|(level, bytes)| level.bytes = Some(bytes));
    report.output = Some(target.name());
    Ok(())
}

/// Prints and reports an event of the collapses.
fn show(event: Event<'_>, seconds: f64, console: &Console, report: &mut ChainReport) {
    match event {
        Event::Simplified(collapses) => {
            report.seconds.simplify = Some(seconds);
            report.record(collapses);
            let coarsest = counted(collapses.triangles_after, "triangle");
            let what = format!(
                "{} to a coarsest level of {coarsest}",
                counted(collapses.collapse_count, "collapse")
            );
            console.stage("simplify", &what, Some(seconds));
        }
        other => collapse_fields!(report).show(other, seconds, console),
    }
}

/// Writes all levels as one GLB; returns the bytes that each of them uses.
fn write_scene(
    model: &Model,
    chain: &Chain,
    target: &Output,
    task: &ChainTask,
    console: &mut Console,
    report: &mut ChainReport,
) -> Result<Vec<usize>, Failure> {
    let options = encode_options(target, task);
    let mut level_bytes = Vec::new();
    let (fields, search) = fields(report, task);
    output::write_searched(target, true, console, fields, search, |observer| {
        let file = chain.encode(model, &options, observer)?;
        level_bytes = file.level_bytes;
        Ok(file.encoded)
    })?;
    Ok(level_bytes)
}

/// Writes a level as a file of its own; returns the size of the file.
fn write_level(
    model: &Model,
    chain: &Chain,
    level: usize,
    target: &Output,
    task: &ChainTask,
    console: &mut Console,
    report: &mut ChainReport,
) -> Result<usize, Failure> {
    let options = encode_options(target, task);
    let (fields, search) = fields(report, task);
    output::write_searched(target, true, console, fields, search, |observer| {
        chain.encode_level(model, level, &options, observer)
    })
}

fn encode_options(target: &Output, task: &ChainTask) -> EncodeOptions {
    let options = EncodeOptions::new(target.format).with_layout(target.layout);
    options.with_list(task.list).with_verify(task.options.verify)
}

/// Returns the fields of a report that a write fills in.
fn fields<'a>(report: &'a mut ChainReport, task: &ChainTask) -> (WriteReport<'a>, SearchReport<'a>) {
    let seconds = &mut report.seconds;
    let write = WriteReport {
        write: &mut seconds.write,
        verify: &mut seconds.verify,
        notes: &mut report.notes,
        vertex_order: None,
    };
    (write, SearchReport { budget: task.budget, stripify: &mut seconds.stripify })
}
