//! `tristrip chain`: several levels of detail over one vertex buffer, in one GLB or in one file per
//! level.

use serde::Serialize;
use tristrip_io::{Format, Model};
use tristrip_pipeline::chain::{self, Chain};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{Stage, encode};
use tristrip_render::text::{bytes, table};

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::{Job, Output};
use crate::output;
use crate::report::{self, Batch};
use crate::search::check_interrupt;
use crate::stage::{load_job, show_mesh, show_proof_of_collapses};
use crate::task::ChainTask;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[
    ("load", &[Stage::Load]),
    ("dual", &[Stage::Prepare]),
    ("simplify", &[Stage::Simplify]),
    ("stripify", &[Stage::Stripify]),
    ("verify", &[Stage::Prove, Stage::ReadBack]),
    ("write", &[Stage::Encode, Stage::Write]),
];

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Chained {
    #[serde(flatten)]
    outcome: chain::Outcome,
    /// The file with all levels; `null` if each level has its own file, or without `-o`.
    output: Option<String>,
    /// The layout of the strips, or `list`; `null` without `-o`.
    layout: Option<&'static str>,
}

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &ChainTask, console: &mut Console) -> bool {
    let process = |job: &Job, console: &mut Console, clock: &StageClock| build(job, task, console, clock);
    let show = |job: &Job, chained: &Chained, title: &str, console: &mut Console| {
        console.result(&format!("{title}{}", summary(&chained.outcome)), job.output.is_none());
    };
    let batch = Batch { budget: task.budget, ..Batch::new(SECONDS) };
    let reports = batch.process(&task.jobs, console, |job| job.input.name(), process, show);
    report::finish(&reports, console)
}

/// Builds the levels of one input and writes them.
fn build(job: &Job, task: &ChainTask, console: &mut Console, clock: &StageClock) -> Result<Chained, Failure> {
    check_interrupt()?;
    let model = load_job(job, console, clock)?;
    let format = job.output.as_ref().map_or(Format::Glb, |output| output.format);
    let options = task.options.clone().with_format(format);
    let mut outcome = clock.observe_and_print(|observer| chain::run(&model, &options, observer))?;
    show_result(&outcome, &job.input.name(), model.notes.len(), console);
    // The report does not need the models.
    let chain = std::mem::take(&mut outcome.chain);
    let mut output = None;
    if let Some(target) = &job.output {
        let mut writer = Writer { model: &model, chain: &chain, task, console, clock };
        if target.in_directory {
            writer.write_levels(target, &mut outcome)?;
        } else {
            writer.write_scene(target, &mut outcome)?;
            output = Some(target.name());
        }
    }
    Ok(Chained { outcome, output, layout: job.output.as_ref().map(|target| target.layout.name()) })
}

/// Prints the results of the collapses. The first `read` notes are already printed.
fn show_result(outcome: &chain::Outcome, name: &str, read: usize, console: &Console) {
    show_mesh(&outcome.mesh, &outcome.notes, read, console);
    let collapses = &outcome.collapses;
    let coarsest = counted(collapses.triangles_after, "triangle");
    let what = format!("{} to a coarsest level of {coarsest}", counted(collapses.collapse_count, "collapse"));
    console.stage("result", &what, None);
    show_proof_of_collapses(outcome.proven, console);
    if let Some(warning) = &outcome.warning {
        console.warning(name, warning);
    }
}

/// Writes the files of a chain.
struct Writer<'a> {
    model: &'a Model,
    chain: &'a Chain,
    task: &'a ChainTask,
    console: &'a mut Console,
    clock: &'a StageClock,
}

impl Writer<'_> {
    /// Writes all levels as one GLB.
    fn write_scene(&mut self, target: &Output, outcome: &mut chain::Outcome) -> Result<(), Failure> {
        let (options, writing) = (self.options(target), self.clock.part());
        let file =
            output::encode(target, &writing, |observer| self.chain.encode(self.model, &options, observer))?;
        self.write(&file.encoded, target, &writing, &mut outcome.notes)?;
        for (level, bytes) in outcome.levels.iter_mut().zip(file.level_bytes) {
            level.bytes = Some(bytes);
        }
        Ok(())
    }

    /// Writes each level to its own file.
    fn write_levels(&mut self, target: &Output, outcome: &mut chain::Outcome) -> Result<(), Failure> {
        for level in &mut outcome.levels {
            let target = target.of_level(level.number);
            let (options, writing) = (self.options(&target), self.clock.part());
            let encoded = output::encode(&target, &writing, |observer| {
                self.chain.encode_level(self.model, level.number, &options, observer)
            })?;
            level.bytes = Some(self.write(&encoded, &target, &writing, &mut outcome.notes)?);
            level.output = Some(target.name());
        }
        Ok(())
    }

    fn options(&self, target: &Output) -> encode::Options {
        let options = encode::Options::new(target.format).with_layout(target.layout);
        options.with_list(self.task.list).with_verify(self.task.options.verify)
    }

    /// Writes a file; returns its size.
    fn write(
        &mut self,
        encoded: &encode::Outcome,
        target: &Output,
        writing: &StageClock,
        notes: &mut Vec<String>,
    ) -> Result<usize, Failure> {
        output::write(target, target.layout.name(), encoded, notes, writing, self.console)
    }
}

/// Returns the row of a level in the table.
fn row(level: &chain::ChainLevel) -> Vec<String> {
    vec![
        format!("  level {}", level.number),
        count(level.triangles),
        count(level.vertices),
        format!("{:.3} %", level.surface_error_percent),
        format!("{:.2} %", 100.0 * level.screen_coverage),
        level.bytes.map_or_else(|| "-".into(), bytes),
        if level.reached {
            String::new()
        } else {
            format!("{} requested, not reached", count(level.target_triangles))
        },
    ]
}

/// Returns a table of the levels.
fn summary(outcome: &chain::Outcome) -> String {
    let head = ["", "triangles", "vertices", "error", "down to coverage", "size", ""];
    let rows: Vec<Vec<String>> =
        std::iter::once(head.map(str::to_owned).to_vec()).chain(outcome.levels.iter().map(row)).collect();
    table(&rows, 1..6)
}
