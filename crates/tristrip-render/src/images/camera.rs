//! Cameras: from model axes to pixels and depth.
//!
//! ```text
//!       up                       parallel:    depth = towards · p
//!        │   ╱ towards the eye   perspective: depth = 1 / w, w = distance along the view axis
//!        │ ╱
//!        └──── right             both increase towards the eye and are linear over a triangle
//! ```

use super::options::{RenderOptions, View};
use super::scene::Facet;
use super::vector::{Vector, add, cross, dot, sub, unit};
use crate::error::Error;
use tristrip::lod;

/// The fraction of the width and height that the model fills; the rest is margin.
const FILLED: f64 = 0.94;

/// The distance of the eye from the centre of a box, in halves of its diagonal: a field of view of
/// about 40 degrees.
const EYE_DISTANCE: f64 = 3.0;
/// The near plane, in the same unit.
const NEAR: f64 = 0.01;
/// The near plane of a level-of-detail view, relative to the distance from the eye to the target.
const NEAR_OF_VIEW: f64 = 1e-3;

/// The image axes in model coordinates.
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
            Error::Image("view: found no direction, expected a view direction and an up direction that is not parallel".into())
        })
    }

    /// Converts a vector from image axes to model axes.
    pub(super) fn outward(&self, [x, y, z]: Vector) -> Vector {
        let along = |axis: Vector, length: f64| axis.map(|share| share * length);
        add(add(along(self.right, x), along(self.up, y)), along(self.towards, z))
    }

    /// Converts a vector from model axes to image axes.
    fn inward(&self, v: Vector) -> Vector {
        [dot(v, self.right), dot(v, self.up), dot(v, self.towards)]
    }
}

/// The position, direction and scale of a view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    pub(super) axes: Axes,
    /// The eye and the distance of the near plane; `None` for a parallel projection.
    eye: Option<(Vector, f64)>,
    scale: f64,
    /// The projected point at the centre of the image.
    middle: [f64; 2],
    size: [f64; 2],
}

impl Camera {
    /// Returns the parallel camera for which the triangles fill the image.
    pub(super) fn fitted(facets: &[Facet], options: &RenderOptions) -> Result<Self, Error> {
        let corners = facets.iter().flat_map(|facet| facet.corners);
        Self::unscaled(options, options.view, None)?.filled_with(corners)
    }

    /// Returns the perspective camera for which a box fills the image.
    pub(super) fn around(low: Vector, high: Vector, options: &RenderOptions) -> Result<Self, Error> {
        let view = options.view;
        let centre = [0, 1, 2].map(|i| low[i] / 2.0 + high[i] / 2.0);
        let half = sub(high, centre);
        let radius = dot(half, half).sqrt();
        if !radius.is_finite() {
            return Err(Error::Image(format!(
                "found a bounding box from {low:?} to {high:?}, expected a smaller one"
            )));
        }
        // A model without extent is visible from any distance.
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let towards = Axes::of(view)?.towards;
        let eye = add(centre, towards.map(|x| x * (EYE_DISTANCE * radius)));
        let camera = Self::unscaled(options, view, Some((eye, NEAR * radius)))?;
        let corner = |n: usize| [0, 1, 2].map(|axis| if n >> axis & 1 == 0 { low[axis] } else { high[axis] });
        camera.filled_with((0..8).map(corner))
    }

    /// Returns the camera of a level-of-detail view for any image size. The view defines the
    /// vertical field of view.
    pub(super) fn of_view(view: &lod::Camera, options: &RenderOptions) -> Result<Self, Error> {
        options.check()?;
        let [right, up, forward] = view.axes();
        let axes = Axes { right, up, towards: forward.map(|x| -x) };
        let eye = view.eye().map(f64::from);
        let away = sub(view.look_at().map(f64::from), eye);
        let near = NEAR_OF_VIEW * dot(away, away).sqrt();
        let size = [f64::from(options.width), f64::from(options.height)];
        let half_height = libm::tan(f64::from(view.field_of_view()).to_radians() / 2.0);
        let scale = size[1] / (2.0 * half_height);
        Ok(Self { axes, eye: Some((eye, near)), scale, middle: [0.0; 2], size })
    }

    fn unscaled(options: &RenderOptions, view: View, eye: Option<(Vector, f64)>) -> Result<Self, Error> {
        options.check()?;
        let size = [f64::from(options.width), f64::from(options.height)];
        Ok(Self { axes: Axes::of(view)?, eye, scale: 1.0, middle: [0.0; 2], size })
    }

    /// Scales the projection so that the points fill the image.
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

    /// Whether depth is the reciprocal of the distance. Interpolation over a triangle is then
    /// perspective-correct.
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

    /// Adds the part of a triangle in front of the near plane, in pixels and depth: nothing, one or
    /// two triangles. The triangle must have one colour.
    ///
    /// ```text
    ///        a            two corners in front of the near plane: a, b and the two points where
    ///       ╱ ╲           the edges to c cross it
    ///      b   ╲
    ///  ─────╲───╲── near
    ///        ╲╱ c         eye below
    /// ```
    /// The intersection with an edge is computed from its visible end, so both triangles of the
    /// edge get the same point.
    pub(super) fn clip(&self, facet: &Facet, seen: &mut Vec<Facet>) -> Result<(), Error> {
        let Some((eye, near)) = self.eye else {
            seen.push(self.facet(facet)?);
            return Ok(());
        };
        let depths = facet.corners.map(|corner| -self.axes.inward(sub(corner, eye))[2] - near);
        if depths.iter().all(|&depth| depth >= 0.0) {
            seen.push(self.facet(facet)?);
            return Ok(());
        }
        let mut outline: Vec<(Vector, Vector)> = Vec::with_capacity(4);
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            if depths[a] >= 0.0 {
                outline.push((facet.corners[a], facet.normals[a]));
            }
            if (depths[a] >= 0.0) != (depths[b] >= 0.0) {
                let (front, behind) = if depths[a] >= 0.0 { (a, b) } else { (b, a) };
                let share = depths[front] / (depths[front] - depths[behind]);
                let between = |a: Vector, b: Vector| [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
                let corner = between(facet.corners[front], facet.corners[behind]);
                outline.push((corner, between(facet.normals[front], facet.normals[behind])));
            }
        }
        for pair in outline.windows(2).skip(1) {
            let corners = [outline[0], pair[0], pair[1]];
            let part = Facet { corners: corners.map(|c| c.0), normals: corners.map(|c| c.1), ..*facet };
            // Tolerate rounding of points on the near plane.
            let wider = Self { eye: Some((eye, 0.5 * near)), ..*self };
            seen.push(wider.facet(&part)?);
        }
        Ok(())
    }

    /// Returns the eye and the direction from it through a pixel.
    #[cfg(test)]
    pub(super) fn ray(&self, pixel: [f64; 2]) -> Option<(Vector, Vector)> {
        let (eye, _) = self.eye?;
        let [x, y] =
            [0, 1].map(|axis| (pixel[axis] - self.size[axis] / 2.0) / self.scale + self.middle[axis]);
        Some((eye, self.axes.outward([x, y, -1.0])))
    }

    /// Returns the unscaled projection of a point, and its depth.
    fn projected(&self, point: Vector) -> Result<Vector, Error> {
        let Some((eye, near)) = self.eye else { return Ok(self.axes.inward(point)) };
        let [x, y, z] = self.axes.inward(sub(point, eye));
        let distance = -z;
        if distance < near || distance.is_nan() {
            let expected = "expected a point in front of it; do both files contain the same model?";
            return Err(Error::Image(format!("found {point:?} next to or behind the eye, {expected}")));
        }
        Ok([x / distance, y / distance, 1.0 / distance])
    }
}
