//! The surface: a mesh's faces made ready for strips, so that every method meets only proper ones.
//!
//! On a surface every face has at least three corners, all different, and is a triangle or convex. Where the mesh is that
//! already, the surface borrows its faces.
//!
//! # Algorithm
//! 1. On request, vertices with the same bits in position and all attributes are named by the first of them.
//! 2. Corners that repeat the one before are left out; faces with fewer than three left draw nothing and are dropped, counted.
//! 3. Polygons are projected along their normal (Newell's sum). One that is not convex, or that passes a vertex twice, is cut
//!    into triangles by ear cutting. Where the cutter's result is not a triangulation of all corners (it drops corners on
//!    straight edges), the polygon becomes a fan, counted: still each of its corners, still its boundary.
//!
//! # Complexity
//! O(n) over the corners, O(k²) at worst for one polygon of k corners that is not convex. No memory where nothing is changed.

use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::{AttributeData, Faces, Mesh};

/// A corner may turn the wrong way by this sine and count as straight.
const STRAIGHT: f64 = 1e-6;

/// Faces that are triangles or convex polygons with different corners.
#[derive(Debug, Clone)]
pub struct Surface<'a> {
    faces: Cow<'a, Faces>,
    vertex_count: usize,
    counts: SurfaceCounts,
}

/// What was changed to make a mesh's faces ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SurfaceCounts {
    /// Vertices that another one with the same bits stands for (`--weld`).
    pub welded_vertices: usize,
    /// Faces that draw nothing, left out: fewer than three different corners in a row.
    pub degenerate_faces: usize,
    /// Polygons that are not convex, cut into triangles beforehand.
    pub cut_polygons: usize,
    /// Of those, the ones that became a fan, as the ear cutter found no triangulation of all their corners.
    pub fanned_polygons: usize,
}

impl<'a> Surface<'a> {
    /// Makes a mesh's faces ready; `weld` lets vertices with the same bits stand for each other.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, Surface};
    /// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 1, 1, 2])?)?;
    /// let surface = Surface::new(&mesh, false);
    /// assert_eq!((surface.faces().face_count(), surface.counts().degenerate_faces), (1, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(mesh: &'a Mesh, weld: bool) -> Self {
        let mut counts = SurfaceCounts::default();
        let mut faces = Cow::Borrowed(mesh.faces());
        if weld {
            let representative = same_vertices(mesh);
            counts.welded_vertices = (0..).zip(&representative).filter(|&(v, &r)| v != r).count();
            if counts.welded_vertices > 0 {
                let corners = faces.corners.iter().map(|&v| representative[v as usize]).collect();
                faces = Cow::Owned(Faces { corners, offsets: mesh.faces().offsets.clone() });
            }
        }
        let faces = match clean(&faces, mesh.positions(), &mut counts) {
            Some(cleaned) => Cow::Owned(cleaned),
            None => faces,
        };
        Self { faces, vertex_count: mesh.vertex_count(), counts }
    }

    /// Gives the faces.
    pub fn faces(&self) -> &Faces {
        &self.faces
    }

    /// Counts the vertices of the mesh, used or not.
    pub fn vertex_count(&self) -> usize {
        self.vertex_count
    }

    /// Tells what was changed.
    pub fn counts(&self) -> SurfaceCounts {
        self.counts
    }
}

/// Gives for each vertex the first one with the same bits in position and all attributes.
fn same_vertices(mesh: &Mesh) -> Vec<u32> {
    let mut first: HashMap<Vec<u8>, u32, BuildHasherDefault<Fnv>> = HashMap::default();
    (0..mesh.vertex_count())
        .map(|v| {
            let mut key = Vec::new();
            mesh.positions()[v].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes()));
            for attribute in mesh.attributes() {
                let n = usize::from(attribute.components.max(1));
                let range = v * n..(v + 1) * n;
                match &attribute.data {
                    AttributeData::F32(d) => {
                        d[range].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes()))
                    }
                    AttributeData::F64(d) => {
                        d[range].iter().for_each(|x| key.extend(x.to_bits().to_le_bytes()))
                    }
                    AttributeData::U8(d) => key.extend(&d[range]),
                    AttributeData::I8(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
                    AttributeData::U16(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
                    AttributeData::I16(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
                    AttributeData::U32(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
                    AttributeData::I32(d) => d[range].iter().for_each(|x| key.extend(x.to_le_bytes())),
                }
            }
            *first.entry(key).or_insert(v as u32)
        })
        .collect()
}

/// The Fowler–Noll–Vo hash: the same on every machine and in every run.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hasher for Fnv {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.0 = (self.0 ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Gives proper faces where some are not; `None` where all are proper already.
fn clean(faces: &Faces, positions: &[[f32; 3]], counts: &mut SurfaceCounts) -> Option<Faces> {
    let proper = |polygon: &[u32]| match *polygon {
        [a, b, c] => a != b && b != c && c != a,
        _ => polygon.len() > 3 && all_different(polygon) && is_convex(polygon, positions),
    };
    if faces.iter().all(proper) {
        return None;
    }
    let mut offsets = vec![0];
    let mut corners: Vec<u32> = Vec::with_capacity(faces.corner_count());
    let mut polygon: Vec<u32> = Vec::new();
    for face in faces.iter() {
        polygon.clear();
        polygon.extend_from_slice(face);
        polygon.dedup();
        while polygon.len() > 1 && polygon.first() == polygon.last() {
            polygon.pop();
        }
        if proper(&polygon) {
            corners.extend_from_slice(&polygon);
            offsets.push(corners.len() as u32);
        } else if polygon.len() < 3 {
            counts.degenerate_faces += 1;
        } else {
            counts.cut_polygons += 1;
            let triangles = cut_ears(&polygon, positions).unwrap_or_else(|| {
                counts.fanned_polygons += 1;
                (1..polygon.len() - 1).map(|i| [polygon[0], polygon[i], polygon[i + 1]]).collect()
            });
            // A vertex that the polygon passes twice may give triangles without area of their own.
            for t in triangles.iter().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) {
                corners.extend_from_slice(t);
                offsets.push(corners.len() as u32);
            }
        }
    }
    Faces::from_offsets(offsets, corners).ok()
}

fn all_different(polygon: &[u32]) -> bool {
    if polygon.len() <= 16 {
        return polygon.iter().enumerate().all(|(i, v)| !polygon[..i].contains(v));
    }
    let mut sorted = polygon.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).all(|w| w[0] != w[1])
}

/// Projects a polygon along its normal; `None` where it has no area.
fn project(polygon: &[u32], positions: &[[f32; 3]]) -> Option<Vec<[f64; 2]>> {
    let at = |i: usize| positions[polygon[i % polygon.len()] as usize].map(f64::from);
    let origin = at(0);
    let local = |i: usize| {
        let p = at(i);
        [p[0] - origin[0], p[1] - origin[1], p[2] - origin[2]]
    };
    let mut normal = [0.0; 3];
    for i in 0..polygon.len() {
        let (p, q) = (local(i), local(i + 1));
        normal[0] += (p[1] - q[1]) * (p[2] + q[2]);
        normal[1] += (p[2] - q[2]) * (p[0] + q[0]);
        normal[2] += (p[0] - q[0]) * (p[1] + q[1]);
    }
    let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length == 0.0 || !length.is_finite() {
        return None;
    }
    let n = normal.map(|x| x / length);
    // Two axes in the polygon's plane, from the coordinate axis that is farthest from its normal.
    let helper = if n[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = unit(cross(helper, n));
    let v = cross(n, u);
    Some((0..polygon.len()).map(|i| [dot(local(i), u), dot(local(i), v)]).collect())
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// Tells whether a polygon is convex in its plane, straight corners allowed; one without area counts as convex, since no
/// triangulation of it is better than another.
fn is_convex(polygon: &[u32], positions: &[[f32; 3]]) -> bool {
    let Some(points) = project(polygon, positions) else { return true };
    let n = points.len();
    let edge = |i: usize| {
        let (p, q) = (points[i % n], points[(i + 1) % n]);
        [q[0] - p[0], q[1] - p[1]]
    };
    let size = |e: [f64; 2]| e[0].hypot(e[1]);
    let turns_right = |i: usize| {
        let (a, b) = (edge(i), edge(i + 1));
        a[0] * b[1] - a[1] * b[0] < -STRAIGHT * size(a) * size(b)
    };
    // A star turns left at every corner but goes around more than once: it changes its course along an axis more than twice.
    let signs: Vec<bool> = (0..n).map(edge).filter(|e| e[0] != 0.0).map(|e| e[0] > 0.0).collect();
    let changes = (0..signs.len()).filter(|&i| signs[i] != signs[(i + 1) % signs.len()]).count();
    changes <= 2 && !(0..n).any(turns_right)
}

/// Cuts a polygon into triangles; `None` where the result is not a triangulation of all its corners.
fn cut_ears(polygon: &[u32], positions: &[[f32; 3]]) -> Option<Vec<[u32; 3]>> {
    let points = project(polygon, positions)?;
    let mut local: Vec<u32> = Vec::new();
    earcut::Earcut::new().earcut(points, &[], &mut local);
    let n = polygon.len() as u32;
    if local.len() != 3 * (polygon.len() - 2) {
        return None;
    }
    let mut triangles: Vec<[u32; 3]> = local.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    // The projection keeps the polygon counter-clockwise; the cutter may give either winding.
    let ascends = |t: &[u32; 3]| (t[0] < t[1]) as u8 + (t[1] < t[2]) as u8 + (t[2] < t[0]) as u8 == 2;
    if triangles.iter().any(|t| !ascends(t)) {
        triangles.iter_mut().for_each(|t| t.swap(0, 1));
    }
    // All boundary edges once, every other edge in both directions.
    let mut edges: Vec<(u32, u32)> =
        triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
    edges.sort_unstable();
    let once = edges.windows(2).all(|w| w[0] != w[1]);
    let matched = |&(a, b): &(u32, u32)| b == (a + 1) % n || edges.binary_search(&(b, a)).is_ok();
    let boundary = (0..n).all(|a| edges.binary_search(&(a, (a + 1) % n)).is_ok());
    (once && boundary && triangles.iter().all(ascends) && edges.iter().all(matched))
        .then(|| triangles.iter().map(|t| t.map(|i| polygon[i as usize])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
        points.iter().map(|p| [p[0], 7.0, p[1]]).collect()
    }

    #[test]
    fn cuts_polygons_that_are_not_convex() {
        let arrow = flat(&[[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]]);
        for polygon in [vec![0, 1, 2, 3], vec![3, 2, 1, 0]] {
            let mesh = Mesh::new(arrow.clone(), Faces::from_polygons([&polygon]).unwrap()).unwrap();
            let surface = Surface::new(&mesh, false);
            assert_eq!(surface.faces().face_count(), 2);
            assert_eq!(surface.counts(), SurfaceCounts { cut_polygons: 1, ..Default::default() });
            // The only diagonal inside joins 1 and 3.
            assert!(surface.faces().iter().all(|t| t.contains(&1) && t.contains(&3)));
        }
    }

    #[test]
    fn keeps_convex_polygons_and_cuts_stars() {
        let star: Vec<[f32; 2]> = (0..5).map(|i| (i as f32 * 2.0 * 1.256_637).sin_cos().into()).collect();
        let round: Vec<[f32; 2]> = (0..5).map(|i| (i as f32 * 1.256_637).sin_cos().into()).collect();
        assert!(!is_convex(&[0, 1, 2, 3, 4], &flat(&star)));
        assert!(is_convex(&[0, 1, 2, 3, 4], &flat(&round)));
        let straight = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 2.0]]);
        assert!(is_convex(&[0, 1, 2, 3], &straight));
        assert!(is_convex(&[0, 1, 2, 1], &flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])), "no area");
    }

    #[test]
    fn drops_what_draws_nothing_and_welds_on_request() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [1.0, 1.0, 0.0]];
        let faces =
            Faces::from_polygons([vec![0, 1, 2], vec![3, 0, 1], vec![2, 2, 1], vec![1, 4, 4, 2, 1], vec![0]]);
        let mesh = Mesh::new(positions, faces.unwrap()).unwrap();
        let counts = |weld| Surface::new(&mesh, weld).counts();
        assert_eq!(counts(false), SurfaceCounts { degenerate_faces: 2, ..Default::default() });
        assert_eq!(
            counts(true),
            SurfaceCounts { degenerate_faces: 3, welded_vertices: 1, ..Default::default() }
        );
        assert_eq!(Surface::new(&mesh, false).faces().face(2), [1, 4, 2]);
    }
}
