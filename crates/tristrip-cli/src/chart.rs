//! Charts as SVG text: panels of lines, points and bars, for pages and reports.
//!
//! ```text
//!  title
//!  ━●━ fifo  ━■━ lru          legend, where there is more than one series
//!  │ ●━━━━●━━━━●              grid, ticks and their figures by the axes' scales
//!  │ ■━━━━■━━━━■
//!  └────────────
//!     places
//! ```
//! No font is read: text is placed by its anchor, and where room must be kept its width is estimated. So the same figures give the
//! same bytes on every machine. The background is white, so that a picture is readable on a dark page too, and the colours are told apart
//! by eyes of every kind; marks differ in shape as well.

mod axis;
mod labels;
mod legend;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use crate::failure::Failure;
use axis::Span;
pub(crate) use axis::{Axis, Scale};
use labels::{Label, Obstacles, place};

/// The width of a picture in pixels: that of a page's text.
const WIDTH: u32 = 900;
/// The height of a panel in pixels.
const PANEL_HEIGHT: u32 = 340;
/// More points than these of a line get no marks of their own.
const MARKED_POINTS: usize = 24;
/// Okabe and Ito's colours, told apart with and without red and green.
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
const INK: RGBColor = RGBColor(40, 40, 40);
/// Of what stands back behind the rest: marks, and texts beside them.
const FAINT: RGBColor = RGBColor(158, 158, 158);
const FAINT_INK: RGBColor = RGBColor(112, 112, 112);
const GRID: RGBColor = RGBColor(222, 222, 222);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plot<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Span, Span>>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

/// Left, top, right and bottom in pixels.
type Frame = [i32; 4];

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mark {
    /// A line through the points in their order; each has a mark where they are few.
    Line,
    /// A line that goes level from each point to below the next one's place, then up or down to it; each point has a mark.
    Steps,
    /// Marks alone.
    Points,
    /// Bars from the axis up; those of several series stand side by side.
    Bars,
}

/// Points of one name, colour and mark.
#[derive(Debug, Clone)]
pub(crate) struct Series {
    name: String,
    mark: Mark,
    points: Vec<(f64, f64)>,
    labels: Vec<String>,
    faint: bool,
}

impl Series {
    /// Makes a series; points that are not finite, or not positive on a logarithmic axis, are not drawn.
    pub(crate) fn new(name: &str, mark: Mark, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), mark, points, labels: Vec::new(), faint: false }
    }

    /// Writes a label beside each point that has one, and the room.
    #[must_use]
    pub(crate) fn with_labels(mut self, labels: Vec<String>) -> Self {
        self.labels = labels;
        self
    }

    /// Lets the series stand back behind the others, in grey.
    #[must_use]
    pub(crate) fn faint(mut self) -> Self {
        self.faint = true;
        self
    }

    fn colour(&self, number: usize) -> RGBColor {
        if self.faint { FAINT } else { COLOURS[number % COLOURS.len()] }
    }

    /// Makes bars at 0, 1, 2 … for an axis of names.
    pub(crate) fn bars(name: &str, heights: &[f64]) -> Self {
        Self::new(name, Mark::Bars, heights.iter().enumerate().map(|(i, &h)| (i as f64, h)).collect())
    }
}

/// One pair of axes with its series.
#[derive(Debug, Clone)]
pub(crate) struct Panel {
    title: String,
    x: Axis,
    y: Axis,
    series: Vec<Series>,
    note: String,
    every_label: bool,
}

impl Panel {
    /// Makes a panel; a legend is drawn where it has more than one series.
    pub(crate) fn new(title: &str, x: Axis, y: Axis, series: Vec<Series>) -> Self {
        Self { title: title.into(), x, y, series, note: String::new(), every_label: false }
    }

    /// Writes a line below the title.
    #[must_use]
    pub(crate) fn with_note(mut self, note: String) -> Self {
        self.note = note;
        self
    }

    /// Writes labels also where there is no room beside their points: further off, at the end of a thin line. They cover no marks.
    #[must_use]
    pub(crate) fn with_every_label(mut self) -> Self {
        self.every_label = true;
        self
    }
}

/// Draws panels, so many in a row, as one SVG document.
///
/// # Errors
/// The drawing library refuses; no figures are known that make it.
pub(crate) fn svg(panels: &[Panel], columns: usize) -> Result<String, Failure> {
    let columns = columns.clamp(1, panels.len().max(1));
    let rows = panels.len().div_ceil(columns).max(1);
    let mut text = String::new();
    draw_all(panels, (rows, columns), &mut text)
        .map_err(|error| Failure::Output(format!("chart: {error}")))?;
    Ok(text)
}

fn draw_all(panels: &[Panel], (rows, columns): (usize, usize), text: &mut String) -> Drawn {
    let root = SVGBackend::with_string(text, (WIDTH, PANEL_HEIGHT * rows as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
        panel.draw(area, &root)?;
    }
    root.present()
}

impl Panel {
    /// Draws into an area of the root, where points of the plot have their places.
    fn draw(&self, area: &Area<'_>, root: &Area<'_>) -> Drawn {
        // 1. What the axes span.
        let values = |take: fn(&(f64, f64)) -> f64| {
            self.series.iter().flat_map(move |series| series.points.iter().map(take))
        };
        let bars = self.series.iter().filter(|series| series.mark == Mark::Bars).count();
        let x = self.x.span(values(|p| p.0), bars > 0);
        let y = self.y.span(values(|p| p.1), false);

        // 2. Title and legend.
        let (width, _) = area.dim_in_pixel();
        area.draw_text(&printable(&self.title), &heading(), (14, 12))?;
        let mut top = 38;
        if !self.note.is_empty() {
            area.draw_text(&printable(&self.note), &style(12, INK, HPos::Left, VPos::Top), (14, top - 2))?;
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
        let axis_titles = style(13, INK, HPos::Center, VPos::Top);
        plot.configure_mesh()
            .x_desc(printable(&self.x.title))
            .y_desc(printable(&self.y.title))
            .axis_desc_style(axis_titles)
            .label_style(style(12, INK, HPos::Center, VPos::Top))
            .x_labels(x.tick_count())
            .y_labels(y.tick_count())
            .bold_line_style(GRID)
            .light_line_style(TRANSPARENT)
            .axis_style(INK)
            .draw()?;

        // 4. Series, the first on top.
        let mut bar = bars;
        for (number, series) in self.series.iter().enumerate().rev() {
            if series.mark == Mark::Bars {
                bar -= 1;
            }
            self.draw_series((root, &mut plot), series, (number, bar, bars), &y)?;
        }
        self.draw_labels((root, &plot), &x, &y)
    }

    /// Gives the points of a series in the units of the axes' spans, with their numbers.
    fn places<'a>(&'a self, series: &'a Series) -> impl Iterator<Item = (usize, (f64, f64))> + 'a {
        series
            .points
            .iter()
            .enumerate()
            .filter_map(|(number, &(x, y))| Some((number, (self.x.scale.place(x)?, self.y.scale.place(y)?))))
    }

    fn draw_series(
        &self,
        (root, plot): (&Area<'_>, &mut Plot<'_, '_>),
        series: &Series,
        (number, bar, bars): (usize, usize, usize),
        y: &Span,
    ) -> Drawn {
        let colour = series.colour(number);
        let places = || self.places(series).map(|(_, place)| place);
        if series.mark == Mark::Bars {
            let width = 0.84 / bars as f64;
            let left = |x: f64| x - 0.42 + width * bar as f64;
            let bars = places().map(|(x, h)| [(left(x), y.low), (left(x) + width, h)]);
            plot.draw_series(bars.map(|corners| Rectangle::new(corners, colour.filled())))?;
            return Ok(());
        }
        if series.mark == Mark::Line {
            plot.draw_series(LineSeries::new(places(), colour.stroke_width(2)))?;
        }
        if series.mark == Mark::Steps {
            plot.draw_series(LineSeries::new(steps(places()), colour.stroke_width(2)))?;
        }
        if matches!(series.mark, Mark::Points | Mark::Steps) || series.points.len() <= MARKED_POINTS {
            for (x, y) in places() {
                let at = plot.backend_coord(&(x, y));
                mark(root, at, number, colour)?;
            }
        }
        Ok(())
    }

    /// Writes labels beside their points, or further off, where they cover neither a label nor the border.
    fn draw_labels(&self, (root, plot): (&Area<'_>, &Plot<'_, '_>), x: &Span, y: &Span) -> Drawn {
        let (low, high) = (plot.backend_coord(&(x.low, y.low)), plot.backend_coord(&(x.high, y.high)));
        let bounds = [low.0, high.1 - 6, high.0 + 18, low.1];
        let (mut labels, mut inks) = (Vec::new(), Vec::new());
        for series in &self.series {
            for (number, place) in self.places(series) {
                let Some(text) = series.labels.get(number).map(|label| printable(label)) else { break };
                if !text.is_empty() {
                    let width = text_width(&text, 11);
                    labels.push(Label { at: plot.backend_coord(&place), text, width });
                    inks.push(if series.faint { FAINT_INK } else { INK });
                }
            }
        }
        let obstacles = self.every_label.then(|| self.obstacles(plot));
        for ((label, ink), spot) in labels.iter().zip(inks).zip(place(&labels, bounds, obstacles)) {
            let Some(spot) = spot else { continue };
            if let Some((from, to)) = spot.leader {
                root.draw(&PathElement::new(vec![from, to], FAINT.stroke_width(1)))?;
            }
            let style = style(11, ink, HPos::Left, VPos::Center);
            root.draw_text(&label.text, &style, (spot.frame[0], spot.frame[1] + 6))?;
        }
        Ok(())
    }

    /// Gives what labels keep away from: all marks, and lines.
    fn obstacles(&self, plot: &Plot<'_, '_>) -> Obstacles {
        let mut obstacles = Obstacles::default();
        for series in self.series.iter().filter(|series| series.mark != Mark::Bars) {
            let places = || self.places(series).map(|(_, place)| place);
            places().for_each(|place| obstacles.mark(plot.backend_coord(&place)));
            match series.mark {
                Mark::Line => obstacles.line(places().map(|place| plot.backend_coord(&place))),
                Mark::Steps => obstacles.line(steps(places()).map(|place| plot.backend_coord(&place))),
                Mark::Points | Mark::Bars => (),
            }
        }
        obstacles
    }
}

/// Puts a corner between each two points: at the place of the later, as high as the earlier.
fn steps(points: impl Iterator<Item = (f64, f64)>) -> impl Iterator<Item = (f64, f64)> {
    let mut height = None;
    points.flat_map(move |(x, y)| {
        let corner = height.replace(y).map(|before| (x, before));
        corner.into_iter().chain([(x, y)])
    })
}

/// Draws the mark of a series: a disc, a square, a triangle or a cross by its number.
fn mark(area: &Area<'_>, at: (i32, i32), number: usize, colour: RGBColor) -> Drawn {
    match number % 4 {
        0 => area.draw(&Circle::new(at, 4, colour.filled())),
        1 => area.draw(&Rectangle::new([(at.0 - 3, at.1 - 3), (at.0 + 4, at.1 + 4)], colour.filled())),
        2 => area.draw(&TriangleMarker::new(at, 5, colour.filled())),
        _ => area.draw(&Cross::new(at, 4, colour.stroke_width(2))),
    }
}

/// Makes the style of a text of some pixels' height.
fn style(pixels: u32, colour: RGBColor, h: HPos, v: VPos) -> TextStyle<'static> {
    // The library takes the height of a line and divides by this for the letters'.
    let font = FontDesc::new(FontFamily::SansSerif, 1.24 * f64::from(pixels), FontStyle::Normal);
    font.color(&colour).pos(Pos::new(h, v))
}

/// Makes the style of a panel's title.
fn heading() -> TextStyle<'static> {
    let font = FontDesc::new(FontFamily::SansSerif, 1.24 * 15.0, FontStyle::Bold);
    font.color(&INK).pos(Pos::new(HPos::Left, VPos::Top))
}

/// Estimates the width of a text in pixels, rather too wide than too narrow.
fn text_width(text: &str, pixels: i32) -> i32 {
    (text.chars().take(1000).map(|_| 3 * pixels).sum::<i32>() + 4) / 5
}

/// Replaces what XML cannot hold.
fn printable(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { '\u{fffd}' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear() -> Scale {
        Scale::Linear { from_zero: true }
    }

    /// Every kind of mark, scale and label, with texts and figures that want care.
    fn sample() -> Vec<Panel> {
        let curve =
            |k: f64| (1..=6).map(|i| (f64::from(1 << i), k * (0.5 + 1.0 / f64::from(1 << i)))).collect();
        let fifo = Series::new("FIFO, kept from strip to strip", Mark::Line, curve(1.1));
        let lru = Series::new("LRU", Mark::Line, curve(1.0));
        let models: Vec<(f64, f64)> =
            (0..12).map(|i| (1000.0 * f64::from(1 << i), 1.1 + 0.01 * f64::from(i % 4))).collect();
        let names = (0..12).map(|i| format!("model {i}")).collect();
        let bins = ["1", "2–3", "4–7", "8–15", "16–31"].map(String::from).to_vec();
        let heights = [230.0, 120.0, 64.0, 12.0, 1.0];
        vec![
            Panel::new(
                "Misses a triangle",
                Axis::new("places", Scale::Log2),
                Axis::new("ACMR", linear()),
                vec![fifo, lru],
            ),
            Panel::new(
                "Cost <by> \u{1} size & \"kind\"",
                Axis::new("triangles", Scale::Log10),
                Axis::new("vertices a triangle", Scale::Linear { from_zero: false }),
                vec![
                    Series::new("sgi", Mark::Points, models.clone()).with_labels(names),
                    Series::new("stripe", Mark::Points, models.iter().map(|p| (p.0, p.1 - 0.05)).collect())
                        .faint(),
                    Series::new("best", Mark::Steps, models.iter().map(|p| (p.0, p.1 - 0.08)).collect()),
                    Series::new("fewest", Mark::Points, models.iter().map(|p| (p.0, p.1 + 0.08)).collect()),
                ],
            ),
            Panel::new(
                "Strip lengths",
                Axis::new("triangles", Scale::Names(bins)),
                Axis::new("strips", linear()),
                vec![Series::bars("one", &heights), Series::bars("other", &heights.map(|h| 0.7 * h))],
            ),
            Panel::new(
                "Nothing",
                Axis::new("x", Scale::Log10),
                Axis::new("y", linear()),
                vec![Series::new(
                    "none",
                    Mark::Line,
                    vec![(f64::NAN, 1.0), (0.0, 2.0), (1.0, f64::INFINITY)],
                )],
            ),
        ]
    }

    #[test]
    fn a_picture_is_whole_and_the_same_every_time() {
        let text = svg(&sample(), 2).unwrap();
        assert_eq!(text, svg(&sample(), 2).unwrap());
        assert!(text.starts_with("<svg width=\"900\" height=\"680\"") && text.trim_end().ends_with("</svg>"));
        assert!(text.contains("Cost &lt;by&gt; \u{fffd} size &amp; &quot;kind&quot;"), "texts are escaped");
        assert!(
            ["places", "ACMR", "2–3", "100k", "FIFO, kept from strip to strip"]
                .iter()
                .all(|t| text.contains(t))
        );
    }

    #[test]
    fn steps_go_level_and_then_down() {
        let points = [(1.0, 9.0), (2.0, 5.0), (4.0, 4.0)];
        let corners: Vec<_> = steps(points.into_iter()).collect();
        assert_eq!(corners, [(1.0, 9.0), (2.0, 9.0), (2.0, 5.0), (4.0, 5.0), (4.0, 4.0)]);
    }

    #[test]
    fn a_crowd_of_points_has_all_its_labels() {
        let points: Vec<(f64, f64)> =
            (0..14).map(|i| (1.0 + 0.01 * f64::from(i % 5), 1.0 + 0.005 * f64::from(i))).collect();
        let names: Vec<String> = (0..14).map(|i| format!("a method {i}")).collect();
        let far = Series::new("far", Mark::Points, vec![(1.5, 1.4)]);
        let crowd = Series::new("crowd", Mark::Points, points).with_labels(names.clone());
        let axis = |title| Axis::new(title, Scale::Linear { from_zero: false });
        let panel = Panel::new("Crowd", axis("x"), axis("y"), vec![crowd, far]).with_note("below".into());
        let written = |panel| {
            let text = svg(&[panel], 1).unwrap();
            assert!(text.contains("below"));
            // The library writes a text between line breaks.
            names.iter().filter(|name| text.contains(&format!("\n{name}\n"))).count()
        };
        assert!(written(panel.clone()) < 14);
        assert_eq!(written(panel.with_every_label()), 14);
    }

    #[test]
    fn a_picture_of_nothing_is_still_a_picture() {
        assert!(svg(&[], 3).unwrap().contains("height=\"340\""));
        let axis = || Axis::new("", Scale::Names(Vec::new()));
        assert!(svg(&[Panel::new("", axis(), axis(), Vec::new())], 0).is_ok());
    }
}
