//! The vertices that every filter sends from the base mesh to the full mesh, when each level is drawn once.
//!
//! `repair` follows the collapses from the full mesh; the other filters read the strips of each level independently.
//! A model of several parts has the collapses of all of them in one order; a collapse of one part leaves the others unchanged.

use clap::ValueEnum;
use tristrip::Error;
use tristrip::lod::traffic;
use tristrip::lod::{Filter, Repair, RepairOptions};

use super::levels::Levels;
use super::part::LodPart;
use super::rows::{FilterTotal, SINGLE_TRIANGLES};
use crate::failure::Failure;
use crate::figures::rounded;
use crate::stages::Pool;
use crate::text::{grouped, table};
use crate::values::FilterName;

/// Counts the vertices that every filter sends for a part, at each of its levels from the full mesh to the base mesh; the filters are
/// in the order of [`FilterName`].
fn sent_by_level(part: &LodPart<'_>, options: RepairOptions) -> Result<Vec<Vec<usize>>, Error> {
    let (strips, sequence) = (part.strips(), part.sequence());
    let mut counts: Vec<Vec<usize>> = Vec::with_capacity(sequence.len() + 1);
    let scanners = || FilterName::value_variants().iter().map(|filter| filter.scanner());
    traffic::walk(strips, sequence, |level| {
        let sent = |filter: Option<Filter>| filter.map_or(0, |filter| level.sent(filter).vertices);
        counts.push(scanners().map(sent).collect());
    })?;
    // The searching filter follows the collapses.
    let mut repair = Repair::new(sequence, strips, options)?;
    for counts in &mut counts {
        let own = counts.iter_mut().zip(scanners()).filter(|(_, scanner)| scanner.is_none());
        own.for_each(|(sent, _)| *sent = repair.vertices_sent());
        repair.coarsen();
    }
    Ok(counts)
}

/// Sums the vertices that every filter sends over all levels of a model; the first total is of the mesh as single triangles.
pub(crate) fn totals(
    pool: &Pool,
    parts: &[LodPart<'_>],
    levels: &Levels<'_>,
    repair: RepairOptions,
) -> Result<Vec<FilterTotal>, Failure> {
    let sent =
        pool.map(parts, |part| sent_by_level(part, repair)).into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut done = vec![0; parts.len()];
    let mut current = vec![0; FilterName::value_variants().len()];
    let mut triangles = levels.triangle_count(&levels.of_parts(levels.len())) as u64;
    for of_part in &sent {
        current.iter_mut().zip(&of_part[0]).for_each(|(sum, sent)| *sum += sent);
    }
    let (mut all_triangles, mut all): (u64, Vec<u64>) =
        (triangles, current.iter().map(|&sent| sent as u64).collect());
    for part in levels.parts_from_full() {
        let sequence = parts[part].sequence();
        let level = sequence.len() - 1 - done[part];
        triangles -= sequence.collapse(level).dropped.len() as u64;
        let (before, after) = (&sent[part][done[part]], &sent[part][done[part] + 1]);
        for (sum, (before, after)) in current.iter_mut().zip(before.iter().zip(after)) {
            *sum = *sum - before + after;
        }
        done[part] += 1;
        all_triangles += triangles;
        all.iter_mut().zip(&current).for_each(|(all, &sum)| *all += sum as u64);
    }
    let total = |filter: String, sent: u64| FilterTotal {
        filter,
        vertices_sent: sent,
        vertices_per_triangle: rounded(sent as f64 / all_triangles.max(1) as f64),
        percent: rounded(100.0 * sent as f64 / (3 * all_triangles).max(1) as f64),
    };
    let filters =
        FilterName::value_variants().iter().zip(all).map(|(filter, sent)| total(filter.name(), sent));
    Ok(std::iter::once(total(SINGLE_TRIANGLES.into(), 3 * all_triangles)).chain(filters).collect())
}

/// Formats totals as a text table.
pub(crate) fn as_text(totals: &[FilterTotal]) -> String {
    let head =
        ["  all levels, each once", "vertices sent", "per triangle", "of single triangles"].map(String::from);
    let line = |total: &FilterTotal| {
        let name = if total.filter == SINGLE_TRIANGLES { "as triangles" } else { &total.filter };
        vec![
            format!("  {name}"),
            grouped(&total.vertices_sent.to_string()),
            format!("{:.3}", total.vertices_per_triangle),
            format!("{:.1} %", total.percent),
        ]
    };
    let lines: Vec<_> = std::iter::once(head.to_vec()).chain(totals.iter().map(line)).collect();
    format!("\n{}", table(&lines, 1..4))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lod::measure::measure_levels;
    use crate::lod::rows::LevelRow;
    use crate::simplify::{Part, simplify_all};
    use tristrip::{Faces, Mesh, StripifyOptions, stripify};

    /// Returns a height field of `cells` × `cells` squares.
    fn height_field(cells: u32, scale: f32) -> Mesh {
        let side = cells + 1;
        let at = |i: u32| {
            let (x, y) = ((i % side) as f32, (i / side) as f32);
            [scale * x, scale * y, (1.3 * x).sin() + (0.7 * x * y).cos()]
        };
        let quad = |i: u32| {
            let v = i / cells * side + i % cells;
            [v, v + 1, v + side, v + side, v + 1, v + side + 1]
        };
        let faces = Faces::from_triangles((0..cells * cells).flat_map(quad).collect()).unwrap();
        Mesh::new((0..side * side).map(at).collect::<Vec<_>>(), faces).unwrap()
    }

    #[test]
    fn totals_are_the_sums_of_all_levels() {
        let pool = Pool::new(Some(1)).unwrap();
        let meshes = [height_field(9, 1.0), height_field(6, 40.0)];
        let strips = [0, 1].map(|part| stripify(&meshes[part], &StripifyOptions::default()).unwrap());
        let parts = meshes.iter().zip(&strips).map(|(mesh, strips)| (mesh, strips.to_list()));
        let parts = Part::of_all(parts.collect()).unwrap();
        let done = simplify_all(&pool, &parts, &[20, 20], None).unwrap();
        let parts = LodPart::all(parts, &strips, done);
        let levels = Levels::new(parts.iter().map(LodPart::sequence).collect());
        assert!(levels.len() > 50, "{}", levels.len());
        let at: Vec<usize> = (0..=levels.len()).collect();
        let rows = measure_levels(&pool, &parts, &levels, &at, RepairOptions::default(), true).unwrap();
        let totals = totals(&pool, &parts, &levels, RepairOptions::default()).unwrap();
        let sum = |sent: &dyn Fn(&LevelRow) -> usize| rows.iter().map(|row| sent(row) as u64).sum::<u64>();
        assert_eq!(totals[0].vertices_sent, sum(&|row| row.vertices_sent.triangles));
        for (index, total) in totals[1..].iter().enumerate() {
            assert_eq!(
                total.vertices_sent,
                sum(&|row| row.vertices_sent.by_filter[index]),
                "{}",
                total.filter
            );
        }
    }
}
