//! The triangle counts and errors of all levels. All models of one [`CollapseSequence`] have the
//! same table.

use crate::collapse::{CollapseSequence, check_level};
use crate::error::Error;

/// The triangle count and the error of each level, 8 bytes per level.
///
/// ```
/// use tristrip::{CollapseSequence, Rename};
/// use tristrip::lod::LevelTable;
/// let renames = [[Rename { removed: 3, kept: 2 }], [Rename { removed: 2, kept: 1 }]];
/// let collapses = renames.iter().zip([0.5, 0.25]).map(|(renames, error)| (&renames[..], error));
/// let levels = LevelTable::of(&CollapseSequence::from_collapses(4, vec![0, 1, 2, 2, 1, 3], collapses)?);
/// assert_eq!((levels.collapse_count(), levels.triangle_count(1)?, levels.error(0)?), (2, 1, 0.5));
/// assert!(levels.error(3).is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct LevelTable {
    triangle_counts: Vec<u32>,
    errors: Vec<f32>,
}

impl LevelTable {
    /// Builds the table of a sequence of collapses.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let levels = LevelTable::of(&sequence);
    /// let table = (0..=2).map(|level| Ok((levels.triangle_count(level)?, levels.error(level)?)));
    /// assert_eq!(table.collect::<Result<Vec<_>, tristrip::Error>>()?, [(1, 0.5), (2, 0.25), (3, 0.0)]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn of(sequence: &CollapseSequence) -> Self {
        let levels = 0..=sequence.len();
        Self {
            triangle_counts: levels.clone().map(|level| sequence.triangles_at(level) as u32).collect(),
            errors: levels.map(|level| sequence.error_at(level)).collect(),
        }
    }

    /// Returns the number of collapses, which is also the level of the full mesh. The number of
    /// levels is greater by one.
    ///
    /// ```
    /// # use tristrip::{CollapseSequence, lod::LevelTable};
    /// let levels = LevelTable::of(&CollapseSequence::from_collapses(3, vec![0, 1, 2], [])?);
    /// assert_eq!(levels.collapse_count(), 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn collapse_count(&self) -> usize {
        self.errors.len() - 1
    }

    /// Returns the number of triangles at a level.
    ///
    /// # Errors
    /// `level` is greater than the level of the full mesh.
    ///
    /// ```
    /// # use tristrip::{CollapseSequence, lod::LevelTable};
    /// let levels = LevelTable::of(&CollapseSequence::from_collapses(3, vec![0, 1, 2], [])?);
    /// assert_eq!(levels.triangle_count(0)?, 1);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn triangle_count(&self, level: usize) -> Result<usize, Error> {
        self.check(level).map(|()| self.triangles_at(level))
    }

    /// Returns the error of a level in mesh units: the largest error of the collapses that lead to
    /// it, or 0 for the full mesh.
    ///
    /// # Errors
    /// `level` is greater than the level of the full mesh.
    ///
    /// ```
    /// # use tristrip::{CollapseSequence, lod::LevelTable};
    /// let levels = LevelTable::of(&CollapseSequence::from_collapses(3, vec![0, 1, 2], [])?);
    /// assert_eq!(levels.error(0)?, 0.0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn error(&self, level: usize) -> Result<f32, Error> {
        self.check(level).map(|()| self.errors[level])
    }

    /// Returns the coarsest level with at most this error in mesh units.
    ///
    /// # Errors
    /// The error is negative or NaN.
    ///
    /// ```
    /// # use tristrip::{CollapseSequence, lod::LevelTable};
    /// let levels = LevelTable::of(&CollapseSequence::from_collapses(3, vec![0, 1, 2], [])?);
    /// assert_eq!(levels.level_of_error(0.1)?, 0);
    /// assert!(levels.level_of_error(f32::NAN).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn level_of_error(&self, error: f32) -> Result<usize, Error> {
        if error.is_nan() || error < 0.0 {
            return Err(Error::Parameter { name: "error", found: error.to_string(), expected: "0 or more" });
        }
        // Errors decrease from the base mesh to the full mesh, whose error is 0.
        Ok(self.errors.partition_point(|&e| e > error).min(self.collapse_count()))
    }

    /// Returns the finest level with at most this many triangles, or 0 if even the base mesh has
    /// more.
    ///
    /// ```
    /// # use tristrip::{CollapseSequence, lod::LevelTable};
    /// let levels = LevelTable::of(&CollapseSequence::from_collapses(3, vec![0, 1, 2], [])?);
    /// assert_eq!(levels.level_of_triangles(7), 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn level_of_triangles(&self, triangle_count: usize) -> usize {
        self.triangle_counts.partition_point(|&count| count as usize <= triangle_count).saturating_sub(1)
    }

    /// Checks that a level exists.
    ///
    /// # Errors
    /// `level` is greater than the level of the full mesh.
    ///
    /// ```
    /// use tristrip::lod::LevelTable;
    /// let levels = LevelTable::of(&tristrip::CollapseSequence::default());
    /// assert!(levels.check(0).is_ok() && levels.check(1).is_err());
    /// ```
    pub fn check(&self, level: usize) -> Result<(), Error> {
        check_level(level, self.collapse_count())
    }

    /// Returns the number of triangles at an existing level.
    pub(crate) fn triangles_at(&self, level: usize) -> usize {
        self.triangle_counts[level] as usize
    }

    /// Returns the memory of the table in bytes.
    ///
    /// ```
    /// use tristrip::lod::LevelTable;
    /// assert!(LevelTable::of(&tristrip::CollapseSequence::default()).memory() < 100);
    /// ```
    pub fn memory(&self) -> usize {
        size_of_val(&self.triangle_counts[..]) + size_of_val(&self.errors[..])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lod::samples::samples;

    proptest! {
        #[test]
        fn the_table_has_the_figures_of_the_sequence(sample in samples(), error in 0.0..2.0_f32, count in 0..60_usize) {
            let (sequence, levels) = (&sample.sequence, LevelTable::of(&sample.sequence));
            for level in 0..=sequence.len() {
                prop_assert_eq!(levels.triangle_count(level).unwrap(), sequence.triangles_at(level));
                prop_assert_eq!(levels.error(level).unwrap().to_bits(), sequence.error_at(level).to_bits());
            }
            prop_assert_eq!(levels.level_of_error(error).unwrap(), sequence.level_of_error(error));
            prop_assert_eq!(levels.level_of_triangles(count), sequence.level_of_triangles(count));
        }
    }
}
