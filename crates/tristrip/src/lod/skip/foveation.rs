//! Foveation: less detail away from the point of the image that the user looks at.
//!
//! The smallest angle that the eye resolves grows about linearly with the angle from the gaze
//! direction. The allowed error of a view grows in the same way:
//!
//! ```text
//! allowed error = pixels × tolerance × (1 + growth × degrees)
//! ```
//! The degrees are measured at the eye, between the gaze direction and the nearest point of the
//! sphere of a collapse.
//!
//! # Travel
//! Let d be the distance of the sphere, θ its angle in radians, G the growth per radian and
//! f = 1 + Gθ. A collapse is allowed if d f is at least the distance n that its error needs.
//!
//! - Moving the eye by dw changes d by at most dw, and θ by at most dw / d.
//! - Turning the gaze by dρ changes θ by at most dρ. A turn counts as the travel of the farthest
//!   point, which is at least d dρ.
//!
//! A travel of dt then changes d f by at most (f + G) dt. Within a travel t = s d, θ grows by at
//! most ∫ dt / (d − t) ≤ ln 1/(1 − s). Therefore d f changes by at most
//! (f + (1 + ln 1/(1 − s)) G) t, with the initial f.
//!
//! # References
//! Guenter, Finch, Drucker, Tan, Snyder: *Foveated 3D Graphics*, 2012.

use std::f64::consts::{LN_2, PI};

use super::camera::CameraFrame;
use crate::error::Error;
use crate::vector::{Point, cross, dot, sub, unit};

/// The natural logarithm of 8/7, rounded up.
const LN_8_7: f64 = 0.133_531_5;

/// The growth of the allowed error away from the point of the image that the user looks at.
///
/// ```
/// use tristrip::lod::{Foveation, ViewCriteria};
/// // Ten degrees from the image center, 1 + 0.2 × 10 = 3 times the error is allowed.
/// let foveation = Foveation::new(0.2)?;
/// // The user looks at the upper left.
/// let criteria = ViewCriteria::default().with_pixels(1.0).with_foveation(foveation.with_attention([0.25, 0.25])?);
/// assert_eq!(criteria.foveation.map(|foveation| foveation.attention()), Some([0.25, 0.25]));
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foveation {
    growth: f32,
    attention: [f32; 2],
}

impl Foveation {
    /// Creates a foveation around the image center: `degrees` away from the center, the allowed
    /// error is multiplied by 1 + `growth` × `degrees`. For a viewer who can just resolve single
    /// pixels, the growth is about 1 per degree. A growth of 0 disables foveation.
    ///
    /// # Errors
    /// The growth is negative or not finite.
    ///
    /// ```
    /// use tristrip::lod::Foveation;
    /// assert_eq!(Foveation::new(0.5)?.growth(), 0.5);
    /// assert!(Foveation::new(-0.5).is_err() && Foveation::new(f32::INFINITY).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(growth: f32) -> Result<Self, Error> {
        if !(growth.is_finite() && growth >= 0.0) {
            let expected = "a finite number of at least 0";
            return Err(Error::Parameter { name: "growth", found: growth.to_string(), expected });
        }
        Ok(Self { growth, attention: [0.5; 2] })
    }

    /// Sets the point of the image that the user looks at, as fractions of the width from the left
    /// and of the height from the top.
    ///
    /// # Errors
    /// A fraction is not between 0 and 1.
    ///
    /// ```
    /// use tristrip::lod::Foveation;
    /// assert!(Foveation::new(0.5)?.with_attention([0.0, 1.0]).is_ok());
    /// assert!(Foveation::new(0.5)?.with_attention([0.5, f32::NAN]).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn with_attention(mut self, attention: [f32; 2]) -> Result<Self, Error> {
        if !attention.iter().all(|x| (0.0..=1.0).contains(x)) {
            let (found, expected) = (format!("{attention:?}"), "fractions from 0 to 1");
            return Err(Error::Parameter { name: "attention", found, expected });
        }
        self.attention = attention;
        Ok(self)
    }

    /// Returns the growth of the allowed error per degree.
    ///
    /// ```
    /// assert_eq!(tristrip::lod::Foveation::new(0.25)?.growth(), 0.25);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn growth(&self) -> f32 {
        self.growth
    }

    /// Returns the point of the image that the user looks at, as fractions of the width from the
    /// left and of the height from the top.
    ///
    /// ```
    /// assert_eq!(tristrip::lod::Foveation::new(0.25)?.attention(), [0.5, 0.5]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn attention(&self) -> [f32; 2] {
        self.attention
    }
}

/// The foveation of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gaze {
    /// The gaze direction, as a unit vector.
    direction: Point,
    /// The growth of the allowed error per radian.
    growth: f64,
}

impl Gaze {
    /// Returns the foveation of a frame, or `None` if the growth is 0.
    pub(super) fn new(foveation: Foveation, frame: &CameraFrame) -> Option<Self> {
        let [right, up] = frame.edges;
        let forward = frame.planes[4];
        let [x, y] = foveation.attention.map(f64::from);
        let direction =
            unit([0, 1, 2].map(|k| forward[k] + (2.0 * x - 1.0) * right[k] + (1.0 - 2.0 * y) * up[k]));
        let growth = f64::from(foveation.growth).to_degrees();
        (growth > 0.0).then_some(Self { direction, growth })
    }

    /// Returns the largest factor on the allowed error.
    pub(super) fn most(&self) -> f64 {
        1.0 + PI * self.growth
    }

    /// Returns the effect of foveation on a sphere.
    pub(super) fn at(&self, away: Point, distance: f64, radius: f64) -> Blur {
        let across = cross(self.direction, away);
        let factor = if distance > radius {
            let center = libm::atan2(dot(across, across).sqrt(), dot(self.direction, away));
            1.0 + self.growth * (center - libm::asin(radius / distance)).max(0.0)
        } else {
            1.0
        };
        Blur { factor, growth: self.growth }
    }

    /// Returns the angle in radians by which the gaze turned, or `None` if the growth differs.
    pub(super) fn turn_from(&self, before: &Self) -> Option<f64> {
        let turned = sub(self.direction, before.direction);
        let half = dot(turned, turned).sqrt() / 2.0;
        (Self { direction: before.direction, ..*self } == *before).then(|| 2.0 * libm::asin(half.min(1.0)))
    }
}

/// The effect of foveation on a collapse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blur {
    /// The factor on the allowed error.
    pub(super) factor: f64,
    growth: f64,
}

impl Blur {
    /// No foveation.
    pub(super) const NONE: Self = Self { factor: 1.0, growth: 0.0 };

    /// Returns a travel within which distance × factor changes by less than `amount`.
    pub(super) fn travel(&self, amount: f64, distance: f64) -> f64 {
        if self.growth <= 0.0 {
            return amount;
        }
        let within = |[share, log]: [f64; 2]| {
            (amount / (self.factor + (1.0 + log) * self.growth)).min(share * distance)
        };
        within([0.125, LN_8_7]).max(within([0.5, LN_2]))
    }
}
