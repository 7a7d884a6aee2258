//! Pixels as PNG files.

use super::options::RenderOptions;
use crate::error::Error;

/// Encodes pixels as a PNG file.
pub(super) fn encode(pixels: &[[u8; 4]], options: &RenderOptions) -> Result<Vec<u8>, Error> {
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
