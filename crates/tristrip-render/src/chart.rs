//! SVG charts: panels of lines, points and bars for pages and reports.
//!
//! ```text
//!  title
//!  ━●━ fifo  ━■━ lru          legend, if there is more than one series
//!  │ ●━━━━●━━━━●              grid, ticks and tick labels from the axes' scales
//!  │ ■━━━━■━━━━■
//!  └────────────
//!     entries
//! ```
//! The same data produces the same bytes on every machine: no font is loaded, text is positioned by
//! its anchor, text widths are estimated where space must be reserved, and logarithms come from
//! `libm`. The background is white, so the chart is readable on a dark page. Series differ in
//! colour and in the shape of their symbols, so overlapping series can still be distinguished.

mod axis;
mod labels;
mod legend;
mod panel;
mod series;
mod style;

use plotters::prelude::*;

use crate::error::Error;
pub use axis::{Axis, Scale};
pub use panel::Panel;
pub use series::{Mark, Series};
use style::DrawResult;

/// The width of a chart in pixels: the text width of a page.
const WIDTH: u32 = 900;
/// The height of a panel in pixels.
const PANEL_HEIGHT: u32 = 340;

/// Draws panels in rows of `columns` as one SVG document.
///
/// # Errors
/// The drawing library fails. No known input causes this.
pub fn svg(panels: &[Panel], columns: usize) -> Result<String, Error> {
    let columns = columns.clamp(1, panels.len().max(1));
    let rows = panels.len().div_ceil(columns).max(1);
    let mut text = String::new();
    draw_all(panels, (rows, columns), &mut text).map_err(|error| Error::Chart(error.to_string()))?;
    Ok(text)
}

fn draw_all(panels: &[Panel], (rows, columns): (usize, usize), text: &mut String) -> DrawResult {
    let root = SVGBackend::with_string(text, (WIDTH, PANEL_HEIGHT * rows as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, panel) in root.split_evenly((rows, columns)).iter().zip(panels) {
        panel.draw(area, &root)?;
    }
    root.present()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear() -> Scale {
        Scale::Linear { from_zero: true }
    }

    /// Returns panels with every mark, scale and label, with text that needs escaping and numbers
    /// out of range.
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
                "Misses per triangle",
                Axis::new("entries", Scale::Log2),
                Axis::new("ACMR", linear()),
                vec![fifo, lru],
            ),
            Panel::new(
                "Cost <by> \u{1} size & \"kind\"",
                Axis::new("triangles", Scale::Log10),
                Axis::new("vertices per triangle", Scale::Linear { from_zero: false }),
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
    fn a_chart_is_complete_and_deterministic() {
        let text = svg(&sample(), 2).unwrap();
        assert_eq!(text, svg(&sample(), 2).unwrap());
        assert!(text.starts_with("<svg width=\"900\" height=\"680\"") && text.trim_end().ends_with("</svg>"));
        assert!(text.contains("Cost &lt;by&gt; \u{fffd} size &amp; &quot;kind&quot;"), "texts are escaped");
        assert!(
            ["entries", "ACMR", "2–3", "100k", "FIFO, kept from strip to strip"]
                .iter()
                .all(|t| text.contains(t))
        );
    }

    #[test]
    fn every_label_of_a_dense_cluster_is_drawn_on_request() {
        let points: Vec<(f64, f64)> =
            (0..14).map(|i| (1.0 + 0.01 * f64::from(i % 5), 1.0 + 0.005 * f64::from(i))).collect();
        let names: Vec<String> = (0..14).map(|i| format!("a method {i}")).collect();
        let far = Series::new("far", Mark::Points, vec![(1.5, 1.4)]);
        let cluster = Series::new("cluster", Mark::Points, points).with_labels(names.clone());
        let axis = |title| Axis::new(title, Scale::Linear { from_zero: false });
        let panel = Panel::new("Cluster", axis("x"), axis("y"), vec![cluster, far]).with_note("below".into());
        let label_count = |panel| {
            let text = svg(&[panel], 1).unwrap();
            assert!(text.contains("below"));
            // The library writes line breaks around each text.
            names.iter().filter(|name| text.contains(&format!("\n{name}\n"))).count()
        };
        assert!(label_count(panel.clone()) < 14);
        assert_eq!(label_count(panel.with_every_label()), 14);
    }

    /// Returns the names of the SVG elements in a colour, except text.
    fn symbols(text: &str, colour: &str) -> Vec<String> {
        let drawn = text.lines().filter(|line| line.contains(colour) && !line.contains("<text"));
        drawn.map(|line| line.split_whitespace().next().unwrap_or_default().to_owned()).collect()
    }

    #[test]
    fn lines_have_the_symbols_of_their_legend_and_hidden_lines_show_theirs() {
        let curve: Vec<(f64, f64)> = (0..=100).map(|i| (f64::from(i), f64::from(i % 7))).collect();
        let series = ["FIFO", "LRU"].map(|name| Series::new(name, Mark::Line, curve.clone())).to_vec();
        let axis = |title| Axis::new(title, linear());
        let text = svg(&[Panel::new("The same", axis("x"), axis("y"), series)], 1).unwrap();
        // Discs of the first series and squares of the second: one in the legend, the others on the
        // line.
        let (fifo, lru) = (symbols(&text, "#0072B2"), symbols(&text, "#D55E00"));
        assert!((10..=14).contains(&fifo.iter().filter(|shape| *shape == "<circle").count()), "{fifo:?}");
        assert!((10..=14).contains(&lru.iter().filter(|shape| *shape == "<rect").count()), "{lru:?}");
        // No symbol covers another one.
        let at = |shape: &str, name: &str| -> Vec<String> {
            let lines = text.lines().filter(|line| line.starts_with(shape) && line.contains("opacity"));
            let value = |line: &str| {
                line.split(&format!("{name}=\""))
                    .nth(1)
                    .and_then(|rest| rest.split('"').next().map(str::to_owned))
            };
            lines.filter_map(value).collect()
        };
        let discs = at("<circle", "cx");
        let squares: Vec<String> =
            at("<rect", "x").iter().filter_map(|x| Some((x.parse::<i32>().ok()? + 3).to_string())).collect();
        assert!(discs.len() > 9 && discs[1..].iter().all(|x| !squares.contains(x)), "{discs:?} {squares:?}");
    }

    #[test]
    fn eight_series_have_eight_symbols() {
        let points = |i: i32| vec![(f64::from(i), 1.0), (f64::from(i), 2.0)];
        let axis = |title| Axis::new(title, linear());
        let shapes: Vec<String> = (0..series::SYMBOLS)
            .map(|index| {
                // The preceding series have no points, so all symbols belong to one series.
                let empty = |n: usize| Series::new(&n.to_string(), Mark::Bars, Vec::new()).faint();
                let mut all: Vec<Series> = (0..index).map(empty).collect();
                all.push(Series::new("one", Mark::Points, points(1)).faint());
                let text = svg(&[Panel::new("", axis("x"), axis("y"), all)], 1).unwrap();
                let drawn =
                    text.lines().filter(|line| line.contains("#9E9E9E") && !line.starts_with("<text"));
                drawn.map(|line| line.chars().filter(|c| !c.is_ascii_digit()).collect::<String>()).collect()
            })
            .collect();
        let different: std::collections::BTreeSet<&String> = shapes.iter().collect();
        assert_eq!(different.len(), series::SYMBOLS, "{shapes:?}");
    }

    #[test]
    fn a_chart_without_data_is_valid() {
        assert!(svg(&[], 3).unwrap().contains("height=\"340\""));
        let axis = || Axis::new("", Scale::Names(Vec::new()));
        assert!(svg(&[Panel::new("", axis(), axis(), Vec::new())], 0).is_ok());
    }
}
