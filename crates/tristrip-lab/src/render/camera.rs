//! Cameras: from the axes of a model to pixels and depth.
//!
//! ```text
//!              up                        parallel:    depth = towards · p
//!               │   ╱ towards the eye    perspective: depth = 1 / w, w = distance from the eye along the axis
//!               │ ╱
//!               └──── right              both grow towards the eye and are linear over a triangle in the picture
//! ```

use super::options::{RenderOptions, View};
use super::scene::Facet;
use super::vector::{Vector, add, cross, dot, sub, unit};
use crate::error::Error;

/// The part of the width and height that the margins on both sides leave for the model.
const FILLED: f64 = 0.94;

/// The distance of the eye from the middle of a box, in halves of its diagonal: a field of view of about 40 degrees.
const EYE_DISTANCE: f64 = 3.0;
/// The least distance of what is drawn from the eye, in the same unit.
const NEAR: f64 = 0.01;

/// The axes of a picture, in those of the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    right: Vector,
    up: Vector,
    pub(super) towards: Vector,
}

impl Axes {
    fn of(view: View) -> Result<Self, Error> {
        let axes = unit(view.from).and_then(|towards| {
            let right = unit(cross(view.up, towards))?;
            Some(Self { right, up: cross(towards, right), towards })
        });
        axes.ok_or_else(|| {
            Error::Picture("view: found no direction, expected a direction of view and another one up".into())
        })
    }

    /// Returns a vector of the picture in the axes of the model.
    pub(super) fn outward(&self, [x, y, z]: Vector) -> Vector {
        let along = |axis: Vector, length: f64| axis.map(|share| share * length);
        add(add(along(self.right, x), along(self.up, y)), along(self.towards, z))
    }

    /// Returns a vector of the model in the axes of the picture.
    fn inward(&self, v: Vector) -> Vector {
        [dot(v, self.right), dot(v, self.up), dot(v, self.towards)]
    }
}

/// From where, and with which scale, a picture is seen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    pub(super) axes: Axes,
    /// The eye, and the least distance from it; `None` for a parallel projection.
    eye: Option<(Vector, f64)>,
    scale: f64,
    /// The point of the projection in the middle of the picture.
    middle: [f64; 2],
    size: [f64; 2],
}

impl Camera {
    /// Returns the camera with parallel rays that fills the picture with triangles.
    pub(super) fn fitted(facets: &[Facet], options: &RenderOptions) -> Result<Self, Error> {
        let corners = facets.iter().flat_map(|facet| facet.corners);
        Self::unscaled(options, options.view, None)?.filled_with(corners)
    }

    /// Returns the camera with perspective that fills the picture with a box.
    pub(super) fn around(low: Vector, high: Vector, options: &RenderOptions) -> Result<Self, Error> {
        let view = options.view;
        let centre = [0, 1, 2].map(|i| low[i] / 2.0 + high[i] / 2.0);
        let half = sub(high, centre);
        let radius = dot(half, half).sqrt();
        if !radius.is_finite() {
            return Err(Error::Picture(format!(
                "found a box from {low:?} to {high:?}, expected a smaller one"
            )));
        }
        // A model without extent is seen from any distance.
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let towards = Axes::of(view)?.towards;
        let eye = add(centre, towards.map(|x| x * (EYE_DISTANCE * radius)));
        let camera = Self::unscaled(options, view, Some((eye, NEAR * radius)))?;
        let corner = |n: usize| [0, 1, 2].map(|axis| if n >> axis & 1 == 0 { low[axis] } else { high[axis] });
        camera.filled_with((0..8).map(corner))
    }

    fn unscaled(options: &RenderOptions, view: View, eye: Option<(Vector, f64)>) -> Result<Self, Error> {
        options.check()?;
        let size = [f64::from(options.width), f64::from(options.height)];
        Ok(Self { axes: Axes::of(view)?, eye, scale: 1.0, middle: [0.0; 2], size })
    }

    /// Scales the projection so that points fill the picture.
    fn filled_with(self, points: impl Iterator<Item = Vector>) -> Result<Self, Error> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            let point = self.projected(point)?;
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        let scale = |axis: usize| FILLED * self.size[axis] / (high[axis] - low[axis]);
        let middle = [0, 1].map(|axis| low[axis] / 2.0 + high[axis] / 2.0);
        Ok(Self { scale: scale(0).min(scale(1)), middle, ..self })
    }

    /// Whether the depth is the reciprocal of the distance, and values over a triangle are therefore weighted by it.
    pub(super) fn perspective(&self) -> bool {
        self.eye.is_some()
    }

    /// Returns a triangle in pixels and depth.
    pub(super) fn facet(&self, facet: &Facet) -> Result<Facet, Error> {
        let mut seen = *facet;
        for corner in &mut seen.corners {
            let [x, y, depth] = self.projected(*corner)?;
            let pixel = |axis: usize, at: f64| self.scale * (at - self.middle[axis]) + self.size[axis] / 2.0;
            *corner = [pixel(0, x), pixel(1, y), depth];
        }
        Ok(seen)
    }

    /// Returns the eye, and the direction from it through a point of the picture in pixels.
    #[cfg(test)]
    pub(super) fn ray(&self, pixel: [f64; 2]) -> Option<(Vector, Vector)> {
        let (eye, _) = self.eye?;
        let [x, y] =
            [0, 1].map(|axis| (pixel[axis] - self.size[axis] / 2.0) / self.scale + self.middle[axis]);
        Some((eye, self.axes.outward([x, y, -1.0])))
    }

    /// Returns a point in the projection, without scale, and its depth.
    fn projected(&self, point: Vector) -> Result<Vector, Error> {
        let Some((eye, near)) = self.eye else { return Ok(self.axes.inward(point)) };
        let [x, y, z] = self.axes.inward(sub(point, eye));
        let distance = -z;
        if distance < near || distance.is_nan() {
            let expected = "expected a point in front of it; is it the same model?";
            return Err(Error::Picture(format!("found {point:?} beside or behind the eye, {expected}")));
        }
        Ok([x / distance, y / distance, 1.0 / distance])
    }
}
