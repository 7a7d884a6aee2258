//! The extent of a model, for camera paths: its bounding box, and its outline during a turn.

use super::lens::{Axis, Lens};
use crate::error::Error;

/// The tangent of the angle by which orbit and dolly look down: 20°.
const ELEVATION: f64 = 0.364;
/// The fraction of the image that a model in orbit fills.
const FILLED: f64 = 0.92;
/// The number of slices of a model, and of points on each ring. They determine the distance of an
/// orbit.
const SLICES: usize = 64;
const ANGLES: usize = 64;
/// The height of a flyover above the box, and how far ahead and down the camera looks, relative to
/// the length of the box.
const HEIGHT: f64 = 0.03;
const AHEAD: f64 = 0.25;
const DOWN: f64 = 0.06;

/// Returns the unit direction from a model to the eye at a fraction of a turn. The turn starts at
/// the axis that follows the vertical axis in the cyclic order x, y, z. For a vertical y axis this
/// is z, the front.
pub(super) fn towards(up: Axis, turn: f64) -> [f64; 3] {
    let up = up as usize;
    let angle = std::f64::consts::TAU * turn;
    let mut direction = [0.0; 3];
    direction[(up + 1) % 3] = libm::cos(angle);
    direction[(up + 2) % 3] = libm::sin(angle);
    direction[up] = ELEVATION;
    let length = (1.0 + ELEVATION * ELEVATION).sqrt();
    direction.map(|x| x / length)
}

/// The bounding box of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    low: [f64; 3],
    high: [f64; 3],
}

impl Bounds {
    /// Returns the bounding box of positions. A box without extent gets size 1.
    pub(super) fn of(positions: &[[f32; 3]]) -> Result<Self, Error> {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (vertex, position) in positions.iter().enumerate() {
            if !position.iter().all(|x| x.is_finite()) {
                let expected = "expected finite coordinates";
                return Err(Error::Data(format!("vertex {vertex}: found {position:?}, {expected}")));
            }
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis].into());
                high[axis] = high[axis].max(position[axis].into());
            }
        }
        if positions.is_empty() {
            return Err(Error::Data("positions: found none, expected a model to fly around".into()));
        }
        if (0..3).all(|axis| low[axis] >= high[axis]) {
            (low, high) = (low.map(|x| x - 0.5), high.map(|x| x + 0.5));
        }
        Ok(Self { low, high })
    }

    pub(super) fn center(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| self.low[k] / 2.0 + self.high[k] / 2.0)
    }

    pub(super) fn side(&self, axis: Axis) -> f64 {
        self.high[axis as usize] - self.low[axis as usize]
    }

    /// Returns a point in a direction from the center.
    pub(super) fn beyond(&self, direction: [f64; 3], distance: f64) -> [f64; 3] {
        let center = self.center();
        [0, 1, 2].map(|k| center[k] + distance * direction[k])
    }

    /// Returns the distance from the center to the surface of the box in a direction.
    pub(super) fn way_out(&self, direction: [f64; 3]) -> f64 {
        let ways = (0..3).filter(|&k| direction[k] != 0.0);
        let way = |k: usize| (self.high[k] - self.low[k]) / 2.0 / direction[k].abs();
        ways.map(way).fold(f64::INFINITY, f64::min)
    }

    /// Returns the eye and the point that it looks at, at a fraction of the way over the box.
    pub(super) fn over(&self, up: Axis, share: f64) -> [[f64; 3]; 2] {
        let others = Axis::ALL.into_iter().filter(|&axis| axis != up);
        let along = others.max_by(|&a, &b| self.side(a).total_cmp(&self.side(b))).unwrap_or(Axis::X);
        let length = self.side(along).max(self.side(up));
        let (up, along) = (up as usize, along as usize);
        let mut eye = self.center();
        eye[up] = self.high[up] + HEIGHT * length;
        // Starts a little before the box, and stops before the point ahead leaves it.
        let (first, last) = (self.low[along] - 0.05 * length, self.high[along] - 0.15 * length);
        eye[along] = first + share * (last - first);
        let mut look_at = eye;
        look_at[along] += AHEAD * length;
        look_at[up] -= DOWN * length;
        [eye, look_at]
    }
}

/// The outline of a model that turns around its vertical axis: the widest point of each slice.
///
/// ```text
///      up                    ring: the height above the center, and the distance from the axis
///       │   ●
///       │  ●     ● eye       a ring at a height above the view axis and a depth toward the eye
///   ────┼────●───            is visible from the distance height / tangent + depth
///       │   ●
/// ```
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rings {
    pub(super) up: Axis,
    /// The height and the radius of each point.
    points: Vec<[f64; 2]>,
}

impl Rings {
    /// Returns the widest point of each slice of a model.
    #[allow(clippy::cast_sign_loss, reason = "positions are above the lowest one")]
    pub(super) fn of(positions: &[[f32; 3]], up: Axis) -> Result<Self, Error> {
        let bounds = Bounds::of(positions)?;
        let (center, side) = (bounds.center(), bounds.side(up));
        let mut widest: [Option<[f64; 2]>; SLICES + 1] = [None; SLICES + 1];
        for position in positions {
            let from_center = [0, 1, 2].map(|k| f64::from(position[k]) - center[k]);
            let across = [1, 2].map(|step| from_center[(up as usize + step) % 3]);
            let radius = (across[0] * across[0] + across[1] * across[1]).sqrt();
            let height = from_center[up as usize];
            let share = if side > 0.0 { height / side + 0.5 } else { 0.0 };
            let slice = &mut widest[((share * SLICES as f64) as usize).min(SLICES)];
            if slice.is_none_or(|[_, widest]| radius > widest) {
                *slice = Some([height, radius]);
            }
        }
        let mut points: Vec<[f64; 2]> = widest.into_iter().flatten().collect();
        if points.iter().all(|&[height, radius]| height == 0.0 && radius == 0.0) {
            // A model without extent.
            points.push([0.0, 0.5]);
        }
        Ok(Self { up, points })
    }

    /// Returns the minimum distance from the center at which the camera of an orbit sees all rings.
    pub(super) fn filling_distance(&self, lens: Lens) -> f64 {
        let tangents = lens.tangents().map(|tangent| FILLED * tangent);
        let length = (1.0 + ELEVATION * ELEVATION).sqrt();
        let (sine, cosine) = (ELEVATION / length, 1.0 / length);
        let mut distance = 0.0_f64;
        for angle in 0..ANGLES {
            let angle = std::f64::consts::TAU * angle as f64 / ANGLES as f64;
            for [height, radius] in &self.points {
                let (front, right) = (radius * libm::cos(angle), radius * libm::sin(angle));
                let depth = front * cosine + height * sine;
                let upward = height * cosine - front * sine;
                distance = distance.max(depth + right.abs() / tangents[0]);
                distance = distance.max(depth + upward.abs() / tangents[1]);
            }
        }
        distance
    }
}
