//! Cones of normals: all directions within a given angle of an axis.
//!
//! Angles are stored as cosines and sines. Adding two angles then needs only products and square
//! roots, which give the same bits on every machine.
//!
//! # References
//! Shirman, Abi-Ezzi: *The Cone of Normals Technique for Fast Processing of Curved Patches*, 1993.

use crate::vector::{Point, dot};

/// The cosine and the sine of 0.02 radians. Rounding an axis to steps of 1/127 turns it by less.
const ROUNDING: [f64; 2] = [0.999_800_006_666_577_8, 0.019_998_666_693_333_08];
/// The number of steps per unit of a rounded coordinate.
const STEPS: f64 = 127.0;

/// A cone of normals under construction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) enum WideCone {
    /// Contains no direction.
    #[default]
    Empty,
    /// Contains the directions within an angle of `axis`, the unit vector in the direction of
    /// `sum`.
    Around { sum: Point, axis: Point, cos: f64, sin: f64 },
    /// Contains all directions.
    Full,
}

impl WideCone {
    /// Creates the cone of one direction. The length of the vector is its weight; a zero vector
    /// gives an empty cone.
    pub(super) fn of(sum: Point) -> Self {
        match direction(sum) {
            Some(axis) => Self::Around { sum, axis, cos: 1.0, sin: 0.0 },
            None => Self::Empty,
        }
    }

    /// Returns a cone that contains both cones.
    pub(super) fn with(&self, other: &Self) -> Self {
        let (
            &Self::Around { sum, axis: a, cos: cos_a, sin: sin_a },
            &Self::Around { sum: more, axis: b, cos: cos_b, sin: sin_b },
        ) = (self, other)
        else {
            return match (self, other) {
                (Self::Empty, cone) | (cone, Self::Empty) => *cone,
                _ => Self::Full,
            };
        };
        let sum = [0, 1, 2].map(|k| sum[k] + more[k]);
        let Some(axis) = direction(sum) else { return Self::Full };
        let mut widest = [1.0, 0.0];
        for (old, angle) in [(a, [cos_a, sin_a]), (b, [cos_b, sin_b])] {
            let cos = dot(axis, old).clamp(-1.0, 1.0);
            let Some(angle) = sum_of([cos, (1.0 - cos * cos).sqrt()], angle) else { return Self::Full };
            if angle[0] < widest[0] {
                widest = angle;
            }
        }
        Self::Around { sum, axis, cos: widest[0], sin: widest[1] }
    }

    /// Returns a four-byte cone that contains this one. An empty cone becomes a full one.
    pub(super) fn rounded(&self) -> Cone {
        let &Self::Around { axis, cos, sin, .. } = self else { return Cone::FULL };
        let Some([cos, _]) = sum_of([cos, sin], ROUNDING) else { return Cone::FULL };
        let cos = (cos * STEPS).floor();
        if cos <= -STEPS {
            return Cone::FULL;
        }
        Cone { axis: axis.map(|x| (x * STEPS).round() as i8), cos: cos as i8 }
    }
}

/// A cone of normals in four bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cone {
    /// The axis, with a length of about 127.
    axis: [i8; 3],
    /// The cosine of the angle times 127, or -128 if the cone contains all directions.
    cos: i8,
}

impl Default for Cone {
    fn default() -> Self {
        Self::FULL
    }
}

/// How a surface whose normals lie in a cone faces a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Facing {
    Front,
    Back,
    /// Some normals may be perpendicular to the direction.
    Edge,
}

impl Cone {
    /// The cone of all directions.
    pub(super) const FULL: Self = Self { axis: [0; 3], cos: i8::MIN };

    /// Returns how the normals face a direction of this length, if each normal may be turned by up
    /// to an angle of this sine. Also returns a lower bound, in radians, on the turn of the
    /// direction that changes the result, or 0 if none is known.
    pub(super) fn facing(self, direction: Point, length: f64, sine: f64) -> (Facing, f64) {
        let axis = self.axis.map(f64::from);
        let norm = dot(axis, axis).sqrt() * length;
        if self.cos == i8::MIN || norm <= 0.0 || sine >= 1.0 {
            return (Facing::Edge, 0.0);
        }
        let cos = f64::from(self.cos) / STEPS;
        let angle = sum_of([cos, (1.0 - cos * cos).sqrt()], [(1.0 - sine * sine).sqrt(), sine]);
        // The sum of both angles. Front and back can be told apart only if it is less than a right
        // angle.
        let Some([_, sine]) = angle.filter(|[cos, _]| *cos > 0.0) else { return (Facing::Edge, 0.0) };
        let toward = dot(axis, direction) / norm;
        let facing = if toward > sine {
            Facing::Front
        } else if toward < -sine {
            Facing::Back
        } else {
            Facing::Edge
        };
        (facing, (toward.abs() - sine).abs())
    }
}

/// Returns the cosine and the sine of the sum of two angles from 0 to π, or `None` if the sum
/// exceeds π.
fn sum_of([cos_a, sin_a]: [f64; 2], [cos_b, sin_b]: [f64; 2]) -> Option<[f64; 2]> {
    let (cos, sin) = (cos_a * cos_b - sin_a * sin_b, sin_a * cos_b + cos_a * sin_b);
    (sin >= 0.0).then_some([cos, sin])
}

/// Returns the unit vector in the direction of a vector, or `None` if its length is zero or not
/// finite.
fn direction(sum: Point) -> Option<Point> {
    let length = dot(sum, sum).sqrt();
    (length > 0.0 && length.is_finite()).then(|| sum.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use proptest::array::uniform3;
    use proptest::prelude::*;

    use super::*;
    use crate::vector::unit;

    proptest! {
        #[test]
        fn a_cone_contains_its_directions(directions in prop::collection::vec(uniform3(-1.0..1.0_f64), 1..9)) {
            prop_assume!(directions.iter().all(|&d| dot(d, d) > 0.01));
            let wide = directions.iter().fold(WideCone::Empty, |cone, &d| cone.with(&WideCone::of(d)));
            let cone = wide.rounded();
            if cone != Cone::FULL {
                let axis = unit(cone.axis.map(f64::from));
                for d in directions {
                    prop_assert!(dot(axis, unit(d)) >= f64::from(cone.cos) / STEPS);
                }
            }
        }

        #[test]
        fn faces_are_those_of_all_normals(
            directions in prop::collection::vec(uniform3(0.5..1.0_f64), 1..9),
            toward in uniform3(-1.0..1.0_f64),
            sine in 0.0..0.5_f64,
        ) {
            prop_assume!(dot(toward, toward) > 0.01);
            let cone = directions.iter().fold(WideCone::Empty, |cone, &d| cone.with(&WideCone::of(d))).rounded();
            let (facing, slack) = cone.facing(toward, dot(toward, toward).sqrt(), sine);
            prop_assert!(slack >= 0.0);
            for d in directions {
                let cos = dot(unit(toward), unit(d));
                prop_assert!(facing != Facing::Front || cos > 0.0);
                prop_assert!(facing != Facing::Back || cos < 0.0);
            }
        }
    }
}
