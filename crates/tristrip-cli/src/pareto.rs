//! `tristrip strip --pareto`: what every method makes of a model, by the two figures that are at odds: indices and misses.
//!
//! ```text
//!  misses a     │ ●───┐ best          a method is optimal where no other has as few of both and fewer of one
//!  triangle     │   ○ └───● cache     optimal ones are joined: below the line is nothing
//!               └───────────────
//!                indices a triangle
//! ```
//! Every result is proven before it becomes a point.

mod picture;

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
pub(crate) use picture::draw;

/// Efforts of `best` and `cache` unless one was asked for: that of `auto`, and that of a longer search.
const EFFORTS: [u8; 2] = [2, 5];

/// The label of the plain triangle list.
const LIST: &str = "list";

/// How long methods search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Searches {
    /// Of all methods that search; each has its own where none was asked for.
    pub(crate) effort: Option<Effort>,
    /// Of each search by itself.
    pub(crate) budget: Option<Duration>,
}

/// One way to draw a model, and what it costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Point {
    /// The name in the picture.
    label: String,
    method: String,
    prefer: Option<String>,
    effort: Option<u8>,
    buffer: String,
    indices_restart_per_triangle: f64,
    acmr: f64,
    optimal: bool,
    stopped: Option<Stopped>,
    /// Whether the file's own order made it: nobody looked for strips.
    #[serde(skip)]
    as_found: bool,
    #[serde(skip)]
    cost: Cost,
}

/// Indices with restarts, and misses, of the whole model: compared before they are rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Cost {
    indices: usize,
    misses: usize,
}

impl Cost {
    /// Tells whether one is nowhere worse and somewhere better.
    fn beats(self, other: Self) -> bool {
        self.indices <= other.indices && self.misses <= other.misses && self != other
    }
}

/// A method under the name that it has in the picture.
#[derive(Debug, Clone)]
struct Candidate {
    label: String,
    options: Options,
}

/// Measures every method, the one of the options too, and the plain list; the notes say what a budget or Ctrl-C cut short.
///
/// # Errors
/// A result is not proven, or Ctrl-C came before the last method.
pub(crate) fn measure(
    pool: &Pool,
    parts: &[Prepared<'_>],
    options: &Options,
    searches: Searches,
    console: &Console,
) -> Result<(Vec<Point>, Vec<String>), Failure> {
    let mut points = Vec::new();
    for candidate in candidates(options, searches.effort) {
        if interrupted() {
            return Err(Failure::Output("pareto: not done: interrupted".into()));
        }
        console.doing(&candidate.label);
        let watch = SearchWatch::new(console.progress(), searches.budget, &candidate.options);
        let point = candidate
            .measure(pool, parts, &watch)
            .map_err(|failure| Failure::Output(format!("pareto: {}: {failure}", candidate.label)))?;
        points.push(point);
    }
    points.push(list(pool, parts, options.buffer()));
    let costs: Vec<Cost> = points.iter().map(|point| point.cost).collect();
    for point in &mut points {
        point.optimal = !costs.iter().any(|cost| cost.beats(point.cost));
    }
    let cut: Vec<&str> =
        points.iter().filter(|point| point.stopped.is_some()).map(|point| point.label.as_str()).collect();
    let notes = (!cut.is_empty())
        .then(|| format!("of the picture, these searches were cut short: {}", cut.join(", ")));
    Ok((points, notes.into_iter().collect()))
}

/// Lists the methods to draw, with the seed, welding and buffer of some options; the method of these options is the last where it is
/// none of the others.
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
        let words = [Some(report.method()), report.prefer()].into_iter().flatten();
        let label = format!("{} {}", words.collect::<Vec<_>>().join(" "), options.effort().level());
        Candidate { label, options }
    };
    let fewest = base.with_method(Method::Fewest);
    candidates.push(search(effort.map_or(fewest, |effort| fewest.with_effort(effort))));
    candidates.extend(efforts.iter().map(|&e| search(base.with_method(Method::Best).with_effort(e))));
    for prefer in [Prefer::Indices, Prefer::Balanced, Prefer::Misses] {
        let cache = base.with_method(Method::Cache).with_prefer(prefer);
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
    /// Finds strips, proves them, and measures them.
    fn measure(&self, pool: &Pool, parts: &[Prepared<'_>], watch: &SearchWatch) -> Result<Point, Failure> {
        let strips = find_strips(pool, parts, &self.options, watch)?.strips;
        prove(pool, parts, &strips, &self.options)?;
        let buffer = self.options.buffer();
        let (metrics, used) = figures(pool, parts, &strips, buffer);
        let report = MethodReport::of(&self.options);
        Ok(Point {
            label: self.label.clone(),
            method: report.method().into(),
            prefer: report.prefer().map(Into::into),
            effort: report.effort(),
            stopped: watch.stopped(),
            as_found: self.options.method() == Method::Input,
            ..Point::of(metrics.indices_restart, used, buffer)
        })
    }
}

impl Point {
    fn of(indices: usize, used: BufferUse, buffer: Buffer) -> Self {
        Self {
            label: String::new(),
            method: String::new(),
            prefer: None,
            effort: None,
            buffer: buffer.to_string(),
            indices_restart_per_triangle: rounded(indices as f64 / used.triangles.max(1) as f64),
            acmr: rounded(used.acmr()),
            optimal: false,
            stopped: None,
            as_found: false,
            cost: Cost { indices, misses: used.misses },
        }
    }
}

/// Sums the figures of strips over the parts, each of which begins with an empty buffer.
fn figures(pool: &Pool, parts: &[Prepared<'_>], strips: &[Strips], buffer: Buffer) -> (Metrics, BufferUse) {
    let pairs: Vec<_> = parts.iter().zip(strips).collect();
    let measured = pool.map(&pairs, |(part, strips)| {
        (Metrics::of(strips), BufferUse::of(strips, buffer, Between::Keep, part.mesh.vertex_count()))
    });
    (measured.iter().map(|m| m.0).sum(), measured.iter().map(|m| m.1).sum())
}

/// Measures the triangles in the order of the file, polygons as fans, without those that draw nothing.
fn list(pool: &Pool, parts: &[Prepared<'_>], buffer: Buffer) -> Point {
    let measured = pool.map(parts, |part| {
        let fans = part.surface.faces().iter().flat_map(|face| match face {
            [first, rest @ ..] => rest.windows(2).flat_map(|edge| [*first, edge[0], edge[1]]).collect(),
            [] => Vec::new(),
        });
        BufferUse::of_list(&fans.collect::<Vec<u32>>(), buffer, part.mesh.vertex_count())
    });
    let used: BufferUse = measured.into_iter().sum();
    let (label, method) = (LIST.into(), LIST.into());
    Point { label, method, as_found: true, ..Point::of(3 * used.triangles, used, buffer) }
}

/// Says in one line what was measured.
pub(crate) fn line(points: &[Point]) -> String {
    let optimal = points.iter().filter(|point| point.optimal).count();
    format!("{} ways to draw it, each proven; {optimal} optimal", points.len())
}

/// Writes the points as a table, the fewest indices first.
pub(crate) fn as_text(points: &[Point]) -> String {
    let mut sorted: Vec<&Point> = points.iter().collect();
    sorted.sort_by_key(|point| (point.cost.indices, point.cost.misses));
    let buffer = points.first().map_or("", |point| point.buffer.as_str());
    let head =
        ["  way".into(), "indices a triangle".into(), format!("ACMR {buffer}"), String::new()].to_vec();
    let row = |point: &Point| {
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
    fn every_method_is_drawn_once_and_under_a_name_of_its_own() {
        let usual = labels(&Options::default(), None);
        assert_eq!(
            usual.join(", "),
            "input, sequential, sgi, stripe, eta, fewest 5, best 2, best 5, cache indices 2, cache indices 5, \
             cache balanced 2, cache balanced 5, cache misses 2, cache misses 5"
        );
        assert_eq!(usual.iter().collect::<HashSet<_>>().len(), usual.len());
        let effort = Effort::new(1);
        let short = labels(&Options::default().with_effort(Effort::new(1).unwrap()), effort);
        assert_eq!(
            short[5..].join(", "),
            "fewest 1, best 1, cache indices 1, cache balanced 1, cache misses 1"
        );
    }

    #[test]
    fn the_method_that_was_asked_for_is_drawn_too() {
        let with = |method| labels(&Options::default().with_method(method), None);
        assert_eq!(with(Method::Best).len(), 14);
        assert_eq!(with(Method::STRIPE).len(), 14);
        assert_eq!(with(Method::Tunnel { length: 9 }).last().map(String::as_str), Some("tunnel 9"));
        let opengl = Options::default().with_cost(tristrip::strip::Cost::OpenGl);
        assert_eq!(labels(&opengl, None).last().map(String::as_str), Some("best opengl 2"));
    }

    #[test]
    fn only_what_is_better_somewhere_beats() {
        let cost = |indices, misses| Cost { indices, misses };
        assert!(cost(1, 2).beats(cost(2, 2)) && cost(2, 1).beats(cost(2, 2)) && cost(1, 1).beats(cost(2, 2)));
        assert!(!cost(2, 2).beats(cost(2, 2)) && !cost(1, 3).beats(cost(2, 2)));
    }
}
