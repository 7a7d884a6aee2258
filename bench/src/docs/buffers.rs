//! The page's section on vertex buffers.

use std::fmt::Write as _;

use crate::buffers::{BUFFER, Buffered, EFFORT, LARGE, LARGE_EFFORT, Point, beaten};
use crate::measure::Outcome;
use crate::methods::CACHE;
use crate::rivals::Pipeline;
use crate::text::{Table, optional};

/// The model on which the smaller buffer is shown.
const REMARKED: &str = "bunny";

/// Writes the section as Markdown; nothing where nothing was searched.
pub(super) fn section(outcomes: &[Outcome], buffered: &[Buffered]) -> String {
    if buffered.is_empty() {
        return String::new();
    }
    let mut sorted: Vec<&Buffered> = buffered.iter().collect();
    sorted.sort_by(|a, b| (a.triangles, &a.model).cmp(&(b.triangles, &b.model)));
    let mut out = format!(
        "## Vertex buffer\n\n`cache` for {BUFFER} by what it prefers, next to meshoptimizer in the same run: indices with restarts / misses of this\n\
         buffer (ACMR), both a triangle; the buffer keeps its vertices from strip to strip. *Longer* is effort {EFFORT} ({LARGE_EFFORT} above {} thousand\n\
         triangles); `best` at effort 2 knows of no buffer. The speed is that of `balanced` at the usual effort in million triangles a\n\
         second, the ratio its time by that of meshoptimizer's strip order and strips.\n\n{}\n",
        LARGE / 1000,
        points(outcomes, &sorted).markdown()
    );
    let counts = Pipeline::ALL.iter().zip(beaten(buffered));
    let counts =
        counts.map(|(pipeline, count)| format!("- {}: {count} of {}\n", pipeline.name(), buffered.len()));
    let _ = writeln!(
        out,
        "A point of meshoptimizer is beaten where one of these settings has fewer indices at no more misses, and one fewer misses\n\
         at no more indices. Models on which it is:\n\n{}\nThe most of its indices, and of its misses, that is saved so; a dash where nothing is:\n\n{}",
        counts.collect::<String>(),
        savings(&sorted).markdown()
    );
    out.push_str(&remark(buffered));
    let speeds = speeds(&sorted);
    if !speeds.is_empty() {
        let _ = writeln!(out, "Simulated buffers, in million indices a second: {}.\n", speeds.join(", "));
    }
    out
}

fn pair(found: &Buffered, point: &Point) -> String {
    let [indices, misses] = [point.indices, point.misses].map(|count| found.per_triangle(count));
    format!("{indices:.3} / {misses:.3}")
}

fn points(outcomes: &[Outcome], buffered: &[&Buffered]) -> Table {
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
    for found in buffered {
        let mut cells = vec![found.model.clone(), found.triangles.to_string()];
        cells.extend(found.rivals.iter().chain(&found.ours).map(|point| pair(found, point)));
        let outcome = outcomes.iter().find(|o| o.model == found.model && !o.polygons);
        let row = outcome.and_then(|outcome| outcome.row(CACHE));
        cells.push(optional(row.map(|row| found.triangles as f64 / row.seconds / 1e6), 2));
        cells.push(optional(row.and_then(|row| row.time_ratio), 2));
        table.push(cells);
    }
    table
}

fn savings(buffered: &[&Buffered]) -> Table {
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
    for found in buffered {
        let mut cells = vec![found.model.clone()];
        for rival in &found.rivals {
            cells.push(saved(found.fewer_indices(rival).map(|point| point.indices), rival.indices));
            cells.push(saved(found.fewer_misses(rival).map(|point| point.misses), rival.misses));
        }
        table.push(cells);
    }
    table
}

/// Says how the peers' figures go with these.
fn remark(buffered: &[Buffered]) -> String {
    let Some(found) = buffered.iter().find(|found| found.model == REMARKED) else {
        return String::new();
    };
    let mut table = Table::new(1, &["ACMR of meshoptimizer", "fifo:16", "fifo:15"]);
    for rival in &found.rivals {
        let both = [rival.misses, rival.misses_fifo_15];
        let mut cells = vec![rival.by.clone()];
        cells.extend(both.map(|count| format!("{:.4}", found.per_triangle(count))));
        table.push(cells);
    }
    format!(
        "What the peers' table calls a FIFO buffer of 16 has 15 places by the definition used here. The bars are judged by 16, with\n\
         which meshoptimizer misses less. On {REMARKED}:\n\n{}\n",
        table.markdown()
    )
}

fn speeds(buffered: &[&Buffered]) -> Vec<String> {
    let all = buffered.iter().flat_map(|found| found.simulators.iter().map(move |s| (found, s)));
    all.map(|(found, s)| format!("{} {} {:.0}", found.model, s.buffer, s.indices_per_second / 1e6)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_has_every_column_filled() {
        let point = |by: &str, indices, misses| Point {
            by: by.into(),
            proven: true,
            indices,
            misses,
            misses_fifo_15: misses + 1,
            seconds: 0.1,
        };
        let rivals = Pipeline::ALL.map(|pipeline| point(pipeline.name(), 20, 10)).to_vec();
        let ours = ["a", "b", "c", "d", "e", "f", "g"].map(|by| point(by, 15, 10)).to_vec();
        let found = Buffered { model: REMARKED.into(), triangles: 10, rivals, ours, simulators: Vec::new() };
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
