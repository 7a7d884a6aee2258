//! The traits of all level-of-detail models: an immutable model, and cursors that select one of its
//! levels.
//!
//! A model is built once, shared by all its users and never modified. A cursor is small and belongs
//! to one instance of the model in a scene, or to one view. It moves between levels and returns the
//! display strips of the current level. Each kind of model stores its levels in its own way.
//!
//! ```text
//! Arc<model> ──▶ cursor: set_level, set_error, set_pixels ──▶ strips ──▶ update_indices
//!            └─▶ cursor of another instance
//! ```
//! All models of one [`CollapseSequence`](crate::CollapseSequence) have the same levels. The
//! [`LevelTable`] lists the triangle count and the error of each level.

use std::sync::Arc;

use super::hysteresis::Hysteresis;
use super::level_table::LevelTable;
use super::view::View;
use crate::error::Error;
use crate::strip::Strips;

/// A mesh at all its levels of detail.
///
/// ```
/// use std::sync::Arc;
/// use tristrip::lod::{Encoding, LevelModel, ProgressiveMesh, ProgressiveStrips};
/// use tristrip::{CollapseSequence, Rename, Strips};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3]);
/// let rename = [Rename { removed: 3, kept: 2 }];
/// let sequence = CollapseSequence::from_collapses(4, strips.to_list(), [(&rename[..], 0.5)])?;
/// let models: [Arc<dyn LevelModel>; 2] = [
///     Arc::new(ProgressiveMesh::new(&sequence)?),
///     Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?),
/// ];
/// for model in models {
///     let mut cursor = model.start();
///     assert_eq!(cursor.strips().triangles().count(), 2);
///     // An error of half a mesh unit is allowed, which selects level 0.
///     assert_eq!(cursor.set_error(0.5)?, 0);
///     assert_eq!(cursor.strips().triangles().collect::<Vec<_>>(), [[0, 1, 2]]);
/// }
/// # Ok::<(), tristrip::Error>(())
/// ```
pub trait LevelModel: Send + Sync {
    /// Returns the triangle count and the error of each level.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let model = ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?;
    /// assert_eq!((model.levels().collapse_count(), model.levels().triangle_count(0)?), (2, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn levels(&self) -> &LevelTable;

    /// Returns the memory of the model in bytes, excluding its cursors.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let memory = |encoding| ProgressiveStrips::new(&strips, &sequence, encoding).map(|model| model.memory());
    /// // One slot fewer to store.
    /// assert_eq!((memory(Encoding::Naive)?, memory(Encoding::Offsets)?), (92, 84));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn memory(&self) -> usize;

    /// Returns a cursor at the level of the full mesh.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let model: Arc<dyn LevelModel> = Arc::new(ProgressiveMesh::new(&sequence)?);
    /// // Two instances share the model; the distant one is drawn coarser.
    /// let (mut near, mut far) = (Arc::clone(&model).start(), model.start());
    /// far.set_level(0)?;
    /// assert_eq!((near.strips().triangles().count(), far.strips().triangles().count()), (3, 1));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn start(self: Arc<Self>) -> Box<dyn LevelCursor>;
}

/// The current level of a model, for one instance or view.
pub trait LevelCursor: Send {
    /// Returns the triangle count and the error of each level.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// let level = cursor.levels().level_of_triangles(2);
    /// cursor.set_level(level)?;
    /// assert_eq!(cursor.strips().triangles().count(), 2);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn levels(&self) -> &LevelTable;

    /// Returns the current level: 0 is the base mesh, and the number of collapses is the full mesh.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// assert_eq!(cursor.level(), 2);
    /// cursor.set_error(1.0)?;
    /// assert_eq!(cursor.level(), 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn level(&self) -> usize;

    /// Moves to a level.
    ///
    /// # Errors
    /// `level` is greater than the level of the full mesh. The cursor does not move.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// cursor.set_level(1)?;
    /// assert!(cursor.set_level(3).is_err());
    /// assert_eq!((cursor.level(), cursor.strips().triangles().count()), (1, 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn set_level(&mut self, level: usize) -> Result<(), Error>;

    /// Returns the display strips of the current level.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Offsets)?).start();
    /// assert_eq!(cursor.strips().vertices(), [0, 1, 2, 3, 4]);
    /// cursor.set_level(1)?;
    /// assert_eq!(cursor.strips().vertices(), [0, 1, 2, 3]);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn strips(&mut self) -> &Strips;

    /// Returns the memory of the cursor in bytes, excluding the model.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveStrips::new(&strips, &sequence, Encoding::Naive)?).start();
    /// let before = cursor.memory();
    /// let display = cursor.strips().memory();
    /// // The stored entries, the decoded entries, and the display strips.
    /// assert_eq!((before, cursor.memory()), (20, 20 + 20 + display));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn memory(&self) -> usize;

    /// Moves to the coarsest level with at most this error in mesh units, and returns that level.
    ///
    /// # Errors
    /// The error is negative or NaN.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// // The collapses have errors of 0.25 and 0.5.
    /// assert_eq!((cursor.set_error(0.6)?, cursor.set_error(0.3)?, cursor.set_error(0.1)?), (0, 1, 2));
    /// assert!(cursor.set_error(f32::NAN).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn set_error(&mut self, error: f32) -> Result<usize, Error> {
        let level = self.levels().level_of_error(error)?;
        self.set_level(level)?;
        Ok(level)
    }

    /// Moves to the finest level with at most this many triangles, and returns that level. If even
    /// the base mesh has more triangles, moves to the base mesh.
    ///
    /// # Errors
    /// [`LevelCursor::set_level`] fails, which cannot happen for a level of
    /// [`LevelCursor::levels`].
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// assert_eq!((cursor.set_triangles(2)?, cursor.strips().triangles().count()), (1, 2));
    /// assert_eq!(cursor.set_triangles(0)?, 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn set_triangles(&mut self, triangle_count: usize) -> Result<usize, Error> {
        let level = self.levels().level_of_triangles(triangle_count);
        self.set_level(level)?;
        Ok(level)
    }

    /// Moves to the coarsest level whose error covers at most this many pixels of a view, and
    /// returns that level.
    ///
    /// # Errors
    /// The number of pixels is negative or NaN.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// // At four pixels per mesh unit, an error of 0.25 covers one pixel and 0.5 covers two.
    /// let view = View::parallel(4.0)?;
    /// assert_eq!((cursor.set_pixels(1.0, view)?, cursor.set_pixels(2.0, view)?), (1, 0));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn set_pixels(&mut self, pixels: f32, view: View) -> Result<usize, Error> {
        self.set_error(view.length_of(pixels))
    }

    /// Moves only if the current level is too coarse or too fine for an error in mesh units, and
    /// returns the resulting level. If the level is too fine, moves to the level that
    /// [`LevelCursor::set_error`] chooses for this error. If it is too coarse, moves to the level
    /// that [`LevelCursor::set_error`] chooses for the hysteresis share of this error. Small camera
    /// movements therefore do not switch levels back and forth.
    ///
    /// # Errors
    /// The error is negative or NaN.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// // Levels 0, 1 and 2 have errors of 0.5, 0.25 and 0. The full mesh becomes too fine when a
    /// // coarser level has at most half of the allowed error.
    /// let half = Hysteresis::new(0.5)?;
    /// assert_eq!((cursor.follow_error(0.25, half)?, cursor.follow_error(0.5, half)?), (2, 0));
    /// // The base mesh is too coarse if less than its error is allowed. Level 2 is the coarsest
    /// // with at most half of the allowed error.
    /// assert_eq!((cursor.follow_error(0.6, half)?, cursor.follow_error(0.4, half)?), (0, 2));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn follow_error(&mut self, error: f32, hysteresis: Hysteresis) -> Result<usize, Error> {
        let level = hysteresis.level(self.levels(), self.level(), error)?;
        self.set_level(level)?;
        Ok(level)
    }

    /// Calls [`LevelCursor::follow_error`] for an error in pixels of a view.
    ///
    /// # Errors
    /// The number of pixels is negative or NaN.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut cursor = Arc::new(ProgressiveMesh::new(&sequence)?).start();
    /// let view = View::parallel(4.0)?;
    /// assert_eq!(cursor.follow_pixels(1.5, view, Hysteresis::default())?, 1);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    fn follow_pixels(&mut self, pixels: f32, view: View, hysteresis: Hysteresis) -> Result<usize, Error> {
        self.follow_error(view.length_of(pixels), hysteresis)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lod::samples::{Sample, samples, sorted};
    use crate::lod::{Encoding, Filter, ModelKind, ProgressiveStrips, RepairOptions, RepairedStrips};
    use crate::random::Random;
    use crate::strip::Layout;

    /// Returns every model of a sample.
    fn models(sample: &Sample) -> Vec<Arc<dyn LevelModel>> {
        let Sample { strips, sequence } = sample;
        let shared = Arc::new(sequence.clone());
        let of_kind = |kind: ModelKind| kind.build(strips, &shared).unwrap();
        let mut models: Vec<Arc<dyn LevelModel>> = ModelKind::ALL.into_iter().map(of_kind).collect();
        for encoding in Encoding::ALL {
            for filter in Filter::ALL {
                let model = ProgressiveStrips::new(strips, sequence, encoding).unwrap();
                models.push(Arc::new(model.with_filter(filter)));
            }
        }
        let repaired = RepairedStrips::new(sequence.clone(), strips.clone(), RepairOptions::default());
        models.push(Arc::new(repaired.unwrap()));
        models
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1))]

        /// Mistakes would accumulate over many moves.
        #[test]
        fn ten_thousand_moves_leave_every_model_exact(sample in samples(), seed in any::<u64>()) {
            let sequence = &sample.sequence;
            let oracle: Vec<_> = (0..=sequence.len()).map(|level| sorted(sequence.drawn(level).unwrap())).collect();
            for model in models(&sample) {
                let (mut cursor, mut random) = (model.start(), Random::new(seed));
                for _ in 0..10_000 {
                    let level = random.below(oracle.len());
                    cursor.set_level(level).unwrap();
                    prop_assert_eq!(&sorted(cursor.strips().triangles()), &oracle[level]);
                }
            }
        }
    }

    proptest! {
        /// The oracle is the list of triangles that the sequence draws.
        #[test]
        fn every_model_draws_every_level(sample in samples(), jumps in prop::collection::vec(any::<usize>(), 1..9)) {
            let sequence = &sample.sequence;
            for model in models(&sample) {
                prop_assert_eq!(model.levels().collapse_count(), sequence.len());
                prop_assert!(model.memory() > 0);
                let mut cursor = Arc::clone(&model).start();
                let mut buffer: Vec<u16> = Vec::new();
                let mut last = sequence.len();
                for jump in jumps.iter().map(|jump| jump % (sequence.len() + 1)) {
                    cursor.set_level(jump).unwrap();
                    prop_assert_eq!(cursor.level(), jump);
                    let strips = cursor.strips();
                    prop_assert_eq!(sorted(strips.triangles()), sorted(sequence.drawn(jump).unwrap()));
                    let before = buffer.clone();
                    let changed = strips.update_indices(Layout::Restart, &mut buffer).unwrap();
                    prop_assert_eq!(&buffer, &strips.to_indices::<u16>(Layout::Restart).unwrap());
                    let is_changed = |i: usize| changed.iter().any(|range| range.contains(&i));
                    prop_assert!((0..buffer.len()).all(|i| is_changed(i) || before.get(i) == Some(&buffer[i])));
                    prop_assert!(jump != last || before.is_empty() || changed.is_empty());
                    prop_assert!(cursor.memory() > 0 || sequence.triangles().is_empty());
                    last = jump;
                }
                let level = cursor.level();
                let error = cursor.set_level(sequence.len() + 1).unwrap_err().to_string();
                prop_assert!(error.ends_with("expected at most the level of the full mesh"), "{error}");
                prop_assert!(cursor.set_error(-1.0).is_err() && cursor.level() == level);
            }
        }
    }
}
