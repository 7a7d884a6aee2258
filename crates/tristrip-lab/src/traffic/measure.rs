//! Measures the vertices that every filter sends at given levels.

use rayon::prelude::*;
use tristrip::lod::{Filter, RepairOptions};
use tristrip_pipeline::text::count;
use tristrip_pipeline::{levels::DisplayFilter, rounded};

use super::rows::{LevelRow, VerticesSent};
use super::updates::{TrafficModel, scanned, sent_by_repair};
use crate::error::Error;
use tristrip_render::text::table;

/// Measures ascending levels of a model. With `verify`, the display strips of each level and filter
/// are proven.
///
/// # Errors
/// The level does not exist, or a level is not proven.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_lab::traffic::{TrafficModel, measure_levels};
/// use tristrip_pipeline::levels;
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let levels = levels::run(&model, &levels::Options::default(), &())?.model;
/// let rows = measure_levels(&TrafficModel::new(&levels), &levels.order.evenly(20), Default::default(), true)?;
/// assert_eq!(rows.iter().map(|row| row.triangles).collect::<Vec<_>>(), [1, 2, 4]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure_levels(
    model: &TrafficModel<'_>,
    at: &[usize],
    repair: RepairOptions,
    verify: bool,
) -> Result<Vec<LevelRow>, Error> {
    let (levels, parts) = (model.levels, &model.levels.parts);
    // 1. The searching filter follows the collapses of each part.
    let of_parts = at.iter().map(|&level| levels.order.of_parts(level)).collect::<Result<Vec<_>, _>>()?;
    let sent_by_repair = parts.par_iter().enumerate().map(|(index, part)| {
        let own: Vec<usize> = of_parts.iter().map(|levels| levels[index]).collect();
        sent_by_repair(part, &own, repair, verify)
    });
    let sent_by_repair = sent_by_repair.collect::<Result<Vec<_>, Error>>()?;
    // 2. The scanning filters read the strips of each level independently.
    let scanners: Vec<Option<Filter>> = DisplayFilter::ALL.iter().map(|filter| filter.scanner()).collect();
    let measured = (0..at.len()).into_par_iter().map(|row| {
        let level = at[row];
        let mut by_filter = vec![0; scanners.len()];
        for (index, part) in parts.iter().enumerate() {
            let level = of_parts[row][index];
            let map = part.index_map(level)?;
            for (sum, scanner) in by_filter.iter_mut().zip(&scanners) {
                let Some(scanner) = scanner else {
                    *sum += sent_by_repair[index][row];
                    continue;
                };
                let display = scanned(*scanner, &map);
                if verify {
                    part.prove(level, &display)?;
                }
                *sum += display.vertices_sent();
            }
        }
        let previous = if row == 0 { level } else { at[row - 1] };
        let triangles = levels.triangle_count(level)?;
        Ok(LevelRow {
            level,
            percent: rounded(100.0 * level as f64 / levels.collapse_count().max(1) as f64),
            triangles,
            vertices_sent: VerticesSent { triangles: 3 * triangles, by_filter },
            refinement: model.refinement(previous, level)?,
        })
    });
    measured.collect()
}

/// Formats rows as a text table.
pub fn as_text(rows: &[LevelRow]) -> String {
    let mut head: Vec<String> = ["  level", "", "triangles", "as triangles"].map(String::from).to_vec();
    head.extend(DisplayFilter::ALL.iter().map(|filter| filter.name().to_owned()));
    head.extend(["u naive", "u encoded", "bytes"].map(String::from));
    let columns = head.len();
    let line = |row: &LevelRow| {
        let mut cells =
            vec![format!("  {}", count(row.level)), format!("{:.0} %", row.percent), count(row.triangles)];
        cells.push(count(row.vertices_sent.triangles));
        cells.extend(row.vertices_sent.by_filter.iter().map(|&sent| count(sent)));
        let step = row.refinement;
        if step.splits > 0 {
            cells.extend([step.updates_naive, step.updates_encoded].map(|u| format!("{u:.2}")));
            cells.push(count(step.bytes_encoded));
        }
        cells
    };
    let lines: Vec<_> = std::iter::once(head).chain(rows.iter().map(line)).collect();
    let legend = "  u: index-map slots written per vertex split; bytes: of the encoded refinement from the row above\n";
    format!("\n  Vertices sent\n{}{legend}", table(&lines, 0..columns))
}
