//! What every filter sends, level by level.

use clap::ValueEnum;
use serde::{Serialize, Serializer};
use tristrip::lod::filter::{Filter, repair};
use tristrip::{Error, Strips};

use super::detail::{Detail, Updates};
use super::levels::Levels;
use crate::failure::Failure;
use crate::figures::rounded;
use crate::stages::Pool;
use crate::text::{count, table};
use crate::values::FilterName;

/// A level, and what is sent to draw it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Row {
    pub(crate) level: usize,
    /// Of the collapses, those that are undone.
    pub(crate) percent: f64,
    pub(crate) triangles: usize,
    pub(crate) vertices_sent: Sent,
    /// What leads here from the level before.
    pub(crate) refinement: Refinement,
}

/// Vertex splits from one level to another, and what they take on their way.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub(crate) struct Refinement {
    pub(crate) splits: usize,
    /// Places of the index map that a split writes on the average.
    pub(crate) updates_naive: f64,
    pub(crate) updates_encoded: f64,
    /// Of the mesh as single triangles, and of the two.
    pub(crate) bytes_triangles: usize,
    pub(crate) bytes_naive: usize,
    pub(crate) bytes_encoded: usize,
}

/// Bytes of a position, and of an index or a place.
const POSITION_BYTES: usize = 12;
const INDEX_BYTES: usize = 2;
/// Indices of a split of a progressive mesh: the vertices of its edge, and the wings of its two triangles.
const SPLIT_INDICES: usize = 4;

impl Refinement {
    /// Counts what leads from one level of a model to a higher one.
    pub(crate) fn between(
        details: &[Detail<'_>],
        levels: &Levels<'_>,
        from: usize,
        to: usize,
    ) -> Result<Self, Error> {
        let (from, to) = (levels.of_parts(from), levels.of_parts(to));
        let ranges = from.into_iter().zip(to).map(|(from, to)| from..to);
        let updates = details.iter().zip(ranges).map(|(detail, range)| detail.updates(range));
        Ok(Self::of(updates.collect::<Result<Vec<_>, _>>()?.into_iter().sum()))
    }

    fn of(updates: Updates) -> Self {
        let Updates { splits, vertices, naive, encoded } = updates;
        let average = |places: usize| rounded(places as f64 / splits.max(1) as f64);
        let bytes = |indices: usize| POSITION_BYTES * vertices + INDEX_BYTES * indices;
        Self {
            splits,
            updates_naive: average(naive),
            updates_encoded: average(encoded),
            bytes_triangles: bytes(SPLIT_INDICES * vertices),
            bytes_naive: bytes(naive),
            bytes_encoded: bytes(encoded),
        }
    }
}

/// Vertices sent: as single triangles, and by each filter, in the order of their names.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Sent {
    pub(crate) triangles: usize,
    pub(crate) by_filter: Vec<usize>,
}

/// An object of names and counts.
impl Serialize for Sent {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let filters = FilterName::value_variants().iter().map(|filter| filter.name());
        let all = std::iter::once((LIST.to_owned(), self.triangles));
        serializer.collect_map(all.chain(filters.zip(self.by_filter.iter().copied())))
    }
}

/// The name of the mesh drawn as single triangles.
pub(crate) const LIST: &str = "triangles";

/// Measures rising levels of a model; each drawing is proven where that is asked for.
pub(crate) fn rows(
    pool: &Pool,
    details: &[Detail<'_>],
    levels: &Levels<'_>,
    at: &[usize],
    repair: repair::Options,
    verify: bool,
) -> Result<Vec<Row>, Failure> {
    // 1. The filter that searches follows the collapses, part by part.
    let of_parts: Vec<Vec<usize>> = at.iter().map(|&level| levels.of_parts(level)).collect();
    let numbered: Vec<_> = details.iter().enumerate().collect();
    let repaired = pool.map(&numbered, |(part, detail)| {
        let own: Vec<usize> = of_parts.iter().map(|levels| levels[*part]).collect();
        detail.repaired(&own, repair, verify)
    });
    let repaired = repaired.into_iter().collect::<Result<Vec<_>, Failure>>()?;
    // 2. The others read the strips of each level by themselves.
    let scanners: Vec<Option<Filter>> =
        FilterName::value_variants().iter().map(|filter| filter.scanner()).collect();
    let numbers: Vec<usize> = (0..at.len()).collect();
    let measured = pool.map(&numbers, |&number| {
        let level = at[number];
        let mut by_filter = vec![0; scanners.len()];
        for (part, detail) in details.iter().enumerate() {
            let level = of_parts[number][part];
            let map = detail.map(level);
            for (sum, scanner) in by_filter.iter_mut().zip(&scanners) {
                let Some(scanner) = scanner else {
                    *sum += repaired[part][number];
                    continue;
                };
                let mut display = Strips::default();
                scanner.map_to(&map, &mut display);
                if verify {
                    detail.prove(level, &display)?;
                }
                *sum += display.vertices_sent();
            }
        }
        let before = if number == 0 { level } else { at[number - 1] };
        let triangles = levels.triangle_count(&of_parts[number]);
        Ok(Row {
            level,
            percent: rounded(100.0 * level as f64 / levels.len().max(1) as f64),
            triangles,
            vertices_sent: Sent { triangles: 3 * triangles, by_filter },
            refinement: Refinement::between(details, levels, before, level)?,
        })
    });
    measured.into_iter().collect()
}

/// Writes rows as a table.
pub(crate) fn as_text(rows: &[Row]) -> String {
    let mut head: Vec<String> = ["  level", "", "triangles", "as triangles"].map(String::from).to_vec();
    head.extend(FilterName::value_variants().iter().map(|filter| filter.name()));
    head.extend(["u naive", "u encoded", "bytes"].map(String::from));
    let columns = head.len();
    let line = |row: &Row| {
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
    let legend = "  u: places of the index map that a vertex split writes; bytes: to come here from the row above, encoded\n";
    format!("\n  Vertices sent\n{}{legend}", table(&lines, 0..columns))
}
