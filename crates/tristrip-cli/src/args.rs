//! The command line as it is typed: every flag with its short and long help. What flags mean together is said in
//! [`crate::task`].

mod detail;

use std::path::PathBuf;
use std::time::Duration;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use tristrip::Layout;
use tristrip_io::Format;

use crate::analyze::BufferList;
use crate::method::{CostName, MethodArgs};
use crate::task::{Shared, Task, validate};
pub(crate) use detail::{LodArgs, SimplifyArgs};

/// Turns polygon meshes into triangle strips and proves them
///
/// Reads OBJ, PLY, OFF, STL, glTF and GLB; writes GLB, PLY and OBJ. Every result is proven to draw exactly the faces of its source,
/// each once, with its winding, before it is written.
#[derive(Debug, Parser)]
#[command(name = "tristrip", version, propagate_version = true, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 done and proven; 1 not proven, or a bad input or output; 2 wrong usage."
)]
struct Cli {
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
    Lod(Box<LodArgs>),
    Repro(ReproArgs),
}

/// Finds triangle strips, proves them, and writes them
///
/// Without -o it only reports. Results for people go to standard output, stages and progress to standard error.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip strip bunny.ply -o bunny.glb             strips that every glTF viewer draws
  tristrip strip scene.glb -o out.glb --layout restart
  tristrip strip models/*.obj -o stripped/ --to ply
  tristrip strip bunny.ply --method best --effort 7 -o bunny.glb
  tristrip strip horse.ply --method fewest --budget 5s
  tristrip strip bunny.ply --method stripe --json   no file: the report alone
  tristrip strip bunny.ply --pareto bunny.svg       every method in one picture
  cat bunny.ply | tristrip strip - -o - --to glb > bunny.glb")]
pub(crate) struct StripArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    /// Number the vertices in the order in which the strips first use them
    ///
    /// Fetches from the vertex buffer are then sequential. Vertices that no strip uses come last. Whatever belongs to a vertex
    /// moves with it; parts of a scene that share vertices share one order, and vertices whose numbers may be named elsewhere keep
    /// them, with a note. With --json the report tells which vertex came to which place.
    #[arg(long, requires = "output", help_heading = "Output")]
    pub(crate) reorder_vertices: bool,
    /// Skip the proof
    #[arg(long, help_heading = "Output")]
    pub(crate) no_verify: bool,
    /// Draw what every method makes of the model into an SVG file: indices a triangle against misses a triangle
    ///
    /// Indices are those of layout restart, misses those of the vertex buffer of --buffer, kept across strips. A line joins the
    /// optimal ones: no other method has fewer of one and no more of the other. Each result is proven, also with --no-verify. The
    /// plain triangle list is shown for comparison. best and cache search at efforts 2 and 5, fewest at 5, or all at --effort;
    /// --budget is for each search by itself; --seed and --weld are for all. Up to three inputs.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) pareto: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}

/// Shows what every method makes of a model, side by side
///
/// One table a model; each row is proven before it is shown, and the best of each column is marked.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip compare bunny.ply cow.obj
  tristrip compare bunny.ply --all --markdown > bunny.md")]
pub(crate) struct CompareArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// Compare also tunnel, eta and all 15 stripe-local and 10 stripe-global variants
    #[arg(long)]
    pub(crate) all: bool,
    /// How long best and fewest search, from 0 to 9
    #[arg(long, value_name = "LEVEL", default_value_t = 3, value_parser = clap::value_parser!(u8).range(0..=9))]
    pub(crate) effort: u8,
    /// What best minimizes
    #[arg(long, value_enum, value_name = "COST", default_value_t = CostName::Restart)]
    pub(crate) cost: CostName,
    /// Stop each search after a time, such as 5s or 500ms
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    pub(crate) budget: Option<Duration>,
    /// Print Markdown tables
    #[arg(long, conflicts_with = "json")]
    pub(crate) markdown: bool,
    /// The seed of the methods that break ties at random
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Let vertices with the same bits in position and all attributes count as one
    #[arg(long)]
    pub(crate) weld: bool,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}

/// Shows how few strips, vertices and indices there can be at best
///
/// Lower bounds for all covers of the dual graph by strips, and how they were found; where more than two faces meet at an edge, they hold
/// for the pairs that the dual graph joins. For polygons they hold whatever the triangulation; for triangles they are sharper.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:
  tristrip bound bunny.ply")]
pub(crate) struct BoundArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// Let vertices with the same bits in position and all attributes count as one
    #[arg(long)]
    pub(crate) weld: bool,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}

/// Shows what a file makes a graphics processor do, as it stands
///
/// Counts triangles, strips, indices, restarts and degenerate triangles as they are stored, and simulates vertex buffers: a miss is a vertex
/// that must be transformed again; ACMR is misses a triangle, ATVR misses a vertex in use. No strips are looked for; polygons count as
/// fans of triangles. Each part of a file (a material of OBJ, a primitive of glTF) begins with an empty buffer.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip analyze bunny.ply bunny.glb              before and after
  tristrip analyze bunny.glb --buffers fifo:8..32,lru:16 --flush
  tristrip analyze bunny.ply bunny.glb --plot buffers.svg")]
pub(crate) struct AnalyzeArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// Which vertex buffers to simulate [default: fifo and lru of 8, 16, 24, 32 and 64]
    ///
    /// A list of KIND:N or KIND:N..M: KIND is fifo (the vertex that came in first leaves first) or lru (the one that was not sent for the
    /// longest time), N and M are places.
    #[arg(long, value_name = "LIST")]
    pub(crate) buffers: Option<BufferList>,
    /// Empty the buffer between strips, as if each had a draw call of its own
    #[arg(long)]
    pub(crate) flush: bool,
    /// Draw misses against places, and the lengths of strips, into an SVG file
    ///
    /// The curves go through the buffers of --buffers, or 2 to 64 places. Up to three inputs.
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}

/// Proves that one file draws exactly the faces of another
///
/// The files may come from anywhere and be in different formats: triangle lists, strips, fans, degenerate triangles, restarts, one
/// primitive a strip. Vertices are compared by the bits of their positions, so that a re-ordered vertex buffer is fine; other
/// attributes are not compared, and scenes are compared mesh by mesh, without the transformations of their nodes.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:
  tristrip verify bunny.ply bunny.glb")]
pub(crate) struct VerifyArgs {
    /// The file that says what should be drawn, or - for standard input
    pub(crate) source: PathBuf,
    /// The file to be proven, or - for standard input
    pub(crate) result: PathBuf,
    /// The format of standard input, or of files whose extension misleads
    #[arg(long, value_enum, value_name = "FORMAT")]
    pub(crate) from: Option<ReadFormat>,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
}

/// Changes the format or the strip layout, and finds no new strips
///
/// Without --layout faces are written as they are, polygons as polygons where the format has them, and strips stay strips. With
/// --layout the triangles' own order becomes strips whatever the input has.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip convert in.obj -o out.ply
  tristrip convert strips.ply -o strips.glb --layout restart")]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    /// Skip the proof
    #[arg(long, help_heading = "Output")]
    pub(crate) no_verify: bool,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}

/// Shows the tables and figures of papers again, published beside measured
///
/// Writes a page for each paper and its figures as SVG into the folder `reproduction` of a directory. Every result is proven before its
/// figures are shown. Pages hold no times, so that they are the same on every machine. Rows whose models are missing say so.
#[derive(Debug, Args)]
#[command(after_long_help = "Papers:
  000  El-Sana et al., Efficiently Computing and Updating Triangle Strips, 2000
  001  Kim et al., A Rendering-Efficient Progressive Transmission of 3D Meshes, 2005
  003  Porcu, Scateni, Partitioning Meshes into Strips (ETA), 2006
  004  Evans, Skiena, Varshney, Efficiently Generating Triangle Strips, 1996

Example:
  tristrip repro -o docs")]
pub(crate) struct ReproArgs {
    /// The papers, by their numbers, separated by commas [default: all]
    #[arg(long, value_name = "PAPERS", value_delimiter = ',')]
    pub(crate) papers: Vec<String>,
    /// The folder of the models [default: ../shared/models, or else testdata/models]
    #[arg(long, value_name = "DIRECTORY")]
    pub(crate) models: Option<PathBuf>,
    /// The directory into whose folder `reproduction` the pages are written
    #[arg(short, long, value_name = "DIRECTORY", help_heading = "Output")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}

#[derive(Debug, Args)]
pub(crate) struct InputArgs {
    /// Mesh files, or - for standard input
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    /// The format of standard input, or of files whose extension misleads
    ///
    /// Without it a file's extension tells, or its content where there is no known extension.
    #[arg(long, value_enum, value_name = "FORMAT", help_heading = "General")]
    pub(crate) from: Option<ReadFormat>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct OutputArgs {
    #[command(flatten)]
    pub(crate) target: TargetArgs,
    /// How strips are laid out [default: degenerate for GLB, restart for PLY, list for OBJ]
    #[arg(long, value_enum, value_name = "LAYOUT", requires = "output")]
    pub(crate) layout: Option<LayoutName>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct TargetArgs {
    /// The file to write, a directory for many inputs, or - for standard output
    ///
    /// The extension tells the format: .glb, .ply or .obj. Files are written beside the old one and renamed. In a directory each
    /// output has its input's name with the extension of --to.
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: Option<PathBuf>,
    /// The format to write [default: by the extension; glb in a directory]
    #[arg(long, value_enum, value_name = "FORMAT", requires = "output")]
    pub(crate) to: Option<WriteFormat>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "General")]
pub(crate) struct SharedArgs {
    /// Print the results as JSON on standard output
    ///
    /// One object for one input, an array for many. The keys are described in FORMAT.md.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print only errors and what was asked for: JSON, a table, a report without -o
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "General")]
pub(crate) struct ThreadArgs {
    /// How many threads may work [default: one for each core]
    ///
    /// The result is the same for any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum ReadFormat {
    Obj,
    Ply,
    Off,
    Stl,
    Gltf,
    Glb,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum WriteFormat {
    Glb,
    Ply,
    Obj,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum LayoutName {
    /// Strips separated by the restart index (in glTF the draft extension for primitive restart)
    Restart,
    /// One strip, joined by degenerate triangles; every glTF viewer draws it
    Degenerate,
    /// One primitive, or row, a strip
    Separate,
    /// A triangle list in strip order
    List,
}

/// Reads the command line; ends the process with help, the version, or exit code 2 where it makes no sense.
pub(crate) fn parse() -> (Task, Shared) {
    let cli = Cli::parse();
    let subcommand = match &cli.command {
        Command::Strip(_) => "strip",
        Command::Compare(_) => "compare",
        Command::Bound(_) => "bound",
        Command::Analyze(_) => "analyze",
        Command::Verify(_) => "verify",
        Command::Convert(_) => "convert",
        Command::Simplify(_) => "simplify",
        Command::Lod(_) => "lod",
        Command::Repro(_) => "repro",
    };
    validate(cli.command).unwrap_or_else(|message| {
        let mut command = Cli::command();
        command.build();
        match command.find_subcommand_mut(subcommand) {
            Some(found) => found.error(ErrorKind::ArgumentConflict, message).exit(),
            None => command.error(ErrorKind::ArgumentConflict, message).exit(),
        }
    })
}

impl ReadFormat {
    pub(crate) fn format(self) -> Format {
        match self {
            Self::Obj => Format::Obj,
            Self::Ply => Format::Ply,
            Self::Off => Format::Off,
            Self::Stl => Format::Stl,
            Self::Gltf => Format::Gltf,
            Self::Glb => Format::Glb,
        }
    }
}

impl WriteFormat {
    pub(crate) fn format(self) -> Format {
        match self {
            Self::Glb => Format::Glb,
            Self::Ply => Format::Ply,
            Self::Obj => Format::Obj,
        }
    }
}

impl LayoutName {
    pub(crate) fn layout(self) -> Layout {
        match self {
            Self::Restart => Layout::Restart,
            Self::Degenerate => Layout::Degenerate,
            Self::Separate => Layout::Separate,
            Self::List => Layout::List,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }
}
