//! Rasterizes triangles band by band, with a depth per sample. The nearest triangle of each sample
//! is found first, then its colour is computed.

use rayon::prelude::*;

use super::options::RenderOptions;
use super::scene::Facet;
use super::shader::Shader;
use super::vector::{Vector, dot};

/// Samples per pixel in each direction.
pub(super) const SAMPLES: usize = 4;

/// The number of pixel rows that a thread draws at a time.
const BAND: usize = 16;

/// The index stored in a sample without a triangle.
const NONE: u32 = u32::MAX;

/// Draws triangles given in pixels and depth. Returns the pixels in rows from the top, in sRGB over
/// the background. Alpha is the fraction of covered samples: 255 if all are covered, at least 15 if
/// any is.
pub(super) fn draw(facets: &[Facet], shader: &Shader<'_>, options: &RenderOptions) -> Vec<[u8; 4]> {
    let (width, height) = (options.width as usize, options.height as usize);
    let mut pixels = vec![[0; 4]; width * height];
    pixels.par_chunks_mut(width * BAND).enumerate().for_each(|(band, pixels)| {
        let rows = pixels.len() / width;
        // The sample rows of the band from the top of the image. The origin of facets is at the
        // bottom.
        let top = (height - band * BAND) as f64;
        let mut samples = Samples::new(width * SAMPLES, rows * SAMPLES, top);
        (0..).zip(facets).for_each(|(number, facet)| samples.add(number, facet));
        samples.resolve(pixels, facets, shader, options.background);
    });
    pixels
}

/// Returns the number of samples that [`draw`] tests for a triangle: those of its bounding box
/// within the image.
pub(super) fn tested_samples(corners: [Vector; 3], options: &RenderOptions) -> u64 {
    let along = |axis: usize, size: u32| {
        let scaled = corners.map(|corner| SAMPLES as f64 * corner[axis]);
        covered(scaled, size as usize * SAMPLES).map_or(0, |samples| samples.len() as u64)
    };
    along(0, options.width) * along(1, options.height)
}

/// The samples of a band: the depth of the nearest triangle, and its index.
struct Samples {
    width: usize,
    height: usize,
    /// The y coordinate of the upper border in pixels.
    top: f64,
    depths: Vec<f64>,
    nearest: Vec<u32>,
}

impl Samples {
    fn new(width: usize, height: usize, top: f64) -> Self {
        let count = width * height;
        Self { width, height, top, depths: vec![f64::NEG_INFINITY; count], nearest: vec![NONE; count] }
    }

    /// Converts a triangle to sample coordinates. The centre of sample (x, y) is at (x + 1/2, y +
    /// 1/2); y points down.
    fn outline(&self, facet: &Facet) -> Option<Outline> {
        let scale = SAMPLES as f64;
        Outline::of(facet.corners.map(|[x, y, depth]| [scale * x, scale * (self.top - y), depth]))
    }

    /// Draws the part of a triangle within the band.
    fn add(&mut self, number: u32, facet: &Facet) {
        let Some(outline) = self.outline(facet) else { return };
        let [a, b, c] = outline.corners;
        let (Some(columns), Some(rows)) =
            (covered([a[0], b[0], c[0]], self.width), covered([a[1], b[1], c[1]], self.height))
        else {
            return;
        };
        for y in rows {
            for x in columns.clone() {
                let Some(weights) = outline.weights(x, y) else { continue };
                let depth = dot(weights, [a[2], b[2], c[2]]);
                let sample = y * self.width + x;
                if depth > self.depths[sample] {
                    self.depths[sample] = depth;
                    self.nearest[sample] = number;
                }
            }
        }
    }

    /// Averages the samples of each pixel over the background.
    fn resolve(
        &self,
        pixels: &mut [[u8; 4]],
        facets: &[Facet],
        shader: &Shader<'_>,
        background: Option<[u8; 3]>,
    ) {
        let behind = background.map(|colour| shader.decoded(colour));
        let width = self.width / SAMPLES;
        let all = SAMPLES * SAMPLES;
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let (x, y) = (index % width * SAMPLES, index / width * SAMPLES);
            let (mut sum, mut covered) = ([0.0_f32; 3], 0_usize);
            for row in y..y + SAMPLES {
                for column in x..x + SAMPLES {
                    let number = self.nearest[row * self.width + column];
                    let Some(facet) = facets.get(number as usize) else { continue };
                    covered += 1;
                    let outline = self.outline(facet);
                    if let Some((weights, outline)) = outline.and_then(|o| Some((o.weights(column, row)?, o)))
                    {
                        let colour =
                            shader.colour(facet, outline.values(weights, shader.perspective), outline.back);
                        sum.iter_mut().zip(colour).for_each(|(sum, colour)| *sum += colour);
                    }
                }
            }
            let colour = match behind {
                Some(behind) => {
                    let share = (all - covered) as f32;
                    [0, 1, 2].map(|i| (sum[i] + share * behind[i]) / all as f32)
                }
                None => sum.map(|sum| sum / covered.max(1) as f32),
            };
            let [r, g, b] = shader.encoded(colour);
            *pixel = [r, g, b, (255 * covered / all) as u8];
        }
    }
}

/// A triangle in sample coordinates with nonzero area.
struct Outline {
    corners: [Vector; 3],
    area: f64,
    /// Whether it is a back face.
    back: bool,
}

impl Outline {
    fn of(corners: [Vector; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        // Counter-clockwise triangles are clockwise if y points down.
        (area != 0.0 && area.is_finite()).then_some(Self { corners, area, back: area > 0.0 })
    }

    /// Returns the barycentric coordinates of the centre of a sample, or `None` if it is outside.
    fn weights(&self, x: usize, y: usize) -> Option<Vector> {
        let [a, b, c] = self.corners;
        let at = [x as f64 + 0.5, y as f64 + 0.5];
        let weights = [side(b, c, at) / self.area, side(c, a, at) / self.area, side(a, b, at) / self.area];
        weights.iter().all(|&weight| weight >= 0.0).then_some(weights)
    }

    /// Returns the interpolation weights of the corners' values. In perspective, value/distance is
    /// linear in the image, not the value itself.
    fn values(&self, weights: Vector, perspective: bool) -> Vector {
        if !perspective {
            return weights;
        }
        let over_distance = [0, 1, 2].map(|i| weights[i] * self.corners[i][2]);
        let sum: f64 = over_distance.iter().sum();
        over_distance.map(|share| share / sum)
    }
}

/// Returns the side of a line on which a point lies. Both directions of a line give exactly
/// opposite values, so no sample falls between two triangles that share an edge.
fn side(p: Vector, q: Vector, at: [f64; 2]) -> f64 {
    let forward = (p[0], p[1]) <= (q[0], q[1]);
    let (p, q) = if forward { (p, q) } else { (q, p) };
    let side = (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0]);
    if forward { side } else { -side }
}

/// Returns the samples whose centres are between the minimum and the maximum coordinate, or `None`
/// if there are none.
#[allow(clippy::cast_sign_loss, reason = "clamped to the band")]
fn covered(coordinates: [f64; 3], count: usize) -> Option<std::ops::Range<usize>> {
    let low = coordinates.into_iter().fold(f64::INFINITY, f64::min) - 0.5;
    let high = coordinates.into_iter().fold(f64::NEG_INFINITY, f64::max) - 0.5;
    let first = low.ceil().max(0.0);
    let last = high.floor().min(count as f64 - 1.0);
    (first <= last).then(|| first as usize..last as usize + 1)
}
