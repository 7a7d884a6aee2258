//! Tables for a terminal and for Markdown, with the same columns.

use std::fmt::Write as _;

use tristrip_render::text;

use crate::measure::{MethodRow, Outcome};
use crate::scaling::Scaling;
use crate::searches::SearchResults;
use crate::targets::Target;
use crate::vertex_caches::{CachePoint, CacheResults};

/// A table: text columns first, then columns of numbers.
#[derive(Debug, Clone)]
pub struct Table {
    heads: Vec<String>,
    text_columns: usize,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Creates a table whose first columns are text, aligned left.
    pub fn new(text_columns: usize, heads: &[impl ToString]) -> Self {
        Self { heads: heads.iter().map(ToString::to_string).collect(), text_columns, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn push(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// Writes the table with aligned columns.
    pub fn aligned(&self) -> String {
        let mut rows = self.with_heads();
        rows.iter_mut().filter_map(|row| row.first_mut()).for_each(|cell| cell.insert_str(0, "  "));
        text::table(&rows, self.text_columns..self.heads.len())
    }

    /// Writes the table as Markdown.
    pub fn markdown(&self) -> String {
        text::markdown(&self.with_heads(), self.text_columns..self.heads.len())
    }

    fn with_heads(&self) -> Vec<Vec<String>> {
        std::iter::once(self.heads.clone()).chain(self.rows.iter().cloned()).collect()
    }
}

/// Returns all measurements of one model as text.
pub fn outcome(outcome: &Outcome) -> String {
    let fed = if outcome.polygons { "polygons" } else { "triangles" };
    let mut out = format!("{}, {} triangles, fed as {fed}\n", outcome.model, outcome.triangles);
    let mut table = Table::new(
        1,
        &[
            "method",
            "proven",
            "strips",
            "isolated",
            "swaps",
            "vertices_sent",
            "gl_cost",
            "restart/T",
            "degenerate/T",
            "ms",
            "ratio",
            "bytes/T",
        ],
    );
    for row in &outcome.rows {
        table.push(cells(row));
    }
    out.push_str(&table.aligned());
    if let Some(peers) = &outcome.peers {
        let best = [
            ("restart/T in one pass", &peers.one_pass_indices_restart_per_triangle),
            ("restart/T", &peers.indices_restart_per_triangle),
            ("degenerate/T", &peers.indices_degenerate_per_triangle),
            ("vertices/T", &peers.vertices_per_triangle),
            ("strips", &peers.strips),
        ];
        for (figure, best) in best {
            let _ = writeln!(out, "  best of all peers, {figure}: {} ({})", best.best, best.by);
        }
    }
    out
}

/// Returns the results of the searches on a model as text.
pub fn searched(searched: &SearchResults) -> String {
    let mut table =
        Table::new(1, &["search", "strips", "restart/T", "degenerate/T", "vertices_sent", "s", "bytes/T"]);
    let all = [&searched.fewest].into_iter().chain(&searched.guided_tunnels).chain(&searched.best);
    for search in all.chain(&searched.polygons).chain(&searched.ladder) {
        let row = &search.row;
        table.push(vec![
            row.method.clone(),
            row.strips.to_string(),
            format!("{:.4}", row.indices_restart_per_triangle),
            format!("{:.4}", row.indices_degenerate_per_triangle),
            row.vertices_sent.to_string(),
            format!("{:.3}", row.seconds),
            optional(row.extra_bytes_per_triangle, 1),
        ]);
    }
    format!("{}, searches; lower bound: {} strips\n{}", searched.model, searched.bound, table.aligned())
}

/// Returns indices and misses of a model as text: meshoptimizer's results, with our results that
/// beat them.
pub fn caches(caches: &CacheResults) -> String {
    let mut table =
        Table::new(1, &["vertex cache", "restart/T", "ACMR", "s", "fewer indices", "fewer misses"]);
    let meshoptimizer = caches.meshoptimizer.iter().map(|theirs| {
        let by = |point: Option<&CachePoint>| point.map_or("–".into(), |point| point.by.clone());
        (theirs, [by(caches.fewer_indices(theirs)), by(caches.fewer_misses(theirs))])
    });
    for (point, beaten_by) in
        meshoptimizer.chain(caches.ours.iter().map(|point| (point, <[String; 2]>::default())))
    {
        let mut cells = vec![point.by.clone()];
        cells.extend([point.indices, point.misses].map(|n| format!("{:.4}", caches.per_triangle(n))));
        cells.push(format!("{:.3}", point.seconds));
        cells.extend(beaten_by);
        table.push(cells);
    }
    let mut out = format!("{}, {}\n{}", caches.model, crate::vertex_caches::REFERENCE_CACHE, table.aligned());
    for simulator in &caches.simulators {
        let millions = simulator.indices_per_second / 1e6;
        let _ = writeln!(
            out,
            "  {} simulated, million indices per second: {millions:.0}",
            simulator.vertex_cache
        );
    }
    out
}

fn cells(row: &MethodRow) -> Vec<String> {
    vec![
        row.method.clone(),
        if row.proven { "yes" } else { "no" }.into(),
        row.strips.to_string(),
        row.isolated.to_string(),
        row.swaps.to_string(),
        row.vertices_sent.to_string(),
        row.gl_cost.to_string(),
        format!("{:.4}", row.indices_restart_per_triangle),
        format!("{:.4}", row.indices_degenerate_per_triangle),
        format!("{:.3}", 1e3 * row.seconds),
        optional(row.time_ratio, 2),
        optional(row.extra_bytes_per_triangle, 1),
    ]
}

/// Formats a number with this number of decimal digits, or a dash.
pub fn optional(figure: Option<f64>, digits: usize) -> String {
    figure.map_or("–".into(), |figure| format!("{figure:.digits$}"))
}

/// Returns the table of targets.
pub fn targets(targets: &[Target]) -> Table {
    let mut table = Table::new(4, &["measured", "target", "result", "met"]);
    for target in targets {
        let met = if target.met { "yes" } else { "NO" };
        table.push(vec![target.what.clone(), target.target.clone(), target.found.clone(), met.into()]);
    }
    table
}

/// Returns the table of levels of a subdivided model.
pub fn scaling(scaling: &Scaling) -> Table {
    let mut table = Table::new(0, &["triangles", "restart/T", "ns/T"]);
    for level in &scaling.levels {
        table.push(vec![
            level.triangles.to_string(),
            format!("{:.4}", level.indices_restart_per_triangle),
            format!("{:.1}", level.nanoseconds_per_triangle),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_align_and_mark_down() {
        let mut table = Table::new(1, &["name", "n"]);
        table.push(vec!["cow".into(), "1000".into()]);
        assert_eq!(table.aligned(), "  name     n\n  cow   1000\n");
        assert_eq!(table.markdown(), "| name | n |\n|---|---:|\n| cow | 1000 |\n");
    }
}
