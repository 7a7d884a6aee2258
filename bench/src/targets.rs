//! The targets of the project, each with the measured value and whether it is met.
//!
//! Values of peers are rounded to four digits. Comparisons allow half of the last digit.

mod searches;
mod target;
mod vertex_caches;

use crate::measure::{MethodRow, Outcome};
use crate::meshoptimizer::Pipeline;
use crate::methods::BEST;
use crate::scaling::Scaling;
use crate::searches::SearchResults;
use crate::vertex_caches::CacheResults;
pub use searches::best_ratio;
pub use target::Target;
use target::{ROUNDING, geometric_mean, none, row};

const SEQUENTIAL_COSTS: [(&str, f64); 5] =
    [("bunny", 1.200), ("fandisk", 1.170), ("horse", 1.232), ("armadillo_43k", 1.340), ("dragon", 1.342)];
const POLYGON_COSTS: [(&str, f64); 2] = [("cow", 1.24), ("triceratops", 1.24)];
const TIMED: [&str; 4] = ["fandisk", "bunny", "horse", "dragon"];
/// Vertices sent: model, SGI as published, the later report of STRIPE (2.1), and our limit.
const POLYGON_VERTICES: [(&str, f64, f64, f64); 3] = [
    ("skyscraper", 5621.0, 4849.0, 4537.0),
    ("triceratops", 8267.0, 7248.0, 6737.0),
    ("power_lines", 12147.0, 10417.0, 10084.0),
];
/// Strip counts of the authors' STRIPE: model, minimum, maximum.
const STRIPE_STRIPS: [(&str, f64, f64); 2] = [("cow_2904", 135.0, 147.0), ("bunny", 917.0, 1229.0)];

/// Returns the targets that have measurements.
pub fn compare(
    outcomes: &[Outcome],
    searched: &[SearchResults],
    caches: &[CacheResults],
    scaling: Option<&Scaling>,
) -> Vec<Target> {
    let rows: usize = outcomes.iter().map(|o| o.rows.len()).sum();
    let mut targets = vec![Target {
        what: "results proven before their times are shown".into(),
        target: "all".into(),
        found: format!("{rows} of {rows}"),
        met: rows > 0,
    }];
    targets.extend(same_inputs(outcomes));
    targets.extend(against_one_pass(outcomes, "sequential"));
    targets.extend(mean_target(outcomes));
    targets.extend(fixed_costs(outcomes));
    targets.extend(against_one_pass(outcomes, BEST));
    targets.extend(against_input(outcomes));
    targets.extend(polygon_vertices(outcomes));
    targets.extend(stripe_strips(outcomes));
    targets.extend(times_and_memory(outcomes));
    targets.extend(searches::compare(outcomes, searched));
    targets.extend(vertex_caches::compare(outcomes, caches));
    targets.extend(scaling.and_then(|scaling| {
        let what = format!(
            "sequential, time per triangle of {} at 8 million relative to 100 thousand",
            scaling.model
        );
        Some(Target::at_most(what, 1.6, scaling.ratio()?, 1))
    }));
    targets
}

/// Compares meshoptimizer's strips with its strips when the peers were measured. It is
/// deterministic, so equal strips mean the same index buffer.
fn same_inputs(outcomes: &[Outcome]) -> Option<Target> {
    let is_same = |o: &Outcome| {
        Some(o.row(Pipeline::StripCache.name())?.strips == o.peers.as_ref()?.meshopt_strip_cache.strips)
    };
    let all: Vec<_> = outcomes.iter().filter_map(|o| Some((o, is_same(o)?))).collect();
    let other = all.iter().filter(|pair| !pair.1).map(|pair| pair.0.model.clone());
    none(
        "models on which meshoptimizer makes other strips than when the peers were measured",
        other,
        all.len(),
    )
}

/// Iterates over the models with measured peers. Returns the cost of a method and of the best
/// one-pass peer.
pub fn pairs<'a>(outcomes: &'a [Outcome], method: &'a str) -> impl Iterator<Item = (&'a Outcome, f64, f64)> {
    outcomes.iter().filter_map(move |outcome| {
        let best = outcome.peers.as_ref()?.one_pass_indices_restart_per_triangle.best;
        Some((outcome, outcome.row(method)?.indices_restart_per_triangle, best))
    })
}

fn against_one_pass(outcomes: &[Outcome], method: &str) -> Option<Target> {
    let all: Vec<_> = pairs(outcomes, method).collect();
    let mut worse: Vec<_> = all.iter().filter(|(_, ours, best)| *ours > best + ROUNDING).collect();
    worse.sort_by(|a, b| (b.1 / b.2).total_cmp(&(a.1 / a.2)));
    let names = worse.iter().map(|(o, ours, best)| format!("{} ({ours:.4} to {best:.4})", o.model));
    none(&format!("{method}, models with more indices than the best one-pass peer"), names, all.len())
}

/// Returns the cost of `sequential` relative to the best one-pass peer, as a geometric mean over
/// the models.
pub fn mean_ratio(outcomes: &[Outcome]) -> Option<f64> {
    geometric_mean(pairs(outcomes, "sequential").map(|(_, ours, best)| ours / best))
}

fn mean_target(outcomes: &[Outcome]) -> Option<Target> {
    let what = "sequential, indices relative to the best one-pass peer, geometric mean";
    Some(Target::at_most(what.into(), 0.98, mean_ratio(outcomes)?, 2))
}

fn fixed_costs(outcomes: &[Outcome]) -> Vec<Target> {
    let triangles = SEQUENTIAL_COSTS.map(|(model, target)| (model, false, target));
    let polygons = POLYGON_COSTS.map(|(model, target)| (model, true, target));
    let target = |(model, is_polygons, target): (&str, bool, f64)| {
        let found = row(outcomes, model, is_polygons, "sequential")?.indices_restart_per_triangle;
        let fed = if is_polygons { ", fed as polygons" } else { "" };
        Some(Target::at_most(format!("sequential, indices per triangle, {model}{fed}"), target, found, 3))
    };
    triangles.into_iter().chain(polygons).filter_map(target).collect()
}

fn against_input(outcomes: &[Outcome]) -> Option<Target> {
    let cost = |outcome: &Outcome, method| Some(outcome.row(method)?.indices_restart_per_triangle);
    let pairs: Vec<_> =
        outcomes.iter().filter_map(|o| Some((o, cost(o, BEST)?, cost(o, "input")?))).collect();
    let worse = pairs.iter().filter(|p| p.1 > p.2).map(|p| p.0.model.clone());
    none(&format!("{BEST}, models with more indices than the input's own order"), worse, pairs.len())
}

fn polygon_vertices(outcomes: &[Outcome]) -> Vec<Target> {
    let mut targets = Vec::new();
    for (model, sgi, stripe, rows) in POLYGON_VERTICES {
        let limits = [
            ("sgi", 1.05 * sgi, format!(" (published {sgi})")),
            ("stripe", 1.03 * stripe, format!(" (published {stripe})")),
            ("quad-rows", rows, String::new()),
        ];
        for (method, limit, published) in limits {
            if let Some(row) = row(outcomes, model, true, method) {
                let what = format!("{method}, vertices sent, {model}{published}");
                targets.push(Target::at_most(what, limit.floor(), row.vertices_sent as f64, 0));
            }
        }
    }
    targets
}

fn stripe_strips(outcomes: &[Outcome]) -> Vec<Target> {
    let target = |(model, least, most): (&str, f64, f64)| {
        let outcome = outcomes.iter().find(|o| o.model == model && !o.polygons)?;
        let (low, high) = (0.9 * least, 1.1 * most);
        let variants = outcome.rows.iter().filter(|row| row.method.starts_with("stripe"));
        let off = |row: &MethodRow| (row.strips as f64 - f64::midpoint(least, most)).abs();
        let nearest = variants.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        Some(Target {
            what: format!("a named variant of STRIPE, strips, {model} (the authors' program {least}–{most})"),
            target: format!("{low:.0}–{high:.0}"),
            found: format!("{} by {}", nearest.strips, nearest.method),
            met: (low..=high).contains(&(nearest.strips as f64)),
        })
    };
    STRIPE_STRIPS.into_iter().filter_map(target).collect()
}

fn times_and_memory(outcomes: &[Outcome]) -> Vec<Target> {
    let mut targets: Vec<Target> = TIMED
        .into_iter()
        .filter_map(|model| {
            let ratio = row(outcomes, model, false, "sequential")?.time_ratio?;
            let what =
                format!("sequential, time relative to meshoptimizer's strip order and strips, {model}");
            Some(Target::at_most(what, 0.5, ratio, 2))
        })
        .collect();
    let bytes = |o: &Outcome| o.row("sequential").and_then(|row| row.extra_bytes_per_triangle);
    let of = |polygons| outcomes.iter().filter(move |o| o.polygons == polygons);
    for (polygons, fed) in [(false, "triangles"), (true, "polygons")] {
        let most = of(polygons).filter_map(|o| Some((bytes(o)?, o))).max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((bytes, outcome)) = most {
            let what = format!(
                "sequential, bytes per triangle beyond input and output, {fed}, most of all ({})",
                outcome.model
            );
            targets.push(Target::at_most(what, 60.0, bytes, 0));
        }
    }
    targets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::papers::{self, column};
    use crate::peers::{PeerBest, Peers, ReferenceStrips};

    fn outcome(model: &str, sequential: f64, peer: f64) -> Outcome {
        let best = |best| PeerBest { best, by: "a peer".into() };
        let peers = Peers {
            triangles: 1000,
            indices_restart_per_triangle: best(peer),
            indices_degenerate_per_triangle: best(peer),
            vertices_per_triangle: best(peer),
            strips: best(1.0),
            one_pass_indices_restart_per_triangle: best(peer),
            meshopt_strip_cache: ReferenceStrips { strips: 10 },
        };
        let row = MethodRow {
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
    fn targets_are_met_or_missed() {
        let targets = compare(&[outcome("bunny", 1.1, 1.2), outcome("fandisk", 1.3, 1.2)], &[], &[], None);
        let met = |start: &str| {
            targets.iter().find(|target| target.what.starts_with(start)).map(|target| target.met)
        };
        assert_eq!(met("sequential, models with more"), Some(false));
        assert_eq!(met("sequential, indices per triangle, bunny"), Some(true));
        assert_eq!(met("sequential, indices per triangle, fandisk"), Some(false));
        assert_eq!(met("sequential, time relative"), Some(true));
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
        let [sgi, stripe] = [(papers::STRIPE_1996, "SGI"), (papers::STRIPE_2000, "STRIPE")]
            .map(|(paper, name)| column(paper, "table 1", name).unwrap());
        for (model, by_sgi, by_stripe, _) in POLYGON_VERTICES {
            assert_eq!((sgi[model], stripe[model]), (by_sgi, by_stripe), "{model}");
        }
    }
}
