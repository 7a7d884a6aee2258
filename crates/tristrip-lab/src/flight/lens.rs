//! The axes of a model, and the lens of a camera.

use std::str::FromStr;

use serde::Deserialize;
use tristrip::lod::{Camera, View};

/// An axis of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Axis {
    /// The first coordinate.
    X,
    /// The second coordinate.
    Y,
    /// The third coordinate.
    Z,
}

impl Axis {
    /// All axes.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Returns the name: `x`, `y` or `z`.
    ///
    /// ```
    /// assert_eq!(tristrip_lab::flight::Axis::ALL.map(|axis| axis.name()), ["x", "y", "z"]);
    /// ```
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self as usize]
    }

    /// Returns a one-line description of the axis.
    ///
    /// ```
    /// assert_eq!(tristrip_lab::flight::Axis::Y.summary(), "The second coordinate");
    /// ```
    pub fn summary(self) -> &'static str {
        ["The first coordinate", "The second coordinate", "The third coordinate"][self as usize]
    }

    pub(super) fn direction(self) -> [f64; 3] {
        [0, 1, 2].map(|k| if k == self as usize { 1.0 } else { 0.0 })
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let axis = Self::ALL.into_iter().find(|axis| axis.name() == text);
        axis.ok_or_else(|| format!("found `{text}`, expected x, y or z"))
    }
}

/// The lens of a camera: its vertical field of view and image size.
///
/// ```
/// use tristrip_lab::flight::Lens;
/// assert_eq!(Lens::default(), Lens { field_of_view: 45.0, image: [1920, 1080] });
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lens {
    /// The vertical field of view in degrees, between 0 and 180.
    pub field_of_view: f32,
    /// The width and height of the image in pixels.
    pub image: [u32; 2],
}

impl Default for Lens {
    fn default() -> Self {
        Self { field_of_view: View::FIELD_OF_VIEW, image: [1920, 1080] }
    }
}

impl Lens {
    /// Checks the field of view and the size.
    ///
    /// # Errors
    /// The field of view is not between 0 and 180 degrees, or a size is 0.
    ///
    /// ```
    /// use tristrip_lab::flight::Lens;
    /// assert!(Lens { field_of_view: 0.0, ..Lens::default() }.check().is_err());
    /// ```
    pub fn check(self) -> Result<(), tristrip::Error> {
        self.camera([0.0; 3], [1.0; 3], Axis::Y.direction()).map(drop)
    }

    /// Returns the tangents of half of the horizontal and vertical field of view.
    pub(super) fn tangents(self) -> [f64; 2] {
        let vertical = libm::tan(f64::from(self.field_of_view).to_radians() / 2.0);
        [vertical * f64::from(self.image[0]) / f64::from(self.image[1]), vertical]
    }

    /// Returns a camera with this lens.
    pub(super) fn camera(
        self,
        eye: [f64; 3],
        look_at: [f64; 3],
        up: [f64; 3],
    ) -> Result<Camera, tristrip::Error> {
        let point = |p: [f64; 3]| p.map(|x| x as f32);
        let [columns, rows] = self.image;
        Camera::new(point(eye), point(look_at))?
            .with_up(point(up))?
            .with_field_of_view(self.field_of_view)?
            .with_image(columns, rows)
    }
}
