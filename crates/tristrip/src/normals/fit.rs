//! How well vertex normals fit the faces.

use super::surface::{normals_of, positions, scaled_to_one, vector};
use crate::error::Error;
use crate::mesh::{Mesh, check_corners, check_triangles, triangles_of};
use crate::vector::{Point, dot, normal_of};

/// The cosine of the maximum angle between the normal of a flat face and those of its corners: 2
/// degrees, which allows normals of 8 bits per component.
pub(super) const SAME_NORMAL: f64 = 0.9994;
/// The cosine of the maximum angle between a face normal and a fitting normal at its corner: 45
/// degrees. A rounded box edge with one row of faces needs this much. In images of a truck, angles
/// from 45 down to 18 degrees were compared, and smaller ones looked worse.
const FITS: f64 = 0.707;

/// Returns whether a normal fits a face. Both have length 1.
pub(super) fn fits(normal: Point, face: Point) -> bool {
    dot(normal, face) >= FITS
}

/// How well vertex normals fit the faces, as shares of the area from 0 to 1. Each corner counts as
/// a third of its triangle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct NormalFit {
    /// The share of corners whose normal is within 2 degrees of the face normal, as on flat faces.
    pub flat: f64,
    /// The share of corners whose normal is more than 45 degrees from the face normal. If
    /// simplification increases this share, some vertices have kept normals of removed faces.
    pub unfit: f64,
}

impl NormalFit {
    /// Measures how well the normals of a mesh fit triangles over its vertices. Returns `None` if
    /// the mesh has no normals (`NORMAL`, three components) or the triangles have no area.
    ///
    /// # Errors
    /// The number of indices is not a multiple of three, or an index is out of range.
    ///
    /// ```
    /// # use tristrip::normals::NormalFit;
    #[doc = include_str!("example.txt")]
    /// assert!(NormalFit::of(&roof, &triangles)?.is_some_and(|fit| fit.flat == 1.0 && fit.unfit == 0.0));
    /// // A triangle on the back with a vertex of the front, whose normal is perpendicular to it.
    /// let third = 1.0 / 3.0;
    /// assert!(NormalFit::of(&roof, &[5, 8, 11])?.is_some_and(|fit| (fit.unfit - third).abs() < 1e-9));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of(mesh: &Mesh, triangles: &[u32]) -> Result<Option<Self>, Error> {
        check_triangles(triangles.len())?;
        check_corners(triangles, mesh.vertex_count())?;
        let Some(normals) = normals_of(mesh) else { return Ok(None) };
        let (mut flat, mut unfit, mut all) = (0.0, 0.0, 0.0);
        for corners in triangles_of(triangles) {
            let double_area = normal_of(positions(mesh, corners));
            let area = dot(double_area, double_area).sqrt();
            let Some(face) = scaled_to_one(double_area).filter(|_| area.is_finite()) else { continue };
            all += 3.0 * area;
            for normal in corners.iter().filter_map(|&v| scaled_to_one(vector(normals, v))) {
                if dot(normal, face) >= SAME_NORMAL {
                    flat += area;
                } else if !fits(normal, face) {
                    unfit += area;
                }
            }
        }
        Ok((all > 0.0).then(|| Self { flat: flat / all, unfit: unfit / all }))
    }
}
