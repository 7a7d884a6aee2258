//! Convexity of polygons in space.
//!
//! # Algorithm
//! 1. Project the polygon along its normal (Newell's sum).
//! 2. The polygon is convex if it turns left at every corner and goes around once, or if it follows
//!    its convex hull up to the rounding of its coordinates to 32-bit floats.
//!
//! Results are identical on every machine: the arithmetic consists of sums, products, quotients and
//! square roots, and Shewchuk's adaptive predicates for the hull.
//!
//! # References
//! Andrew: *Another Efficient Algorithm for Convex Hulls in Two Dimensions*, 1979; Shewchuk:
//! *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, 1997.
//!
//! # Complexity
//! O(k log k) for k corners, or O(k) if the polygon turns left at every corner.

use robust::{Coord, orient2d};

use crate::mesh::Positions;
use crate::vector::{cross, dot, sub, unit};

/// A corner counts as straight if it turns right by an angle whose sine is at most this.
const STRAIGHT: f64 = 1e-6;

/// The distance by which rounding to 32-bit floats may have moved two points relative to each
/// other, as a fraction of the largest coordinate: half a unit in the last place per point, along
/// three axes.
const ROUNDING: f64 = 1.732_051 * f32::EPSILON as f64;

/// Returns whether a polygon is convex in its plane, allowing for straight corners and rounding. A
/// polygon without area counts as convex, because all its triangulations are equivalent.
pub(super) fn is_convex<P: Positions + ?Sized>(polygon: &[u32], positions: &P) -> bool {
    let Some(points) = project(polygon, positions) else { return true };
    if turns_left(&points) {
        return true;
    }
    let coordinates = polygon.iter().flat_map(|&v| positions.position(v as usize).unwrap_or_default());
    let largest = coordinates.fold(0.0, |largest: f32, x| largest.max(x.abs()));
    lies_along_hull(&points, ROUNDING * f64::from(largest))
}

/// Returns whether a polygon turns left or goes straight at every corner, and goes around once.
fn turns_left(points: &[[f64; 2]]) -> bool {
    let n = points.len();
    let edge = |i: usize| {
        let (p, q) = (points[i % n], points[(i + 1) % n]);
        [q[0] - p[0], q[1] - p[1]]
    };
    let square = |e: [f64; 2]| e[0] * e[0] + e[1] * e[1];
    // Compare squares instead of lengths. The coordinates are differences of 32-bit floats, so
    // their fourth powers do not overflow.
    let turns_right = |i: usize| {
        let (a, b) = (edge(i), edge(i + 1));
        let cross = a[0] * b[1] - a[1] * b[0];
        cross < 0.0 && cross * cross > STRAIGHT * STRAIGHT * square(a) * square(b)
    };
    // A star turns left at every corner but goes around more than once: its direction along an axis
    // changes more than twice.
    let signs: Vec<bool> = (0..n).map(edge).filter(|e| e[0] != 0.0).map(|e| e[0] > 0.0).collect();
    let changes = (0..signs.len()).filter(|&i| signs[i] != signs[(i + 1) % signs.len()]).count();
    changes <= 2 && !(0..n).any(turns_right)
}

/// Returns whether a polygon follows its convex hull counter-clockwise and once. No corner may be
/// farther than `tolerance` from the hull, or farther than that behind an earlier corner. Unlike
/// `turns_left` this detects a concave bend over many corners, each of which bends by less than its
/// rounding.
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
            let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
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

/// Returns the corners of the convex hull in counter-clockwise order (Andrew's monotone chain with
/// exact predicates).
fn hull(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let by_position = |&a: &usize, &b: &usize| {
        let (p, q) = (points[a], points[b]);
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(a.cmp(&b))
    };
    order.sort_unstable_by(by_position);
    let left = |a: usize, b: usize, c: usize| {
        let [p, q, r] = [a, b, c].map(|i| Coord { x: points[i][0], y: points[i][1] });
        orient2d(p, q, r) > 0.0
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

/// Projects a polygon along its normal, which is Newell's sum. Returns `None` if the polygon has no
/// area.
pub(super) fn project<P: Positions + ?Sized>(polygon: &[u32], positions: &P) -> Option<Vec<[f64; 2]>> {
    let vertex = |i: usize| polygon[i % polygon.len()] as usize;
    let at = |i: usize| positions.position(vertex(i)).unwrap_or_default().map(f64::from);
    let origin = at(0);
    let local = |i: usize| sub(at(i), origin);
    let mut normal = [0.0; 3];
    for i in 0..polygon.len() {
        let (p, q) = (local(i), local(i + 1));
        normal[0] += (p[1] - q[1]) * (p[2] + q[2]);
        normal[1] += (p[2] - q[2]) * (p[0] + q[0]);
        normal[2] += (p[0] - q[0]) * (p[1] + q[1]);
    }
    let length = dot(normal, normal).sqrt();
    if length == 0.0 || !length.is_finite() {
        return None;
    }
    let n = normal.map(|x| x / length);
    // Choose two axes in the polygon's plane, starting from a coordinate axis far from the normal.
    let axis = if n[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = unit(cross(axis, n));
    let v = cross(n, u);
    Some((0..polygon.len()).map(|i| [dot(local(i), u), dot(local(i), v)]).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(points: &[[f32; 2]]) -> Vec<[f32; 3]> {
        points.iter().map(|p| [p[0], 7.0, p[1]]).collect()
    }

    #[test]
    fn stars_are_not_convex_and_straight_corners_are() {
        let star: Vec<[f32; 2]> = (0..5).map(|i| (i as f32 * 2.0 * 1.256_637).sin_cos().into()).collect();
        let round: Vec<[f32; 2]> = (0..5).map(|i| (i as f32 * 1.256_637).sin_cos().into()).collect();
        assert!(!is_convex(&[0, 1, 2, 3, 4], &flat(&star)));
        assert!(is_convex(&[0, 1, 2, 3, 4], &flat(&round)));
        let straight = flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 2.0]]);
        assert!(is_convex(&[0, 1, 2, 3], &straight));
        assert!(is_convex(&[0, 1, 2, 1], &flat(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])), "no area");
    }

    #[test]
    fn tiny_and_huge_polygons_are_classified_like_others() {
        let square = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
        let arrow = [[0.0, 0.0], [2.0, 1.0], [0.0, 2.0], [0.5, 1.0]];
        for scale in [f32::from_bits(1 << 4), f32::MIN_POSITIVE, 1.0, f32::MAX / 4.0] {
            let scaled = |points: [[f32; 2]; 4]| flat(&points.map(|p| p.map(|x| x * scale)));
            // A large second coordinate would leave no precision for tiny squares.
            let positions =
                |points| scaled(points).into_iter().map(|p| [p[0], 0.0, p[2]]).collect::<Vec<_>>();
            assert!(is_convex(&[0, 1, 2, 3], &positions(square)), "{scale}");
            assert!(!is_convex(&[0, 1, 2, 3], &positions(arrow)), "{scale}");
        }
    }

    #[test]
    fn a_concave_bend_is_detected_however_many_corners_it_has() {
        // A crescent: each corner of its inner side bends by less than its rounding.
        let n = 40_000;
        let x = |i: usize| i as f32 / n as f32 * 2.0 - 1.0;
        let outer = (0..=n).map(|i| [x(i), 1.0 - x(i) * x(i)]);
        let inner = (1..n).rev().map(|i| [x(i), 0.5 - 0.5 * x(i) * x(i)]);
        let crescent: Vec<[f32; 2]> = outer.chain(inner).collect();
        let polygon: Vec<u32> = (0..crescent.len() as u32).collect();
        assert!(!is_convex(&polygon, &flat(&crescent)));
    }
}
