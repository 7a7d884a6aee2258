//! The flags of simplification and levels of detail.

use std::path::PathBuf;

use clap::Args;
use tristrip::Effort;
use tristrip::lod::{ModelKind, View};
use tristrip::simplify::{MergeOrder, Price};
use tristrip_pipeline::{
    Deviation, Ratio, chain::ChainRatios, levels::DisplayFilter, levels::Level, simplify::Normals,
};

use super::groups::{CollapseArgs, FromArgs, GeneralArgs, OutputArgs, TargetArgs};
use super::view::{CriteriaArgs, LensArgs};
use crate::method::MethodArgs;
use crate::values::{Amount, VectorArg, effort_parser, named};

/// Simplify a mesh by half-edge collapses
///
/// Topology is preserved. The shape is preserved as far as the triangle budget allows. All parts of
/// a scene are simplified together. If the budget cannot be reached within the error limit, or
/// without tearing or folding the surface, simplification stops early with a warning. Without -o,
/// print a report and write no file. `tristrip help simplification` explains all options.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip simplify bunny.ply --ratio 5% -o bunny-small.ply
  tristrip simplify bunny.ply --triangles 2000 -o bunny-small.glb
  tristrip simplify bunny.ply --ratio 5% --fit -o bunny-small.ply   a third closer to the input
  tristrip simplify scene.glb --error 0.1% -o light.glb   as few triangles as this error allows
  tristrip simplify duck.glb --ratio 20% --picture before-after.png
  tristrip simplify bunny.ply --ratio 0.05 --error 1% --json")]
pub(crate) struct SimplifyArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Keep this fraction of the triangles: 0.05 or 5%
    ///
    /// All parts of a model share one triangle budget. Without --ratio and --triangles, simplify as
    /// far as --error allows. With one of them, stop at whichever limit is reached first.
    #[arg(long, value_name = "RATIO", conflicts_with = "triangles", allow_negative_numbers = true)]
    pub(crate) ratio: Option<Ratio>,
    /// Keep this many triangles, or one less
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) triangles: Option<usize>,
    #[command(flatten)]
    pub(crate) collapse: CollapseArgs,
    /// Keep or rebuild normals: auto, keep or rebuild
    ///
    /// auto rebuilds the normals of flat-shaded parts, and replaces other normals that no longer
    /// match their faces. rebuild recomputes all normals: flat, or smooth up to a crease angle
    /// estimated for each part.
    #[arg(long, value_name = "MODE", value_parser = named(Normals::ALL, Normals::name, Normals::summary), default_value_t = Normals::default(), hide_possible_values = true)]
    pub(crate) normals: Normals,
    /// Move the remaining vertices closer to the original surface
    ///
    /// This typically reduces the RMS distance by a third or more. The result contains positions
    /// that the input does not have.
    #[arg(long)]
    pub(crate) fit: bool,
    /// Round joint weights to 8 bits and animated rotations to 16 bits in GLB and .gltf output
    #[arg(long, hide_short_help = true)]
    pub(crate) compact: bool,
    #[command(flatten)]
    pub(crate) target: TargetArgs,
    /// Draw the model before and after to a PNG file, from eight sides
    ///
    /// The upper row shows the input, and the lower row shows the result. Each view is 256 x 256
    /// pixels, with base colours and textures. Node transformations are applied; animations and
    /// skins are ignored. This option takes one input.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) picture: Option<PathBuf>,
}

/// Write one level of detail with the strips of the full mesh
///
/// Build strips once, for the full mesh. Half-edge collapses, cheapest first, reduce the full mesh
/// to a base mesh and rename vertices in the strips. Level 0 is the base mesh, and the highest
/// level is the full mesh. Each level adds one vertex. Verification checks that the result draws
/// exactly the triangles that remain after the collapses. Without -o, print a report and write no
/// file. `tristrip help levels` explains levels, filters and models.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip level bunny.ply --level 40% -o level.glb
  tristrip level bunny.ply --triangles 5k -o level.glb
  tristrip level bunny.ply --pixels 1.5 --distance 3      the level for a viewing distance
  tristrip level bunny.ply --base 1% --filter dtfs --level 120
  tristrip level bunny.ply --model sets --level 25% -o level.glb")]
pub(crate) struct LevelArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Select the level: % or number of undone collapses [default: 10%]
    #[arg(
        long,
        value_name = "LEVEL",
        help_heading = "Level",
        allow_negative_numbers = true,
        conflicts_with_all = ["triangles", "error", "pixels"],
    )]
    pub(crate) level: Option<Level>,
    /// Select the finest level with at most this many triangles, such as 200k
    #[arg(
        long,
        value_name = "COUNT",
        help_heading = "Level",
        allow_negative_numbers = true,
        conflicts_with_all = ["error", "pixels"]
    )]
    pub(crate) triangles: Option<Amount>,
    /// Select the coarsest level within this error: 0.01 mesh units, or 0.1%
    #[arg(long, value_name = "ERROR", help_heading = "Level", allow_negative_numbers = true)]
    pub(crate) error: Option<Deviation>,
    /// Select the coarsest level whose error is at most this many pixels
    #[arg(
        long,
        value_name = "PIXELS",
        help_heading = "Level",
        allow_negative_numbers = true,
        conflicts_with = "error",
        requires = "distance"
    )]
    pub(crate) pixels: Option<f32>,
    /// Set the camera distance for --pixels, in mesh units
    #[arg(
        long,
        value_name = "DISTANCE",
        help_heading = "Level",
        allow_negative_numbers = true,
        requires = "pixels"
    )]
    pub(crate) distance: Option<f32>,
    /// Set the vertical field of view for --pixels, in degrees [default: 45]
    #[arg(long, visible_alias = "fov", value_name = "DEGREES", default_value_t = View::FIELD_OF_VIEW, hide_default_value = true, help_heading = "Level", allow_negative_numbers = true, requires = "pixels", hide_short_help = true)]
    pub(crate) field_of_view: f32,
    /// Set the image height for --pixels, in pixels [default: 1080]
    #[arg(long, value_name = "ROWS", default_value_t = View::ROWS, hide_default_value = true, help_heading = "Level", allow_negative_numbers = true, requires = "pixels", hide_short_help = true)]
    pub(crate) rows: f32,
    /// Keep this fraction of the triangles in the base mesh [default: 5% with --level, else 0]
    #[arg(
        long,
        hide_short_help = true,
        value_name = "RATIO",
        help_heading = "Level",
        allow_negative_numbers = true
    )]
    pub(crate) base: Option<Ratio>,
    /// Set the cost of a collapse: distance, planes or quadric [default: distance]
    #[arg(long, value_name = "PRICE", value_parser = named(Price::ALL, Price::name, Price::summary), default_value_t = Price::default(), hide_default_value = true, hide_possible_values = true, help_heading = "Level", hide_short_help = true)]
    pub(crate) price: Price,
    /// Set the display filter: repair, linked, dtfs, stss or none [default: repair]
    #[arg(long, value_parser = named(DisplayFilter::ALL, DisplayFilter::name, DisplayFilter::summary), value_name = "FILTER", help_heading = "Level", hide_possible_values = true)]
    pub(crate) filter: Option<DisplayFilter>,
    /// Set the search effort of --filter repair, from 0 to 9 [default: 5]
    #[arg(long, value_name = "LEVEL", value_parser = effort_parser(), help_heading = "Level", hide_short_help = true)]
    pub(crate) filter_effort: Option<Effort>,
    /// Draw the strips of a level model instead of filtered strips; see `tristrip help levels`
    #[arg(long, value_parser = named(ModelKind::ALL, ModelKind::name, ModelKind::summary), hide_possible_values = true, value_name = "MODEL", help_heading = "Level", hide_short_help = true)]
    pub(crate) model: Option<ModelKind>,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}

/// Write a view-dependent level of detail for one camera
///
/// Detail is reduced far from the camera, outside the frustum and on back faces. The view reuses
/// the strips of the full mesh (Skip Strips). The result is verified. Without -o, print a report
/// and write no file. `tristrip help levels` explains the details.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip camera-level dragon.ply --eye 0,0,3 --look-at 0,0,0 --pixels 1.5 -o seen.glb
  tristrip camera-level dragon.ply --eye 0,0,3 --look-at 0,0,0 --triangles 200k
  tristrip camera-level terrain.ply --eye 0,9,0 --look-at 9,0,9 --foveation 0.2 --attention 0.5,0.7")]
pub(crate) struct CameraLevelArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Set the camera position, in scene coordinates
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
    pub(crate) eye: VectorArg,
    /// Set the point that the camera looks at, in scene coordinates
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true)]
    pub(crate) look_at: VectorArg,
    /// Set the up direction of the image [default: 0,1,0]
    #[arg(long, hide_short_help = true, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true, default_value_t = VectorArg([0.0, 1.0, 0.0]), hide_default_value = true)]
    pub(crate) up: VectorArg,
    #[command(flatten)]
    pub(crate) lens: LensArgs,
    /// Limit the image-space error of a collapse, in pixels [default: 1]
    #[arg(
        long,
        value_name = "PIXELS",
        help_heading = "Detail",
        allow_negative_numbers = true,
        hide_default_value = true,
        default_value_t = 1.0
    )]
    pub(crate) pixels: f32,
    /// Limit the number of triangles, such as 50000, 200k or 2M
    #[arg(long, value_name = "COUNT", help_heading = "Detail", allow_negative_numbers = true)]
    pub(crate) triangles: Option<Amount>,
    #[command(flatten)]
    pub(crate) criteria: CriteriaArgs,
    /// Keep this fraction of the triangles in the base mesh [default: 0]
    #[arg(
        long,
        value_name = "RATIO",
        help_heading = "Detail",
        allow_negative_numbers = true,
        hide_short_help = true
    )]
    pub(crate) base: Option<Ratio>,
    /// Set the cost of a collapse: distance, planes or quadric [default: distance]
    #[arg(long, value_name = "PRICE", value_parser = named(Price::ALL, Price::name, Price::summary), default_value_t = Price::default(), hide_default_value = true, hide_possible_values = true, help_heading = "Detail", hide_short_help = true)]
    pub(crate) price: Price,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}

/// Write several levels of detail that a viewer switches between
///
/// All levels come from one simplification and share the vertices of the input. A GLB or .gltf
/// contains all levels (MSFT_lod). In a directory, each level is a separate file. Normals are not
/// rebuilt; `simplify --normals` rebuilds them for a single level. Without -o, print a report and
/// write no file. `tristrip help levels` and `tristrip help simplification` explain the details.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip chain truck.gltf -o truck.lod.glb
  tristrip chain duck.glb --ratios 100%,30%,5% -o levels/   one file per level; duck_0.glb is the finest
  tristrip chain duck.glb -o levels/ --layout list")]
pub(crate) struct ChainArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// Keep these fractions of the triangles, finest level first, up to 16 levels
    #[arg(long, value_name = "RATIOS", default_value_t = ChainRatios::default())]
    pub(crate) ratios: ChainRatios,
    #[command(flatten)]
    pub(crate) collapse: CollapseArgs,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}

/// Build a view-dependent LOD model and write it as .tlod
///
/// Build strips for the full mesh, and a merge tree of half-edge collapses. At run time, a renderer
/// applies every collapse whose image-space error is small enough; it does not rebuild strips (Skip
/// Strips). The file contains the mesh with all attributes, the strips and the collapses.
/// Verification checks that the strips draw exactly the faces of the mesh, and that the file
/// contains the same model when it is read back. Polygons are triangulated. The parts of a file
/// become one mesh, without node transformations. Attributes that some parts lack are dropped, and
/// a note reports them.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip build-lod bunny.ply -o bunny.tlod
  tristrip build-lod dragon.ply -o dragon.tlod --order shortest-edge --json
  tristrip build-lod bunny.ply -o bunny.tlod --method best:effort=5")]
pub(crate) struct BuildLodArgs {
    /// A mesh file, or - for standard input
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) from: FromArgs,
    /// Set the order in which collapses are chosen
    ///
    /// With quadric, each level takes independent collapses from the cheapest quarter, and feature
    /// vertices collapse last. With shortest-edge, each level takes as many independent collapses
    /// as possible.
    #[arg(long, value_name = "ORDER", value_parser = named(MergeOrder::ALL, MergeOrder::name, MergeOrder::summary), default_value_t = MergeOrder::default(), help_heading = "Level")]
    pub(crate) order: MergeOrder,
    /// Write this .tlod file
    #[arg(short, long, value_name = "OUTPUT", help_heading = "Output")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}
