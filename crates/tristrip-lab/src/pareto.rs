//! Compares all methods on a model by two conflicting metrics, indices and misses.
//!
//! ```text
//!  misses per   │ ●───┐ best          a method is optimal if no other method is better in
//!  triangle     │   ○ └───● cache     one metric and at least as good in the other; a line
//!               └───────────────      connects the optimal methods
//!               indices per triangle
//! ```
//! Each result is proven before it becomes a point.

mod chart;

use rayon::prelude::*;
use serde::Serialize;
use tristrip::Effort;
use tristrip::Metrics;
use tristrip::stripify::{Objective, TunnelOptions};
use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
use tristrip::{Method, StripifyOptions, Strips};
use tristrip_pipeline::text::counted;
use tristrip_pipeline::{
    Error as PipelineError, MethodDescription, Observer, PreparedModel, PreparedPart, SearchStop, rounded,
};

use crate::error::Error;
pub use chart::draw;
use tristrip_render::text::table;

/// The efforts of `best` and `cache`: their default, and a longer search.
const EFFORTS: [u8; 2] = [2, 5];

/// The label of the plain triangle list.
const LIST: &str = "list";

/// Receives which method is measured, in addition to the events of the pipeline.
pub trait ParetoObserver: Observer {
    /// Receives the label of the method that starts.
    fn method(&self, _label: &str) {}
}

/// Ignores all events.
impl ParetoObserver for () {}

/// The cost of one method on a model; the keys are those of the JSON report.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ParetoPoint {
    /// The name of the method in the chart.
    pub label: String,
    /// The name of the method.
    pub method: String,
    /// The objective of `cache`; `None` for other methods.
    pub objective: Option<String>,
    /// The effort of a search; `None` for methods that do not search.
    pub effort: Option<u8>,
    /// The simulated vertex cache.
    pub vertex_cache: String,
    /// Indices with restarts per triangle.
    pub indices_restart_per_triangle: f64,
    /// Misses per triangle.
    pub acmr: f64,
    /// Whether no other method is better in one metric and at least as good in the other.
    pub optimal: bool,
    /// Why the search was stopped early; `None` if it was not.
    pub stopped: Option<SearchStop>,
    /// Whether the point is the triangle list in the order of the file, without a search for
    /// strips.
    #[serde(skip)]
    is_file_order: bool,
    #[serde(skip)]
    cost: ParetoCost,
}

/// Indices with restarts, and misses, of the whole model. Costs are compared without rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct ParetoCost {
    indices: usize,
    misses: usize,
}

impl ParetoCost {
    /// Returns whether this cost is lower in one metric and not higher in the other.
    fn dominates(self, other: Self) -> bool {
        self.indices <= other.indices && self.misses <= other.misses && self != other
    }
}

/// A method with its options and its name in the chart.
#[derive(Debug, Clone)]
struct Candidate {
    label: String,
    options: StripifyOptions,
}

/// Measures all methods, including the method of the options, and the plain list. Notes name the
/// searches that were stopped early. `effort` applies to all methods that search; `None` uses their
/// defaults.
///
/// # Errors
/// A result is not proven, or the observer cancelled.
///
/// ```
/// use tristrip::{Effort, StripifyOptions};
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::PreparedModel;
/// let model = read(b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n", Format::Obj)?;
/// let prepared = PreparedModel::new(&model, false);
/// let options = StripifyOptions::default();
/// let (points, _) = tristrip_lab::pareto::measure(&prepared, &options, Effort::new(0), &())?;
/// assert!(points.iter().any(|point| point.label == "sgi" && point.optimal));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(
    model: &PreparedModel<'_>,
    options: &StripifyOptions,
    effort: Option<Effort>,
    observer: &dyn ParetoObserver,
) -> Result<(Vec<ParetoPoint>, Vec<String>), Error> {
    let mut points = Vec::new();
    for candidate in candidates(options, effort) {
        if observer.is_cancelled() {
            return Err(Error::Interrupted("pareto: not finished"));
        }
        observer.method(&candidate.label);
        let point = candidate.measure(model, observer);
        let label = candidate.label;
        points.push(point.map_err(|source| Error::Method { label, source })?);
    }
    points.push(list(model.parts(), options.vertex_cache));
    let costs: Vec<ParetoCost> = points.iter().map(|point| point.cost).collect();
    for point in &mut points {
        point.optimal = !costs.iter().any(|cost| cost.dominates(point.cost));
    }
    let stopped: Vec<&str> =
        points.iter().filter(|point| point.stopped.is_some()).map(|point| point.label.as_str()).collect();
    let notes = (!stopped.is_empty())
        .then(|| format!("chart: these searches were stopped early: {}", stopped.join(", ")));
    Ok((points, notes.into_iter().collect()))
}

/// Returns the methods of the chart, with the seed, welding and vertex cache of the options. The
/// method of the options is appended unless it is already included.
fn candidates(options: &StripifyOptions, effort: Option<Effort>) -> Vec<Candidate> {
    let base = StripifyOptions::default()
        .with_weld(options.weld)
        .with_seed(options.seed)
        .with_vertex_cache(options.vertex_cache);
    let plain = |label: &str, method| Candidate { label: label.into(), options: base.with_method(method) };
    let mut candidates = vec![
        plain("input", Method::Input),
        plain("sequential", Method::Sequential),
        plain("sgi", Method::SGI),
        plain("stripe", Method::STRIPE),
        plain("quad-rows", Method::QUAD_ROWS),
        plain("guided-tunnels", Method::GuidedTunnels(TunnelOptions::default())),
    ];
    let efforts: Vec<Effort> = match effort {
        Some(effort) => vec![effort],
        None => EFFORTS.into_iter().filter_map(Effort::new).collect(),
    };
    let search = |options: StripifyOptions| {
        let report = MethodDescription::of(&options);
        let words = [Some(report.method()), report.objective()].into_iter().flatten();
        let label =
            format!("{} {}", words.collect::<Vec<_>>().join(" "), options.effort_or_default().level());
        Candidate { label, options }
    };
    let fewest = base.with_method(Method::Fewest);
    candidates.push(search(effort.map_or(fewest, |effort| fewest.with_effort(effort))));
    candidates.extend(efforts.iter().map(|&e| search(base.with_method(Method::Best).with_effort(e))));
    for objective in [Objective::Indices, Objective::Balanced, Objective::Misses] {
        let cache = base.with_method(Method::Cache).with_objective(objective);
        candidates.extend(efforts.iter().map(|&e| search(cache.with_effort(e))));
    }
    let report = MethodDescription::of(options);
    if candidates.iter().all(|other| MethodDescription::of(&other.options) != report) {
        candidates.push(Candidate { label: report.label(), options: *options });
    }
    candidates
}

impl Candidate {
    /// Builds strips, proves them, and measures them.
    fn measure(
        &self,
        model: &PreparedModel<'_>,
        observer: &dyn ParetoObserver,
    ) -> Result<ParetoPoint, PipelineError> {
        let watch = observer.search(&self.options);
        let strips = model.find_strips(&self.options, &*watch)?;
        model.prove(&strips)?;
        let cache = self.options.vertex_cache;
        let (metrics, used) = figures(&strips, cache);
        let report = MethodDescription::of(&self.options);
        Ok(ParetoPoint {
            label: self.label.clone(),
            method: report.method().into(),
            objective: report.objective().map(Into::into),
            effort: report.effort(),
            stopped: watch.stopped(),
            is_file_order: self.options.method == Method::Input,
            ..ParetoPoint::of(metrics.indices_restart, used, cache)
        })
    }
}

impl ParetoPoint {
    fn of(indices: usize, used: VertexCacheStatistics, cache: VertexCache) -> Self {
        Self {
            label: String::new(),
            method: String::new(),
            objective: None,
            effort: None,
            vertex_cache: cache.to_string(),
            indices_restart_per_triangle: rounded(indices as f64 / used.triangles.max(1) as f64),
            acmr: rounded(used.acmr()),
            optimal: false,
            stopped: None,
            is_file_order: false,
            cost: ParetoCost { indices, misses: used.misses },
        }
    }
}

/// Sums the metrics of strips over the parts. Each part starts with an empty vertex cache.
fn figures(strips: &[Strips], cache: VertexCache) -> (Metrics, VertexCacheStatistics) {
    let measured = strips
        .par_iter()
        .map(|strips| (Metrics::of(strips), VertexCacheStatistics::of(strips, cache, FlushPolicy::Keep)));
    let measured: Vec<(Metrics, VertexCacheStatistics)> = measured.collect();
    (measured.iter().map(|m| m.0).sum(), measured.iter().map(|m| m.1).sum())
}

/// Measures the triangle list in the order of the file. Polygons count as fans, and degenerate
/// faces are skipped.
fn list(parts: &[PreparedPart<'_>], cache: VertexCache) -> ParetoPoint {
    let measured = parts
        .par_iter()
        .map(|part| VertexCacheStatistics::of_list(part.surface.faces().fans().as_chunks().0, cache));
    let used: VertexCacheStatistics = measured.collect::<Vec<_>>().into_iter().sum();
    let (label, method) = (LIST.into(), LIST.into());
    ParetoPoint { label, method, is_file_order: true, ..ParetoPoint::of(3 * used.triangles, used, cache) }
}

/// Returns a line with the number of methods.
pub fn line(points: &[ParetoPoint]) -> String {
    let optimal = points.iter().filter(|point| point.optimal).count();
    format!("{} compared, each proven; {optimal} optimal", counted(points.len(), "method"))
}

/// Returns the points as a table, sorted by indices.
pub fn as_text(points: &[ParetoPoint]) -> String {
    let mut sorted: Vec<&ParetoPoint> = points.iter().collect();
    sorted.sort_by_key(|point| (point.cost.indices, point.cost.misses));
    let cache = points.first().map_or("", |point| point.vertex_cache.as_str());
    let head =
        ["  method".into(), "indices per triangle".into(), format!("ACMR {cache}"), String::new()].to_vec();
    let row = |point: &ParetoPoint| {
        vec![
            format!("  {}", point.label),
            format!("{:.3}", point.indices_restart_per_triangle),
            format!("{:.3}", point.acmr),
            if point.optimal { "optimal".into() } else { String::new() },
        ]
    };
    let rows: Vec<_> = std::iter::once(head).chain(sorted.into_iter().map(row)).collect();
    format!("\n{}", table(&rows, 1..3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn labels(options: &StripifyOptions, effort: Option<Effort>) -> Vec<String> {
        candidates(options, effort).into_iter().map(|candidate| candidate.label).collect()
    }

    #[test]
    fn every_method_appears_once_under_a_distinct_name() {
        let default = labels(&StripifyOptions::default(), None);
        assert_eq!(
            default.join(", "),
            "input, sequential, sgi, stripe, quad-rows, guided-tunnels, fewest 5, best 2, best 5, cache indices 2, cache indices 5, \
             cache balanced 2, cache balanced 5, cache misses 2, cache misses 5"
        );
        assert_eq!(default.iter().collect::<HashSet<_>>().len(), default.len());
        let effort = Effort::new(1);
        let short = labels(&StripifyOptions::default().with_effort(Effort::new(1).unwrap()), effort);
        assert_eq!(
            short[6..].join(", "),
            "fewest 1, best 1, cache indices 1, cache balanced 1, cache misses 1"
        );
    }

    #[test]
    fn the_requested_method_is_included() {
        let with = |method| labels(&StripifyOptions::default().with_method(method), None);
        assert_eq!(with(Method::Best).len(), 15);
        assert_eq!(with(Method::STRIPE).len(), 15);
        assert_eq!(with(Method::Tunnel { length: 9 }).last().map(String::as_str), Some("tunnel"));
        let opengl = StripifyOptions::default().with_cost(tristrip::Cost::OpenGl);
        assert_eq!(labels(&opengl, None).last().map(String::as_str), Some("best:cost=opengl"));
    }

    #[test]
    fn a_cost_dominates_only_if_it_is_less_in_one_figure() {
        let cost = |indices, misses| ParetoCost { indices, misses };
        assert!(
            cost(1, 2).dominates(cost(2, 2))
                && cost(2, 1).dominates(cost(2, 2))
                && cost(1, 1).dominates(cost(2, 2))
        );
        assert!(!cost(2, 2).dominates(cost(2, 2)) && !cost(1, 3).dominates(cost(2, 2)));
    }
}
