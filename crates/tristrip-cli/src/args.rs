//! Command-line flags with their short and long help. The module `task` checks combinations of
//! flags.

mod detail;
mod groups;
#[cfg(feature = "serve")]
mod serve;
mod stream;
mod view;

use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use clap::builder::styling::{AnsiColor, Styles};
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::error::ErrorKind;
use clap::{Arg, ArgAction, Args, CommandFactory, Error, FromArgMatches, Parser, Subcommand};
use clap_complete::Shell;
use tristrip::Cost;
use tristrip::Effort;
use tristrip_pipeline::analyze::VertexCacheList;

use crate::method::{MethodArgs, WeldArgs};
use crate::topics::{TOPICS, Topic};
use crate::values::{effort_parser, named};
pub(crate) use detail::{BuildLodArgs, CameraLevelArgs, ChainArgs, LevelArgs, SimplifyArgs};
pub(crate) use groups::{FromArgs, GeneralArgs, OutputArgs, SharedArgs, TargetArgs};
#[cfg(feature = "serve")]
pub(crate) use serve::{LogFormat, ServeArgs, ViewArgs};
pub(crate) use stream::{InspectArgs, PackArgs, UnpackArgs};
pub(crate) use view::CriteriaArgs;

/// The colours of help and errors on a terminal; `NO_COLOR=1` disables them.
const STYLES: Styles = Styles::styled()
    .header(AnsiColor::Green.on_default().bold())
    .usage(AnsiColor::Green.on_default().bold())
    .literal(AnsiColor::Cyan.on_default().bold())
    .placeholder(AnsiColor::Cyan.on_default())
    .error(AnsiColor::Red.on_default().bold())
    .valid(AnsiColor::Green.on_default())
    .invalid(AnsiColor::Yellow.on_default());

/// Stripify, simplify and stream polygon meshes
///
/// Read OBJ, PLY, OFF, STL, glTF and GLB; write GLB, glTF, PLY and OBJ. Every output is verified
/// before it is written. Strips draw each input face exactly once, with its original winding.
#[derive(Debug, Parser)]
#[command(name = "tristrip", bin_name = "tristrip", version, propagate_version = true, max_term_width = 100, styles = STYLES)]
#[command(
    disable_help_subcommand = true,
    arg_required_else_help = true,
    help_template = "{about-with-newline}\n{usage-heading} {usage}{after-help}\n{options}"
)]
struct Cli {
    #[command(flatten)]
    shared: SharedArgs,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Strip(StripArgs),
    Compare(CompareArgs),
    Bound(BoundArgs),
    Analyze(AnalyzeArgs),
    Verify(VerifyArgs),
    Convert(ConvertArgs),
    Simplify(SimplifyArgs),
    Chain(Box<ChainArgs>),
    Level(Box<LevelArgs>),
    CameraLevel(Box<CameraLevelArgs>),
    BuildLod(Box<BuildLodArgs>),
    Pack(PackArgs),
    Unpack(UnpackArgs),
    Inspect(InspectArgs),
    #[cfg(feature = "serve")]
    Serve(Box<ServeArgs>),
    #[cfg(feature = "serve")]
    View(ViewArgs),
    /// Serve the models of a directory over HTTP (not in this build)
    #[cfg(not(feature = "serve"))]
    #[command(after_help = NO_SERVER, arg = any_arguments())]
    Serve,
    /// View models in the browser (not in this build)
    #[cfg(not(feature = "serve"))]
    #[command(after_help = NO_SERVER, arg = any_arguments())]
    View,
    Completions(CompletionsArgs),
    Man(ManArgs),
    Help(HelpArgs),
}

/// Subcommands grouped by task, in the order of the help.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Shrink files", &["strip", "simplify", "convert"]),
    ("Levels of detail", &["chain", "level", "camera-level", "build-lod"]),
    ("Stream and view", &["pack", "unpack", "serve", "view"]),
    ("Inspect and verify", &["analyze", "compare", "bound", "inspect", "verify"]),
];

/// Subcommands that print text about the command itself.
const TEXTS: [&str; 3] = ["help", "completions", "man"];

/// Error and help text of `serve` and `view` in a build without the web server.
#[cfg(not(feature = "serve"))]
pub(crate) const NO_SERVER: &str = "this build does not include the web server; to install it, run in a clone of the repository: \
     `cargo install --path crates/tristrip-cli --features serve --profile dist`";

/// Accepts and ignores all arguments, as the web server's subcommands would accept them.
#[cfg(not(feature = "serve"))]
fn any_arguments() -> Arg {
    Arg::new("arguments").num_args(0..).hide(true).allow_hyphen_values(true).trailing_var_arg(true)
}

/// Build triangle strips, verify them and write them
///
/// Without -o, print a report and write no file. The report goes to standard output, or to standard
/// error with `-o -`. Stages and progress go to standard error.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip strip bunny.ply -o bunny.glb             strips, which most glTF viewers draw
  tristrip strip scene.glb -o out.glb --layout restart
  tristrip strip models/*.obj -o stripped/ --to ply
  tristrip strip bunny.ply --method best:effort=7 -o bunny.glb
  tristrip strip horse.ply --method fewest --budget 5s
  tristrip strip bunny.ply --method stripe --json   without a file: only the report
  tristrip strip bunny.ply --picture strips.png     an image with one colour per strip
  cat bunny.ply | tristrip strip - -o - --to glb > bunny.glb")]
pub(crate) struct StripArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    /// Reorder the vertices by first use in the strips
    ///
    /// The vertex buffer is then read sequentially, and unused vertices come last. Parts of a scene
    /// that share vertices share one order. If other data in the file may refer to vertices by
    /// index, their order is kept and a note reports it. With --json, the report lists the old
    /// index of each vertex.
    #[arg(long, requires = "output", help_heading = "Output")]
    pub(crate) reorder_vertices: bool,
    /// Draw the strips to a PNG file, one colour per strip
    ///
    /// The image is 1200 x 900 pixels and shows the model from the front, with the y axis up.
    /// Adjacent strips have different colours. Node transformations are ignored. This option takes
    /// one input.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) picture: Option<PathBuf>,
}

/// Compare stripification methods
///
/// Print one table per model. Every result is verified. The best value in each column is marked.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip compare bunny.ply cow.obj
  tristrip compare bunny.ply --all --markdown > bunny.md")]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Also run tunnel, eta, guided-tunnels, and all variants of sgi, stripe-local and
    /// stripe-global
    #[arg(long)]
    pub(crate) all: bool,
    /// Set the search effort of best, fewest and cache, from 0 to 9 [default: 2; for fewest 5]
    #[arg(long, value_name = "LEVEL", value_parser = effort_parser())]
    pub(crate) effort: Option<Effort>,
    /// Set the cost that the method best minimizes
    #[arg(long, value_parser = named(Cost::ALL, Cost::name, Cost::summary), value_name = "COST", default_value_t = Cost::Restart)]
    pub(crate) cost: Cost,
    /// Stop each search after this time, such as 5s or 500ms, and keep its best result
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    pub(crate) budget: Option<Duration>,
    /// Print Markdown tables
    #[arg(long)]
    pub(crate) markdown: bool,
    /// Set the random seed for methods that break ties at random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) weld: WeldArgs,
}

/// Compute lower bounds on strips, vertices and indices
///
/// No strips on the dual graph can be below these bounds. The report names the method that found
/// each bound. If more than two faces share an edge, the dual graph joins them in pairs, and strips
/// cross the edge only within a pair. For a mesh with polygons, the bounds hold for every
/// triangulation. They are tighter for a mesh of triangles.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:
  tristrip bound bunny.ply")]
pub(crate) struct BoundArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    #[command(flatten)]
    pub(crate) weld: WeldArgs,
}

/// Report index and vertex-cache statistics of a file
///
/// Count triangles, strips, indices, restarts and degenerate triangles as stored in the file, and
/// simulate vertex caches. No strips are built; polygons count as triangle fans. A cache miss is a
/// vertex that must be transformed. ACMR is the number of misses per triangle. ATVR is the number
/// of misses per used vertex. Each part of a file (a material in OBJ, a primitive in glTF) starts
/// with an empty cache.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip analyze bunny.ply bunny.glb              before and after
  tristrip analyze bunny.glb --vertex-caches fifo:8..32,lru:16 --flush
  tristrip analyze bunny.ply bunny.glb --plot caches.svg")]
pub(crate) struct AnalyzeArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Simulate these vertex caches [default: fifo and lru with 8, 16, 24, 32 and 64 entries]
    ///
    /// LIST contains KIND:N or KIND:N..M, separated by commas. KIND is fifo (evicts the oldest
    /// entry) or lru (evicts the least recently used entry). N and M are numbers of entries.
    #[arg(long, value_name = "LIST")]
    pub(crate) vertex_caches: Option<VertexCacheList>,
    /// Flush the vertex cache between strips, as if each strip had its own draw call
    #[arg(long)]
    pub(crate) flush: bool,
    /// Write an SVG plot of misses by cache size, and a histogram of strip lengths
    ///
    /// The curves show the caches given by --vertex-caches, by default caches of 2 to 64 entries.
    /// This option takes up to three inputs.
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
}

/// Verify that one file draws exactly the faces of another
///
/// The files can come from any program and can have different formats. Triangle lists, strips,
/// fans, degenerate triangles and restarts are supported. Strips can also be stored as separate
/// primitives. Vertices are compared by the exact bits of their positions, so their order may
/// differ. Other attributes are not compared. Scenes are compared mesh by mesh, without node
/// transformations.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:
  tristrip verify bunny.ply bunny.glb")]
pub(crate) struct VerifyArgs {
    /// The file with the expected faces, or - for standard input
    pub(crate) source: PathBuf,
    /// The file to verify, or - for standard input
    pub(crate) result: PathBuf,
    #[command(flatten)]
    pub(crate) from: FromArgs,
}

/// Convert between formats or strip layouts, without building new strips
///
/// Without --layout, faces are written unchanged: polygons stay polygons if the format supports
/// them, and strips stay strips. With --layout, all faces are written as strips, in their stored
/// order.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip convert in.obj -o out.ply
  tristrip convert strips.ply -o strips.glb --layout restart")]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
}

/// Print shell completions
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip completions bash > ~/.local/share/bash-completion/completions/tristrip
  tristrip completions zsh > ~/.zfunc/_tristrip
  tristrip completions fish > ~/.config/fish/completions/tristrip.fish")]
pub(crate) struct CompletionsArgs {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub(crate) shell: Shell,
}

/// Explain a subcommand or a topic
///
/// `tristrip COMMAND -h` lists the options of a subcommand. `tristrip help COMMAND` explains them.
#[derive(Debug, Args)]
#[command(after_long_help = topics())]
pub(crate) struct HelpArgs {
    /// The subcommand or topic
    #[arg(value_name = "NAME", value_parser = help_parser(), hide_possible_values = true)]
    pub(crate) name: Option<String>,
}

/// Print the man page of the command or of a subcommand
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip man > ~/.local/share/man/man1/tristrip.1
  tristrip man strip | man -l -")]
pub(crate) struct ManArgs {
    /// The subcommand [default: the command]
    #[arg(value_name = "SUBCOMMAND")]
    pub(crate) subcommand: Option<String>,
}

/// A command line that clap accepted.
#[derive(Debug)]
pub(crate) struct ParsedCommand {
    pub(crate) command: Command,
    pub(crate) shared: SharedArgs,
    pub(crate) subcommand: &'static str,
}

/// Parses the command line.
///
/// # Errors
/// The usage is wrong, or help or the version was requested.
pub(crate) fn parse(arguments: Vec<OsString>) -> Result<ParsedCommand, Error> {
    let matches = command_line().try_get_matches_from(arguments)?;
    let parsed = Cli::from_arg_matches(&matches);
    let Cli { shared, command } = parsed.map_err(|error| error.format(&mut command_line()))?;
    let subcommand = match &command {
        Command::Strip(_) => "strip",
        Command::Compare(_) => "compare",
        Command::Bound(_) => "bound",
        Command::Analyze(_) => "analyze",
        Command::Verify(_) => "verify",
        Command::Convert(_) => "convert",
        Command::Simplify(_) => "simplify",
        Command::Chain(_) => "chain",
        Command::Level(_) => "level",
        Command::CameraLevel(_) => "camera-level",
        Command::BuildLod(_) => "build-lod",
        Command::Pack(_) => "pack",
        Command::Unpack(_) => "unpack",
        Command::Inspect(_) => "inspect",
        #[cfg(feature = "serve")]
        Command::Serve(_) => "serve",
        #[cfg(feature = "serve")]
        Command::View(_) => "view",
        #[cfg(not(feature = "serve"))]
        Command::Serve => "serve",
        #[cfg(not(feature = "serve"))]
        Command::View => "view",
        Command::Completions(_) => "completions",
        Command::Man(_) => "man",
        Command::Help(HelpArgs { name: Some(name) }) if Topic::find(name).is_none() => {
            return Err(help(&[name]));
        }
        Command::Help(HelpArgs { name: None }) => return Err(help(&[])),
        Command::Help(_) => "help",
    };
    Ok(ParsedCommand { command, shared, subcommand })
}

/// Returns the long help of the command or of a subcommand. In clap, help is an error that is
/// printed to standard output.
fn help(subcommand: &[&String]) -> Error {
    let words = ["tristrip"].into_iter().chain(subcommand.iter().map(|name| name.as_str()));
    match command_line().try_get_matches_from(words.chain(["--help"])) {
        Err(help) => help,
        Ok(_) => command_line().error(ErrorKind::InvalidSubcommand, "there is no help"),
    }
}

/// Returns the command with all subcommands. `--version` of a subcommand prints the name of the
/// command.
pub(crate) fn command_line() -> clap::Command {
    let command = Cli::command().mut_subcommands(|subcommand| {
        let subcommand = subcommand.display_name("tristrip").disable_version_flag(true).arg(version());
        match subcommand.get_name() {
            "convert" => subcommand.mut_arg("output", |output| output.required(true)),
            // The flag is accepted only to explain why it is refused.
            "build-lod" => subcommand.mut_arg("weld", |weld| weld.hide(true)),
            _ => subcommand,
        }
    });
    let groups = groups(&command);
    let exit_codes =
        "Exit codes: 0 success, all results verified; 1 failed verification, input or output; 2 wrong usage.";
    let hint = "`tristrip COMMAND -h` lists the options of a command. `tristrip help COMMAND` explains them.";
    command
        .after_help(format!("{groups}\n{hint}"))
        .after_long_help(format!("{groups}\n{hint}\n\n{}\n{exit_codes}", topics()))
}

/// Returns the flag that prints the version; it is hidden in the help of subcommands.
fn version() -> Arg {
    Arg::new("version").short('V').long("version").action(ArgAction::Version).hide(true)
}

/// Returns the subcommands grouped by task, each with its summary.
fn groups(command: &clap::Command) -> String {
    let mut text = String::new();
    for (title, names) in GROUPS {
        let _ = writeln!(text, "{title}:");
        for name in names {
            let about = command.find_subcommand(name).and_then(clap::Command::get_about);
            let _ = writeln!(text, "  {name:<14}{}", about.map(ToString::to_string).unwrap_or_default());
        }
    }
    let _ = writeln!(text, "Help: {}", TEXTS.join(", "));
    text
}

/// Returns the list of topics of `tristrip help`.
fn topics() -> String {
    let lines = TOPICS.iter().map(|topic| format!("  {:<16}{}\n", topic.name, topic.summary));
    format!("Topics of `tristrip help`:\n{}", lines.collect::<String>())
}

/// Returns a parser for the names of subcommands and topics.
fn help_parser() -> PossibleValuesParser {
    let topics = TOPICS.iter().map(|topic| PossibleValue::new(topic.name).help(topic.summary));
    let subcommands = GROUPS.iter().flat_map(|(_, names)| names.iter()).chain(&TEXTS);
    PossibleValuesParser::new(subcommands.map(PossibleValue::new).chain(topics))
}

/// Builds the error for an invalid combination of flags, with the usage of the subcommand.
pub(crate) fn usage_error(subcommand: &str, message: &str) -> Error {
    let mut command = command_line();
    command.build();
    match command.find_subcommand_mut(subcommand) {
        Some(found) => found.error(ErrorKind::ArgumentConflict, message),
        None => command.error(ErrorKind::ArgumentConflict, message),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        command_line().debug_assert();
    }
}
