//! Tasks of levels of detail: `chain`, `lod` and `build-lod`.

use std::path::PathBuf;
use std::time::Duration;

use tristrip::lod::{Camera, ModelKind, RepairOptions, View, ViewCriteria};
use tristrip::simplify::{MergeOrder, Price};
use tristrip::{Effort, Layout, StripifyOptions};
use tristrip_io::Format;
use tristrip_pipeline::{ChainOptions, DisplayFilter, Level, LevelGoal, Ratio};

use super::checks::of_flag;
use super::views::{checked_pixels, view_criteria};
use crate::args::{BuildLodArgs, ChainArgs, LodArgs};
use crate::job::{Input, Job, inputs, jobs_of, jobs_of_levels};
use crate::values::{Amount as Count, Vector};

#[derive(Debug)]
pub(crate) struct LodTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: StripifyOptions,
    pub(crate) budget: Option<Duration>,
    pub(crate) model: ModelKind,
    /// The ratio of triangles that the base mesh keeps.
    pub(crate) base: Ratio,
    pub(crate) price: Price,
    pub(crate) goal: LevelGoal,
    /// The view in which the error of the level is reported.
    pub(crate) view: Option<View>,
    /// The camera of which the view is drawn instead of a level, and what detail it needs.
    pub(crate) camera: Option<(Camera, ViewCriteria)>,
    pub(crate) filter: DisplayFilter,
    /// The effort of [`DisplayFilter::Repair`].
    pub(crate) filter_effort: Effort,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct ChainTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: ChainOptions,
    pub(crate) budget: Option<Duration>,
    /// Whether a part may be written as a list: not if the user chose a layout.
    pub(crate) list: bool,
}

#[derive(Debug)]
pub(crate) struct BuildLodTask {
    pub(crate) input: Input,
    /// The file to write.
    pub(crate) output: PathBuf,
    pub(crate) options: StripifyOptions,
    pub(crate) budget: Option<Duration>,
    pub(crate) order: MergeOrder,
}

impl LodTask {
    /// Returns the options of [`DisplayFilter::Repair`].
    pub(crate) fn repair(&self) -> RepairOptions {
        RepairOptions::default().with_effort(self.filter_effort)
    }
}

pub(super) fn lod_task(mut args: LodArgs) -> Result<LodTask, String> {
    if args.model == ModelKind::ProgressiveMesh {
        // It has no strips: in any other layout, each triangle would be one.
        args.output.layout = args.output.layout.or(Some(Layout::List));
    }
    if args.pixels.is_some() && args.triangles.is_some() && args.camera.is_none() {
        return Err("--triangles cannot be used with --pixels without --camera".into());
    }
    let view = view(&args)?;
    let goal = level_goal(&args, view);
    // Goals may need any level; a level is a number within a range that is not too coarse to look at.
    let camera = camera(&args)?;
    let base = match goal {
        LevelGoal::Level(_) if camera.is_none() => Ratio::new(0.05),
        _ => Some(Ratio::ZERO),
    };
    let filter = display_filter(args.model, args.filter)?;
    let filter_effort = filter_effort(&args, filter)?;
    let jobs = jobs_of(args.general, &args.output)?;
    Ok(LodTask {
        jobs,
        options: args.method.validate()?,
        budget: args.method.budget(),
        model: args.model,
        base: args.base.or(base).unwrap_or(Ratio::ZERO),
        price: args.price,
        goal,
        view,
        camera,
        filter,
        filter_effort,
        verify: !args.output.target.no_verify,
    })
}

/// Returns the view of --pixels.
fn view(args: &LodArgs) -> Result<Option<View>, String> {
    let (Some(distance), Some(pixels)) = (args.distance, args.pixels) else { return Ok(None) };
    checked_pixels(pixels)?;
    let view = View::of_camera(distance, args.lens.field_of_view, args.rows);
    view.map(Some).map_err(|error| of_flag(&error))
}

/// Returns the camera of a view, and what detail it needs.
fn camera(args: &LodArgs) -> Result<Option<(Camera, ViewCriteria)>, String> {
    let (Some(Vector(eye)), Some(Vector(look_at))) = (args.camera, args.look_at) else { return Ok(None) };
    if args.model != ModelKind::Skip {
        return Err(format!("--camera belongs to --model skip, not to {}", args.model));
    }
    let [columns, rows] = args.lens.image.0;
    let camera = Camera::new(eye, look_at)
        .and_then(|camera| camera.with_up(args.up.0))
        .and_then(|camera| camera.with_field_of_view(args.lens.field_of_view))
        .and_then(|camera| camera.with_image(columns, rows))
        .map_err(|error| of_flag(&error))?;
    let criteria = view_criteria(args.pixels.unwrap_or(1.0), args.triangles, &args.criteria)?;
    Ok(Some((camera, criteria)))
}

/// Returns what selects the level.
fn level_goal(args: &LodArgs, view: Option<View>) -> LevelGoal {
    match (args.pixels.zip(view), args.triangles, args.error) {
        (Some((pixels, view)), ..) => LevelGoal::Pixels(pixels, view),
        (_, Some(Count(count)), _) if args.camera.is_none() => LevelGoal::Triangles(count),
        (.., Some(error)) => LevelGoal::Error(error),
        _ => LevelGoal::Level(args.level.unwrap_or(Level::Percent(10.0))),
    }
}

pub(super) fn chain_task(args: ChainArgs) -> Result<ChainTask, String> {
    let ratios = args.ratios;
    let jobs = jobs_of_levels(args.general, &args.output, ratios.as_slice().len())?;
    let draws_lists = args.output.layout == Some(Layout::List);
    let method = if draws_lists { args.method.for_lists() } else { args.method };
    let options = ChainOptions::new(ratios, Format::Glb)
        .with_deviation(args.collapse.error.unwrap_or_default())
        .with_rules(args.collapse.rules())
        .with_stripify(method.validate()?)
        .with_verify(!args.output.target.no_verify);
    Ok(ChainTask { jobs, options, budget: method.budget(), list: args.output.layout.is_none() })
}

pub(super) fn build_lod_task(args: BuildLodArgs) -> Result<BuildLodTask, String> {
    let BuildLodArgs { input, from, order, output, method } = args;
    if output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("tlod")) {
        return Err(format!("{}: build-lod writes .tlod; use this extension", output.display()));
    }
    let options = method.validate()?;
    if options.weld() {
        return Err(
            "--weld does not fit build-lod: the file holds the vertices of the mesh as they are".into()
        );
    }
    let input = inputs(vec![input], from.from)?.into_iter().next().ok_or("an input is needed")?;
    let budget = method.budget();
    Ok(BuildLodTask { input, output, options, budget, order })
}

/// Returns the filter of a model: models that store strips by themselves have none.
fn display_filter(model: ModelKind, filter: Option<DisplayFilter>) -> Result<DisplayFilter, String> {
    match (model, filter) {
        (ModelKind::Progressive | ModelKind::Naive, filter) => Ok(filter.unwrap_or_default()),
        (_, None | Some(DisplayFilter::None)) => Ok(DisplayFilter::None),
        (model, Some(filter)) => Err(format!(
            "--filter {filter} belongs to --model progressive and naive: {model} is drawn as it is stored"
        )),
    }
}

/// Returns the effort of [`DisplayFilter::Repair`].
fn filter_effort(args: &LodArgs, filter: DisplayFilter) -> Result<Effort, String> {
    let is_used = filter == DisplayFilter::Repair;
    match args.filter_effort {
        Some(_) if !is_used => Err(format!("--filter-effort belongs to --filter repair, not to {filter}")),
        effort => Ok(effort.unwrap_or_default()),
    }
}
