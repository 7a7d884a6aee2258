//! The detail criteria of a view.

use tristrip::lod::{Foveation, ViewCriteria};

use super::checks::of_flag;
use crate::args::CriteriaArgs;
use crate::values::{Amount as Count, VectorArg};

/// Checks the allowed error in pixels.
pub(super) fn checked_pixels(pixels: f32) -> Result<f32, String> {
    if pixels.is_finite() && pixels >= 0.0 {
        return Ok(pixels);
    }
    Err(format!("--pixels: found {pixels}, expected a finite number of at least 0"))
}

/// Builds the detail criteria of a view, without a step limit.
pub(super) fn view_criteria(
    pixels: f32,
    triangles: Option<Count>,
    args: &CriteriaArgs,
) -> Result<ViewCriteria, String> {
    let mut criteria = ViewCriteria::default()
        .with_pixels(checked_pixels(pixels)?)
        .with_frustum(!args.no_frustum)
        .with_back_faces(!args.no_back_faces)
        .with_silhouettes(!args.no_silhouettes);
    if let Some(Count(most)) = triangles {
        criteria = criteria.with_budget(most);
    }
    if let Some(VectorArg(direction)) = args.light {
        criteria = criteria.with_light(direction);
    }
    if let Some(growth) = args.foveation {
        let foveation = Foveation::new(growth)
            .map_err(|_| format!("--foveation: found {growth}, expected a finite number of at least 0"))?
            .with_attention(args.attention.0)
            .map_err(|error| of_flag(&error))?;
        criteria = criteria.with_foveation(foveation);
    }
    criteria.check().map_err(|error| of_flag(&error))?;
    Ok(criteria)
}
