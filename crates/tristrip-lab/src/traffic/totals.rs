//! The number of vertices that every filter sends from the base mesh to the full mesh, if each
//! level is drawn once.
//!
//! `repair` follows the collapses from the full mesh. The other filters read the strips of each
//! level independently. A model of several parts has the collapses of all parts in one order; a
//! collapse of one part leaves the others unchanged.

use std::sync::Arc;

use rayon::prelude::*;
use tristrip::Error as MeshError;
use tristrip::lod::{Filter, Repair, RepairOptions};
use tristrip_pipeline::text::grouped;
use tristrip_pipeline::{levels::DisplayFilter, levels::LevelPart, levels::ModelLevels, rounded};

use super::levels::walk;
use super::rows::{FilterTotal, SINGLE_TRIANGLES};
use crate::error::Error;
use tristrip_render::text::table;

/// Counts the vertices that every filter sends for a part, at each of its levels from the full mesh
/// to the base mesh. Filters are in the order of [`DisplayFilter::ALL`].
fn sent_by_level(part: &LevelPart, options: RepairOptions) -> Result<Vec<Vec<usize>>, MeshError> {
    let (strips, sequence) = (part.strips(), part.sequence());
    let mut counts: Vec<Vec<usize>> = Vec::with_capacity(sequence.len() + 1);
    let scanners = || DisplayFilter::ALL.iter().map(|filter| filter.scanner());
    walk(strips, sequence, |level| {
        let sent = |filter: Option<Filter>| filter.map_or(0, |filter| level.sent(filter).vertices);
        counts.push(scanners().map(sent).collect());
    })?;
    // The searching filter follows the collapses.
    let mut repair = Repair::new(Arc::clone(sequence), strips, options)?;
    for counts in &mut counts {
        let own = counts.iter_mut().zip(scanners()).filter(|(_, scanner)| scanner.is_none());
        own.for_each(|(sent, _)| *sent = repair.vertices_sent());
        repair.coarsen();
    }
    Ok(counts)
}

/// Sums the vertices that every filter sends over all levels of a model. The first total is that of
/// single triangles.
///
/// # Errors
/// A part is too large.
///
/// ```
/// use tristrip_io::{Format, read};
/// use tristrip_pipeline::levels;
/// let corners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 0\n";
/// let model = read([corners, "f 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"].concat().as_bytes(), Format::Obj)?;
/// let levels = levels::run(&model, &levels::Options::default(), &())?.model;
/// let totals = tristrip_lab::traffic::totals(&levels, Default::default())?;
/// assert_eq!((totals[0].filter.as_str(), totals[0].vertices_sent), ("triangles", 3 * (1 + 2 + 4)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn totals(levels: &ModelLevels, repair: RepairOptions) -> Result<Vec<FilterTotal>, Error> {
    let parts = &levels.parts;
    let sent = parts.par_iter().map(|part| sent_by_level(part, repair));
    let sent = sent.collect::<Result<Vec<_>, MeshError>>()?;
    let mut done = vec![0; parts.len()];
    let mut current = vec![0; DisplayFilter::ALL.len()];
    let mut triangles = levels.triangle_count(levels.collapse_count())? as u64;
    for of_part in &sent {
        current.iter_mut().zip(&of_part[0]).for_each(|(sum, sent)| *sum += sent);
    }
    let (mut all_triangles, mut all): (u64, Vec<u64>) =
        (triangles, current.iter().map(|&sent| sent as u64).collect());
    for together in levels.order.parts_from_full() {
        for part in together.iter().map(|&part| part as usize) {
            let sequence = parts[part].sequence();
            let level = sequence.len() - 1 - done[part];
            triangles -= sequence.collapse(level)?.dropped.len() as u64;
            let (before, after) = (&sent[part][done[part]], &sent[part][done[part] + 1]);
            for (sum, (before, after)) in current.iter_mut().zip(before.iter().zip(after)) {
                *sum = *sum - before + after;
            }
            done[part] += 1;
        }
        all_triangles += triangles;
        all.iter_mut().zip(&current).for_each(|(all, &sum)| *all += sum as u64);
    }
    let total = |filter: &str, sent: u64| FilterTotal {
        filter: filter.into(),
        vertices_sent: sent,
        vertices_per_triangle: rounded(sent as f64 / all_triangles.max(1) as f64),
        percent: rounded(100.0 * sent as f64 / (3 * all_triangles).max(1) as f64),
    };
    let filters = DisplayFilter::ALL.iter().zip(all).map(|(filter, sent)| total(filter.name(), sent));
    Ok(std::iter::once(total(SINGLE_TRIANGLES, 3 * all_triangles)).chain(filters).collect())
}

/// Formats totals as a text table.
pub fn as_text(totals: &[FilterTotal]) -> String {
    let head =
        ["  sum over all levels", "vertices sent", "per triangle", "of single triangles"].map(String::from);
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
    use crate::traffic::{LevelRow, TrafficModel, measure_levels};
    use tristrip::{Faces, Mesh};
    use tristrip_io::{Model, Part};
    use tristrip_pipeline::levels;

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
        let part = |mesh| Part { mesh, ..Part::default() };
        let parts = vec![part(height_field(9, 1.0)), part(height_field(6, 40.0))];
        let model = Model { parts, ..Model::default() };
        let base = "15%".parse().unwrap();
        let levels = levels::run(&model, &levels::Options::default().with_base(base), &()).unwrap().model;
        assert!(levels.collapse_count() > 50, "{}", levels.collapse_count());
        let at: Vec<usize> = (0..=levels.collapse_count()).collect();
        let traffic = TrafficModel::new(&levels);
        let rows = measure_levels(&traffic, &at, RepairOptions::default(), true).unwrap();
        let totals = totals(&levels, RepairOptions::default()).unwrap();
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
