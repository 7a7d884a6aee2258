//! The targets for vertex caches: results that beat meshoptimizer's, indices and misses, and
//! speeds.

use super::target::{Target, none, row};
use crate::measure::Outcome;
use crate::methods::CACHE;
use crate::vertex_caches::{CachePoint, CacheResults};

/// The models on which every result of meshoptimizer should be beaten in indices and in misses.
const COMPARED: [&str; 5] = ["bunny", "horse", "armadillo_43k", "fandisk", "dragon"];
/// A model, a setting, its misses and its indices per triangle.
const POINTS: [(&str, &str, f64, f64); 2] =
    [("bunny", "cache fifo:16 misses", 0.72, 1.55), ("bunny", CACHE, 0.80, 1.33)];
/// Models on which `cache` should process at least a million triangles per second.
const TIMED: [&str; 3] = ["bunny", "horse", "dragon"];
const TRIANGLES_PER_SECOND: f64 = 1e6;
const INDICES_PER_SECOND: f64 = 1e8;

/// Returns the targets that have measurements.
pub(super) fn compare(outcomes: &[Outcome], caches: &[CacheResults]) -> Vec<Target> {
    let named = |model: &str| caches.iter().find(|b| b.model == model);
    let mut targets: Vec<Target> = COMPARED.into_iter().filter_map(|model| beaten(named(model)?)).collect();
    targets.extend(POINTS.into_iter().filter_map(|(model, setting, acmr, indices)| {
        let found = named(model)?;
        Some(point(found, found.setting(setting)?, acmr, indices))
    }));
    targets.extend(speeds(outcomes));
    targets.extend(caches.iter().flat_map(simulators));
    targets
}

fn beaten(found: &CacheResults) -> Option<Target> {
    let missed =
        found.meshoptimizer.iter().filter(|theirs| !found.beats(theirs)).map(|theirs| theirs.by.clone());
    let what = format!("points of meshoptimizer not beaten in both indices and misses, {}", found.model);
    none(&what, missed, found.meshoptimizer.len())
}

fn point(found: &CacheResults, point: &CachePoint, most_misses: f64, most_indices: f64) -> Target {
    let [misses, indices] = [point.misses, point.indices].map(|count| found.per_triangle(count));
    Target {
        what: format!("{}, ACMR at indices per triangle, {}", point.by, found.model),
        target: format!("≤ {most_misses:.2} at ≤ {most_indices:.2}"),
        found: format!("{misses:.4} at {indices:.4}"),
        met: misses <= most_misses && indices <= most_indices,
    }
}

fn speeds(outcomes: &[Outcome]) -> Vec<Target> {
    let target = |model: &str| {
        let row = row(outcomes, model, false, CACHE)?;
        let triangles = outcomes.iter().find(|o| o.model == model && !o.polygons)?.triangles;
        let what = format!("{CACHE}, million triangles per second, {model}");
        let speed = triangles as f64 / row.seconds;
        Some(Target::at_least(what, TRIANGLES_PER_SECOND / 1e6, speed / 1e6, 1))
    };
    TIMED.into_iter().filter_map(target).collect()
}

fn simulators(found: &CacheResults) -> Vec<Target> {
    let target = |simulator: &crate::vertex_caches::SimulatorSpeed| {
        let what =
            format!("{} simulated, million indices per second, {}", simulator.vertex_cache, found.model);
        Target::at_least(what, INDICES_PER_SECOND / 1e6, simulator.indices_per_second / 1e6, 0)
    };
    found.simulators.iter().map(target).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertex_caches::SimulatorSpeed;

    #[test]
    fn points_are_beaten_or_not() {
        let point = |by: &str, indices, misses| CachePoint {
            by: by.into(),
            proven: true,
            indices,
            misses,
            misses_fifo_15: misses,
            seconds: 0.1,
        };
        let simulators = vec![SimulatorSpeed { vertex_cache: "fifo:16".into(), indices_per_second: 9e7 }];
        let bunny = CacheResults {
            model: "bunny".into(),
            triangles: 100,
            meshoptimizer: vec![point("weak", 150, 90), point("strong", 120, 70)],
            ours: vec![point(CACHE, 130, 80), point("cache fifo:16 misses", 156, 60)],
            simulators,
        };
        let targets = compare(&[], &[bunny]);
        let found: Vec<_> = targets
            .iter()
            .map(|target| (target.target.as_str(), target.found.as_str(), target.met))
            .collect();
        let expected = [
            ("none", "1 of 2: strong", false),
            ("≤ 0.72 at ≤ 1.55", "0.6000 at 1.5600", false),
            ("≤ 0.80 at ≤ 1.33", "0.8000 at 1.3000", true),
            ("≥ 100", "90.0", false),
        ];
        assert_eq!(found, expected);
    }
}
