//! The flags of simplification and levels of detail.

use clap::Args;

use super::{InputArgs, SharedArgs, TargetArgs, ThreadArgs};
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
    /// Measured as the root of a mean of squared distances to the planes of the faces that went. Alone it gives as few triangles as
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
