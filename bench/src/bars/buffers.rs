//! The bars of vertex buffers: meshoptimizer's points beaten, indices and misses, and speeds.

use super::{Bar, none, row};
use crate::buffers::{Buffered, Point};
use crate::measure::Outcome;
use crate::methods::CACHE;

/// Models on which every point of meshoptimizer is to be beaten both ways.
const BEATEN: [&str; 5] = ["bunny", "horse", "armadillo_43k", "fandisk", "dragon"];
/// A model, a setting, its misses and its indices a triangle.
const POINTS: [(&str, &str, f64, f64); 2] =
    [("bunny", "cache fifo:16 misses", 0.72, 1.55), ("bunny", CACHE, 0.80, 1.33)];
/// Models on which `cache` is to make a million triangles a second or more.
const TIMED: [&str; 3] = ["bunny", "horse", "dragon"];
const TRIANGLES_PER_SECOND: f64 = 1e6;
const INDICES_PER_SECOND: f64 = 1e8;

/// Lists the bars of which something was measured.
pub(super) fn judge(outcomes: &[Outcome], buffered: &[Buffered]) -> Vec<Bar> {
    let named = |model: &str| buffered.iter().find(|b| b.model == model);
    let mut bars: Vec<Bar> = BEATEN.into_iter().filter_map(|model| beaten(named(model)?)).collect();
    bars.extend(POINTS.into_iter().filter_map(|(model, setting, acmr, indices)| {
        let found = named(model)?;
        Some(point(found, found.setting(setting)?, acmr, indices))
    }));
    bars.extend(speeds(outcomes));
    bars.extend(buffered.iter().flat_map(simulators));
    bars
}

fn beaten(found: &Buffered) -> Option<Bar> {
    let missed = found.rivals.iter().filter(|rival| !found.beats(rival)).map(|rival| rival.by.clone());
    let what =
        format!("points of meshoptimizer that are not beaten in indices and in misses, {}", found.model);
    none(&what, missed, found.rivals.len())
}

fn point(found: &Buffered, point: &Point, most_misses: f64, most_indices: f64) -> Bar {
    let [misses, indices] = [point.misses, point.indices].map(|count| found.per_triangle(count));
    Bar {
        what: format!("{}, ACMR at indices a triangle, {}", point.by, found.model),
        bar: format!("≤ {most_misses:.2} at ≤ {most_indices:.2}"),
        found: format!("{misses:.4} at {indices:.4}"),
        met: misses <= most_misses && indices <= most_indices,
    }
}

fn speeds(outcomes: &[Outcome]) -> Vec<Bar> {
    let bar = |model: &str| {
        let row = row(outcomes, model, false, CACHE)?;
        let triangles = outcomes.iter().find(|o| o.model == model && !o.polygons)?.triangles;
        let what = format!("{CACHE}, million triangles a second, {model}");
        let speed = triangles as f64 / row.seconds;
        Some(Bar::at_least(what, TRIANGLES_PER_SECOND / 1e6, speed / 1e6, 1))
    };
    TIMED.into_iter().filter_map(bar).collect()
}

fn simulators(found: &Buffered) -> Vec<Bar> {
    let bar = |simulator: &crate::buffers::Simulator| {
        let what = format!("{} simulated, million indices a second, {}", simulator.buffer, found.model);
        Bar::at_least(what, INDICES_PER_SECOND / 1e6, simulator.indices_per_second / 1e6, 0)
    };
    found.simulators.iter().map(bar).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::buffers::Simulator;

    #[test]
    fn bars_tell_beaten_from_not_beaten() {
        let point = |by: &str, indices, misses| Point {
            by: by.into(),
            proven: true,
            indices,
            misses,
            misses_fifo_15: misses,
            seconds: 0.1,
        };
        let simulators = vec![Simulator { buffer: "fifo:16".into(), indices_per_second: 9e7 }];
        let bunny = Buffered {
            model: "bunny".into(),
            triangles: 100,
            rivals: vec![point("weak", 150, 90), point("strong", 120, 70)],
            ours: vec![point(CACHE, 130, 80), point("cache fifo:16 misses", 156, 60)],
            simulators,
        };
        let bars = judge(&[], &[bunny]);
        let found: Vec<_> = bars.iter().map(|bar| (bar.bar.as_str(), bar.found.as_str(), bar.met)).collect();
        let expected = [
            ("none", "1 of 2: strong", false),
            ("≤ 0.72 at ≤ 1.55", "0.6000 at 1.5600", false),
            ("≤ 0.80 at ≤ 1.33", "0.8000 at 1.3000", true),
            ("≥ 100", "90.0", false),
        ];
        assert_eq!(found, expected);
    }
}
