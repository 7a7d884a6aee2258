//! Images of meshes, strips and textured models as PNG files in memory, and image differences
//! between two models.
//!
//! ```text
//! positions, strips ─▶ scene: triangles, normals, paint ─▶ camera: pixels, depth ─▶ raster ─▶ PNG
//!         └▶ colours: neighbouring strips differ ──┐                                │
//! model ─▶ textured: placed parts ─▶ surfaces: materials, textures ─▶ shader: colour at a point
//!                └▶ sides: eight cameras around the first of two models ─▶ differences, holes
//! ```
//! # Algorithm
//! 1. A camera projects the vertices. For strips, the projection is parallel and scaled to fill the
//!    image. For textured models, it is perspective, fitted to the eight corners of the bounding
//!    box. The functions whose names end in `_seen` use the camera of a level-of-detail view
//!    instead; geometry behind it is clipped.
//! 2. A corner has the normal of the file, or the mean normal of the triangles at its position,
//!    unless the surface has a crease there.
//! 3. Each strip gets a palette colour that differs from the colours of its neighbours. A textured
//!    model shows its base colour, normals or texture coordinates, depending on the [`Mode`].
//! 4. Bands of rows are drawn in parallel with 4 × 4 samples per pixel. The nearest triangle of
//!    each sample is found first. The shader then computes its colour with perspective-correct
//!    interpolation and bilinear texture filtering.
//!
//! An image has the same bytes on every machine: only sums, products, quotients, square roots and
//! `libm` are used, and images are decoded without architecture-specific instructions. The crate
//! `euc` for software rendering is not used, because its published version is years old and does
//! not guarantee this.
//!
//! # Complexity
//! Linear time in triangles and samples, plus one test per triangle and band. Memory: 150 bytes per
//! triangle, about twice that while a part is added or with texture coordinates and colours, and 12
//! bytes per sample of the bands drawn at the same time.

mod attributes;
mod camera;
mod colours;
mod encoding;
mod options;
#[cfg(test)]
mod oracle;
mod painted;
mod pose;
mod raster;
mod scene;
mod shader;
mod sheet;
mod sides;
mod surfaces;
mod texture;
mod textured;
mod tones;
mod vector;

use tristrip::{Strips, lod};

use crate::error::Error;
use camera::Camera;
use encoding::encode;
pub use options::{MAX_SIZE, Mode, RenderOptions, View};
use painted::{coloured, pixels_seen, plain};
use scene::Facet;
use shader::Shader;
pub use sheet::{SheetImage, sheet};
pub use sides::{Differences, SIDES, compare, rows_of_sides};
pub use textured::TexturedModel;

/// Draws each strip in one colour. Strips that share an edge have different colours. A part
/// consists of its positions and its strips. Returns the bytes of a PNG file.
///
/// # Errors
/// A size is 0 or too large, the view has no direction, a coordinate is not finite, or a strip uses
/// a vertex without a position.
///
/// ```
/// use tristrip::Strips;
/// use tristrip_render::images::{RenderOptions, strips};
/// let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
/// let mut strip = Strips::default();
/// strip.push(&[0, 1, 2, 3]);
/// let png = strips(&[(&square, &strip)], &RenderOptions::default().with_size(64, 48))?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), tristrip_render::Error>(())
/// ```
pub fn strips(parts: &[(&[[f32; 3]], &Strips)], options: &RenderOptions) -> Result<Vec<u8>, Error> {
    options.check()?;
    fitted(coloured(parts)?, options)
}

/// Draws strips like [`strips`], from a perspective camera. Geometry behind the camera is clipped.
/// The camera defines the vertical field of view, and the options define the image size.
///
/// # Errors
/// A size is 0 or too large, a coordinate is not finite, or a strip uses a vertex without a
/// position.
///
/// ```
/// use tristrip::{Strips, lod::Camera};
/// use tristrip_render::images::{RenderOptions, strips_seen};
/// let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
/// let mut strip = Strips::default();
/// strip.push(&[0, 1, 2, 3]);
/// let camera = Camera::new([0.5, 0.5, 2.0], [0.5, 0.5, 0.0])?;
/// let options = RenderOptions::default().with_size(64, 48);
/// let png = strips_seen(&[(&square, &strip)], &camera, &options)?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), tristrip_render::Error>(())
/// ```
pub fn strips_seen(
    parts: &[(&[[f32; 3]], &Strips)],
    camera: &lod::Camera,
    options: &RenderOptions,
) -> Result<Vec<u8>, Error> {
    seen(&coloured(parts)?, camera, options)
}

/// Draws triangles, three indices each, in one colour. A part consists of its positions and its
/// triangles. Returns the bytes of a PNG file.
///
/// # Errors
/// A size is 0 or too large, the view has no direction, a coordinate is not finite, or a triangle
/// uses a vertex without a position.
///
/// ```
/// use tristrip_render::images::{RenderOptions, triangles};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let png = triangles(&[(&corners, &[0, 1, 2])], &RenderOptions::default().with_size(64, 48))?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), tristrip_render::Error>(())
/// ```
pub fn triangles(parts: &[(&[[f32; 3]], &[u32])], options: &RenderOptions) -> Result<Vec<u8>, Error> {
    options.check()?;
    fitted(plain(parts)?, options)
}

/// Draws triangles like [`triangles`], from a perspective camera. Geometry behind the camera is
/// clipped.
///
/// # Errors
/// A size is 0 or too large, a coordinate is not finite, or a triangle uses a vertex without a
/// position.
///
/// ```
/// use tristrip::lod::Camera;
/// use tristrip_render::images::{RenderOptions, triangles_seen};
/// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let camera = Camera::new([0.5, 0.5, 2.0], [0.5, 0.5, 0.0])?;
/// let options = RenderOptions::default().with_size(64, 48);
/// let png = triangles_seen(&[(&corners, &[0, 1, 2])], &camera, &options)?;
/// assert!(png.starts_with(b"\x89PNG"));
/// # Ok::<(), tristrip_render::Error>(())
/// ```
pub fn triangles_seen(
    parts: &[(&[[f32; 3]], &[u32])],
    camera: &lod::Camera,
    options: &RenderOptions,
) -> Result<Vec<u8>, Error> {
    seen(&plain(parts)?, camera, options)
}

/// Draws triangles from a camera and encodes the image.
fn seen(facets: &[Facet], camera: &lod::Camera, options: &RenderOptions) -> Result<Vec<u8>, Error> {
    encode(&pixels_seen(facets, camera, options)?, options)
}

/// Draws triangles as large as the image allows and encodes the image.
fn fitted(mut facets: Vec<Facet>, options: &RenderOptions) -> Result<Vec<u8>, Error> {
    let camera = Camera::fitted(&facets, options)?;
    for facet in &mut facets {
        *facet = camera.facet(facet)?;
    }
    encode(&raster::draw(&facets, &Shader::plain(&camera), options), options)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Decodes an image without transparency.
    fn decoded(png: &[u8]) -> (u32, Vec<[u8; 3]>) {
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
        let mut data = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut data).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        (info.width, data.as_chunks().0.to_vec())
    }

    /// Returns the corners of a square at a depth.
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

    /// A floor around the eye has its horizon in the middle of the image. Everything below is
    /// floor, and geometry behind the eye is not visible.
    #[test]
    fn what_is_behind_the_camera_is_cut_off() {
        let floor = [[-1e4, -1.0, -1e4], [1e4, -1.0, -1e4], [-1e4, -1.0, 1e4], [1e4, -1.0, 1e4]];
        let camera = lod::Camera::new([0.0; 3], [0.0, 0.0, -1.0]).unwrap();
        for whole in [strip(&[0, 1, 2, 3]), strip(&[2, 3, 0, 1]), strip(&[1, 3, 0, 2])] {
            let (width, pixels) = decoded(&strips_seen(&[(&floor, &whole)], &camera, &front()).unwrap());
            let (above, below) = pixels.split_at(15 * width as usize);
            assert!(above.iter().all(|&pixel| pixel == [255; 3]));
            assert!(below[width as usize..].iter().all(|&pixel| pixel != [255; 3]));
        }
        let above = floor.map(|[x, y, z]| [x, y + 5.0, z - 1e5]);
        let away = lod::Camera::new([0.0; 3], [0.0, 0.0, 1.0]).unwrap();
        let png = triangles_seen(&[(&above, &[0, 1, 2, 2, 1, 3])], &away, &front()).unwrap();
        assert!(decoded(&png).1.iter().all(|&pixel| pixel == [255; 3]));
    }

    /// A square of height 1 at the distance at which the image has height 2.
    #[test]
    fn a_camera_shows_lengths_in_perspective() {
        let corners = square(-0.5, 0.0).into_iter().map(|[x, y, z]| [x, y - 0.5, z]).collect::<Vec<_>>();
        let camera = lod::Camera::new([0.0, 0.0, 1.0], [0.0; 3]).unwrap().with_field_of_view(90.0).unwrap();
        let (_, pixels) =
            decoded(&strips_seen(&[(&corners, &strip(&[0, 1, 2, 3]))], &camera, &front()).unwrap());
        let covered = pixels.iter().filter(|&&pixel| pixel != [255; 3]).count();
        assert!((15 * 15..=16 * 16).contains(&covered), "a square of 15 pixels: {covered}");
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
