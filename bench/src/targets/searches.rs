//! The targets for the searches: few strips, cheap strips, and their times.

use super::target::{ROUNDING, Target, geometric_mean, none};
use crate::measure::{MethodRow, Outcome};
use crate::methods::{BEST, FEWEST, GUIDED_TUNNELS};
use crate::searches::{PEER_COSTS, SearchResults, per_triangle};

/// Targets of `fewest`: strips and seconds.
const FEWEST_TARGETS: [(&str, usize, f64); 6] = [
    ("goblet", 1, 0.01),
    ("fandisk", 1, 0.3),
    ("cessna", 11, 2.0),
    ("bunny", 9, 1.5),
    ("horse", 1, 10.0),
    ("dragon", 474, 20.0),
];
/// The target gap between strips and lower bound on dragon.
const GAP: (&str, f64) = ("dragon", 0.05);
/// Targets of `best`: the costs per triangle for each of [`PEER_COSTS`], and seconds.
const BEST_TARGETS: [(&str, [f64; 3], f64); 5] = [
    ("cow_2904", [1.205, 1.155, 1.25], 5.0),
    ("fandisk", [1.098, 1.074, 1.125], 5.0),
    ("bunny", [1.125, 1.092, 1.16], 5.0),
    ("horse", [1.155, 1.12, 1.19], 5.0),
    ("dragon", [1.27, 1.22, 1.31], 60.0),
];
/// Targets for vertices sent on models with polygons.
const POLYGON_TARGETS: [(&str, usize); 3] =
    [("skyscraper", 4290), ("triceratops", 6430), ("power_lines", 9300)];
/// Efforts with their target costs, and their times relative to the reference.
const LADDER_TARGETS: [(&str, f64, f64); 4] =
    [("best 1", 1.195, 1.0), ("best 3", 1.16, 10.0), ("best 5", 1.135, 100.0), ("best 7", 1.125, 400.0)];
/// The target speedup over the published time.
const FASTER: f64 = 100.0;
/// The target cost relative to the best peer, as a geometric mean.
const MEAN: f64 = 0.94;
const BYTES: f64 = 120.0;

/// Returns the targets for which a search ran.
pub(super) fn compare(outcomes: &[Outcome], searched: &[SearchResults]) -> Vec<Target> {
    let mut targets = fewest(searched);
    targets.extend(guided_tunnels(searched));
    targets.extend(best(searched));
    targets.extend(against_peers(searched));
    targets.extend(against_starts(outcomes));
    targets.extend(memory(outcomes, searched));
    targets
}

fn named<'a>(searched: &'a [SearchResults], model: &str) -> Option<&'a SearchResults> {
    searched.iter().find(|s| s.model == model)
}

/// Returns a target for a value and for its time.
fn timed(what: String, target: (String, f64), found: &str, is_reached: bool, seconds: f64) -> Target {
    let (figure, most) = target;
    let met = is_reached && seconds <= most;
    Target {
        what,
        target: format!("≤ {figure} in {most} s"),
        found: format!("{found} in {seconds:.3} s"),
        met,
    }
}

fn fewest(searched: &[SearchResults]) -> Vec<Target> {
    let target = |(model, strips, seconds): (&str, usize, f64)| {
        let row = &named(searched, model)?.fewest.row;
        let what = format!("fewest, strips, {model}");
        let found = row.strips.to_string();
        Some(timed(what, (strips.to_string(), seconds), &found, row.strips <= strips, row.seconds))
    };
    let mut targets: Vec<Target> = FEWEST_TARGETS.into_iter().filter_map(target).collect();
    if let Some(s) = named(searched, GAP.0) {
        targets.push(Target::at_most(
            format!("fewest, fraction of strips beyond the bound, {}", s.model),
            GAP.1,
            s.gap(),
            3,
        ));
    }
    let closed: Vec<&SearchResults> = searched.iter().filter(|s| s.is_closed).collect();
    let more = |s: &&&SearchResults| s.fewest.row.strips > s.bound.max(1);
    let names = closed.iter().filter(more).map(|s| format!("{} {}", s.model, s.fewest.row.strips));
    targets.extend(none(
        "fewest, closed connected models with more strips than their bound",
        names,
        closed.len(),
    ));
    let strips = |s: &SearchResults| Some((s.fewest.row.strips, s.peers.as_ref()?.strips.best));
    let pairs: Vec<_> = searched.iter().filter_map(|s| Some((s, strips(s)?))).collect();
    let worse = pairs.iter().filter(|(_, (ours, best))| *ours as f64 > *best);
    let names = worse.map(|(s, (ours, best))| format!("{} ({ours} to {best})", s.model));
    targets.extend(none("fewest, models with more strips than the best of all peers", names, pairs.len()));
    targets
}

fn guided_tunnels(searched: &[SearchResults]) -> Vec<Target> {
    let target = |s: &SearchResults| {
        let (row, published) = (&s.guided_tunnels.as_ref()?.row, s.published.as_ref()?);
        let what =
            format!("guided-tunnels, the published strips of ETA in a hundredth of the time, {}", s.model);
        let most = (published.strips.to_string(), published.seconds / FASTER);
        Some(timed(what, most, &row.strips.to_string(), row.strips as f64 <= published.strips, row.seconds))
    };
    searched.iter().filter_map(target).collect()
}

fn best(searched: &[SearchResults]) -> Vec<Target> {
    let mut targets = Vec::new();
    for (model, costs, seconds) in BEST_TARGETS {
        let Some(s) = named(searched, model) else { continue };
        for ((cost, most), search) in PEER_COSTS.into_iter().zip(costs).zip(&s.best) {
            let found = per_triangle(&search.row, s.triangles, cost);
            let what = format!("best, {cost} per triangle, {model}");
            let found_text = format!("{found:.4}");
            targets.push(timed(
                what,
                (format!("{most:.3}"), seconds),
                &found_text,
                found <= most,
                search.row.seconds,
            ));
        }
    }
    for (model, most) in POLYGON_TARGETS {
        if let Some(search) = named(searched, model).and_then(|s| s.polygons.as_ref()) {
            let sent = search.row.vertices_sent as f64;
            targets.push(Target::at_most(
                format!("best, vertices sent, {model} as polygons"),
                most as f64,
                sent,
                0,
            ));
        }
    }
    for s in searched {
        for (name, most, most_times) in LADDER_TARGETS {
            let row: Option<&MethodRow> = s.ladder.iter().map(|l| &l.row).find(|row| row.method == name);
            let Some((row, times)) = row.and_then(|row| Some((row, row.time_ratio?))) else { continue };
            let found = row.indices_restart_per_triangle;
            targets.push(Target {
                what: format!("{name}, indices per triangle and time relative to meshoptimizer, {}", s.model),
                target: format!("≤ {most:.3} in {most_times} ×"),
                found: format!("{found:.4} in {times:.2} ×"),
                met: found <= most && times <= most_times,
            });
        }
    }
    targets
}

/// Returns a cost of `best` relative to the best peer, as a geometric mean over the models.
pub fn best_ratio(searched: &[SearchResults], at: usize) -> Option<f64> {
    let ratio = |s: &SearchResults| {
        let (ours, best) = s.pair(s.best.get(at)?, PEER_COSTS[at])?;
        Some(ours / best.best)
    };
    geometric_mean(searched.iter().filter_map(ratio))
}

fn against_peers(searched: &[SearchResults]) -> Vec<Target> {
    let mut targets = Vec::new();
    for (at, cost) in PEER_COSTS.into_iter().enumerate() {
        let of = |s: &SearchResults| {
            let (ours, best) = s.pair(s.best.get(at)?, cost)?;
            Some((s.model.clone(), ours, best.best))
        };
        let pairs: Vec<_> = searched.iter().filter_map(of).collect();
        let names = pairs.iter().filter(|(_, ours, best)| *ours > best + ROUNDING);
        let names = names.map(|(model, ours, best)| format!("{model} ({ours:.4} to {best:.4})"));
        let name = cost.name();
        targets.extend(none(
            &format!("best, models with a higher cost than the best of all peers, {name}"),
            names,
            pairs.len(),
        ));
        if let Some(mean) = best_ratio(searched, at) {
            let what = format!("best, {name} cost relative to the best of all peers, geometric mean");
            targets.push(Target::at_most(what, MEAN, mean, 2));
        }
    }
    targets
}

fn against_starts(outcomes: &[Outcome]) -> Option<Target> {
    let cost = |o: &Outcome, method| Some(o.row(method)?.indices_restart_per_triangle);
    let pair = |o: &Outcome| {
        let start =
            ["input", "sequential", "quad-rows"].into_iter().filter_map(|m| cost(o, m)).reduce(f64::min);
        Some((o.model.clone(), cost(o, BEST)?, start?))
    };
    let pairs: Vec<_> = outcomes.iter().filter_map(pair).collect();
    let names = pairs.iter().filter(|(_, ours, start)| ours > start).map(|(model, ..)| model.clone());
    none("best, models with more indices than input, sequential or quad-rows", names, pairs.len())
}

fn memory(outcomes: &[Outcome], searched: &[SearchResults]) -> Vec<Target> {
    let bytes = |row: &MethodRow, model: &str| Some((row.extra_bytes_per_triangle?, model.to_owned()));
    let target = |method: &str, all: &mut dyn Iterator<Item = (f64, String)>| {
        let (bytes, model) = all.max_by(|a, b| a.0.total_cmp(&b.0))?;
        let what = format!("{method}, bytes per triangle beyond input and output, most of all ({model})");
        Some(Target::at_most(what, BYTES, bytes, 0))
    };
    let mut targets = Vec::new();
    for method in [BEST, FEWEST, GUIDED_TUNNELS] {
        let mut all = outcomes.iter().filter_map(|o| bytes(o.row(method)?, &o.model));
        targets.extend(target(method, &mut all));
    }
    let mut longer = searched.iter().flat_map(|s| {
        let all = s.best.iter().chain(&s.guided_tunnels).chain([&s.fewest]);
        all.filter_map(|search| bytes(&search.row, &s.model)).collect::<Vec<_>>()
    });
    targets.extend(target("every longer search", &mut longer));
    targets
}
