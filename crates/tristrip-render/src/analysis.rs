//! The chart of an analysis: misses against the size of the vertex cache, and a histogram of strip lengths.

use tristrip::vertex_cache::{Replacement, VertexCache, VertexCacheStatistics};

use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::error::Error;
use tristrip_pipeline::StripLengths;

/// The data of one file.
#[derive(Debug)]
pub struct Curve {
    /// The name of the file.
    pub file: String,
    /// Each vertex cache with its statistics.
    pub each: Vec<(VertexCache, VertexCacheStatistics)>,
    /// The histogram of strip lengths.
    pub lengths: StripLengths,
}

/// Draws the curves of all files in one chart: two panels, or one if there are no strips.
///
/// # Errors
/// The drawing library fails; no input is known that causes this.
///
/// ```
/// use tristrip_render::analysis::{Curve, draw};
/// let model = tristrip_io::read(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", tristrip_io::Format::Obj)?;
/// let analysis = tristrip_pipeline::analyze(&model, &Default::default());
/// let curve = Curve { file: "a.obj".into(), each: analysis.vertex_caches, lengths: analysis.lengths };
/// assert!(draw(&[curve], false)?.starts_with("<svg"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw(curves: &[Curve], flushed: bool) -> Result<String, Error> {
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
                .filter(|(cache, _)| cache.replacement == replacement)
                .map(|(cache, used)| (f64::from(cache.entries), used.acmr()))
                .collect();
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            if !points.is_empty() {
                series.push(Series::new(&curve.name(label, curves), Mark::Line, points));
            }
        }
    }
    series.extend(lower_bounds(curves));
    let title = match curves {
        [one] => format!("Vertices transformed: {}", one.file),
        _ => "Vertices transformed".into(),
    };
    let entries =
        if flushed { "vertex cache entries, flushed between strips" } else { "vertex cache entries" };
    Panel::new(
        &title,
        Axis::new(entries, Scale::Log2),
        Axis::new("misses per triangle (ACMR)", Scale::Linear { from_zero: true }),
        series,
    )
}

/// Returns the lower bounds of the misses: each used vertex is a miss once. Files with the same bound share a line.
fn lower_bounds(curves: &[Curve]) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    let mut drawn: Vec<Vec<(f64, f64)>> = Vec::new();
    for curve in curves {
        let sizes = || curve.each.iter().map(|(cache, _)| f64::from(cache.entries));
        let (Some(low), Some(high)) = (sizes().reduce(f64::min), sizes().reduce(f64::max)) else { continue };
        let height = curve
            .each
            .first()
            .map_or(0.0, |(_, used)| VertexCacheStatistics { misses: used.vertices, ..*used }.acmr());
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
        Axis::new("triangles per strip, up to the next label", Scale::Names(names)),
        Axis::new("strips", Scale::Linear { from_zero: true }),
        bars.collect(),
    )
}

impl Curve {
    /// Returns the name of a line, with the file if there are several.
    fn name(&self, what: &str, all: &[Self]) -> String {
        if all.len() == 1 { what.to_owned() } else { format!("{}, {what}", self.file) }
    }
}
