//! The levels of a model: the collapses of all its parts in one order.

use tristrip::CollapseSequence;

use crate::error::Error;

/// The order of the collapses of all parts of a model: by their errors, so that at every level all parts have about the same error.
///
/// 4 bytes per collapse.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LevelOrder {
    /// The number of collapses of each part.
    lengths: Vec<usize>,
    /// The part of each collapse, from the full meshes to the base meshes.
    order: Vec<u32>,
}

impl LevelOrder {
    /// Orders the collapses of all parts.
    pub(crate) fn new<'a>(sequences: impl IntoIterator<Item = &'a CollapseSequence>) -> Self {
        let (mut collapses, mut lengths): (Vec<(f32, u32)>, _) = (Vec::new(), Vec::new());
        for (part, sequence) in (0..).zip(sequences) {
            // The greatest error so far, so that the collapses of a part keep their order.
            let mut greatest = 0.0_f32;
            collapses.extend(sequence.iter().map(|collapse| {
                greatest = greatest.max(collapse.error);
                (greatest, part)
            }));
            lengths.push(sequence.len());
        }
        collapses.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { lengths, order: collapses.into_iter().map(|(_, part)| part).collect() }
    }

    /// Returns the number of collapses, which is the level of the full model.
    pub fn collapse_count(&self) -> usize {
        self.order.len()
    }

    /// Returns the level of each part at a level of the model, in linear time.
    ///
    /// # Errors
    /// [`Error::Level`]: the model does not have this level.
    pub fn of_parts(&self, level: usize) -> Result<Vec<usize>, Error> {
        let last = self.collapse_count();
        let undone = last.checked_sub(level).ok_or(Error::Level { found: level, last })?;
        let mut levels = self.lengths.clone();
        self.order[..undone].iter().for_each(|&part| levels[part as usize] -= 1);
        Ok(levels)
    }

    /// Iterates over the parts of the collapses, from the full model to the base meshes.
    pub fn parts_from_full(&self) -> impl Iterator<Item = usize> {
        self.order.iter().map(|&part| part as usize)
    }

    /// Returns levels from the base mesh to the full mesh, in `steps` equal steps, at least one; equal levels are returned once.
    pub fn evenly(&self, steps: usize) -> Vec<usize> {
        let (steps, last) = (steps.max(1), self.collapse_count());
        let mut levels: Vec<usize> = (0..=steps).map(|step| (last * step + steps / 2) / steps).collect();
        levels.dedup();
        levels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::Rename;

    /// Returns a sequence of collapses along the rim of a fan, with the given errors.
    fn fan(errors: &[f32]) -> CollapseSequence {
        let corners = errors.len() as u32 + 3;
        let triangles = (0..corners - 1).flat_map(|i| [i, i + 1, corners]).collect();
        let renames: Vec<[Rename; 1]> =
            (0..errors.len() as u32).map(|i| [Rename { removed: i, kept: i + 1 }]).collect();
        let collapses = renames.iter().zip(errors).map(|(rename, &error)| (&rename[..], error));
        CollapseSequence::from_collapses(corners as usize + 1, triangles, collapses).unwrap()
    }

    #[test]
    fn collapses_of_all_parts_are_ordered_by_error() {
        let (a, b) = (fan(&[1.0, 4.0, 2.0]), fan(&[2.0, 3.0, 5.0]));
        let levels = LevelOrder::new([&a, &b]);
        let all: Vec<_> = (0..=6).rev().map(|level| levels.of_parts(level).unwrap()).collect();
        assert_eq!(all, [[3, 3], [2, 3], [2, 2], [2, 1], [1, 1], [0, 1], [0, 0]]);
        assert!(matches!(levels.of_parts(7), Err(Error::Level { found: 7, last: 6 })));
        assert_eq!(levels.evenly(3), [0, 2, 4, 6]);
        assert_eq!(levels.evenly(20), [0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(LevelOrder::new([]).evenly(20), [0]);
    }
}
