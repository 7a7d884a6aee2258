//! Codes the position of the new point of a split as a residual against a prediction from the
//! polygon around it.
//!
//! ```text
//!       a₂ ──── a₁
//!      ╱  ╲    ╱  ╲
//!     a₃    v      a₀
//!      ╲  ╱    ╲  ╱
//!       k ──────
//! ```
//! The polygon of the new point v consists of the kept point k and the points aₛ … aₑ around the
//! corners that move. The prediction is the mean q of the polygon's points, plus a weighted sum of
//! the differences of other estimates from q.
//!
//! # Algorithm
//! 1. The other estimates are the kept point, the midpoint of aₛ and aₑ, q plus the mean of the
//!    Laplacians of the polygon's points, and the centroid of the polygon. They have separate
//!    weights along the polygon's normal and perpendicular to it. There is a set of weights for
//!    each number of points in the polygon and each of three regimes of batches. The encoder fits
//!    the weights to the model and writes them to the stream.
//! 2. The coordinates are coded one after the other. The axis along which the normal is longest
//!    comes last. If the new point is in the plane of the polygon, the differences in the first
//!    coordinates predict the differences in the later coordinates.
//! 3. The level of a number is the expected size of a difference. Features are the size of the
//!    polygon projected to the axis, the distance of the prediction from q, the width of the
//!    polygon along the axis, and the difference in the previous coordinate.
//!
//! All values are integers below 2⁵³, so they can be represented as floats. Divisions round down.
//!
//! # References
//! Taubin, Guéziec, Horn, Lazarus: *Progressive Forest Split Compression*, 1998; Alliez, Desbrun:
//! *Progressive Compression for Lossless Transmission of Triangle Meshes*, 2001 (barycentres, and
//! separate coding along the normal). The combination was developed for this library.

use super::fans::{GridPlace, SurfaceFan};
use crate::entropy::numbers::{NumberLevel, NumberModel, logarithm};
use crate::entropy::range_coder::BitCoder;

/// The number of estimates in addition to the mean of the polygon.
pub(super) const ESTIMATES: usize = 4;
/// The number of polygon sizes with their own weights: 3, 4, 5, 6, 7, and more points.
const POLYGONS: usize = 6;
/// The number of batch regimes with their own weights: the last batch, the second to last, and all
/// earlier ones.
pub(super) const REGIMES: usize = 3;
/// Weights of the estimates along the normal and perpendicular to it, in 1/64.
pub(super) type EstimateWeights = [[[i32; 2]; ESTIMATES]; POLYGONS * REGIMES];
pub(super) const WEIGHT_ONE: i64 = 64;
pub(super) const USUAL_WEIGHTS: EstimateWeights =
    [[[42, 13], [-6, -12], [12, 14], [32, 52]]; POLYGONS * REGIMES];
/// Estimates are in 1/16 of a step, the prediction in 1/1024.
const ONE: i64 = 16 * WEIGHT_ONE;

/// The maximum Laplacian: twice the size of the grid. Larger values occur only for fans with so
/// many neighbours that their number has wrapped.
const MAX_LAPLACIAN: i64 = 1 << 21;

/// The maximum number of bits of a coordinate.
pub(super) const MAX_BITS: u32 = 16;

/// The sets of numbers: coordinates perpendicular to the normal, those along it, and those of the
/// base mesh.
const ALONG: usize = 1;
const OF_BASE: usize = 2;

/// The initial weights of the features of a level, perpendicular to the normal and along it.
const BESIDE_LEVEL: [i32; 5] = [55_000, 40_000, 29_000, 42_000, 13_000];
const ALONG_LEVEL: [i32; 5] = [36_000, 6_000, 6_000, 9_000, 3_000];

/// Returns 65536 / n.
#[inline]
fn reciprocal(n: u32) -> i64 {
    const RECIPROCALS: [u32; 257] = {
        let mut reciprocals = [65536; 257];
        let mut n = 1;
        while n < 257 {
            reciprocals[n] = 65536 / n as u32;
            n += 1;
        }
        reciprocals
    };
    RECIPROCALS.get(n as usize).copied().unwrap_or_else(|| 65536 / n).into()
}

/// The estimates of a point, relative to the kept point.
#[derive(Debug, Clone, Default)]
pub(super) struct Estimates {
    pub(super) kept: GridPlace,
    /// The points of the polygon without the kept one.
    points: Vec<[i64; 3]>,
    /// The mean of the polygon, in 1/16 of a step.
    pub(super) mean: [i64; 3],
    /// The differences of the other estimates from it, in 1/16 of a step.
    pub(super) others: [[i64; 3]; ESTIMATES],
    /// The normal of the polygon, of any length.
    pub(super) normal: [i64; 3],
    /// The variance of its points along each axis, times the square of their number.
    spreads: [i64; 3],
    count: i64,
    /// The index of the weights to use.
    pub(super) class: usize,
}

fn floor_div(a: i64, b: i64) -> i64 {
    if b > 0 { a.div_euclid(b) } else { 0 }
}

fn dot(a: &[i64; 3], b: &[i64; 3]) -> i64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Estimates {
    /// Computes the estimates for a point between a kept fan and the fans around it.
    #[inline]
    pub(super) fn look_around(&mut self, fans: &[SurfaceFan], (kept, around): (u32, &[u32]), regime: usize) {
        let of_kept = &fans[kept as usize];
        let kept = of_kept.place();
        // A triangle at the end of a border has no third point.
        let count = (around.len() + 1).max(3);
        if self.points.len() < count {
            self.points.resize(2 * count, [0; 3]);
        }
        // 1. The points relative to the kept one, their sum and the sum of their squares; the sum
        //    of the Laplacians.
        let (mut laplacians, mut fan_count) = (of_kept.laplacian(), u32::from(of_kept.count));
        for (point, &other) in self.points.iter_mut().zip(around) {
            let fan = &fans[other as usize];
            let (place, laplacian) = (fan.place(), fan.laplacian());
            fan_count += u32::from(fan.count);
            for j in 0..3 {
                point[j] = i64::from(place[j] - kept[j]);
                laplacians[j] = laplacians[j].wrapping_add(laplacian[j]);
            }
        }
        if around.len() == 1 {
            self.points[1] = self.points[0];
        }
        let points = &self.points[..count - 1];
        let (mut sum, mut squares) = ([0; 3], [0; 3]);
        for point in points {
            for j in 0..3 {
                sum[j] += point[j];
                squares[j] += point[j] * point[j];
            }
        }
        // 2. The triangles between the kept point and the others, with at most eleven bits.
        let size = logarithm((squares[0] + squares[1] + squares[2] + 1).cast_unsigned());
        let surplus = (size / 16 - 10).max(0);
        let (mut normal, mut centre, mut area) = ([0_i64; 3], [0; 3], 0);
        let (start, end) = (points[0], points[points.len() - 1]);
        let mut a = start.map(|x| x >> surplus);
        for point in &points[1..] {
            let b = point.map(|x| x >> surplus);
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            let size = cross[0].abs().max(cross[1].abs()).max(cross[2].abs());
            area += size;
            for j in 0..3 {
                normal[j] += cross[j];
                centre[j] += size * (a[j] + b[j]);
            }
            a = b;
        }
        let of_area = (1 << 32) / (3 * area).max(1);
        // 3. The estimates.
        let (share, of_around) = (reciprocal(count as u32), reciprocal(fan_count));
        let number = i64::from(count as u32);
        for j in 0..3 {
            let mean = (16 * sum[j] * share) >> 16;
            self.mean[j] = mean;
            self.others[0][j] = -mean;
            self.others[1][j] = 8 * (start[j] + end[j]) - mean;
            let laplacian = (i64::from(laplacians[j]) * of_around) >> 12;
            self.others[2][j] = laplacian.clamp(-MAX_LAPLACIAN, MAX_LAPLACIAN);
            self.others[3][j] = if area == 0 { 0 } else { ((centre[j] * of_area) >> (28 - surplus)) - mean };
            self.spreads[j] = number * squares[j] - sum[j] * sum[j];
        }
        let most = normal[0].unsigned_abs() | normal[1].unsigned_abs() | normal[2].unsigned_abs();
        let surplus = (u64::BITS - most.leading_zeros()).saturating_sub(8);
        self.normal = normal.map(|x| x >> surplus);
        self.kept = kept;
        self.count = number;
        self.class = regime * POLYGONS + (count - 3).min(POLYGONS - 1);
    }

    /// Returns the predicted point relative to the kept one, in 1/1024 of a step.
    #[inline]
    fn expected(&self, weights: &EstimateWeights, square: i64) -> [i64; 3] {
        let mut expected = [0; 3];
        (0..3).for_each(|j| expected[j] = self.mean[j] * WEIGHT_ONE);
        let mut along = 0;
        for (other, &[normal, beside]) in self.others.iter().zip(&weights[self.class]) {
            (0..3).for_each(|j| expected[j] += i64::from(beside) * other[j]);
            along += i64::from(normal - beside) * dot(other, &self.normal);
        }
        let height = floor_div(256 * along, square);
        (0..3).for_each(|j| expected[j] += (height * self.normal[j]) >> 8);
        expected
    }
}

/// The models of the coordinates of new points.
#[derive(Debug, Clone)]
pub(super) struct PlaceModel {
    numbers: NumberModel,
    levels: [NumberLevel<5>; 3],
    pub(super) weights: EstimateWeights,
    /// The maximum coordinate with the known bits. Invalid bytes could exceed it.
    pub(super) most: i32,
}

impl PlaceModel {
    pub(super) fn new(weights: &EstimateWeights) -> Self {
        let levels = [BESIDE_LEVEL, BESIDE_LEVEL, ALONG_LEVEL].map(NumberLevel::new);
        Self { numbers: NumberModel::new(3), levels, weights: *weights, most: 0 }
    }

    /// Codes the position of a new point.
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        estimates: &Estimates,
        place: GridPlace,
    ) -> GridPlace {
        let normal = &estimates.normal;
        let square = dot(normal, normal);
        let expected = estimates.expected(&self.weights, square);
        let mut last = 2;
        for j in [1, 0] {
            if normal[j].abs() >= normal[last].abs() {
                last = j;
            }
        }
        let order = [if last == 2 { 0 } else { last + 1 }, if last == 0 { 2 } else { last - 1 }, last];
        let [n0, n1, n2] = order.map(|j| normal[j]);
        let rest = square - n0 * n0;
        // 1. The features: those of the polygon, then those of each axis.
        let log = |x: i64| logarithm(x.cast_unsigned());
        let count = estimates.count;
        let small = ((count * count) >> 3) + 1;
        let spreads = &estimates.spreads;
        let of_count = 2 * log(count);
        let size = log(spreads[0] + spreads[1] + spreads[2] + small) - of_count;
        let [of_square, of_rest, of_last] =
            if square == 0 { [0; 3] } else { [log(square), log(rest), log(n2 * n2)] };
        let shares = [of_rest - of_square, of_last - of_rest, of_square - of_last];
        let mut shift = ONE / 2;
        for j in 0..3 {
            shift += (expected[j] - WEIGHT_ONE * estimates.mean[j]).abs();
        }
        let shift = 2 * log(shift) - 160 - size;

        // 2. The coordinates perpendicular to the normal, then the one along it.
        let mut found = estimates.kept;
        let mut before = 0;
        let mut code = |turn: usize, slope: i64| {
            let j = order[turn];
            let size = size + shares[turn];
            let width = log(spreads[j] + small) - of_count - size;
            let features = [32, size - 64, shift - shares[turn], width, before];
            let level = &mut self.levels[turn];
            let middle = (expected[j] + slope + ONE / 2) >> 10;
            let middle = estimates.kept[j].wrapping_add(middle as i32);
            let difference = place[j].wrapping_sub(middle);
            let set = if turn == 2 { ALONG } else { 0 };
            let (difference, error) = self.numbers.code(coder, set, level.expect(features), difference);
            level.learn(features, error);
            before = error.clamp(-48, 48);
            found[j] = middle.wrapping_add(difference).clamp(0, self.most);
            // The difference from the prediction.
            ONE * (i64::from(found[j]) - i64::from(estimates.kept[j])) - expected[j]
        };
        let across = n0 * code(0, 0);
        let along = across + n1 * code(1, floor_div(-n1 * across, rest));
        let rise = (-along * n2.signum()) >> 8;
        code(2, (rise * reciprocal(n2.unsigned_abs() as u32)) >> 8);
        found
    }

    /// Codes the position of a point of the base mesh near a predicted position. `square` is the
    /// squared length of the sides of the triangles around it.
    pub(super) fn code_base<C: BitCoder>(
        &mut self,
        coder: &mut C,
        near: GridPlace,
        square: u64,
        place: GridPlace,
    ) -> GridPlace {
        let mut found = near;
        for axis in 0..3 {
            let difference = place[axis].wrapping_sub(near[axis]);
            let level = logarithm(square) - 16;
            let (difference, _) = self.numbers.code(coder, OF_BASE, level, difference);
            found[axis] = near[axis].wrapping_add(difference).clamp(0, self.most);
        }
        found
    }
}
