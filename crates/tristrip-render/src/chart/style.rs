//! Colours, sizes and text styles shared by all elements of a chart.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The colours of Okabe and Ito, which people with colour-vision deficiencies can distinguish.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
/// The colour of axes and text.
pub(super) const INK: RGBColor = RGBColor(40, 40, 40);
/// The colour of background series and leader lines.
pub(super) const FAINT: RGBColor = RGBColor(158, 158, 158);
/// The colour of labels of background series.
pub(super) const FAINT_INK: RGBColor = RGBColor(112, 112, 112);
pub(super) const GRID: RGBColor = RGBColor(222, 222, 222);

pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
pub(super) type DrawResult<T = ()> = Result<T, DrawingAreaErrorKind<std::io::Error>>;

/// Returns the colour for a series index. Colours repeat after seven series.
pub(super) fn series_colour(index: usize) -> RGBColor {
    COLOURS[index % COLOURS.len()]
}

/// Returns a text style with a font height in pixels.
pub(super) fn text_style(pixels: u32, colour: RGBColor, h: HPos, v: VPos) -> TextStyle<'static> {
    font(pixels, FontStyle::Normal).color(&colour).pos(Pos::new(h, v))
}

/// Returns the style of a panel's title.
pub(super) fn title_style() -> TextStyle<'static> {
    font(15, FontStyle::Bold).color(&INK).pos(Pos::new(HPos::Left, VPos::Top))
}

fn font(pixels: u32, style: FontStyle) -> FontDesc<'static> {
    // The library expects the line height and divides it by 1.24 to get the font height.
    FontDesc::new(FontFamily::SansSerif, 1.24 * f64::from(pixels), style)
}

/// Estimates the width of a text in pixels. The estimate is an upper bound for most texts.
pub(super) fn text_width(text: &str, pixels: i32) -> i32 {
    (text.chars().take(1000).map(|_| 3 * pixels).sum::<i32>() + 4) / 5
}

/// Replaces characters that XML does not allow.
pub(super) fn printable(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { '\u{fffd}' } else { c })
        .collect()
}
