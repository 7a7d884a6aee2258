//! Draws triangles with a depth per sample, band by band.

use rayon::prelude::*;

use super::options::RenderOptions;
use super::scene::{Facet, Vector, dot, unit};

/// Samples per pixel in each direction.
pub(super) const SAMPLES: usize = 4;

/// Rows of pixels that are drawn at the same time by one thread.
const BAND: usize = 16;

/// The direction to the light: from the upper left, in front of the model.
const LIGHT: Vector = [-0.45, 0.65, 0.75];
/// The shares of the light that comes from all sides and from [`LIGHT`].
const AMBIENT: f64 = 0.34;
const DIRECT: f64 = 0.70;

/// Draws triangles, and returns the pixels in rows from the top, in sRGB with alpha.
pub(super) fn draw(facets: &[Facet], options: &RenderOptions) -> Vec<[u8; 4]> {
    let (width, height) = (options.width as usize, options.height as usize);
    let tones = Tones::new();
    let mut pixels = vec![[0; 4]; width * height];
    pixels.par_chunks_mut(width * BAND).enumerate().for_each(|(band, pixels)| {
        let rows = pixels.len() / width;
        let mut samples = Samples::new(width * SAMPLES, rows * SAMPLES);
        // The sample rows of the band, from the top of the picture; facets have their origin at the bottom.
        let top = (height - band * BAND) as f64;
        facets.iter().for_each(|facet| samples.add(facet, top, &tones));
        samples.resolve(pixels, width, options.background, &tones);
    });
    pixels
}

/// The samples of a band: the depth of the nearest triangle, and its colour in linear light.
struct Samples {
    width: usize,
    height: usize,
    depths: Vec<f64>,
    colours: Vec<[f32; 3]>,
}

impl Samples {
    fn new(width: usize, height: usize) -> Self {
        let count = width * height;
        Self { width, height, depths: vec![f64::NEG_INFINITY; count], colours: vec![[0.0; 3]; count] }
    }

    /// Draws the part of a triangle that lies in the band, whose upper border is at a height in pixels.
    fn add(&mut self, facet: &Facet, top: f64, tones: &Tones) {
        let scale = SAMPLES as f64;
        // Sample coordinates: the centre of sample (x, y) is at (x + 1/2, y + 1/2), y downwards.
        let [a, b, c] = facet.corners.map(|corner| [scale * corner[0], scale * (top - corner[1]), corner[2]]);
        let (Some(columns), Some(rows)) =
            (covered([a[0], b[0], c[0]], self.width), covered([a[1], b[1], c[1]], self.height))
        else {
            return;
        };
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        for y in rows {
            for x in columns.clone() {
                let at = [x as f64 + 0.5, y as f64 + 0.5];
                let edge = |p: Vector, q: Vector| {
                    ((q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0])) / area
                };
                let weights = [edge(b, c), edge(c, a), edge(a, b)];
                if weights.iter().any(|&weight| weight < 0.0) {
                    continue;
                }
                let depth = dot(weights, [a[2], b[2], c[2]]);
                let sample = y * self.width + x;
                if depth > self.depths[sample] {
                    self.depths[sample] = depth;
                    self.colours[sample] = shaded(facet, weights, tones);
                }
            }
        }
    }

    /// Averages the samples of each pixel, over the background.
    fn resolve(&self, pixels: &mut [[u8; 4]], width: usize, background: Option<[u8; 3]>, tones: &Tones) {
        let behind = background.map(|colour| tones.linear(colour));
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let (x, y) = (index % width * SAMPLES, index / width * SAMPLES);
            let (mut sum, mut covered) = ([0.0_f32; 3], 0_usize);
            for row in y..y + SAMPLES {
                for sample in row * self.width + x..row * self.width + x + SAMPLES {
                    if self.depths[sample] > f64::NEG_INFINITY {
                        covered += 1;
                        sum.iter_mut().zip(self.colours[sample]).for_each(|(sum, colour)| *sum += colour);
                    }
                }
            }
            let all = SAMPLES * SAMPLES;
            let (colour, alpha) = match behind {
                Some(behind) => {
                    let share = (all - covered) as f32;
                    ([0, 1, 2].map(|i| (sum[i] + share * behind[i]) / all as f32), 255)
                }
                None => (sum.map(|sum| sum / covered.max(1) as f32), (255 * covered / all) as u8),
            };
            let [r, g, b] = colour.map(|light| tones.encoded(light));
            *pixel = [r, g, b, alpha];
        }
    }
}

/// Returns the samples whose centres lie between the least and the greatest coordinate; `None` if there are none.
#[allow(clippy::cast_sign_loss, reason = "clamped to the band")]
fn covered(coordinates: [f64; 3], count: usize) -> Option<std::ops::Range<usize>> {
    let low = coordinates.into_iter().fold(f64::INFINITY, f64::min) - 0.5;
    let high = coordinates.into_iter().fold(f64::NEG_INFINITY, f64::max) - 0.5;
    let first = low.ceil().max(0.0);
    let last = high.floor().min(count as f64 - 1.0);
    (first <= last).then(|| first as usize..last as usize + 1)
}

/// Returns the colour of a triangle at a point, given by its weights of the corners, in linear light.
fn shaded(facet: &Facet, weights: [f64; 3], tones: &Tones) -> [f32; 3] {
    let [a, b, c] = facet.normals;
    let mixed = [0, 1, 2].map(|i| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i]);
    let towards_light = match (unit(mixed), unit(LIGHT)) {
        (Some(normal), Some(light)) => dot(normal, light).max(0.0),
        _ => 0.0,
    };
    let light = (AMBIENT + DIRECT * towards_light) as f32;
    tones.linear(facet.colour).map(|share| share * light)
}

/// Conversion between sRGB and linear light.
struct Tones {
    linear: [f32; 256],
}

impl Tones {
    fn new() -> Self {
        let mut linear = [0.0; 256];
        for (value, light) in linear.iter_mut().enumerate() {
            let share = value as f64 / 255.0;
            let exact =
                if share <= 0.040_45 { share / 12.92 } else { libm::pow((share + 0.055) / 1.055, 2.4) };
            *light = exact as f32;
        }
        Self { linear }
    }

    fn linear(&self, colour: [u8; 3]) -> [f32; 3] {
        colour.map(|value| self.linear[usize::from(value)])
    }

    /// Returns the sRGB value that is nearest to a share of linear light, rounded down between two.
    fn encoded(&self, light: f32) -> u8 {
        let above = self.linear.partition_point(|&known| known <= light);
        match above {
            0 => 0,
            256 => 255,
            _ if light - self.linear[above - 1] > self.linear[above] - light => above as u8,
            _ => (above - 1) as u8,
        }
    }
}
