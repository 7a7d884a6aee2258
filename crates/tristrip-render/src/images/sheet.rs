//! Sheets: several images of strips in one file.

use tristrip::{Strips, lod};

use super::encoding::encode_few;
use super::options::RenderOptions;
use super::painted::{coloured, pixels_seen, plain};
use crate::error::Error;

/// The number of images per row.
const COLUMNS: usize = 2;

/// One image of a sheet.
#[derive(Debug, Clone, Copy)]
pub struct SheetImage<'a> {
    /// The positions of the vertices.
    pub positions: &'a [[f32; 3]],
    /// The strips to draw.
    pub strips: &'a Strips,
    /// The camera.
    pub camera: &'a lod::Camera,
    /// Whether each strip has its own colour.
    pub is_coloured: bool,
}

/// Draws images of one size, two per row, in reading order. Returns the bytes of a PNG file with
/// 256 colours.
///
/// # Errors
/// The sheet is too large, a coordinate is not finite, or a strip uses a vertex without a position.
pub fn sheet(pictures: &[SheetImage<'_>], [width, height]: [u32; 2]) -> Result<Vec<u8>, Error> {
    let columns = pictures.len().clamp(1, COLUMNS);
    let rows = pictures.len().div_ceil(columns).max(1);
    let of_picture = RenderOptions::default().with_size(width, height);
    let whole = of_picture.with_size(times(width, columns), times(height, rows));
    whole.check()?;
    let [wide, high] = [width as usize, height as usize];
    let mut pixels = vec![[255; 4]; wide * columns * high * rows];
    for (number, picture) in pictures.iter().enumerate() {
        let part = (picture.positions, picture.strips);
        let facets = if picture.is_coloured {
            coloured(&[part])?
        } else {
            plain(&[(picture.positions, &picture.strips.to_list())])?
        };
        let drawn = pixels_seen(&facets, picture.camera, &of_picture)?;
        let (row, column) = (number / columns, number % columns);
        for (y, line) in drawn.chunks_exact(wide).enumerate() {
            let first = (row * high + y) * wide * columns + column * wide;
            pixels[first..first + wide].copy_from_slice(line);
        }
    }
    encode_few(&pixels, &whole)
}

/// Returns `size` times `count`, saturated: a sheet that is too large is still rejected.
fn times(size: u32, count: usize) -> u32 {
    size.saturating_mul(u32::try_from(count).unwrap_or(u32::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the width and the pixels of a sheet.
    fn decoded(png: &[u8]) -> (u32, Vec<[u8; 3]>) {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(png));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        assert_eq!(reader.info().color_type, png::ColorType::Indexed);
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        (info.width, data.as_chunks().0.to_vec())
    }

    #[test]
    fn pictures_are_in_reading_order() {
        let square = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        let mut strips = Strips::default();
        strips.push(&[0, 1, 2, 3]);
        let at = |eye: [f32; 3]| lod::Camera::new(eye, [0.0; 3]).unwrap();
        let (near, far) = (at([0.0, 0.0, 1.5]), at([0.0, 0.0, 20.0]));
        let picture =
            |camera, is_coloured| SheetImage { positions: &square, strips: &strips, camera, is_coloured };
        let pictures = [picture(&near, true), picture(&far, true), picture(&near, false)];
        let (width, pixels) = decoded(&sheet(&pictures, [40, 30]).unwrap());
        assert_eq!((width, pixels.len()), (80, 80 * 60));
        let white = |x: usize, y: usize| pixels[y * 80 + x] == [255; 3];
        // The centres of the four images, and a corner of the second.
        assert_eq!([white(20, 15), white(60, 15), white(20, 45), white(60, 45)], [false, false, false, true]);
        assert!(white(42, 2) && !white(20, 2));
        let grey = |[r, g, b]: [u8; 3]| r == g && g == b;
        assert!(!grey(pixels[15 * 80 + 20]) && grey(pixels[45 * 80 + 20]));
    }

    #[test]
    fn an_empty_sheet_is_white_and_a_large_one_is_refused() {
        let (width, pixels) = decoded(&sheet(&[], [8, 6]).unwrap());
        assert_eq!((width, pixels), (8, vec![[255; 3]; 48]));
        let (strips, camera) = (Strips::default(), lod::Camera::new([0.0; 3], [1.0; 3]).unwrap());
        let picture = SheetImage { positions: &[], strips: &strips, camera: &camera, is_coloured: true };
        assert!(sheet(&[picture; 2], [8000, 10]).is_err());
        assert!(sheet(&[picture; 2], [u32::MAX, 1]).is_err());
        assert!(sheet(&[], [0, 1]).is_err());
    }
}
