//! What a view needs, and tasks of flights.

use std::num::NonZeroU32;
use std::path::PathBuf;
use std::time::Duration;

use tristrip::StripifyOptions;
use tristrip::lod::{Filter, Foveation, ViewCriteria};
use tristrip_lab::flight::{CameraPath, Lens, MAX_FRAMES};

use super::checks::{check_chart, of_flag};
use crate::args::{CriteriaArgs, FlyArgs, LensArgs};
use crate::job::{Input, inputs};
use crate::values::{Amount as Count, Vector};

/// The pictures of a flight, unless more are asked for.
const USUAL_PICTURES: usize = 60;

#[derive(Debug)]
pub(crate) struct FlyTask {
    pub(crate) input: Input,
    pub(crate) options: StripifyOptions,
    pub(crate) budget: Option<Duration>,
    pub(crate) path: CameraPath,
    pub(crate) frame_count: usize,
    pub(crate) lens: Lens,
    pub(crate) criteria: ViewCriteria,
    pub(crate) filter: Filter,
    pub(crate) verify: bool,
    /// The Markdown file to write.
    pub(crate) report: Option<PathBuf>,
    /// The SVG file to write.
    pub(crate) plot: Option<PathBuf>,
    pub(crate) video: Option<VideoTask>,
}

/// The pictures of a flight.
#[derive(Debug)]
pub(crate) struct VideoTask {
    pub(crate) directory: PathBuf,
    /// One of how many frames is drawn.
    pub(crate) every: usize,
    /// Whether strips have no colours of their own.
    pub(crate) is_shaded: bool,
}

/// Returns the image of a camera.
pub(super) fn lens(args: &LensArgs) -> Lens {
    Lens { field_of_view: args.field_of_view, image: args.image.0 }
}

/// Checks an allowed error in pixels.
pub(super) fn checked_pixels(pixels: f32) -> Result<f32, String> {
    if pixels.is_finite() && pixels >= 0.0 {
        return Ok(pixels);
    }
    Err(format!("--pixels: found {pixels}, expected a finite number of at least 0"))
}

/// Returns what detail a view needs, without a limit of steps.
pub(super) fn view_criteria(
    pixels: f32,
    triangles: Option<Count>,
    args: &CriteriaArgs,
) -> Result<ViewCriteria, String> {
    let criteria = ViewCriteria::new(checked_pixels(pixels)?).map_err(|error| of_flag(&error))?;
    let mut criteria = criteria
        .with_frustum(!args.no_frustum)
        .with_back_faces(!args.no_back_faces)
        .with_silhouettes(!args.no_silhouettes);
    if let Some(Count(most)) = triangles {
        criteria = criteria.with_budget(most);
    }
    if let Some(Vector(direction)) = args.light {
        criteria = criteria.with_light(direction).map_err(|error| of_flag(&error))?;
    }
    if let Some(growth) = args.foveation {
        let foveation = Foveation::new(growth)
            .map_err(|_| format!("--foveation: found {growth}, expected a finite number of at least 0"))?
            .with_attention(args.attention.0)
            .map_err(|error| of_flag(&error))?;
        criteria = criteria.with_foveation(foveation);
    }
    Ok(criteria)
}

pub(super) fn fly_task(args: FlyArgs) -> Result<FlyTask, String> {
    let input = inputs(vec![args.input], args.from.from)?.pop().ok_or("a file is needed")?;
    if !(1..=MAX_FRAMES).contains(&args.frames) {
        return Err(format!("--frames: found {}, expected 1 to {MAX_FRAMES}", args.frames));
    }
    let lens = lens(&args.lens);
    lens.check().map_err(|error| of_flag(&error))?;
    let mut criteria = view_criteria(args.pixels, args.triangles, &args.criteria)?;
    if let Some(Count(steps)) = args.steps {
        if steps == 0 {
            return Err("--steps: found 0, expected at least 1: a view would never change".into());
        }
        criteria = criteria.with_steps(steps);
    }
    if args.report.as_ref().is_some_and(|path| path.as_os_str() == "-") {
        return Err("--report: found -, expected a file: standard output has the table".into());
    }
    if let Some(path) = &args.plot {
        check_chart("--plot", path, 1)?;
        if args.report.as_ref() == Some(path) {
            return Err(format!("{}: --report and --plot name the same file", path.display()));
        }
    }
    let every = |every: NonZeroU32| every.get() as usize;
    let usual = args.frames.div_ceil(USUAL_PICTURES);
    let video = args.video.map(|directory| VideoTask {
        directory,
        every: args.video_every.map_or(usual, every),
        is_shaded: args.shaded,
    });
    let options = args.method.validate(false)?;
    if input.is_tlod() && (options != StripifyOptions::default() || args.method.budget().is_some()) {
        return Err(format!("{}: has strips of its own; leave out the flags of the method", input.name()));
    }
    Ok(FlyTask {
        input,
        options,
        budget: args.method.budget(),
        path: CameraPath::new(&args.path, args.up).map_err(|error| format!("--{error}"))?,
        frame_count: args.frames,
        lens,
        criteria,
        filter: args.filter,
        verify: !args.no_verify,
        report: args.report,
        plot: args.plot,
        video,
    })
}
