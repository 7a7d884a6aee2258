//! The stages of an input as the command shows them: an observer of the pipeline that measures their times and watches searches.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use serde::Serialize;
use tristrip::StripifyOptions;
use tristrip_io::Model;
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{Event, MeshProperties, Observer, Search, Stage, Stopped};

use crate::clock::StageClock;
use crate::console::Console;
use crate::failure::Failure;
use crate::figures::mesh_line;
use crate::input::load;
use crate::job::{Input, Job};
use crate::search::SearchWatch;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) load: Option<f64>,
    pub(crate) dual: Option<f64>,
    pub(crate) stripify: Option<f64>,
    pub(crate) verify: Option<f64>,
    pub(crate) write: Option<f64>,
}

/// Calls `work`, and returns its result and its time in seconds.
pub(crate) fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// Loads an input, and returns it with the time in seconds.
pub(crate) fn load_timed(input: &Input, console: &Console) -> Result<(Model, f64), Failure> {
    console.doing("load");
    let (model, seconds) = timed(|| load(input));
    Ok((model?, seconds))
}

/// Loads the input of a job as [`load_timed`] does; a result in glTF gets the images that the input has in separate files. They stay
/// where they are for a `.gltf` in the folder of the input. A result with materials gets those of an OBJ and its libraries, and an OBJ those of glTF.
pub(crate) fn load_job(job: &Job, console: &Console) -> Result<(Model, f64), Failure> {
    let (mut model, seconds) = load_timed(&job.input, console)?;
    let Some(output) = &job.output else { return Ok((model, seconds)) };
    let (images, image_seconds) = timed(|| output.target().complete(&mut model, job.input.path.as_deref()));
    let images = images.map_err(|error| Failure::reading(&job.input.name(), &error))?;
    if let Some(first) = images.left.first() {
        let message = format!("images that the file only refers to: {}, such as {first}", images.left.len());
        console.warning(&job.input.name(), &message);
    }
    Ok((model, seconds + image_seconds))
}

/// Prints what was loaded and its notes: the first lines of operations that build or bound strips.
pub(crate) fn show_mesh(
    mesh: &MeshProperties,
    parts: usize,
    notes: &[String],
    clock: &StageClock,
    console: &Console,
) {
    let faces = counted(mesh.faces, "face");
    let size = format!("{faces}, {}", counted(mesh.vertices, "vertex"));
    console.stage("load", &size, clock.seconds(&[Stage::Load]));
    console.stage("mesh", &mesh_line(mesh, parts), clock.seconds(&[Stage::Survey]));
    notes.iter().for_each(|note| console.note(note));
    console.stage("dual", &format!("{faces} joined across shared edges"), clock.seconds(&[Stage::Prepare]));
}

/// Prints what a search for strips found, and prints and records a note if it was stopped.
pub(crate) fn show_search(
    what: &str,
    seconds: f64,
    stopped: Option<Stopped>,
    console: &Console,
    notes: &mut Vec<String>,
) {
    console.stage("stripify", what, Some(seconds));
    if let Some(stopped) = stopped {
        console.note(stopped.note());
        notes.push(stopped.note().into());
    }
}

/// Shows the stages of an input. `handle` receives each event with the time of its stage in seconds, to report it.
pub(crate) struct Stages<'a, F> {
    console: &'a Console,
    budget: Option<Duration>,
    load_seconds: f64,
    handle: Mutex<(F, Times)>,
}

/// When the current stage began, and how long the dual graph took, which is shown after the report on the mesh.
struct Times {
    started: Instant,
    dual: f64,
}

impl<'a, F: FnMut(Event<'_>, f64) + Send> Stages<'a, F> {
    /// Shows the stages of an input that was loaded in this time.
    pub(crate) fn new(console: &'a Console, load_seconds: f64, handle: F) -> Self {
        let times = Times { started: Instant::now(), dual: 0.0 };
        Self { console, budget: None, load_seconds, handle: Mutex::new((handle, times)) }
    }

    /// Stops each search after a time.
    pub(crate) fn with_budget(self, budget: Option<Duration>) -> Self {
        Self { budget, ..self }
    }

    fn show_mesh(&self, parts: usize, mesh: &MeshProperties, notes: &[String], seconds: f64, dual: f64) {
        let faces = counted(mesh.faces, "face");
        let size = format!("{faces}, {}", counted(mesh.vertices, "vertex"));
        self.console.stage("load", &size, Some(self.load_seconds));
        self.console.stage("mesh", &mesh_line(mesh, parts), Some(seconds));
        notes.iter().for_each(|note| self.console.note(note));
        self.console.stage("dual", &format!("{faces} joined across shared edges"), Some(dual));
    }
}

impl<F: FnMut(Event<'_>, f64) + Send> Observer for Stages<'_, F> {
    fn stage(&self, stage: Stage) {
        self.console.doing(&stage.to_string());
        if let Ok(mut handle) = self.handle.lock() {
            handle.1.started = Instant::now();
        }
    }

    fn event(&self, event: Event<'_>) {
        // Events come from the thread that runs the pipeline, so that nobody else holds the lock.
        let Ok(mut handle) = self.handle.lock() else { return };
        let (handle, times) = &mut *handle;
        let seconds = times.started.elapsed().as_secs_f64();
        match event {
            Event::Prepared => times.dual = seconds,
            Event::Surveyed { parts, mesh, notes } => {
                self.show_mesh(parts, mesh, notes, seconds, times.dual);
            }
            Event::Note(note) => self.console.note(note),
            _ => (),
        }
        handle(event, seconds);
    }

    fn search(&self, options: &StripifyOptions) -> Box<dyn Search + '_> {
        Box::new(SearchWatch::new(self.console.progress(), self.budget, options))
    }
}
