//! The flags of progressive GLB: `pack`, `unpack`, `inspect`.

use std::path::PathBuf;

use clap::Args;
use tristrip_pipeline::Level;

use super::groups::{GeneralArgs, TargetArgs};
use crate::values::Vector;

/// Pack a model as a progressive GLB, which is drawn after its first bytes and refined by the others
///
/// The file is a valid GLB: every viewer draws its base meshes. Behind them are chunks of vertex splits, which refine the base meshes to the full ones; `unpack`, all other
/// subcommands and the JavaScript decoder read them, also from a part of the file. Positions are rounded to a grid, and attributes too; triangles and their winding stay. A
/// scene keeps all else: nodes, materials, textures, skins, animations. The file is read back and proven.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip pack bunny.ply -o bunny.glb
  tristrip pack scene.glb -o progressive.glb --position-bits 12
  tristrip pack models/*.ply -o packed/ --json
  tristrip pack terrain.ply -o terrain.glb --eye 0,1,-2   the foreground first")]
pub(crate) struct PackArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Refine first what looks largest from this position in the scene, such as 0,0.1,0.5 [default: everywhere alike]
    ///
    /// Errors count by the distance, and half where the surface faces away. All is refined in the end.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Stream")]
    pub(crate) eye: Option<Vector>,
    /// The file to write, with the extension .glb, a directory for several inputs, or - for standard output
    ///
    /// A file is written under a temporary name and then renamed; one that exists is replaced. In a directory, each output has the name of its input.
    #[arg(short, long, value_name = "OUTPUT", help_heading = "Output")]
    pub(crate) output: PathBuf,
    /// The bits of a coordinate: the longest side of a mesh has two to this power steps, less one [default: 14]
    ///
    /// Parts that the same nodes place have one grid, so that no cracks open between them.
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(4..=16), help_heading = "Stream")]
    pub(crate) position_bits: Option<u32>,
    /// Skip verification
    #[arg(long, help_heading = "Output")]
    pub(crate) no_verify: bool,
}

/// Read a level of detail from a progressive GLB
///
/// Without --level, --triangles or --bytes, the full meshes. A file that is cut off or damaged gives what is complete before the end or the damage, with a warning. The
/// result has the scene of the file if it is a GLB; other formats get the meshes.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip unpack bunny.glb --level 30% -o part.ply
  tristrip unpack bunny.glb --triangles 5000 -o part.glb
  tristrip unpack bunny.glb --bytes 20000 -o first.glb    what the first bytes hold
  tristrip unpack cut-off.glb -o rest.ply")]
pub(crate) struct UnpackArgs {
    /// A file of `pack`, or - for standard input
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// The level of detail: the number of collapses that are undone, or a percentage of all
    #[arg(long, value_name = "LEVEL", allow_negative_numbers = true, group = "goal", help_heading = "Level")]
    pub(crate) level: Option<Level>,
    /// The finest level with at most this number of triangles in the refined meshes
    #[arg(long, value_name = "N", group = "goal", help_heading = "Level")]
    pub(crate) triangles: Option<usize>,
    /// What so many first bytes of the file hold
    #[arg(long, value_name = "N", group = "goal", help_heading = "Level")]
    pub(crate) bytes: Option<usize>,
    #[command(flatten)]
    pub(crate) target: TargetArgs,
}

/// Show what a progressive GLB holds: chunks, bits per vertex, error against bytes
///
/// The bits of the components are those of the range coder: marks say which vertices are split, corners which of their triangles move, precision is further bits of
/// positions that are there already. Bits per vertex are relative to the vertices of the full meshes. A file that is cut off or damaged is shown as far as it is complete.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip inspect bunny.glb
  tristrip inspect bunny.glb --plot rate.svg       error against bytes
  tristrip inspect bunny.glb --json")]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Print a row for each chunk
    #[arg(long)]
    pub(crate) chunks: bool,
    /// Draw the error of the levels against the bytes in an SVG file
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) plot: Option<PathBuf>,
}
