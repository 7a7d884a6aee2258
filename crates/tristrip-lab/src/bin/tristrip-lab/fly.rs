//! `tristrip-lab fly`: a camera over a model with view-dependent detail.

use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use tristrip::Mesh;
use tristrip::lod::{Camera, Foveation, SkipStrips, SkipView, ViewCriteria};
use tristrip_io::tlod::{self, TlodLimits};
use tristrip_lab::flight::{
    CameraPath, FlightObserver, FlightOptions, FlightReport, FrameRow, Lens, MAX_FRAMES, as_markdown,
    as_text, draw, fly,
};
use tristrip_pipeline::MethodDescription;
use tristrip_pipeline::text::{count, counted};
use tristrip_pipeline::view_model::{self, ViewModel};
use tristrip_render::images::{RenderOptions, strips_seen, triangles_seen};

use crate::args::FlyArgs;
use crate::console::Console;
use crate::failure::Failure;
use crate::input::{check_chart, load, short_name, timed, write_text};

/// The maximum number of frames whose display strips are proven.
const PROOF_COUNT: usize = 20;
/// The default maximum number of images.
const DEFAULT_IMAGES: usize = 60;

/// The time of each stage in seconds; `null` for a stage that did not run.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct FlySeconds {
    load: Option<f64>,
    build: Option<f64>,
    /// All frames, with their proofs and images.
    fly: Option<f64>,
}

/// The report of the input; the keys are those of the JSON output.
#[derive(Debug, Default, Serialize)]
struct FlyReport {
    file: String,
    /// `None` for a `.tlod` file, which has its own strips.
    #[serde(flatten)]
    method: Option<MethodDescription>,
    filter: String,
    /// The name of the path, or its file.
    path: String,
    proven: Option<bool>,
    seconds: FlySeconds,
    #[serde(flatten)]
    flight: FlightReport,
    report: Option<String>,
    plot: Option<String>,
    /// The directory of the images, and their number.
    video: Option<String>,
    pictures: Option<usize>,
    notes: Vec<String>,
    error: Option<String>,
}

/// A flight with validated arguments.
struct Task<'a> {
    args: &'a FlyArgs,
    path: CameraPath,
    lens: Lens,
    criteria: ViewCriteria,
}

/// Flies over the input.
pub(crate) fn run(args: &FlyArgs, console: &Console) -> Result<(), Failure> {
    let task = Task::of(args)?;
    let mut report = FlyReport {
        file: args.input.display().to_string(),
        filter: args.filter.to_string(),
        path: task.path.name(),
        ..FlyReport::default()
    };
    let done = flown(&task, console, &mut report);
    if let Err(Failure::Failed(message)) = &done {
        console.error(message);
        report.error = Some(message.clone());
        console.json(&[report])?;
        return Err(Failure::Reported);
    }
    done?;
    console.result(&report.flight.summary.as_ref().map(as_text).unwrap_or_default())?;
    console.json(&[report])
}

/// Returns the failure for an invalid value, with the name of its argument.
fn of_argument(error: &tristrip::Error) -> Failure {
    Failure::Usage(match error {
        tristrip::Error::Parameter { name, found, expected } => {
            let flag = if *name == "growth" { "foveation".into() } else { name.replace('_', "-") };
            format!("--{flag}: found {found}, expected {expected}")
        }
        other => other.to_string(),
    })
}

impl<'a> Task<'a> {
    fn of(args: &'a FlyArgs) -> Result<Self, Failure> {
        let usage = |message: String| Err(Failure::Usage(message));
        if !(1..=MAX_FRAMES).contains(&args.frames) {
            return usage(format!("--frames: found {}, expected 1 to {MAX_FRAMES}", args.frames));
        }
        if !(args.pixels.is_finite() && args.pixels >= 0.0) {
            let expected = "expected a finite number of at least 0";
            return usage(format!("--pixels: found {}, {expected}", args.pixels));
        }
        if args.report.as_ref().is_some_and(|path| path.as_os_str() == "-") {
            return usage("--report: found -, expected a file: standard output has the table".into());
        }
        if let Some(path) = &args.plot {
            check_chart("--plot", path, 1)?;
            if args.report.as_ref() == Some(path) {
                return usage(format!("{}: --report and --plot name the same file", path.display()));
            }
        }
        if args.method.is_some() && is_tlod(&args.input) {
            return usage(format!(
                "{}: --method cannot be used: the file has its own strips",
                args.input.display()
            ));
        }
        let lens = Lens { field_of_view: args.field_of_view, image: args.image };
        lens.check().map_err(|error| of_argument(&error))?;
        let path = CameraPath::new(&args.path, args.up);
        let path = path.map_err(|error| Failure::Usage(format!("--{error}")))?;
        Ok(Self { args, path, lens, criteria: criteria(args).map_err(|error| of_argument(&error))? })
    }
}

/// Returns the criteria that decide the detail of a frame.
fn criteria(args: &FlyArgs) -> Result<ViewCriteria, tristrip::Error> {
    let mut criteria = ViewCriteria::default()
        .with_pixels(args.pixels)
        .with_frustum(!args.no_frustum)
        .with_back_faces(!args.no_back_faces)
        .with_silhouettes(!args.no_silhouettes);
    if let Some(triangles) = args.triangles {
        criteria = criteria.with_budget(triangles);
    }
    if let Some(steps) = args.steps {
        criteria = criteria.with_steps(steps.get());
    }
    if let Some(direction) = args.light {
        criteria = criteria.with_light(direction);
    }
    if let Some(growth) = args.foveation {
        criteria = criteria.with_foveation(Foveation::new(growth)?.with_attention(args.attention)?);
    }
    criteria.check()?;
    Ok(criteria)
}

fn is_tlod(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("tlod"))
}

/// Reads a `.tlod` file, or builds the model of a mesh.
fn view_model_of(task: &Task<'_>, console: &Console, report: &mut FlyReport) -> Result<ViewModel, Failure> {
    let Task { args, .. } = task;
    if is_tlod(&args.input) {
        let (read, seconds) = timed(|| {
            let file = File::open(&args.input)
                .map_err(|source| tristrip_io::Error::Io { path: args.input.display().to_string(), source });
            file.and_then(|file| tlod::read(file, &TlodLimits::default()))
        });
        report.seconds.load = Some(seconds);
        return Ok(read?.into());
    }
    let (model, seconds) = load(&args.input, console)?;
    report.seconds.load = Some(seconds);
    let stripify = args.method.unwrap_or_default();
    report.method = Some(MethodDescription::of(&stripify));
    let options = view_model::Options::default().with_stripify(stripify).with_verify(!args.no_verify);
    let (built, seconds) = timed(|| view_model::run(model, &options, &()));
    report.seconds.build = Some(seconds);
    let built = built?;
    report.notes = built.notes;
    Ok(built.model)
}

/// Builds the model, flies, and writes the requested files.
fn flown(task: &Task<'_>, console: &Console, report: &mut FlyReport) -> Result<(), Failure> {
    let args = task.args;
    task.path.check()?;
    let ViewModel { mesh, strips, sequence, .. } = view_model_of(task, console, report)?;
    let model = Arc::new(SkipStrips::new(&strips, &sequence, mesh.positions())?);
    let base = counted(model.levels().triangle_count(0)?, "triangle");
    console.stage("build", &format!("vertex tree over a base mesh of {base}"), report.seconds.build);
    report.flight = FlightReport::of_model(&model)?;

    let cameras = task.path.cameras(mesh.positions(), args.frames, task.lens)?;
    let mut images = Images::new(args, &mesh)?;
    let options = FlightOptions {
        criteria: task.criteria,
        filter: args.filter,
        proof_count: if args.no_verify { 0 } else { PROOF_COUNT },
    };
    let (rows, seconds) = timed(|| fly(&model, &cameras, &options, &mut images));
    let rows = rows?;
    report.seconds.fly = Some(seconds);
    console.stage("fly", &format!("{}, path {}", counted(rows.len(), "frame"), report.path), Some(seconds));
    let drawn = images.drawn;
    report.flight = std::mem::take(&mut report.flight).with_frames(rows);
    let FlightReport { frames, summary, .. } = &report.flight;
    let rows = frames.as_deref().unwrap_or_default();
    let proven = summary.as_ref().map_or(0, |all| all.frames_proven);
    if proven > 0 {
        report.proven = Some(true);
        let frames = counted(proven, "frame");
        console.stage("verify", &format!("proven: exactly the triangles of the view, {frames}"), None);
    }
    if let Some(directory) = &args.video {
        report.video = Some(directory.display().to_string());
        report.pictures = Some(drawn);
        console.stage("video", &format!("{}, {}", directory.display(), counted(drawn, "image")), None);
    }
    if let Some(path) = &args.report {
        write_text(path, &page(task, report.method.as_ref(), &model, rows), "report", console)?;
        report.report = Some(path.display().to_string());
    }
    if let Some(path) = &args.plot {
        write_text(path, &draw(&short_name(&args.input), rows)?, "plot", console)?;
        report.plot = Some(path.display().to_string());
    }
    Ok(())
}

/// Returns the page of a flight.
fn page(
    task: &Task<'_>,
    method: Option<&MethodDescription>,
    model: &SkipStrips,
    rows: &[FrameRow],
) -> String {
    let criteria = &task.criteria;
    let [columns, height] = task.lens.image;
    let pixels = criteria.pixels;
    let budget = criteria.budget.map(|budget| format!(" At most {}.", counted(budget, "triangle")));
    let steps = criteria
        .steps
        .map(|steps| format!(" At most {} per frame, collapses or splits.", counted(steps, "step")));
    let foveation = criteria.foveation.map(|foveation| {
        let [x, y] = foveation.attention();
        format!(" growing by {} per degree from {x}, {y} of the image,", foveation.growth())
    });
    let how = format!(
        "Path {}, {columns} × {height} pixels, {} degrees; error {pixels} px,{} filter {}; strips {}. \
         Vertex tree of height {} with {}, {} bytes with the strips of the full mesh.{}{}",
        task.path.name(),
        task.lens.field_of_view,
        foveation.unwrap_or_default(),
        task.args.filter,
        method.map_or("of the file".into(), |method| format!("by {}", method.description())),
        model.height(),
        counted(model.levels().collapse_count(), "collapse"),
        count(model.memory_by_part().iter().sum()),
        budget.unwrap_or_default(),
        steps.unwrap_or_default(),
    );
    as_markdown(&format!("Flight: {}", short_name(&task.args.input)), &how, rows)
}

/// Writes frames as images to a directory.
struct Images<'a> {
    args: &'a FlyArgs,
    mesh: &'a Mesh,
    /// One of every `every` frames is drawn.
    every: usize,
    drawn: usize,
}

impl<'a> Images<'a> {
    /// Creates the directory if it does not exist. A missing parent is more likely a typing error.
    fn new(args: &'a FlyArgs, mesh: &'a Mesh) -> Result<Self, Failure> {
        if let Some(directory) = &args.video
            && !directory.is_dir()
        {
            fs::create_dir(directory)
                .map_err(|source| tristrip_io::Error::Io { path: directory.display().to_string(), source })?;
        }
        let every = args.video_every.map_or(args.frames.div_ceil(DEFAULT_IMAGES), usize::from);
        Ok(Self { args, mesh, every, drawn: 0 })
    }
}

impl FlightObserver for Images<'_> {
    fn frame(&mut self, row: &FrameRow, camera: &Camera, view: &SkipView) -> Result<(), tristrip_lab::Error> {
        let Some(directory) = self.args.video.as_ref().filter(|_| row.frame.is_multiple_of(self.every))
        else {
            return Ok(());
        };
        let [columns, rows] = camera.image();
        let options = RenderOptions::default().with_size(columns, rows);
        let (positions, strips) = (self.mesh.positions(), view.display_strips());
        let image = if self.args.shaded {
            triangles_seen(&[(positions, &strips.to_list())], camera, &options)?
        } else {
            strips_seen(&[(positions, &strips)], camera, &options)?
        };
        let path = directory.join(format!("{:04}.png", self.drawn));
        tristrip_io::replace_file(&path, &image).map_err(tristrip_pipeline::Error::from)?;
        self.drawn += 1;
        Ok(())
    }
}
