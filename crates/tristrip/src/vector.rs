//! Vectors in double precision, and distances to triangles.
//!
//! Uses only sums, products, quotients and square roots, whose results are identical on every
//! machine.

/// A point or vector in local coordinates.
pub(crate) type Point = [f64; 3];

#[inline]
pub(crate) fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline]
pub(crate) fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline]
pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns `a` scaled to length 1.
#[inline]
pub(crate) fn unit(a: Point) -> Point {
    let length = dot(a, a).sqrt();
    a.map(|x| x / length)
}

/// Returns the cross product of two edges of a triangle: a normal whose length is twice the area.
#[inline]
pub(crate) fn normal_of([a, b, c]: [Point; 3]) -> Point {
    cross(sub(b, a), sub(c, a))
}

/// Returns the squared distance from a point to a segment. A segment of zero length is treated as a
/// point.
#[inline]
pub(crate) fn to_segment(p: Point, [a, b]: [Point; 2]) -> f64 {
    let (along, to) = (sub(b, a), sub(p, a));
    let length = dot(along, along);
    let share = if length > 0.0 { (dot(along, to) / length).clamp(0.0, 1.0) } else { 0.0 };
    let rest = [0, 1, 2].map(|k| to[k] - share * along[k]);
    dot(rest, rest)
}

/// Returns the squared distance from a point to a triangle if it is less than `known`, otherwise
/// `known`. A triangle without area is treated as its edges.
///
/// If the foot of the perpendicular lies inside, this is the distance to the plane. Otherwise it is
/// the smallest distance to the edges that the foot lies beyond.
#[inline]
pub(crate) fn to_triangle(p: Point, corners: [Point; 3], known: f64) -> f64 {
    let normal = normal_of(corners);
    let (square, height) = (dot(normal, normal), dot(normal, sub(p, corners[0])));
    // No point of the triangle is closer than its plane.
    if height * height > known * square {
        return known;
    }
    let edge = |k: usize| [corners[k], corners[(k + 1) % 3]];
    // The cross product of the normal and an edge points inwards.
    let beyond = [0, 1, 2].map(|k| {
        let [from, to] = edge(k);
        dot(cross(normal, sub(to, from)), sub(p, from)) <= 0.0
    });
    let from_plane = height * height / square;
    if beyond == [false; 3] && !from_plane.is_nan() {
        return known.min(from_plane);
    }
    (0..3).filter(|&k| beyond[k]).fold(known, |least, k| least.min(to_segment(p, edge(k))))
}

/// Returns the point of a triangle closest to a given point, in barycentric coordinates: none is
/// negative, and they add up to 1. A triangle without area is treated as its edges.
///
/// Uses the formulas per Voronoi region from Ericson, *Real-Time Collision Detection*, 2005,
/// section 5.1.5.
///
/// ```
/// use tristrip::simplify::nearest_in_triangle;
/// let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// assert_eq!(nearest_in_triangle([1.0, 1.0, 5.0], corners), [0.0, 0.5, 0.5]);
/// assert_eq!(nearest_in_triangle([-1.0, -1.0, 0.0], corners), [1.0, 0.0, 0.0]);
/// ```
pub fn nearest_in_triangle(point: [f64; 3], corners: [[f64; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = corners;
    let normal = normal_of(corners);
    if dot(normal, normal) <= 0.0 {
        return nearest_on_edges(point, corners);
    }
    let (ab, ac) = (sub(b, a), sub(c, a));
    let along = |from: Point| (dot(ab, sub(point, from)), dot(ac, sub(point, from)));
    let ((a_b, a_c), (b_b, b_c), (c_b, c_c)) = (along(a), along(b), along(c));
    if a_b <= 0.0 && a_c <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    if b_b >= 0.0 && b_c <= b_b {
        return [0.0, 1.0, 0.0];
    }
    if c_c >= 0.0 && c_b <= c_c {
        return [0.0, 0.0, 1.0];
    }
    let [of_a, of_b, of_c] = [b_b * c_c - c_b * b_c, c_b * a_c - a_b * c_c, a_b * b_c - b_b * a_c];
    let all = of_a + of_b + of_c;
    if of_a > 0.0 && of_b > 0.0 && of_c > 0.0 {
        return [of_a / all, of_b / all, of_c / all];
    }
    nearest_on_edges(point, corners)
}

/// Returns the closest point on the edges of a triangle, in barycentric coordinates.
fn nearest_on_edges(p: Point, corners: [Point; 3]) -> [f64; 3] {
    let (mut least, mut nearest) = (f64::INFINITY, [1.0, 0.0, 0.0]);
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let (along, there) = (sub(corners[to], corners[from]), sub(p, corners[from]));
        let length = dot(along, along);
        let share = if length > 0.0 { (dot(along, there) / length).clamp(0.0, 1.0) } else { 0.0 };
        let rest = [0, 1, 2].map(|k| there[k] - share * along[k]);
        if dot(rest, rest) < least {
            least = dot(rest, rest);
            nearest = [0.0; 3];
            (nearest[from], nearest[to]) = (1.0 - share, share);
        }
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point> {
        [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64]
    }

    proptest! {
        /// The oracle samples many points of the triangle.
        #[test]
        fn no_point_of_the_triangle_is_nearer(p in point(), t in [point(), point(), point()]) {
            let found = to_triangle(p, t, f64::INFINITY).sqrt();
            let mut least = f64::INFINITY;
            let n = 60;
            for i in 0..=n {
                for j in 0..=n - i {
                    let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
                    let q = [0, 1, 2].map(|k| t[0][k] + u * (t[1][k] - t[0][k]) + v * (t[2][k] - t[0][k]));
                    least = least.min(dot(sub(p, q), sub(p, q)).sqrt());
                }
            }
            for known in [0.5 * found, 2.0 * found] {
                prop_assert!((to_triangle(p, t, known * known).sqrt() - known.min(found)).abs() < 1e-9);
            }
            prop_assert!(found <= least + 1e-9, "{} and {}", found, least);
            prop_assert!(found >= least - 4.0 / n as f64, "{} and {}", found, least);
        }
    }

    #[test]
    fn a_triangle_without_area_consists_of_its_edges() {
        let line = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        let square = to_triangle([2.0, 2.0, 0.0], line, f64::INFINITY);
        assert!((square - 4.0).abs() < 1e-12);
        assert!((to_triangle([0.0, 3.0, 4.0], [[0.0; 3]; 3], f64::INFINITY) - 25.0).abs() < 1e-12);
    }
}
