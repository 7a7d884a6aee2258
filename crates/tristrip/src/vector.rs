//! Vectors in double precision, and the distance from a point to a triangle.
//!
//! Only sums, products, quotients and square roots, which are exact to the last bit on every machine.

/// A point or vector of a local frame.
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

/// Returns the cross product of two edges of a triangle: its normal, of twice its area as length.
#[inline]
pub(crate) fn normal_of([a, b, c]: [Point; 3]) -> Point {
    cross(sub(b, a), sub(c, a))
}

/// Returns the squared distance from a point to a segment; a segment of zero length is a point.
#[inline]
pub(crate) fn to_segment(p: Point, [a, b]: [Point; 2]) -> f64 {
    let (along, to) = (sub(b, a), sub(p, a));
    let length = dot(along, along);
    let share = if length > 0.0 { (dot(along, to) / length).clamp(0.0, 1.0) } else { 0.0 };
    let rest = [0, 1, 2].map(|k| to[k] - share * along[k]);
    dot(rest, rest)
}

/// Returns the squared distance from a point to a triangle if it is less than `known`, otherwise `known`; a triangle without area
/// consists of its edges.
///
/// If the foot of the perpendicular lies inside, this is the distance to the plane; otherwise the least distance to the edges that
/// the foot lies beyond.
#[inline]
pub(crate) fn to_triangle(p: Point, [a, b, c]: [Point; 3], known: f64) -> f64 {
    let normal = normal_of([a, b, c]);
    let to = sub(p, a);
    let (square, height) = (dot(normal, normal), dot(normal, to));
    // No point of the triangle is nearer than its plane.
    if height * height > known * square {
        return known;
    }
    let beyond = |from: Point, edge: [Point; 2]| dot(cross(normal, sub(edge[1], edge[0])), from) <= 0.0;
    let (ab, bc, ca) = (beyond(to, [a, b]), beyond(sub(p, b), [b, c]), beyond(sub(p, c), [c, a]));
    if !(ab || bc || ca) && square > 0.0 {
        return known.min(height * height / square);
    }
    let edges = [(ab, [a, b]), (bc, [b, c]), (ca, [c, a])];
    edges
        .into_iter()
        .filter(|&(beyond, _)| beyond)
        .fold(known, |least, (_, edge)| least.min(to_segment(p, edge)))
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
