//! The picture of an analysis: misses against the size of the buffer, and how long the strips are.

use tristrip::strip::{Buffer, BufferUse, Replacement};

use super::stored::Lengths;
use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::failure::Failure;

/// What one file adds to the picture.
#[derive(Debug)]
pub(super) struct Curve {
    pub(super) file: String,
    pub(super) each: Vec<(Buffer, BufferUse)>,
    pub(super) lengths: Lengths,
}

/// Draws the curves of all files into one picture: two panels, or one where there are no strips.
pub(super) fn draw(curves: &[Curve], flushed: bool) -> Result<String, Failure> {
    let mut panels = vec![misses(curves, flushed)];
    if curves.iter().any(|curve| !curve.lengths.bins().is_empty()) {
        panels.push(lengths(curves));
    }
    svg(&panels, panels.len())
}

fn misses(curves: &[Curve], flushed: bool) -> Panel {
    let mut series = Vec::new();
    for curve in curves {
        for (replacement, label) in [(Replacement::Fifo, "FIFO"), (Replacement::Lru, "LRU")] {
            let mut points: Vec<(f64, f64)> = curve
                .each
                .iter()
                .filter(|(buffer, _)| buffer.replacement == replacement)
                .map(|(buffer, used)| (f64::from(buffer.places), used.acmr()))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            if !points.is_empty() {
                series.push(Series::new(&curve.name(label, curves), Mark::Line, points));
            }
        }
    }
    series.extend(least(curves));
    let title = match curves {
        [one] => format!("Vertices transformed: {}", one.file),
        _ => "Vertices transformed".into(),
    };
    let places =
        if flushed { "places of the buffer, flushed between strips" } else { "places of the buffer" };
    Panel::new(
        &title,
        Axis::new(places, Scale::Log2),
        Axis::new("misses a triangle (ACMR)", Scale::Linear { from_zero: true }),
        series,
    )
}

/// Gives the lines below which no buffer can be: each vertex in use is a miss once. One line serves files that are alike.
fn least(curves: &[Curve]) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    let mut drawn: Vec<Vec<(f64, f64)>> = Vec::new();
    for curve in curves {
        let sizes = || curve.each.iter().map(|(buffer, _)| f64::from(buffer.places));
        let (Some(low), Some(high)) = (sizes().reduce(f64::min), sizes().reduce(f64::max)) else { continue };
        let height =
            curve.each.first().map_or(0.0, |(_, used)| BufferUse { misses: used.vertices, ..*used }.acmr());
        let line = vec![(low, height), (high, height)];
        if low < high && !drawn.contains(&line) {
            series.push(Series::new(&curve.name("each vertex once", curves), Mark::Line, line.clone()));
            drawn.push(line);
        }
    }
    if let ([_], [line]) = (&series[..], &drawn[..]) {
        return vec![Series::new("each vertex once", Mark::Line, line.clone())];
    }
    series
}

fn lengths(curves: &[Curve]) -> Panel {
    let with_strips: Vec<&Curve> = curves.iter().filter(|curve| !curve.lengths.bins().is_empty()).collect();
    let longest = with_strips.iter().map(|curve| curve.lengths.bins()).max_by_key(|bins| bins.len());
    let names = longest.unwrap_or_default().iter().map(|bin| bin.from.to_string()).collect();
    let bars = with_strips.iter().map(|curve| {
        let heights: Vec<f64> = curve.lengths.bins().iter().map(|bin| bin.strips as f64).collect();
        Series::bars(&curve.file, &heights)
    });
    let title = match &with_strips[..] {
        [one] if curves.len() > 1 => format!("Lengths of strips: {}", one.file),
        _ => "Lengths of strips".into(),
    };
    Panel::new(
        &title,
        Axis::new("triangles of a strip, from this many to the next", Scale::Names(names)),
        Axis::new("strips", Scale::Linear { from_zero: true }),
        bars.collect(),
    )
}

impl Curve {
    /// Names a line, with the file where there are several.
    fn name(&self, what: &str, all: &[Self]) -> String {
        if all.len() == 1 { what.to_owned() } else { format!("{}, {what}", self.file) }
    }
}
