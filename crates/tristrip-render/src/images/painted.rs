//! Coloured triangles, and their pixels from a camera.

use tristrip::{Strips, lod};

use super::camera::Camera;
use super::colours;
use super::options::RenderOptions;
use super::raster;
use super::scene::{self, Facet};
use super::shader::Shader;
use crate::error::Error;

/// Returns the triangles of strips in one colour per strip.
pub(super) fn coloured(parts: &[(&[[f32; 3]], &Strips)]) -> Result<Vec<Facet>, Error> {
    let mut facets = Vec::new();
    for (positions, strips) in parts {
        let colours = colours::of_strips(strips);
        let strips = strips.iter().zip(colours);
        let triangles = strips.flat_map(|(strip, colour)| {
            tristrip::strip_triangles(strip).map(move |triangle| (triangle, colour))
        });
        scene::add_part(&mut facets, positions, triangles)?;
    }
    Ok(facets)
}

/// Returns triangles in one colour.
pub(super) fn plain(parts: &[(&[[f32; 3]], &[u32])]) -> Result<Vec<Facet>, Error> {
    let mut facets = Vec::new();
    for (positions, corners) in parts {
        let (triangles, _) = corners.as_chunks();
        let triangles = triangles.iter().map(|&triangle| (triangle, colours::PLAIN));
        scene::add_part(&mut facets, positions, triangles)?;
    }
    Ok(facets)
}

/// Draws triangles from a camera.
pub(super) fn pixels_seen(
    facets: &[Facet],
    camera: &lod::Camera,
    options: &RenderOptions,
) -> Result<Vec<[u8; 4]>, Error> {
    let camera = Camera::of_view(camera, options)?;
    let mut seen = Vec::with_capacity(facets.len());
    for facet in facets {
        camera.clip(facet, &mut seen)?;
    }
    Ok(raster::draw(&seen, &Shader::plain(&camera), options))
}
