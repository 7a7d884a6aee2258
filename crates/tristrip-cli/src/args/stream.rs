//! The flags of progressive GLB: `pack`, `unpack`, `inspect`.

use std::path::PathBuf;

use clap::Args;
use tristrip_pipeline::levels::Level;

use super::groups::{GeneralArgs, TargetArgs};
use crate::values::VectorArg;

/// Pack a model as a progressive GLB that renders while it loads
///
/// The model renders from the first bytes and refines as the rest arrives. The file is a valid GLB:
/// every viewer draws its base meshes. Chunks of vertex splits follow and refine the base meshes to
/// the full meshes. `unpack`, `inspect` and the JavaScript decoder also read truncated files; the
/// other subcommands need the complete file. Positions and attributes are rounded to a grid;
/// triangles and their winding are unchanged. Nodes, materials, textures, skins and animations are
/// kept. Parts with morph targets, and parts that a stream would not make smaller, are stored in
/// full. The file is read back and verified.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip pack bunny.ply -o bunny.glb
  tristrip pack scene.glb -o progressive.glb --position-bits 12
  tristrip pack models/*.ply -o packed/ --json
  tristrip pack terrain.ply -o terrain.glb --eye 0,1,-2   the foreground first")]
pub(crate) struct PackArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// First refine the surface near this scene position, such as 0,0.1,0.5 [default: uniform]
    ///
    /// Errors are divided by the distance, and halved on back faces. The complete file still
    /// refines to the full mesh.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, help_heading = "Stream")]
    pub(crate) eye: Option<VectorArg>,
    /// Write to a .glb file, a directory for several inputs, or - for standard output
    ///
    /// Files are written under a temporary name and then renamed. Existing files are replaced. In a
    /// directory, each output has the name of its input.
    #[arg(short, long, value_name = "OUTPUT", help_heading = "Output")]
    pub(crate) output: PathBuf,
    /// Store each coordinate in this many bits, 4 to 16 [default: 14]
    ///
    /// The longest side of a mesh is divided into 2^BITS - 1 steps. Parts placed by the same nodes
    /// share a grid, so no cracks open between them.
    #[arg(long, value_name = "BITS", value_parser = clap::value_parser!(u32).range(4..=16), help_heading = "Stream")]
    pub(crate) position_bits: Option<u32>,
    /// Skip verification
    #[arg(long, help_heading = "Output")]
    pub(crate) no_verify: bool,
}

/// Read a level of detail from a progressive GLB
///
/// Without --level, --triangles or --bytes, read the full meshes. If the file is truncated or
/// damaged, read everything before the damage and print a warning. GLB output contains the scene of
/// the file; other formats contain only its meshes.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip unpack bunny.glb --level 30% -o part.ply
  tristrip unpack bunny.glb --triangles 5000 -o part.glb
  tristrip unpack bunny.glb --bytes 20000 -o first.glb    from the first bytes only
  tristrip unpack cut-off.glb -o rest.ply")]
pub(crate) struct UnpackArgs {
    /// A file written by `pack`, or - for standard input
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    /// Select the level: a percentage, or the number of collapses to undo
    #[arg(long, value_name = "LEVEL", allow_negative_numbers = true, group = "goal", help_heading = "Level")]
    pub(crate) level: Option<Level>,
    /// Read the finest level with at most this many triangles
    #[arg(long, value_name = "N", group = "goal", help_heading = "Level")]
    pub(crate) triangles: Option<usize>,
    /// Read only this many bytes of the file
    #[arg(long, value_name = "N", group = "goal", help_heading = "Level")]
    pub(crate) bytes: Option<usize>,
    #[command(flatten)]
    pub(crate) target: TargetArgs,
}

/// Report chunks, bits per vertex and errors of a progressive GLB
///
/// The table splits the range-coded bits by component: `marks` selects the vertices to split,
/// `corners` selects the triangles that move, and `precision` refines known positions. Bits per
/// vertex are relative to the vertices of the full meshes. A truncated or damaged file is inspected
/// up to the damage.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip inspect bunny.glb
  tristrip inspect bunny.glb --plot rate.svg       error against bytes
  tristrip inspect bunny.glb --json")]
pub(crate) struct InspectArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Print one row per chunk
    #[arg(long)]
    pub(crate) chunks: bool,
    /// Write an SVG plot of the error against the bytes received
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) plot: Option<PathBuf>,
}
