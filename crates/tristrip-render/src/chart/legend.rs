//! The legend of a panel: the symbol and name of each series, in rows above the plot.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::series::{Mark, Series, draw_symbol};
use super::style::{Area, DrawResult, INK, printable, text_style, text_width};

/// The height of a row in pixels.
const ROW_HEIGHT: i32 = 18;
/// The distance from the left of a symbol to its name.
const SYMBOL_WIDTH: i32 = 30;
/// The distance between two entries.
const GAP: i32 = 16;

/// Draws the legend from its top left corner, in rows of at most `width` pixels. Returns its
/// height.
pub(super) fn draw(
    area: &Area<'_>,
    series: &[Series],
    (left, top): (i32, i32),
    width: i32,
) -> DrawResult<i32> {
    let (mut x, mut y) = (left, top);
    for (index, series) in series.iter().enumerate() {
        let name = printable(&series.name);
        let needed = SYMBOL_WIDTH + text_width(&name, 12);
        if x > left && x + needed > left + width {
            (x, y) = (left, y + ROW_HEIGHT);
        }
        let (colour, middle) = (series.colour(index), y + ROW_HEIGHT / 2 - 2);
        match series.mark {
            Mark::Bars => {
                area.draw(&Rectangle::new([(x + 6, middle - 5), (x + 18, middle + 5)], colour.filled()))?;
            }
            mark => {
                if matches!(mark, Mark::Line | Mark::Steps) {
                    let line = vec![(x, middle), (x + SYMBOL_WIDTH - 6, middle)];
                    area.draw(&PathElement::new(line, colour.stroke_width(2)))?;
                }
                draw_symbol(area, (x + SYMBOL_WIDTH / 2 - 3, middle), index, colour)?;
            }
        }
        area.draw_text(&name, &text_style(12, INK, HPos::Left, VPos::Center), (x + SYMBOL_WIDTH, middle))?;
        x += needed + GAP;
    }
    Ok(y + ROW_HEIGHT - top)
}
