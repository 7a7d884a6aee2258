//! Pictures of meshes and of strips, as PNG files in memory.
//!
//! ```text
//! positions, strips ─▶ scene: corners in pixels and depth, normals ─▶ raster: bands of rows, nearest sample ─▶ PNG
//!         └▶ colours: neighbouring strips differ ───────────────┘
//! ```
//! # Algorithm
//! 1. The vertices that triangles use are projected along the direction of view, without perspective, and scaled to fill the picture.
//! 2. A corner has the mean normal of the triangles around its vertex, unless the surface has a crease there; a light from the upper left
//!    shades both sides.
//! 3. Each strip gets the colour of a palette that its neighbours do not have (`colours.rs`).
//! 4. Bands of rows are drawn in parallel, with 4 × 4 samples per pixel and the nearest triangle at each.
//!
//! Only sums, products, quotients, square roots and `libm` decide, so that a picture has the same bytes on every machine. There is a crate
//! for software rendering, `euc`, but its published version is years old, and it does not state this.
//!
//! # Complexity
//! Linear time in triangles and samples, and a test of each triangle per band. 150 bytes per triangle, and about as much again while a part
//! is added; 20 bytes per sample of the bands that are drawn at the same time.

mod colours;
mod options;
mod raster;
mod scene;

use tristrip::Strips;

use crate::error::Error;
pub use options::{MAX_SIZE, RenderOptions, View};
use scene::Scene;

/// Draws strips with one colour per strip; strips that share an edge have different colours. A part is its positions and its strips.
/// Returns the bytes of a PNG file.
///
/// # Errors
/// A size is 0 or too large, the view has no direction, a coordinate is not finite, or strips name a vertex without a position.
///
/// ```
/// use tristrip::Strips;
/// use tristrip_lab::render::{RenderOptions, strips};
/// let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
/// let mut strip = Strips::default();
/// strip.push(&[0, 1, 2, 3]);
/// let png = strips(&[(&square, &strip)], &RenderOptions::default().with_size(64, 48))?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), tristrip_lab::Error>(())
/// ```
pub fn strips(parts: &[(&[[f32; 3]], &Strips)], options: &RenderOptions) -> Result<Vec<u8>, Error> {
    let mut scene = Scene::new(options)?;
    for (positions, strips) in parts {
        let colours = colours::of_strips(strips);
        let strips = strips.iter().zip(colours);
        let triangles = strips.flat_map(|(strip, colour)| {
            tristrip::strip_triangles(strip).map(move |triangle| (triangle, colour))
        });
        scene.add(positions, triangles)?;
    }
    encode(&raster::draw(&scene.finish(), options), options)
}

/// Draws triangles, three indices each, in one colour. A part is its positions and its triangles. Returns the bytes of a PNG file.
///
/// # Errors
/// As of [`strips`].
///
/// ```
/// use tristrip_lab::render::{RenderOptions, triangles};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let png = triangles(&[(&corners, &[0, 1, 2])], &RenderOptions::default().with_size(64, 48))?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), tristrip_lab::Error>(())
/// ```
pub fn triangles(parts: &[(&[[f32; 3]], &[u32])], options: &RenderOptions) -> Result<Vec<u8>, Error> {
    let mut scene = Scene::new(options)?;
    for (positions, corners) in parts {
        let (triangles, _) = corners.as_chunks();
        scene.add(positions, triangles.iter().map(|&triangle| (triangle, colours::PLAIN)))?;
    }
    encode(&raster::draw(&scene.finish(), options), options)
}

/// Encodes pixels as a PNG file.
fn encode(pixels: &[[u8; 4]], options: &RenderOptions) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, options.width, options.height);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let (colour, data): (_, Vec<u8>) = match options.background {
        Some(_) => (png::ColorType::Rgb, pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect()),
        None => (png::ColorType::Rgba, pixels.as_flattened().to_vec()),
    };
    encoder.set_color(colour);
    let picture = |error: png::EncodingError| Error::Picture(error.to_string());
    let mut writer = encoder.write_header().map_err(picture)?;
    writer.write_image_data(&data).map_err(picture)?;
    writer.finish().map_err(picture)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decodes a picture without transparency.
    fn decoded(png: &[u8]) -> (u32, Vec<[u8; 3]>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        (info.width, data.as_chunks().0.to_vec())
    }

    /// Returns a square at a depth, and its two triangles.
    fn square(x: f32, z: f32) -> Vec<[f32; 3]> {
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[a, b]| [x + a, b, z]).to_vec()
    }

    fn strip(vertices: &[u32]) -> Strips {
        let mut strips = Strips::default();
        strips.push(vertices);
        strips
    }

    fn front() -> RenderOptions {
        let view = View { from: [0.0, 0.0, 1.0], up: [0.0, 1.0, 0.0] };
        RenderOptions::default().with_view(view).with_size(40, 30)
    }

    #[test]
    fn the_nearest_surface_is_seen_and_the_background_around_it() {
        let (near, far) = (square(0.0, 1.0), square(0.0, 0.0));
        let whole = strip(&[0, 1, 2, 3]);
        let only_near = strips(&[(&near, &whole)], &front()).unwrap();
        let both = strips(&[(&near, &whole), (&far, &whole)], &front()).unwrap();
        let reversed = strips(&[(&far, &whole), (&near, &whole)], &front()).unwrap();
        assert_eq!(decoded(&both), decoded(&reversed));
        assert_eq!(decoded(&both), decoded(&only_near));
        let (width, pixels) = decoded(&both);
        assert_eq!(pixels[0], [255; 3]);
        assert_ne!(pixels[(15 * width + 20) as usize], [255; 3]);
        let covered = pixels.iter().filter(|&&pixel| pixel != [255; 3]).count();
        assert!((700..=800).contains(&covered), "a square of 28 pixels: {covered}");
    }

    #[test]
    fn strips_that_share_an_edge_have_different_colours() {
        let corners = square(0.0, 0.0);
        let mut halves = strip(&[0, 1, 2]);
        halves.push(&[2, 1, 3]);
        let (width, pixels) = decoded(&strips(&[(&corners, &halves)], &front()).unwrap());
        let at = |x: u32, y: u32| pixels[(y * width + x) as usize];
        assert_ne!(at(12, 22), at(27, 8));
        let (_, one) = decoded(&strips(&[(&corners, &strip(&[0, 1, 2, 3]))], &front()).unwrap());
        assert_eq!(one[(22 * width + 12) as usize], one[(8 * width + 27) as usize]);
    }

    #[test]
    fn both_sides_are_lit_and_threads_do_not_matter() {
        let corners = square(0.0, 0.0);
        let picture = |triangles: &[u32]| super::triangles(&[(&corners, triangles)], &front()).unwrap();
        assert_eq!(decoded(&picture(&[0, 1, 2])), decoded(&picture(&[2, 1, 0])));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| picture(&[0, 1, 2])), picture(&[0, 1, 2]));
    }

    #[test]
    fn nothing_can_be_drawn_and_wrong_arguments_are_refused() {
        let (_, pixels) = decoded(&strips(&[], &front()).unwrap());
        assert!(pixels.iter().all(|&pixel| pixel == [255; 3]));
        let point = [[1.0; 3]; 3];
        assert!(strips(&[(&point, &strip(&[0, 1, 2]))], &front()).is_ok(), "a triangle without area");
        assert!(strips(&[(&point, &strip(&[0, 1, 3]))], &front()).is_err());
        assert!(strips(&[(&[[f32::NAN; 3]; 3], &strip(&[0, 1, 2]))], &front()).is_err());
        assert!(strips(&[], &front().with_size(0, 5)).is_err());
        assert!(strips(&[], &front().with_size(5, MAX_SIZE + 1)).is_err());
        let along = View { from: [0.0, 2.0, 0.0], up: [0.0, 1.0, 0.0] };
        assert!(strips(&[], &front().with_view(along)).is_err());
        let far = [[f32::MAX, 0.0, 0.0], [-f32::MAX, 0.0, 0.0], [0.0, f32::MAX, 0.0]];
        assert!(strips(&[(&far, &strip(&[0, 1, 2]))], &front()).is_ok());
    }

    #[test]
    fn a_transparent_background_has_an_alpha_channel() {
        let png =
            strips(&[(&square(0.0, 0.0), &strip(&[0, 1, 2, 3]))], &front().with_background(None)).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&png)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        assert_eq!(reader.next_frame(&mut data).unwrap().color_type, png::ColorType::Rgba);
        assert_eq!((data[3], data[4 * (15 * 40 + 20) + 3]), (0, 255));
    }
}
