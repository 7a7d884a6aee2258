//! The picture of all methods: a panel a model, the optimal ones joined by steps and named, the others behind in grey.

use super::{LIST, Point};
use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::failure::Failure;

/// What the file's own order costs is drawn unless it makes an axis longer than so many times what the methods need.
const STRETCH: f64 = 2.0;

/// Points of one place that are all named; of more, the first ones, and how many others there are.
const NAMED: usize = 3;

/// Draws the points of each model, by name, one below the other.
pub(crate) fn draw(models: &[(String, &[Point])]) -> Result<String, Failure> {
    let panels: Vec<Panel> = models.iter().map(|(name, points)| panel(name, points)).collect();
    svg(&panels, 1)
}

fn panel(name: &str, points: &[Point]) -> Panel {
    let frame = Frame::of(points.iter().filter(|point| !point.as_found));
    let (shown, outside): (Vec<&Point>, Vec<&Point>) =
        points.iter().partition(|point| !point.as_found || frame.holds(point));
    let (mut optimal, others): (Vec<&Point>, Vec<&Point>) =
        shown.into_iter().partition(|point| point.optimal);
    optimal.sort_by_key(|point| (point.cost.indices, point.cost.misses));
    let series = vec![
        series("optimal: no other way has fewer of one and no more of the other", Mark::Steps, &optimal),
        series("others", Mark::Points, &others).faint(),
    ];
    let buffer = points.first().map_or("", |point| point.buffer.as_str());
    Panel::new(
        &format!("Indices against misses: {name}"),
        Axis::new("indices a triangle, with restarts", Scale::Linear { from_zero: false }),
        Axis::new(&format!("misses a triangle ({buffer})"), Scale::Linear { from_zero: false }),
        series,
    )
    .with_note(note(&outside))
    .with_every_label()
}

/// Makes a series in which points of one place share a label.
fn series(name: &str, mark: Mark, points: &[&Point]) -> Series {
    let label = |(number, point): (usize, &&Point)| {
        let same = |other: &&&Point| other.cost == point.cost;
        if points[..number].iter().any(|other| same(&other)) {
            return String::new();
        }
        let names: Vec<String> = points.iter().filter(same).map(|point| shown_name(point)).collect();
        let named = names[..names.len().min(NAMED)].join(", ");
        match names.len().saturating_sub(NAMED) {
            0 => named,
            more => format!("{named} and {more} more"),
        }
    };
    let labels = points.iter().enumerate().map(label).collect();
    Series::new(name, mark, points.iter().map(|point| place(point)).collect()).with_labels(labels)
}

fn place(point: &Point) -> (f64, f64) {
    (point.indices_restart_per_triangle, point.acmr)
}

fn shown_name(point: &Point) -> String {
    if point.label == LIST { "plain list".into() } else { point.label.clone() }
}

/// Says what stands outside of the picture.
fn note(outside: &[&Point]) -> String {
    let figures = |point: &&Point| {
        let (indices, acmr) = place(point);
        let optimal = if point.optimal { ", optimal" } else { "" };
        format!("{} ({indices:.3} indices, {acmr:.3} misses{optimal})", shown_name(point))
    };
    match outside {
        [] => String::new(),
        all => format!("Outside: {}", all.iter().map(figures).collect::<Vec<_>>().join(", ")),
    }
}

/// What the methods need of both axes.
struct Frame {
    low: (f64, f64),
    high: (f64, f64),
}

impl Frame {
    fn of<'a>(points: impl Iterator<Item = &'a Point>) -> Self {
        let none = Self { low: (f64::INFINITY, f64::INFINITY), high: (f64::NEG_INFINITY, f64::NEG_INFINITY) };
        points.map(place).fold(none, |frame, (x, y)| Self {
            low: (frame.low.0.min(x), frame.low.1.min(y)),
            high: (frame.high.0.max(x), frame.high.1.max(y)),
        })
    }

    /// Tells whether a point stretches no axis too far.
    fn holds(&self, point: &Point) -> bool {
        let fits = |low: f64, high: f64, at: f64| high.max(at) - low.min(at) <= STRETCH * (high - low);
        let (x, y) = place(point);
        fits(self.low.0, self.high.0, x) && fits(self.low.1, self.high.1, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::strip::{Buffer, BufferUse};

    fn point(label: &str, indices: usize, misses: usize, optimal: bool) -> Point {
        let used = BufferUse { misses, triangles: 100, vertices: 60 };
        let as_found = [LIST, "input"].contains(&label);
        Point { label: label.into(), optimal, as_found, ..Point::of(indices, used, Buffer::default()) }
    }

    fn drawn(points: &[Point]) -> String {
        draw(&[("a.ply".into(), points)]).unwrap()
    }

    #[test]
    fn points_of_one_place_share_a_label() {
        let two = [point("eta", 120, 90, true), point("best 5", 110, 95, true), point("sgi", 120, 90, true)];
        assert!(drawn(&two).contains("\neta, sgi\n"));
        let five: Vec<Point> = ["a", "b", "c", "d", "e"].map(|name| point(name, 200, 100, true)).to_vec();
        assert!(drawn(&five).contains("\na, b, c and 2 more\n"));
    }

    #[test]
    fn the_files_own_order_does_not_spoil_the_scale() {
        let methods = [point("best 5", 110, 95, true), point("eta", 140, 80, true)];
        let with = |input, list| drawn(&[&methods[..], &[input, list]].concat());
        let far = with(point("input", 270, 150, false), point(LIST, 300, 70, true));
        assert!(far.contains(
            "Outside: input (2.700 indices, 1.500 misses), plain list (3.000 indices, 0.700 misses, optimal)"
        ));
        let near = with(point("input", 150, 85, false), point(LIST, 300, 85, false));
        assert!(near.contains("\ninput\n") && near.contains("Outside: plain list (3.000"));
        assert!(drawn(&[]).contains("</svg>"));
    }
}
