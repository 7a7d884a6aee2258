//! Tables for people: the same columns on a terminal and in Markdown.

use std::fmt::Write as _;

use crate::bars::Bar;
use crate::buffers::{Buffered, Point};
use crate::measure::{Outcome, Row};
use crate::scaling::Scaling;
use crate::searches::Searched;

/// A table; the first column is text, the others are figures unless told otherwise.
#[derive(Debug, Clone)]
pub struct Table {
    heads: Vec<&'static str>,
    text_columns: usize,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Makes a table of which the first columns hold text, aligned left.
    pub fn new(text_columns: usize, heads: &[&'static str]) -> Self {
        Self { heads: heads.to_vec(), text_columns, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn push(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// Writes the table with aligned columns.
    pub fn aligned(&self) -> String {
        let wide = |i: usize| {
            let cells = self.rows.iter().filter_map(|row| row.get(i)).map(|cell| cell.chars().count());
            cells.chain([self.heads[i].chars().count()]).max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.heads.len()).map(wide).collect();
        let heads: Vec<String> = self.heads.iter().map(ToString::to_string).collect();
        let mut out = String::new();
        for row in std::iter::once(&heads).chain(&self.rows) {
            let mut line = String::from(" ");
            for (i, cell) in row.iter().enumerate() {
                let pad = " ".repeat(widths[i].saturating_sub(cell.chars().count()));
                let (before, after) =
                    if i < self.text_columns { ("", pad.as_str()) } else { (pad.as_str(), "") };
                let _ = write!(line, " {before}{cell}{after} ");
            }
            out.push_str(line.trim_end());
            out.push('\n');
        }
        out
    }

    /// Writes the table as Markdown.
    pub fn markdown(&self) -> String {
        let mut out = format!("| {} |\n|", self.heads.join(" | "));
        (0..self.heads.len())
            .for_each(|i| out.push_str(if i < self.text_columns { "---|" } else { "---:|" }));
        out.push('\n');
        for row in &self.rows {
            let _ = writeln!(out, "| {} |", row.join(" | "));
        }
        out
    }
}

/// Shows everything that was measured of one model.
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

/// Shows what was searched on a model.
pub fn searched(searched: &Searched) -> String {
    let mut table =
        Table::new(1, &["search", "strips", "restart/T", "degenerate/T", "vertices_sent", "s", "bytes/T"]);
    let all = [&searched.fewest].into_iter().chain(&searched.eta).chain(&searched.best);
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
    format!("{}, searches; at least {} strips\n{}", searched.model, searched.bound, table.aligned())
}

/// Shows indices and misses of a model, meshoptimizer's points with what beats them.
pub fn buffered(buffered: &Buffered) -> String {
    let mut table =
        Table::new(1, &["vertex buffer", "restart/T", "ACMR", "s", "fewer indices", "fewer misses"]);
    let rivals = buffered.rivals.iter().map(|rival| {
        let by = |point: Option<&Point>| point.map_or("–".into(), |point| point.by.clone());
        (rival, [by(buffered.fewer_indices(rival)), by(buffered.fewer_misses(rival))])
    });
    for (point, beaten_by) in
        rivals.chain(buffered.ours.iter().map(|point| (point, <[String; 2]>::default())))
    {
        let mut cells = vec![point.by.clone()];
        cells.extend([point.indices, point.misses].map(|n| format!("{:.4}", buffered.per_triangle(n))));
        cells.push(format!("{:.3}", point.seconds));
        cells.extend(beaten_by);
        table.push(cells);
    }
    let mut out = format!("{}, {}\n{}", buffered.model, crate::buffers::BUFFER, table.aligned());
    for simulator in &buffered.simulators {
        let millions = simulator.indices_per_second / 1e6;
        let _ = writeln!(out, "  {} simulated, million indices a second: {millions:.0}", simulator.buffer);
    }
    out
}

fn cells(row: &Row) -> Vec<String> {
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

/// Writes a figure with so many digits after the point, or a dash.
pub fn optional(figure: Option<f64>, digits: usize) -> String {
    figure.map_or("–".into(), |figure| format!("{figure:.digits$}"))
}

/// Lists the bars.
pub fn bars(bars: &[Bar]) -> Table {
    let mut table = Table::new(4, &["what", "bar", "measured", "met"]);
    for bar in bars {
        let met = if bar.met { "yes" } else { "NO" };
        table.push(vec![bar.what.clone(), bar.bar.clone(), bar.found.clone(), met.into()]);
    }
    table
}

/// Lists the levels of a subdivided model.
pub fn scaling(scaling: &Scaling) -> Table {
    let mut table = Table::new(0, &["triangles", "restart/T", "ns a triangle"]);
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
