//! What is drawn: triangles with corners in the axes of the picture, their normals and colours.

use std::collections::HashMap;

use super::options::{MAX_SIZE, RenderOptions};
use crate::error::Error;

/// A point or vector: right, up, towards the eye.
pub(super) type Vector = [f64; 3];

/// The part of the width and height that the margins on both sides leave for the model.
const FILLED: f64 = 0.94;

/// The least cosine of the angle between the normal of a triangle and that of its vertex; at a sharper crease, such as an edge of a cube, the
/// triangle is flat.
const CREASE: f64 = 0.8;

/// A triangle of the picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// In pixels from the lower left corner; the depth grows towards the eye.
    pub(super) corners: [Vector; 3],
    /// Of length 1, towards the eye.
    pub(super) normals: [Vector; 3],
    /// In sRGB.
    pub(super) colour: [u8; 3],
}

/// The triangles of a picture that is being set up.
pub(super) struct Scene {
    right: Vector,
    up: Vector,
    towards: Vector,
    size: [f64; 2],
    facets: Vec<Facet>,
}

impl Scene {
    /// Checks the options, and derives the axes of the picture.
    pub(super) fn new(options: &RenderOptions) -> Result<Self, Error> {
        for size in [options.width, options.height] {
            if !(1..=MAX_SIZE).contains(&size) {
                let expected = format!("expected 1 to {MAX_SIZE} pixels");
                return Err(Error::Picture(format!("size: found {size}, {expected}")));
            }
        }
        let view = options.view;
        let axes = unit(view.from).and_then(|towards| {
            let right = unit(cross(view.up, towards))?;
            Some((right, cross(towards, right), towards))
        });
        let (right, up, towards) = axes.ok_or_else(|| {
            Error::Picture("view: found no direction, expected a direction of view and another one up".into())
        })?;
        let size = [f64::from(options.width), f64::from(options.height)];
        Ok(Self { right, up, towards, size, facets: Vec::new() })
    }

    /// Adds the triangles of a part, each with its colour.
    pub(super) fn add(
        &mut self,
        positions: &[[f32; 3]],
        triangles: impl Iterator<Item = ([u32; 3], [u8; 3])>,
    ) -> Result<(), Error> {
        let mut facets = Vec::new();
        for (triangle, colour) in triangles {
            let mut corners = [Vector::default(); 3];
            for (corner, &vertex) in corners.iter_mut().zip(&triangle) {
                *corner = self.seen(positions, vertex)?;
            }
            facets.push((triangle, corners, colour));
        }
        let normals = vertex_normals(positions, &facets);
        self.facets.extend(facets.into_iter().filter_map(|(triangle, corners, colour)| {
            let flat = unit(normal(corners))?;
            let normals = triangle.map(|vertex| {
                let smooth = normals.get(&bits(positions, vertex)).and_then(|&sum| unit(sum));
                facing(smooth.filter(|&smooth| dot(smooth, flat) >= CREASE).unwrap_or(flat))
            });
            Some(Facet { corners, normals, colour })
        }));
        Ok(())
    }

    /// Returns a vertex in the axes of the picture.
    fn seen(&self, positions: &[[f32; 3]], vertex: u32) -> Result<Vector, Error> {
        let found = positions.get(vertex as usize).ok_or_else(|| {
            Error::Picture(format!("found vertex {vertex}, expected less than {}", positions.len()))
        })?;
        if !found.iter().all(|x| x.is_finite()) {
            return Err(Error::Picture(format!(
                "vertex {vertex}: found {found:?}, expected finite coordinates"
            )));
        }
        let position = found.map(f64::from);
        Ok([dot(position, self.right), dot(position, self.up), dot(position, self.towards)])
    }

    /// Returns the triangles, scaled and moved to the middle of the picture.
    pub(super) fn finish(self) -> Vec<Facet> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in self.facets.iter().flat_map(|facet| facet.corners) {
            for axis in 0..2 {
                low[axis] = low[axis].min(corner[axis]);
                high[axis] = high[axis].max(corner[axis]);
            }
        }
        let scale = |axis: usize| FILLED * self.size[axis] / (high[axis] - low[axis]);
        let scale = scale(0).min(scale(1));
        let mut facets = self.facets;
        for corner in facets.iter_mut().flat_map(|facet| &mut facet.corners) {
            for axis in 0..2 {
                let middle = low[axis] / 2.0 + high[axis] / 2.0;
                corner[axis] = scale * (corner[axis] - middle) + self.size[axis] / 2.0;
            }
        }
        facets
    }
}

/// The bits of a position: vertices at the same position have one normal, whatever their other attributes.
type PositionBits = [u32; 3];

fn bits(positions: &[[f32; 3]], vertex: u32) -> PositionBits {
    positions.get(vertex as usize).map_or([0; 3], |position| position.map(f32::to_bits))
}

/// Sums the normals of the triangles around each position, weighted by their areas.
fn vertex_normals(
    positions: &[[f32; 3]],
    facets: &[([u32; 3], [Vector; 3], [u8; 3])],
) -> HashMap<PositionBits, Vector> {
    let mut normals: HashMap<PositionBits, Vector> = HashMap::new();
    for (triangle, corners, _) in facets {
        let normal = normal(*corners);
        for &vertex in triangle {
            let sum = normals.entry(bits(positions, vertex)).or_default();
            *sum = [sum[0] + normal[0], sum[1] + normal[1], sum[2] + normal[2]];
        }
    }
    normals
}

/// Turns a normal towards the eye, so that both sides of a surface are lit.
fn facing(normal: Vector) -> Vector {
    if normal[2] < 0.0 { normal.map(|x| -x) } else { normal }
}

/// Returns the normal of a triangle, of twice its area as length.
fn normal([a, b, c]: [Vector; 3]) -> Vector {
    cross(sub(b, a), sub(c, a))
}

fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns a vector scaled to length 1; `None` if it has no direction.
pub(super) fn unit(a: Vector) -> Option<Vector> {
    // Scaled first, so that the squares of very large and very small vectors are neither infinite nor zero.
    let largest = a.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    let a = a.map(|x| x / largest);
    let length = dot(a, a).sqrt();
    Some(a.map(|x| x / length))
}
