//! Foveation: less detail away from the point of the image at which somebody looks.
//!
//! The smallest angle that an eye resolves grows about linearly with the angle from the point of its attention. So does the error that a view allows:
//!
//! ```text
//! allowed error = pixels × tolerance × (1 + growth × degrees)
//! ```
//! The degrees are those between the direction to the attention and the nearest point of the sphere of a collapse, as seen from the eye.
//!
//! # Travel
//! With d the distance of the sphere, θ its angle in radians, G the growth per radian and f = 1 + Gθ, a collapse is allowed where d f is at least a distance n that its
//! error needs. A way dw of the eye changes d by up to dw, and θ by up to dw / d; a turn dρ of the attention changes θ by up to dρ. If a turn counts
//! as the travel of the farthest point, no less than d dρ, then d f changes by up to (f + G) dt in a travel dt. Within a travel t of a share s of d, θ grows
//! by up to ∫ dt / (d − t) ≤ ln 1/(1 − s), so that d f changes by up to (f + (1 + ln 1/(1 − s)) G) t, with the f at its beginning.
//!
//! # References
//! Guenter, Finch, Drucker, Tan, Snyder: *Foveated 3D Graphics*, 2012.

use std::f64::consts::{LN_2, PI};

use super::camera::CameraFrame;
use crate::error::Error;
use crate::vector::{Point, cross, dot, sub, unit};

/// The natural logarithm of 8/7, rounded up.
const LN_8_7: f64 = 0.133_531_5;

/// How the allowed error of a view grows away from the point of the image at which somebody looks.
///
/// ```
/// use tristrip::lod::{Foveation, ViewCriteria};
/// // Ten degrees from the middle of the image, 1 + 0.2 × 10 = 3 times the error is allowed.
/// let foveation = Foveation::new(0.2)?;
/// // Somebody looks at the upper left.
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
    /// Creates a foveation around the middle of the image: `degrees` away from it the allowed error is 1 + `growth` × `degrees` times as large. An eye that just
    /// resolves the pixels has a growth of about 1 per degree; at 0 there is no foveation.
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

    /// Sets the point of the image at which somebody looks, in fractions of its width from the left and of its height from the top.
    ///
    /// # Errors
    /// A fraction is not from 0 to 1.
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

    /// Returns the point of the image at which somebody looks, in fractions of its width from the left and of its height from the top.
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
    /// The direction from the eye to the attention, of length 1.
    direction: Point,
    /// The growth of the allowed error per radian.
    growth: f64,
}

impl Gaze {
    /// Returns the foveation of a frame, if there is one.
    pub(super) fn new(foveation: Foveation, frame: &CameraFrame) -> Option<Self> {
        let [right, up] = frame.edges;
        let forward = frame.planes[4];
        let [x, y] = foveation.attention.map(f64::from);
        let direction =
            unit([0, 1, 2].map(|k| forward[k] + (2.0 * x - 1.0) * right[k] + (1.0 - 2.0 * y) * up[k]));
        let growth = f64::from(foveation.growth).to_degrees();
        (growth > 0.0).then_some(Self { direction, growth })
    }

    /// Returns the largest factor of the allowed error.
    pub(super) fn most(&self) -> f64 {
        1.0 + PI * self.growth
    }

    /// Returns what the foveation does at a sphere.
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

    /// Returns the angle in radians by which the attention turned, or `None` if the growth is another one.
    pub(super) fn turn_from(&self, before: &Self) -> Option<f64> {
        let turned = sub(self.direction, before.direction);
        let half = dot(turned, turned).sqrt() / 2.0;
        (Self { direction: before.direction, ..*self } == *before).then(|| 2.0 * libm::asin(half.min(1.0)))
    }
}

/// What foveation does to a collapse.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Blur {
    /// The factor of the allowed error.
    pub(super) factor: f64,
    growth: f64,
}

impl Blur {
    /// No foveation.
    pub(super) const NONE: Self = Self { factor: 1.0, growth: 0.0 };

    /// Returns the travel within which a distance times the factor changes by less than an amount.
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
