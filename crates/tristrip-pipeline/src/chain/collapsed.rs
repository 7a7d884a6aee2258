//! The levels of a chain: the collapse level of each part, and the vertices in reverse order of
//! removal.

use tristrip::CollapseSequence;
use tristrip_io::PartLevel;

use super::coverage::PartExtent;
use super::ratios::ChainRatios;
use crate::error::Error;
use crate::goal::Amount;
use crate::simplify::{LevelOrder, Part, PartCollapses};

/// A level of all parts.
pub(super) struct CollapsedLevel {
    /// The requested number of triangles.
    pub(super) target_triangles: usize,
    /// The number of triangles drawn.
    pub(super) triangles: usize,
    /// The collapse level of each part.
    at: Vec<usize>,
    /// The triangles and new vertices of each part, over its vertices in the model.
    pub(super) parts: Vec<PartLevel>,
}

impl CollapsedLevel {
    /// Returns whether the level has at most the requested number of triangles.
    pub(super) fn is_reached(&self) -> bool {
        self.triangles <= self.target_triangles
    }
}

/// Returns the levels, the finest first. Each level undoes collapses of the next coarser level.
pub(super) fn levels(
    parts: &[Part<'_>],
    done: &[PartCollapses],
    ratios: &ChainRatios,
) -> Result<Vec<CollapsedLevel>, Error> {
    let full = parts.iter().map(Part::triangle_count).sum();
    let order = LevelOrder::new(done);
    let mut levels = Vec::new();
    let mut coarser: Vec<Option<usize>> = vec![None; parts.len()];
    for ratio in ratios.as_slice().iter().rev() {
        let target_triangles = Amount::Ratio(*ratio).of(full);
        let at = order.of_parts(order.level_of_triangles(done, target_triangles)?)?;
        let counts = done.iter().zip(&at).map(|(done, &level)| done.sequence.triangle_count(level));
        let triangles = counts.sum::<Result<usize, _>>()?;
        let mut level =
            CollapsedLevel { target_triangles, triangles, at, parts: Vec::with_capacity(parts.len()) };
        for (((part, done), &at), coarser) in parts.iter().zip(done).zip(&level.at).zip(&mut coarser) {
            level.parts.push(part_level(part, &done.sequence, *coarser, at)?);
            *coarser = Some(at);
        }
        levels.push(level);
    }
    levels.reverse();
    Ok(levels)
}

/// Returns the triangles of a part at a level, and the vertices that it adds to the next coarser
/// level.
fn part_level(
    part: &Part<'_>,
    sequence: &CollapseSequence,
    coarser: Option<usize>,
    level: usize,
) -> Result<PartLevel, Error> {
    let mut triangles = sequence.drawn(level)?.into_flattened();
    let mut added = Vec::new();
    // Undoing a collapse adds the vertex that it removed.
    for undone in coarser.unwrap_or(level)..level {
        added.extend(sequence.collapse(undone)?.renames.iter().map(|rename| rename.removed));
    }
    part.compact.used.outward(&mut triangles);
    part.compact.used.outward(&mut added);
    Ok(PartLevel { triangles, added })
}

/// Returns the bounding box of a part and the errors of its levels.
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
