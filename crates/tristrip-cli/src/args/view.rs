//! The flags of a view: the image of the camera, and what detail it needs.

use clap::Args;
use tristrip::lod::View;

use crate::values::{ImagePoint, ImageSize, VectorArg};

/// The image of a camera.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct LensArgs {
    /// The vertical field of view in degrees [default: 45]
    #[arg(long, visible_alias = "fov", value_name = "DEGREES", hide_default_value = true, default_value_t = View::FIELD_OF_VIEW, allow_negative_numbers = true)]
    pub(crate) field_of_view: f32,
    /// The width and height of the image in pixels [default: 1920x1080]
    #[arg(long, value_name = "SIZE", hide_default_value = true, default_value_t = ImageSize([1920, 1080]))]
    pub(crate) image: ImageSize,
}

/// What a view sees: the criteria beside the error in pixels and the triangles.
#[derive(Debug, Args)]
#[command(next_help_heading = "Detail")]
pub(crate) struct CriteriaArgs {
    /// Keep the detail outside the frustum
    #[arg(long, hide_short_help = true)]
    pub(crate) no_frustum: bool,
    /// Keep the detail of back faces, otherwise up to four times the error
    #[arg(long, hide_short_help = true)]
    pub(crate) no_back_faces: bool,
    /// Give silhouettes no extra detail, otherwise half the error
    #[arg(long, hide_short_help = true)]
    pub(crate) no_silhouettes: bool,
    /// The direction to a light: unlit faces may have twice the error
    #[arg(long, hide_short_help = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) light: Option<VectorArg>,
    /// The growth of the allowed error per degree from --attention, such as 0.2
    #[arg(long, hide_short_help = true, value_name = "GROWTH", allow_negative_numbers = true)]
    pub(crate) foveation: Option<f32>,
    /// The point of interest in fractions of the image [default: 0.5,0.5]
    #[arg(long, hide_short_help = true, value_name = "X,Y", allow_hyphen_values = true, requires = "foveation", hide_default_value = true, default_value_t = ImagePoint([0.5, 0.5]))]
    pub(crate) attention: ImagePoint,
}
