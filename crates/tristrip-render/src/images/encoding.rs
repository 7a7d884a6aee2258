//! Encodes pixels as PNG files.

use super::options::RenderOptions;
use crate::error::Error;

/// The levels per channel of the colour cube, and the grey levels, of an indexed file.
const LEVELS: u8 = 6;
const GREYS: u8 = 40;
/// Maximum channel difference of a pixel that counts as grey.
const GREY: u8 = 24;

/// Encodes pixels as a PNG file.
pub(super) fn encode(pixels: &[[u8; 4]], options: &RenderOptions) -> Result<Vec<u8>, Error> {
    let (colour, data): (_, Vec<u8>) = match options.background {
        Some(_) => (png::ColorType::Rgb, pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect()),
        None => (png::ColorType::Rgba, pixels.as_flattened().to_vec()),
    };
    file(options, colour, &data, |_| ())
}

/// Returns a file with eight bits per sample. `set` configures the encoder further.
fn file(
    options: &RenderOptions,
    colour: png::ColorType,
    data: &[u8],
    set: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>),
) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, options.width, options.height);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_color(colour);
    set(&mut encoder);
    let picture = |error: png::EncodingError| Error::Image(error.to_string());
    let mut writer = encoder.write_header().map_err(picture)?;
    writer.write_image_data(data).map_err(picture)?;
    writer.finish().map_err(picture)?;
    Ok(bytes)
}

/// Encodes opaque pixels as a PNG file with a palette of 256 colours, a quarter of the size: a cube
/// of six levels per channel, and 40 greys.
pub(super) fn encode_few(pixels: &[[u8; 4]], options: &RenderOptions) -> Result<Vec<u8>, Error> {
    let data: Vec<u8> = pixels.iter().map(|&[r, g, b, _]| index([r, g, b])).collect();
    file(options, png::ColorType::Indexed, &data, |encoder| {
        encoder.set_palette(palette());
        encoder.set_compression(png::Compression::High);
        // Differences of palette indices are meaningless.
        encoder.set_filter(png::Filter::NoFilter);
    })
}

/// Returns the colours in index order: the greys, then the cube.
fn palette() -> Vec<u8> {
    let value = |level: u8, levels: u8| (u32::from(level) * 255 / u32::from(levels - 1)) as u8;
    let greys = (0..GREYS).flat_map(|level| [value(level, GREYS); 3]);
    let cube = (0..LEVELS).flat_map(|r| (0..LEVELS).flat_map(move |g| (0..LEVELS).map(move |b| [r, g, b])));
    greys.chain(cube.flat_map(|colour| colour.map(|level| value(level, LEVELS)))).collect()
}

/// Returns the index of the nearest colour.
fn index([r, g, b]: [u8; 3]) -> u8 {
    let level = |value: u8, levels: u8| ((u32::from(value) * u32::from(levels - 1) + 127) / 255) as u8;
    if r.max(g).max(b) - r.min(g).min(b) <= GREY {
        level(g, GREYS)
    } else {
        let [r, g, b] = [r, g, b].map(|value| level(value, LEVELS));
        GREYS + (r * LEVELS + g) * LEVELS + b
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_the_palette_are_their_own_nearest() {
        let palette = palette();
        let (colours, rest) = palette.as_chunks::<3>();
        assert!(colours.len() == 256 && rest.is_empty());
        for (number, &colour) in colours.iter().enumerate() {
            let nearest = colours[usize::from(index(colour))];
            // Greys of the cube map to the grey levels, one of which is within half a step.
            let difference = (0..3).map(|k| nearest[k].abs_diff(colour[k])).max().unwrap();
            assert!(difference <= if number < 40 { 0 } else { 4 }, "{colour:?}, {nearest:?}");
        }
        assert_eq!([[0; 3], [255; 3]].map(|colour| colours[usize::from(index(colour))]), [[0; 3], [255; 3]]);
    }
}
