//! `tristrip level` and `tristrip camera-level`: one level or one view, drawn with the strips of
//! the full mesh.

use serde::Serialize;
use tristrip::lod::{Camera, ModelKind, ViewCriteria};
use tristrip_io::Model;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{
    Error, Observer, Stage, StripMetrics, encode, levels, levels::LevelGoal, levels::ModelLevels, rounded,
};

use crate::clock::{SecondsKeys, StageClock};
use crate::console::Console;
use crate::failure::Failure;
use crate::figures;
use crate::job::{Job, Output};
use crate::output;
use crate::report::{self, Batch};
use crate::search::check_interrupt;
use crate::stage::{load_job, show_mesh};
use crate::task::LevelTask;

/// The keys of `seconds`.
pub(crate) const SECONDS: SecondsKeys = &[
    ("load", &[Stage::Load]),
    ("dual", &[Stage::Prepare]),
    ("stripify", &[Stage::Stripify]),
    ("simplify", &[Stage::Simplify]),
    ("filter", &[Stage::Filter]),
    ("verify", &[Stage::Prove, Stage::ReadBack]),
    ("write", &[Stage::Encode, Stage::Write]),
];

/// The report on one input. The field names are the keys of the JSON output.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Leveled {
    #[serde(flatten)]
    outcome: levels::Outcome,
    /// The level model that stores the strips: `progressive-mesh`, `naive`, `progressive`, `sets`,
    /// `blocks` or `skip`.
    model: &'static str,
    /// The display filter: `none`, `stss`, `dtfs`, `linked` or `repair`. It is `none` for a level
    /// model without a filter.
    filter: String,
    /// The search effort of the filter `repair`, from 0 to 9.
    filter_effort: u8,
    #[serde(flatten)]
    drawn: Drawn,
    /// The file that was written; `null` without `-o`.
    output: Option<String>,
    /// The layout of the strips; `null` without `-o`.
    layout: Option<&'static str>,
}

/// What is drawn: a level or a view.
#[derive(Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Drawn {
    /// Whether the strips draw the full mesh, the display strips draw exactly the triangles of the
    /// level or view, and a written file draws the same triangles when it is read back; `null` if
    /// verification was disabled.
    proven: Option<bool>,
    /// The level that is drawn; `null` for a camera.
    level: Option<usize>,
    /// The maximum error of the collapses of the level, in mesh units; `null` for a camera.
    surface_error: Option<f32>,
    /// `surface_error` in percent of `diagonal`; `null` for a camera.
    surface_error_percent: Option<f64>,
    /// `surface_error` in pixels of the view; `null` without `--pixels` or `--distance`, and for a
    /// camera.
    pixels: Option<f64>,
    /// The metrics of the display strips.
    #[serde(flatten)]
    metrics: StripMetrics,
}

/// Processes all inputs in order; returns whether all succeeded.
pub(crate) fn run(task: &LevelTask, console: &mut Console) -> bool {
    let process =
        |job: &Job, console: &mut Console, clock: &StageClock| Drawing { job, task, clock }.process(console);
    let show = |job: &Job, leveled: &Leveled, title: &str, console: &mut Console| {
        let metrics = figures::summary(&leveled.drawn.metrics);
        console.result(&format!("{title}{metrics}"), job.output.is_none());
    };
    let batch = Batch { budget: task.budget, ..Batch::new(SECONDS) };
    let reports = batch.process(&task.jobs, console, |job| job.input.name(), process, show);
    report::finish(&reports, console)
}

/// Prints the results of the strips and collapses. The first `read` notes are already printed.
fn show_built(outcome: &levels::Outcome, read: usize, console: &Console) {
    show_mesh(&outcome.mesh, &outcome.notes, read, console);
    let strips = count(outcome.strips_full);
    let what = format!("{strips} of the full mesh ({})", outcome.method.description());
    console.stage("strips", &what, None);
    let base = counted(outcome.triangles_base, "triangle");
    let what = format!("{} to a base mesh of {base}", counted(outcome.levels, "collapse"));
    console.stage("result", &what, None);
}

/// The drawing of one input.
struct Drawing<'a> {
    job: &'a Job,
    task: &'a LevelTask,
    clock: &'a StageClock,
}

impl Drawing<'_> {
    /// Runs all stages.
    fn process(&self, console: &mut Console) -> Result<Leveled, Failure> {
        check_interrupt()?;
        let task = self.task;
        let model = load_job(self.job, console, self.clock)?;
        let options = levels::Options::default().with_stripify(task.options);
        let options = options.with_base(task.base).with_price(task.price).with_verify(task.verify);
        let mut outcome = self.clock.observe_and_print(|observer| levels::run(&model, &options, observer))?;
        show_built(&outcome, model.notes.len(), console);
        let drawn = match &task.camera {
            Some(camera) => self.draw_view(&model, &mut outcome, camera, console)?,
            None => self.draw_level(&model, &mut outcome, console)?,
        };
        // The report does not need the levels.
        outcome.model = ModelLevels::default();
        let target = self.job.output.as_ref();
        Ok(Leveled {
            outcome,
            model: task.model.name(),
            filter: task.filter.to_string(),
            filter_effort: task.filter_effort.level(),
            drawn,
            output: target.map(Output::name),
            layout: target.map(|target| target.layout.name()),
        })
    }

    /// Prints what is drawn and how.
    fn show_drawn(
        &self,
        metrics: &StripMetrics,
        (name, how): (&str, &str),
        drawing: &StageClock,
        console: &Console,
    ) {
        let (triangles, strips) = (counted(metrics.triangles, "triangle"), counted(metrics.strips, "strip"));
        let what = format!("{name}: {triangles} in {strips} ({how})");
        console.stage("filter", &what, drawing.seconds(&[Stage::Filter]));
        if self.task.verify {
            let kind = name.split(' ').next().unwrap_or_default();
            let what = format!("proven: draws exactly the triangles of the {kind}, with their winding");
            console.stage("verify", &what, drawing.seconds(&[Stage::Prove]));
        } else {
            console.stage("verify", "skipped", None);
        }
    }

    /// Returns the level that the task selects.
    fn level(&self, outcome: &mut levels::Outcome, console: &Console) -> Result<usize, Failure> {
        let level = outcome.model.level_of(self.task.goal)?;
        let triangles = outcome.model.triangle_count(level)?;
        if let LevelGoal::Triangles(requested) = self.task.goal
            && triangles > requested
        {
            let (requested, found) = (counted(requested, "triangle"), count(triangles));
            let note = format!("requested {requested}, but the base mesh has {found}");
            console.note(&note);
            outcome.notes.push(note);
        }
        Ok(level)
    }

    /// Draws a level and writes the file.
    fn draw_level(
        &self,
        model: &Model,
        outcome: &mut levels::Outcome,
        console: &mut Console,
    ) -> Result<Drawn, Failure> {
        let level = self.level(outcome, console)?;
        let (levels, task, drawing) = (&outcome.model, self.task, self.clock.part());
        let displayed = drawing.observe(|observer| match task.model {
            ModelKind::Progressive | ModelKind::Naive => {
                levels.display(level, task.filter, task.repair(), observer)
            }
            kind => levels.display_of(kind, level, observer),
        })?;
        let how = format!("model {}, filter {}", task.model, task.filter);
        let name = format!("level {}", count(level));
        self.show_drawn(&displayed.metrics, (&name, &how), &drawing, console);
        let pixels = task.view.map(|view| f64::from(view.pixels_of(displayed.surface_error)));
        if let Some(pixels) = pixels {
            console.stage("error", &format!("{pixels:.3} pixels in the view"), None);
        }
        let encode = |options: &encode::Options, observer: &dyn Observer| {
            levels.encode(model, &displayed, options, observer)
        };
        self.write(!displayed.strips.is_empty(), &mut outcome.notes, console, encode)?;
        Ok(Drawn {
            proven: displayed.proven.then_some(true),
            level: Some(level),
            surface_error: Some(displayed.surface_error),
            surface_error_percent: Some(displayed.surface_error_percent),
            pixels: pixels.map(rounded),
            metrics: displayed.metrics,
        })
    }

    /// Draws the view of a camera and writes the file.
    fn draw_view(
        &self,
        model: &Model,
        outcome: &mut levels::Outcome,
        (camera, criteria): &(Camera, ViewCriteria),
        console: &mut Console,
    ) -> Result<Drawn, Failure> {
        let (levels, drawing) = (&outcome.model, self.clock.part());
        let view = drawing.observe(|observer| levels.view(model, camera, criteria, observer))?;
        let how = format!("model {}", self.task.model);
        self.show_drawn(&view.metrics, ("view", &how), &drawing, console);
        view.notes.iter().for_each(|note| console.note(note));
        outcome.notes.extend_from_slice(&view.notes);
        let encode = |options: &encode::Options, observer: &dyn Observer| {
            levels.encode_view(model, &view, options, observer)
        };
        self.write(!view.strips.is_empty(), &mut outcome.notes, console, encode)?;
        Ok(Drawn {
            proven: view.proven.then_some(true),
            level: None,
            surface_error: None,
            surface_error_percent: None,
            pixels: None,
            metrics: view.metrics,
        })
    }

    /// Writes the file of a job that has one.
    fn write(
        &self,
        has_strips: bool,
        notes: &mut Vec<String>,
        console: &mut Console,
        encode: impl FnOnce(&encode::Options, &dyn Observer) -> Result<encode::Outcome, Error>,
    ) -> Result<(), Failure> {
        let Some(target) = &self.job.output else { return Ok(()) };
        let options = encode::Options::new(target.format).with_layout(target.layout);
        let (options, writing) = (options.with_verify(self.task.verify), self.clock.part());
        let encoded = output::encode(target, &writing, |observer| encode(&options, observer))?;
        let how = output::drawn_as(target, has_strips);
        output::write(target, how, &encoded, notes, &writing, console)?;
        Ok(())
    }
}
