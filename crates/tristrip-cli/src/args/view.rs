//! The flags of a view: the image of the camera, and what detail it needs.

use clap::Args;
use tristrip::lod::View;

use crate::values::{ImagePoint, ImageSize, Vector};

/// The image of a camera.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct LensArgs {
    /// The vertical angle of the image in degrees
    #[arg(long, visible_alias = "fov", value_name = "DEGREES", default_value_t = View::FIELD_OF_VIEW, allow_negative_numbers = true)]
    pub(crate) field_of_view: f32,
    /// The columns and rows of the image in pixels
    #[arg(long, value_name = "SIZE", default_value_t = ImageSize([1920, 1080]))]
    pub(crate) image: ImageSize,
}

/// What a view sees: the criteria beside the error in pixels and the triangles.
#[derive(Debug, Args)]
#[command(next_help_heading = "Detail")]
pub(crate) struct CriteriaArgs {
    /// Keep the detail outside of the image
    #[arg(long)]
    pub(crate) no_frustum: bool,
    /// Keep the detail of faces that look away, which may have four times the error otherwise
    #[arg(long)]
    pub(crate) no_back_faces: bool,
    /// Give silhouettes no more detail than other faces; they may have half of the error otherwise
    #[arg(long)]
    pub(crate) no_silhouettes: bool,
    /// The direction to a light: faces that look away from it may have twice the error
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) light: Option<Vector>,
    /// How much the allowed error grows per degree away from where somebody looks, such as 0.2
    ///
    /// At D degrees from --attention, as seen from the camera, it is 1 + GROWTH x D times as large. An eye that just resolves the pixels has a
    /// growth of about 1 per degree; without the flag and at 0, the error is the same everywhere.
    #[arg(long, value_name = "GROWTH", allow_negative_numbers = true)]
    pub(crate) foveation: Option<f32>,
    /// The point of the image at which somebody looks, in fractions of its width from the left and its height from the top
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires = "foveation", default_value_t = ImagePoint([0.5, 0.5]))]
    pub(crate) attention: ImagePoint,
}
