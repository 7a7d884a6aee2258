//! What is drawn: triangles in the axes of the model, their normals, and what colours them.

use std::collections::HashMap;

use super::vector::{Vector, add, cross, dot, sub, unit};
use crate::error::Error;

/// The least cosine of the angle between the normal of a triangle and that of its vertex; at a sharper crease, such as an edge of a cube, the
/// triangle is flat.
const CREASE: f64 = 0.8;

/// A triangle of a picture.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// In the axes of the model; once a camera has seen them, in pixels from the lower left corner, with a depth that grows towards the eye.
    pub(super) corners: [Vector; 3],
    /// Of length 1, in the axes of the model.
    pub(super) normals: [Vector; 3],
    pub(super) paint: Paint,
}

/// What colours a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) enum Paint {
    /// A colour in sRGB.
    Colour([u8; 3]),
    /// The corners of a textured model with this number.
    Corners(u32),
}

/// Returns the position of a vertex.
///
/// # Errors
/// There is no such vertex, or it is not finite.
pub(super) fn position(positions: &[[f32; 3]], vertex: u32) -> Result<Vector, Error> {
    let found = positions.get(vertex as usize).ok_or_else(|| {
        Error::Image(format!("found vertex {vertex}, expected less than {}", positions.len()))
    })?;
    if !found.iter().all(|x| x.is_finite()) {
        let expected = "expected finite coordinates";
        return Err(Error::Image(format!("vertex {vertex}: found {found:?}, {expected}")));
    }
    Ok(found.map(f64::from))
}

/// Adds the triangles of a part, each with its colour.
pub(super) fn add_part(
    facets: &mut Vec<Facet>,
    positions: &[[f32; 3]],
    triangles: impl Iterator<Item = ([u32; 3], [u8; 3])>,
) -> Result<(), Error> {
    let mut corners = Vec::new();
    let mut colours = Vec::new();
    for (triangle, colour) in triangles {
        let mut found = [Vector::default(); 3];
        for (corner, &vertex) in found.iter_mut().zip(&triangle) {
            *corner = position(positions, vertex)?;
        }
        corners.push(found);
        colours.push(colour);
    }
    let normals = corner_normals(&corners);
    let all = corners.into_iter().zip(normals).zip(colours);
    facets.extend(all.filter_map(|((corners, normals), colour)| {
        Some(Facet { corners, normals: normals?, paint: Paint::Colour(colour) })
    }));
    Ok(())
}

/// Returns the normals at the corners of each triangle: the mean of the triangles around the position, weighted by their areas, or at a
/// crease that of the triangle; `None` for a triangle without area.
pub(super) fn corner_normals(triangles: &[[Vector; 3]]) -> Vec<Option<[Vector; 3]>> {
    let mut sums: HashMap<PositionBits, Vector> = HashMap::new();
    for &corners in triangles {
        let normal = normal(corners);
        for corner in corners {
            let sum = sums.entry(bits(corner)).or_default();
            *sum = add(*sum, normal);
        }
    }
    let of_triangle = |&corners: &[Vector; 3]| {
        let flat = unit(normal(corners))?;
        Some(corners.map(|corner| {
            let smooth = sums.get(&bits(corner)).and_then(|&sum| unit(sum));
            smooth.filter(|&smooth| dot(smooth, flat) >= CREASE).unwrap_or(flat)
        }))
    };
    triangles.iter().map(of_triangle).collect()
}

/// The bits of a position: vertices at the same position have one normal, whatever their other attributes.
type PositionBits = [u64; 3];

fn bits(position: Vector) -> PositionBits {
    position.map(f64::to_bits)
}

/// Returns the normal of a triangle, of twice its area as length.
pub(super) fn normal([a, b, c]: [Vector; 3]) -> Vector {
    cross(sub(b, a), sub(c, a))
}
