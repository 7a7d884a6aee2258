//! The page's section on the searches.

use std::fmt::Write as _;

use crate::searches::{PEER_COSTS, SearchEffort, SearchResults, SearchRow, per_triangle};
use crate::targets::best_ratio;
use crate::text::Table;

/// Writes the section as Markdown; empty if there are no results.
pub(super) fn section(searched: &[SearchResults], depth: SearchEffort) -> String {
    if searched.is_empty() {
        return String::new();
    }
    let mut sorted: Vec<&SearchResults> = searched.iter().collect();
    sorted.sort_by(|a, b| (a.triangles, &a.model).cmp(&(b.triangles, &b.model)));
    let mut out = format!(
        "## Fewest strips\n\n`fewest` at effort {} on one thread; *bound* is a lower bound on the number of strips, *gap* the fraction of strips beyond it.\n\
         Published figures of ETA are from 2006, on a computer of that time.\n\n{}\n{}\n",
        depth.fewest,
        published(&sorted).markdown(),
        fewest(&sorted).markdown()
    );
    let means = PEER_COSTS.into_iter().enumerate().filter_map(|(at, cost)| {
        let below = 100.0 * (1.0 - best_ratio(searched, at)?);
        Some(format!("{} {below:.1} %", cost.name()))
    });
    let _ = writeln!(
        out,
        "## Cheapest indices\n\n`best` for each cost, indices or vertices per triangle, at effort {} (one lower above 80,000 triangles, two above 300,000),\n\
         compared with the best of all peers, including slow ones. Saving in the geometric mean: {}.\n\n{}",
        depth.best,
        means.collect::<Vec<_>>().join(", "),
        best(&sorted).markdown()
    );
    let _ = writeln!(out, "{}", ladder(&sorted).markdown());
    let _ = writeln!(out, "{}", polygons(&sorted).markdown());
    out
}

fn seconds(search: &SearchRow) -> String {
    format!("{:.3}", search.row.seconds)
}

fn published(searched: &[&SearchResults]) -> Table {
    let heads = ["model", "by", "strips", "isolated", "ACMR 32", "vertices/T", "seconds", "bound", "gap"];
    let mut table = Table::new(2, &heads);
    for s in searched {
        let (Some(paper), Some(guided)) = (&s.published, &s.guided_tunnels) else { continue };
        let model = format!("{} ({} T)", s.model, s.triangles);
        table.push(vec![
            model,
            "ETA, published".into(),
            paper.strips.to_string(),
            paper.isolated.to_string(),
            format!("{:.2}", paper.acmr_32),
            format!("{:.2}", paper.vertices_per_triangle),
            paper.seconds.to_string(),
            String::new(),
            String::new(),
        ]);
        for (by, search) in [("guided-tunnels", guided), ("fewest", &s.fewest)] {
            let row = &search.row;
            let beyond = row.strips.saturating_sub(s.bound) as f64 / row.strips.max(1) as f64;
            table.push(vec![
                String::new(),
                by.into(),
                row.strips.to_string(),
                row.isolated.to_string(),
                format!("{:.2}", search.acmr_fifo_32),
                format!("{:.2}", row.vertices_sent as f64 / s.triangles as f64),
                seconds(search),
                s.bound.to_string(),
                format!("{:.1} %", 100.0 * beyond),
            ]);
        }
    }
    table
}

fn fewest(searched: &[&SearchResults]) -> Table {
    let heads = [
        "model",
        "best of all peers by",
        "triangles",
        "its strips",
        "fewest",
        "bound",
        "gap",
        "seconds",
        "isolated",
        "vertices/T",
        "ACMR 32",
    ];
    let mut table = Table::new(2, &heads);
    for s in searched {
        let row = &s.fewest.row;
        let peer = s.peers.as_ref().map(|peers| &peers.strips);
        table.push(vec![
            s.model.clone(),
            peer.map_or("–".into(), |best| best.by.clone()),
            s.triangles.to_string(),
            peer.map_or("–".into(), |best| best.best.to_string()),
            row.strips.to_string(),
            s.bound.to_string(),
            format!("{:.1} %", 100.0 * s.gap()),
            seconds(&s.fewest),
            row.isolated.to_string(),
            format!("{:.3}", row.vertices_sent as f64 / s.triangles as f64),
            format!("{:.3}", s.fewest.acmr_fifo_32),
        ]);
    }
    table
}

fn ladder(searched: &[&SearchResults]) -> Table {
    let mut table = Table::new(2, &["model", "method", "restart/T", "seconds", "time / meshoptimizer"]);
    for s in searched {
        for search in &s.ladder {
            table.push(vec![
                s.model.clone(),
                search.row.method.clone(),
                format!("{:.4}", search.row.indices_restart_per_triangle),
                seconds(search),
                crate::text::optional(search.row.time_ratio, 2),
            ]);
        }
    }
    table
}

fn polygons(searched: &[&SearchResults]) -> Table {
    let mut table =
        Table::new(1, &["model, as polygons", "strips", "vertices sent", "vertices/T", "seconds"]);
    for s in searched {
        if let Some(search) = &s.polygons {
            table.push(vec![
                s.model.clone(),
                search.row.strips.to_string(),
                search.row.vertices_sent.to_string(),
                format!("{:.4}", search.row.vertices_sent as f64 / s.triangles as f64),
                seconds(search),
            ]);
        }
    }
    table
}

fn best(searched: &[&SearchResults]) -> Table {
    let heads =
        ["model", "triangles", "restart", "peer", "s", "opengl", "peer", "s", "degenerate", "peer", "s"];
    let mut table = Table::new(1, &heads);
    for s in searched {
        let mut cells = vec![s.model.clone(), s.triangles.to_string()];
        for (cost, search) in PEER_COSTS.into_iter().zip(&s.best) {
            let peer = s.pair(search, cost).map_or("–".into(), |(_, best)| format!("{:.4}", best.best));
            let ours = per_triangle(&search.row, s.triangles, cost);
            cells.extend([format!("{ours:.4}"), peer, format!("{:.2}", search.row.seconds)]);
        }
        table.push(cells);
    }
    table
}
