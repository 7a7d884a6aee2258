//! Distances between the triangles around a point and the triangles that would replace them,
//! computed for four triangles at a time.
//!
//! ```text
//!        u ───── w
//!       ╱ ╲     ╱
//!      ╱   ╲   ╱
//!     a ──── o
//! ```
//! The point is the origin o, and the longest edge to a neighbour is the unit, so 32-bit floats
//! have seven digits around each point, at any scale. The old triangles are (o, u, w), the new ones
//! (a, u, w), where a is the neighbour that the point collapses to.
//!
//! The nearest position on a triangle is the foot of the perpendicular if it is inside, otherwise
//! it is on an edge. With normals n = u × w of an old triangle and n' = u × w + a × u + w × a of a
//! new one:
//! - the foot of the origin is inside the new triangle if the dot products of n' with u × w, a × u
//!   and w × a are positive; the height of the origin is a · n divided by the length of n';
//! - the foot of a position m is inside the old triangle if m · (n × u) and m · (w × n) are not
//!   negative, and their sum is at most n · n; its height is m · n divided by the length of n.
//!
//! Neighbouring triangles share the edges at o or a, so testing one such edge per triangle is
//! enough around an inner point.

use wide::f32x4;

use crate::vector::{Point, dot, sub};

const LANES: usize = 4;
/// A triangle with a shorter normal, at unit edge length, is treated as its edges: rounding could
/// give the normal any direction.
const MIN_NORMAL: f32 = 1e-5;
/// Added to divisors that can be zero.
const TINY: f32 = 1e-30;

/// Four vectors.
type Lanes = [f32x4; 3];

fn dots(a: Lanes, b: Lanes) -> f32x4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn subs(a: Lanes, b: Lanes) -> Lanes {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn crosses(a: Lanes, b: Lanes) -> Lanes {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn scaled(a: Lanes, by: f32x4) -> Lanes {
    a.map(|x| x * by)
}

fn splat(a: [f32; 3]) -> Lanes {
    a.map(f32x4::splat)
}

/// Returns the squared distances of points from segments that begin at the origin. `inverse` is the
/// inverse of the segments' squared length.
fn from_segment(points: Lanes, along: Lanes, inverse: f32x4) -> f32x4 {
    let share = (dots(points, along) * inverse).fast_max(f32x4::ZERO).fast_min(f32x4::ONE);
    let rest = subs(points, scaled(along, share));
    dots(rest, rest)
}

fn least(lanes: f32x4) -> f32 {
    lanes.to_array().into_iter().fold(f32::INFINITY, |least, x| if x < least { x } else { least })
}

/// Four triangles around the point.
#[derive(Debug, Clone, Copy)]
struct TriangleBlock {
    u: Lanes,
    w: Lanes,
    /// The normals of the old triangles, as long as twice their areas.
    normal: Lanes,
    /// The squared lengths of the normals.
    square: f32x4,
    /// The squared distance of the point from the opposite edge.
    outer: f32x4,
    old: OldTriangles,
}

/// Precomputed values for the distance from old triangles.
#[derive(Debug, Clone, Copy, Default)]
struct OldTriangles {
    /// Unit normals; zero where the triangle is treated as its edges.
    unit: Lanes,
    /// The cross products of the normal and u, and of w and the normal.
    sides: [Lanes; 2],
    /// The maximum sum of a position's dot products with both sides; negative where the triangle is
    /// treated as its edges.
    most: f32x4,
    /// The vector from u to w.
    edge: Lanes,
    /// The inverses of the squared lengths of u, w and the edge between them.
    inverses: [f32x4; 3],
}

impl TriangleBlock {
    fn new(u: Lanes, w: Lanes) -> Self {
        let normal = crosses(u, w);
        let edge = subs(w, u);
        let tiny = f32x4::splat(TINY);
        let negative = u.map(|x| -x);
        let outer = from_segment(negative, edge, f32x4::ONE / (dots(edge, edge) + tiny));
        Self { u, w, normal, square: dots(normal, normal), outer, old: OldTriangles::default() }
    }

    /// Prepares distances from the old triangles.
    fn place(&mut self) {
        let tiny = f32x4::splat(TINY);
        let has_area = self.square.simd_gt(f32x4::splat(MIN_NORMAL * MIN_NORMAL));
        let scale = has_area.select(f32x4::ONE / (self.square + tiny).sqrt(), f32x4::ZERO);
        let edge = subs(self.w, self.u);
        self.old = OldTriangles {
            unit: scaled(self.normal, scale),
            sides: [crosses(self.normal, self.u), crosses(self.w, self.normal)],
            most: has_area.select(self.square, f32x4::splat(-1.0)),
            edge,
            inverses: [self.u, self.w, edge].map(|along| f32x4::ONE / (dots(along, along) + tiny)),
        };
    }

    /// Returns the squared distances of the origin from the new triangles at a position, plus
    /// `left_out`.
    fn new_distance(&self, at: Lanes, left_out: f32x4, is_inner: bool) -> f32x4 {
        let (first, last) = (crosses(at, self.u), crosses(self.w, at));
        let normal = [0, 1, 2].map(|k| self.normal[k] + first[k] + last[k]);
        let square = dots(normal, normal);
        let positive = |cross: Lanes| dots(normal, cross).simd_gt(f32x4::ZERO);
        let is_inside = positive(self.normal)
            & positive(first)
            & positive(last)
            & square.simd_gt(f32x4::splat(MIN_NORMAL * MIN_NORMAL));
        let height = dots(at, self.normal);
        let from_plane = height * height / (square + f32x4::splat(TINY));
        let from_face = is_inside.select(from_plane, self.outer) + left_out;
        let spoke = |end: Lanes| {
            let along = subs(end, at);
            from_segment(at.map(|x| -x), along, f32x4::ONE / (dots(along, along) + f32x4::splat(TINY)))
        };
        // Around an inner point, the u of a dropped triangle is the w of a remaining one.
        if is_inner {
            from_face.fast_min(spoke(self.u))
        } else {
            from_face.fast_min(spoke(self.u).fast_min(spoke(self.w)) + left_out)
        }
    }

    /// Returns the squared distances of a position from the old triangles.
    fn old_distance(&self, point: Lanes, is_inner: bool) -> f32x4 {
        let old = &self.old;
        let sides = old.sides.map(|side| dots(point, side));
        let is_inside = sides[0].simd_ge(f32x4::ZERO)
            & sides[1].simd_ge(f32x4::ZERO)
            & (sides[0] + sides[1]).simd_le(old.most);
        let height = dots(point, old.unit);
        let from_edge = from_segment(subs(point, self.u), old.edge, old.inverses[2]);
        let from_spoke = from_segment(point, self.u, old.inverses[0]);
        let least = is_inside.select(height * height, from_edge).fast_min(from_spoke);
        if is_inner { least } else { least.fast_min(from_segment(point, self.w, old.inverses[1])) }
    }
}

/// The triangles around a point.
#[derive(Debug, Default)]
pub(crate) struct TriangleFan {
    origin: Point,
    /// The length of the longest edge at the point; positive.
    unit: f64,
    is_inner: bool,
    count: usize,
    blocks: Vec<TriangleBlock>,
    /// Whether the blocks are ready for distances from old triangles.
    is_placed: bool,
    /// Infinite for triangles that the current distance query leaves out, otherwise zero.
    left_out: Vec<f32x4>,
}

impl TriangleFan {
    /// Sets the triangles (origin, u, w).
    pub(crate) fn place(
        &mut self,
        origin: Point,
        is_inner: bool,
        edges: impl ExactSizeIterator<Item = [Point; 2]> + Clone,
    ) {
        let square = |p: Point| {
            let edge = sub(p, origin);
            dot(edge, edge)
        };
        let longest = edges.clone().flatten().map(square).fold(0.0, f64::max).sqrt();
        self.unit = if longest > 0.0 { longest } else { 1.0 };
        (self.origin, self.is_inner, self.count, self.is_placed) = (origin, is_inner, edges.len(), false);
        self.blocks.clear();
        let mut edges = edges;
        while edges.len() > 0 {
            // Unused lanes repeat the last triangle.
            let mut lanes = [[[0.0_f32; LANES]; 3]; 2];
            let mut last = [[0.0_f32; 3]; 2];
            for lane in 0..LANES {
                if let Some(edge) = edges.next() {
                    last = edge.map(|p| self.local(p));
                }
                for (ends, end) in lanes.iter_mut().zip(&last) {
                    for (component, &x) in ends.iter_mut().zip(end) {
                        component[lane] = x;
                    }
                }
            }
            let [u, w] = lanes.map(|end| end.map(f32x4::from));
            self.blocks.push(TriangleBlock::new(u, w));
        }
    }

    /// Returns a position relative to the point, in the fan's unit.
    fn local(&self, position: Point) -> [f32; 3] {
        let scale = 1.0 / self.unit;
        sub(position, self.origin).map(|x| (x * scale) as f32)
    }

    /// Returns the squared distance of the point from the triangles that it would have at a
    /// position, except those that `is_left_out` selects. If none remain, returns the distance from
    /// their opposite edges.
    pub(crate) fn distance(&mut self, kept: Point, is_left_out: impl Fn(usize) -> bool) -> f64 {
        let at = splat(self.local(kept));
        let mut remain = false;
        self.left_out.clear();
        for block in 0..self.blocks.len() {
            let mut lanes = [0.0; LANES];
            for (lane, value) in lanes.iter_mut().enumerate() {
                let triangle = (block * LANES + lane).min(self.count - 1);
                if is_left_out(triangle) {
                    *value = f32::INFINITY;
                } else {
                    remain = true;
                }
            }
            self.left_out.push(f32x4::from(lanes));
        }
        let found = if remain {
            let all = self.blocks.iter().zip(&self.left_out);
            all.map(|(block, &left_out)| least(block.new_distance(at, left_out, self.is_inner)))
                .fold(f32::INFINITY, f32::min)
        } else {
            self.blocks.iter().map(|block| least(block.outer)).fold(f32::INFINITY, f32::min)
        };
        f64::from(found) * self.unit * self.unit
    }

    /// Returns the squared distance of a position from the old triangles.
    pub(crate) fn old_distance(&mut self, position: Point) -> f64 {
        self.place_old();
        let point = splat(self.local(position));
        let found = self.blocks.iter().map(|block| least(block.old_distance(point, self.is_inner)));
        f64::from(found.fold(f32::INFINITY, f32::min)) * self.unit * self.unit
    }

    /// Returns the index of the old triangle nearest to a position.
    pub(crate) fn nearest(&mut self, position: Point) -> usize {
        self.place_old();
        let point = splat(self.local(position));
        let (mut nearest, mut distance) = (0, f32::INFINITY);
        for (i, block) in self.blocks.iter().enumerate() {
            for (lane, found) in block.old_distance(point, self.is_inner).to_array().into_iter().enumerate() {
                if found < distance {
                    (nearest, distance) = (i * LANES + lane, found);
                }
            }
        }
        nearest.min(self.count - 1)
    }

    /// Prepares distances from the old triangles, once.
    fn place_old(&mut self) {
        if !self.is_placed {
            self.blocks.iter_mut().for_each(TriangleBlock::place);
            self.is_placed = true;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::to_triangle;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point> {
        [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64]
    }

    fn nearest(p: Point, triangles: impl Iterator<Item = [Point; 3]>) -> f64 {
        triangles.fold(f64::INFINITY, |least, triangle| to_triangle(p, triangle, least))
    }

    proptest! {
        /// Fans of 3 to 20 triangles, closed or open: the distances match those from each single
        /// triangle.
        #[test]
        fn distances_are_those_of_each_triangle(
            rim in prop::collection::vec(point(), 3..20),
            (origin, at) in (point(), point()),
            (closed, scale) in (any::<bool>(), -8..3),
        ) {
            let scale = 10_f64.powi(scale);
            let place = |p: Point| p.map(|x| 7.0 + x * scale);
            let (origin, at, rim) = (place(origin), place(at), rim.into_iter().map(place).collect::<Vec<_>>());
            let count = if closed { rim.len() } else { rim.len() - 1 };
            let edges: Vec<[Point; 2]> = (0..count).map(|i| [rim[i], rim[(i + 1) % rim.len()]]).collect();
            let mut fan = TriangleFan::default();
            fan.place(origin, closed, edges.iter().copied());
            let is_near = |found: f64, oracle: f64| (found.sqrt() - oracle.sqrt()).abs() < 2e-3 * scale;
            let old = nearest(at, edges.iter().map(|&[u, w]| [origin, u, w]));
            prop_assert!(is_near(fan.old_distance(at), old), "{} {old}", fan.old_distance(at));
            let [u, w] = edges[fan.nearest(at)];
            prop_assert!(is_near(to_triangle(at, [origin, u, w], f64::INFINITY), old));
            for (k, &kept) in rim.iter().enumerate() {
                let has = |i: usize| i == k || (i + 1) % rim.len() == k;
                let left = (0..count).filter(|&i| !has(i)).map(|i| [kept, edges[i][0], edges[i][1]]);
                let oracle = nearest(origin, left);
                if oracle.is_finite() {
                    prop_assert!(is_near(fan.distance(kept, has), oracle), "{} {oracle}", fan.distance(kept, has));
                }
            }
        }
    }
}
