//! The legend of a panel: each series' mark and name, in rows above the plot.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::{Area, INK, Mark, Series, mark, printable, style, text_width};

/// The height of a row in pixels.
const ROW: i32 = 18;
/// The width of a mark with its distance to the name.
const SAMPLE: i32 = 30;
/// The distance between two entries.
const GAP: i32 = 16;

/// Draws the legend from a place on, in rows of some pixels' width; gives its height.
pub(super) fn draw(
    area: &Area<'_>,
    series: &[Series],
    (left, top): (i32, i32),
    width: i32,
) -> Result<i32, DrawingAreaErrorKind<std::io::Error>> {
    let (mut x, mut y) = (left, top);
    for (number, series) in series.iter().enumerate() {
        let name = printable(&series.name);
        let needed = SAMPLE + text_width(&name, 12);
        if x > left && x + needed > left + width {
            (x, y) = (left, y + ROW);
        }
        let (colour, middle) = (series.colour(number), y + ROW / 2 - 2);
        match series.mark {
            Mark::Bars => {
                area.draw(&Rectangle::new([(x + 6, middle - 5), (x + 18, middle + 5)], colour.filled()))?;
            }
            kind => {
                if matches!(kind, Mark::Line | Mark::Steps) {
                    let line = vec![(x, middle), (x + SAMPLE - 6, middle)];
                    area.draw(&PathElement::new(line, colour.stroke_width(2)))?;
                }
                mark(area, (x + SAMPLE / 2 - 3, middle), number, colour)?;
            }
        }
        area.draw_text(&name, &style(12, INK, HPos::Left, VPos::Center), (x + SAMPLE, middle))?;
        x += needed + GAP;
    }
    Ok(y + ROW - top)
}
