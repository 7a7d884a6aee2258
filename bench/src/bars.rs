//! The bars that the project holds itself to, each with what was measured and whether that meets it.
//!
//! Figures of peers are rounded to four digits, so that half of the last one is allowed for when they are compared.

mod buffers;
mod searches;

use serde::Serialize;

use crate::buffers::Buffered;
use crate::measure::{Outcome, Row};
use crate::rivals::Pipeline;
use crate::scaling::Scaling;
use crate::searches::Searched;
pub use searches::best_ratio;

/// Half of the last digit of the peers' figures.
const ROUNDING: f64 = 0.000_05;

/// Models that are named where a bar is missed.
const NAMED: usize = 5;

const SEQUENTIAL_COSTS: [(&str, f64); 5] =
    [("bunny", 1.200), ("fandisk", 1.170), ("horse", 1.232), ("armadillo_43k", 1.340), ("dragon", 1.342)];
const POLYGON_COSTS: [(&str, f64); 2] = [("cow", 1.24), ("triceratops", 1.24)];
const TIMED: [&str; 4] = ["fandisk", "bunny", "horse", "dragon"];
/// Vertices sent as published by Evans, Skiena and Varshney (1996): model, SGI, the better of two reports of STRIPE.
const PUBLISHED: [(&str, f64, f64); 3] =
    [("skyscraper", 5621.0, 4616.0), ("triceratops", 8267.0, 6911.0), ("power_lines", 12147.0, 10417.0)];
/// Strips that the authors' own STRIPE makes: model, least, most.
const STRIPE_STRIPS: [(&str, f64, f64); 2] = [("cow_2904", 135.0, 147.0), ("bunny", 917.0, 1229.0)];

/// A bar and what was found.
#[derive(Debug, Clone, Serialize)]
pub struct Bar {
    /// What is measured.
    pub what: String,
    /// What it should be.
    pub bar: String,
    /// What it is.
    pub found: String,
    /// Whether the bar is met.
    pub met: bool,
}

impl Bar {
    /// Makes a bar that is met by a figure of at most so much.
    pub fn at_most(what: String, bar: f64, found: f64, digits: usize) -> Self {
        let (bar_text, found_text) = (format!("≤ {bar:.digits$}"), format!("{found:.*}", digits + 1));
        Self { what, bar: bar_text, found: found_text, met: found <= bar }
    }

    /// Makes a bar that is met by a figure of at least so much.
    pub fn at_least(what: String, bar: f64, found: f64, digits: usize) -> Self {
        let (bar_text, found_text) = (format!("≥ {bar:.digits$}"), format!("{found:.*}", digits + 1));
        Self { what, bar: bar_text, found: found_text, met: found >= bar }
    }
}

/// Lists the bars of which something was measured.
pub fn judge(
    outcomes: &[Outcome],
    searched: &[Searched],
    buffered: &[Buffered],
    scaling: Option<&Scaling>,
) -> Vec<Bar> {
    let rows: usize = outcomes.iter().map(|o| o.rows.len()).sum();
    let mut bars = vec![Bar {
        what: "answers proven before their times are shown".into(),
        bar: "all".into(),
        found: format!("{rows} of {rows}"),
        met: rows > 0,
    }];
    bars.extend(same_inputs(outcomes));
    bars.extend(against_one_pass(outcomes, "sequential"));
    bars.extend(geometric_mean(outcomes));
    bars.extend(fixed_costs(outcomes));
    bars.extend(against_one_pass(outcomes, "auto"));
    bars.extend(against_input(outcomes));
    bars.extend(published(outcomes));
    bars.extend(stripe_strips(outcomes));
    bars.extend(times_and_memory(outcomes));
    bars.extend(searches::judge(outcomes, searched));
    bars.extend(buffers::judge(outcomes, buffered));
    bars.extend(scaling.and_then(|scaling| {
        let what =
            format!("sequential, time a triangle of {} at 8 million by that at 100 thousand", scaling.model);
        Some(Bar::at_most(what, 1.6, scaling.ratio()?, 1))
    }));
    bars
}

/// Meshoptimizer is deterministic: where it gives the strips that it gave among the peers, the index buffer is theirs.
fn same_inputs(outcomes: &[Outcome]) -> Option<Bar> {
    let is_same = |o: &Outcome| {
        Some(o.row(Pipeline::StripCache.name())?.strips == o.peers.as_ref()?.meshopt_strip_cache.strips)
    };
    let all: Vec<_> = outcomes.iter().filter_map(|o| Some((o, is_same(o)?))).collect();
    let other: Vec<String> = all.iter().filter(|pair| !pair.1).map(|pair| pair.0.model.clone()).collect();
    let met = other.is_empty();
    (!all.is_empty()).then(|| Bar {
        what: "models on which meshoptimizer gives other strips than among the peers".into(),
        bar: "none".into(),
        found: listed(&other, all.len()),
        met,
    })
}

/// The cost of a method and the best one-pass peer's, for each model that peers were measured on.
pub fn pairs<'a>(outcomes: &'a [Outcome], method: &'a str) -> impl Iterator<Item = (&'a Outcome, f64, f64)> {
    outcomes.iter().filter_map(move |outcome| {
        let best = outcome.peers.as_ref()?.one_pass_indices_restart_per_triangle.best;
        Some((outcome, outcome.row(method)?.indices_restart_per_triangle, best))
    })
}

fn against_one_pass(outcomes: &[Outcome], method: &str) -> Option<Bar> {
    let all: Vec<_> = pairs(outcomes, method).collect();
    let mut worse: Vec<_> = all.iter().filter(|(_, ours, best)| *ours > best + ROUNDING).collect();
    worse.sort_by(|a, b| (b.1 / b.2).total_cmp(&(a.1 / a.2)));
    let names = worse.iter().map(|(o, ours, best)| format!("{} ({ours:.4} to {best:.4})", o.model));
    let found = listed(&names.collect::<Vec<_>>(), all.len());
    (!all.is_empty()).then(|| Bar {
        what: format!("{method}, models with more indices than the best one-pass peer"),
        bar: "none".into(),
        found,
        met: worse.is_empty(),
    })
}

/// Says how many fall short, and names the first few.
fn listed(names: &[String], of: usize) -> String {
    let count = format!("{} of {of}", names.len());
    match names.len() {
        0 => count,
        n if n <= NAMED => format!("{count}: {}", names.join(", ")),
        _ => format!("{count}: {}, …", names[..NAMED].join(", ")),
    }
}

/// A bar that nothing is to miss.
fn none(what: &str, missed: impl Iterator<Item = String>, of: usize) -> Option<Bar> {
    let missed: Vec<String> = missed.collect();
    let (found, met) = (listed(&missed, of), missed.is_empty());
    (of > 0).then(|| Bar { what: what.into(), bar: "none".into(), found, met })
}

/// Gives the geometric mean over the models of the cost of `sequential` by that of the best one-pass peer.
pub fn mean_ratio(outcomes: &[Outcome]) -> Option<f64> {
    let logarithms: Vec<f64> =
        pairs(outcomes, "sequential").map(|(_, ours, best)| (ours / best).ln()).collect();
    (!logarithms.is_empty()).then(|| (logarithms.iter().sum::<f64>() / logarithms.len() as f64).exp())
}

fn geometric_mean(outcomes: &[Outcome]) -> Option<Bar> {
    let what = "sequential, indices by those of the best one-pass peer, geometric mean";
    Some(Bar::at_most(what.into(), 0.98, mean_ratio(outcomes)?, 2))
}

fn row<'a>(outcomes: &'a [Outcome], model: &str, polygons: bool, method: &str) -> Option<&'a Row> {
    outcomes.iter().find(|o| o.model == model && o.polygons == polygons)?.row(method)
}

fn fixed_costs(outcomes: &[Outcome]) -> Vec<Bar> {
    let triangles = SEQUENTIAL_COSTS.map(|(model, bar)| (model, false, bar));
    let polygons = POLYGON_COSTS.map(|(model, bar)| (model, true, bar));
    let bar = |(model, is_polygons, bar): (&str, bool, f64)| {
        let found = row(outcomes, model, is_polygons, "sequential")?.indices_restart_per_triangle;
        let fed = if is_polygons { ", fed as polygons" } else { "" };
        Some(Bar::at_most(format!("sequential, indices a triangle, {model}{fed}"), bar, found, 3))
    };
    triangles.into_iter().chain(polygons).filter_map(bar).collect()
}

fn against_input(outcomes: &[Outcome]) -> Option<Bar> {
    let cost = |outcome: &Outcome, method| Some(outcome.row(method)?.indices_restart_per_triangle);
    let pairs: Vec<_> =
        outcomes.iter().filter_map(|o| Some((o, cost(o, "auto")?, cost(o, "input")?))).collect();
    let worse: Vec<String> = pairs.iter().filter(|p| p.1 > p.2).map(|p| p.0.model.clone()).collect();
    let met = worse.is_empty();
    (!pairs.is_empty()).then(|| Bar {
        what: "auto, models with more indices than the input's own order".into(),
        bar: "none".into(),
        found: listed(&worse, pairs.len()),
        met,
    })
}

fn published(outcomes: &[Outcome]) -> Vec<Bar> {
    let mut bars = Vec::new();
    for (model, sgi, stripe) in PUBLISHED {
        for (method, published, allowed) in [("sgi", sgi, 1.05), ("stripe", stripe, 1.01)] {
            if let Some(row) = row(outcomes, model, true, method) {
                let what = format!("{method}, vertices sent, {model} (published {published})");
                bars.push(Bar::at_most(what, (published * allowed).floor(), row.vertices_sent as f64, 0));
            }
        }
    }
    bars
}

fn stripe_strips(outcomes: &[Outcome]) -> Vec<Bar> {
    let bar = |(model, least, most): (&str, f64, f64)| {
        let outcome = outcomes.iter().find(|o| o.model == model && !o.polygons)?;
        let (low, high) = (0.9 * least, 1.1 * most);
        let variants = outcome.rows.iter().filter(|row| row.method.starts_with("stripe"));
        let off = |row: &Row| (row.strips as f64 - f64::midpoint(least, most)).abs();
        let nearest = variants.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(Bar {
            what: format!("a named variant of STRIPE, strips, {model} (the authors' program {least}–{most})"),
            bar: format!("{low:.0}–{high:.0}"),
            found: format!("{} by {}", nearest.strips, nearest.method),
            met: (low..=high).contains(&(nearest.strips as f64)),
        })
    };
    STRIPE_STRIPS.into_iter().filter_map(bar).collect()
}

fn times_and_memory(outcomes: &[Outcome]) -> Vec<Bar> {
    let mut bars: Vec<Bar> = TIMED
        .into_iter()
        .filter_map(|model| {
            let ratio = row(outcomes, model, false, "sequential")?.time_ratio?;
            let what = format!("sequential, time by meshoptimizer's strip order and strips, {model}");
            Some(Bar::at_most(what, 0.5, ratio, 2))
        })
        .collect();
    let bytes = |o: &Outcome| o.row("sequential").and_then(|row| row.extra_bytes_per_triangle);
    let of = |polygons| outcomes.iter().filter(move |o| o.polygons == polygons);
    for (polygons, fed) in [(false, "triangles"), (true, "polygons")] {
        let most = of(polygons).filter_map(|o| Some((bytes(o)?, o))).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((bytes, outcome)) = most {
            let what = format!(
                "sequential, bytes a triangle beyond input and output, {fed}, most of all ({})",
                outcome.model
            );
            bars.push(Bar::at_most(what, 60.0, bytes, 0));
        }
    }
    bars
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::papers::{self, column};
    use crate::peers::{Best, Peers, Reference};

    fn outcome(model: &str, sequential: f64, peer: f64) -> Outcome {
        let best = |best| Best { best, by: "a peer".into() };
        let peers = Peers {
            triangles: 1000,
            indices_restart_per_triangle: best(peer),
            indices_degenerate_per_triangle: best(peer),
            vertices_per_triangle: best(peer),
            strips: best(1.0),
            one_pass_indices_restart_per_triangle: best(peer),
            meshopt_strip_cache: Reference { strips: 10 },
        };
        let row = Row {
            method: "sequential".into(),
            proven: true,
            strips: 10,
            isolated: 0,
            swaps: 0,
            vertices_sent: 1020,
            gl_cost: 1020,
            indices_restart_per_triangle: sequential,
            indices_degenerate_per_triangle: sequential,
            seconds: 0.001,
            time_ratio: Some(0.4),
            extra_bytes_per_triangle: Some(61.0),
        };
        Outcome { model: model.into(), polygons: false, triangles: 1000, rows: vec![row], peers: Some(peers) }
    }

    #[test]
    fn bars_tell_met_from_not_met() {
        let bars = judge(&[outcome("bunny", 1.1, 1.2), outcome("fandisk", 1.3, 1.2)], &[], &[], None);
        let met = |start: &str| bars.iter().find(|bar| bar.what.starts_with(start)).map(|bar| bar.met);
        assert_eq!(met("sequential, models with more"), Some(false));
        assert_eq!(met("sequential, indices a triangle, bunny"), Some(true));
        assert_eq!(met("sequential, indices a triangle, fandisk"), Some(false));
        assert_eq!(met("sequential, time by"), Some(true));
        assert_eq!(met("sequential, bytes"), Some(false));
        assert_eq!(met("sgi"), None);
    }

    #[test]
    fn the_mean_is_geometric() {
        let mean = mean_ratio(&[outcome("a", 1.0, 2.0), outcome("b", 2.0, 1.0)]);
        assert!(mean.is_some_and(|mean| (mean - 1.0).abs() < 1e-12));
    }

    #[test]
    fn published_vertices_are_those_of_the_papers() {
        let [sgi, first, second] =
            [(papers::STRIPE_1996, "SGI"), (papers::STRIPE_1996, "STRIPE"), (papers::STRIPE_2000, "STRIPE")]
                .map(|(paper, name)| column(paper, "table 1", name).unwrap());
        for (model, by_sgi, by_stripe) in PUBLISHED {
            assert_eq!((sgi[model], first[model].min(second[model])), (by_sgi, by_stripe), "{model}");
        }
    }
}
