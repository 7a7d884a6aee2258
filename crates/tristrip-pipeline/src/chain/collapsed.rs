//! The levels of a chain: which level of the collapses of each part is drawn, and the vertices in the order of their removal.

use std::collections::BTreeMap;

use tristrip::CollapseSequence;
use tristrip_io::PartLevel;

use super::coverage::PartExtent;
use super::ratios::ChainRatios;
use crate::error::Error;
use crate::goal::Amount;
use crate::simplify::{Part, PartCollapses};

/// A level of all parts.
pub(super) struct CollapsedLevel {
    /// The number of triangles requested.
    pub(super) target_triangles: usize,
    /// The number of triangles drawn.
    pub(super) triangles: usize,
    /// Whether each group of parts has at most its share of the triangles requested.
    pub(super) reached: bool,
    /// The level of the collapses of each part.
    at: Vec<usize>,
    /// What is drawn of each part, over its vertices in the model.
    pub(super) parts: Vec<PartLevel>,
}

/// Returns the levels, the finest first. Every level undoes collapses of the next coarser one.
pub(super) fn levels(
    parts: &[Part<'_>],
    done: &[PartCollapses],
    ratios: &ChainRatios,
) -> Result<Vec<CollapsedLevel>, Error> {
    let before: Vec<usize> = parts.iter().map(Part::triangle_count).collect();
    let mut levels = Vec::new();
    let mut coarser: Vec<Option<usize>> = vec![None; parts.len()];
    for ratio in ratios.as_slice().iter().rev() {
        let shares = Amount::Ratio(*ratio).shares(&before);
        let mut level = CollapsedLevel {
            target_triangles: shares.iter().sum(),
            triangles: 0,
            reached: true,
            at: vec![0; parts.len()],
            parts: Vec::with_capacity(parts.len()),
        };
        for group in groups(done) {
            let share: usize = group.iter().map(|&part| shares[part]).sum();
            let count = choose(&group, done, share, &mut level.at)?;
            level.triangles += count;
            level.reached &= count <= share;
        }
        for (((part, done), &at), coarser) in parts.iter().zip(done).zip(&level.at).zip(&mut coarser) {
            level.parts.push(part_level(part, &done.sequence, *coarser, at)?);
            *coarser = Some(at);
        }
        levels.push(level);
    }
    levels.reverse();
    Ok(levels)
}

/// Returns the parts of each group that is simplified as one surface.
fn groups(done: &[PartCollapses]) -> Vec<Vec<usize>> {
    let mut groups: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    done.iter().enumerate().for_each(|(part, done)| groups.entry(done.group).or_default().push(part));
    groups.into_values().collect()
}

/// Chooses the levels of the parts of a group: those after the fewest steps of the group at which it has no more triangles than its share, so
/// that borders between its parts stay closed. Returns the number of triangles.
fn choose(group: &[usize], done: &[PartCollapses], share: usize, at: &mut [usize]) -> Result<usize, Error> {
    let level_after = |part: usize, steps: usize| {
        let PartCollapses { sequence, steps: of_part, .. } = &done[part];
        let collapses = match of_part {
            None => steps.min(sequence.len()),
            Some(of_part) => of_part.partition_point(|&step| (step as usize) < steps),
        };
        sequence.len() - collapses
    };
    let count = |steps: usize| -> Result<usize, Error> {
        group
            .iter()
            .try_fold(0, |sum, &part| Ok(sum + done[part].sequence.triangle_count(level_after(part, steps))?))
    };
    let most = group.iter().map(|&part| match &done[part].steps {
        None => done[part].sequence.len(),
        Some(steps) => steps.last().map_or(0, |&step| step as usize + 1),
    });
    let (mut low, mut high) = (0, most.max().unwrap_or(0));
    while low < high {
        let middle = usize::midpoint(low, high);
        if count(middle)? <= share { high = middle } else { low = middle + 1 }
    }
    group.iter().for_each(|&part| at[part] = level_after(part, low));
    count(low)
}

/// Returns what a level draws of a part, and the vertices that it adds to the next coarser level.
fn part_level(
    part: &Part<'_>,
    sequence: &CollapseSequence,
    coarser: Option<usize>,
    level: usize,
) -> Result<PartLevel, Error> {
    let mut triangles = sequence.drawn(level)?.into_flattened();
    let mut added = Vec::new();
    // The split of a level adds the vertices that the collapse to it removed.
    for undone in coarser.unwrap_or(level)..level {
        added.extend(sequence.collapse(undone)?.renames.iter().map(|rename| rename.removed));
    }
    part.compact.used.outward(&mut triangles);
    part.compact.used.outward(&mut added);
    Ok(PartLevel { triangles, added })
}

/// Returns the extent of a part and the errors of its levels.
pub(super) fn extent(
    part: &Part<'_>,
    number: usize,
    done: &[PartCollapses],
    levels: &[CollapsedLevel],
) -> Result<PartExtent, Error> {
    let (mut lowest, mut highest) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &vertex in part.triangles() {
        for (axis, &x) in part.compact.mesh.positions()[vertex as usize].iter().enumerate() {
            lowest[axis] = lowest[axis].min(x.into());
            highest[axis] = highest[axis].max(x.into());
        }
    }
    let errors = levels.iter().map(|level| done[number].sequence.error(level.at[number]));
    let errors = errors.collect::<Result<Vec<f32>, _>>()?;
    Ok(PartExtent { lowest, highest, errors })
}
