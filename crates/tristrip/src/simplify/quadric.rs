//! Quadrics: the sum of weighted squared distances from a point to planes, as ten numbers.
//!
//! A plane of unit normal (a, b, c) and offset d is at distance ax + by + cz + d from (x, y, z). The square of that is a
//! polynomial of degree two, and so is any sum of such squares: planes are added by adding coefficients.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997, section 4.

use crate::vector::{Point, dot};

/// The sum of weighted squared distances to planes, and the weight of those that faces gave.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Quadric {
    /// Coefficients of x², y², z².
    squares: [f64; 3],
    /// Coefficients of xy, xz, yz.
    products: [f64; 3],
    /// Coefficients of x, y, z.
    lines: [f64; 3],
    constant: f64,
    /// The weight of the faces' planes; those of borders do not count.
    pub(super) weight: f64,
    /// The weight of all planes.
    pub(super) whole_weight: f64,
}

impl Quadric {
    /// Takes the plane through a point with a unit normal, for its square to count so many times.
    pub(super) fn plane(normal: Point, through: Point, weight: f64) -> Self {
        let [a, b, c] = normal;
        let d = -dot(normal, through);
        Self {
            squares: [a * a, b * b, c * c].map(|x| weight * x),
            products: [a * b, a * c, b * c].map(|x| 2.0 * weight * x),
            lines: [a, b, c].map(|x| 2.0 * weight * d * x),
            constant: weight * d * d,
            weight: 0.0,
            whole_weight: weight,
        }
    }

    /// Says that the planes are those of faces of a weight.
    pub(super) fn of_faces(self, weight: f64) -> Self {
        Self { weight, ..self }
    }

    /// Adds the planes of another.
    pub(super) fn add(&mut self, other: &Self) {
        for k in 0..3 {
            self.squares[k] += other.squares[k];
            self.products[k] += other.products[k];
            self.lines[k] += other.lines[k];
        }
        self.constant += other.constant;
        self.weight += other.weight;
        self.whole_weight += other.whole_weight;
    }

    /// Gives the sum at a point; what rounding takes below zero counts as zero.
    #[inline]
    pub(super) fn at(&self, [x, y, z]: Point) -> f64 {
        let [xx, yy, zz] = self.squares;
        let [xy, xz, yz] = self.products;
        let [lx, ly, lz] = self.lines;
        let sum = x * (xx * x + xy * y + xz * z + lx)
            + y * (yy * y + yz * z + ly)
            + z * (zz * z + lz)
            + self.constant;
        sum.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = Point> {
        [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64]
    }

    proptest! {
        #[test]
        fn is_the_sum_of_squared_distances(
            planes in prop::collection::vec((point(), point(), 0.0..2.0_f64), 1..6),
            at in point(),
        ) {
            let (mut quadric, mut sum, mut weights) = (Quadric::default(), 0.0, 0.0);
            for (normal, through, weight) in planes {
                let length = dot(normal, normal).sqrt();
                prop_assume!(length > 0.01);
                let normal = normal.map(|x| x / length);
                let offset = [0, 1, 2].map(|k| at[k] - through[k]);
                sum += weight * dot(normal, offset).powi(2);
                weights += weight;
                quadric.add(&Quadric::plane(normal, through, weight).of_faces(weight));
            }
            prop_assert!((quadric.at(at) - sum).abs() < 1e-12 * (1.0 + sum));
            prop_assert!((quadric.weight - weights).abs() < 1e-12);
            prop_assert!((quadric.whole_weight - weights).abs() < 1e-12);
        }
    }
}
