//! The flags of flights.

use std::num::NonZeroU32;
use std::path::PathBuf;

use clap::Args;
use tristrip::lod::Filter;
use tristrip_lab::flight::Axis;

use super::groups::FromArgs;
use super::view::{CriteriaArgs, LensArgs};
use crate::method::MethodArgs;
use crate::values::{Amount, named};

/// Fly a camera over a model with view-dependent detail, and measure each frame
///
/// Build strips once for the full mesh, and a tree of collapses. In each frame the camera decides which vertices collapse: more far away,
/// outside of the image and on faces that look away. Only the strips change in which such a vertex is. The report has the
/// triangles, the vertices sent, what changed, and the time of each update. The display strips of up to 20 frames are proven
/// to draw exactly the triangles of the view.
///
/// The parts of a file become one mesh. Each is where its coordinates are, without the transformations of nodes.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip fly bunny.ply                                     one turn around the model
  tristrip fly bunny.ply --frames 600 --pixels 2 --report bunny.md --plot bunny.svg
  tristrip fly terrain.ply --path flyover --triangles 200k
  tristrip fly dragon.ply --path dolly --filter linked --json
  tristrip fly terrain.ply --path flyover --foveation 0.2 --attention 0.5,0.7
  tristrip fly bunny.ply --path cameras.json --image 960x540 --video frames/")]
pub(crate) struct FlyArgs {
    /// The mesh file, a .tlod file of build-lod, or - for a mesh on standard input
    #[arg(value_name = "INPUT")]
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) from: FromArgs,
    /// The path of the camera: orbit, dolly, flyover, or a JSON file of cameras
    ///
    /// orbit is one turn around the vertical axis, at a distance at which the model fills the image. dolly goes straight towards the model, from far
    /// away until close to it. flyover goes low over it along the longest side of its bounding box, for terrains. A file is an array of cameras,
    /// `[{"eye": [0, 0, 9], "look_at": [0, 0, 0], "up": [0, 1, 0], "field_of_view": 45}]` in mesh units and degrees, between
    /// which the frames are interpolated linearly; up and the angle may be left out.
    #[arg(long, value_name = "PATH", default_value = "orbit", help_heading = "Flight")]
    pub(crate) path: PathBuf,
    /// The number of frames, up to 100000
    #[arg(
        long,
        value_name = "N",
        default_value_t = 300,
        help_heading = "Flight",
        allow_negative_numbers = true
    )]
    pub(crate) frames: usize,
    /// The vertical axis of orbit, dolly and flyover [default: y; for flyover, the shortest side of the bounding box]
    #[arg(long, value_name = "AXIS", value_parser = named(Axis::ALL, Axis::name, Axis::summary), help_heading = "Flight")]
    pub(crate) up: Option<Axis>,
    #[command(flatten)]
    pub(crate) lens: LensArgs,
    /// The error that a collapse may have in the image, in pixels
    #[arg(
        long,
        value_name = "PIXELS",
        default_value_t = 1.0,
        help_heading = "Detail",
        allow_negative_numbers = true
    )]
    pub(crate) pixels: f32,
    #[command(flatten)]
    pub(crate) criteria: CriteriaArgs,
    /// How the strips are filtered before they are drawn
    #[arg(long, value_parser = named(Filter::ALL, Filter::name, Filter::summary), value_name = "FILTER", default_value_t = Filter::Dtfs, help_heading = "Detail")]
    pub(crate) filter: Filter,
    /// The most triangles of a frame, such as 50000, 200k or 2M
    ///
    /// If the error needs more, the largest errors in pixels are reduced first. The base mesh may have more.
    #[arg(long, value_name = "COUNT", help_heading = "Detail")]
    pub(crate) triangles: Option<Amount>,
    /// The most collapses and splits of a frame; what is left is done in the next one [default: no limit]
    #[arg(long, value_name = "N", help_heading = "Detail")]
    pub(crate) steps: Option<Amount>,
    /// Write the report of all frames as a Markdown page
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) report: Option<PathBuf>,
    /// Plot triangles, vertices sent and milliseconds per frame in an SVG file
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    pub(crate) plot: Option<PathBuf>,
    /// Draw frames as PNG files 0000.png, 0001.png … in a directory, one colour per strip
    ///
    /// The directory is created if it does not exist, and files of these names are replaced. Colours are chosen per frame.
    #[arg(long, value_name = "DIRECTORY", help_heading = "Output")]
    pub(crate) video: Option<PathBuf>,
    /// Draw one frame of every K [default: so that at most 60 are drawn]
    #[arg(long, value_name = "K", requires = "video", help_heading = "Output")]
    pub(crate) video_every: Option<NonZeroU32>,
    /// Draw the surface in grey, without the colours of strips
    #[arg(long, requires = "video", help_heading = "Output")]
    pub(crate) shaded: bool,
    /// Skip verification
    #[arg(long, help_heading = "Output")]
    pub(crate) no_verify: bool,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}
