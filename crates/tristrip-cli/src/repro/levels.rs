//! Levels of detail as a paper has them: base meshes of 5 % of the triangles, and what each filter sends.
//!
//! Figures of a model, over all levels, each drawn once:
//! - `collapses`, `triangles_base`, `vertices_base`;
//! - `gbits_triangles`, and for each filter `gbits_…`: the vertices sent, in the published unit ([`gigabits`]);
//! - `percent_…`: of the vertices sent as single triangles; `percent_base_…` and `percent_full_…`: at the base mesh and the full one;
//! - `saving_dtfs`: how many percent dtfs sends less than stss;
//! - `crossing_stss`: up to which percent of the levels stss sends more than single triangles, in steps of 1 %;
//! - `updates_naive`, `updates_encoded`: places that a vertex split writes on the average;
//! - `saving_updates`, `saving_bytes`: how many percent the symbols save, of places and of bytes.
//!
//! Curves by level: `triangles` and the filters' names for vertices sent, `updates_naive` and `updates_encoded` for each 5 %.

use std::collections::BTreeMap;

use clap::ValueEnum;
use tristrip::Strips;
use tristrip::lod::filter::repair;
use tristrip::lod::traffic::gigabits;

use crate::failure::Failure;
use crate::lod::{Detail, Levels, Refinement, Row, Sent, rows, totals};
use crate::simplify::{Part, simplify_all};
use crate::stages::{Pool, Prepared};
use crate::values::{Amount, FilterName, Ratio};

/// The share of the triangles that the paper's base meshes have.
const BASE: &str = "5%";
/// Steps of the curves, and levels of each average of updates.
const CURVE_STEPS: usize = 100;
const BIN_STEPS: usize = 20;

/// Figures and curves of levels by their names.
#[derive(Debug, Default)]
pub(super) struct LevelsFound {
    pub(super) figures: BTreeMap<String, f64>,
    pub(super) curves: BTreeMap<String, Vec<(f64, f64)>>,
}

/// Measures the levels of a model whose full mesh these strips draw.
///
/// # Errors
/// A level is not proven.
pub(super) fn measure(
    parts: &[Prepared<'_>],
    strips: &[Strips],
    pool: &Pool,
) -> Result<LevelsFound, Failure> {
    // 1. The collapses.
    let meshes = parts.iter().map(|part| part.mesh);
    let parts = Part::of_all(meshes.zip(strips.iter().map(Strips::to_list)).collect())?;
    let triangles: Vec<usize> = parts.iter().map(Part::triangle_count).collect();
    let base = BASE.parse::<Ratio>().map_err(Failure::Input)?;
    let done = simplify_all(pool, &parts, &Amount::Ratio(base).shares(&triangles), None)?;
    let details = parts.into_iter().zip(strips).zip(done);
    let details = details.map(|((part, strips), done)| Detail::new(part.compact, strips, done));
    let details: Vec<Detail<'_>> = details.collect();
    let levels = Levels::new(details.iter().map(Detail::sequence).collect());

    // 2. What is sent.
    let repair = repair::Options::default();
    let curve = rows(pool, &details, &levels, &levels.evenly(CURVE_STEPS), repair, true)?;
    let mut found = LevelsFound::default();
    found.add("collapses", levels.len() as f64);
    found.add("triangles_base", levels.triangle_count(&levels.of_parts(0)) as f64);
    let used = |detail: &Detail<'_>| {
        let mut used = detail.left(0);
        used.sort_unstable();
        used.dedup();
        used.len()
    };
    found.add("vertices_base", details.iter().map(used).sum::<usize>() as f64);
    for total in totals(pool, &details, &levels, repair)? {
        found.add(&format!("gbits_{}", total.filter), gigabits(total.vertices_sent));
        found.add(&format!("percent_{}", total.filter), total.percent);
    }
    found.add_saving("saving_dtfs", "percent_dtfs", "percent_stss");
    if let [first, .., last] = &curve[..] {
        found.add_ends(first, last);
    }
    let above =
        curve.iter().filter(|row| filters(&row.vertices_sent)["stss"] > row.vertices_sent.triangles as f64);
    found.add("crossing_stss", above.map(|row| row.percent).fold(0.0, f64::max));

    // 3. What is written.
    let all = Refinement::between(&details, &levels, 0, levels.len())?;
    found.add("updates_naive", all.updates_naive);
    found.add("updates_encoded", all.updates_encoded);
    found.add_saving("saving_updates", "updates_encoded", "updates_naive");
    let saved = 100.0 * (1.0 - all.bytes_encoded as f64 / all.bytes_naive.max(1) as f64);
    found.add("saving_bytes", saved);
    found.add_curve(&curve);
    found.add_bins(&details, &levels)?;
    Ok(found)
}

/// Names what every filter sends.
fn filters(sent: &Sent) -> BTreeMap<String, f64> {
    let names = FilterName::value_variants().iter().map(|filter| filter.name());
    names.zip(sent.by_filter.iter().map(|&sent| sent as f64)).collect()
}

impl LevelsFound {
    fn add(&mut self, name: &str, figure: f64) {
        self.figures.insert(name.into(), figure);
    }

    /// Adds how many percent one figure is below another.
    fn add_saving(&mut self, name: &str, of: &str, than: &str) {
        if let (Some(of), Some(than)) = (self.figures.get(of), self.figures.get(than))
            && *than > 0.0
        {
            self.add(name, 100.0 * (1.0 - of / than));
        }
    }

    /// Adds the costs of the base mesh and of the full one.
    fn add_ends(&mut self, base: &Row, full: &Row) {
        for (end, row) in [("base", base), ("full", full)] {
            for (filter, sent) in filters(&row.vertices_sent) {
                let percent = 100.0 * sent / row.vertices_sent.triangles.max(1) as f64;
                self.add(&format!("percent_{end}_{filter}"), percent);
            }
        }
    }

    fn point(&mut self, name: &str, point: (f64, f64)) {
        self.curves.entry(name.into()).or_default().push(point);
    }

    /// Adds what is sent at each level.
    fn add_curve(&mut self, rows: &[Row]) {
        for row in rows {
            self.point("triangles", (row.percent, row.vertices_sent.triangles as f64));
            for (name, sent) in filters(&row.vertices_sent) {
                self.point(&name, (row.percent, sent));
            }
        }
    }

    /// Adds what is written on the average over so many levels each.
    fn add_bins(&mut self, details: &[Detail<'_>], levels: &Levels<'_>) -> Result<(), Failure> {
        for pair in levels.evenly(BIN_STEPS).windows(2) {
            let all = Refinement::between(details, levels, pair[0], pair[1])?;
            let middle = 50.0 * (pair[0] + pair[1]) as f64 / levels.len() as f64;
            self.point("updates_naive", (middle, all.updates_naive));
            self.point("updates_encoded", (middle, all.updates_encoded));
        }
        Ok(())
    }
}
