//! Hysteresis: prevents small camera movements from switching levels.
//!
//! Without hysteresis, a camera that moves back and forth around a threshold would switch levels in
//! every frame. The cursor therefore keeps its level while the error of the level is allowed and no
//! coarser level has an error of at most `share` × the allowed error.
//!
//! ```text
//! error of the level   0 ───────── share ───────── allowed ─────────▶
//!                        too fine │   level kept    │ too coarse
//!                          coarsen ──────────────▶ │
//!                                 │ ◀────────────── refine
//! ```
//! A level that is too coarse is replaced with the finest level of the range. A level that is too
//! fine is replaced with the coarsest level of the range. A camera that keeps moving in one
//! direction therefore changes the level again only after it has crossed the whole range.

use super::level_table::LevelTable;
use crate::error::Error;

/// A share of the allowed error. A level is too fine if a coarser level has an error of at most
/// this share of the allowed error.
///
/// ```
/// # use tristrip::lod::Hysteresis;
/// // The default keeps a level while its error is above 4/5 of the allowed error.
/// assert_eq!(Hysteresis::new(0.8)?, Hysteresis::default());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hysteresis {
    share: f32,
}

impl Default for Hysteresis {
    /// Returns a share of 4/5.
    fn default() -> Self {
        Self { share: 0.8 }
    }
}

impl Hysteresis {
    /// Creates a hysteresis from a share between 0 and 1. A share of 1 disables hysteresis. At 0 a
    /// level is never too fine.
    ///
    /// # Errors
    /// The share is not between 0 and 1.
    ///
    /// ```
    /// # use tristrip::lod::Hysteresis;
    /// assert!(Hysteresis::new(0.5).is_ok() && Hysteresis::new(1.5).is_err());
    /// ```
    pub fn new(share: f32) -> Result<Self, Error> {
        if (0.0..=1.0).contains(&share) {
            return Ok(Self { share });
        }
        Err(Error::Parameter { name: "share", found: share.to_string(), expected: "0 to 1" })
    }

    /// Returns the share of the allowed error.
    pub(crate) fn share(self) -> f32 {
        self.share
    }

    /// Returns the level to use after `current` for an allowed error in mesh units.
    ///
    /// # Errors
    /// The error is negative or NaN.
    pub(crate) fn level(self, levels: &LevelTable, current: usize, error: f32) -> Result<usize, Error> {
        let coarsest = levels.level_of_error(error)?;
        // With a share of 0 no level is too fine.
        let finest = if self.share == 0.0 {
            levels.collapse_count()
        } else {
            levels.level_of_error(self.share * error)?
        };
        Ok(if current < coarsest {
            finest
        } else if current > finest {
            coarsest
        } else {
            current
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::collapse::{CollapseSequence, Rename};
    use crate::strip::Strips;

    proptest! {
        /// The error of the level never exceeds the allowed error. After a switch, the level is
        /// kept while the allowed error changes further by less than the share.
        #[test]
        fn a_wavering_view_changes_nothing(
            errors in prop::collection::vec(0.0..1.0_f32, 1..40),
            share in 0.1..1.0_f32,
            start in any::<usize>(),
            error in 0.0..1.0_f32,
            offsets in prop::collection::vec(0.01..0.99_f32, 1..9),
        ) {
            let levels = table(errors);
            let hysteresis = Hysteresis::new(share).unwrap();
            let before = start % (levels.collapse_count() + 1);
            let now = hysteresis.level(&levels, before, error).unwrap();
            prop_assert!(levels.error(now).unwrap() <= error);
            for offset in offsets {
                let between = share + (1.0 - share) * offset;
                let later = if now < before { error / between } else { error * between };
                if now != before {
                    prop_assert_eq!(hysteresis.level(&levels, now, later).unwrap(), now);
                }
            }
        }
    }

    /// Returns a table with these errors, largest first.
    fn table(mut errors: Vec<f32>) -> LevelTable {
        errors.sort_unstable_by(f32::total_cmp);
        let count = errors.len() as u32;
        let mut strips = Strips::default();
        strips.push(&(0..count + 3).collect::<Vec<_>>());
        let renames: Vec<[Rename; 1]> =
            (0..count).map(|i| [Rename { removed: count + 2 - i, kept: count + 1 - i }]).collect();
        let collapses = renames.iter().zip(errors).map(|(renames, error)| (&renames[..], error));
        let vertex_count = count as usize + 3;
        let sequence = CollapseSequence::from_collapses(vertex_count, strips.to_list(), collapses).unwrap();
        LevelTable::of(&sequence)
    }

    #[test]
    fn without_a_share_no_level_is_too_fine() {
        let levels = table(vec![0.0, 0.0, 0.5]);
        let never = Hysteresis::new(0.0).unwrap();
        assert_eq!(never.level(&levels, 3, f32::INFINITY).unwrap(), 3);
        assert_eq!(never.level(&levels, 3, 0.0).unwrap(), 3);
        assert_eq!(never.level(&levels, 0, 0.1).unwrap(), 3);
        assert!(never.level(&levels, 0, f32::NAN).is_err());
    }

    #[test]
    fn a_view_that_comes_and_goes_jumps_over_the_range() {
        let levels = table((1..=100).map(|error| error as f32 / 100.0).collect());
        let hysteresis = Hysteresis::default();
        // The level with an error of e/100 is 100 − e.
        assert_eq!(hysteresis.level(&levels, 0, 0.5).unwrap(), 60);
        assert_eq!(hysteresis.level(&levels, 55, 0.5).unwrap(), 55);
        assert_eq!(hysteresis.level(&levels, 99, 0.5).unwrap(), 50);
        let mut moves = 0;
        let mut current = 100;
        for step in 0..1000 {
            let next = hysteresis.level(&levels, current, step as f32 / 1000.0).unwrap();
            moves += usize::from(next != current);
            current = next;
        }
        let without = (0..1000).filter(|&step| {
            let level = |step: i32| levels.level_of_error(step as f32 / 1000.0).unwrap();
            step > 0 && level(step) != level(step - 1)
        });
        assert!(4 * moves < without.count(), "{moves} moves");
    }
}
