//! Validated tasks. Only this module checks combinations of flags; it builds a task from a valid
//! combination, and rejects other combinations with a message.

mod checks;
mod levels;
#[cfg(feature = "serve")]
mod servers;
mod streams;
mod views;

use std::ffi::OsString;
use std::path::PathBuf;
use std::time::Duration;

use tristrip::Effort;
use tristrip::vertex_cache::FlushPolicy;
use tristrip::{Layout, StripifyOptions};
use tristrip_io::gltf::Rounding;
use tristrip_pipeline::analyze::{self, VertexCacheList};
use tristrip_pipeline::{Amount, Goal, simplify};

use crate::args::{self, AnalyzeArgs, Command, HelpArgs, OutputArgs, SharedArgs};
use crate::job::{Input, Job, inputs, inputs_of, jobs_of, write_to_stdout};
use crate::shell;
use crate::topics::{Topic, topic_names};
use checks::{check_chart, check_picture};
pub(crate) use levels::{BuildLodTask, ChainTask, LevelTask};
use levels::{build_lod_task, camera_level_task, chain_task, level_task};
#[cfg(feature = "serve")]
pub(crate) use servers::{ServeTask, ViewTask};
#[cfg(feature = "serve")]
use servers::{serve_task, view_task};
pub(crate) use streams::{InspectTask, PackTask, UnpackTask};
use streams::{inspect_task, pack_task, unpack_task};

/// A subcommand with a valid combination of options.
#[derive(Debug)]
pub(crate) enum Task {
    Strip(StripTask),
    Compare(CompareTask),
    Bound(BoundTask),
    Analyze(AnalyzeTask),
    Verify(VerifyTask),
    Convert(ConvertTask),
    Simplify(SimplifyTask),
    Level(LevelTask),
    Chain(ChainTask),
    BuildLod(BuildLodTask),
    Pack(PackTask),
    Unpack(UnpackTask),
    Inspect(InspectTask),
    #[cfg(feature = "serve")]
    Serve(Box<ServeTask>),
    #[cfg(feature = "serve")]
    View(Box<ViewTask>),
    /// Text to print: completions, a man page or a topic.
    Print(Vec<u8>),
}

#[derive(Debug)]
pub(crate) struct StripTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: StripifyOptions,
    pub(crate) budget: Option<Duration>,
    /// Whether a part may be written as a list. False if the user chose a layout.
    pub(crate) list: bool,
    /// Whether to reorder the vertices by first use.
    pub(crate) reorder: bool,
    pub(crate) verify: bool,
    /// The PNG file that shows the strips.
    pub(crate) picture: Option<PathBuf>,
}

#[derive(Debug)]
pub(crate) struct CompareTask {
    pub(crate) inputs: Vec<Input>,
    pub(crate) every_variant: bool,
    pub(crate) markdown: bool,
    pub(crate) options: StripifyOptions,
    /// The effort of the methods that search, instead of their default efforts. `best` runs at its
    /// default effort, too.
    pub(crate) effort: Option<Effort>,
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
    pub(crate) options: analyze::Options,
    /// The SVG file to write.
    pub(crate) plot: Option<PathBuf>,
    /// The vertex caches of the curves in this file.
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
    /// Whether to write all faces as strips in stored order. Otherwise only the strips of the input
    /// are written as strips.
    pub(crate) as_strips: bool,
    pub(crate) verify: bool,
}

#[derive(Debug)]
pub(crate) struct SimplifyTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: simplify::Options,
    /// The PNG file that shows the model before and after.
    pub(crate) picture: Option<PathBuf>,
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
            | Self::Level(LevelTask { jobs, .. })
            | Self::Chain(ChainTask { jobs, .. })
            | Self::Pack(PackTask { jobs, .. }) => write_to_stdout(jobs),
            Self::Unpack(UnpackTask { job, .. }) => write_to_stdout(std::slice::from_ref(job)),
            Self::Compare(_)
            | Self::Bound(_)
            | Self::Analyze(_)
            | Self::Verify(_)
            | Self::BuildLod(_)
            | Self::Inspect(_)
            | Self::Print(_) => false,
            #[cfg(feature = "serve")]
            Self::Serve(_) | Self::View(_) => false,
        }
    }
}

impl Task {
    /// Checks the shared options against the task and returns the task. Shared options can precede
    /// the subcommand, where clap does not check them against its flags.
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

/// Parses the command line into a task.
///
/// # Errors
/// The usage is wrong, or help or the version was requested.
pub(crate) fn parse(arguments: Vec<OsString>) -> Result<(Task, Shared), clap::Error> {
    let parsed = args::parse(arguments)?;
    let shared = shared(&parsed.shared);
    let task = validate(parsed.command).and_then(|task| task.fitting(&shared));
    let task = task.map_err(|message| args::usage_error(parsed.subcommand, &message))?;
    Ok((task, shared))
}

/// Builds a task from flags.
///
/// # Errors
/// The combination of flags is not valid; the message names the flags.
fn validate(command: Command) -> Result<Task, String> {
    Ok(match command {
        Command::Strip(args) => {
            let jobs = jobs_of(args.general, &args.output)?;
            let options = args.method.validate()?;
            let budget = args.method.budget();
            let (list, reorder) = (args.output.layout.is_none(), args.reorder_vertices);
            let verify = !args.output.target.no_verify;
            let picture = args.picture;
            if let Some(path) = &picture {
                check_picture(path, &jobs)?;
            }
            Task::Strip(StripTask { jobs, options, budget, list, reorder, verify, picture })
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
            let [source, result]: [Input; 2] = both.try_into().map_err(|_| "expected two files")?;
            Task::Verify(VerifyTask { source, result })
        }
        Command::Convert(args) => {
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
            let mut options = simplify::Options::default().with_goal(goal).with_rules(args.collapse.rules());
            options = options.with_normals(args.normals).with_fit(args.fit).with_verify(verify);
            if args.compact {
                options = options.with_rounding(Rounding::WeightsAndRotations);
            }
            Task::Simplify(SimplifyTask { jobs, options, picture: args.picture })
        }
        Command::Chain(args) => Task::Chain(chain_task(*args)?),
        Command::Level(args) => Task::Level(level_task(*args)?),
        Command::CameraLevel(args) => Task::Level(camera_level_task(*args)?),
        Command::BuildLod(args) => Task::BuildLod(build_lod_task(*args)?),
        Command::Pack(args) => Task::Pack(pack_task(args)?),
        Command::Unpack(args) => Task::Unpack(unpack_task(args)?),
        Command::Inspect(args) => Task::Inspect(inspect_task(args)?),
        #[cfg(feature = "serve")]
        Command::Serve(args) => Task::Serve(Box::new(serve_task(*args)?)),
        #[cfg(feature = "serve")]
        Command::View(args) => Task::View(Box::new(view_task(args)?)),
        #[cfg(not(feature = "serve"))]
        Command::Serve | Command::View => return Err(args::NO_SERVER.into()),
        Command::Completions(args) => Task::Print(shell::completions(args.shell)),
        Command::Man(args) => Task::Print(shell::man(args.subcommand.as_deref())?),
        Command::Help(HelpArgs { name }) => {
            let name = name.unwrap_or_default();
            let unknown = || format!("found topic `{name}`, expected one of: {}", topic_names());
            let topic = Topic::find(&name).ok_or_else(unknown)?;
            Task::Print(topic.text().into_bytes())
        }
    })
}

fn analyze_task(args: AnalyzeArgs) -> Result<Task, String> {
    let inputs = inputs_of(args.general)?;
    if let Some(path) = &args.plot {
        check_chart("--plot", path, inputs.len())?;
    }
    let curve = args.plot.as_ref().map(|_| args.vertex_caches.clone().unwrap_or_else(VertexCacheList::curve));
    let flush_policy = if args.flush { FlushPolicy::Flush } else { FlushPolicy::Keep };
    let vertex_caches = args.vertex_caches.unwrap_or_default();
    let options =
        analyze::Options::default().with_vertex_caches(vertex_caches).with_flush_policy(flush_policy);
    let task = AnalyzeTask { inputs, options, plot: args.plot, curve };
    Ok(Task::Analyze(task))
}

fn shared(args: &SharedArgs) -> Shared {
    Shared { json: args.json, quiet: args.quiet, threads: args.threads.map(usize::from) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// clap rejects unknown topics first. This message is for a name that only clap knows.
    #[test]
    fn an_unknown_topic_is_named_with_the_topics() {
        let message = validate(Command::Help(HelpArgs { name: Some("paint".into()) })).unwrap_err();
        assert_eq!(
            message,
            "found topic `paint`, expected one of: methods, levels, simplification, files, server"
        );
    }
}
