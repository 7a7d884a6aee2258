//! The linear least-squares problem whose solution moves a surface toward points.
//!
//! # Algorithm
//! A point has the barycentric coordinates s in its triangle, and the vector r to the other
//! surface. It contributes one equation: the sum of the corner moves, weighted by s, equals r. The
//! residual has full weight along the normal, and a small weight in the tangent plane. The normal
//! equations of all points of a triangle sum to one 3 × 3 block per pair of corners. The time of an
//! iteration therefore does not depend on the number of points. The system is solved by conjugate
//! gradients, preconditioned by the inverse diagonal block of each position.
//!
//! # Complexity
//! O(p + s t) time for p points, s iterations and t triangles; 300 bytes per triangle.

use super::surface::Point;
use crate::surface_change::dot;

/// The number of conjugate gradient iterations.
const STEPS: usize = 24;
/// The weight of a distance along the plane of a triangle, relative to a distance from it.
const ALONG: f64 = 0.05;
/// The weight of the moves themselves, relative to evenly spread points. It limits the moves of
/// positions with few points.
const STIFFNESS: f64 = 0.02;
/// The pairs of corners.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [0, 2], [1, 2]];

/// A symmetric 3 × 3 matrix: the first row, the rest of the second, the rest of the third.
type Block = [f64; 6];

/// The equation of a point for the corners of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pull {
    pub(super) triangle: u32,
    pub(super) shares: Point,
    /// The vector from the surface to the target.
    pub(super) rest: Point,
    /// The direction in which distances have full weight: a unit vector, or zero.
    pub(super) normal: Point,
    pub(super) weight: f64,
}

/// The normal equations of the moves.
pub(super) struct Equations<'a> {
    triangles: &'a [[u32; 3]],
    /// One block per pair of corners of each triangle.
    blocks: Vec<[Block; 6]>,
    right: Vec<Point>,
    /// The mass of each position; see [`FitSurface::masses`](super::surface::FitSurface::masses).
    mass: Vec<f64>,
}

impl Pull {
    /// Returns the weight matrix of a residual: full weight along the normal, a small weight across
    /// it.
    fn weights(&self) -> Block {
        let [x, y, z] = self.normal;
        let full = self.weight * (1.0 - ALONG);
        let along = self.weight * ALONG;
        [
            full * x * x + along,
            full * x * y,
            full * x * z,
            full * y * y + along,
            full * y * z,
            full * z * z + along,
        ]
    }
}

impl<'a> Equations<'a> {
    pub(super) fn new(triangles: &'a [[u32; 3]], mass: Vec<f64>) -> Self {
        let (blocks, right) = (vec![[[0.0; 6]; 6]; triangles.len()], vec![[0.0; 3]; mass.len()]);
        Self { triangles, blocks, right, mass }
    }

    pub(super) fn add(&mut self, pull: &Pull) {
        let weights = pull.weights();
        let blocks = &mut self.blocks[pull.triangle as usize];
        for (block, [i, j]) in blocks.iter_mut().zip(PAIRS) {
            let share = pull.shares[i] * pull.shares[j];
            add_scaled(block, &weights, share);
        }
        let weighted = product(&weights, pull.rest);
        for (&corner, share) in self.triangles[pull.triangle as usize].iter().zip(pull.shares) {
            let right = &mut self.right[corner as usize];
            *right = [0, 1, 2].map(|k| right[k] + share * weighted[k]);
        }
    }

    /// Returns the moves of all positions. Positions that are not free have zero moves.
    pub(super) fn solve(&self, is_free: &[bool]) -> Vec<Point> {
        let inverses = self.inverses();
        let conditioned = |rest: &[Point]| -> Vec<Point> {
            rest.iter().zip(&inverses).map(|(&rest, inverse)| product(inverse, rest)).collect()
        };
        let inner = |a: &[Point], b: &[Point]| a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum::<f64>();
        let mut moves = vec![[0.0; 3]; self.right.len()];
        let mut rest = self.right.clone();
        fix(&mut rest, is_free);
        let mut search = conditioned(&rest);
        let mut energy = inner(&rest, &search);
        for _ in 0..STEPS {
            let mut image = self.image(&search);
            fix(&mut image, is_free);
            let curvature = inner(&search, &image);
            if energy <= 0.0 || curvature <= 0.0 {
                break;
            }
            let length = energy / curvature;
            for v in 0..moves.len() {
                for k in 0..3 {
                    moves[v][k] += length * search[v][k];
                    rest[v][k] -= length * image[v][k];
                }
            }
            let next = conditioned(&rest);
            let now = inner(&rest, &next);
            let ratio = now / energy;
            energy = now;
            for (search, next) in search.iter_mut().zip(next) {
                *search = [0, 1, 2].map(|k| next[k] + ratio * search[k]);
            }
        }
        moves
    }

    /// Returns the product of the system matrix and a field of moves.
    fn image(&self, field: &[Point]) -> Vec<Point> {
        let mut image: Vec<Point> =
            field.iter().zip(&self.mass).map(|(by, mass)| by.map(|x| STIFFNESS * mass * x)).collect();
        for (corners, blocks) in self.triangles.iter().zip(&self.blocks) {
            for (block, [i, j]) in blocks.iter().zip(PAIRS) {
                let ends = if i == j { &[[i, j]][..] } else { &[[i, j], [j, i]] };
                for &[to, from] in ends {
                    let by = product(block, field[corners[from] as usize]);
                    let image = &mut image[corners[to] as usize];
                    *image = [0, 1, 2].map(|k| image[k] + by[k]);
                }
            }
        }
        image
    }

    /// Returns the inverse of the diagonal block of each position; zero for positions without
    /// points.
    fn inverses(&self) -> Vec<Block> {
        let stiff = |mass: &f64| [*mass * STIFFNESS, 0.0, 0.0, *mass * STIFFNESS, 0.0, *mass * STIFFNESS];
        let mut sums: Vec<Block> = self.mass.iter().map(stiff).collect();
        for (corners, blocks) in self.triangles.iter().zip(&self.blocks) {
            for (&corner, block) in corners.iter().zip(blocks) {
                add_scaled(&mut sums[corner as usize], block, 1.0);
            }
        }
        sums.iter().map(inverse).collect()
    }
}

/// Sets the moves of positions that are not free to zero.
fn fix(field: &mut [Point], is_free: &[bool]) {
    field.iter_mut().zip(is_free).filter(|(_, is_free)| !**is_free).for_each(|(x, _)| *x = [0.0; 3]);
}

fn add_scaled(sum: &mut Block, block: &Block, factor: f64) {
    sum.iter_mut().zip(block).for_each(|(sum, x)| *sum += factor * x);
}

fn product([a, b, c, d, e, f]: &Block, [x, y, z]: Point) -> Point {
    [a * x + b * y + c * z, b * x + d * y + e * z, c * x + e * y + f * z]
}

/// Returns the inverse of a positive definite matrix, or zero if it has none.
fn inverse(&[a, b, c, d, e, f]: &Block) -> Block {
    let first = [d * f - e * e, c * e - b * f, b * e - c * d];
    let determinant = a * first[0] + b * first[1] + c * first[2];
    if !(determinant > 0.0 && determinant.is_finite()) {
        return [0.0; 6];
    }
    [first[0], first[1], first[2], a * f - c * c, b * c - a * e, a * d - b * b].map(|x| x / determinant)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_change::sub;
    use tristrip::random::Random;

    /// The moves minimize the sum of weighted squares: any other moves have a larger sum.
    #[test]
    #[allow(clippy::float_cmp, reason = "what is fixed must not move by a bit")]
    fn the_moves_solve_the_equations() {
        let mut random = Random::new(7);
        let mut number = || (random.below(2000) as f64 - 1000.0) / 1000.0;
        let triangles = [[0, 1, 2], [1, 2, 3], [2, 3, 0], [3, 0, 1]];
        let pulls: Vec<Pull> = (0..60)
            .map(|i| {
                let [u, v] = [number().abs() / 2.0, number().abs() / 2.0];
                let normal = crate::simplify::fit::surface::unit([number(), number(), number()]);
                let (rest, weight) = ([number(), number(), number()], 0.5 + number().abs());
                Pull { triangle: i % 4, shares: [1.0 - u - v, u, v], rest, normal, weight }
            })
            .collect();
        let mass = [3.0, 5.0, 4.0, 6.0];
        let mut equations = Equations::new(&triangles, mass.to_vec());
        pulls.iter().for_each(|pull| equations.add(pull));
        let moves = equations.solve(&[true, true, true, false]);
        assert_eq!(moves[3], [0.0; 3]);
        let energy = |moves: &[Point]| {
            let stiff = moves.iter().zip(mass).map(|(&by, mass)| STIFFNESS * mass * dot(by, by));
            let mut sum: f64 = stiff.sum();
            for pull in &pulls {
                let corners = triangles[pull.triangle as usize];
                let mut value = [0.0; 3];
                for (&corner, share) in corners.iter().zip(pull.shares) {
                    let by = moves[corner as usize];
                    value = [0, 1, 2].map(|k| value[k] + share * by[k]);
                }
                let left = sub(value, pull.rest);
                let across = dot(pull.normal, left);
                sum += pull.weight * ((1.0 - ALONG) * across * across + ALONG * dot(left, left));
            }
            sum
        };
        let least = energy(&moves);
        for v in 0..3 {
            for k in 0..3 {
                for by in [-1e-3, 1e-3] {
                    let mut other = moves.clone();
                    other[v][k] += by;
                    assert!(energy(&other) >= least, "{v} {k} {by}");
                }
            }
        }
    }
}
