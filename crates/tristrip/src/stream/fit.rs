//! Fits the weights of the estimates to a model by least squares.
//!
//! The bits of a coordinate grow with the logarithm of the prediction error. Each squared error is
//! therefore divided by its value under the previous weights. A few such fits minimize the sum of
//! the logarithms. The decoder reads the weights and does not repeat the fits.

use super::fans::GridPlace;
use super::places::{ESTIMATES, EstimateWeights, Estimates, WEIGHT_ONE};

/// A row of the normal equations: the estimates, then the point.
type Row = [f64; ESTIMATES + 1];

/// The maximum absolute value of a weight.
const MAX_WEIGHT: f64 = 255.0;
/// A distance, in 1/16 of a step, below which all errors count the same.
const NEAR: f64 = 16.0;

/// The normal equations of all weights, along the normal and perpendicular to it.
#[derive(Debug, Clone)]
pub(super) struct Fit {
    sums: Vec<[[Row; ESTIMATES]; 2]>,
}

impl Fit {
    pub(super) fn new(weights: &EstimateWeights) -> Self {
        Self { sums: vec![[[[0.0; ESTIMATES + 1]; ESTIMATES]; 2]; weights.len()] }
    }

    /// Adds a point.
    pub(super) fn add(&mut self, estimates: &Estimates, weights: &EstimateWeights, place: GridPlace) {
        let class = estimates.class;
        let normal = estimates.normal.map(|x| x as f64);
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let unit = normal.map(|x| if length > 0.0 { x / length } else { 0.0 });
        let along = |v: &[f64; 3]| v[0] * unit[0] + v[1] * unit[1] + v[2] * unit[2];
        // The estimates and the point, relative to the mean.
        let mut vectors = [[0.0; 3]; ESTIMATES + 1];
        for (vector, other) in vectors.iter_mut().zip(&estimates.others) {
            *vector = other.map(|x| x as f64);
        }
        vectors[ESTIMATES] =
            [0, 1, 2].map(|j| (16 * i64::from(place[j] - estimates.kept[j]) - estimates.mean[j]) as f64);
        let heights = vectors.map(|v| along(&v));
        let flat: [Row; 3] = [0, 1, 2].map(|j| {
            let mut row = [0.0; ESTIMATES + 1];
            (0..=ESTIMATES).for_each(|i| row[i] = vectors[i][j] - heights[i] * unit[j]);
            row
        });
        let sides: [&[Row]; 2] = [&[heights], &flat];
        for (side, rows) in sides.into_iter().enumerate() {
            let rest = |row: &Row| {
                let weight = |i: usize| f64::from(weights[class][i][side]) / WEIGHT_ONE as f64;
                row[ESTIMATES] - (0..ESTIMATES).map(|i| row[i] * weight(i)).sum::<f64>()
            };
            let square = NEAR * NEAR + rows.iter().map(|row| rest(row) * rest(row)).sum::<f64>();
            for row in rows {
                for (i, sums) in self.sums[class][side].iter_mut().enumerate() {
                    (0..=ESTIMATES).for_each(|j| sums[j] += row[i] * row[j] / square);
                }
            }
        }
    }

    /// Returns the least-squares weights. Weights with too few points keep their values.
    pub(super) fn solve(&self, weights: &EstimateWeights) -> EstimateWeights {
        let mut solved = *weights;
        for (sums, weights) in self.sums.iter().zip(&mut solved) {
            for side in 0..2 {
                if let Some(solution) = solve(sums[side]) {
                    for (weight, x) in weights.iter_mut().zip(solution) {
                        let steps = (x * WEIGHT_ONE as f64).clamp(-MAX_WEIGHT, MAX_WEIGHT);
                        weight[side] = (steps + 0.5).floor() as i32;
                    }
                }
            }
        }
        solved
    }
}

/// Solves the normal equations by elimination. Returns `None` if the solution is not unique.
fn solve(mut rows: [Row; ESTIMATES]) -> Option<[f64; ESTIMATES]> {
    for (i, row) in rows.iter_mut().enumerate() {
        // Regularization: keeps the weights of linearly dependent estimates small.
        row[i] += 1e-3 * row[i] + 1e-3;
    }
    for i in 0..ESTIMATES {
        let pivot = (i..ESTIMATES).max_by(|&a, &b| rows[a][i].abs().total_cmp(&rows[b][i].abs()))?;
        rows.swap(i, pivot);
        if rows[i][i].abs() < 1e-9 {
            return None;
        }
        for other in (0..ESTIMATES).filter(|&other| other != i) {
            let factor = rows[other][i] / rows[i][i];
            for j in i..=ESTIMATES {
                rows[other][j] -= factor * rows[i][j];
            }
        }
    }
    let mut solution = [0.0; ESTIMATES];
    (0..ESTIMATES).for_each(|i| solution[i] = rows[i][ESTIMATES] / rows[i][i]);
    Some(solution)
}
