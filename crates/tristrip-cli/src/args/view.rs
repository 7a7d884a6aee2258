//! The flags of a view: the image of the camera, and what detail it needs.

use clap::Args;
use tristrip::lod::View;

use crate::values::{ImagePoint, ImageSize, Vector};

/// The image of a camera.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct LensArgs {
    /// The vertical field of view in degrees
    #[arg(long, visible_alias = "fov", value_name = "DEGREES", default_value_t = View::FIELD_OF_VIEW, allow_negative_numbers = true)]
    pub(crate) field_of_view: f32,
    /// The width and height of the image in pixels
    #[arg(long, value_name = "SIZE", default_value_t = ImageSize([1920, 1080]))]
    pub(crate) image: ImageSize,
}

/// What a view sees: the criteria beside the error in pixels and the triangles.
#[derive(Debug, Args)]
#[command(next_help_heading = "Detail")]
pub(crate) struct CriteriaArgs {
    /// Keep the detail outside the frustum
    #[arg(long)]
    pub(crate) no_frustum: bool,
    /// Keep the detail of back faces, which otherwise may have four times the error
    #[arg(long)]
    pub(crate) no_back_faces: bool,
    /// Give silhouettes no extra detail; otherwise they may have only half the error
    #[arg(long)]
    pub(crate) no_silhouettes: bool,
    /// The direction to a light: unlit faces may have twice the error
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) light: Option<Vector>,
    /// How much the allowed error grows per degree from the point of --attention, such as 0.2
    #[arg(long, value_name = "GROWTH", allow_negative_numbers = true)]
    pub(crate) foveation: Option<f32>,
    /// The point of the image that somebody looks at, in fractions of its width and height
    #[arg(long, value_name = "X,Y", allow_hyphen_values = true, requires = "foveation", default_value_t = ImagePoint([0.5, 0.5]))]
    pub(crate) attention: ImagePoint,
}
