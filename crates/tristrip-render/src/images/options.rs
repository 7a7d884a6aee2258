//! Rendering options: size, view direction and background.

use crate::error::Error;

/// Maximum width and height in pixels.
pub const MAX_SIZE: u32 = 8192;

/// Rendering options. The default is 1200 × 900 pixels on white, seen from the front, slightly
/// above and to the right.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct RenderOptions {
    /// The width in pixels, from 1 to [`MAX_SIZE`].
    pub width: u32,
    /// The height in pixels, from 1 to [`MAX_SIZE`].
    pub height: u32,
    /// The view direction.
    pub view: View,
    /// The sRGB background colour; `None` for a transparent background.
    pub background: Option<[u8; 3]>,
}

/// What the colours of an image show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// The base colour with its texture and vertex colours, lit from the eye.
    Textured,
    /// Interpolated normals: x, y and z from -1 to 1 as red, green and blue.
    Normals,
    /// Texture coordinates: u as red and v as green, mirrored outside 0 to 1.
    Uv,
    /// Grey, lit from the upper left.
    Shaded,
}

impl Mode {
    /// All modes.
    pub const ALL: [Self; 4] = [Self::Textured, Self::Normals, Self::Uv, Self::Shaded];

    /// Returns the name used in reports: `textured`, `normals`, `uv` or `shaded`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Textured => "textured",
            Self::Normals => "normals",
            Self::Uv => "uv",
            Self::Shaded => "shaded",
        }
    }

    /// Whether colours are light intensities rather than values.
    pub(super) fn is_lit(self) -> bool {
        matches!(self, Self::Textured | Self::Shaded)
    }
}

/// The view direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// The direction from the model to the eye, of any length.
    pub from: [f64; 3],
    /// The up direction of the image, of any length, not parallel to `from`.
    pub up: [f64; 3],
}

impl Default for View {
    fn default() -> Self {
        Self { from: [0.35, 0.25, 1.0], up: [0.0, 1.0, 0.0] }
    }
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { width: 1200, height: 900, view: View::default(), background: Some([255; 3]) }
    }
}

impl RenderOptions {
    /// Checks the size.
    pub(super) fn check(&self) -> Result<(), Error> {
        for size in [self.width, self.height] {
            if !(1..=MAX_SIZE).contains(&size) {
                let expected = format!("expected 1 to {MAX_SIZE} pixels");
                return Err(Error::Image(format!("size: found {size}, {expected}")));
            }
        }
        Ok(())
    }

    /// Sets the size in pixels.
    #[must_use]
    pub fn with_size(self, width: u32, height: u32) -> Self {
        Self { width, height, ..self }
    }

    /// Sets the view direction.
    #[must_use]
    pub fn with_view(self, view: View) -> Self {
        Self { view, ..self }
    }

    /// Sets the sRGB background colour; `None` for a transparent background.
    #[must_use]
    pub fn with_background(self, background: Option<[u8; 3]>) -> Self {
        Self { background, ..self }
    }
}
