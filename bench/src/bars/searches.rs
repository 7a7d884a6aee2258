//! The bars of the searches: few strips, cheap strips, and their times.

use tristrip::strip::Cost;

use super::{Bar, ROUNDING, none};
use crate::measure::{Outcome, Row};
use crate::methods::{BEST, COSTS, ETA, FEWEST};
use crate::searches::{PEER_COSTS, Searched, per_triangle};

/// Strips and seconds of `fewest`.
const FEWEST_BARS: [(&str, usize, f64); 6] = [
    ("goblet", 1, 0.01),
    ("fandisk", 1, 0.3),
    ("cessna", 11, 2.0),
    ("bunny", 9, 1.5),
    ("horse", 1, 10.0),
    ("dragon", 474, 20.0),
];
/// The gap between strips and bound on dragon.
const GAP: (&str, f64) = ("dragon", 0.05);
/// What `best` is to cost a triangle, for each of [`PEER_COSTS`], and its seconds.
const BEST_BARS: [(&str, [f64; 3], f64); 5] = [
    ("cow_2904", [1.205, 1.155, 1.25], 5.0),
    ("fandisk", [1.098, 1.074, 1.125], 5.0),
    ("bunny", [1.125, 1.092, 1.16], 5.0),
    ("horse", [1.155, 1.12, 1.19], 5.0),
    ("dragon", [1.27, 1.22, 1.31], 60.0),
];
/// Vertices sent of models of polygons.
const POLYGON_BARS: [(&str, usize); 3] = [("skyscraper", 4290), ("triceratops", 6430), ("power_lines", 9300)];
/// Efforts, what they are to cost, and their times by that of the reference.
const LADDER_BARS: [(&str, f64, f64); 4] =
    [("best 1", 1.195, 1.0), ("best 3", 1.16, 10.0), ("best 5", 1.135, 100.0), ("best 7", 1.125, 400.0)];
/// The published time is to be undercut so many times.
const FASTER: f64 = 100.0;
/// Below the best of all peers, as a geometric mean.
const MEAN: f64 = 0.94;
const BYTES: f64 = 120.0;

/// Lists the bars of which something was searched.
pub(super) fn judge(outcomes: &[Outcome], searched: &[Searched]) -> Vec<Bar> {
    let mut bars = fewest(searched);
    bars.extend(eta(searched));
    bars.extend(best(searched));
    bars.extend(against_peers(searched));
    bars.extend(against_starts(outcomes));
    bars.extend(memory(outcomes, searched));
    bars
}

fn named<'a>(searched: &'a [Searched], model: &str) -> Option<&'a Searched> {
    searched.iter().find(|s| s.model == model)
}

fn cost_name(cost: Cost) -> &'static str {
    COSTS.iter().find(|(each, _)| *each == cost).map_or("", |(_, name)| name)
}

/// A bar on a figure and on the time that it takes.
fn timed(what: String, bar: (String, f64), found: &str, is_reached: bool, seconds: f64) -> Bar {
    let (figure, most) = bar;
    let met = is_reached && seconds <= most;
    Bar { what, bar: format!("≤ {figure} in {most} s"), found: format!("{found} in {seconds:.3} s"), met }
}

fn fewest(searched: &[Searched]) -> Vec<Bar> {
    let bar = |(model, strips, seconds): (&str, usize, f64)| {
        let row = &named(searched, model)?.fewest.row;
        let what = format!("fewest, strips, {model}");
        let found = row.strips.to_string();
        Some(timed(what, (strips.to_string(), seconds), &found, row.strips <= strips, row.seconds))
    };
    let mut bars: Vec<Bar> = FEWEST_BARS.into_iter().filter_map(bar).collect();
    if let Some(s) = named(searched, GAP.0) {
        bars.push(Bar::at_most(format!("fewest, strips beyond the bound, {}", s.model), GAP.1, s.gap(), 3));
    }
    let closed: Vec<&Searched> = searched.iter().filter(|s| s.is_closed).collect();
    let more = |s: &&&Searched| s.fewest.row.strips > s.bound.max(1);
    let names = closed.iter().filter(more).map(|s| format!("{} {}", s.model, s.fewest.row.strips));
    bars.extend(none(
        "fewest, closed connected models with more strips than their bound",
        names,
        closed.len(),
    ));
    let strips = |s: &Searched| Some((s.fewest.row.strips, s.peers.as_ref()?.strips.best));
    let pairs: Vec<_> = searched.iter().filter_map(|s| Some((s, strips(s)?))).collect();
    let worse = pairs.iter().filter(|(_, (ours, best))| *ours as f64 > *best);
    let names = worse.map(|(s, (ours, best))| format!("{} ({ours} to {best})", s.model));
    bars.extend(none("fewest, models with more strips than the best of all peers", names, pairs.len()));
    bars
}

fn eta(searched: &[Searched]) -> Vec<Bar> {
    let bar = |s: &Searched| {
        let (row, published) = (&s.eta.as_ref()?.row, s.published.as_ref()?);
        let what = format!("eta, strips as published in a hundredth of the time, {}", s.model);
        let most = (published.strips.to_string(), published.seconds / FASTER);
        Some(timed(what, most, &row.strips.to_string(), row.strips as f64 <= published.strips, row.seconds))
    };
    searched.iter().filter_map(bar).collect()
}

fn best(searched: &[Searched]) -> Vec<Bar> {
    let mut bars = Vec::new();
    for (model, costs, seconds) in BEST_BARS {
        let Some(s) = named(searched, model) else { continue };
        for ((cost, most), search) in PEER_COSTS.into_iter().zip(costs).zip(&s.best) {
            let found = per_triangle(&search.row, s.triangles, cost);
            let what = format!("best, {} a triangle, {model}", cost_name(cost));
            let found_text = format!("{found:.4}");
            bars.push(timed(
                what,
                (format!("{most:.3}"), seconds),
                &found_text,
                found <= most,
                search.row.seconds,
            ));
        }
    }
    for (model, most) in POLYGON_BARS {
        if let Some(search) = named(searched, model).and_then(|s| s.polygons.as_ref()) {
            let sent = search.row.vertices_sent as f64;
            bars.push(Bar::at_most(
                format!("best, vertices sent, {model} as polygons"),
                most as f64,
                sent,
                0,
            ));
        }
    }
    for s in searched {
        for (name, most, most_times) in LADDER_BARS {
            let row: Option<&Row> = s.ladder.iter().map(|l| &l.row).find(|row| row.method == name);
            let Some((row, times)) = row.and_then(|row| Some((row, row.time_ratio?))) else { continue };
            let found = row.indices_restart_per_triangle;
            bars.push(Bar {
                what: format!("{name}, indices a triangle and time by meshoptimizer's, {}", s.model),
                bar: format!("≤ {most:.3} in {most_times} ×"),
                found: format!("{found:.4} in {times:.2} ×"),
                met: found <= most && times <= most_times,
            });
        }
    }
    bars
}

/// The geometric mean over the models of a cost of `best` by that of the best of all peers.
pub fn best_ratio(searched: &[Searched], at: usize) -> Option<f64> {
    let logarithm = |s: &Searched| {
        let (ours, best) = s.pair(s.best.get(at)?, PEER_COSTS[at])?;
        Some((ours / best.best).ln())
    };
    let all: Vec<f64> = searched.iter().filter_map(logarithm).collect();
    (!all.is_empty()).then(|| (all.iter().sum::<f64>() / all.len() as f64).exp())
}

fn against_peers(searched: &[Searched]) -> Vec<Bar> {
    let mut bars = Vec::new();
    for (at, cost) in PEER_COSTS.into_iter().enumerate() {
        let of = |s: &Searched| {
            let (ours, best) = s.pair(s.best.get(at)?, cost)?;
            Some((s.model.clone(), ours, best.best))
        };
        let pairs: Vec<_> = searched.iter().filter_map(of).collect();
        let names = pairs.iter().filter(|(_, ours, best)| *ours > best + ROUNDING);
        let names = names.map(|(model, ours, best)| format!("{model} ({ours:.4} to {best:.4})"));
        let name = cost_name(cost);
        bars.extend(none(
            &format!("best, models with a higher cost than the best of all peers, {name}"),
            names,
            pairs.len(),
        ));
        if let Some(mean) = best_ratio(searched, at) {
            let what = format!("best, {name} cost by that of the best of all peers, geometric mean");
            bars.push(Bar::at_most(what, MEAN, mean, 2));
        }
    }
    bars
}

fn against_starts(outcomes: &[Outcome]) -> Option<Bar> {
    let cost = |o: &Outcome, method| Some(o.row(method)?.indices_restart_per_triangle);
    let pair = |o: &Outcome| {
        let start = ["input", "sequential", "stripe"].into_iter().filter_map(|m| cost(o, m)).reduce(f64::min);
        Some((o.model.clone(), cost(o, BEST)?, start?))
    };
    let pairs: Vec<_> = outcomes.iter().filter_map(pair).collect();
    let names = pairs.iter().filter(|(_, ours, start)| ours > start).map(|(model, ..)| model.clone());
    none("best, models with more indices than input, sequential or stripe", names, pairs.len())
}

fn memory(outcomes: &[Outcome], searched: &[Searched]) -> Vec<Bar> {
    let bytes = |row: &Row, model: &str| Some((row.extra_bytes_per_triangle?, model.to_owned()));
    let bar = |method: &str, all: &mut dyn Iterator<Item = (f64, String)>| {
        let (bytes, model) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let what = format!("{method}, bytes a triangle beyond input and output, most of all ({model})");
        Some(Bar::at_most(what, BYTES, bytes, 0))
    };
    let mut bars = Vec::new();
    for method in [BEST, FEWEST, ETA] {
        let mut all = outcomes.iter().filter_map(|o| bytes(o.row(method)?, &o.model));
        bars.extend(bar(method, &mut all));
    }
    let mut longer = searched.iter().flat_map(|s| {
        let all = s.best.iter().chain(&s.eta).chain([&s.fewest]);
        all.filter_map(|search| bytes(&search.row, &s.model)).collect::<Vec<_>>()
    });
    bars.extend(bar("every longer search", &mut longer));
    bars
}
