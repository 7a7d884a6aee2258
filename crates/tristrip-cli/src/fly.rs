//! `tristrip fly`: a camera over a model with view-dependent detail.

use std::fs;
use std::path::Path;

use serde::Serialize;
use tristrip::Mesh;
use tristrip::lod::{Camera, SkipStrips, SkipView};
use tristrip_lab::flight::{
    FlightObserver, FlightOptions, FlightReport, FrameRow, as_markdown, as_text, draw, fly,
};
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::{MethodReport, Stopped, ViewModel, ViewModelOptions};
use tristrip_render::images::{RenderOptions, strips_seen, triangles_seen};
use tristrip_render::text;

use crate::batch::{self, InputReport, Outcome};
use crate::console::Console;
use crate::failure::Failure;
use crate::input::short_name;
use crate::search::interrupted;
use crate::stage::timed;
use crate::task::{FlyTask, VideoTask};
use crate::view_model::{Building, load_view_model};

/// The most frames whose display strips are proven.
const PROOF_COUNT: usize = 20;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct FlySeconds {
    load: Option<f64>,
    stripify: Option<f64>,
    simplify: Option<f64>,
    build: Option<f64>,
    /// All frames, with their proofs and pictures.
    fly: Option<f64>,
}

/// The report of the input; the keys are those of the JSON output.
#[derive(Debug, Serialize)]
struct FlyReport {
    file: String,
    /// None for a `.tlod` file, which has strips of its own.
    #[serde(flatten)]
    method: Option<MethodReport>,
    filter: String,
    /// The name of the path, or its file.
    path: String,
    proven: Option<bool>,
    seconds: FlySeconds,
    #[serde(flatten)]
    flight: FlightReport,
    report: Option<String>,
    plot: Option<String>,
    /// The directory of the pictures, and their number.
    video: Option<String>,
    pictures: Option<usize>,
    stopped: Option<Stopped>,
    notes: Vec<String>,
    error: Option<String>,
}

impl InputReport for FlyReport {
    fn outcome(&mut self) -> Outcome<'_> {
        Outcome { file: &self.file, proven: Some(&mut self.proven), error: &mut self.error }
    }
}

/// Flies over the input; returns whether all succeeded.
pub(crate) fn run(task: &FlyTask, console: &mut Console) -> bool {
    let new_report = |task: &FlyTask| FlyReport {
        file: task.input.name(),
        method: Some(MethodReport::of(&task.options)),
        filter: task.filter.to_string(),
        path: task.path.name(),
        proven: None,
        seconds: FlySeconds::default(),
        flight: FlightReport::default(),
        report: None,
        plot: None,
        video: None,
        pictures: None,
        stopped: None,
        notes: Vec::new(),
        error: None,
    };
    let process =
        |task: &FlyTask, console: &mut Console, report: &mut FlyReport| flown(task, console, report);
    let show = |_: &FlyTask, report: &FlyReport, title: &str, console: &mut Console| {
        let summary = report.flight.summary.as_ref().map(as_text).unwrap_or_default();
        console.result(&format!("{title}{summary}"), task.report.is_none());
    };
    let reports = batch::process_all(std::slice::from_ref(task), None, console, new_report, process, show);
    batch::finish(reports, console)
}

/// Builds the model, flies, and writes what was asked for.
fn flown(task: &FlyTask, console: &Console, report: &mut FlyReport) -> Result<(), Failure> {
    task.path.check()?;
    let mut building = Building::default();
    let options = ViewModelOptions::default().with_stripify(task.options).with_verify(task.verify);
    let built = load_view_model(&task.input, &options, task.budget, console, &mut building);
    let Building { load, stripify, simplify, build, stopped, notes } = building;
    report.seconds = FlySeconds { load, stripify, simplify, build, fly: None };
    (report.stopped, report.notes) = (stopped, notes);
    let (ViewModel { mesh, .. }, model) = built?;
    report.method = report.method.take().filter(|_| stripify.is_some());
    report.flight = FlightReport::of_model(&model)?;

    let cameras = task.path.cameras(mesh.positions(), task.frame_count, task.lens)?;
    let mut pictures = Pictures::new(task.video.as_ref(), &mesh, console)?;
    console.doing("fly");
    let options = FlightOptions {
        criteria: task.criteria,
        filter: task.filter,
        proof_count: if task.verify { PROOF_COUNT } else { 0 },
    };
    let (rows, seconds) = timed(|| fly(&model, &cameras, &options, &mut pictures));
    let rows = rows?;
    let drawn = pictures.drawn;
    report.seconds.fly = Some(seconds);
    report.flight = std::mem::take(&mut report.flight).with_frames(rows);
    let FlightReport { frames, summary, .. } = &report.flight;
    let (rows, proven) =
        (frames.as_deref().unwrap_or_default(), summary.as_ref().map_or(0, |all| all.frames_proven));
    console.stage("fly", &format!("{}, path {}", counted(rows.len(), "frame"), report.path), Some(seconds));
    if proven > 0 {
        report.proven = Some(true);
        let frames = counted(proven, "frame");
        console.stage("verify", &format!("proven: exactly the triangles of the view, {frames}"), None);
    }
    if let Some(video) = &task.video {
        report.video = Some(video.directory.display().to_string());
        report.pictures = Some(drawn);
        console.stage(
            "video",
            &format!("{}, {}", video.directory.display(), counted(drawn, "picture")),
            None,
        );
    }
    if let Some(path) = &task.report {
        write(path, &page(task, report.method.as_ref(), &model, rows), console, "report")?;
        report.report = Some(path.display().to_string());
    }
    if let Some(path) = &task.plot {
        write(path, &draw(&short_name(&report.file), rows)?, console, "plot")?;
        report.plot = Some(path.display().to_string());
    }
    Ok(())
}

/// Returns the page of a flight.
fn page(task: &FlyTask, method: Option<&MethodReport>, model: &SkipStrips, rows: &[FrameRow]) -> String {
    let criteria = &task.criteria;
    let [columns, height] = task.lens.image;
    let pixels = criteria.pixels();
    let budget = criteria.budget().map(|budget| format!(" At most {}.", counted(budget, "triangle")));
    let steps =
        criteria.steps().map(|steps| format!(" At most {} collapses and splits per frame.", count(steps)));
    let foveation = criteria.foveation().map(|foveation| {
        let [x, y] = foveation.attention();
        format!(" growing by {} per degree from {x}, {y} of the image,", foveation.growth())
    });
    let how = format!(
        "Path {}, {columns} × {height} pixels, {} degrees; error {pixels} px,{} filter {}; strips {}. \
         Vertex tree of height {} with {}, {} bytes with the strips of the full mesh.{}{}",
        task.path.name(),
        task.lens.field_of_view,
        foveation.unwrap_or_default(),
        task.filter,
        method.map_or("of the file".into(), |method| format!("by {}", method.description())),
        model.height(),
        counted(model.levels().collapse_count(), "collapse"),
        count(model.memory_by_part().iter().sum()),
        budget.unwrap_or_default(),
        steps.unwrap_or_default(),
    );
    as_markdown(&format!("Flight: {}", short_name(&task.input.name())), &how, rows)
}

fn write(path: &Path, contents: &str, console: &Console, stage: &str) -> Result<(), Failure> {
    tristrip_io::replace_file(path, contents.as_bytes()).map_err(|error| Failure::writing(&error))?;
    console.stage(stage, &format!("{}, {}", path.display(), text::bytes(contents.len())), None);
    Ok(())
}

/// Draws frames into a directory.
struct Pictures<'a> {
    video: Option<&'a VideoTask>,
    mesh: &'a Mesh,
    console: &'a Console,
    drawn: usize,
}

impl<'a> Pictures<'a> {
    /// Creates the directory if it does not exist, but not a missing parent, which is more likely a typing error.
    fn new(video: Option<&'a VideoTask>, mesh: &'a Mesh, console: &'a Console) -> Result<Self, Failure> {
        if let Some(VideoTask { directory, .. }) = video
            && !directory.is_dir()
        {
            fs::create_dir(directory).map_err(|error| Failure::system(directory, &error))?;
        }
        Ok(Self { video, mesh, console, drawn: 0 })
    }
}

impl FlightObserver for Pictures<'_> {
    fn frame(&mut self, row: &FrameRow, camera: &Camera, view: &SkipView) -> Result<(), tristrip_lab::Error> {
        self.console.doing(&format!("fly: frame {}", count(row.frame)));
        let Some(video) = self.video.filter(|video| row.frame.is_multiple_of(video.every)) else {
            return Ok(());
        };
        let [columns, rows] = camera.image();
        let options = RenderOptions::default().with_size(columns, rows);
        let (positions, strips) = (self.mesh.positions(), view.display_strips());
        let picture = if video.is_shaded {
            triangles_seen(&[(positions, &strips.to_list())], camera, &options)?
        } else {
            strips_seen(&[(positions, &strips)], camera, &options)?
        };
        let path = video.directory.join(format!("{:04}.png", self.drawn));
        tristrip_io::replace_file(&path, &picture).map_err(tristrip_pipeline::Error::from)?;
        self.drawn += 1;
        Ok(())
    }

    fn is_cancelled(&self) -> bool {
        interrupted()
    }
}
