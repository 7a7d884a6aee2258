//! The camera of a frame.

use crate::error::Error;
use crate::lod::level::view::View;
use crate::vector::{Point, cross, dot, sub, unit};

/// A camera: position, view direction, field of view and image size.
///
/// ```
/// use tristrip::lod::Camera;
/// let camera = Camera::new([0.0, 0.0, 3.0], [0.0; 3])?.with_field_of_view(60.0)?.with_image(1920, 1080)?;
/// assert_eq!(camera.eye(), [0.0, 0.0, 3.0]);
/// assert!(Camera::new([0.0; 3], [0.0; 3]).is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: [f32; 3],
    look_at: [f32; 3],
    up: [f32; 3],
    field_of_view: f32,
    columns: u32,
    rows: u32,
}

impl Camera {
    /// Creates a camera at `eye` that looks at the point `look_at`, both in mesh units. The up
    /// direction is y, the vertical field of view is 45 degrees, and the image has 1920 by 1080
    /// pixels.
    ///
    /// # Errors
    /// A coordinate is not finite, or the points are equal.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// assert!(Camera::new([f32::NAN, 0.0, 0.0], [0.0; 3]).is_err());
    /// // Straight down: another axis becomes the up direction.
    /// assert!(Camera::new([0.0, 5.0, 0.0], [0.0; 3]).is_ok());
    /// ```
    pub fn new(eye: [f32; 3], look_at: [f32; 3]) -> Result<Self, Error> {
        for (name, point) in [("eye", eye), ("look_at", look_at)] {
            check_finite(name, point)?;
        }
        if eye.iter().zip(look_at).all(|(&a, b)| a.total_cmp(&b).is_eq() || a - b == 0.0) {
            let found = format!("{eye:?}, the position of the camera");
            return Err(Error::Parameter { name: "look_at", found, expected: "another point" });
        }
        let field_of_view = View::FIELD_OF_VIEW;
        Ok(Self { eye, look_at, up: [0.0, 1.0, 0.0], field_of_view, columns: 1920, rows: 1080 })
    }

    /// Sets the up direction of the image. If it is parallel to the view direction, the coordinate
    /// axis least parallel to the view direction is used instead.
    ///
    /// # Errors
    /// A coordinate is not finite, or all are 0.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// let camera = Camera::new([5.0, 0.0, 0.0], [0.0; 3])?;
    /// assert!(camera.with_up([0.0, 0.0, 1.0]).is_ok() && camera.with_up([0.0; 3]).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_up(mut self, up: [f32; 3]) -> Result<Self, Error> {
        check_finite("up", up)?;
        if up.iter().all(|&x| x == 0.0) {
            let found = format!("{up:?}");
            return Err(Error::Parameter { name: "up", found, expected: "a direction" });
        }
        self.up = up;
        Ok(self)
    }

    /// Sets the vertical field of view in degrees.
    ///
    /// # Errors
    /// The angle is not between 0 and 180 degrees.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// let camera = Camera::new([5.0, 0.0, 0.0], [0.0; 3])?;
    /// assert!(camera.with_field_of_view(0.0).is_err() && camera.with_field_of_view(f32::NAN).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_field_of_view(mut self, degrees: f32) -> Result<Self, Error> {
        if !(degrees > 0.0 && degrees < 180.0) {
            let expected = "an angle between 0 and 180 degrees";
            return Err(Error::Parameter { name: "field_of_view", found: degrees.to_string(), expected });
        }
        self.field_of_view = degrees;
        Ok(self)
    }

    /// Sets the width and the height of the image in pixels.
    ///
    /// # Errors
    /// The width or the height is 0.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// assert!(Camera::new([5.0, 0.0, 0.0], [0.0; 3])?.with_image(0, 480).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_image(mut self, columns: u32, rows: u32) -> Result<Self, Error> {
        if columns == 0 || rows == 0 {
            let found = format!("{columns} by {rows}");
            return Err(Error::Parameter { name: "image", found, expected: "at least 1 by 1" });
        }
        (self.columns, self.rows) = (columns, rows);
        Ok(self)
    }

    /// Returns the position of the camera in mesh units.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// assert_eq!(Camera::new([5.0, 0.0, 0.0], [0.0; 3])?.eye(), [5.0, 0.0, 0.0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn eye(&self) -> [f32; 3] {
        self.eye
    }

    /// Returns the point that the camera looks at, in mesh units.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// assert_eq!(Camera::new([5.0, 0.0, 0.0], [1.0; 3])?.look_at(), [1.0; 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn look_at(&self) -> [f32; 3] {
        self.look_at
    }

    /// Returns the up direction of the image.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// assert_eq!(Camera::new([5.0, 0.0, 0.0], [0.0; 3])?.up(), [0.0, 1.0, 0.0]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn up(&self) -> [f32; 3] {
        self.up
    }

    /// Returns the vertical field of view in degrees.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// assert_eq!(Camera::new([5.0, 0.0, 0.0], [0.0; 3])?.field_of_view(), 45.0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn field_of_view(&self) -> f32 {
        self.field_of_view
    }

    /// Returns the width and the height of the image in pixels.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// assert_eq!(Camera::new([5.0, 0.0, 0.0], [0.0; 3])?.image(), [1920, 1080]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn image(&self) -> [u32; 2] {
        [self.columns, self.rows]
    }

    /// Returns the right, up and forward directions of the camera as unit vectors.
    ///
    /// ```
    /// use tristrip::lod::Camera;
    /// let [right, up, forward] = Camera::new([0.0, 0.0, 3.0], [0.0; 3])?.axes();
    /// assert_eq!((right[0], up[1], forward[2]), (1.0, 1.0, -1.0));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn axes(&self) -> [[f64; 3]; 3] {
        let forward = unit(sub(self.look_at.map(f64::from), self.eye.map(f64::from)));
        let up = self.up.map(f64::from);
        // The length of the direction does not matter.
        let largest = up.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let right = cross(forward, up.map(|x| x / largest));
        let least = (0..3).min_by(|&a, &b| forward[a].abs().total_cmp(&forward[b].abs())).unwrap_or(0);
        let axis = [0, 1, 2].map(|k| if k == least { 1.0 } else { 0.0 });
        let is_along = dot(right, right) < 1e-12;
        let right = unit(if is_along { cross(forward, axis) } else { right });
        [right, cross(right, forward), forward]
    }

    /// Returns the camera in the form that the criteria use.
    pub(super) fn frame(&self) -> CameraFrame {
        let eye = self.eye.map(f64::from);
        let [right, up, forward] = self.axes();
        let half_height = libm::tan(f64::from(self.field_of_view).to_radians() / 2.0);
        let half_width = half_height * f64::from(self.columns) / f64::from(self.rows);
        // The inward normals of the sides of the frustum.
        let side = |half: f64, across: Point, sign: f64| {
            unit([0, 1, 2].map(|k| half * forward[k] + sign * across[k]))
        };
        CameraFrame {
            eye,
            planes: [
                side(half_width, right, 1.0),
                side(half_width, right, -1.0),
                side(half_height, up, 1.0),
                side(half_height, up, -1.0),
                forward,
            ],
            edges: [right.map(|x| half_width * x), up.map(|x| half_height * x)],
            pixels_per_slope: f64::from(self.rows) / (2.0 * half_height),
        }
    }
}

/// A camera in the form that the criteria use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CameraFrame {
    pub(super) eye: Point,
    /// The inward normals of the planes through the eye that bound the visible region: four sides,
    /// and the view direction.
    pub(super) planes: [Point; 5],
    /// The vectors from the image center to its right and its upper edge, at distance 1.
    pub(super) edges: [Point; 2],
    /// The number of pixels that a length of 1 covers at distance 1.
    pub(super) pixels_per_slope: f64,
}

impl CameraFrame {
    /// Returns the largest distance between the eye and a point of a sphere.
    pub(super) fn farthest(&self, (center, radius): (Point, f64)) -> f64 {
        let away = sub(self.eye, center);
        dot(away, away).sqrt() + radius
    }

    /// Returns the distance that the eye moved, and the largest change of the distance between a
    /// point of the sphere and a frustum plane.
    pub(super) fn motion_from(&self, before: &Self, (center, radius): (Point, f64)) -> [f64; 2] {
        let length = |a: Point| dot(a, a).sqrt();
        let planes = self.planes.iter().zip(&before.planes).map(|(&now, &then)| {
            let of_center = dot(now, sub(center, self.eye)) - dot(then, sub(center, before.eye));
            of_center.abs() + length(sub(now, then)) * radius
        });
        [length(sub(self.eye, before.eye)), planes.fold(0.0, f64::max)]
    }
}

fn check_finite(name: &'static str, point: [f32; 3]) -> Result<(), Error> {
    if point.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(Error::Parameter { name, found: format!("{point:?}"), expected: "finite numbers" })
}
