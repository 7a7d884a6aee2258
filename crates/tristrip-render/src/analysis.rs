//! The chart of an analysis: cache misses by vertex cache size, and a histogram of strip lengths.

use tristrip::vertex_cache::{Replacement, VertexCacheStatistics};

use crate::chart::{Axis, Mark, Panel, Scale, Series, svg};
use crate::error::Error;
use tristrip_pipeline::analyze::{self, CacheMisses};

/// The data of one file.
#[derive(Debug)]
pub struct Curve {
    /// The name of the file.
    pub file: String,
    /// Its statistics for each vertex cache size.
    pub analysis: analyze::Outcome,
}

/// Draws a chart of all files with two panels, or one if there are no strips.
///
/// # Errors
/// The drawing library fails. No known input causes this.
///
/// ```
/// use tristrip_render::analysis::{Curve, draw};
/// let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let model = tristrip_io::read(obj, tristrip_io::Format::Obj)?;
/// let analysis = tristrip_pipeline::analyze::run(&model, &Default::default(), &())?;
/// let curve = Curve { file: "a.obj".into(), analysis };
/// assert!(draw(&[curve], false)?.starts_with("<svg"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw(curves: &[Curve], flushed: bool) -> Result<String, Error> {
    let mut panels = vec![misses(curves, flushed)];
    if curves.iter().any(|curve| !curve.analysis.lengths.is_empty()) {
        panels.push(lengths(curves));
    }
    svg(&panels, panels.len())
}

fn misses(curves: &[Curve], flushed: bool) -> Panel {
    let mut series = Vec::new();
    for curve in curves {
        for (replacement, label) in [(Replacement::Fifo, "FIFO"), (Replacement::Lru, "LRU")] {
            let caches = curve.analysis.vertex_caches.iter();
            let mut points: Vec<(f64, f64)> = caches
                .filter(|cache| cache.vertex_cache.replacement == replacement)
                .map(|cache| (entries(cache), curve.acmr(cache.misses)))
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

/// Returns the lower bounds of the misses: each used vertex misses at least once. Files with the
/// same bound share a line.
fn lower_bounds(curves: &[Curve]) -> Vec<Series> {
    let mut series: Vec<Series> = Vec::new();
    let mut drawn: Vec<Vec<(f64, f64)>> = Vec::new();
    for curve in curves {
        let sizes = || curve.analysis.vertex_caches.iter().map(entries);
        let (Some(low), Some(high)) = (sizes().reduce(f64::min), sizes().reduce(f64::max)) else { continue };
        let height = curve.acmr(curve.analysis.stored.vertices);
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
    let with_strips: Vec<&Curve> = curves.iter().filter(|curve| !curve.analysis.lengths.is_empty()).collect();
    let longest = with_strips.iter().map(|curve| &curve.analysis.lengths[..]).max_by_key(|bins| bins.len());
    let names = longest.unwrap_or_default().iter().map(|bin| bin.from.to_string()).collect();
    let bars = with_strips.iter().map(|curve| {
        let heights: Vec<f64> = curve.analysis.lengths.iter().map(|bin| bin.strips as f64).collect();
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

fn entries(cache: &CacheMisses) -> f64 {
    f64::from(cache.vertex_cache.entries)
}

impl Curve {
    /// Returns `misses` per triangle.
    fn acmr(&self, misses: usize) -> f64 {
        let stored = &self.analysis.stored;
        VertexCacheStatistics { misses, triangles: stored.triangles, vertices: stored.vertices }.acmr()
    }

    /// Returns the name of a line, including the file if there are several.
    fn name(&self, what: &str, all: &[Self]) -> String {
        if all.len() == 1 { what.to_owned() } else { format!("{}, {what}", self.file) }
    }
}
