//! The flags of simplification and levels of detail.

use std::path::PathBuf;

use clap::Args;
use tristrip::Effort;
use tristrip::lod::{ModelKind, View};
use tristrip::simplify::{MergeOrder, Price};
use tristrip_pipeline::{ChainRatios, Deviation, DisplayFilter, Level, Normals, Ratio};

use super::groups::{CollapseArgs, FromArgs, GeneralArgs, OutputArgs, TargetArgs};
use super::view::{CriteriaArgs, LensArgs};
use crate::method::MethodArgs;
use crate::values::{Amount, Vector, effort_parser, named};

/// Simplify a mesh by half-edge collapses
///
/// The surface keeps its holes and, as far as the goal allows, its shape. All parts of a scene are simplified together. If a goal cannot be
/// reached within the error limit, or without tearing or folding the surface, simplification stops earlier and prints a warning. Without -o,
/// only report. `tristrip help simplification` explains all options in detail.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip simplify bunny.ply --ratio 5% -o bunny-small.ply
  tristrip simplify bunny.ply --triangles 2000 -o bunny-small.glb
  tristrip simplify bunny.ply --ratio 5% --fit -o bunny-small.ply   a third closer to the input
  tristrip simplify scene.glb --error 0.1% -o light.glb   as few as this error allows
  tristrip simplify duck.glb --ratio 20% --picture before-after.png
  tristrip simplify bunny.ply --ratio 0.05 --error 1% --json")]
pub(crate) struct SimplifyArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// The ratio of all triangles to keep: 0.05 or 5%
    ///
    /// All parts of a model share the triangles. Without --ratio or --triangles, simplify as far as --error allows; with one of them,
    /// simplification ends at whichever limit is reached first.
    #[arg(long, value_name = "RATIO", conflicts_with = "triangles", allow_negative_numbers = true)]
    pub(crate) ratio: Option<Ratio>,
    /// The number of triangles to keep
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) triangles: Option<usize>,
    #[command(flatten)]
    pub(crate) collapse: CollapseArgs,
    /// Whether normals are kept or rebuilt
    #[arg(long, value_name = "MODE", value_parser = named(Normals::ALL, Normals::name, Normals::summary), default_value_t = Normals::default())]
    pub(crate) normals: Normals,
    /// Move the remaining vertices closer to the original surface
    ///
    /// The root mean square of the distances falls by a third or more. The result has vertices that the input does not have.
    #[arg(long)]
    pub(crate) fit: bool,
    /// Round joint weights to 8 bits and rotations of animations to 16 bits in a GLB or .gltf
    #[arg(long)]
    pub(crate) compact: bool,
    #[command(flatten)]
    pub(crate) target: TargetArgs,
    /// Draw the model before and after in a PNG file, from eight sides
    ///
    /// The upper row shows the input, the lower row the result, in eight views of 256 x 256 pixels with base colours and textures. A scene is
    /// drawn as its nodes place it, without animations and joints. One input.
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) picture: Option<PathBuf>,
}

/// Draw any level of detail with the strips of the full mesh
///
/// Strips are built once, for the full mesh. Half-edge collapses, the cheapest first, rename vertices in them down to a base mesh. Level 0
/// is the base mesh, the highest level is the full mesh, and each level adds one vertex. A filter removes degenerate triangles
/// before a level is drawn. The level is proven to draw exactly the triangles that remain after the collapses. Without -o, only report.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip lod bunny.ply --level 40% -o level.glb     strips at any level
  tristrip lod bunny.ply --method stripe --base 1% --filter dtfs --level 120
  tristrip lod bunny.ply --model sets --level 25% -o level.glb
  tristrip lod bunny.ply --model blocks --pixels 1.5 --distance 3     the level for a viewing distance
  tristrip lod dragon.ply --model skip --camera 0,0,3 --look-at 0,0,0 --fov 45 --pixels 1.5 -o frame.glb
  tristrip lod dragon.ply --model skip --camera 0,0,3 --look-at 0,0,0 --triangles 200k
")]
#[command(
    mut_arg("field_of_view", |flag| flag.requires("viewpoint")),
    mut_arg("image", |flag| flag.requires("camera")),
    mut_group("CriteriaArgs", |flags| flags.requires("camera"))
)]
pub(crate) struct LodArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// How levels are stored and replayed
    ///
    /// All models have the same levels. Those that store strips by themselves are drawn as they are; --filter belongs to the others.
    #[arg(long, value_parser = named(ModelKind::ALL, ModelKind::name, ModelKind::summary), value_name = "MODEL", default_value_t = ModelKind::default(), help_heading = "Levels")]
    pub(crate) model: ModelKind,
    /// The ratio of all triangles that the base mesh keeps: 0.05 or 5% [default: 5%; 0 with --triangles, --error or --pixels]
    ///
    /// If the surface cannot be simplified this far without tearing or folding, the base mesh has more triangles, and a note says so unless
    /// the ratio is 0.
    #[arg(long, value_name = "RATIO", help_heading = "Levels", allow_negative_numbers = true)]
    pub(crate) base: Option<Ratio>,
    /// The level to draw: the number of undone collapses, or a percentage of all collapses such as 40% [default: 10%]
    ///
    /// P% of n collapses is level P n / 100, rounded to the nearest integer. In a model of several parts, the levels undo the collapses
    /// of all parts, the greatest cost first. 0 is the base mesh, 100% the full mesh. Instead of --level, --triangles, --error or
    /// --pixels select one.
    #[arg(
        long,
        value_name = "LEVEL",
        help_heading = "Levels",
        allow_negative_numbers = true,
        conflicts_with_all = ["triangles", "error", "pixels"],
    )]
    pub(crate) level: Option<Level>,
    /// Draw the finest level with at most this number of triangles, such as 50000, 200k or 2M
    ///
    /// With --camera, the most triangles of the view: if --pixels needs more, the largest errors in pixels are reduced first. The base mesh may
    /// have more.
    #[arg(
        long,
        value_name = "COUNT",
        help_heading = "Levels",
        allow_negative_numbers = true,
        conflicts_with = "error"
    )]
    pub(crate) triangles: Option<Amount>,
    /// Draw the coarsest level whose surface error covers at most this number of pixels, seen from --distance
    ///
    /// With --camera, each collapse may have this error where the camera sees it [default: 1].
    #[arg(
        long,
        value_name = "PIXELS",
        help_heading = "Levels",
        allow_negative_numbers = true,
        conflicts_with = "error",
        requires = "viewpoint"
    )]
    pub(crate) pixels: Option<f32>,
    /// The distance from the camera to the nearest point of the model, in mesh units
    #[arg(
        long,
        value_name = "DISTANCE",
        help_heading = "Levels",
        allow_negative_numbers = true,
        requires = "pixels",
        group = "viewpoint"
    )]
    pub(crate) distance: Option<f32>,
    /// The rows of the image
    #[arg(
        long,
        value_name = "ROWS",
        default_value_t = View::ROWS,
        help_heading = "Levels",
        allow_negative_numbers = true,
        requires = "pixels"
    )]
    pub(crate) rows: f32,
    /// With --model skip, draw what a camera at this point sees, each place in its own detail
    ///
    /// Coarse are the places far away, outside of the image and on faces that look away. The point is in the coordinates of the scene: a part
    /// that one node places is seen there. A part in several places, or one that a node stretches, is drawn in full, with a note.
    #[arg(
        long,
        value_name = "X,Y,Z",
        help_heading = "Camera",
        allow_hyphen_values = true,
        requires = "look_at",
        group = "viewpoint",
        conflicts_with_all = ["level", "error", "rows"],
    )]
    pub(crate) camera: Option<Vector>,
    /// The point that the camera looks at
    #[arg(
        long,
        value_name = "X,Y,Z",
        help_heading = "Camera",
        allow_hyphen_values = true,
        requires = "camera"
    )]
    pub(crate) look_at: Option<Vector>,
    /// The direction that is up in the image
    #[arg(long, value_name = "X,Y,Z", help_heading = "Camera", allow_hyphen_values = true, requires = "camera", default_value_t = Vector([0.0, 1.0, 0.0]))]
    pub(crate) up: Vector,
    #[command(flatten)]
    pub(crate) lens: LensArgs,
    #[command(flatten)]
    pub(crate) criteria: CriteriaArgs,
    /// How the strips of --model progressive and naive are filtered before they are drawn [default: repair]
    #[arg(long, value_parser = named(DisplayFilter::ALL, DisplayFilter::name, DisplayFilter::summary), value_name = "FILTER", help_heading = "Levels")]
    pub(crate) filter: Option<DisplayFilter>,
    /// The search effort of --filter repair, from 0 to 9 [default: 5]
    #[arg(long, value_name = "LEVEL", value_parser = effort_parser(), help_heading = "Levels")]
    pub(crate) filter_effort: Option<Effort>,
    /// Draw the coarsest level whose surface error is at most this: in mesh units, or in % of the bounding-box diagonal
    #[arg(long, value_name = "ERROR", help_heading = "Levels", allow_negative_numbers = true)]
    pub(crate) error: Option<Deviation>,
    /// What a collapse costs
    #[arg(long, value_name = "PRICE", value_parser = named(Price::ALL, Price::name, Price::summary), default_value_t = Price::default(), help_heading = "Levels")]
    pub(crate) price: Price,
    #[command(flatten)]
    pub(crate) output: OutputArgs,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}

/// Write several levels of detail for a viewer to switch between
///
/// All levels come from one simplification and share the vertices of the input. A GLB or .gltf holds all of them (MSFT_lod); in a directory, each
/// level is a file of its own. Normals are kept: `simplify --normals` rebuilds them for a single level. Without -o, only report. `tristrip help
/// levels` and `tristrip help simplification` explain the details.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip chain truck.gltf -o truck.lod.glb
  tristrip chain duck.glb --ratios 100%,30%,5% -o levels/   one file per level: levels/duck_0.glb is the finest
  tristrip chain duck.glb -o levels/ --layout list")]
pub(crate) struct ChainArgs {
    #[command(flatten)]
    pub(crate) general: GeneralArgs,
    /// The ratios of all triangles that the levels keep, the finest first, up to 16
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
/// Strips are built for the full mesh, and half-edge collapses are organized in levels. For each frame, a program applies the collapses whose error
/// its camera cannot see, without building strips again (Skip Strips). The file holds the mesh with all attributes, the strips and the collapses.
/// The strips are proven to draw exactly the faces of the mesh, and the file is read back and compared. Polygons become triangles. The parts of a
/// file become one mesh, without the transformations of their nodes; attributes that not all parts have are dropped with a note.
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
    /// The order in which collapses are chosen
    ///
    /// By quadric, the cheaper half of the possible collapses makes a level, so the vertices of features go last. By shortest edge, each level has
    /// as many independent collapses as possible.
    #[arg(long, value_name = "ORDER", value_parser = named(MergeOrder::ALL, MergeOrder::name, MergeOrder::summary), default_value_t = MergeOrder::default(), help_heading = "Levels")]
    pub(crate) order: MergeOrder,
    /// The .tlod file to write
    #[arg(short, long, value_name = "OUTPUT", help_heading = "Output")]
    pub(crate) output: PathBuf,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}
