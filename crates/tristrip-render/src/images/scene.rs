//! The geometry to draw: triangles in model axes, with normals and paint.

use std::collections::HashMap;

use super::vector::{Vector, add, cross, dot, sub, unit};
use crate::error::Error;

/// Minimum cosine between the normals of a triangle and its vertex for smooth shading. Sharper
/// creases, such as the edges of a cube, are shaded flat.
const CREASE: f64 = 0.8;

/// A triangle of an image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    /// In model axes. After projection: in pixels from the lower left corner, with a depth that
    /// increases towards the eye.
    pub(super) corners: [Vector; 3],
    /// Unit normals in model axes.
    pub(super) normals: [Vector; 3],
    pub(super) paint: Paint,
}

/// The colour source of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) enum Paint {
    /// An sRGB colour.
    Colour([u8; 3]),
    /// The index of the corner values in a textured model.
    Corners(u32),
}

/// Returns the position of a vertex.
///
/// # Errors
/// The vertex does not exist, or its position is not finite.
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

/// Adds the triangles of a part with their colours.
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

/// Returns the corner normals of each triangle: the area-weighted mean of the triangles at the
/// position, or at a crease the normal of the triangle. `None` for a triangle without area.
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

/// The bits of a position. Vertices at the same position share a normal, whatever their other
/// attributes.
type PositionBits = [u64; 3];

fn bits(position: Vector) -> PositionBits {
    position.map(f64::to_bits)
}

/// Returns the normal of a triangle; its length is twice the area.
pub(super) fn normal([a, b, c]: [Vector; 3]) -> Vector {
    cross(sub(b, a), sub(c, a))
}
