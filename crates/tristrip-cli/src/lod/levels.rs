//! The levels of a model: the collapses of all its parts in one order.

use tristrip::CollapseSequence;

/// The levels of a model of any number of parts: the collapses of all parts in the order of their errors, so that at every level all
/// parts have about the same error.
pub(crate) struct Levels<'a> {
    sequences: Vec<&'a CollapseSequence>,
    /// The part of each collapse, from the full meshes to the base meshes.
    order: Vec<u32>,
}

impl<'a> Levels<'a> {
    pub(crate) fn new(sequences: Vec<&'a CollapseSequence>) -> Self {
        let mut collapses: Vec<(f32, u32)> = Vec::new();
        for (part, sequence) in (0..).zip(&sequences) {
            // The greatest error so far, so that the collapses of a part keep their order.
            let mut greatest = 0.0_f32;
            collapses.extend(sequence.iter().map(|collapse| {
                greatest = greatest.max(collapse.error);
                (greatest, part)
            }));
        }
        collapses.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { sequences, order: collapses.into_iter().map(|(_, part)| part).collect() }
    }

    /// Returns the number of collapses, which is the level of the full model.
    pub(crate) fn len(&self) -> usize {
        self.order.len()
    }

    /// Returns the level of each part at a level of the model.
    pub(crate) fn of_parts(&self, level: usize) -> Vec<usize> {
        let mut levels: Vec<usize> = self.sequences.iter().map(|sequence| sequence.len()).collect();
        self.order[..self.len() - level].iter().for_each(|&part| levels[part as usize] -= 1);
        levels
    }

    /// Iterates over the parts of the collapses, from the full model to the base meshes.
    pub(crate) fn parts_from_full(&self) -> impl Iterator<Item = usize> {
        self.order.iter().map(|&part| part as usize)
    }

    /// Returns the number of triangles, given the level of each part.
    pub(crate) fn triangle_count(&self, of_parts: &[usize]) -> usize {
        self.sequences.iter().zip(of_parts).map(|(sequence, &level)| sequence.triangle_count(level)).sum()
    }

    /// Returns the greatest error of the collapses that lead to the level of each part, in mesh units.
    pub(crate) fn error(&self, of_parts: &[usize]) -> f32 {
        self.sequences
            .iter()
            .zip(of_parts)
            .map(|(sequence, &level)| sequence.error(level))
            .fold(0.0, f32::max)
    }

    /// Returns levels from the base mesh to the full mesh, in `steps` equal steps; equal levels are returned once.
    pub(crate) fn evenly(&self, steps: usize) -> Vec<usize> {
        let mut levels: Vec<usize> =
            (0..=steps).map(|step| (self.len() * step + steps / 2) / steps).collect();
        levels.dedup();
        levels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tristrip::simplify::Rename;

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
        let levels = Levels::new(vec![&a, &b]);
        let all: Vec<_> = (0..=levels.len()).rev().map(|level| levels.of_parts(level)).collect();
        assert_eq!(all, [[3, 3], [2, 3], [2, 2], [2, 1], [1, 1], [0, 1], [0, 0]]);
        assert_eq!(levels.triangle_count(&[2, 1]), 4 + 3);
        assert_eq!(levels.error(&[2, 1]).to_bits(), 3.0_f32.to_bits());
        assert_eq!(levels.evenly(3), [0, 2, 4, 6]);
        assert_eq!(levels.evenly(20), [0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(Levels::new(vec![]).evenly(20), [0]);
    }
}
