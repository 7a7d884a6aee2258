//! The flags of a view: the image of the camera, and the detail criteria.

use clap::Args;
use tristrip::lod::View;

use crate::values::{ImagePoint, ImageSize, VectorArg};

/// The image of a camera.
#[derive(Debug, Args)]
#[command(next_help_heading = "Camera")]
pub(crate) struct LensArgs {
    /// Set the vertical view angle in degrees [default: 45]
    #[arg(long, visible_alias = "fov", value_name = "DEGREES", hide_default_value = true, default_value_t = View::FIELD_OF_VIEW, allow_negative_numbers = true)]
    pub(crate) field_of_view: f32,
    /// Set the image width and height in pixels [default: 1920x1080]
    #[arg(long, value_name = "SIZE", hide_default_value = true, default_value_t = ImageSize([1920, 1080]))]
    pub(crate) image: ImageSize,
}

/// The detail criteria of a view, in addition to the error in pixels and the triangle budget.
#[derive(Debug, Args)]
#[command(next_help_heading = "Detail")]
pub(crate) struct CriteriaArgs {
    /// Do not reduce detail outside the frustum
    #[arg(long, hide_short_help = true)]
    pub(crate) no_frustum: bool,
    /// Do not allow four times the error on back faces
    #[arg(long, hide_short_help = true)]
    pub(crate) no_back_faces: bool,
    /// Do not halve the allowed error at silhouettes
    #[arg(long, hide_short_help = true)]
    pub(crate) no_silhouettes: bool,
    /// Set the direction to a light; faces turned away from it may have twice the error
    #[arg(long, hide_short_help = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub(crate) light: Option<VectorArg>,
    /// Set how much the allowed error grows per degree from --attention, such as 0.2
    #[arg(long, hide_short_help = true, value_name = "GROWTH", allow_negative_numbers = true)]
    pub(crate) foveation: Option<f32>,
    /// Set the point of interest, in fractions of the image [default: 0.5,0.5]
    #[arg(long, hide_short_help = true, value_name = "X,Y", allow_hyphen_values = true, requires = "foveation", hide_default_value = true, default_value_t = ImagePoint([0.5, 0.5]))]
    pub(crate) attention: ImagePoint,
}
