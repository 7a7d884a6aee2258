//! The surface: a mesh's faces made ready for strips, so that every method meets only proper ones.
//!
//! On a surface every face has at least three corners, all different, and is a triangle or convex. Where the mesh is that
//! already, the surface borrows its faces.
//!
//! # Algorithm
//! 1. On request, vertices in use with the same bits in position and all attributes are named by the first of them.
//! 2. Corners that repeat the one before are left out; faces with fewer than three left draw nothing and are dropped, counted.
//! 3. Polygons are projected along their normal (Newell's sum). Convex is one that turns left at every corner and goes around
//!    once, or that lies along its convex hull as closely as the rounding of its coordinates to 32-bit floats. One that is
//!    not, or that passes a vertex twice, is cut into triangles by ear cutting. Where the cutter's result is not a triangulation
//!    of all corners (it drops corners on straight edges), or the polygon is too large for it, the polygon becomes a fan,
//!    counted: still each of its corners, still its boundary.
//!
//! # Complexity
//! O(n) over the corners; O(k log k) for a polygon of k corners that is convex up to rounding, and O(k²) at worst to cut one that is
//! not: k is at most [`EAR_CORNERS`], and the sum of k² over the large ones at most [`EAR_STEPS`], so that all of it stays O(n) with a
//! bound of a second or two on top. No memory where nothing is changed.

use std::borrow::Cow;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::mesh::{Faces, Mesh, vertex_bits};

/// A corner may turn the wrong way by this sine and count as straight.
const STRAIGHT: f64 = 1e-6;

/// How far two points may stand from where they were before their coordinates became 32-bit floats, in parts of the
/// largest coordinate: half a unit of the last place each, along three axes.
const ROUNDING: f64 = 1.732_051 * f32::EPSILON as f64;

/// The most corners of a polygon that is cut by ears. The cutter goes by a z-order curve and takes less than 0.3 ms for 2,000
/// corners of combs, bowls and round shapes, but up to 28 ns · k² for polygons that cross themselves (tuned on stars, combs,
/// spirals, random and self-crossing polygons of 1,000 to 16,000 corners): 0.47 s at this limit.
pub const EAR_CORNERS: usize = 4096;

/// The most that k² of the polygons cut by ears, those of more than [`EAR_SMALL`] corners, may add up to in a mesh: four of
/// the largest, 1.4 s at worst.
pub const EAR_STEPS: usize = 4 * EAR_CORNERS * EAR_CORNERS;

/// Polygons of up to so many corners are always cut by ears: 7 µs a corner at worst.
pub const EAR_SMALL: usize = 256;

/// Faces that are triangles or convex polygons with different corners.
#[derive(Debug, Clone)]
pub struct PreparedFaces<'a> {
    faces: Cow<'a, Faces>,
    vertex_count: usize,
    counts: PreparedCounts,
}

/// What was changed to make a mesh's faces ready.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PreparedCounts {
    /// Vertices in use that another one with the same bits stands for (`--weld`).
    pub welded_vertices: usize,
    /// Faces that draw nothing, left out: fewer than three different corners in a row.
    pub degenerate_faces: usize,
    /// Polygons that are not convex, cut into triangles beforehand.
    pub cut_polygons: usize,
    /// Of those, the ones that became a fan, as the ear cutter found no triangulation of all their corners, or as they were
    /// too large for it.
    pub fanned_polygons: usize,
}

impl<'a> PreparedFaces<'a> {
    /// Makes a mesh's faces ready; `weld` lets vertices with the same bits stand for each other.
    ///
    /// ```
    /// use tristrip::{Faces, Mesh, PreparedFaces};
    /// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let mesh = Mesh::new(positions, Faces::from_triangles(vec![0, 1, 2, 1, 1, 2])?)?;
    /// let surface = PreparedFaces::new(&mesh, false);
    /// assert_eq!((surface.faces().face_count(), surface.counts().degenerate_faces), (1, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(mesh: &'a Mesh, weld: bool) -> Self {
        let mut counts = PreparedCounts::default();
        let mut faces = Cow::Borrowed(mesh.faces());
        if weld {
            let welded = weld_corners(mesh);
            counts.welded_vertices = welded.count;
            if welded.count > 0 {
                faces = Cow::Owned(mesh.faces().renamed(welded.corners));
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
    pub fn counts(&self) -> PreparedCounts {
        self.counts
    }
}

/// The corners of a mesh's faces by the first vertex in use with the same bits.
struct Welded {
    corners: Vec<u32>,
    /// Vertices in use that another one stands for.
    count: usize,
}

/// Names each corner by the first vertex in use with the same bits in position and all attributes.
fn weld_corners(mesh: &Mesh) -> Welded {
    let mut used = mesh.faces().corners().to_vec();
    used.sort_unstable();
    used.dedup();
    let mut first: HashMap<Vec<u8>, u32, BuildHasherDefault<Fnv>> = HashMap::default();
    let stands_for: Vec<u32> =
        used.iter().map(|&v| *first.entry(vertex_bits(mesh, v as usize)).or_insert(v)).collect();
    let count = used.iter().zip(&stands_for).filter(|(v, first)| v != first).count();
    let place = |&v: &u32| stands_for[used.partition_point(|&u| u < v)];
    Welded { corners: mesh.faces().corners().iter().map(place).collect(), count }
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
fn clean(faces: &Faces, positions: &[[f32; 3]], counts: &mut PreparedCounts) -> Option<Faces> {
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
    let mut steps_left = EAR_STEPS;
    let mut affordable = |k: usize| {
        let steps = if k > EAR_SMALL { k.saturating_mul(k) } else { 0 };
        let fits = k <= EAR_CORNERS && steps <= steps_left;
        steps_left -= if fits { steps } else { 0 };
        fits
    };
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
            let cut = if affordable(polygon.len()) { cut_ears(&polygon, positions) } else { None };
            let triangles = cut.unwrap_or_else(|| {
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

/// Tells whether a polygon is convex in its plane, straight corners and rounding allowed; one without area counts as convex,
/// since no triangulation of it is better than another.
fn is_convex(polygon: &[u32], positions: &[[f32; 3]]) -> bool {
    let Some(points) = project(polygon, positions) else { return true };
    if turns_left(&points) {
        return true;
    }
    let coordinates = polygon.iter().flat_map(|&v| positions[v as usize]);
    let largest = coordinates.fold(0.0, |most: f32, x| most.max(x.abs()));
    lies_along_hull(&points, ROUNDING * f64::from(largest))
}

/// Tells whether a polygon turns left at every corner, or not at all, and goes around once.
fn turns_left(points: &[[f64; 2]]) -> bool {
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

/// Tells whether a polygon runs along its convex hull, counter-clockwise and once, no corner farther than `tolerance` from
/// the hull or that far behind another one. Unlike the corners' turns this sees a bend of many corners, each of which bends by
/// less than its rounding.
fn lies_along_hull(points: &[[f64; 2]], tolerance: f64) -> bool {
    let hull = hull(points);
    let n = points.len();
    let Some(first) = (0..hull.len()).min_by_key(|&i| hull[i]) else { return false };
    let corner = |i: usize| hull[(first + i) % hull.len()] + if i < hull.len() { 0 } else { n };
    hull.len() > 2
        && (0..hull.len()).all(|i| {
            let (start, end) = (corner(i), corner(i + 1));
            let (p, q) = (points[start % n], points[end % n]);
            let along = [q[0] - p[0], q[1] - p[1]];
            let length = along[0].hypot(along[1]);
            let mut farthest = 0.0_f64;
            start < end
                && (start + 1..end).all(|j| {
                    let r = [points[j % n][0] - p[0], points[j % n][1] - p[1]];
                    let inside = (along[0] * r[1] - along[1] * r[0]) / length;
                    let forward = (along[0] * r[0] + along[1] * r[1]) / length;
                    let close = inside <= tolerance
                        && forward >= farthest - tolerance
                        && forward <= length + tolerance;
                    farthest = farthest.max(forward);
                    close
                })
        })
}

/// Gives the corners of the convex hull counter-clockwise (Andrew's monotone chain).
fn hull(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let by_place = |&a: &usize, &b: &usize| {
        let (p, q) = (points[a], points[b]);
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(a.cmp(&b))
    };
    order.sort_unstable_by(by_place);
    let left = |a: usize, b: usize, c: usize| {
        let (p, q, r) = (points[a], points[b], points[c]);
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0.0
    };
    let chain = |order: &mut dyn Iterator<Item = usize>| {
        let mut chain: Vec<usize> = Vec::new();
        for corner in order {
            while chain.len() > 1 && !left(chain[chain.len() - 2], chain[chain.len() - 1], corner) {
                chain.pop();
            }
            chain.push(corner);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut order.iter().copied());
    hull.extend(chain(&mut order.iter().rev().copied()));
    hull
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
            let surface = PreparedFaces::new(&mesh, false);
            assert_eq!(surface.faces().face_count(), 2);
            assert_eq!(surface.counts(), PreparedCounts { cut_polygons: 1, ..Default::default() });
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
        let surface = PreparedFaces::new(&mesh, false);
        (surface.faces().face_count(), surface.counts())
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
    fn a_bend_is_seen_however_many_corners_it_has() {
        // A crescent: its inner side bends by less at each corner than rounding may.
        let n = 40_000;
        let x = |i: usize| i as f32 / n as f32 * 2.0 - 1.0;
        let outer = (0..=n).map(|i| [x(i), 1.0 - x(i) * x(i)]);
        let inner = (1..n).rev().map(|i| [x(i), 0.5 - 0.5 * x(i) * x(i)]);
        let crescent: Vec<[f32; 2]> = outer.chain(inner).collect();
        let polygon: Vec<u32> = (0..crescent.len() as u32).collect();
        assert!(!is_convex(&polygon, &flat(&crescent)));
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

        // Many of the largest are cut while the steps last; small ones always are.
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
