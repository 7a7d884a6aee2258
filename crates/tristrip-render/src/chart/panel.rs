//! Panels: one pair of axes with its series, legend and labels.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::{Axis, AxisSpan};
use super::labels::{Obstacles, PointLabel, place_labels};
use super::legend;
use super::series::{Mark, Series, draw_symbol, with_corners};
use super::style::{
    Area, DrawResult, FAINT, FAINT_INK, GRID, INK, printable, text_style, text_width, title_style,
};

/// The maximum number of symbols on a line.
const SYMBOLS_PER_LINE: usize = 12;

type Plot<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<AxisSpan, AxisSpan>>;

/// One pair of axes with its series.
#[derive(Debug, Clone)]
pub struct Panel {
    title: String,
    x: Axis,
    y: Axis,
    series: Vec<Series>,
    note: String,
    every_label: bool,
}

impl Panel {
    /// Creates a panel. With more than one series, it has a legend.
    pub fn new(title: &str, x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self { title: title.into(), x, y, series, note: String::new(), every_label: false }
    }

    /// Adds a line of text below the title.
    #[must_use]
    pub fn with_note(mut self, note: String) -> Self {
        self.note = note;
        self
    }

    /// Draws every label. Labels without free space next to their point are placed farther away,
    /// with a leader line. Labels never overlap symbols.
    #[must_use]
    pub fn with_every_label(mut self) -> Self {
        self.every_label = true;
        self
    }

    /// Draws the panel into an area of the root. Symbols and labels are drawn in root coordinates.
    pub(super) fn draw(&self, area: &Area<'_>, root: &Area<'_>) -> DrawResult {
        // 1. Axis ranges.
        let values = |take: fn(&(f64, f64)) -> f64| {
            self.series.iter().flat_map(move |series| series.points.iter().map(take))
        };
        let bars = self.series.iter().filter(|series| series.mark == Mark::Bars).count();
        let x = self.x.span(values(|p| p.0), bars > 0);
        let y = self.y.span(values(|p| p.1), false);

        // 2. Title and legend.
        let (width, _) = area.dim_in_pixel();
        area.draw_text(&printable(&self.title), &title_style(), (14, 12))?;
        let mut top = 38;
        if !self.note.is_empty() {
            let note_style = text_style(12, INK, HPos::Left, VPos::Top);
            area.draw_text(&printable(&self.note), &note_style, (14, top - 2))?;
            top += 20;
        }
        if self.series.len() > 1 {
            top += legend::draw(area, &self.series, (14, top), width.cast_signed() - 28)?;
        }

        // 3. Axes.
        let inner = area.clone().margin(top + 8, 6, 6, 22);
        let mut plot = ChartBuilder::on(&inner)
            .x_label_area_size(46)
            .y_label_area_size(30 + text_width(y.longest_label(), 12))
            .build_cartesian_2d(x.clone(), y.clone())?;
        plot.configure_mesh()
            .x_desc(printable(&self.x.title))
            .y_desc(printable(&self.y.title))
            .axis_desc_style(text_style(13, INK, HPos::Center, VPos::Top))
            .label_style(text_style(12, INK, HPos::Center, VPos::Top))
            .x_labels(x.tick_count())
            .y_labels(y.tick_count())
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(INK)
            .draw()?;

        // 4. Series in reverse order, so the first is on top. Symbols are drawn last, so no line
        //    hides them.
        let mut bar = bars;
        for (index, series) in self.series.iter().enumerate().rev() {
            if series.mark == Mark::Bars {
                bar -= 1;
            }
            self.draw_series(&mut plot, series, (index, bar, bars), &y)?;
        }
        for (index, series) in self.series.iter().enumerate().rev() {
            for (x, y) in self.marked(index, series) {
                draw_symbol(root, plot.backend_coord(&(x, y)), index, series.colour(index))?;
            }
        }
        self.draw_labels((root, &plot), &x, &y)
    }

    /// Iterates over the visible points of a series: index and axis coordinates.
    fn coordinates<'a>(&'a self, series: &'a Series) -> impl Iterator<Item = (usize, (f64, f64))> + 'a {
        series.points.iter().enumerate().filter_map(|(index, &(x, y))| {
            Some((index, (self.x.scale.coordinate(x)?, self.y.scale.coordinate(y)?)))
        })
    }

    /// Returns the points of a series that get a symbol; on a line, only some of them. The symbols
    /// of several lines alternate, so they are visible where one line hides another.
    fn marked(&self, index: usize, series: &Series) -> Vec<(f64, f64)> {
        let points: Vec<(f64, f64)> = self.coordinates(series).map(|(_, at)| at).collect();
        match series.mark {
            Mark::Bars => Vec::new(),
            Mark::Points | Mark::Steps => points,
            Mark::Line => {
                let lines = self.series.iter().filter(|series| series.mark == Mark::Line).count();
                let stride = points.len().div_ceil(SYMBOLS_PER_LINE).max(lines.min(points.len())).max(1);
                // The first symbols of the lines are spread over one stride.
                let first = (index * stride / lines.max(1)) % stride;
                points.into_iter().skip(first).step_by(stride).collect()
            }
        }
    }

    fn draw_series(
        &self,
        plot: &mut Plot<'_, '_>,
        series: &Series,
        (index, bar, bars): (usize, usize, usize),
        y: &AxisSpan,
    ) -> DrawResult {
        let colour = series.colour(index);
        let coordinates = || self.coordinates(series).map(|(_, at)| at);
        if series.mark == Mark::Bars {
            let width = 0.84 / bars as f64;
            let left = |x: f64| x - 0.42 + width * bar as f64;
            let bars = coordinates().map(|(x, h)| [(left(x), y.low), (left(x) + width, h)]);
            plot.draw_series(bars.map(|corners| Rectangle::new(corners, colour.filled())))?;
            return Ok(());
        }
        if series.mark == Mark::Line {
            plot.draw_series(LineSeries::new(coordinates(), colour.stroke_width(2)))?;
        }
        if series.mark == Mark::Steps {
            plot.draw_series(LineSeries::new(with_corners(coordinates()), colour.stroke_width(2)))?;
        }
        Ok(())
    }

    /// Draws labels next to their points or farther away, without overlapping each other or the
    /// border.
    fn draw_labels(
        &self,
        (root, plot): (&Area<'_>, &Plot<'_, '_>),
        x: &AxisSpan,
        y: &AxisSpan,
    ) -> DrawResult {
        let (low, high) = (plot.backend_coord(&(x.low, y.low)), plot.backend_coord(&(x.high, y.high)));
        let bounds = [low.0, high.1 - 6, high.0 + 18, low.1];
        let (mut labels, mut inks) = (Vec::new(), Vec::new());
        for series in &self.series {
            for (index, at) in self.coordinates(series) {
                let Some(text) = series.labels.get(index).map(|label| printable(label)) else { break };
                if !text.is_empty() {
                    let width = text_width(&text, 11);
                    labels.push(PointLabel { at: plot.backend_coord(&at), text, width });
                    inks.push(if series.faint { FAINT_INK } else { INK });
                }
            }
        }
        let obstacles = self.every_label.then(|| self.obstacles(plot));
        for ((label, ink), position) in labels.iter().zip(inks).zip(place_labels(&labels, bounds, obstacles))
        {
            let Some(position) = position else { continue };
            if let Some((from, to)) = position.leader {
                root.draw(&PathElement::new(vec![from, to], FAINT.stroke_width(1)))?;
            }
            let style = text_style(11, ink, HPos::Left, VPos::Center);
            root.draw_text(&label.text, &style, (position.rect[0], position.rect[1] + 6))?;
        }
        Ok(())
    }

    /// Collects all symbols and lines, which labels must avoid.
    fn obstacles(&self, plot: &Plot<'_, '_>) -> Obstacles {
        let mut obstacles = Obstacles::default();
        for series in self.series.iter().filter(|series| series.mark != Mark::Bars) {
            let coordinates = || self.coordinates(series).map(|(_, at)| at);
            coordinates().for_each(|at| obstacles.add_symbol(plot.backend_coord(&at)));
            match series.mark {
                Mark::Line => obstacles.add_line(coordinates().map(|at| plot.backend_coord(&at))),
                Mark::Steps => {
                    obstacles.add_line(with_corners(coordinates()).map(|at| plot.backend_coord(&at)));
                }
                Mark::Points | Mark::Bars => (),
            }
        }
        obstacles
    }
}
