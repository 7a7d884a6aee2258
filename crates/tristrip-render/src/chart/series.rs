//! Data series: named points and their mark.

use plotters::prelude::*;

use super::style::{Area, DrawResult, FAINT, series_colour};

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line through the points in order; some points have a symbol.
    Line,
    /// A step function: horizontal from each point to the x of the next, then vertical. Each point
    /// has a symbol.
    Steps,
    /// Symbols only.
    Points,
    /// Bars from the axis. Bars of several series are drawn side by side.
    Bars,
}

/// Points with a common name, colour and mark.
#[derive(Debug, Clone)]
pub struct Series {
    pub(super) name: String,
    pub(super) mark: Mark,
    pub(super) points: Vec<(f64, f64)>,
    pub(super) labels: Vec<String>,
    pub(super) faint: bool,
}

impl Series {
    /// Creates a series. Points that are not finite, or not positive on a logarithmic axis, are not
    /// drawn.
    pub fn new(name: &str, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), mark, points, labels: Vec::new(), faint: false }
    }

    /// Creates bars at 0, 1, 2, … for an axis with names.
    pub fn bars(name: &str, heights: &[f64]) -> Self {
        Self::new(name, Mark::Bars, heights.iter().enumerate().map(|(i, &h)| (i as f64, h)).collect())
    }

    /// Adds a label per point. Empty labels and labels without free space are not drawn.
    #[must_use]
    pub fn with_labels(mut self, labels: Vec<String>) -> Self {
        self.labels = labels;
        self
    }

    /// Draws the series in grey, in the background.
    #[must_use]
    pub fn faint(mut self) -> Self {
        self.faint = true;
        self
    }

    /// Returns the colour of this series for its index in the panel.
    pub(super) fn colour(&self, index: usize) -> RGBColor {
        if self.faint { FAINT } else { series_colour(index) }
    }
}

/// The number of different symbols. Charts with more series repeat them.
pub(super) const SYMBOLS: usize = 8;

/// Draws the symbol of a series by its index: disc, square, triangle, cross, diamond, ring,
/// inverted triangle, plus.
pub(super) fn draw_symbol(area: &Area<'_>, (x, y): (i32, i32), index: usize, colour: RGBColor) -> DrawResult {
    let polygon = |corners: &[(i32, i32)]| {
        Polygon::new(corners.iter().map(|(dx, dy)| (x + dx, y + dy)).collect::<Vec<_>>(), colour.filled())
    };
    let bar =
        |dx: i32, dy: i32| PathElement::new(vec![(x - dx, y - dy), (x + dx, y + dy)], colour.stroke_width(2));
    match index % SYMBOLS {
        0 => area.draw(&Circle::new((x, y), 4, colour.filled())),
        1 => area.draw(&Rectangle::new([(x - 3, y - 3), (x + 4, y + 4)], colour.filled())),
        2 => area.draw(&TriangleMarker::new((x, y), 5, colour.filled())),
        3 => area.draw(&Cross::new((x, y), 4, colour.stroke_width(2))),
        4 => area.draw(&polygon(&[(0, -5), (5, 0), (0, 5), (-5, 0)])),
        5 => {
            area.draw(&Circle::new((x, y), 4, WHITE.filled()))?;
            area.draw(&Circle::new((x, y), 4, colour.stroke_width(2)))
        }
        6 => area.draw(&polygon(&[(-4, -3), (4, -3), (0, 5)])),
        _ => {
            area.draw(&bar(5, 0))?;
            area.draw(&bar(0, 5))
        }
    }
}

/// Inserts a corner between consecutive points, with the x of the second and the y of the first.
pub(super) fn with_corners(points: impl Iterator<Item = (f64, f64)>) -> impl Iterator<Item = (f64, f64)> {
    let mut previous = None;
    points.flat_map(move |(x, y)| {
        let corner = previous.replace(y).map(|before| (x, before));
        corner.into_iter().chain([(x, y)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_horizontal_then_vertical() {
        let points = [(1.0, 9.0), (2.0, 5.0), (4.0, 4.0)];
        let corners: Vec<_> = with_corners(points.into_iter()).collect();
        assert_eq!(corners, [(1.0, 9.0), (2.0, 9.0), (2.0, 5.0), (4.0, 5.0), (4.0, 4.0)]);
    }
}
