//! Tasks of levels of detail: `chain`, `level`, `camera-level` and `build-lod`.

use std::path::PathBuf;
use std::time::Duration;

use tristrip::lod::{Camera, ModelKind, RepairOptions, View, ViewCriteria};
use tristrip::simplify::{MergeOrder, Price};
use tristrip::{Effort, Layout, StripifyOptions};
use tristrip_io::Format;
use tristrip_pipeline::{Ratio, chain, levels::DisplayFilter, levels::Level, levels::LevelGoal};

use super::checks::of_flag;
use super::views::{checked_pixels, view_criteria};
use crate::args::{BuildLodArgs, CameraLevelArgs, ChainArgs, LevelArgs};
use crate::job::{Input, Job, inputs, jobs_of, jobs_of_levels};
use crate::values::{Amount as Count, VectorArg};

#[derive(Debug)]
pub(crate) struct LevelTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: StripifyOptions,
    pub(crate) budget: Option<Duration>,
    pub(crate) model: ModelKind,
    /// The fraction of the triangles that the base mesh keeps.
    pub(crate) base: Ratio,
    pub(crate) price: Price,
    pub(crate) goal: LevelGoal,
    /// The view for which the error of the level is reported.
    pub(crate) view: Option<View>,
    /// The camera whose view is drawn instead of a level, with the detail criteria of the view.
    pub(crate) camera: Option<(Camera, ViewCriteria)>,
    pub(crate) filter: DisplayFilter,
    /// The effort of [`DisplayFilter::Repair`].
    pub(crate) filter_effort: Effort,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct ChainTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: chain::Options,
    pub(crate) budget: Option<Duration>,
    /// Whether a part may be written as a list. False if the user chose a layout.
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

impl LevelTask {
    /// Returns the options of [`DisplayFilter::Repair`].
    pub(crate) fn repair(&self) -> RepairOptions {
        RepairOptions::default().with_effort(self.filter_effort)
    }
}

pub(super) fn level_task(mut args: LevelArgs) -> Result<LevelTask, String> {
    let model = args.model.unwrap_or(ModelKind::Progressive);
    if model == ModelKind::ProgressiveMesh {
        // This model has no strips: in any other layout, each triangle would be a strip.
        args.output.layout = args.output.layout.or(Some(Layout::List));
    }
    let view = view(&args)?;
    let goal = level_goal(&args, view);
    // A goal can need any level. A level number refers to a range whose coarsest level still
    // resembles the model.
    let base = match goal {
        LevelGoal::Level(_) => Ratio::new(0.05),
        _ => Some(Ratio::ZERO),
    };
    let filter = display_filter(model, args.filter)?;
    let filter_effort = filter_effort(args.filter_effort, filter)?;
    let jobs = jobs_of(args.general, &args.output)?;
    Ok(LevelTask {
        jobs,
        options: args.method.validate()?,
        budget: args.method.budget(),
        model,
        base: args.base.or(base).unwrap_or(Ratio::ZERO),
        price: args.price,
        goal,
        view,
        camera: None,
        filter,
        filter_effort,
        verify: !args.output.target.no_verify,
    })
}

pub(super) fn camera_level_task(args: CameraLevelArgs) -> Result<LevelTask, String> {
    let (VectorArg(eye), VectorArg(look_at)) = (args.eye, args.look_at);
    let [columns, rows] = args.lens.image.0;
    let camera = Camera::new(eye, look_at)
        .and_then(|camera| camera.with_up(args.up.0))
        .and_then(|camera| camera.with_field_of_view(args.lens.field_of_view))
        .and_then(|camera| camera.with_image(columns, rows))
        .map_err(|error| of_flag(&error))?;
    let criteria = view_criteria(args.pixels, args.triangles, &args.criteria)?;
    Ok(LevelTask {
        jobs: jobs_of(args.general, &args.output)?,
        options: args.method.validate()?,
        budget: args.method.budget(),
        model: ModelKind::Skip,
        base: args.base.unwrap_or(Ratio::ZERO),
        price: args.price,
        goal: LevelGoal::Level(Level::Percent(100.0)),
        view: None,
        camera: Some((camera, criteria)),
        filter: DisplayFilter::None,
        filter_effort: Effort::default(),
        verify: !args.output.target.no_verify,
    })
}

/// Returns the view of --pixels.
fn view(args: &LevelArgs) -> Result<Option<View>, String> {
    let (Some(distance), Some(pixels)) = (args.distance, args.pixels) else { return Ok(None) };
    checked_pixels(pixels)?;
    let view = View::of_camera(distance, args.field_of_view, args.rows);
    view.map(Some).map_err(|error| of_flag(&error))
}

/// Returns what selects the level.
fn level_goal(args: &LevelArgs, view: Option<View>) -> LevelGoal {
    match (args.pixels.zip(view), args.triangles, args.error) {
        (Some((pixels, view)), ..) => LevelGoal::Pixels(pixels, view),
        (_, Some(Count(count)), _) => LevelGoal::Triangles(count),
        (.., Some(error)) => LevelGoal::Error(error),
        _ => LevelGoal::Level(args.level.unwrap_or(Level::Percent(10.0))),
    }
}

pub(super) fn chain_task(args: ChainArgs) -> Result<ChainTask, String> {
    let ratios = args.ratios;
    let jobs = jobs_of_levels(args.general, &args.output, ratios.as_slice().len())?;
    let draws_lists = args.output.layout == Some(Layout::List);
    let method = if draws_lists { args.method.for_lists() } else { args.method };
    let options = chain::Options::new(ratios, Format::Glb)
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
    if options.weld {
        return Err(
            "--weld cannot be used with build-lod: the file stores the vertices of the mesh unchanged".into(),
        );
    }
    let input = inputs(vec![input], from.from)?.into_iter().next().ok_or("found no input, expected one")?;
    let budget = method.budget();
    Ok(BuildLodTask { input, output, options, budget, order })
}

/// Returns the filter of a model. Models that store their own strips have none.
fn display_filter(model: ModelKind, filter: Option<DisplayFilter>) -> Result<DisplayFilter, String> {
    match (model, filter) {
        (ModelKind::Progressive | ModelKind::Naive, filter) => Ok(filter.unwrap_or_default()),
        (_, None | Some(DisplayFilter::None)) => Ok(DisplayFilter::None),
        (model, Some(filter)) => {
            Err(format!("--filter {filter} applies to --model progressive and naive, not to {model}"))
        }
    }
}

/// Returns the effort of [`DisplayFilter::Repair`].
fn filter_effort(effort: Option<Effort>, filter: DisplayFilter) -> Result<Effort, String> {
    match effort {
        Some(_) if filter != DisplayFilter::Repair => {
            Err(format!("--filter-effort applies to --filter repair, not to {filter}"))
        }
        effort => Ok(effort.unwrap_or_default()),
    }
}
