//! Measures the vertices that every filter sends at given levels, and the updates between them.

use clap::ValueEnum;
use tristrip::lod::{Filter, RepairOptions};
use tristrip::{Error, Strips};

use super::levels::Levels;
use super::part::{LodPart, SplitUpdates};
use super::rows::{LevelRow, Refinement, VerticesSent};
use crate::failure::Failure;
use crate::figures::rounded;
use crate::stages::Pool;
use crate::text::{count, table};
use crate::values::FilterName;

/// Bytes per position, and per index or index-map slot.
const POSITION_BYTES: usize = 12;
const INDEX_BYTES: usize = 2;
/// Indices per split of a progressive mesh: the two vertices of its edge, and the two opposite vertices of its triangles.
const SPLIT_INDICES: usize = 4;

/// Computes the refinement from one level of a model to a higher one.
pub(crate) fn refinement(
    parts: &[LodPart<'_>],
    levels: &Levels<'_>,
    from: usize,
    to: usize,
) -> Result<Refinement, Error> {
    let (from, to) = (levels.of_parts(from), levels.of_parts(to));
    let ranges = from.into_iter().zip(to).map(|(from, to)| from..to);
    let updates = parts.iter().zip(ranges).map(|(part, range)| part.updates(range));
    let SplitUpdates { splits, vertices, naive, encoded } =
        updates.collect::<Result<Vec<_>, _>>()?.into_iter().sum();
    let average = |slots: usize| rounded(slots as f64 / splits.max(1) as f64);
    let bytes = |indices: usize| POSITION_BYTES * vertices + INDEX_BYTES * indices;
    Ok(Refinement {
        splits,
        updates_naive: average(naive),
        updates_encoded: average(encoded),
        bytes_triangles: bytes(SPLIT_INDICES * vertices),
        bytes_naive: bytes(naive),
        bytes_encoded: bytes(encoded),
    })
}

/// Measures ascending levels of a model. With `verify`, the display strips of each level and filter are proven.
pub(crate) fn measure_levels(
    pool: &Pool,
    parts: &[LodPart<'_>],
    levels: &Levels<'_>,
    at: &[usize],
    repair: RepairOptions,
    verify: bool,
) -> Result<Vec<LevelRow>, Failure> {
    // 1. The searching filter follows the collapses of each part.
    let of_parts: Vec<Vec<usize>> = at.iter().map(|&level| levels.of_parts(level)).collect();
    let numbered: Vec<_> = parts.iter().enumerate().collect();
    let sent_by_repair = pool.map(&numbered, |(index, part)| {
        let own: Vec<usize> = of_parts.iter().map(|levels| levels[*index]).collect();
        part.sent_by_repair(&own, repair, verify)
    });
    let sent_by_repair = sent_by_repair.into_iter().collect::<Result<Vec<_>, Failure>>()?;
    // 2. The scanning filters read the strips of each level independently.
    let scanners: Vec<Option<Filter>> =
        FilterName::value_variants().iter().map(|filter| filter.scanner()).collect();
    let rows: Vec<usize> = (0..at.len()).collect();
    let measured = pool.map(&rows, |&row| {
        let level = at[row];
        let mut by_filter = vec![0; scanners.len()];
        for (index, part) in parts.iter().enumerate() {
            let level = of_parts[row][index];
            let map = part.index_map(level);
            for (sum, scanner) in by_filter.iter_mut().zip(&scanners) {
                let Some(scanner) = scanner else {
                    *sum += sent_by_repair[index][row];
                    continue;
                };
                let mut display = Strips::default();
                scanner.map_to(&map, &mut display);
                if verify {
                    part.prove(level, &display)?;
                }
                *sum += display.vertices_sent();
            }
        }
        let previous = if row == 0 { level } else { at[row - 1] };
        let triangles = levels.triangle_count(&of_parts[row]);
        Ok(LevelRow {
            level,
            percent: rounded(100.0 * level as f64 / levels.len().max(1) as f64),
            triangles,
            vertices_sent: VerticesSent { triangles: 3 * triangles, by_filter },
            refinement: refinement(parts, levels, previous, level)?,
        })
    });
    measured.into_iter().collect()
}

/// Formats rows as a text table.
pub(crate) fn as_text(rows: &[LevelRow]) -> String {
    let mut head: Vec<String> = ["  level", "", "triangles", "as triangles"].map(String::from).to_vec();
    head.extend(FilterName::value_variants().iter().map(|filter| filter.name()));
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
