//! The surface data of a model: texture coordinates and colours at triangle corners, materials, and
//! decoded textures.

use tristrip_io::gltf::{Appearance, Material, Wrap};

use super::texture::{MAX_PIXELS, Texture};
use super::tones::Tones;
use super::vector::{Vector, mix};
use crate::error::Error;

/// The surface data of a model's triangles.
#[derive(Debug, Default)]
pub(super) struct Surfaces {
    corners: Vec<Corners>,
    materials: Vec<Surface>,
    textures: Vec<Texture>,
}

/// The values at the corners of a triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Corners {
    pub(super) coordinates: [[f32; 2]; 3],
    /// Linear light.
    pub(super) colours: [[f32; 3]; 3],
    pub(super) material: u32,
}

/// A material with a decoded image.
#[derive(Debug, Clone, Copy)]
struct Surface {
    base_colour: [f32; 3],
    texture: Option<(usize, [Wrap; 2])>,
}

impl Surfaces {
    /// Decodes the images of a scene and collects the materials of its parts.
    pub(super) fn of(appearance: &Appearance) -> Result<Self, Error> {
        let mut budget = MAX_PIXELS;
        let decode = |image| Texture::decode(image, &mut budget);
        let textures = appearance.images.iter().map(decode).collect::<Result<_, Error>>()?;
        let surface = |material: &Material| {
            let [red, green, blue, _] = material.base_colour;
            let texture = material.texture.map(|texture| (texture.image, texture.wrap));
            Surface { base_colour: [red, green, blue], texture }
        };
        let materials = appearance.materials.iter().map(surface).collect();
        Ok(Self { corners: Vec::new(), materials, textures })
    }

    /// Adds a triangle and returns its index.
    pub(super) fn push(&mut self, corners: Corners) -> u32 {
        self.corners.push(corners);
        (self.corners.len() - 1) as u32
    }

    /// Returns the texture coordinates at a point of a triangle.
    pub(super) fn coordinates(&self, triangle: u32, shares: Vector) -> [f64; 2] {
        let corners = self.corners.get(triangle as usize);
        corners.map_or([0.0; 2], |corners| mix(shares, corners.coordinates.map(|at| at.map(f64::from))))
    }

    /// Returns the base colour at a point of a triangle, in linear light.
    pub(super) fn base_colour(&self, triangle: u32, shares: Vector, tones: &Tones) -> [f32; 3] {
        let Some(corners) = self.corners.get(triangle as usize) else { return [1.0; 3] };
        let Some(surface) = self.materials.get(corners.material as usize) else { return [1.0; 3] };
        let vertex = mix(shares, corners.colours.map(|colour| colour.map(f64::from)));
        let texel = surface.texture.and_then(|(texture, wrap)| {
            Some(self.textures.get(texture)?.sample(self.coordinates(triangle, shares), wrap, tones))
        });
        let texel = texel.unwrap_or([1.0; 3]);
        [0, 1, 2].map(|i| surface.base_colour[i] * vertex[i] as f32 * texel[i])
    }
}
