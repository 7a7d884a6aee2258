//! Data series: named points, and the mark by which they are drawn.

use plotters::prelude::*;

use super::style::{Area, DrawResult, FAINT, series_colour};

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A line through the points in their order; each point has a symbol if there are few.
    Line,
    /// A step function: horizontal from each point to the x of the next, then vertical; each point has a symbol.
    Steps,
    /// Symbols only.
    Points,
    /// Bars from the axis; bars of several series stand side by side.
    Bars,
}

/// Points with one name, colour and mark.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(super) name: String,
    pub(super) mark: Mark,
    pub(super) points: Vec<(f64, f64)>,
    pub(super) labels: Vec<String>,
    pub(super) faint: bool,
}

impl Series {
    /// Creates a series. Points that are not finite, or not positive on a logarithmic axis, are not drawn.
    pub(crate) fn new(name: &str, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), mark, points, labels: Vec::new(), faint: false }
    }

    /// Creates bars at 0, 1, 2 … for an axis of names.
    pub(crate) fn bars(name: &str, heights: &[f64]) -> Self {
        Self::new(name, Mark::Bars, heights.iter().enumerate().map(|(i, &h)| (i as f64, h)).collect())
    }

    /// Adds a label per point. Empty labels, and labels without free space, are not drawn.
    #[must_use]
    pub(crate) fn with_labels(mut self, labels: Vec<String>) -> Self {
        self.labels = labels;
        self
    }

    /// Draws the series in grey, as background.
    #[must_use]
    pub(crate) fn faint(mut self) -> Self {
        self.faint = true;
        self
    }

    /// Returns the colour of this series, given its index in the panel.
    pub(super) fn colour(&self, index: usize) -> RGBColor {
        if self.faint { FAINT } else { series_colour(index) }
    }
}

/// Draws the symbol of a series: a disc, a square, a triangle or a cross, by the index of the series.
pub(super) fn draw_symbol(area: &Area<'_>, at: (i32, i32), index: usize, colour: RGBColor) -> DrawResult {
    match index % 4 {
        0 => area.draw(&Circle::new(at, 4, colour.filled())),
        1 => area.draw(&Rectangle::new([(at.0 - 3, at.1 - 3), (at.0 + 4, at.1 + 4)], colour.filled())),
        2 => area.draw(&TriangleMarker::new(at, 5, colour.filled())),
        _ => area.draw(&Cross::new(at, 4, colour.stroke_width(2))),
    }
}

/// Inserts a corner between each two points: the x of the second, the y of the first.
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
