//! Prepared faces: the faces of a mesh, cleaned for the strip methods.
//!
//! Every prepared face is a triangle or a convex polygon, and all its corners are different
//! vertices. If all faces of the mesh are like this already, they are borrowed.
//!
//! # Algorithm
//! 1. On request, vertices in use with the same bits in position and all attributes are replaced by
//!    the first of them.
//! 2. Corners that repeat the previous one are dropped. Faces with fewer than three remaining
//!    corners draw nothing; they are dropped and counted.
//! 3. Polygons that are not convex (see `convex.rs`) or contain a vertex twice are cut into
//!    triangles by ear cutting. The polygon becomes a fan if it is too large for ear cutting, or if
//!    the result is not a triangulation of all corners (ear cutting drops corners on straight
//!    edges). A fan keeps all corners and the boundary, and is counted.
//!
//! # Complexity
//! O(n) time, where n is the number of corners. A polygon of k corners takes O(k log k) if it is
//! convex up to rounding, and O(k²) in the worst case if it must be cut. k is at most
//! [`ear_cutting::EAR_CORNERS`], and the sum of k² over the large polygons at most
//! [`ear_cutting::EAR_STEPS`], so cutting takes at most a second or two. Takes no memory if nothing
//! changes.

mod convex;
mod ear_cutting;

use std::borrow::Cow;

use crate::error::Error;
use crate::ids::check_count;
use crate::mesh::{Faces, Mesh, Positions, VertexWelds, check_positions, is_degenerate, without_repeats};
use convex::is_convex;
use ear_cutting::{EarBudget, cut_ears};

/// Faces that are triangles or convex polygons with distinct corners.
#[derive(Debug, Clone)]
pub struct PreparedFaces<'a> {
    faces: Cow<'a, Faces>,
    vertex_count: usize,
    counts: PreparedCounts,
    welds: VertexWelds,
}

/// Counts of the changes made by the preparation of a mesh's faces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PreparedCounts {
    /// Number of vertices in use that were replaced by a vertex with the same bits (`--weld`).
    pub welded_vertices: usize,
    /// Number of dropped faces that draw nothing. They have fewer than three corners after repeated
    /// consecutive corners are dropped.
    pub degenerate_faces: usize,
    /// Number of polygons cut into triangles because they are not convex or contain a vertex twice.
    pub cut_polygons: usize,
    /// Number of these polygons that became fans, because they were too large for ear cutting or
    /// ear cutting found no triangulation of all corners.
    pub fanned_polygons: usize,
}

impl<'a> PreparedFaces<'a> {
    /// Prepares the faces of a mesh. With `weld`, vertices with the same bits are replaced by the
    /// first of them.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, PreparedFaces};
    /// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 1, 1, 2])?)?;
    /// let prepared = PreparedFaces::new(&mesh, false);
    /// assert_eq!((prepared.faces().face_count(), prepared.counts().degenerate_faces), (1, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(mesh: &'a Mesh, weld: bool) -> Self {
        let mut counts = PreparedCounts::default();
        let mut faces = Cow::Borrowed(mesh.faces());
        let welds = if weld { VertexWelds::of(mesh) } else { VertexWelds::default() };
        counts.welded_vertices = welds.len();
        if !welds.is_empty() {
            faces = Cow::Owned(mesh.faces().renamed(welds.vertices(mesh.faces().corners())));
        }
        let faces = match clean(&faces, mesh.positions(), &mut counts) {
            Some(cleaned) => Cow::Owned(cleaned),
            None => faces,
        };
        Self { faces, vertex_count: mesh.vertex_count(), counts, welds }
    }

    /// Prepares faces over positions in the caller's memory. Positions are not copied.
    ///
    /// # Errors
    /// A face has a vertex without a position, or with a position that is not finite.
    pub(crate) fn of_faces<P: Positions + ?Sized>(faces: &'a Faces, positions: &P) -> Result<Self, Error> {
        let vertex_count = positions.vertex_count();
        check_count("vertices", vertex_count)?;
        check_positions(faces.corners(), positions)?;
        let mut counts = PreparedCounts::default();
        let faces = clean(faces, positions, &mut counts).map_or(Cow::Borrowed(faces), Cow::Owned);
        Ok(Self { faces, vertex_count, counts, welds: VertexWelds::default() })
    }

    /// Returns the same faces in another order: `order` contains their indices.
    pub(crate) fn in_order<'b>(&self, order: &[u32]) -> PreparedFaces<'b> {
        let (counts, welds) = (self.counts, self.welds.clone());
        let faces = Cow::Owned(self.faces.in_order(order));
        PreparedFaces { faces, vertex_count: self.vertex_count, counts, welds }
    }

    /// Prepares triangles, which need no positions.
    pub(crate) fn of_triangles(faces: &'a Faces, vertex_count: usize) -> Self {
        debug_assert!(faces.as_triangles().is_some());
        let mut counts = PreparedCounts::default();
        let faces = clean::<[[f32; 3]]>(faces, &[], &mut counts).map_or(Cow::Borrowed(faces), Cow::Owned);
        Self { faces, vertex_count, counts, welds: VertexWelds::default() }
    }

    /// Returns the faces.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, PreparedFaces};
    /// // A concave quadrilateral, which is cut along its inner diagonal.
    /// let positions = vec![[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 2.0, 0.0], [0.5, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_polygons([[0, 1, 2, 3]])?)?;
    /// let prepared = PreparedFaces::new(&mesh, false);
    /// let on_diagonal = |face: &[u32]| face.contains(&1) && face.contains(&3);
    /// assert_eq!(prepared.faces().iter().filter(|face| on_diagonal(face)).count(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn faces(&self) -> &Faces {
        &self.faces
    }

    /// Counts the vertices of the mesh, including unused ones.
    pub(crate) fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Returns the welded vertices.
    pub(crate) fn welds(&self) -> &VertexWelds {
        &self.welds
    }

    /// Returns the counts of the changes made by the preparation.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, PreparedFaces};
    /// // The last two of four vertices have the same position.
    /// let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 1, 2, 3])?)?;
    /// let counts = PreparedFaces::new(&mesh, true).counts();
    /// assert_eq!((counts.welded_vertices, counts.degenerate_faces), (1, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn counts(&self) -> PreparedCounts {
        self.counts
    }
}

/// Returns cleaned faces, or `None` if all faces are valid.
fn clean<P: Positions + ?Sized>(faces: &Faces, positions: &P, counts: &mut PreparedCounts) -> Option<Faces> {
    let is_valid = |polygon: &[u32]| match *polygon {
        [a, b, c] => !is_degenerate([a, b, c]),
        _ => polygon.len() > 3 && all_different(polygon) && is_convex(polygon, positions),
    };
    if faces.iter().all(is_valid) {
        return None;
    }
    let mut offsets = vec![0];
    let mut corners: Vec<u32> = Vec::with_capacity(faces.corner_count());
    let mut polygon: Vec<u32> = Vec::new();
    let mut budget = EarBudget::new();
    for face in faces.iter() {
        without_repeats(face, &mut polygon);
        if is_valid(&polygon) {
            corners.extend_from_slice(&polygon);
            offsets.push(corners.len() as u32);
        } else if polygon.len() < 3 {
            counts.degenerate_faces += 1;
        } else {
            counts.cut_polygons += 1;
            let cut = if budget.reserve(polygon.len()) { cut_ears(&polygon, positions) } else { None };
            let triangles = cut.unwrap_or_else(|| {
                counts.fanned_polygons += 1;
                (1..polygon.len() - 1).map(|i| [polygon[0], polygon[i], polygon[i + 1]]).collect()
            });
            // Polygons that contain a vertex twice may yield degenerate triangles.
            for t in triangles.into_iter().filter(|&t| !is_degenerate(t)) {
                corners.extend_from_slice(&t);
                offsets.push(corners.len() as u32);
            }
        }
    }
    // Preparation adds no triangles, so the number of faces stays within the limits.
    Some(Faces::from_valid_offsets(offsets, corners))
}

fn all_different(polygon: &[u32]) -> bool {
    if polygon.len() <= 16 {
        return polygon.iter().enumerate().all(|(i, v)| !polygon[..i].contains(v));
    }
    let mut sorted = polygon.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).all(|w| w[0] != w[1])
}

#[cfg(test)]
mod tests {
    use super::ear_cutting::{EAR_CORNERS, EAR_SMALL};
    use super::*;

    fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
        points.iter().map(|p| [p[0], 7.0, p[1]]).collect()
    }

    #[test]
    fn cuts_concave_polygons() {
        let arrow = flat(&[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]]);
        for polygon in [vec![0, 1, 2, 3], vec![3, 2, 1, 0]] {
            let mesh = Mesh::new(arrow.clone(), Faces::from_polygons([&polygon]).unwrap()).unwrap();
            let prepared = PreparedFaces::new(&mesh, false);
            assert_eq!(prepared.faces().face_count(), 2);
            assert_eq!(prepared.counts(), PreparedCounts { cut_polygons: 1, ..Default::default() });
            // The only inner diagonal connects 1 and 3.
            assert!(prepared.faces().iter().all(|t| t.contains(&1) && t.contains(&3)));
        }
    }

    #[test]
    fn drops_faces_that_draw_nothing_and_welds_on_request() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [1.0, 1.0, 0.0]];
        let faces =
            Faces::from_polygons([vec![0, 1, 2], vec![3, 0, 1], vec![2, 2, 1], vec![1, 4, 4, 2, 1], vec![0]]);
        let mesh = Mesh::new(positions, faces.unwrap()).unwrap();
        let counts = |weld| PreparedFaces::new(&mesh, weld).counts();
        assert_eq!(counts(false), PreparedCounts { degenerate_faces: 2, ..Default::default() });
        assert_eq!(
            counts(true),
            PreparedCounts { degenerate_faces: 3, welded_vertices: 1, ..Default::default() }
        );
        assert_eq!(PreparedFaces::new(&mesh, false).faces().face(2), [1, 4, 2]);
    }

    fn one_polygon(points: &[[f32; 2]]) -> (usize, PreparedCounts) {
        let polygon: Vec<u32> = (0..points.len() as u32).collect();
        let mesh = Mesh::new(flat(points), Faces::from_polygons([polygon]).unwrap()).unwrap();
        let prepared = PreparedFaces::new(&mesh, false);
        (prepared.faces().face_count(), prepared.counts())
    }

    #[test]
    fn rounding_does_not_make_a_polygon_concave() {
        let round = |n: usize, middle: f32| -> Vec<[f32; 2]> {
            let angle = |i: usize| -(i as f64) / n as f64 * std::f64::consts::TAU;
            (0..n).map(|i| [middle + angle(i).cos() as f32, angle(i).sin() as f32]).collect()
        };
        for (n, middle) in [(1000, 0.0), (100_000, 0.0), (2000, 300.0), (500, 1e4)] {
            assert_eq!(
                one_polygon(&round(n, middle)),
                (1, PreparedCounts::default()),
                "{n} corners at {middle}"
            );
        }
    }

    #[test]
    fn polygons_too_large_to_cut_become_fans() {
        let star = |n: usize| -> Vec<[f32; 2]> {
            let radius = |i: usize| if i.is_multiple_of(2) { 1.0 } else { 0.5 };
            let angle = |i: usize| i as f32 / n as f32 * std::f32::consts::TAU;
            (0..n).map(|i| [radius(i) * angle(i).cos(), radius(i) * angle(i).sin()]).collect()
        };
        let cut = PreparedCounts { cut_polygons: 1, ..Default::default() };
        assert_eq!(one_polygon(&star(EAR_CORNERS)), (EAR_CORNERS - 2, cut));
        let fanned = PreparedCounts { fanned_polygons: 1, ..cut };
        assert_eq!(one_polygon(&star(EAR_CORNERS + 2)), (EAR_CORNERS, fanned));

        // The largest polygons are cut within the budget, small ones always.
        let mut points = star(EAR_CORNERS);
        points.extend(star(EAR_SMALL));
        let large: Vec<u32> = (0..EAR_CORNERS as u32).collect();
        let small: Vec<u32> = (0..EAR_SMALL as u32).map(|i| i + EAR_CORNERS as u32).collect();
        let polygons = std::iter::repeat_n(&large, 5).chain([&small]);
        let mesh = Mesh::new(flat(&points), Faces::from_polygons(polygons).unwrap()).unwrap();
        let counts = PreparedFaces::new(&mesh, false).counts();
        assert_eq!((counts.cut_polygons, counts.fanned_polygons), (6, 1));
    }
}
