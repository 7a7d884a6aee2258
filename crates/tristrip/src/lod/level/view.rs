//! The projected size of lengths: converts between mesh units and pixels.

use crate::error::Error;

/// The scale at which a view shows an object, in pixels per mesh unit.
///
/// ```
/// use tristrip::lod::View;
/// // An image 1080 pixels high with a field of view of 90 degrees, at a distance of 540 mesh
/// // units: one pixel covers one unit.
/// assert_eq!(View::perspective(540.0, 1.0, 1080.0)?.length_of(2.0), 2.0);
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Pixels per mesh unit.
    scale: f32,
}

impl View {
    /// The default vertical field of view in degrees.
    pub const FIELD_OF_VIEW: f32 = 45.0;

    /// The default image height in pixels.
    pub const ROWS: f32 = 1080.0;

    /// Creates a perspective view.
    ///
    /// - `distance`: distance from the eye to the nearest point of the object, in mesh units.
    /// - `vertical_scale`: the element in row 2, column 2 of the projection matrix. It is 1 /
    ///   tan(fov / 2), where fov is the vertical field of view.
    /// - `rows`: image height in pixels.
    ///
    /// # Errors
    /// A value is not positive or not finite, or the resulting scale is zero or infinite. An object
    /// at or behind the eye has no valid distance: draw its full mesh.
    ///
    /// ```
    /// use tristrip::lod::View;
    /// let pixel_at = |distance| View::perspective(distance, 1.0, 1000.0).map(|view| view.length_of(1.0));
    /// assert_eq!((pixel_at(500.0)?, pixel_at(1000.0)?), (1.0, 2.0));
    /// // Behind the eye.
    /// assert!(pixel_at(-1.0).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn perspective(distance: f32, vertical_scale: f32, rows: f32) -> Result<Self, Error> {
        for (name, value) in [("distance", distance), ("vertical_scale", vertical_scale), ("rows", rows)] {
            check_positive(name, value)?;
        }
        let scale = vertical_scale * rows / (2.0 * distance);
        check_positive("pixels_per_unit", scale)?;
        Ok(Self { scale })
    }

    /// Creates a perspective view from the distance to the nearest point of the object in mesh
    /// units, the vertical field of view in degrees, and the image height in pixels. Typical values
    /// are [`View::FIELD_OF_VIEW`] and [`View::ROWS`].
    ///
    /// # Errors
    /// The angle is not between 0 and 180 degrees, the distance or the height is not positive, or
    /// the resulting scale is zero or infinite.
    ///
    /// ```
    /// use tristrip::lod::View;
    /// // With a field of view of 90 degrees, the visible height is twice the distance.
    /// assert_eq!(View::of_camera(500.0, 90.0, 1000.0)?.length_of(1.0), 1.0);
    /// assert!(View::of_camera(500.0, 180.0, 1000.0).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_camera(distance: f32, degrees: f32, rows: f32) -> Result<Self, Error> {
        if !(degrees > 0.0 && degrees < 180.0) {
            let expected = "an angle between 0 and 180 degrees";
            return Err(Error::Parameter { name: "field_of_view", found: degrees.to_string(), expected });
        }
        let vertical_scale = 1.0 / libm::tan(f64::from(degrees).to_radians() / 2.0);
        Self::perspective(distance, vertical_scale as f32, rows)
    }

    /// Creates a parallel (orthographic) view from its scale in pixels per mesh unit.
    ///
    /// # Errors
    /// The scale is not positive or not finite.
    ///
    /// ```
    /// assert_eq!(tristrip::lod::View::parallel(4.0)?.length_of(1.0), 0.25);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn parallel(pixels_per_unit: f32) -> Result<Self, Error> {
        check_positive("pixels_per_unit", pixels_per_unit)?;
        Ok(Self { scale: pixels_per_unit })
    }

    /// Returns the number of pixels that a length in mesh units covers.
    ///
    /// ```
    /// assert_eq!(tristrip::lod::View::parallel(2.0)?.pixels_of(1.5), 3.0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn pixels_of(self, length: f32) -> f32 {
        length * self.scale
    }

    /// Returns the length in mesh units that covers a number of pixels.
    ///
    /// ```
    /// assert_eq!(tristrip::lod::View::parallel(2.0)?.length_of(3.0), 1.5);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn length_of(self, pixels: f32) -> f32 {
        pixels / self.scale
    }
}

fn check_positive(name: &'static str, value: f32) -> Result<(), Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::Parameter { name, found: value.to_string(), expected: "a positive number" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_without_a_size_are_refused() {
        assert!(View::perspective(0.0, 1.0, 1.0).is_err());
        assert!(View::perspective(1.0, f32::NAN, 1.0).is_err());
        assert!(View::parallel(-1.0).is_err() && View::parallel(f32::INFINITY).is_err());
    }

    #[test]
    fn angles_without_an_image_are_refused() {
        for degrees in [0.0, -1.0, 180.0, f32::NAN, f32::INFINITY] {
            assert!(View::of_camera(1.0, degrees, 1.0).is_err(), "{degrees}");
        }
        let view = View::of_camera(1.0, View::FIELD_OF_VIEW, View::ROWS).unwrap();
        // The scale is 540 rows divided by the tangent of half the angle, √2 − 1.
        assert!((view.pixels_of(1.0) - 540.0 / (2.0_f32.sqrt() - 1.0)).abs() < 1e-3);
    }
}
