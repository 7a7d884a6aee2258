//! Eight views of a model, and the differences between this model and a second one in these views.
//!
//! # Algorithm
//! The eight perspective cameras look at the bounding box of the first model from beyond its
//! corners, so every surface direction is visible from one of them. Both models use the cameras of
//! the first, and the same background. A pixel is *covered* if triangles cover all of its samples,
//! and *empty* if they cover none.
//!
//! - Different: a channel differs by more than 8 of 255.
//! - Hole: covered in the first model, including its eight neighbours, and not fully covered in the
//!   second.
//! - Grown: empty in the first model, including its eight neighbours, and not empty in the second.

use super::encoding::encode;
use super::options::{Mode, RenderOptions, View};
use super::textured::TexturedModel;
use crate::error::Error;

/// The width and height of compared images in pixels.
const COMPARED_SIZE: u32 = 256;
/// Maximum channel difference that is ignored.
const TOLERANCE: u8 = 8;

/// The number of views.
pub const SIDES: usize = 8;

/// Differences between two models, in pixels summed over the eight views.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Differences {
    /// Pixels that show at least one of the models.
    pub shown: usize,
    /// Shown pixels that differ by more than 8 of 255 in a channel.
    pub different: usize,
    /// Pixels where the background is visible through the second model, except at the silhouette of
    /// the first.
    pub holes: usize,
    /// Pixels that show the second model where the first has only background, except at its
    /// silhouette.
    pub grown: usize,
}

impl Differences {
    /// Returns the fraction of shown pixels that differ, from 0 to 1.
    pub fn share(&self) -> f64 {
        self.different as f64 / self.shown.max(1) as f64
    }
}

/// Compares a model with its replacement, such as a simplified model, in eight images of 256 × 256
/// pixels.
///
/// # Errors
/// A triangle of `after` is far outside the bounding box of `before`, and is behind or next to the
/// eye.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_render::images::{Mode, TexturedModel, compare};
/// let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
/// let before = TexturedModel::new(&read(square.as_bytes(), Format::Obj)?)?;
/// let torn = TexturedModel::new(&read(square[..40].as_bytes(), Format::Obj)?)?;
/// let differences = compare(&before, &torn, Mode::Shaded)?;
/// assert!(differences.holes > 0 && differences.grown == 0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compare(before: &TexturedModel, after: &TexturedModel, mode: Mode) -> Result<Differences, Error> {
    let mut differences = Differences::default();
    for options in views(COMPARED_SIZE) {
        let Some(camera) = before.camera(&options)? else { break };
        let pictures = [before.seen(&camera, mode, &options)?, after.seen(&camera, mode, &options)?];
        differences.add(&pictures[0], &pictures[1], COMPARED_SIZE as usize);
    }
    Ok(differences)
}

/// Draws one row of images per model, from the eight sides of the first model, in squares of `size`
/// pixels. Returns the bytes of a PNG file.
///
/// # Errors
/// The image would be too large, or a triangle far outside the bounding box of the first model is
/// behind or next to the eye.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_render::images::{Mode, TexturedModel, rows_of_sides};
/// let model = TexturedModel::new(&read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", Format::Obj)?)?;
/// let png = rows_of_sides(&[&model, &model], Mode::Textured, 32)?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn rows_of_sides(models: &[&TexturedModel], mode: Mode, size: u32) -> Result<Vec<u8>, Error> {
    let height = size.saturating_mul(u32::try_from(models.len()).unwrap_or(u32::MAX));
    let sheet = RenderOptions::default().with_size(size.saturating_mul(SIDES as u32), height);
    sheet.check()?;
    let (width, side) = (sheet.width as usize, size as usize);
    let mut pixels = vec![[255; 4]; width * height as usize];
    for (column, options) in views(size).enumerate() {
        let Some(camera) = models.first().map(|first| first.camera(&options)).transpose()?.flatten() else {
            break;
        };
        for (row, model) in models.iter().enumerate() {
            let seen = model.seen(&camera, mode, &options)?;
            for (y, line) in seen.chunks_exact(side).enumerate() {
                let first = (row * side + y) * width + column * side;
                pixels[first..first + side].copy_from_slice(line);
            }
        }
    }
    encode(&pixels, &sheet)
}

/// Returns the options of the eight views from beyond the corners of a box, the upper four first.
fn views(size: u32) -> impl Iterator<Item = RenderOptions> {
    const AROUND: [[f64; 2]; 4] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    [1.0, -1.0].into_iter().flat_map(move |height| {
        AROUND.into_iter().map(move |[x, z]| {
            let view = View { from: [x, height, z], up: [0.0, 1.0, 0.0] };
            RenderOptions::default().with_size(size, size).with_view(view)
        })
    })
}

impl Differences {
    /// Adds a view with rows of `width` pixels.
    fn add(&mut self, before: &[[u8; 4]], after: &[[u8; 4]], width: usize) {
        for (at, (b, a)) in before.iter().zip(after).enumerate() {
            let shown = b[3] > 0 || a[3] > 0;
            self.shown += usize::from(shown);
            let differs = (0..3).any(|channel| b[channel].abs_diff(a[channel]) > TOLERANCE);
            self.different += usize::from(shown && differs);
            // Pixels outside the image count as background.
            let is_around = |alpha: u8| {
                let (x, y) = (at % width, at / width);
                (y.wrapping_sub(1)..=y + 1).all(|y| {
                    (x.wrapping_sub(1)..=x + 1).all(|x| {
                        let found = if x < width { before.get(y * width + x) } else { None };
                        found.map_or(0, |pixel| pixel[3]) == alpha
                    })
                })
            };
            self.holes += usize::from(a[3] < 255 && b[3] == 255 && is_around(255));
            self.grown += usize::from(a[3] > 0 && b[3] == 0 && is_around(0));
        }
    }
}
