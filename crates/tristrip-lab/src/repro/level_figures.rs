//! Levels of detail as in Kim et al. 2005: base meshes with 5 % of the triangles (254 triangles for
//! the cow), and the vertices that each filter sends.
//!
//! Metrics of a model over all levels, each drawn once:
//! - `collapses`, `triangles_base`, `vertices_base`;
//! - `gbits_triangles`, and `gbits_…` for each filter: the vertices sent, in the published unit
//!   ([`gigabits`]);
//! - `percent_…`: the vertices sent in percent of single triangles; `percent_base_…` and
//!   `percent_full_…`: at the base mesh and the full mesh;
//! - `saving_dtfs`: by how many percent dtfs sends less than stss; `saving_triangles_dtfs` and
//!   `saving_full_dtfs`: less than single triangles, over all levels and at the full mesh;
//! - `crossing_stss`: the highest level at which stss sends more than single triangles, in percent,
//!   in steps of 1 %;
//! - `updates_naive`, `updates_encoded`: index-map slots written per vertex split;
//! - `saving_updates` and `saving_bytes`: the percentage of slots and bytes that the encoding
//!   saves; `saving_bytes_with_id`: with two more bytes for the vertex id of each split;
//! - `bytes_naive` and `bytes_encoded`: the bytes of all splits by equation 2, with 12 bytes per
//!   position and 2 per slot. For the transmitted bytes see `wire_figures.rs`.
//!
//! Curves by level: `triangles`; the vertices sent, by the names of the filters; `updates_naive`
//! and `updates_encoded` per 5 %.

use std::collections::BTreeMap;

use tristrip::Strips;
use tristrip::lod::RepairOptions;
use tristrip_pipeline::{PreparedModel, Ratio, levels, levels::LevelPart, levels::ModelLevels};

use super::wire_figures;
use crate::error::Error;
use crate::traffic::{LevelRow, TrafficModel, gigabits, measure_levels, totals};

/// The size of the paper's base meshes, as a ratio of the triangles.
const BASE: &str = "5%";
/// The number of triangles of the cow, whose base mesh has another ratio, and this ratio.
const OTHER_BASE: (usize, &str) = (5804, "4.377%");
/// The number of steps of the curves of vertices sent, and of the averages of updates.
const CURVE_STEPS: usize = 100;
const BIN_STEPS: usize = 20;

/// The bytes of a vertex id.
const ID_BYTES: usize = 2;
/// Metrics and curves of levels, by name.
#[derive(Debug, Default)]
pub(super) struct LevelFigures {
    pub(super) figures: BTreeMap<String, f64>,
    pub(super) curves: BTreeMap<String, Vec<(f64, f64)>>,
}

/// Measures the levels of a model, drawn with the strips of its full mesh. The options select the
/// strips and the collapses.
///
/// # Errors
/// A level is not proven.
pub(super) fn measure(
    prepared: &PreparedModel<'_>,
    strips: &[Strips],
    options: levels::Options,
) -> Result<LevelFigures, Error> {
    // 1. The collapses.
    let (triangles, other) = OTHER_BASE;
    let base = if prepared.mesh_figures().triangles == triangles { other } else { BASE };
    let base = base.parse::<Ratio>().map_err(Error::Data)?;
    let levels = ModelLevels::from_strips(prepared, strips, &options.with_base(base), &())?;
    let traffic = TrafficModel::new(&levels);

    // 2. Vertices sent.
    let repair = RepairOptions::default();
    let curve = measure_levels(&traffic, &levels.order.evenly(CURVE_STEPS), repair, true)?;
    let mut measured = LevelFigures::default();
    measured.add("collapses", levels.collapse_count() as f64);
    measured.add("triangles_base", levels.triangle_count(0)? as f64);
    let base_vertices = |part: &LevelPart| {
        let mut used = part.triangles(0)?;
        used.sort_unstable();
        used.dedup();
        Ok(used.len())
    };
    let base_vertices = levels.parts.iter().map(base_vertices).sum::<Result<usize, Error>>()?;
    measured.add("vertices_base", base_vertices as f64);
    for total in totals(&levels, repair)? {
        measured.add(&format!("gbits_{}", total.filter), gigabits(total.vertices_sent));
        measured.add(&format!("percent_{}", total.filter), total.percent);
    }
    measured.add_saving("saving_dtfs", "percent_dtfs", "percent_stss");
    measured.add_saving("saving_triangles_dtfs", "percent_dtfs", "percent_triangles");
    if let [first, .., last] = &curve[..] {
        measured.add_ends(first, last);
    }
    measured.add_saving("saving_full_dtfs", "percent_full_dtfs", "percent_triangles");
    let above = curve.iter().filter(|row| {
        row.vertices_sent.filters().any(|(name, sent)| name == "stss" && sent > row.vertices_sent.triangles)
    });
    measured.add("crossing_stss", above.map(|row| row.percent).fold(0.0, f64::max));

    // 3. Index-map updates.
    let all = traffic.refinement(0, levels.collapse_count())?;
    measured.add("updates_naive", all.updates_naive);
    measured.add("updates_encoded", all.updates_encoded);
    measured.add("bytes_naive", all.bytes_naive as f64);
    measured.add("bytes_encoded", all.bytes_encoded as f64);
    measured.add_saving("saving_updates", "updates_encoded", "updates_naive");
    let saved = 100.0 * (1.0 - all.bytes_encoded as f64 / all.bytes_naive.max(1) as f64);
    measured.add("saving_bytes", saved);
    let ids = ID_BYTES * all.splits;
    let saved = 100.0 * (1.0 - (all.bytes_encoded + ids) as f64 / (all.bytes_naive + ids).max(1) as f64);
    measured.add("saving_bytes_with_id", saved);
    for (name, bytes) in wire_figures::measure(prepared, &levels)? {
        measured.add(name, bytes);
    }
    measured.add_curve(&curve);
    measured.add_bins(&traffic, &levels)?;
    Ok(measured)
}

impl LevelFigures {
    fn add(&mut self, name: &str, figure: f64) {
        self.figures.insert(name.into(), figure);
    }

    /// Adds the percentage by which one metric is below another.
    fn add_saving(&mut self, name: &str, of: &str, than: &str) {
        if let (Some(of), Some(than)) = (self.figures.get(of), self.figures.get(than))
            && *than > 0.0
        {
            self.add(name, 100.0 * (1.0 - of / than));
        }
    }

    /// Adds the percentages of the base mesh and the full mesh.
    fn add_ends(&mut self, base: &LevelRow, full: &LevelRow) {
        for (end, row) in [("base", base), ("full", full)] {
            for (filter, sent) in row.vertices_sent.filters() {
                let percent = 100.0 * sent as f64 / row.vertices_sent.triangles.max(1) as f64;
                self.add(&format!("percent_{end}_{filter}"), percent);
            }
        }
    }

    fn add_point(&mut self, name: &str, point: (f64, f64)) {
        self.curves.entry(name.into()).or_default().push(point);
    }

    /// Adds the vertices sent at each level.
    fn add_curve(&mut self, rows: &[LevelRow]) {
        for row in rows {
            self.add_point("triangles", (row.percent, row.vertices_sent.triangles as f64));
            for (name, sent) in row.vertices_sent.filters() {
                self.add_point(name, (row.percent, sent as f64));
            }
        }
    }

    /// Adds the index-map updates per split, averaged over bins with equal numbers of levels.
    fn add_bins(&mut self, traffic: &TrafficModel<'_>, levels: &ModelLevels) -> Result<(), Error> {
        for pair in levels.order.evenly(BIN_STEPS).windows(2) {
            let all = traffic.refinement(pair[0], pair[1])?;
            let middle = 50.0 * (pair[0] + pair[1]) as f64 / levels.collapse_count() as f64;
            self.add_point("updates_naive", (middle, all.updates_naive));
            self.add_point("updates_encoded", (middle, all.updates_encoded));
        }
        Ok(())
    }
}
