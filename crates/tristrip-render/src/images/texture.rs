//! Textures: images decoded within a budget, with bilinear sampling.
//!
//! The PNG and JPEG decoders use no architecture-specific instructions, so a texture has the same
//! pixels on every machine.

use std::io::Cursor;

use tristrip::text::counted;
use tristrip_io::gltf::{Image, Wrap};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::tones::Tones;
use crate::error::Error;

/// Maximum number of pixels of all textures of a model: 192 MiB.
pub(super) const MAX_PIXELS: usize = 1 << 26;

/// The magic bytes of PNG.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// The magic bytes of JPEG.
const JPEG: &[u8] = b"\xff\xd8\xff";

/// A decoded image.
#[derive(Debug)]
pub(super) struct Texture {
    width: usize,
    height: usize,
    /// sRGB pixels in rows from the top.
    pixels: Vec<[u8; 3]>,
}

impl Texture {
    /// Decodes an image and charges its pixels to a budget.
    pub(super) fn decode(image: &Image, budget: &mut usize) -> Result<Self, Error> {
        let bytes = image.bytes();
        let wrong = |why: String| Error::Image(format!("{}: {why}", image.at));
        if bytes.starts_with(PNG) {
            decode_png(bytes, budget).map_err(wrong)
        } else if bytes.starts_with(JPEG) {
            decode_jpeg(bytes, budget).map_err(wrong)
        } else {
            let found: Vec<u8> = bytes.iter().copied().take(8).collect();
            Err(wrong(format!("found an image that starts with {found:?}, expected PNG or JPEG")))
        }
    }

    fn new(width: usize, height: usize, data: &[u8], channels: usize) -> Result<Self, String> {
        let pixels: Vec<[u8; 3]> = data
            .chunks_exact(channels)
            .take(width * height)
            .map(|pixel| if channels < 3 { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] })
            .collect();
        if width == 0 || pixels.len() != width * height {
            let found = counted(pixels.len(), "pixel");
            return Err(format!("found {found}, expected {width} × {height}"));
        }
        Ok(Self { width, height, pixels })
    }

    /// Returns the bilinearly interpolated colour at texture coordinates, in linear light. The
    /// origin is the upper left corner.
    pub(super) fn sample(&self, [u, v]: [f64; 2], wrap: [Wrap; 2], tones: &Tones) -> [f32; 3] {
        let (x, y) = (u * self.width as f64 - 0.5, v * self.height as f64 - 0.5);
        let (left, above) = (x.floor(), y.floor());
        let (right, below) = ((x - left) as f32, (y - above) as f32);
        let columns = [left, left + 1.0].map(|x| wrapped(x, self.width, wrap[0]));
        let rows = [above, above + 1.0].map(|y| wrapped(y, self.height, wrap[1]));
        let at =
            |row: usize, column: usize| tones.linear(self.pixels[rows[row] * self.width + columns[column]]);
        let between =
            |a: [f32; 3], b: [f32; 3], share: f32| [0, 1, 2].map(|i| a[i] * (1.0 - share) + b[i] * share);
        between(between(at(0, 0), at(0, 1), right), between(at(1, 0), at(1, 1), right), below)
    }
}

/// Returns the pixel index for an integral coordinate, which may be outside the image.
#[allow(clippy::cast_sign_loss, reason = "not negative; NaN becomes 0")]
fn wrapped(at: f64, count: usize, wrap: Wrap) -> usize {
    let n = count as f64;
    let at = match wrap {
        Wrap::Repeat => at.rem_euclid(n),
        Wrap::Mirror => {
            let at = at.rem_euclid(2.0 * n);
            if at < n { at } else { 2.0 * n - 1.0 - at }
        }
        Wrap::Clamp => at.max(0.0),
    };
    (at as usize).min(count - 1)
}

/// Charges the pixels of an image to a budget.
fn charge(width: usize, height: usize, budget: &mut usize) -> Result<(), String> {
    let left = width.checked_mul(height).and_then(|count| budget.checked_sub(count));
    *budget = left.ok_or_else(|| {
        format!("found {width} × {height} pixels, the limit is {MAX_PIXELS} for all images of a model")
    })?;
    Ok(())
}

fn decode_png(bytes: &[u8], budget: &mut usize) -> Result<Texture, String> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    // Palettes and fewer bits are expanded to bytes; 16-bit channels are reduced to their upper
    // byte.
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|error| error.to_string())?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    charge(width, height, budget)?;
    let size = reader.output_buffer_size().ok_or("found an image too large for memory")?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(|error| error.to_string())?;
    Texture::new(width, height, &data, frame.color_type.samples())
}

fn decode_jpeg(bytes: &[u8], budget: &mut usize) -> Result<Texture, String> {
    let options = DecoderOptions::default().set_use_unsafe(false).jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions().ok_or("found no size")?;
    charge(width, height, budget)?;
    let data = decoder.decode().map_err(|error| error.to_string())?;
    Texture::new(width, height, &data, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_outside_are_repeated_mirrored_or_clamped() {
        let rows = |wrap| [-4.0, -1.0, 0.0, 2.0, 3.0, 4.0, 6.0].map(|at| wrapped(at, 3, wrap));
        assert_eq!(rows(Wrap::Repeat), [2, 2, 0, 2, 0, 1, 0]);
        assert_eq!(rows(Wrap::Mirror), [2, 0, 0, 2, 2, 1, 0]);
        assert_eq!(rows(Wrap::Clamp), [0, 0, 0, 2, 2, 2, 2]);
        assert!(wrapped(f64::NAN, 3, Wrap::Repeat) < 3 && wrapped(f64::INFINITY, 3, Wrap::Mirror) < 3);
    }

    #[test]
    fn samples_lie_between_the_centres_of_pixels() {
        let texture = Texture::new(2, 1, &[0, 0, 0, 255, 255, 255], 3).unwrap();
        let tones = Tones::new();
        let red = |u: f64, wrap| texture.sample([u, 0.5], [wrap; 2], &tones)[0];
        let near = |found: f32, expected: f32| assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        near(red(0.25, Wrap::Clamp), 0.0);
        near(red(0.75, Wrap::Clamp), 1.0);
        near(red(0.375, Wrap::Clamp), 0.25);
        near(red(0.0, Wrap::Clamp), 0.0);
        near(red(0.0, Wrap::Repeat), 0.5);
        near(red(-0.25, Wrap::Repeat), 1.0);
        near(red(-0.25, Wrap::Mirror), 0.0);
    }

    #[test]
    fn the_pixels_of_all_images_have_a_limit() {
        let mut budget = MAX_PIXELS;
        assert!(charge(1 << 13, 1 << 12, &mut budget).is_ok());
        let error = charge(1 << 13, (1 << 12) + 1, &mut budget).unwrap_err();
        assert_eq!(error, "found 8192 × 4097 pixels, the limit is 67108864 for all images of a model");
        assert!(charge(1 << 13, 1 << 12, &mut budget).is_ok() && charge(1, 1, &mut budget).is_err());
        assert!(charge(usize::MAX, 2, &mut budget).is_err());
        assert!(Texture::new(0, 0, &[], 3).is_err() && Texture::new(2, 2, &[0; 9], 3).is_err());
    }
}
