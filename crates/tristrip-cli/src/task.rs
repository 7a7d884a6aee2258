//! Validated tasks: the only place where flags are checked against each other and turned into a task, or rejected with a message.

use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tristrip::Effort;
use tristrip::lod::{Camera, Filter, Foveation, ModelKind, RepairOptions, View, ViewCriteria};
use tristrip::simplify::{MergeOrder, Price};
use tristrip::vertex_cache::FlushPolicy;
use tristrip::{Layout, StripifyOptions};
use tristrip_io::Format;
use tristrip_io::gltf::Rounding;
use tristrip_lab::flight::{Axis, Lens, MAX_FRAMES};
use tristrip_lab::recovery::Sweep;
use tristrip_pipeline::{
    Amount, AnalyzeOptions, ChainOptions, ChainRatios, DisplayFilter, Goal, Level, LevelGoal, Ratio,
    SimplifyOptions, VertexCacheList,
};

use crate::args::{
    self, AnalyzeArgs, BuildLodArgs, Command, CriteriaArgs, FlyArgs, LensArgs, LodArgs, OutputArgs,
    SharedArgs,
};
use crate::job::{Input, Job, inputs, inputs_of, jobs_of, jobs_of_levels, write_to_stdout};
use crate::shell;
use crate::values::{Amount as Count, Vector};

/// The maximum number of inputs in one chart: with more, the curves cannot be told apart.
const MAX_PLOTTED_INPUTS: usize = 3;

/// The pictures of a flight, unless more are asked for.
const USUAL_PICTURES: usize = 60;

/// A subcommand with options that fit each other.
#[derive(Debug)]
pub(crate) enum Task {
    Strip(StripTask),
    Compare(CompareTask),
    Bound(BoundTask),
    Analyze(AnalyzeTask),
    Verify(VerifyTask),
    Convert(ConvertTask),
    Simplify(SimplifyTask),
    Lod(LodTask),
    Chain(ChainTask),
    BuildLod(BuildLodTask),
    Fly(FlyTask),
    Repro(ReproTask),
    /// A text to print: completions, or a man page.
    Print(Vec<u8>),
}

#[derive(Debug)]
pub(crate) struct StripTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: StripifyOptions,
    pub(crate) budget: Option<Duration>,
    /// Whether a part may be written as a list: not if the user chose a layout.
    pub(crate) list: bool,
    /// Whether to write vertices in the order of first use.
    pub(crate) reorder: bool,
    pub(crate) verify: bool,
    pub(crate) pareto: Option<ParetoTask>,
    /// The PNG file to draw the strips in.
    pub(crate) picture: Option<PathBuf>,
}

/// A chart of all methods.
#[derive(Debug)]
pub(crate) struct ParetoTask {
    /// The SVG file to write.
    pub(crate) path: PathBuf,
    /// The effort of all searches; `None` for the default of each method.
    pub(crate) effort: Option<Effort>,
}

#[derive(Debug)]
pub(crate) struct CompareTask {
    pub(crate) inputs: Vec<Input>,
    pub(crate) every_variant: bool,
    pub(crate) markdown: bool,
    pub(crate) options: StripifyOptions,
    /// The effort of the methods that search; `best` also runs at its default effort.
    pub(crate) effort: Effort,
    pub(crate) budget: Option<Duration>,
}

#[derive(Debug)]
pub(crate) struct BoundTask {
    pub(crate) inputs: Vec<Input>,
    pub(crate) options: StripifyOptions,
}

#[derive(Debug)]
pub(crate) struct AnalyzeTask {
    pub(crate) inputs: Vec<Input>,
    pub(crate) options: AnalyzeOptions,
    /// The SVG file to write.
    pub(crate) plot: Option<PathBuf>,
    /// The vertex caches of its curves.
    pub(crate) curve: Option<VertexCacheList>,
}

#[derive(Debug)]
pub(crate) struct VerifyTask {
    pub(crate) source: Input,
    pub(crate) result: Input,
}

#[derive(Debug)]
pub(crate) struct ConvertTask {
    pub(crate) jobs: Vec<Job>,
    /// Whether to write all faces as strips in stored order, not only those that the input stores as strips.
    pub(crate) as_strips: bool,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct SimplifyTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: SimplifyOptions,
    /// The PNG file of the model before and after.
    pub(crate) picture: Option<PathBuf>,
}

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
    pub(crate) table: bool,
    pub(crate) compare: bool,
    /// The sweeps over which every model is measured.
    pub(crate) sweeps: Vec<Sweep>,
    /// The SVG file to write.
    pub(crate) plot: Option<PathBuf>,
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

/// Where a camera flies.
#[derive(Debug)]
pub(crate) enum CameraPath {
    /// Around the model.
    Orbit(Axis),
    /// Towards the model.
    Dolly(Axis),
    /// Over the model; without an axis, its shortest side is vertical.
    Flyover(Option<Axis>),
    /// Through the cameras of a JSON file.
    File(PathBuf),
}

impl CameraPath {
    /// Returns the name for reports: that of the path, or of the file.
    pub(crate) fn name(&self) -> String {
        match self {
            Self::Orbit(_) => "orbit".into(),
            Self::Dolly(_) => "dolly".into(),
            Self::Flyover(_) => "flyover".into(),
            Self::File(path) => path.display().to_string(),
        }
    }
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

#[derive(Debug)]
pub(crate) struct ReproTask {
    /// The keys of the papers.
    pub(crate) papers: BTreeSet<String>,
    pub(crate) models: PathBuf,
    pub(crate) output: PathBuf,
}

/// The options that all tasks share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) json: bool,
    pub(crate) quiet: bool,
    pub(crate) threads: Option<usize>,
}

impl Task {
    /// Returns whether a mesh is written to standard output.
    pub(crate) fn output_is_stdout(&self) -> bool {
        match self {
            Self::Strip(StripTask { jobs, .. })
            | Self::Convert(ConvertTask { jobs, .. })
            | Self::Simplify(SimplifyTask { jobs, .. })
            | Self::Lod(LodTask { jobs, .. })
            | Self::Chain(ChainTask { jobs, .. }) => write_to_stdout(jobs),
            Self::Compare(_)
            | Self::Bound(_)
            | Self::Analyze(_)
            | Self::Verify(_)
            | Self::BuildLod(_)
            | Self::Fly(_)
            | Self::Repro(_)
            | Self::Print(_) => false,
        }
    }
}

impl Task {
    /// Returns the task if the shared options fit it: these may stand before the subcommand, where clap does not compare them with its flags.
    fn fitting(self, shared: &Shared) -> Result<Self, String> {
        match &self {
            Self::Compare(CompareTask { markdown: true, .. }) if shared.json => {
                Err("--markdown cannot be used with --json".into())
            }
            task if task.output_is_stdout() && shared.json => {
                Err("-o - and --json both write to standard output".into())
            }
            _ => Ok(self),
        }
    }
}

/// Parses the command line into a task; exits with the help, the version, or exit code 2 for wrong usage. The papers are those that can
/// be reproduced.
pub(crate) fn parse(papers: &[&str]) -> (Task, Shared) {
    let parsed = args::parse();
    let shared = shared(&parsed.shared);
    let task = validate(parsed.command, papers).and_then(|task| task.fitting(&shared));
    let task = task.unwrap_or_else(|message| args::exit_with_usage_error(parsed.subcommand, &message));
    (task, shared)
}

/// Builds a task from flags.
///
/// # Errors
/// Flags do not fit together; the message names them.
fn validate(command: Command, papers: &[&str]) -> Result<Task, String> {
    Ok(match command {
        Command::Strip(args) => {
            let jobs = jobs_of(args.general, &args.output)?;
            let options = args.method.validate(args.pareto.is_some())?;
            let pareto =
                args.pareto.map(|path| pareto_task(path, args.method.effort(), &jobs)).transpose()?;
            let budget = args.method.budget();
            let (list, reorder) = (args.output.layout.is_none(), args.reorder_vertices);
            let verify = !args.output.target.no_verify;
            let picture = args.picture;
            if let Some(path) = &picture {
                check_picture(path, &jobs)?;
            }
            Task::Strip(StripTask { jobs, options, budget, list, reorder, verify, pareto, picture })
        }
        Command::Compare(args) => {
            let options = StripifyOptions::default()
                .with_seed(args.seed)
                .with_weld(args.weld.weld)
                .with_cost(args.cost);
            let inputs = inputs_of(args.general)?;
            let (every_variant, markdown) = (args.all, args.markdown);
            let (effort, budget) = (args.effort, args.budget);
            let task = CompareTask { inputs, every_variant, markdown, options, effort, budget };
            Task::Compare(task)
        }
        Command::Bound(args) => {
            let options = StripifyOptions::default().with_weld(args.weld.weld);
            let inputs = inputs_of(args.general)?;
            Task::Bound(BoundTask { inputs, options })
        }
        Command::Analyze(args) => analyze_task(args)?,
        Command::Verify(args) => {
            let both = inputs(vec![args.source, args.result], args.from.from)?;
            let [source, result]: [Input; 2] = both.try_into().map_err(|_| "two files are needed")?;
            Task::Verify(VerifyTask { source, result })
        }
        Command::Convert(args) => {
            if args.output.target.output.is_none() {
                return Err("-o is needed: name the file to write".into());
            }
            let (as_strips, verify) = (args.output.layout.is_some(), !args.output.target.no_verify);
            let jobs = jobs_of(args.general, &args.output)?;
            Task::Convert(ConvertTask { jobs, as_strips, verify })
        }
        Command::Simplify(args) => {
            let amount = args.ratio.map(Amount::Ratio).or(args.triangles.map(Amount::Triangles));
            let goal = Goal { amount, deviation: args.collapse.error.unwrap_or_default() };
            let verify = !args.target.no_verify;
            let output = OutputArgs { target: args.target, layout: Some(Layout::List) };
            let jobs = jobs_of(args.general, &output)?;
            if let Some(path) = &args.picture {
                check_picture(path, &jobs)?;
            }
            let mut options = SimplifyOptions::new(goal).with_rules(args.collapse.rules());
            options = options.with_normals(args.normals).with_verify(verify);
            if args.compact {
                options = options.with_rounding(Rounding::WeightsAndRotations);
            }
            Task::Simplify(SimplifyTask { jobs, options, picture: args.picture })
        }
        Command::Lod(args) => match args.chain.clone() {
            Some(ratios) => chain_task(*args, ratios)?,
            None => lod_task(*args)?,
        },
        Command::BuildLod(args) => build_lod_task(*args)?,
        Command::Fly(args) => fly_task(*args)?,
        Command::Repro(args) => {
            let papers = select_papers(args.papers, papers)?;
            let models = args.models.unwrap_or_else(default_models);
            let task = ReproTask { papers, models, output: args.output };
            Task::Repro(task)
        }
        Command::Completions(args) => Task::Print(shell::completions(args.shell)),
        Command::Man(args) => Task::Print(shell::man(args.subcommand.as_deref())?),
    })
}

impl LodTask {
    /// Returns the options of [`DisplayFilter::Repair`].
    pub(crate) fn repair(&self) -> RepairOptions {
        RepairOptions::default().with_effort(self.filter_effort)
    }
}

fn lod_task(mut args: LodArgs) -> Result<Task, String> {
    if args.model == ModelKind::ProgressiveMesh {
        // It has no strips: in any other layout, each triangle would be one.
        args.output.layout = args.output.layout.or(Some(Layout::List));
    }
    if let Some(flag) = args.collapse.first_of_chains() {
        return Err(format!("{flag} needs --chain: other levels go down to the base mesh, without limits"));
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
    if let Some(path) = &args.plot {
        check_chart("--plot", path, jobs.len())?;
        check_distinct_files("--plot", path, &jobs)?;
    }
    let task = LodTask {
        jobs,
        options: args.method.validate(false)?,
        budget: args.method.budget(),
        model: args.model,
        base: args.base.or(base).unwrap_or(Ratio::ZERO),
        price: args.collapse.price,
        goal,
        view,
        camera,
        filter,
        filter_effort,
        table: args.table,
        compare: args.compare,
        sweeps: Sweep::ALL.into_iter().filter(|sweep| args.sweep.contains(sweep)).collect(),
        plot: args.plot,
        verify: !args.output.target.no_verify,
    };
    Ok(Task::Lod(task))
}

/// Returns the view of --pixels.
fn view(args: &LodArgs) -> Result<Option<View>, String> {
    let (Some(distance), Some(pixels)) = (args.distance, args.pixels) else { return Ok(None) };
    checked_pixels(pixels)?;
    let view = View::of_camera(distance, args.lens.field_of_view, args.rows);
    view.map(Some).map_err(|error| error.to_string())
}

/// Returns the camera of a view, and what detail it needs.
fn camera(args: &LodArgs) -> Result<Option<(Camera, ViewCriteria)>, String> {
    let (Some(Vector(eye)), Some(Vector(look_at))) = (args.camera, args.look_at) else { return Ok(None) };
    if args.model != ModelKind::Skip {
        return Err(format!("--camera belongs to --model skip, not to {}", args.model));
    }
    let lens = lens(&args.lens);
    let camera = Camera::new(eye, look_at)
        .and_then(|camera| camera.with_up(args.up.0))
        .and_then(|camera| camera.with_field_of_view(lens.field_of_view))
        .and_then(|camera| camera.with_image(lens.image[0], lens.image[1]))
        .map_err(|error| error.to_string())?;
    let criteria = view_criteria(args.pixels.unwrap_or(1.0), args.triangles, &args.criteria)?;
    Ok(Some((camera, criteria)))
}

/// Returns the image of a camera.
fn lens(args: &LensArgs) -> Lens {
    Lens { field_of_view: args.field_of_view, image: args.image.0 }
}

/// Checks an allowed error in pixels.
fn checked_pixels(pixels: f32) -> Result<f32, String> {
    if pixels.is_finite() && pixels >= 0.0 {
        return Ok(pixels);
    }
    Err(format!("--pixels: found {pixels}, expected 0 or more"))
}

/// Returns what detail a view needs, without a limit of steps.
fn view_criteria(pixels: f32, triangles: Option<Count>, args: &CriteriaArgs) -> Result<ViewCriteria, String> {
    let criteria = ViewCriteria::new(checked_pixels(pixels)?).map_err(|error| error.to_string())?;
    let mut criteria = criteria
        .with_frustum(!args.no_frustum)
        .with_back_faces(!args.no_back_faces)
        .with_silhouettes(!args.no_silhouettes);
    if let Some(Count(most)) = triangles {
        criteria = criteria.with_budget(most);
    }
    if let Some(Vector(direction)) = args.light {
        criteria = criteria.with_light(direction).map_err(|error| format!("--{error}"))?;
    }
    if let Some(growth) = args.foveation {
        let foveation =
            Foveation::new(growth).and_then(|foveation| foveation.with_attention(args.attention.0));
        criteria = criteria.with_foveation(foveation.map_err(|error| format!("--foveation: {error}"))?);
    }
    Ok(criteria)
}

/// Returns what selects the level.
fn level_goal(args: &LodArgs, view: Option<View>) -> LevelGoal {
    match (args.pixels.zip(view), args.triangles, args.collapse.error) {
        (Some((pixels, view)), ..) => LevelGoal::Pixels(pixels, view),
        (_, Some(Count(count)), _) if args.camera.is_none() => LevelGoal::Triangles(count),
        (.., Some(error)) => LevelGoal::Error(error),
        _ => LevelGoal::Level(args.level.unwrap_or(Level::Percent(10.0))),
    }
}

fn fly_task(args: FlyArgs) -> Result<Task, String> {
    let input = inputs(vec![args.input], args.from.from)?.pop().ok_or("a file is needed")?;
    if !(1..=MAX_FRAMES).contains(&args.frames) {
        return Err(format!("--frames: found {}, expected 1 to {MAX_FRAMES}", args.frames));
    }
    let lens = lens(&args.lens);
    lens.check().map_err(|error| error.to_string())?;
    let mut criteria = view_criteria(args.pixels, args.triangles, &args.criteria)?;
    if let Some(Count(steps)) = args.steps {
        if steps == 0 {
            return Err("--steps: found 0, expected at least 1: a view would never change".into());
        }
        criteria = criteria.with_steps(steps);
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
    Ok(Task::Fly(FlyTask {
        input,
        options: args.method.validate(false)?,
        budget: args.method.budget(),
        path: camera_path(args.path, args.up)?,
        frame_count: args.frames,
        lens,
        criteria,
        filter: args.filter,
        verify: !args.no_verify,
        report: args.report,
        plot: args.plot,
        video,
    }))
}

/// Returns the path of a camera by its name, or as a file.
fn camera_path(path: PathBuf, up: Option<Axis>) -> Result<CameraPath, String> {
    Ok(match path.to_str() {
        Some("orbit") => CameraPath::Orbit(up.unwrap_or(Axis::Y)),
        Some("dolly") => CameraPath::Dolly(up.unwrap_or(Axis::Y)),
        Some("flyover") => CameraPath::Flyover(up),
        _ if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("json")) => {
            return Err(format!(
                "--path: found {}, expected orbit, dolly, flyover or a .json file of cameras",
                path.display()
            ));
        }
        _ if up.is_some() => {
            return Err("--up cannot be used with a file of cameras: it has their axes".into());
        }
        _ => CameraPath::File(path),
    })
}

fn chain_task(args: LodArgs, ratios: ChainRatios) -> Result<Task, String> {
    let jobs = jobs_of_levels(args.general, &args.output, ratios.as_slice().len())?;
    let draws_lists = args.output.layout == Some(Layout::List);
    let method = if draws_lists { args.method.for_lists() } else { args.method };
    let options = ChainOptions::new(ratios, Format::Glb)
        .with_deviation(args.collapse.error.unwrap_or_default())
        .with_rules(args.collapse.rules())
        .with_stripify(method.validate(false)?)
        .with_verify(!args.output.target.no_verify);
    Ok(Task::Chain(ChainTask { jobs, options, budget: method.budget(), list: args.output.layout.is_none() }))
}

fn build_lod_task(args: BuildLodArgs) -> Result<Task, String> {
    let BuildLodArgs { input, from, order, output, method } = args;
    if output.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("tlod")) {
        return Err(format!("{}: build-lod writes .tlod; use this extension", output.display()));
    }
    let options = method.validate(false)?;
    if options.weld() {
        return Err(
            "--weld does not fit build-lod: the file holds the vertices of the mesh as they are".into()
        );
    }
    let input = inputs(vec![input], from.from)?.into_iter().next().ok_or("an input is needed")?;
    let budget = method.budget();
    Ok(Task::BuildLod(BuildLodTask { input, output, options, budget, order }))
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
    let is_used = filter == DisplayFilter::Repair || args.table || args.compare || args.plot.is_some();
    match args.filter_effort {
        Some(_) if !is_used => Err(format!("--filter-effort belongs to --filter repair, not to {filter}")),
        effort => Ok(effort.unwrap_or_default()),
    }
}

fn analyze_task(args: AnalyzeArgs) -> Result<Task, String> {
    let inputs = inputs_of(args.general)?;
    if let Some(path) = &args.plot {
        check_chart("--plot", path, inputs.len())?;
    }
    let curve = args.plot.as_ref().map(|_| args.vertex_caches.clone().unwrap_or_else(VertexCacheList::curve));
    let flush_policy = if args.flush { FlushPolicy::Flush } else { FlushPolicy::Keep };
    let vertex_caches = args.vertex_caches.unwrap_or_default();
    let options = AnalyzeOptions::default().with_vertex_caches(vertex_caches).with_flush_policy(flush_policy);
    let task = AnalyzeTask { inputs, options, plot: args.plot, curve };
    Ok(Task::Analyze(task))
}

fn pareto_task(path: PathBuf, effort: Option<Effort>, jobs: &[Job]) -> Result<ParetoTask, String> {
    check_chart("--pareto", &path, jobs.len())?;
    check_distinct_files("--pareto", &path, jobs)?;
    Ok(ParetoTask { path, effort })
}

/// Checks that a picture of one input can be written to this file.
fn check_picture(path: &PathBuf, jobs: &[Job]) -> Result<(), String> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png")) {
        return Err(format!("{}: --picture writes PNG; use the extension .png", path.display()));
    }
    if jobs.len() > 1 {
        return Err("--picture takes one input".into());
    }
    check_distinct_files("--picture", path, jobs)
}

/// Checks that a chart and the outputs are different files.
fn check_distinct_files(flag: &str, path: &PathBuf, jobs: &[Job]) -> Result<(), String> {
    if jobs.iter().filter_map(|job| job.output.as_ref()).any(|output| output.path.as_ref() == Some(path)) {
        return Err(format!("{}: -o and {flag} name the same file", path.display()));
    }
    Ok(())
}

/// Checks that a chart of this many inputs can be written to this file.
fn check_chart(flag: &str, path: &Path, input_count: usize) -> Result<(), String> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        return Err(format!("{}: {flag} writes SVG; use the extension .svg", path.display()));
    }
    if input_count > MAX_PLOTTED_INPUTS {
        return Err(format!("{flag} takes at most {MAX_PLOTTED_INPUTS} inputs"));
    }
    Ok(())
}

/// Returns the papers named, or all known papers.
fn select_papers(named: Vec<String>, known: &[&str]) -> Result<BTreeSet<String>, String> {
    if let Some(unknown) = named.iter().find(|name| !known.contains(&name.as_str())) {
        return Err(format!("unknown paper {unknown:?}; known papers: {}", known.join(", ")));
    }
    Ok(if named.is_empty() {
        known.iter().map(ToString::to_string).collect()
    } else {
        named.into_iter().collect()
    })
}

/// Returns the model folder beside the checkout if it exists, else the project's own, relative to the checkout.
fn default_models() -> PathBuf {
    let shared = PathBuf::from("../shared/models");
    if shared.is_dir() { shared } else { "testdata/models".into() }
}

fn shared(args: &SharedArgs) -> Shared {
    Shared { json: args.json, quiet: args.quiet, threads: args.threads.map(usize::from) }
}
