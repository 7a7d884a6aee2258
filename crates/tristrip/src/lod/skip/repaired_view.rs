//! A view with repaired strips: paths over its triangles that are updated around each collapse and
//! split.
//!
//! Display strips that are filtered from the strips of the full mesh break up as a view gets
//! coarser. This view has strips of its own triangles instead. `repair` keeps their cost close to
//! that of strips built from scratch. This is not part of the published algorithm.
//!
//! Each update writes all strips again, which takes time proportional to the triangles of the view.
//!
//! # Complexity
//! Each collapse and split takes the time of [`Repair`](crate::lod::Repair). Each update takes O(t)
//! time for t drawn triangles. A view takes 64 bytes per triangle of the full mesh.

use std::sync::Arc;

use super::{Camera, SkipStrips, SkipView, ViewCriteria, ViewUpdate};
use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::lod::level::level_model::LevelCursor;
use crate::lod::repair::{Repair, RepairOptions};
use crate::strip::Strips;
use crate::text::counted;

/// A view of a model with repaired strips.
///
/// ```
#[doc = include_str!("example.txt")]
/// let mut view = RepairedView::new(&model, &strips, sequence.clone(), RepairOptions::default())?;
/// view.update(&Camera::new([4.0, 1.0, 4.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(0.5))?;
/// assert_eq!(view.strips().triangles().count(), view.view().triangle_count());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct RepairedView {
    view: SkipView,
    repair: Repair,
    /// The level that each collapse leads to, by collapse id.
    levels: Vec<u32>,
    /// Whether each collapse is applied in the strips, by collapse id.
    is_collapsed: Vec<bool>,
}

impl RepairedView {
    /// Creates a view at the base mesh. `strips` and `sequence` must be the ones that the model was
    /// built from.
    ///
    /// # Errors
    /// The model was built from a different sequence, or the strips do not draw its full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut view = RepairedView::new(&model, &strips, sequence.clone(), RepairOptions::default())?;
    /// assert_eq!(view.strips().triangles().count(), sequence.triangle_count(0)?);
    /// assert!(RepairedView::new(&model, &strips, sequence.with_base(1)?, RepairOptions::default()).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(
        model: &Arc<SkipStrips>,
        strips: &Strips,
        sequence: impl Into<Arc<CollapseSequence>>,
        options: RepairOptions,
    ) -> Result<Self, Error> {
        let sequence = sequence.into();
        let order = &model.order;
        let is_same = |(collapse_id, collapse): (&crate::ids::OptionalId, crate::collapse::Collapse<'_>)| {
            collapse_id.get().map(|collapse_id| model.tree.vertex(collapse_id))
                == collapse.renames.first().map(|r| r.removed)
        };
        if order.len() != sequence.len() || !order.iter().zip(sequence.iter()).all(is_same) {
            let found = format!("a different sequence of {}", counted(sequence.len(), "collapse"));
            return Err(Error::Parameter { name: "sequence", found, expected: "the sequence of the model" });
        }
        let mut levels = vec![0; model.tree.len()];
        let mut is_collapsed = vec![false; model.tree.len()];
        for (number, collapse_id) in order.iter().enumerate() {
            if let Some(collapse_id) = collapse_id.get() {
                levels[collapse_id as usize] = (order.len() - 1 - number) as u32;
                is_collapsed[collapse_id as usize] = true;
            }
        }
        Ok(Self {
            view: model.view_without_strips(),
            repair: Repair::in_any_order(&sequence, strips, options)?,
            levels,
            is_collapsed,
        })
    }

    /// Moves the view to the detail that a camera needs, as [`SkipView::update`] does, and repairs
    /// the strips. The changed ranges are not reported.
    ///
    /// # Errors
    /// The model has no positions, or [`ViewCriteria::check`] fails.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut view = RepairedView::new(&model, &strips, sequence.clone(), RepairOptions::default())?;
    /// let update = view.update(&Camera::new([4.0, 1.0, 4.0], [4.0, 0.0, 4.0])?, &ViewCriteria::default().with_pixels(0.5))?;
    /// assert!(update.splits > 0);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn update(&mut self, camera: &Camera, criteria: &ViewCriteria) -> Result<ViewUpdate, Error> {
        let update = self.view.update(camera, criteria)?;
        for collapse_id in self.view.take_moved() {
            let (level, is_collapsed) =
                (self.levels[collapse_id as usize] as usize, &mut self.is_collapsed[collapse_id as usize]);
            if *is_collapsed {
                self.repair.split_from(level);
            } else {
                self.repair.collapse_to(level);
            }
            *is_collapsed = !*is_collapsed;
        }
        Ok(update)
    }

    /// Returns the underlying view, which has no display strips.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let view = RepairedView::new(&model, &strips, sequence.clone(), RepairOptions::default())?;
    /// assert!(view.view().indices().is_empty());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn view(&self) -> &SkipView {
        &self.view
    }

    /// Returns the repaired strips. They use the vertex ids of the full mesh.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let mut view = RepairedView::new(&model, &strips, sequence.clone(), RepairOptions::default())?;
    /// assert!(view.strips().vertices_sent() <= model.view().display_strips().vertices_sent());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn strips(&mut self) -> &Strips {
        self.repair.strips()
    }

    /// Returns the memory of the view in bytes, excluding the model.
    ///
    /// ```
    #[doc = include_str!("example.txt")]
    /// let view = RepairedView::new(&model, &strips, sequence.clone(), RepairOptions::default())?;
    /// assert!(view.memory() > model.view().memory());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn memory(&self) -> usize {
        self.view.memory()
            + LevelCursor::memory(&self.repair)
            + size_of_val(&self.levels[..])
            + size_of_val(&self.is_collapsed[..])
    }
}
