//! The chart of all methods, with one panel per model. Optimal methods are connected by steps and
//! labelled; the others are grey.

use super::{LIST, ParetoPoint};
use crate::error::Error;
use tristrip_render::chart::{Axis, Mark, Panel, Scale, Series, svg};

/// The point of the file's own order is drawn unless it stretches an axis beyond the range of the
/// methods by more than this factor.
const MAX_STRETCH: f64 = 2.0;

/// The maximum number of names in the label of points at the same position. The rest is only
/// counted.
const MAX_NAMES: usize = 3;

/// Draws the points of each named model, one panel below the other.
///
/// # Errors
/// The drawing library fails; no input is known that causes this.
///
/// ```
/// use tristrip::{Effort, StripifyOptions};
/// use tristrip_io::{Format, read};
/// use tristrip_lab::pareto::{draw, measure};
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let prepared = tristrip_pipeline::PreparedModel::new(&model, false);
/// let (points, _) = measure(&prepared, &StripifyOptions::default(), Effort::new(0), &())?;
/// assert!(draw(&[("square".into(), &points)])?.starts_with("<svg"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw(models: &[(String, &[ParetoPoint])]) -> Result<String, Error> {
    let panels: Vec<Panel> = models.iter().map(|(name, points)| panel(name, points)).collect();
    Ok(svg(&panels, 1)?)
}

fn panel(name: &str, points: &[ParetoPoint]) -> Panel {
    let ranges = AxisRanges::of(points.iter().filter(|point| !point.is_file_order));
    let (shown, outside): (Vec<&ParetoPoint>, Vec<&ParetoPoint>) =
        points.iter().partition(|point| !point.is_file_order || ranges.hold(point));
    let (mut optimal, others): (Vec<&ParetoPoint>, Vec<&ParetoPoint>) =
        shown.into_iter().partition(|point| point.optimal);
    optimal.sort_by_key(|point| (point.cost.indices, point.cost.misses));
    let series = vec![
        series("optimal: no other method has fewer of one and no more of the other", Mark::Steps, &optimal),
        series("others", Mark::Points, &others).faint(),
    ];
    let cache = points.first().map_or("", |point| point.vertex_cache.as_str());
    Panel::new(
        &format!("Indices against misses: {name}"),
        Axis::new("indices per triangle, with restarts", Scale::Linear { from_zero: false }),
        Axis::new(&format!("misses per triangle ({cache})"), Scale::Linear { from_zero: false }),
        series,
    )
    .with_note(note(&outside))
    .with_every_label()
}

/// Builds a series in which points at the same position share a label.
fn series(name: &str, mark: Mark, points: &[&ParetoPoint]) -> Series {
    let label = |(number, point): (usize, &&ParetoPoint)| {
        let same = |other: &&&ParetoPoint| other.cost == point.cost;
        if points[..number].iter().any(|other| same(&other)) {
            return String::new();
        }
        let names: Vec<String> = points.iter().filter(same).map(|point| shown_name(point)).collect();
        let named = names[..names.len().min(MAX_NAMES)].join(", ");
        match names.len().saturating_sub(MAX_NAMES) {
            0 => named,
            more => format!("{named} and {more} more"),
        }
    };
    let labels = points.iter().enumerate().map(label).collect();
    Series::new(name, mark, points.iter().map(|point| position(point)).collect()).with_labels(labels)
}

fn position(point: &ParetoPoint) -> (f64, f64) {
    (point.indices_restart_per_triangle, point.acmr)
}

fn shown_name(point: &ParetoPoint) -> String {
    if point.label == LIST { "plain list".into() } else { point.label.clone() }
}

/// Returns a note on the points outside of the axes.
fn note(outside: &[&ParetoPoint]) -> String {
    let figures = |point: &&ParetoPoint| {
        let (indices, acmr) = position(point);
        let optimal = if point.optimal { ", optimal" } else { "" };
        format!("{} ({indices:.3} indices, {acmr:.3} misses{optimal})", shown_name(point))
    };
    match outside {
        [] => String::new(),
        all => format!("Outside: {}", all.iter().map(figures).collect::<Vec<_>>().join(", ")),
    }
}

/// The ranges of both axes that cover the methods.
struct AxisRanges {
    low: (f64, f64),
    high: (f64, f64),
}

impl AxisRanges {
    fn of<'a>(points: impl Iterator<Item = &'a ParetoPoint>) -> Self {
        let none = Self { low: (f64::INFINITY, f64::INFINITY), high: (f64::NEG_INFINITY, f64::NEG_INFINITY) };
        points.map(position).fold(none, |ranges, (x, y)| Self {
            low: (ranges.low.0.min(x), ranges.low.1.min(y)),
            high: (ranges.high.0.max(x), ranges.high.1.max(y)),
        })
    }

    /// Returns whether a point fits both axes without stretching them too far.
    fn hold(&self, point: &ParetoPoint) -> bool {
        let fits = |low: f64, high: f64, at: f64| high.max(at) - low.min(at) <= MAX_STRETCH * (high - low);
        let (x, y) = position(point);
        fits(self.low.0, self.high.0, x) && fits(self.low.1, self.high.1, y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::vertex_cache::{VertexCache, VertexCacheStatistics};

    fn point(label: &str, indices: usize, misses: usize, optimal: bool) -> ParetoPoint {
        let used = VertexCacheStatistics { misses, triangles: 100, vertices: 60 };
        let is_file_order = [LIST, "input"].contains(&label);
        ParetoPoint {
            label: label.into(),
            optimal,
            is_file_order,
            ..ParetoPoint::of(indices, used, VertexCache::default())
        }
    }

    fn drawn(points: &[ParetoPoint]) -> String {
        draw(&[("a.ply".into(), points)]).unwrap()
    }

    #[test]
    fn points_at_the_same_position_share_a_label() {
        let two = [point("eta", 120, 90, true), point("best 5", 110, 95, true), point("sgi", 120, 90, true)];
        assert!(drawn(&two).contains("\neta, sgi\n"));
        let five: Vec<ParetoPoint> =
            ["a", "b", "c", "d", "e"].map(|name| point(name, 200, 100, true)).to_vec();
        assert!(drawn(&five).contains("\na, b, c and 2 more\n"));
    }

    #[test]
    fn the_files_own_order_does_not_dominate_the_scale() {
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
