//! The command line.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use tristrip::lod::{Filter, View};
use tristrip::simplify::Price;
use tristrip::vertex_cache::VertexCache;
use tristrip::{Effort, StripifyOptions};
use tristrip_lab::flight::Axis;
use tristrip_lab::recovery::Sweep;
use tristrip_pipeline::{Ratio, levels::Level, parse_method};

use crate::values::{effort, image_size, numbers};

/// Reproduce papers on triangle strips, compare methods and level models, and fly cameras
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 success, all results proven; 1 not proven, or an input or output error; 2 wrong usage."
)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Args)]
pub(crate) struct SharedArgs {
    /// Print the report as JSON
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Print only results and errors
    #[arg(short, long, global = true)]
    pub(crate) quiet: bool,
    /// The number of threads [default: one per processor]
    #[arg(long, value_name = "N", global = true)]
    pub(crate) threads: Option<NonZeroUsize>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Repro(ReproArgs),
    Levels(LevelsArgs),
    Pareto(ParetoArgs),
    Fly(Box<FlyArgs>),
    Pack(PackArgs),
    Unpack(UnpackArgs),
}

/// Reproduce the tables and figures of papers, and show published and measured values side by side
///
/// Write one page per paper, with its figures as SVG or PNG, into the directory `reproduction`
/// inside the output directory. Each result is proven first. Pages contain no times, so they are
/// the same on every machine. Rows whose model is missing are marked. If an existing page was
/// measured on more models than are found now, it is kept, with a note.
#[derive(Debug, Args)]
#[command(after_long_help = "Papers:
  000  El-Sana et al., Efficiently Computing and Updating Triangle Strips, 2000
  001  Kim et al., A Rendering-Efficient Progressive Transmission of 3D Meshes, 2005
  002  Belmonte et al., Triangle Strip Multiresolution Modelling Using Sorted Edges (SETS), 2006
  003  Porcu, Scateni, Partitioning Meshes into Strips (ETA), 2006
  004  Evans, Skiena, Varshney, Efficiently Generating Triangle Strips, 1996

Examples:
  tristrip-lab repro -o docs
  tristrip-lab repro --papers 000 --section skip-strips -o docs")]
pub(crate) struct ReproArgs {
    /// The numbers of the papers, separated by commas [default: all]
    #[arg(long, value_name = "PAPERS", value_delimiter = ',')]
    pub(crate) papers: Vec<String>,
    /// Reproduce only this section of each paper
    ///
    /// Paper 000 has the sections strips and skip-strips; papers 001 and 002 have levels; papers
    /// 003 and 004 have strips. Other sections of the page are kept.
    #[arg(long, value_name = "NAME")]
    pub(crate) section: Option<String>,
    /// The directory of the models [default: ../shared/models if it exists, else testdata/models]
    #[arg(long, value_name = "DIRECTORY")]
    pub(crate) models: Option<PathBuf>,
    /// The directory in which the directory `reproduction` is created
    #[arg(short, long, value_name = "DIRECTORY")]
    pub(crate) output: PathBuf,
}

/// Compare filters and level models on the levels of detail of meshes
///
/// Build strips once, for the full mesh. Half-edge collapses, cheapest first, rename vertices in
/// them down to a base mesh. At least one of --table, --compare, --sweep and --plot is required.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip-lab levels bunny.ply --table                      vertices sent by each filter, level by level
  tristrip-lab levels bunny.ply --compare --plot filters.svg
  tristrip-lab levels bunny.ply --sweep linear,exponential --plot recovery.svg")]
#[command(group = clap::ArgGroup::new("output").required(true).multiple(true).args(["table", "compare", "sweep", "plot"]))]
pub(crate) struct LevelsArgs {
    /// The mesh files
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    /// Print the vertices that each filter sends at 21 levels from the base mesh to the full mesh
    #[arg(long)]
    pub(crate) table: bool,
    /// Print the vertices that each filter sends over all levels
    #[arg(long)]
    pub(crate) compare: bool,
    /// Measure the memory of each level model, and its time to move between levels: linear,
    /// exponential, or both
    ///
    /// Recover 1, 3, 6, 10, 15 and 20 % of all levels, from the full mesh down to the base mesh and
    /// up again. Levels are equally spaced (linear), or closer together near the full mesh
    /// (exponential).
    #[arg(long, value_name = "SWEEPS", value_delimiter = ',')]
    pub(crate) sweep: Vec<Sweep>,
    /// Plot the vertices sent by each filter, or the times with --sweep, as an SVG file; up to
    /// three inputs
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    /// The ratio of all triangles that the base mesh keeps: 0.05 or 5%
    #[arg(long, value_name = "RATIO", default_value = "5%", allow_negative_numbers = true)]
    pub(crate) base: Ratio,
    /// The cost of collapses: distance, planes or quadric
    #[arg(long, value_name = "PRICE", default_value_t)]
    pub(crate) price: Price,
    /// The effort of the filter `repair`, from 0 to 9
    #[arg(long, value_name = "LEVEL", value_parser = effort, default_value = "5")]
    pub(crate) filter_effort: Effort,
    /// Skip verification
    #[arg(long)]
    pub(crate) no_verify: bool,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}

/// The strips of the full mesh.
#[derive(Debug, Args)]
pub(crate) struct MethodArgs {
    /// The method that builds the strips, with its options, such as
    /// stripe-global:patches=full,cutoff=10
    #[arg(short = 'm', long = "method", value_name = "METHOD", value_parser = parse_method, default_value = "best")]
    pub(crate) options: StripifyOptions,
}

/// Chart all methods: indices per triangle against misses per triangle
///
/// A line connects the Pareto-optimal methods: no other method is better in one of the two costs
/// and at least as good in the other. Each result is proven. The plain triangle list is shown for
/// comparison. The cache is not flushed between strips.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:
  tristrip-lab pareto bunny.ply -o bunny.svg")]
pub(crate) struct ParetoArgs {
    /// The mesh files, up to three
    #[arg(required = true, value_name = "INPUT")]
    pub(crate) inputs: Vec<PathBuf>,
    /// The SVG file to write
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: PathBuf,
    /// The effort of best, fewest and cache, from 0 to 9 [default: best and cache at 2 and 5,
    /// fewest at 5]
    #[arg(long, value_name = "LEVEL", value_parser = effort)]
    pub(crate) effort: Option<Effort>,
    /// The vertex cache: fifo:N or lru:N, N entries
    #[arg(long, value_name = "CACHE", default_value_t)]
    pub(crate) vertex_cache: VertexCache,
    /// The seed of randomized methods
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,
    /// Merge vertices with the same bits in position and all attributes
    #[arg(long)]
    pub(crate) weld: bool,
}

/// Fly a camera over a model with view-dependent detail, and measure each frame
///
/// Build strips once for the full mesh, and a tree of collapses. In each frame, the camera decides
/// which vertices collapse: more of them far from the camera, outside the frustum and on back
/// faces. Only strips with such a vertex change. The report has the triangles, the vertices sent,
/// the changes, and the time of each update. The display strips of up to 20 frames are proven to
/// draw exactly the triangles of the view.
///
/// The parts of a file are joined into one mesh; node transforms are not applied.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip-lab fly bunny.ply                                     one turn around the model
  tristrip-lab fly bunny.ply --frames 600 --pixels 2 --report bunny.md --plot bunny.svg
  tristrip-lab fly terrain.ply --path flyover --triangles 200000
  tristrip-lab fly dragon.tlod --path dolly --filter linked --json
  tristrip-lab fly bunny.ply --path cameras.json --image 960x540 --video frames/")]
#[allow(clippy::struct_excessive_bools, reason = "each is a flag")]
pub(crate) struct FlyArgs {
    /// The mesh file, or a .tlod file
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// The path of the camera: orbit, dolly, flyover, or a JSON file of cameras
    ///
    /// orbit is one turn around the vertical axis, at the distance where the model fills the image.
    /// dolly moves straight toward the model. flyover flies low over the model along the longest
    /// side of its bounding box, for terrains. A file is an array of cameras,
    /// `[{"eye": [0, 0, 9], "look_at": [0, 0, 0], "up": [0, 1, 0], "field_of_view": 45}]`, in mesh
    /// units and degrees. Frames are interpolated linearly between them. `up` and `field_of_view`
    /// are optional.
    #[arg(long, value_name = "PATH", default_value = "orbit")]
    pub(crate) path: PathBuf,
    /// The number of frames, up to 100000
    #[arg(long, value_name = "N", default_value_t = 300)]
    pub(crate) frames: usize,
    /// The vertical axis of orbit, dolly and flyover [default: y; for flyover, the shortest side of
    /// the bounding box]
    #[arg(long, value_name = "AXIS")]
    pub(crate) up: Option<Axis>,
    /// The vertical field of view in degrees
    #[arg(long, visible_alias = "fov", value_name = "DEGREES", default_value_t = View::FIELD_OF_VIEW)]
    pub(crate) field_of_view: f32,
    /// The width and height of the image in pixels, such as 1280x720
    #[arg(long, value_name = "SIZE", value_parser = image_size, default_value = "1920x1080")]
    pub(crate) image: [u32; 2],
    /// The maximum error of a collapse in the image, in pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 1.0, allow_negative_numbers = true)]
    pub(crate) pixels: f32,
    /// The maximum number of triangles of a frame
    ///
    /// If the error limit needs more triangles, the largest errors in pixels are reduced first. The
    /// base mesh may have more.
    #[arg(long, value_name = "COUNT")]
    pub(crate) triangles: Option<usize>,
    /// The maximum number of collapses and splits per frame; the rest is done in the next frame
    /// [default: no limit]
    #[arg(long, value_name = "N")]
    pub(crate) steps: Option<NonZeroUsize>,
    /// Keep full detail outside the frustum
    #[arg(long)]
    pub(crate) no_frustum: bool,
    /// Keep full detail on back faces; otherwise they may have four times the error
    #[arg(long)]
    pub(crate) no_back_faces: bool,
    /// Give silhouettes no more detail than other faces; otherwise they may have only half of the
    /// error
    #[arg(long)]
    pub(crate) no_silhouettes: bool,
    /// The direction to a light; faces that face away from it may have twice the error
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::<f32, 3>, allow_hyphen_values = true)]
    pub(crate) light: Option<[f32; 3]>,
    /// The growth of the allowed error per degree from the point of attention, such as 0.2
    #[arg(long, value_name = "GROWTH", allow_negative_numbers = true)]
    pub(crate) foveation: Option<f32>,
    /// The point of attention, in fractions of the image from the left and from the top
    #[arg(long, value_name = "X,Y", value_parser = numbers::<f32, 2>, requires = "foveation", default_value = "0.5,0.5")]
    pub(crate) attention: [f32; 2],
    /// The filter that turns strips into display strips: none, stss, dtfs or linked
    #[arg(long, value_name = "FILTER", default_value_t = Filter::Dtfs)]
    pub(crate) filter: Filter,
    /// Write the report of all frames as a Markdown page
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Plot triangles, vertices sent and milliseconds per frame as an SVG file
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PathBuf>,
    /// Write frames as PNG files 0000.png, 0001.png … to a directory, one colour per strip
    #[arg(long, value_name = "DIRECTORY")]
    pub(crate) video: Option<PathBuf>,
    /// Draw one of every K frames [default: at most 60 images]
    #[arg(long, value_name = "K", requires = "video")]
    pub(crate) video_every: Option<NonZeroUsize>,
    /// Draw the surface in grey, without strip colours
    #[arg(long, requires = "video")]
    pub(crate) shaded: bool,
    /// Skip verification
    #[arg(long)]
    pub(crate) no_verify: bool,
    /// The method that builds the strips, with its options, such as
    /// stripe-global:patches=full,cutoff=10 [default: best]
    #[arg(short, long, value_name = "METHOD", value_parser = parse_method)]
    pub(crate) method: Option<StripifyOptions>,
}

/// Encode a mesh in the format of paper 001: progressive strips, and 12 + 2 u bytes per restored
/// vertex
///
/// All parts are joined into one mesh of positions and strips. The bytes are not compressed.
#[derive(Debug, Args)]
#[command(after_long_help = "Example:
  tristrip-lab pack bunny.ply -o bunny.ps")]
pub(crate) struct PackArgs {
    /// The mesh file
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// The file to write
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: PathBuf,
    /// Skip verification
    #[arg(long)]
    pub(crate) no_verify: bool,
}

/// Read a level of detail from a file written by `pack`, which may be truncated
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip-lab unpack bunny.ps --level 30% -o part.ply
  tristrip-lab unpack bunny.ps --bytes 20000 -o first.ply")]
pub(crate) struct UnpackArgs {
    /// A file written by `pack`
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// The level of detail, as a number of undone collapses or a percentage of all collapses
    /// [default: 100%]
    #[arg(long, value_name = "LEVEL", group = "goal", allow_negative_numbers = true)]
    pub(crate) level: Option<Level>,
    /// Read the finest level with at most this number of triangles
    #[arg(long, value_name = "N", group = "goal")]
    pub(crate) triangles: Option<usize>,
    /// Read the level that the first N bytes contain
    #[arg(long, value_name = "N", group = "goal")]
    pub(crate) bytes: Option<usize>,
    /// The mesh file to write; without it, print only the report
    #[arg(short, long, value_name = "OUTPUT")]
    pub(crate) output: Option<PathBuf>,
}
