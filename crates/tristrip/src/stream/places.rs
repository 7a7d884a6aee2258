//! Where the point of a split is: expected from the polygon around it, and coded as the difference.
//!
//! ```text
//!       a₂ ──── a₁             The polygon of the new point v is the kept point k and the points aₛ … aₑ around the corners that move. What is
//!      ╱  ╲    ╱  ╲            expected is the mean q of its points, and a weighted sum of how other estimates differ from q.
//!     a₃    v      a₀
//!      ╲  ╱    ╲  ╱
//!       k ──────
//! ```
//! # Algorithm
//! 1. The estimates: the kept point; the middle of aₛ and aₑ; the mean of the parallelograms over the edges of the polygon; q and the mean
//!    of the Laplacians of the polygon's points; the centre of its perimeter. They have weights along the normal of the polygon and
//!    others beside it, which the encoder fits to the model and sends: for each number of points in the polygon, and for each of three regimes of batches.
//! 2. The axes: the coordinates are coded one after the other, that along which the normal is longest last. A difference in the first two says
//!    what to expect in the others, if the new point is in the plane of the polygon.
//! 3. The scales: the size of the polygon, projected to each axis. Other contexts: how large the differences were at the points around, how much the
//!    estimates differ along the normal, how wide the polygon is along the axis, how much the coordinates before have differed.
//!
//! All is done in integers below 2⁵³, so that floats can stand for them; divisions round down.
//!
//! # References
//! Touma, Gotsman: *Triangle Mesh Compression*, 1998 (parallelograms). Taubin, Guéziec, Horn, Lazarus: *Progressive Forest Split Compression*, 1998; Alliez,
//! Desbrun: *Progressive Compression for Lossless Transmission of Triangle Meshes*, 2001 (barycentres, and the normal apart). The combination is ours.

use super::numbers::{NumberContext, NumberModel, halves};
use super::range_coder::BitCoder;

/// A position on the grid of the stream.
pub(super) type Place = [i32; 3];

/// The estimates beside the mean of the polygon.
pub(super) const ESTIMATES: usize = 5;
/// The numbers of points that have weights of their own: 3, 4, 5, 6, 7, and more.
const POLYGONS: usize = 6;
/// The batches that have weights of their own: the last, the last but one, and all before.
pub(super) const REGIMES: usize = 3;
/// Weights of the estimates along the normal and beside it, in 1/32.
pub(super) type Weights = [[[i32; 2]; ESTIMATES]; POLYGONS * REGIMES];
pub(super) const WEIGHT_ONE: i64 = 32;
pub(super) const USUAL_WEIGHTS: Weights =
    [[[22, 7], [-3, -10], [-2, -1], [8, 6], [0, 0]]; POLYGONS * REGIMES];

/// The contexts of a coordinate.
const CONTEXTS: usize = 1024;
/// The most bits of a coordinate.
pub(super) const MOST_BITS: u32 = 16;

/// How much of a point was unexpected: along the normal, and beside it, in buckets above the usual one, from 0 to [`MOST_SURPRISE`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Surprise {
    pub(super) along: u32,
    pub(super) beside: u32,
}

const MOST_SURPRISE: i32 = 10;

/// What is known around a new point.
#[derive(Debug, Clone, Default)]
pub(super) struct Polygon {
    /// The kept point, then aₛ … aₑ.
    pub(super) points: Vec<Place>,
    /// The sum of the parallelograms over its edges, and their number.
    pub(super) parallelograms: [i64; 3],
    pub(super) parallelogram_count: i64,
    /// The sum of the Laplacians of its points, in 1/16.
    pub(super) laplacians: [i64; 3],
    /// The surprises of the kept point, aₛ and aₑ.
    pub(super) surprises: [Surprise; 3],
}

impl Polygon {
    /// Adds the parallelogram over an edge whose triangle has a third point on the other side.
    #[inline]
    pub(super) fn add_parallelogram(&mut self, edge: [Place; 2], third: Place) {
        for j in 0..3 {
            self.parallelograms[j] += i64::from(edge[0][j]) + i64::from(edge[1][j]) - i64::from(third[j]);
        }
        self.parallelogram_count += 1;
    }
}

/// The estimates of a point.
#[derive(Debug)]
pub(super) struct Estimates {
    /// The mean of the polygon, in 1/16.
    pub(super) mean: [i64; 3],
    /// How the others differ from it, in 1/16.
    pub(super) others: [[i64; 3]; ESTIMATES],
    /// The normal of the polygon, of any length.
    pub(super) normal: [i64; 3],
    /// The square of the mean distance of its points from the mean.
    square: i64,
    /// Which weights apply.
    pub(super) class: usize,
}

fn floor_div(a: i64, b: i64) -> i64 {
    if b > 0 { a.div_euclid(b) } else { 0 }
}

fn dot(a: &[i64; 3], b: &[i64; 3]) -> i64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(super) fn square_distance(a: Place, b: Place) -> u64 {
    let square = |j: usize| {
        let difference = u64::from(a[j].abs_diff(b[j]));
        difference * difference
    };
    square(0) + square(1) + square(2)
}

impl Estimates {
    pub(super) fn new(polygon: &Polygon, regime: usize) -> Self {
        let points = &polygon.points;
        let (kept, count) = (points[0], i64::from(points.len() as u32));
        let last = points[points.len() - 1];
        let axes = [0, 1, 2];
        let mut sum = [0; 3];
        let (mut perimeter, mut length) = ([0; 3], 0);
        let mut before = last;
        for &point in points {
            let side: i64 = axes.iter().map(|&j| i64::from(point[j].abs_diff(before[j]))).sum();
            length += side;
            for j in axes {
                sum[j] += i64::from(point[j]);
                perimeter[j] += side * (i64::from(point[j]) + i64::from(before[j]));
            }
            before = point;
        }
        let mean = sum.map(|x| floor_div(16 * x, count));
        let difference = |j: usize, estimate: i64| estimate - mean[j];
        let of_kept = axes.map(|j| difference(j, 16 * i64::from(kept[j])));
        let of_ends = axes.map(|j| difference(j, 8 * (i64::from(points[1][j]) + i64::from(last[j]))));
        let of_sides = match polygon.parallelogram_count {
            0 => [0; 3],
            n => axes.map(|j| difference(j, floor_div(16 * polygon.parallelograms[j], n))),
        };
        let of_laplacians = polygon.laplacians.map(|x| floor_div(x, count));
        let of_perimeter = match length {
            0 => [0; 3],
            _ => axes.map(|j| difference(j, floor_div(8 * perimeter[j], length))),
        };
        let square = |&point: &Place| square_distance(point, mean.map(|x| (x >> 4) as i32)).cast_signed();
        Self {
            mean,
            others: [of_kept, of_ends, of_sides, of_laplacians, of_perimeter],
            normal: normal(points),
            square: floor_div(points.iter().map(square).sum(), count) + 1,
            class: regime * POLYGONS + (points.len() - 3).min(POLYGONS - 1),
        }
    }

    /// Returns the expected point, in 1/512.
    fn expected(&self, weights: &Weights) -> [i64; 3] {
        let mut expected = self.mean.map(|x| x * WEIGHT_ONE);
        let mut along = 0;
        for (other, weights) in self.others.iter().zip(&weights[self.class]) {
            let [normal, beside] = weights.map(i64::from);
            (0..3).for_each(|j| expected[j] += beside * other[j]);
            along += (normal - beside) * dot(other, &self.normal);
        }
        let square = dot(&self.normal, &self.normal);
        (0..3).for_each(|j| expected[j] += floor_div(along * self.normal[j], square));
        expected
    }

    /// Returns how much an estimate differs from the mean along the normal, relative to the size of the polygon: 0 to 15.
    fn height(&self, estimate: usize) -> usize {
        let along = dot(&self.others[estimate], &self.normal) >> 6;
        let logarithm = |x: i64| halves(x.cast_unsigned());
        let below = logarithm(dot(&self.normal, &self.normal)) + logarithm(self.square);
        (logarithm(along * along) + 20).saturating_sub(below).min(15)
    }
}

/// Returns the sum of the normals of the triangles between the first point and the others, with eight bits along its longest axis.
fn normal(points: &[Place]) -> [i64; 3] {
    let from_first = |point: &Place| [0, 1, 2].map(|j| i64::from(point[j]) - i64::from(points[0][j]));
    let mut normal = [0_i64; 3];
    for pair in points[1..].windows(2) {
        let [a, b] = [from_first(&pair[0]), from_first(&pair[1])];
        for j in 0..3 {
            let (x, y) = ((j + 1) % 3, (j + 2) % 3);
            normal[j] += a[x] * b[y] - a[y] * b[x];
        }
    }
    let most = normal.iter().map(|x| x.unsigned_abs()).max().unwrap_or(0);
    let surplus = (u64::BITS - most.leading_zeros()).saturating_sub(8);
    normal.map(|x| x >> surplus)
}

/// The models of the coordinates of new points.
#[derive(Debug, Clone)]
pub(super) struct PlaceModel {
    numbers: NumberModel,
    pub(super) weights: Weights,
    /// The largest coordinate of the bits that are known: bytes that no encoder has written may lead beyond it.
    pub(super) most: i32,
}

impl PlaceModel {
    pub(super) fn new(weights: &Weights) -> Self {
        Self { numbers: NumberModel::new(3, CONTEXTS), weights: *weights, most: 0 }
    }

    /// Codes the position of a new point.
    pub(super) fn code<C: BitCoder>(
        &mut self,
        coder: &mut C,
        polygon: &Polygon,
        estimates: &Estimates,
        place: Place,
    ) -> (Place, Surprise) {
        let expected = estimates.expected(&self.weights);
        let normal = &estimates.normal;
        let mut last = 2;
        for j in [1, 0] {
            if normal[j].abs() >= normal[last].abs() {
                last = j;
            }
        }
        let order = [(last + 1) % 3, (last + 2) % 3, last];
        let [n0, n1, n2] = order.map(|j| normal[j]);
        let square = dot(normal, normal);
        let rest = square - n0 * n0;
        let size = estimates.square;
        let scale = |x: i64| halves(x.cast_unsigned());
        let scales = if square == 0 {
            [scale(16 * size); 3]
        } else {
            let shares = [
                floor_div(1024 * rest, square),
                floor_div(1024 * n2 * n2, rest),
                floor_div(1024 * square, n2 * n2),
            ];
            shares.map(|share| scale((size * share) >> 6))
        };
        // The contexts.
        let sum = |of: fn(&Surprise) -> u32| polygon.surprises.iter().map(of).sum::<u32>().min(31) as usize;
        let (along, beside) = (sum(|surprise| surprise.along), sum(|surprise| surprise.beside));
        let class = polygon.points.len().min(8) - 3;
        let heights = [2, 3, 0].map(|estimate| estimates.height(estimate));
        let width = |axis: usize| {
            let j = order[axis];
            let offset = |point: &Place| i64::from(point[j]) - (estimates.mean[j] >> 4);
            let squares: i64 = polygon.points.iter().map(|point| offset(point) * offset(point)).sum();
            let width = scale(16 * (floor_div(squares, i64::from(polygon.points.len() as u32)) + 1));
            (width + 16).saturating_sub(scales[axis]).min(31)
        };
        let level = |above: i32| (above + 4).clamp(0, 7).cast_unsigned() as usize;
        let common = |axis: usize| {
            [class * 128 + scales[axis].min(127), heights[1] * 32 + heights[0], heights[2] * 32 + heights[1]]
        };

        // 1. The coordinates beside the normal.
        let mut found = [0; 3];
        let round = |x: i64| ((x + 256) >> 9) as i32;
        let mut code = |axis: usize, expected: i64, first: [usize; 2]| {
            let middle = round(expected);
            let [c, d, e] = common(axis);
            let context =
                NumberContext { axis, scale: scales[axis], contexts: [first[0], first[1], c, d, e] };
            let difference = place[order[axis]].wrapping_sub(middle);
            let (difference, above) = self.numbers.code(coder, context, difference);
            found[order[axis]] = middle.wrapping_add(difference).clamp(0, self.most);
            // How far from what is expected of the polygon, in 1/512.
            (i64::from(found[order[axis]]) * 512 - expected, above)
        };
        let e0 = expected[order[0]];
        let (d0, above0) = code(0, e0, [beside * 32 + scales[0] / 2 % 32, width(0) * 8 + class]);
        let e1 = expected[order[1]];
        let shift = floor_div(-n0 * n1 * d0, rest);
        let (rest1, above1) =
            code(1, e1 + shift, [beside * 32 + level(above0) * 4, width(1) * 8 + level(above0)]);
        // 2. That along the normal.
        let d1 = rest1 + shift;
        let fall = floor_div(-(n0 * d0 + n1 * d1) * n2.signum(), n2.abs());
        let contexts = [along * 32 + level(above0), level(above0) * 8 + level(above1)];
        let (_, above2) = code(2, expected[order[2]] + fall, contexts);
        let surprise = |above: i32| above.clamp(0, MOST_SURPRISE).cast_unsigned();
        (found, Surprise { along: surprise(above2 + 5), beside: surprise(above0 + above1 + 7) })
    }

    /// Codes the position of a point of the base mesh, near a place at which the triangles around have sides of a square length.
    pub(super) fn code_base<C: BitCoder>(
        &mut self,
        coder: &mut C,
        near: Place,
        square: u64,
        place: Place,
    ) -> Place {
        let mut found = near;
        for axis in 0..3 {
            let context = NumberContext { axis, scale: halves(square), ..NumberContext::default() };
            let difference = place[axis].wrapping_sub(near[axis]);
            let (difference, _) = self.numbers.code(coder, context, difference);
            found[axis] = near[axis].wrapping_add(difference).clamp(0, self.most);
        }
        found
    }
}
