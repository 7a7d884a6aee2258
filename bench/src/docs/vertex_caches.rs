//! The page's section on vertex caches.

use std::fmt::Write as _;

use crate::measure::Outcome;
use crate::meshoptimizer::Pipeline;
use crate::methods::CACHE;
use crate::text::{Table, optional};
use crate::vertex_caches::{CachePoint, CacheResults, EFFORT, LARGE, LARGE_EFFORT, REFERENCE_CACHE, beaten};

/// The model for which the smaller cache is shown.
const REMARKED: &str = "bunny";

/// Writes the section as Markdown; empty if there are no results.
pub(super) fn section(outcomes: &[Outcome], caches: &[CacheResults]) -> String {
    if caches.is_empty() {
        return String::new();
    }
    let mut sorted: Vec<&CacheResults> = caches.iter().collect();
    sorted.sort_by(|a, b| (a.triangles, &a.model).cmp(&(b.triangles, &b.model)));
    let mut out = format!(
        "## Vertex cache\n\n`cache` for {REFERENCE_CACHE} by objective, and meshoptimizer in the same run: indices with restarts / misses of this\n\
         vertex cache (ACMR), both per triangle; the cache is kept between strips. *Longer* is effort {EFFORT} ({LARGE_EFFORT} above {} thousand\n\
         triangles); `best` at effort 2 does not consider a cache. The speed is that of `balanced` at the default effort in million triangles per\n\
         second, the ratio its time relative to meshoptimizer's strip order and strips.\n\n{}\n",
        LARGE / 1000,
        points(outcomes, &sorted).markdown()
    );
    let counts = Pipeline::ALL.iter().zip(beaten(caches));
    let counts =
        counts.map(|(pipeline, count)| format!("- {}: {count} of {}\n", pipeline.name(), caches.len()));
    let _ = writeln!(
        out,
        "A point of meshoptimizer is beaten if one of these settings has fewer indices and no more misses, and one has fewer misses\n\
         and no more indices. Number of models on which it is beaten:\n\n{}\nThe largest saving of its indices, and of its misses; a dash if there is none:\n\n{}",
        counts.collect::<String>(),
        savings(&sorted).markdown()
    );
    out.push_str(&remark(caches));
    let speeds = speeds(&sorted);
    if !speeds.is_empty() {
        let _ =
            writeln!(out, "Simulated vertex caches, in million indices per second: {}.\n", speeds.join(", "));
    }
    out
}

fn pair(found: &CacheResults, point: &CachePoint) -> String {
    let [indices, misses] = [point.indices, point.misses].map(|count| found.per_triangle(count));
    format!("{indices:.3} / {misses:.3}")
}

fn points(outcomes: &[Outcome], caches: &[&CacheResults]) -> Table {
    let heads = [
        "model",
        "triangles",
        "meshopt stripify",
        "cache, stripify",
        "strip cache, stripify",
        "indices",
        "balanced",
        "misses",
        "longer indices",
        "longer balanced",
        "longer misses",
        "best 2",
        "M T/s",
        "ratio",
    ];
    let mut table = Table::new(1, &heads);
    for found in caches {
        let mut cells = vec![found.model.clone(), found.triangles.to_string()];
        cells.extend(found.meshoptimizer.iter().chain(&found.ours).map(|point| pair(found, point)));
        let outcome = outcomes.iter().find(|o| o.model == found.model && !o.polygons);
        let row = outcome.and_then(|outcome| outcome.row(CACHE));
        cells.push(optional(row.map(|row| found.triangles as f64 / row.seconds / 1e6), 2));
        cells.push(optional(row.and_then(|row| row.time_ratio), 2));
        table.push(cells);
    }
    table
}

fn savings(caches: &[&CacheResults]) -> Table {
    let heads = [
        "model",
        "meshopt stripify: indices",
        "misses",
        "cache, stripify: indices",
        "misses",
        "strip cache, stripify: indices",
        "misses",
    ];
    let saved = |ours: Option<usize>, theirs: usize| {
        ours.map_or("–".into(), |ours| format!("{:.1} %", 100.0 * (1.0 - ours as f64 / theirs as f64)))
    };
    let mut table = Table::new(1, &heads);
    for found in caches {
        let mut cells = vec![found.model.clone()];
        for theirs in &found.meshoptimizer {
            cells.push(saved(found.fewer_indices(theirs).map(|point| point.indices), theirs.indices));
            cells.push(saved(found.fewer_misses(theirs).map(|point| point.misses), theirs.misses));
        }
        table.push(cells);
    }
    table
}

/// Relates the metrics of the peers to ours.
fn remark(caches: &[CacheResults]) -> String {
    let Some(found) = caches.iter().find(|found| found.model == REMARKED) else {
        return String::new();
    };
    let mut table = Table::new(1, &["ACMR of meshoptimizer", "fifo:16", "fifo:15"]);
    for theirs in &found.meshoptimizer {
        let both = [theirs.misses, theirs.misses_fifo_15];
        let mut cells = vec![theirs.by.clone()];
        cells.extend(both.map(|count| format!("{:.4}", found.per_triangle(count))));
        table.push(cells);
    }
    format!(
        "What the peers' table calls a FIFO cache of 16 has 15 entries by the definition used here. The targets use 16, with\n\
         which meshoptimizer has fewer misses. On {REMARKED}:\n\n{}\n",
        table.markdown()
    )
}

fn speeds(caches: &[&CacheResults]) -> Vec<String> {
    let all = caches.iter().flat_map(|found| found.simulators.iter().map(move |s| (found, s)));
    all.map(|(found, s)| format!("{} {} {:.0}", found.model, s.vertex_cache, s.indices_per_second / 1e6))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_has_every_column_filled() {
        let point = |by: &str, indices, misses| CachePoint {
            by: by.into(),
            proven: true,
            indices,
            misses,
            misses_fifo_15: misses + 1,
            seconds: 0.1,
        };
        let meshoptimizer = Pipeline::ALL.map(|pipeline| point(pipeline.name(), 20, 10)).to_vec();
        let ours = ["a", "b", "c", "d", "e", "f", "g"].map(|by| point(by, 15, 10)).to_vec();
        let found = CacheResults {
            model: REMARKED.into(),
            triangles: 10,
            meshoptimizer,
            ours,
            simulators: Vec::new(),
        };
        let text = section(&[], &[found]);
        let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| ")).collect();
        assert_eq!(
            rows.iter().map(|row| row.matches(" |").count()).collect::<Vec<_>>(),
            [14, 14, 7, 7, 3, 3, 3, 3]
        );
        assert!(rows[3].contains("| 25.0 % | – |"), "{}", rows[3]);
        assert!(rows[5].ends_with("| 1.0000 | 1.1000 |") && !text.contains("Simulated"));
        assert!(section(&[], &[]).is_empty());
    }
}
