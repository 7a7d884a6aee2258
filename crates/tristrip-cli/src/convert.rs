//! `tristrip convert`: converts between formats and strip layouts without building new strips.

use serde::Serialize;
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Stage, convert};

use crate::clock::{STRIP_SECONDS, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{self, drawn_as};
use crate::report::{self, Batch};
use crate::stage::load_job;
use crate::task::ConvertTask;

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Converted {
    #[serde(flatten)]
    outcome: convert::Outcome,
    /// The file that was written.
    output: String,
    /// The layout of the strips; `null` if the file has only faces.
    layout: Option<&'static str>,
}

/// Converts all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &ConvertTask, console: &mut Console) -> bool {
    let process = |job: &Job, console: &mut Console, clock: &StageClock| convert(job, task, console, clock);
    let batch = Batch::new(STRIP_SECONDS);
    let reports = batch.process(&task.jobs, console, |job| job.input.name(), process, |_, _, _, _| ());
    report::finish(&reports, console)
}

fn convert(
    job: &Job,
    task: &ConvertTask,
    console: &mut Console,
    clock: &StageClock,
) -> Result<Converted, Failure> {
    let target = job.output.as_ref().ok_or_else(|| Failure::Output("found no output, expected -o".into()))?;
    let model = load_job(job, console, clock)?;
    let mut options = convert::Options::new(target.format).with_verify(task.verify);
    if task.as_strips {
        options = options.with_layout(target.layout);
    }
    let mut outcome = output::encode(target, clock, |observer| convert::run(&model, &options, observer))?;
    if let Some(strips) = outcome.strips {
        let what = format!("{} in input order", counted(strips, "strip"));
        console.stage("strips", &what, clock.seconds(&[Stage::Prepare, Stage::Stripify]));
    }
    let how = drawn_as(target, outcome.drawn.iter().any(Option::is_some));
    output::write(target, how, &outcome.encoded, &mut outcome.notes, clock, console)?;
    // The report does not need the bytes and the strips.
    outcome.encoded.bytes = Vec::new();
    outcome.drawn = Vec::new();
    let layout = outcome.strips.map(|_| target.layout.name());
    Ok(Converted { outcome, output: target.name(), layout })
}
