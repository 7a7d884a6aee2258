//! Quadrics: the sum of weighted squared distances from a point to planes, as ten coefficients.
//!
//! A plane with unit normal (a, b, c) and offset d has distance ax + by + cz + d from (x, y, z).
//! The square of this distance is a polynomial of degree two, and so is a sum of such squares.
//! Planes are therefore added by adding coefficients.
//!
//! # References
//! Garland, Heckbert: *Surface Simplification Using Quadric Error Metrics*, 1997, section 4.

use crate::vector::{Point, dot};

/// The sum of weighted squared distances to planes, and the weight of the planes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Quadric {
    /// Coefficients of x², y², z².
    squares: [f64; 3],
    /// Coefficients of xy, xz, yz.
    products: [f64; 3],
    /// Coefficients of x, y, z.
    lines: [f64; 3],
    constant: f64,
    /// The weight of the planes of faces, without borders and seams.
    pub(crate) weight: f64,
    /// The weight of all planes.
    pub(crate) whole_weight: f64,
}

impl Quadric {
    /// Returns the quadric of the plane through a point with a unit normal.
    pub(crate) fn plane(normal: Point, through: Point, weight: f64) -> Self {
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

    /// Returns the quadric with its planes counted as face planes of a weight.
    pub(crate) fn of_faces(self, weight: f64) -> Self {
        Self { weight, ..self }
    }

    /// Adds the planes of another quadric.
    pub(crate) fn add(&mut self, other: &Self) {
        for k in 0..3 {
            self.squares[k] += other.squares[k];
            self.products[k] += other.products[k];
            self.lines[k] += other.lines[k];
        }
        self.constant += other.constant;
        self.weight += other.weight;
        self.whole_weight += other.whole_weight;
    }

    /// Evaluates the sum at a position. A sum that becomes negative by rounding counts as zero.
    #[inline]
    pub(crate) fn at(&self, [x, y, z]: Point) -> f64 {
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
    use crate::vector::sub;
    use proptest::array::uniform3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_the_sum_of_squared_distances(
            planes in prop::collection::vec((uniform3(-1.0..1.0), uniform3(-1.0..1.0), 0.0..2.0), 1..6),
            at in uniform3(-1.0..1.0),
        ) {
            let (mut quadric, mut sum, mut weights) = (Quadric::default(), 0.0, 0.0);
            for (normal, through, weight) in planes {
                let length = dot(normal, normal).sqrt();
                prop_assume!(length > 0.01);
                let normal = normal.map(|x| x / length);
                sum += weight * dot(normal, sub(at, through)).powi(2);
                weights += weight;
                quadric.add(&Quadric::plane(normal, through, weight).of_faces(weight));
            }
            prop_assert!((quadric.at(at) - sum).abs() < 1e-12 * (1.0 + sum));
            prop_assert!((quadric.weight - weights).abs() < 1e-12);
            prop_assert!((quadric.whole_weight - weights).abs() < 1e-12);
        }
    }
}
