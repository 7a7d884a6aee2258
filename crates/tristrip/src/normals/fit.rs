//! How well the normals of vertices fit the faces.

use super::surface::{normals_of, positions, scaled_to_one, vector};
use crate::error::Error;
use crate::mesh::{Mesh, check_corners, check_triangles, triangles_of};
use crate::vector::{Point, dot, normal_of};

/// The cosine of the largest angle between the normal of a flat face and those of its corners: 2 degrees, for normals of 8 bits.
pub(super) const SAME_NORMAL: f64 = 0.9994;
/// The cosine of the largest angle between the normal of a face and one at its corner that fits: 45 degrees, which a rounded edge of a
/// box needs with one row of faces. In pictures of a truck, of 45 to 18 degrees, less was worse.
const FITS: f64 = 0.707;

/// Returns whether a normal fits a face, both of length 1.
pub(super) fn fits(normal: Point, face: Point) -> bool {
    dot(normal, face) >= FITS
}

/// How well the normals of vertices fit the faces, as shares of the area from 0 to 1; a corner counts for a third of its triangle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct NormalFit {
    /// The corners at which the normal is at most 2 degrees off that of the face: flat sides.
    pub flat: f64,
    /// The corners at which the normal is more than 45 degrees off. A simplification after which these are more has left vertices with the
    /// normals of faces that are gone.
    pub unfit: f64,
}

impl NormalFit {
    /// Measures how well the normals of a mesh fit triangles over its vertices; `None` if the mesh has no normals (`NORMAL`, three
    /// components), or the triangles have no area.
    ///
    /// # Errors
    /// The number of indices is not a multiple of three, or an index is out of range.
    ///
    /// ```
    /// # use tristrip::normals::NormalFit;
    #[doc = include_str!("example.txt")]
    /// assert!(NormalFit::of(&roof, &triangles)?.is_some_and(|fit| fit.flat == 1.0 && fit.unfit == 0.0));
    /// // A triangle of the back with a vertex of the front, whose normal is at a right angle to it.
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
