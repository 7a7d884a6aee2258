//! `tristrip strip --pareto`: compares all methods on a model by two conflicting figures, indices and misses.
//!
//! ```text
//!  misses per   │ ●───┐ best          a method is optimal if no other has at most as many of both and fewer of one
//!  triangle     │   ○ └───● cache     a line joins the optimal methods: no method is below it
//!               └───────────────
//!               indices per triangle
//! ```
//! Each result is proven before it becomes a point.

mod chart;

use std::time::Duration;

use serde::Serialize;
use tristrip::strip::{Between, Buffer, BufferUse, Metrics};
use tristrip::stripify::{Effort, EtaOptions, Prefer};
use tristrip::{Method, Options, Strips};

use crate::console::Console;
use crate::failure::Failure;
use crate::figures::rounded;
use crate::method::MethodReport;
use crate::search::{SearchWatch, Stopped, interrupted};
use crate::stages::{Pool, Prepared, find_strips, prove};
use crate::text::table;
pub(crate) use chart::draw;

/// The default efforts of `best` and `cache`: that of `auto`, and a longer search.
const EFFORTS: [u8; 2] = [2, 5];

/// The label of the plain triangle list.
const LIST: &str = "list";

/// The limits of searches.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Searches {
    /// The effort of all methods that search; `None` for the default efforts.
    pub(crate) effort: Option<Effort>,
    /// The time budget of each search.
    pub(crate) budget: Option<Duration>,
}

/// The cost of one method on a model; the keys are those of the JSON report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct ParetoPoint {
    /// The name in the chart.
    label: String,
    method: String,
    objective: Option<String>,
    effort: Option<u8>,
    vertex_cache: String,
    indices_restart_per_triangle: f64,
    acmr: f64,
    optimal: bool,
    stopped: Option<Stopped>,
    /// Whether the point is the file's own order: no strips were searched for.
    #[serde(skip)]
    is_file_order: bool,
    #[serde(skip)]
    cost: ParetoCost,
}

/// Indices with restarts, and misses, of the whole model. Costs are compared unrounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct ParetoCost {
    indices: usize,
    misses: usize,
}

impl ParetoCost {
    /// Returns whether this cost is less in one figure and not greater in the other.
    fn dominates(self, other: Self) -> bool {
        self.indices <= other.indices && self.misses <= other.misses && self != other
    }
}

/// A method with its options, under its name in the chart.
#[derive(Debug, Clone)]
struct Candidate {
    label: String,
    options: Options,
}

/// Measures all methods, including the one of the options, and the plain list. The notes name the searches that a budget or Ctrl-C
/// stopped.
///
/// # Errors
/// A result is not proven, or Ctrl-C was pressed before the last method.
pub(crate) fn measure(
    pool: &Pool,
    parts: &[Prepared<'_>],
    options: &Options,
    searches: Searches,
    console: &Console,
) -> Result<(Vec<ParetoPoint>, Vec<String>), Failure> {
    let mut points = Vec::new();
    for candidate in candidates(options, searches.effort) {
        if interrupted() {
            return Err(Failure::Output("pareto: not finished: interrupted".into()));
        }
        console.doing(&candidate.label);
        let watch = SearchWatch::new(console.progress(), searches.budget, &candidate.options);
        let point = candidate
            .measure(pool, parts, &watch)
            .map_err(|failure| Failure::Output(format!("pareto: {}: {failure}", candidate.label)))?;
        points.push(point);
    }
    points.push(list(pool, parts, options.buffer()));
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

/// Returns the methods of the chart, with the seed, welding and vertex cache of the options. The method of the options is added at the
/// end unless it is one of them.
fn candidates(options: &Options, effort: Option<Effort>) -> Vec<Candidate> {
    let base =
        Options::default().with_weld(options.weld()).with_seed(options.seed()).with_buffer(options.buffer());
    let plain = |label: &str, method| Candidate { label: label.into(), options: base.with_method(method) };
    let mut candidates = vec![
        plain("input", Method::Input),
        plain("sequential", Method::Sequential),
        plain("sgi", Method::Sgi),
        plain("stripe", Method::STRIPE),
        plain("eta", Method::Eta(EtaOptions::default())),
    ];
    let efforts: Vec<Effort> = match effort {
        Some(effort) => vec![effort],
        None => EFFORTS.into_iter().filter_map(Effort::new).collect(),
    };
    let search = |options: Options| {
        let report = MethodReport::of(&options);
        let words = [Some(report.method()), report.objective()].into_iter().flatten();
        let label = format!("{} {}", words.collect::<Vec<_>>().join(" "), options.effort().level());
        Candidate { label, options }
    };
    let fewest = base.with_method(Method::Fewest);
    candidates.push(search(effort.map_or(fewest, |effort| fewest.with_effort(effort))));
    candidates.extend(efforts.iter().map(|&e| search(base.with_method(Method::Best).with_effort(e))));
    for objective in [Prefer::Indices, Prefer::Balanced, Prefer::Misses] {
        let cache = base.with_method(Method::Cache).with_prefer(objective);
        candidates.extend(efforts.iter().map(|&e| search(cache.with_effort(e))));
    }
    let own = match options.method() {
        Method::Auto => options.with_method(Method::Best).with_effort(options.effort()),
        _ => *options,
    };
    let report = MethodReport::of(&own);
    if candidates.iter().all(|other| MethodReport::of(&other.options) != report) {
        candidates.push(Candidate { label: report.label(), options: own });
    }
    candidates
}

impl Candidate {
    /// Builds strips, proves them, and measures them.
    fn measure(
        &self,
        pool: &Pool,
        parts: &[Prepared<'_>],
        watch: &SearchWatch,
    ) -> Result<ParetoPoint, Failure> {
        let strips = find_strips(pool, parts, &self.options, watch)?.strips;
        prove(pool, parts, &strips, &self.options)?;
        let cache = self.options.buffer();
        let (metrics, used) = figures(pool, parts, &strips, cache);
        let report = MethodReport::of(&self.options);
        Ok(ParetoPoint {
            label: self.label.clone(),
            method: report.method().into(),
            objective: report.objective().map(Into::into),
            effort: report.effort(),
            stopped: watch.stopped(),
            is_file_order: self.options.method() == Method::Input,
            ..ParetoPoint::of(metrics.indices_restart, used, cache)
        })
    }
}

impl ParetoPoint {
    fn of(indices: usize, used: BufferUse, cache: Buffer) -> Self {
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

/// Sums the figures of strips over the parts. Each part starts with an empty vertex cache.
fn figures(pool: &Pool, parts: &[Prepared<'_>], strips: &[Strips], cache: Buffer) -> (Metrics, BufferUse) {
    let pairs: Vec<_> = parts.iter().zip(strips).collect();
    let measured = pool.map(&pairs, |(part, strips)| {
        (Metrics::of(strips), BufferUse::of(strips, cache, Between::Keep, part.mesh.vertex_count()))
    });
    (measured.iter().map(|m| m.0).sum(), measured.iter().map(|m| m.1).sum())
}

/// Measures the triangle list in the order of the file, polygons as fans, without degenerate faces.
fn list(pool: &Pool, parts: &[Prepared<'_>], cache: Buffer) -> ParetoPoint {
    let measured = pool.map(parts, |part| {
        let fans = part.surface.faces().iter().flat_map(|face| match face {
            [first, rest @ ..] => rest.windows(2).flat_map(|edge| [*first, edge[0], edge[1]]).collect(),
            [] => Vec::new(),
        });
        BufferUse::of_list(&fans.collect::<Vec<u32>>(), cache, part.mesh.vertex_count())
    });
    let used: BufferUse = measured.into_iter().sum();
    let (label, method) = (LIST.into(), LIST.into());
    ParetoPoint { label, method, is_file_order: true, ..ParetoPoint::of(3 * used.triangles, used, cache) }
}

/// Returns a line on the number of methods.
pub(crate) fn line(points: &[ParetoPoint]) -> String {
    let optimal = points.iter().filter(|point| point.optimal).count();
    format!("{} methods compared, each proven; {optimal} optimal", points.len())
}

/// Returns the points as a table, the fewest indices first.
pub(crate) fn as_text(points: &[ParetoPoint]) -> String {
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

    fn labels(options: &Options, effort: Option<Effort>) -> Vec<String> {
        candidates(options, effort).into_iter().map(|candidate| candidate.label).collect()
    }

    #[test]
    fn every_method_appears_once_under_a_distinct_name() {
        let default = labels(&Options::default(), None);
        assert_eq!(
            default.join(", "),
            "input, sequential, sgi, stripe, eta, fewest 5, best 2, best 5, cache indices 2, cache indices 5, \
             cache balanced 2, cache balanced 5, cache misses 2, cache misses 5"
        );
        assert_eq!(default.iter().collect::<HashSet<_>>().len(), default.len());
        let effort = Effort::new(1);
        let short = labels(&Options::default().with_effort(Effort::new(1).unwrap()), effort);
        assert_eq!(
            short[5..].join(", "),
            "fewest 1, best 1, cache indices 1, cache balanced 1, cache misses 1"
        );
    }

    #[test]
    fn the_requested_method_is_included() {
        let with = |method| labels(&Options::default().with_method(method), None);
        assert_eq!(with(Method::Best).len(), 14);
        assert_eq!(with(Method::STRIPE).len(), 14);
        assert_eq!(with(Method::Tunnel { length: 9 }).last().map(String::as_str), Some("tunnel 9"));
        let opengl = Options::default().with_cost(tristrip::strip::Cost::OpenGl);
        assert_eq!(labels(&opengl, None).last().map(String::as_str), Some("best opengl 2"));
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
