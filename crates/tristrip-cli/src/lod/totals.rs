//! What every filter sends from the base mesh to the full one, where each level is drawn once.
//!
//! `repair` follows the collapses from the full mesh down; the others read the strips of each level by themselves.
//! A model of several parts has the collapses of all of them in one order; a part stays as it is at the levels of the others.

use clap::ValueEnum;
use serde::Serialize;
use tristrip::Error;
use tristrip::lod::filter::{Filter, Repair, repair};
use tristrip::lod::traffic;

use super::detail::Detail;
use super::levels::Levels;
use super::measure::LIST;
use crate::failure::Failure;
use crate::figures::rounded;
use crate::stages::Pool;
use crate::text::{grouped, table};
use crate::values::FilterName;

/// What one way to draw the levels of a model sends.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Total {
    /// The name of the filter, or that of the mesh as single triangles.
    pub(crate) filter: String,
    /// Of all levels together.
    pub(crate) vertices_sent: u64,
    pub(crate) vertices_per_triangle: f64,
    /// Of what the mesh sends as single triangles.
    pub(crate) percent: f64,
}

/// Vertices sent by every filter, in the order of their names.
type Counts = Vec<usize>;

/// Counts what every filter sends of a part at each of its levels, from the full mesh down.
fn by_level(detail: &Detail<'_>, options: repair::Options) -> Result<Vec<Counts>, Error> {
    let (strips, sequence) = (detail.strips(), detail.sequence());
    let mut counts: Vec<Counts> = Vec::with_capacity(sequence.len() + 1);
    let scanners = || FilterName::value_variants().iter().map(|filter| filter.scanner());
    traffic::walk(strips, sequence, |level| {
        let sent = |filter: Option<Filter>| filter.map_or(0, |filter| level.sent(filter).vertices);
        counts.push(scanners().map(sent).collect());
    })?;
    // The one that searches follows the collapses by itself.
    let mut repair = Repair::new(sequence, strips, options)?;
    for counts in &mut counts {
        let own = counts.iter_mut().zip(scanners()).filter(|(_, scanner)| scanner.is_none());
        own.for_each(|(sent, _)| *sent = repair.vertices_sent());
        repair.coarsen();
    }
    Ok(counts)
}

/// Sums what every filter sends over all levels of a model; the first is the mesh as single triangles.
pub(crate) fn totals(
    pool: &Pool,
    details: &[Detail<'_>],
    levels: &Levels<'_>,
    repair: repair::Options,
) -> Result<Vec<Total>, Failure> {
    let parts =
        pool.map(details, |detail| by_level(detail, repair)).into_iter().collect::<Result<Vec<_>, _>>()?;
    let mut done = vec![0; details.len()];
    let mut now = vec![0; FilterName::value_variants().len()];
    let mut triangles = levels.triangle_count(&levels.of_parts(levels.len())) as u64;
    for part in &parts {
        now.iter_mut().zip(&part[0]).for_each(|(now, sent)| *now += sent);
    }
    let (mut all_triangles, mut all): (u64, Vec<u64>) =
        (triangles, now.iter().map(|&sent| sent as u64).collect());
    for part in levels.parts_from_full() {
        let sequence = details[part].sequence();
        let level = sequence.len() - 1 - done[part];
        triangles -= sequence.collapse(level).dropped.len() as u64;
        let (before, after) = (&parts[part][done[part]], &parts[part][done[part] + 1]);
        for (now, (before, after)) in now.iter_mut().zip(before.iter().zip(after)) {
            *now = *now - before + after;
        }
        done[part] += 1;
        all_triangles += triangles;
        all.iter_mut().zip(&now).for_each(|(all, &now)| *all += now as u64);
    }
    let total = |filter: String, sent: u64| Total {
        filter,
        vertices_sent: sent,
        vertices_per_triangle: rounded(sent as f64 / all_triangles.max(1) as f64),
        percent: rounded(100.0 * sent as f64 / (3 * all_triangles).max(1) as f64),
    };
    let filters =
        FilterName::value_variants().iter().zip(all).map(|(filter, sent)| total(filter.name(), sent));
    Ok(std::iter::once(total(LIST.into(), 3 * all_triangles)).chain(filters).collect())
}

/// Writes totals as a table.
pub(crate) fn as_text(totals: &[Total]) -> String {
    let head =
        ["  all levels, each once", "vertices sent", "a triangle", "of the triangles"].map(String::from);
    let line = |total: &Total| {
        let name = if total.filter == LIST { "as triangles" } else { &total.filter };
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
    use crate::lod::measure::rows;
    use crate::simplify::{Part, simplify_all};
    use tristrip::{Faces, Mesh, Options, Strips, stripify};

    /// A bumpy square of so many cells a side.
    fn bumps(cells: u32, scale: f32) -> Mesh {
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
        let meshes = [bumps(9, 1.0), bumps(6, 40.0)];
        let strips = [0, 1].map(|part| stripify(&meshes[part], &Options::default()).unwrap());
        let parts = meshes.iter().zip(&strips).map(|(mesh, strips)| (mesh, strips.to_list()));
        let parts = Part::of_all(parts.collect()).unwrap();
        let done = simplify_all(&pool, &parts, &[20, 20], None).unwrap();
        let details = parts.into_iter().zip(&strips as &[Strips]).zip(done);
        let details: Vec<Detail<'_>> =
            details.map(|((part, strips), done)| Detail::new(part.compact, strips, done)).collect();
        let levels = Levels::new(details.iter().map(Detail::sequence).collect());
        assert!(levels.len() > 50, "{}", levels.len());
        let at: Vec<usize> = (0..=levels.len()).collect();
        let rows = rows(&pool, &details, &levels, &at, repair::Options::default(), true).unwrap();
        let totals = totals(&pool, &details, &levels, repair::Options::default()).unwrap();
        let sum =
            |sent: &dyn Fn(&crate::lod::Row) -> usize| rows.iter().map(|row| sent(row) as u64).sum::<u64>();
        assert_eq!(totals[0].vertices_sent, sum(&|row| row.vertices_sent.triangles));
        for (number, total) in totals[1..].iter().enumerate() {
            assert_eq!(
                total.vertices_sent,
                sum(&|row| row.vertices_sent.by_filter[number]),
                "{}",
                total.filter
            );
        }
    }
}
