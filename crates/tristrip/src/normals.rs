//! Detects how a mesh is shaded, and computes normals with the same shading for other triangles
//! over its vertices.
//!
//! A *flat-shaded* mesh has the face normal at each corner, so every edge is hard: the normals on
//! its two sides differ. A mesh with creases is smooth between hard edges. Simplification changes
//! the faces, so the normals of the remaining vertices belong to faces that no longer exist.
//!
//! # Algorithm
//! 1. An edge shared by two triangles, matched by position, is *hard* if the normals on its two
//!    sides differ at one of its ends.
//! 2. A mesh is flat-shaded if nearly all corners have the normal of their face and many edges are
//!    hard. Without the second condition, a plane would count as flat-shaded.
//! 3. The crease angle is the threshold of the angle between faces that best separates hard edges
//!    from the others. It leaves the fewest edges on the wrong side.
//! 4. New normals: the candidates of a corner are the mesh's normals at its point. The corner gets
//!    the candidate nearest to its face normal, if this candidate is within 45 degrees of it. All
//!    other corners at a point that are connected by edges below the crease angle share one normal.
//!    They get the mesh normal that is nearest to the weighted mean of their face normals, among
//!    those at the point. If no mesh normal is near the mean, the corners get the mean itself. In a
//!    flat-shaded mesh, every corner gets its face normal.
//!
//! # References
//! N. Max: *Weights for Computing Vertex Normals from Facet Normals*, 1999: the weights, which need
//! no angles and are exact for a sphere.
//!
//! # Complexity
//! O(n log n) time; about 80 bytes per triangle.

mod fit;
mod known;
mod surface;

use crate::error::Error;
use crate::mesh::{Attribute, Mesh, check_corners, check_triangles, triangles_of};
use crate::union_find::UnionFind;
use crate::vector::{Point, cross, dot, sub};
pub use fit::NormalFit;
use fit::{SAME_NORMAL, fits};
use known::KnownNormals;
use surface::{InnerEdge, TriangleNormals, normals_of, positions, scaled_to_one, unit_normal, vector};

/// The minimum share of corners with their face normals in a flat-shaded mesh.
const FLAT_CORNERS: f64 = 0.98;
/// The minimum share of hard edges in a flat-shaded mesh. With fewer, most faces are parts of
/// planes, which need no new normals when they collapse.
const HARD_EDGES: f64 = 0.25;

/// The shading of a mesh: flat, or smooth up to a crease angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shading {
    is_flat: bool,
    /// The cosine of the crease angle; below every cosine if there are no hard edges.
    crease: f64,
}

impl Shading {
    /// Detects how triangles over the vertices of a mesh are shaded. Returns `None` if the mesh has
    /// no normals (`NORMAL`, three components).
    ///
    /// # Errors
    /// The number of indices is not a multiple of three, or an index is out of range.
    ///
    /// ```
    #[doc = include_str!("normals/example.txt")]
    /// assert!(Shading::of(&roof, &triangles)?.is_some_and(|shading| shading.is_flat()));
    /// let bare = Mesh::new(roof.shared_positions(), Faces::default())?;
    /// assert_eq!(Shading::of(&bare, &triangles)?, None);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of(mesh: &Mesh, triangles: &[u32]) -> Result<Option<Self>, Error> {
        let Some(normals) = normals_of(mesh) else { return Ok(None) };
        let surface = TriangleNormals::new(mesh, triangles)?;
        let edges = surface.inner_edges();
        let at = |corner: u32| vector(normals, triangles[corner as usize]);
        let is_hard = |edge: &InnerEdge| edge.ends.iter().any(|&[a, b]| differ(at(a), at(b)));
        let hard: Vec<bool> = edges.iter().map(is_hard).collect();
        let hard_count = hard.iter().filter(|&&hard| hard).count();
        let is_flat = hard_count > 0
            && hard_count as f64 >= HARD_EDGES * edges.len() as f64
            && has_face_normals(normals, mesh, triangles);
        let angles = edges.iter().zip(&hard).filter_map(|(edge, &hard)| Some((surface.cosine(edge)?, hard)));
        Ok(Some(Self { is_flat, crease: separating(angles.collect()) }))
    }

    /// Returns the shading of flat-shaded triangles, or `None` for any other shading. This function
    /// is faster than [`Shading::of`] for most triangles that are not flat-shaded.
    ///
    /// # Errors
    /// The number of indices is not a multiple of three, or an index is out of range.
    ///
    /// ```
    #[doc = include_str!("normals/example.txt")]
    /// assert_eq!(Shading::of_flat(&roof, &triangles)?, Shading::of(&roof, &triangles)?);
    /// assert_eq!(Shading::of_flat(&roof, &triangles[..6])?, None);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of_flat(mesh: &Mesh, triangles: &[u32]) -> Result<Option<Self>, Error> {
        check_triangles(triangles.len())?;
        check_corners(triangles, mesh.vertex_count())?;
        if !normals_of(mesh).is_some_and(|normals| has_face_normals(normals, mesh, triangles)) {
            return Ok(None);
        }
        Ok(Self::of(mesh, triangles)?.filter(Self::is_flat))
    }

    /// Returns whether the triangles are flat-shaded.
    ///
    /// ```
    #[doc = include_str!("normals/example.txt")]
    /// // One side alone is a plane without hard edges.
    /// assert!(Shading::of(&roof, &triangles[..6])?.is_some_and(|shading| !shading.is_flat()));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn is_flat(&self) -> bool {
        self.is_flat
    }

    /// Returns unit normals for other triangles over the vertices of a mesh, three per triangle.
    /// `before` contains the triangles that have this shading. A triangle without area gets the
    /// normals of its vertices, or zero if they have none.
    ///
    /// # Errors
    /// A number of indices is not a multiple of three, or an index is out of range.
    ///
    /// ```
    #[doc = include_str!("normals/example.txt")]
    /// let shading = Shading::of(&roof, &triangles)?.unwrap_or_default();
    /// // A triangle from the front of the roof to the end of its back.
    /// let normals = shading.corner_normals(&roof, &triangles, &[0, 1, 8])?;
    /// assert!(normals.iter().all(|n| n[1] == n[2] && n[1] > 0.7));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn corner_normals(
        &self,
        mesh: &Mesh,
        before: &[u32],
        triangles: &[u32],
    ) -> Result<Vec<[f32; 3]>, Error> {
        self.normals_of_corners(mesh, before, triangles, false)
    }

    /// Returns normals like [`Shading::corner_normals`], but a corner keeps its vertex normal if
    /// this normal fits the face. If none of the candidates fits, the corner gets the face normal.
    ///
    /// # Errors
    /// A number of indices is not a multiple of three, or an index is out of range.
    ///
    /// ```
    #[doc = include_str!("normals/example.txt")]
    /// let shading = Shading::of(&roof, &triangles)?.unwrap_or_default();
    /// // A triangle on the back with a vertex of the front.
    /// let normals = shading.repaired_normals(&roof, &triangles, &[5, 8, 11])?;
    /// assert_eq!(normals, [[0.0, 1.0, 0.0]; 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn repaired_normals(
        &self,
        mesh: &Mesh,
        before: &[u32],
        triangles: &[u32],
    ) -> Result<Vec<[f32; 3]>, Error> {
        self.normals_of_corners(mesh, before, triangles, true)
    }

    /// Returns the normal of each corner; with `keeps`, the vertex normal where it fits.
    fn normals_of_corners(
        &self,
        mesh: &Mesh,
        before: &[u32],
        triangles: &[u32],
        keeps: bool,
    ) -> Result<Vec<[f32; 3]>, Error> {
        check_triangles(before.len())?;
        check_corners(before, mesh.vertex_count())?;
        let surface = TriangleNormals::new(mesh, triangles)?;
        let stored = normals_of(mesh);
        let own = |corner: usize| stored.and_then(|stored| scaled_to_one(vector(stored, triangles[corner])));
        let smooth = if self.is_flat {
            Vec::new()
        } else {
            let known = KnownNormals::new(mesh, before, triangles);
            self.smooth(&surface, mesh, triangles, &known)
        };
        let normal = |corner: usize| {
            let face = surface.normals[corner / 3];
            let is_fit = |&normal: &Point| face.is_none_or(|face| fits(normal, face));
            let smooth = smooth.get(corner).copied().flatten();
            let new = if keeps { own(corner).filter(is_fit).or(smooth.filter(is_fit)) } else { smooth };
            new.or(face).or_else(|| own(corner)).unwrap_or([0.0; 3])
        };
        Ok((0..triangles.len()).map(|corner| normal(corner).map(|x| x as f32)).collect())
    }

    /// Returns for each corner the known normal that fits its face, or else the normal of the faces
    /// around it up to the creases; `None` where these cancel out.
    fn smooth(
        &self,
        surface: &TriangleNormals,
        mesh: &Mesh,
        triangles: &[u32],
        known: &KnownNormals,
    ) -> Vec<Option<Point>> {
        let mut fans = UnionFind::new(triangles.len());
        for edge in surface.inner_edges() {
            if surface.cosine(&edge).is_some_and(|cosine| cosine >= self.crease) {
                edge.ends.iter().for_each(|&[a, b]| fans.unite(a, b));
            }
        }
        let mut sums = vec![[0.0; 3]; triangles.len()];
        for (corner, weighted) in
            triangles_of(triangles).flat_map(|t| weighted_normals(positions(mesh, t))).enumerate()
        {
            let sum = &mut sums[fans.find(corner as u32) as usize];
            *sum = [0, 1, 2].map(|k| sum[k] + weighted[k]);
        }
        let of_fan = |corner: usize| scaled_to_one(sums[corner]).map(|mean| known.nearest(corner, mean));
        let of_fans: Vec<Option<Point>> =
            (0..triangles.len()).map(|c| if fans.is_root(c as u32) { of_fan(c) } else { None }).collect();
        let normal = |corner: usize| {
            let fitting = surface.normals[corner / 3].and_then(|face| known.fitting(corner, face));
            fitting.or(of_fans[fans.find(corner as u32) as usize])
        };
        (0..triangles.len()).map(normal).collect()
    }
}

impl Default for Shading {
    /// Returns the shading of a surface without hard edges.
    fn default() -> Self {
        Self { is_flat: false, crease: -2.0 }
    }
}

/// Returns whether nearly all corners have their face normals. Triangles without area are ignored.
fn has_face_normals(normals: &Attribute, mesh: &Mesh, triangles: &[u32]) -> bool {
    let (mut fitting, mut all) = (0_usize, 0_usize);
    for corners in triangles_of(triangles) {
        let Some(face) = unit_normal(positions(mesh, corners)) else { continue };
        let fits = |&v: &u32| {
            scaled_to_one(vector(normals, v)).is_some_and(|normal| dot(normal, face) >= SAME_NORMAL)
        };
        (fitting, all) = (fitting + corners.iter().filter(|v| fits(v)).count(), all + 3);
    }
    all > 0 && fitting as f64 >= FLAT_CORNERS * all as f64
}

/// Returns whether two normals differ by more than rounding.
fn differ(a: Point, b: Point) -> bool {
    match (scaled_to_one(a), scaled_to_one(b)) {
        (Some(a), Some(b)) => dot(a, b) < SAME_NORMAL,
        (a, b) => a.is_some() != b.is_some(),
    }
}

/// Returns the cosine that best separates hard edges (lower cosines) from the others. Ties go to
/// the largest angle.
fn separating(mut edges: Vec<(f64, bool)>) -> f64 {
    edges.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let hard_count = edges.iter().filter(|(_, hard)| *hard).count();
    // If the threshold is below all edges, none is classified as hard, so every hard edge is wrong.
    let (mut fewest, mut best) = (hard_count, Shading::default().crease);
    let mut wrong = hard_count;
    for (i, &(cosine, hard)) in edges.iter().enumerate() {
        wrong = if hard { wrong - 1 } else { wrong + 1 };
        let next = edges.get(i + 1).map_or(2.0, |edge| edge.0);
        if wrong < fewest && next > cosine {
            (fewest, best) = (wrong, f64::midpoint(cosine, next));
        }
    }
    best
}

/// Returns the contribution of a triangle to the normal at each of its corners, by Max's weights.
fn weighted_normals(corners: [Point; 3]) -> [Point; 3] {
    [0, 1, 2].map(|k| {
        let [to_next, to_previous] = [1, 2].map(|step| sub(corners[(k + step) % 3], corners[k]));
        let weight = dot(to_next, to_next) * dot(to_previous, to_previous);
        let normal = cross(to_next, to_previous);
        if weight > 0.0 { normal.map(|x| x / weight) } else { [0.0; 3] }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{AttributeData, Faces};

    fn with_normals(positions: Vec<[f32; 3]>, normals: &[[f32; 3]]) -> Mesh {
        let data = AttributeData::F32(normals.as_flattened().to_vec());
        let normals = Attribute { name: "NORMAL".into(), components: 3, normalized: false, data };
        Mesh::new(positions, Faces::default()).unwrap().with_attribute(normals).unwrap()
    }

    /// Returns a tube of `sides` sides around the z axis, with caps and smooth or flat sides.
    fn tube(sides: u32, is_smooth: bool) -> (Mesh, Vec<u32>) {
        let angle = |i: u32| f64::from(i % sides) / f64::from(sides) * std::f64::consts::TAU;
        let at = |i: u32, z: f32| [angle(i).cos() as f32, angle(i).sin() as f32, z];
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        let mut quad_of = |corners: [[f32; 3]; 3], given: Option<[[f32; 3]; 3]>| {
            let face = scaled_to_one(crate::vector::normal_of(corners.map(|p| p.map(f64::from)))).unwrap();
            positions.extend(corners);
            normals.extend(given.unwrap_or([face.map(|x| x as f32); 3]));
        };
        for i in 0..sides {
            let round = |j: u32| [at(j, 0.0)[0], at(j, 0.0)[1], 0.0];
            let smooth = |js: [u32; 3]| is_smooth.then_some(js.map(round));
            quad_of([at(i, 0.0), at(i + 1, 0.0), at(i + 1, 1.0)], smooth([i, i + 1, i + 1]));
            quad_of([at(i, 0.0), at(i + 1, 1.0), at(i, 1.0)], smooth([i, i + 1, i]));
            quad_of([at(i, 1.0), at(i + 1, 1.0), [0.0, 0.0, 1.0]], None);
            quad_of([at(i + 1, 0.0), at(i, 0.0), [0.0, 0.0, 0.0]], None);
        }
        let count = positions.len() as u32;
        (with_normals(positions, &normals), (0..count).collect())
    }

    #[test]
    fn flat_and_smooth_sides_are_told_apart() {
        let (mesh, triangles) = tube(12, false);
        let flat = Shading::of(&mesh, &triangles).unwrap().unwrap();
        assert!(flat.is_flat());
        let (mesh, triangles) = tube(12, true);
        let creased = Shading::of(&mesh, &triangles).unwrap().unwrap();
        assert!(!creased.is_flat());
        // The sides meet at 30 degrees, and the caps at 90.
        assert!((0.0..0.87).contains(&creased.crease), "{creased:?}");
    }

    /// Recomputed normals of unchanged triangles equal the old ones, also at the hard rims of a
    /// cylinder with smooth sides.
    #[test]
    fn normals_of_the_same_faces_are_the_old_ones() {
        for (sides, is_smooth) in [(12, false), (12, true), (40, true)] {
            let (mesh, triangles) = tube(sides, is_smooth);
            let shading = Shading::of(&mesh, &triangles).unwrap().unwrap();
            let found = shading.corner_normals(&mesh, &triangles, &triangles).unwrap();
            let old = normals_of(&mesh).unwrap();
            for (corner, normal) in found.iter().enumerate() {
                let cosine = dot(normal.map(f64::from), vector(old, corner as u32));
                assert!(cosine > 0.9999, "{sides} {is_smooth} corner {corner}: {normal:?}");
            }
        }
    }

    #[test]
    fn hard_edges_are_separated_by_their_angle() {
        assert!(separating(vec![]) < -1.0);
        assert!(separating(vec![(0.9, false), (0.2, false)]) < -1.0);
        assert!(separating(vec![(0.9, true), (0.2, true)]) > 1.0);
        let mixed = vec![(0.1, true), (0.9, false), (0.3, true), (0.95, false), (0.99, true)];
        assert!((separating(mixed) - 0.6).abs() < 1e-9);
    }

    #[test]
    fn hostile_values_are_no_normals() {
        let huge = f32::MAX;
        let positions = vec![[0.0; 3], [huge, 0.0, 0.0], [0.0, huge, 0.0], [0.0; 3], [0.0; 3]];
        let mesh = with_normals(positions, &[[f32::NAN, 0.0, 1.0]; 5]);
        let triangles = [0, 1, 2, 0, 3, 4, 2, 2, 2];
        let shading = Shading::of(&mesh, &triangles).unwrap().unwrap();
        let normals = shading.corner_normals(&mesh, &triangles, &triangles).unwrap();
        assert_eq!(normals, [[0.0, 0.0, 1.0]; 9]);
        assert!(
            Shading::of(&mesh, &[0, 1]).is_err()
                && shading.corner_normals(&mesh, &triangles, &[0, 1, 5]).is_err()
        );
        assert!(shading.corner_normals(&mesh, &[0, 1, 5], &triangles).is_err());
    }
}
