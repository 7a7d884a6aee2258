//! The flags of simplification and levels of detail.

use std::path::PathBuf;

use clap::Args;

use super::{InputArgs, OutputArgs, SharedArgs, TargetArgs, ThreadArgs};
use crate::lod::{FilterName, Level, ModelName};
use crate::method::MethodArgs;
use crate::simplify::{Deviation, Ratio};

/// Gives a mesh fewer triangles by half-edge collapses, the cheapest first
///
/// A vertex that goes is drawn as one of its neighbours; no vertex moves, and none is new. The surface keeps its holes, its separate
/// pieces and, unless that costs too much, its shape. A goal that cannot be reached without tearing or folding the surface is not, and a
/// note says where it ended: that is no fault. Vertices of a position that several parts use (materials of OBJ, primitives of glTF) stay, so
/// that parts do not come apart. Vertices that are not used any more are left out of the file; a GLB that was read from glTF keeps
/// them, since other things in the scene count on their number. Without -o it only reports.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip simplify bunny.ply --ratio 5% -o bunny-small.ply
  tristrip simplify bunny.ply --triangles 2000 -o bunny-small.glb
  tristrip simplify scene.glb --error 0.1% -o light.glb   as few as this error allows
  tristrip simplify bunny.ply --ratio 0.05 --error 1% --json")]
pub(crate) struct SimplifyArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// The share of the triangles to keep, of each part: 0.05 or 5%
    #[arg(long, value_name = "RATIO", conflicts_with = "triangles")]
    pub(crate) ratio: Option<Ratio>,
    /// How many triangles to keep; each part keeps its share
    #[arg(long, value_name = "N")]
    pub(crate) triangles: Option<usize>,
    /// How far the surface may come away: 0.01 in units of the mesh, or 0.1% of the diagonal of the model's bounding box
    ///
    /// The error of a collapse is the distance of the vertex that goes from the triangles in its place, or the root of the mean of its squared distances to the planes that it stood for, if that is greater. Alone it gives as few triangles as
    /// this error allows; beside --ratio or --triangles, whatever comes first is the end.
    #[arg(long, value_name = "ERROR")]
    pub(crate) error: Option<Deviation>,
    #[command(flatten)]
    pub(crate) target: TargetArgs,
    /// Skip the proof
    #[arg(long, help_heading = "Output")]
    pub(crate) no_verify: bool,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}

/// Draws any level of detail with the strips of the full mesh
///
/// Strips are found once, of the full mesh. Half-edge collapses, the cheapest first, rename vertices in them down to a base mesh; level 0
/// is the base mesh, the highest level is the full one, and a level more is a vertex more. What collapses leave degenerate a filter takes
/// out before it is drawn. Every level is proven to draw exactly the triangles that the collapses leave. Without -o it only reports.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip lod bunny.ply --level 40% -o level.glb     strips at any level
  tristrip lod bunny.ply --table                      what every filter sends, level by level
  tristrip lod bunny.ply --method stripe --base 1% --filter dtfs --level 120
  tristrip lod bunny.ply --compare --plot lod.svg     filters against the mesh drawn as triangles")]
pub(crate) struct LodArgs {
    #[command(flatten)]
    pub(crate) inputs: InputArgs,
    /// How levels are stored and replayed
    #[arg(long, value_enum, value_name = "MODEL", default_value_t = ModelName::Progressive, help_heading = "Levels")]
    pub(crate) model: ModelName,
    /// The share of the triangles of each part that the base mesh keeps: 0.05 or 5%
    ///
    /// Where the surface cannot be simplified so far without tearing or folding, the base mesh has more, and a note says so.
    #[arg(long, value_name = "RATIO", default_value = "5%", help_heading = "Levels")]
    pub(crate) base: Ratio,
    /// The level to draw: a number of collapses undone, or a share of them such as 40%
    ///
    /// P% of n collapses is the level P n / 100, rounded to the nearest. The levels of a model of several parts undo the collapses of all parts,
    /// those of the greatest error first.
    #[arg(long, value_name = "LEVEL", default_value = "100%", help_heading = "Levels")]
    pub(crate) level: Level,
    /// How strips are read before they are drawn
    #[arg(long, value_enum, value_name = "FILTER", default_value_t = FilterName::DEFAULT, help_heading = "Levels")]
    pub(crate) filter: FilterName,
    /// How long --filter repair searches, from 0 to 9 [default: 5]
    #[arg(long, value_name = "LEVEL", value_parser = clap::value_parser!(u8).range(0..=9), help_heading = "Levels")]
    pub(crate) filter_effort: Option<u8>,
    /// Show what every filter sends, at levels 5 % apart
    #[arg(long, help_heading = "Levels")]
    pub(crate) table: bool,
    /// Show what every filter sends from the base mesh to the full one, each level drawn once
    #[arg(long, help_heading = "Levels")]
    pub(crate) compare: bool,
    /// Draw what every filter sends over the levels into an SVG file; up to three inputs
    #[arg(long, value_name = "FILE", help_heading = "Levels")]
    pub(crate) plot: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
    /// Skip the proof
    #[arg(long, help_heading = "Output")]
    pub(crate) no_verify: bool,
    #[command(flatten)]
    pub(crate) shared: SharedArgs,
    #[command(flatten)]
    pub(crate) threads: ThreadArgs,
}
