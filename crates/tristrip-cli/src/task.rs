//! What was asked for: the one place where flags become a task that makes sense, or a message that says which of them do not fit.

use std::collections::{BTreeSet, HashMap};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Duration;

use tristrip::lod::filter::repair;
use tristrip::strip::Between;
use tristrip::stripify::Effort;
use tristrip::{Layout, Options};
use tristrip_io::Format;

use crate::analyze::BufferList;
use crate::args::{
    AnalyzeArgs, Command, InputArgs, LayoutName, LodArgs, OutputArgs, ReadFormat, SharedArgs, WriteFormat,
};
use crate::lod::{FilterName, Level, ModelName};
use crate::repro;
use crate::simplify::{Amount, Goal, Ratio};

/// Inputs whose curves can be told apart in one picture.
const PLOTTED_INPUTS: usize = 3;

/// What was asked for, with flags that fit each other.
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
    Repro(ReproTask),
}

#[derive(Debug)]
pub(crate) struct StripTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: Options,
    pub(crate) budget: Option<Duration>,
    /// Whether vertices are written in the order of their first use.
    pub(crate) reorder: bool,
    pub(crate) verify: bool,
    pub(crate) pareto: Option<ParetoTask>,
}

/// A picture of all methods.
#[derive(Debug)]
pub(crate) struct ParetoTask {
    /// The SVG file to write.
    pub(crate) path: PathBuf,
    /// The effort of all searches, where it was asked for.
    pub(crate) effort: Option<Effort>,
}

#[derive(Debug)]
pub(crate) struct CompareTask {
    pub(crate) inputs: Vec<Input>,
    pub(crate) every_variant: bool,
    pub(crate) markdown: bool,
    pub(crate) options: Options,
    /// The effort of the methods that search, but for `auto`, which has its own.
    pub(crate) effort: Effort,
    pub(crate) budget: Option<Duration>,
}

#[derive(Debug)]
pub(crate) struct BoundTask {
    pub(crate) inputs: Vec<Input>,
    pub(crate) options: Options,
}

#[derive(Debug)]
pub(crate) struct AnalyzeTask {
    pub(crate) inputs: Vec<Input>,
    pub(crate) buffers: BufferList,
    pub(crate) between: Between,
    /// The SVG file to write.
    pub(crate) plot: Option<PathBuf>,
    /// The buffers that its curves go through.
    pub(crate) curve: Option<BufferList>,
}

#[derive(Debug)]
pub(crate) struct VerifyTask {
    pub(crate) source: Input,
    pub(crate) result: Input,
}

#[derive(Debug)]
pub(crate) struct ConvertTask {
    pub(crate) jobs: Vec<Job>,
    /// Whether all faces are written as strips of their own order, not only those that the input has as strips.
    pub(crate) as_strips: bool,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct SimplifyTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) goal: Goal,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct LodTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: Options,
    pub(crate) budget: Option<Duration>,
    pub(crate) model: ModelName,
    /// The share of the triangles that the base mesh keeps.
    pub(crate) base: Ratio,
    pub(crate) level: Level,
    pub(crate) filter: FilterName,
    /// Of the filter that searches.
    pub(crate) filter_effort: Effort,
    pub(crate) table: bool,
    pub(crate) compare: bool,
    /// The SVG file to write.
    pub(crate) plot: Option<PathBuf>,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct ReproTask {
    /// Keys of papers.
    pub(crate) papers: BTreeSet<String>,
    pub(crate) models: PathBuf,
    pub(crate) output: PathBuf,
}

/// An input, and where its result goes.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) input: Input,
    pub(crate) output: Option<Output>,
}

/// Where a mesh comes from.
#[derive(Debug)]
pub(crate) struct Input {
    /// `None` for standard input.
    pub(crate) path: Option<PathBuf>,
    pub(crate) format: Option<Format>,
}

/// Where a result goes, and how.
#[derive(Debug)]
pub(crate) struct Output {
    /// `None` for standard output.
    pub(crate) path: Option<PathBuf>,
    /// Whether the file lies in an output directory, which is made where it is missing.
    pub(crate) in_directory: bool,
    pub(crate) format: Format,
    pub(crate) layout: Layout,
}

/// What all tasks have in common.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) json: bool,
    pub(crate) quiet: bool,
    pub(crate) threads: Option<usize>,
}

impl Task {
    /// Tells whether a mesh is written to standard output.
    pub(crate) fn output_is_stdout(&self) -> bool {
        let (Self::Strip(StripTask { jobs, .. })
        | Self::Convert(ConvertTask { jobs, .. })
        | Self::Simplify(SimplifyTask { jobs, .. })
        | Self::Lod(LodTask { jobs, .. })) = self
        else {
            return false;
        };
        jobs.iter().any(|job| job.output.as_ref().is_some_and(|output| output.path.is_none()))
    }
}

impl Input {
    /// Gives the name that messages and reports use.
    pub(crate) fn name(&self) -> String {
        self.path.as_ref().map_or_else(|| "-".into(), |path| path.display().to_string())
    }
}

impl Output {
    /// Gives the name that messages and reports use.
    pub(crate) fn name(&self) -> String {
        self.path.as_ref().map_or_else(|| "-".into(), |path| path.display().to_string())
    }
}

/// Makes a task of the flags, or says which of them do not fit.
pub(crate) fn validate(command: Command) -> Result<(Task, Shared), String> {
    Ok(match command {
        Command::Strip(args) => {
            let jobs = jobs(inputs(args.inputs)?, &args.output)?;
            let options = args.method.validate(args.pareto.is_some())?;
            let pareto =
                args.pareto.map(|path| pareto_task(path, args.method.effort(), &jobs)).transpose()?;
            let shared = shared(&args.shared, args.threads.threads);
            refuse_two_results(&jobs, &shared)?;
            let budget = args.method.budget();
            let (reorder, verify) = (args.reorder_vertices, !args.no_verify);
            (Task::Strip(StripTask { jobs, options, budget, reorder, verify, pareto }), shared)
        }
        Command::Compare(args) => {
            let options =
                Options::default().with_seed(args.seed).with_weld(args.weld).with_cost(args.cost.into());
            let inputs = inputs(args.inputs)?;
            let (every_variant, markdown, budget) = (args.all, args.markdown, args.budget);
            let effort = Effort::new(args.effort).unwrap_or_default();
            let task = CompareTask { inputs, every_variant, markdown, options, effort, budget };
            (Task::Compare(task), shared(&args.shared, args.threads.threads))
        }
        Command::Bound(args) => {
            let options = Options::default().with_weld(args.weld);
            let task = BoundTask { inputs: inputs(args.inputs)?, options };
            (Task::Bound(task), shared(&args.shared, args.threads.threads))
        }
        Command::Analyze(args) => {
            let shared = shared(&args.shared, args.threads.threads);
            (Task::Analyze(analyze_task(args)?), shared)
        }
        Command::Verify(args) => {
            let both = InputArgs { inputs: vec![args.source, args.result], from: args.from };
            let mut both = inputs(both)?.into_iter();
            let (Some(source), Some(result)) = (both.next(), both.next()) else {
                return Err("two files are needed".into());
            };
            (Task::Verify(VerifyTask { source, result }), shared(&args.shared, Some(1)))
        }
        Command::Convert(args) => {
            if args.output.target.output.is_none() {
                return Err("-o is needed: where should the result go?".into());
            }
            let as_strips = args.output.layout.is_some();
            let jobs = jobs(inputs(args.inputs)?, &args.output)?;
            let shared = shared(&args.shared, args.threads.threads);
            refuse_two_results(&jobs, &shared)?;
            (Task::Convert(ConvertTask { jobs, as_strips, verify: !args.no_verify }), shared)
        }
        Command::Simplify(args) => {
            let amount = args.ratio.map(Amount::Ratio).or(args.triangles.map(Amount::Triangles));
            let goal = Goal { amount, deviation: args.error };
            if goal.amount.is_none() && goal.deviation.is_none() {
                return Err("how far? --ratio, --triangles or --error is needed".into());
            }
            let output = OutputArgs { target: args.target, layout: Some(LayoutName::List) };
            let jobs = jobs(inputs(args.inputs)?, &output)?;
            let shared = shared(&args.shared, args.threads.threads);
            refuse_two_results(&jobs, &shared)?;
            (Task::Simplify(SimplifyTask { jobs, goal, verify: !args.no_verify }), shared)
        }
        Command::Lod(args) => {
            let filter_effort = filter_effort(&args)?;
            let jobs = jobs(inputs(args.inputs)?, &args.output)?;
            let shared = shared(&args.shared, args.threads.threads);
            refuse_two_results(&jobs, &shared)?;
            if let Some(path) = &args.plot {
                check_picture("--plot", path, jobs.len())?;
                check_other_file("--plot", path, &jobs)?;
            }
            let task = LodTask {
                jobs,
                options: args.method.validate(false)?,
                budget: args.method.budget(),
                model: args.model,
                base: args.base,
                level: args.level,
                filter: args.filter,
                filter_effort,
                table: args.table,
                compare: args.compare,
                plot: args.plot,
                verify: !args.no_verify,
            };
            (Task::Lod(task), shared)
        }
        Command::Repro(args) => {
            let papers = papers(args.papers)?;
            let models = args.models.unwrap_or_else(default_models);
            let task = ReproTask { papers, models, output: args.output };
            (Task::Repro(task), shared(&args.shared, args.threads.threads))
        }
    })
}

impl LodTask {
    /// Gives the options of the filter that searches.
    pub(crate) fn repair(&self) -> repair::Options {
        repair::Options::default().with_effort(self.filter_effort)
    }
}

/// Takes the effort of the filter that searches.
fn filter_effort(args: &LodArgs) -> Result<Effort, String> {
    let is_used = args.filter == FilterName::Repair || args.table || args.compare || args.plot.is_some();
    match args.filter_effort {
        Some(_) if !is_used => {
            Err(format!("--filter-effort belongs to --filter repair, not to {}", args.filter.name()))
        }
        effort => Ok(effort.and_then(Effort::new).unwrap_or_default()),
    }
}

fn analyze_task(args: AnalyzeArgs) -> Result<AnalyzeTask, String> {
    let inputs = inputs(args.inputs)?;
    if let Some(path) = &args.plot {
        check_picture("--plot", path, inputs.len())?;
    }
    let curve = args.plot.as_ref().map(|_| args.buffers.clone().unwrap_or_else(BufferList::curve));
    let between = if args.flush { Between::Flush } else { Between::Keep };
    Ok(AnalyzeTask { inputs, buffers: args.buffers.unwrap_or_default(), between, plot: args.plot, curve })
}

fn pareto_task(path: PathBuf, effort: Option<Effort>, jobs: &[Job]) -> Result<ParetoTask, String> {
    check_picture("--pareto", &path, jobs.len())?;
    check_other_file("--pareto", &path, jobs)?;
    Ok(ParetoTask { path, effort })
}

/// Tells whether a picture goes into a file of its own.
fn check_other_file(flag: &str, path: &PathBuf, jobs: &[Job]) -> Result<(), String> {
    if jobs.iter().filter_map(|job| job.output.as_ref()).any(|output| output.path.as_ref() == Some(path)) {
        return Err(format!("{}: -o and {flag} name the same file", path.display()));
    }
    Ok(())
}

/// Tells whether a picture of inputs can be drawn into a file of this name.
fn check_picture(flag: &str, path: &Path, input_count: usize) -> Result<(), String> {
    if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
        return Err(format!("{}: {flag} writes SVG; name a file .svg", path.display()));
    }
    if input_count > PLOTTED_INPUTS {
        return Err(format!("{flag} takes at most {PLOTTED_INPUTS} inputs, or nobody can tell them apart"));
    }
    Ok(())
}

fn shared(args: &SharedArgs, threads: Option<u16>) -> Shared {
    Shared { json: args.json, quiet: args.quiet, threads: threads.map(usize::from) }
}

/// Takes the papers that were named, or all.
fn papers(named: Vec<String>) -> Result<BTreeSet<String>, String> {
    let known = || repro::keys().map(String::from);
    if let Some(unknown) = named.iter().find(|name| !known().any(|key| key == **name)) {
        return Err(format!("no paper {unknown:?}; there are {}", known().collect::<Vec<_>>().join(", ")));
    }
    Ok(if named.is_empty() { known().collect() } else { named.into_iter().collect() })
}

/// Gives the folder of models beside the checkout, else the project's own, for one who stands in the checkout.
fn default_models() -> PathBuf {
    let shared = PathBuf::from("../shared/models");
    if shared.is_dir() { shared } else { "testdata/models".into() }
}

fn inputs(args: InputArgs) -> Result<Vec<Input>, String> {
    if args.inputs.iter().filter(|path| is_dash(path)).count() > 1 {
        return Err("standard input (-) can be read only once".into());
    }
    let format = args.from.map(ReadFormat::format);
    let input = |path: PathBuf| Input { path: (!is_dash(&path)).then_some(path), format };
    Ok(args.inputs.into_iter().map(input).collect())
}

fn refuse_two_results(jobs: &[Job], shared: &Shared) -> Result<(), String> {
    let to_stdout = jobs.iter().any(|job| job.output.as_ref().is_some_and(|output| output.path.is_none()));
    if to_stdout && shared.json {
        return Err("-o - and --json both write to standard output".into());
    }
    Ok(())
}

fn is_dash(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Gives each input its output.
fn jobs(inputs: Vec<Input>, args: &OutputArgs) -> Result<Vec<Job>, String> {
    let Some(target) = &args.target.output else {
        return Ok(inputs.into_iter().map(|input| Job { input, output: None }).collect());
    };
    if is_dash(target) {
        return jobs_to_stdout(inputs, args);
    }
    let slash =
        target.as_os_str().as_encoded_bytes().last().is_some_and(|&b| std::path::is_separator(b.into()));
    if inputs.len() > 1 || slash || target.is_dir() {
        return jobs_to_directory(inputs, target, args);
    }
    let format = match (args.target.to, Format::from_path(target)) {
        (Some(to), _) => to.format(),
        (None, Some(format @ (Format::Glb | Format::Ply | Format::Obj))) => format,
        (None, Some(format)) => {
            let hint =
                if format == Format::Gltf { "glTF is written as .glb" } else { ".glb, .ply and .obj are" };
            return Err(format!("{}: {} is not written; {hint}", target.display(), format.name()));
        }
        (None, None) => {
            let target = target.display();
            return Err(format!("{target}: the extension names no format; use .glb, .ply or .obj, or --to"));
        }
    };
    let layout = layout(args, format)?;
    let output = |_: &Input| Output { path: Some(target.clone()), in_directory: false, format, layout };
    Ok(inputs.into_iter().map(|input| Job { output: Some(output(&input)), input }).collect())
}

fn jobs_to_stdout(inputs: Vec<Input>, args: &OutputArgs) -> Result<Vec<Job>, String> {
    let Some(to) = args.target.to else {
        return Err("-o - needs --to: which format should be written?".into());
    };
    let format = to.format();
    if inputs.len() > 1 {
        return Err("-o - takes one input; give a directory for many".into());
    }
    if format != Format::Obj && std::io::stdout().is_terminal() {
        return Err(format!("standard output is a terminal, and {} is binary; redirect it", format.name()));
    }
    let layout = layout(args, format)?;
    let output = || Some(Output { path: None, in_directory: false, format, layout });
    Ok(inputs.into_iter().map(|input| Job { input, output: output() }).collect())
}

fn jobs_to_directory(inputs: Vec<Input>, directory: &Path, args: &OutputArgs) -> Result<Vec<Job>, String> {
    let format = args.target.to.unwrap_or(WriteFormat::Glb).format();
    let layout = layout(args, format)?;
    // Without a slash at its end, which would make a file look like nothing at all.
    let directory: &Path = &directory.components().collect::<PathBuf>();
    if directory.exists() && !directory.is_dir() {
        return Err(format!("{}: many inputs need a directory, and this is a file", directory.display()));
    }
    if !directory.exists() && Format::from_path(directory).is_some() {
        return Err(format!("{}: many inputs need a directory, and this names a file", directory.display()));
    }
    let mut first: HashMap<PathBuf, String> = HashMap::new();
    let mut jobs = Vec::with_capacity(inputs.len());
    for input in inputs {
        let stem = input.path.as_ref().and_then(|path| path.file_stem()).unwrap_or("stdin".as_ref());
        let mut file = stem.to_owned();
        file.push(".");
        file.push(format.extension());
        let path = directory.join(file);
        let same =
            |a: &Path, b: &Path| matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b);
        if input.path.as_ref().is_some_and(|from| same(from, &path)) {
            return Err(format!(
                "{}: the output would replace the input; choose another directory",
                path.display()
            ));
        }
        if let Some(other) = first.insert(path.clone(), input.name()) {
            return Err(format!(
                "{}: both {other} and {} would be written here",
                path.display(),
                input.name()
            ));
        }
        jobs.push(Job {
            input,
            output: Some(Output { path: Some(path), in_directory: true, format, layout }),
        });
    }
    Ok(jobs)
}

/// Gives the layout that was asked for, or the format's usual one.
fn layout(args: &OutputArgs, format: Format) -> Result<Layout, String> {
    let asked = args.layout.map(LayoutName::layout);
    match (format, asked) {
        (Format::Obj, None | Some(Layout::List)) => Ok(Layout::List),
        (Format::Obj, Some(_)) => Err("OBJ has no strips, only --layout list; write .glb or .ply".into()),
        (_, Some(layout)) => Ok(layout),
        (Format::Ply, None) => Ok(Layout::Restart),
        (_, None) => Ok(Layout::Degenerate),
    }
}

/// Gives the name of a layout as it is typed.
pub(crate) fn layout_name(layout: Layout) -> &'static str {
    match layout {
        Layout::Restart => "restart",
        Layout::Degenerate => "degenerate",
        Layout::Separate => "separate",
        Layout::List => "list",
    }
}
