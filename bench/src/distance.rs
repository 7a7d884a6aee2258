//! Distance of two triangle meshes: the two-sided root mean square distance.
//!
//! Points are sampled on one surface in proportion to area, with a seeded generator; the nearest point of the other surface is searched
//! in a uniform grid, shell after shell. The mean of both directions, as a fraction of the diagonal of the first surface's bounding box,
//! is the measure that the peers were compared by.
//!
//! # References
//! Cignoni, Rocchini, Scopigno: *Metro: Measuring Error on Simplified Surfaces*, 1998.

use tristrip::random::Random;

type Point = [f64; 3];

/// Grid cells along the longest side.
const CELLS: usize = 64;

/// Returns the two-sided distance of `other` from `surface`, index buffers over the same vertices, as a fraction of the diagonal of
/// the first one's bounding box, with `points` samples in each direction; NaN if one of them has no area.
///
/// # Panics
/// An index has no position.
pub fn two_sided_rms(surface: &[u32], other: &[u32], positions: &[[f32; 3]], points: usize) -> f64 {
    let at = |v: u32| positions[v as usize].map(f64::from);
    let bounds = Bounds::of(surface.iter().map(|&v| at(v)));
    let triangles = |indices: &[u32]| -> Vec<[Point; 3]> {
        indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(at)).collect()
    };
    let (a, b) = (triangles(surface), triangles(other));
    let (there, back) = (
        mean_square(&a, &CellGrid::new(&b, &bounds), points),
        mean_square(&b, &CellGrid::new(&a, &bounds), points),
    );
    f64::midpoint(there, back).sqrt() / bounds.diagonal()
}

struct Bounds {
    low: Point,
    high: Point,
}

impl Bounds {
    fn of(points: impl Iterator<Item = Point>) -> Self {
        let empty = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        points.fold(empty, |b, p| Self {
            low: [0, 1, 2].map(|k| b.low[k].min(p[k])),
            high: [0, 1, 2].map(|k| b.high[k].max(p[k])),
        })
    }

    fn diagonal(&self) -> f64 {
        let sides = sub(self.high, self.low);
        dot(sides, sides).sqrt()
    }
}

/// Triangles by the grid cells that their bounding boxes overlap.
struct CellGrid<'a> {
    triangles: &'a [[Point; 3]],
    low: Point,
    side: f64,
    /// The triangles of each cell, one cell after the other; `starts` has the first of each.
    members: Vec<u32>,
    starts: Vec<u32>,
}

impl<'a> CellGrid<'a> {
    fn new(triangles: &'a [[Point; 3]], bounds: &Bounds) -> Self {
        let longest = (0..3).map(|k| bounds.high[k] - bounds.low[k]).fold(0.0, f64::max);
        let side = (longest / CELLS as f64 * 1.000_1).max(f64::MIN_POSITIVE);
        let mut grid = Self { triangles, low: bounds.low, side, members: Vec::new(), starts: Vec::new() };
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (t, triangle) in triangles.iter().enumerate() {
            let of = Bounds::of(triangle.iter().copied());
            let (low, high) = (grid.cell(of.low), grid.cell(of.high));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    pairs.extend((low[2]..=high[2]).map(|z| (number([x, y, z]), t as u32)));
                }
            }
        }
        pairs.sort_unstable();
        let cell_count = (CELLS * CELLS * CELLS) as u32;
        grid.starts =
            (0..=cell_count).map(|cell| pairs.partition_point(|pair| pair.0 < cell) as u32).collect();
        grid.members = pairs.into_iter().map(|pair| pair.1).collect();
        grid
    }

    #[expect(clippy::cast_sign_loss, reason = "cut off at zero")]
    fn cell(&self, p: Point) -> [usize; 3] {
        [0, 1, 2].map(|k| (((p[k] - self.low[k]) / self.side).max(0.0) as usize).min(CELLS - 1))
    }

    /// Returns the squared distance to the nearest triangle.
    fn nearest(&self, p: Point) -> f64 {
        let center = self.cell(p);
        let mut least = f64::INFINITY;
        for shell in 0..CELLS {
            let range = |k: usize| center[k].saturating_sub(shell)..=(center[k] + shell).min(CELLS - 1);
            for x in range(0) {
                for y in range(1) {
                    for z in range(2) {
                        let [i, j, k] = [x.abs_diff(center[0]), y.abs_diff(center[1]), z.abs_diff(center[2])];
                        if i.max(j).max(k) == shell {
                            let cell = number([x, y, z]) as usize;
                            let members =
                                &self.members[self.starts[cell] as usize..self.starts[cell + 1] as usize];
                            let distances =
                                members.iter().map(|&t| to_triangle(p, self.triangles[t as usize]));
                            least = distances.fold(least, f64::min);
                        }
                    }
                }
            }
            // A farther shell has nothing nearer than the width of the shells searched.
            if least.sqrt() <= shell as f64 * self.side {
                break;
            }
        }
        least
    }
}

fn number([x, y, z]: [usize; 3]) -> u32 {
    ((x * CELLS + y) * CELLS + z) as u32
}

fn mean_square(from: &[[Point; 3]], to: &CellGrid<'_>, points: usize) -> f64 {
    let areas: Vec<f64> =
        from.iter().map(|&[a, b, c]| cross(sub(b, a), sub(c, a))).map(|n| dot(n, n).sqrt()).collect();
    let total: f64 = areas.iter().sum();
    let mut random = Random::new(1);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let (mut sum, mut count, mut due) = (0.0, 0_usize, 0.0);
    for (&[a, b, c], area) in from.iter().zip(&areas) {
        due += area / total * points as f64;
        while due >= 1.0 {
            due -= 1.0;
            let (u, v) = (uniform(), uniform());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            sum += to.nearest([0, 1, 2].map(|k| a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k])));
            count += 1;
        }
    }
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// Returns the squared distance from a point to a triangle (Ericson: *Real-Time Collision Detection*, 2005, section 5.1.5: by the region
/// of the point's projection).
fn to_triangle(p: Point, [a, b, c]: [Point; 3]) -> f64 {
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let square = |q: Point| dot(sub(p, q), sub(p, q));
    let along = |from: Point, edge: Point, t: f64| [0, 1, 2].map(|k| from[k] + t * edge[k]);
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return square(a);
    }
    let bp = sub(p, b);
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return square(b);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return square(along(a, ab, d1 / (d1 - d3)));
    }
    let cp = sub(p, c);
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return square(c);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return square(along(a, ac, d2 / (d2 - d6)));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return square(along(b, sub(c, b), (d4 - d3) / ((d4 - d3) + (d5 - d6))));
    }
    let scale = 1.0 / (va + vb + vc);
    square(along(along(a, ab, vb * scale), ac, vc * scale))
}

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_squares_a_tenth_apart() {
        let square = |z: f32| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z], [1.0, 1.0, z]];
        let positions = [square(0.0), square(0.1)].concat();
        let (low, high) = ([0, 1, 2, 2, 1, 3], [4, 5, 6, 6, 5, 7]);
        let found = two_sided_rms(&low, &high, &positions, 1000) * 2.0_f64.sqrt();
        assert!((found - 0.1).abs() < 1e-6, "{found}");
        assert!(two_sided_rms(&low, &low, &positions, 1000) < 1e-9);
        // Half of the other square is missing: the mean squared distance to its edge is 1/12 there.
        let half = two_sided_rms(&low, &high[..3], &positions, 4000) * 2.0_f64.sqrt();
        let expected = f64::midpoint(0.01 + 1.0 / 24.0, 0.01).sqrt();
        assert!((half - expected).abs() < 0.01, "{half} of {expected}");
    }
}
