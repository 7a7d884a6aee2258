//! Computes the colour of a triangle at a point.

use super::camera::Camera;
use super::colours::PLAIN;
use super::options::Mode;
use super::scene::{Facet, Paint};
use super::surfaces::Surfaces;
use super::tones::Tones;
use super::vector::{Vector, dot, mix, unit};

/// The light direction in image axes: from the upper left, in front of the model.
const LIGHT: Vector = [-0.45, 0.65, 0.75];
/// The intensities of ambient and directional light.
const AMBIENT: f64 = 0.34;
const DIRECT: f64 = 0.70;

/// The parameters of shading.
pub(super) struct Shader<'a> {
    mode: Mode,
    surfaces: Option<&'a Surfaces>,
    /// Unit vectors to the light and to the eye.
    light: Vector,
    towards: Vector,
    /// Whether the depth of a corner is the reciprocal of its distance.
    pub(super) perspective: bool,
    tones: Tones,
}

impl<'a> Shader<'a> {
    /// Shades triangles that have their own colours, with light from the upper left.
    pub(super) fn plain(camera: &Camera) -> Self {
        let axes = camera.axes;
        let light = unit(axes.outward(LIGHT)).unwrap_or(axes.towards);
        let perspective = camera.perspective();
        let tones = Tones::new();
        Self { mode: Mode::Shaded, surfaces: None, light, towards: axes.towards, perspective, tones }
    }

    /// Shades the triangles of a textured model.
    pub(super) fn textured(camera: &Camera, surfaces: &'a Surfaces, mode: Mode) -> Self {
        Self { mode, surfaces: Some(surfaces), ..Self::plain(camera) }
    }

    /// Returns the colour of a triangle at barycentric coordinates, in a form that can be averaged:
    /// linear light, or the values of the mode.
    pub(super) fn colour(&self, facet: &Facet, shares: Vector, back: bool) -> [f32; 3] {
        let number = match facet.paint {
            Paint::Colour(colour) => return self.lit(facet, shares, back, colour),
            Paint::Corners(number) => number,
        };
        match (self.mode, self.surfaces) {
            (Mode::Shaded, _) | (_, None) => self.lit(facet, shares, back, PLAIN),
            (Mode::Normals, _) => {
                let normal = unit(mix(shares, facet.normals)).unwrap_or_default();
                normal.map(|x| (0.5 * x + 0.5) as f32)
            }
            (Mode::Uv, Some(surfaces)) => {
                // Mirrored outside 0 to 1, which avoids discontinuities.
                let [u, v] = surfaces.coordinates(number, shares).map(|x| {
                    let x = x.rem_euclid(2.0);
                    if x > 1.0 { 2.0 - x } else { x }
                });
                [u as f32, v as f32, 0.5]
            }
            (Mode::Textured, Some(surfaces)) => {
                let base = surfaces.base_colour(number, shares, &self.tones);
                let towards = unit(mix(shares, facet.normals)).map_or(0.0, |n| dot(n, self.towards).abs());
                let light = (AMBIENT + DIRECT * towards) as f32;
                base.map(|share| share * light)
            }
        }
    }

    /// Returns the lit colour of the visible side of a triangle.
    fn lit(&self, facet: &Facet, shares: Vector, back: bool, colour: [u8; 3]) -> [f32; 3] {
        let towards = unit(mix(shares, facet.normals)).map_or(0.0, |n| dot(n, self.light));
        let towards = if back { -towards } else { towards };
        let light = (AMBIENT + DIRECT * towards.max(0.0)) as f32;
        self.tones.linear(colour).map(|share| share * light)
    }

    /// Converts an sRGB colour to the form for averaging.
    pub(super) fn decoded(&self, colour: [u8; 3]) -> [f32; 3] {
        if self.mode.is_lit() { self.tones.linear(colour) } else { colour.map(|x| f32::from(x) / 255.0) }
    }

    /// Converts an average to the values of an image.
    #[allow(clippy::cast_sign_loss, reason = "clamped")]
    pub(super) fn encoded(&self, colour: [f32; 3]) -> [u8; 3] {
        if self.mode.is_lit() {
            colour.map(|light| self.tones.encoded(light))
        } else {
            colour.map(|x| (255.0 * x + 0.5).clamp(0.0, 255.0) as u8)
        }
    }
}
