//! Levels of the sequence as views: exactly the collapses of a level are applied.

use std::sync::Arc;

use super::SkipView;
use crate::error::Error;

impl SkipView {
    /// Moves the view from any state to a level of the sequence. A collapse is applied after its
    /// dependencies, and split after the collapses that depend on it.
    ///
    /// # Errors
    /// `level` is greater than the level of the full mesh.
    ///
    /// ```
    #[doc = include_str!("../example.txt")]
    /// let mut view = model.view();
    /// view.set_level(20)?;
    /// assert_eq!(view.triangle_count(), sequence.triangle_count(20)?);
    /// assert!(view.set_level(100).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn set_level(&mut self, level: usize) -> Result<(), Error> {
        let model = Arc::clone(&self.model);
        model.levels.check(level)?;
        let mut is_target = vec![false; model.tree.len()];
        let done = &model.order[..model.order.len() - level];
        done.iter()
            .filter_map(|collapse_id| collapse_id.get())
            .for_each(|collapse_id| is_target[collapse_id as usize] = true);
        let is_leader = |node: u32| model.tree.parent(node).is_some() && model.tree.collapse_id(node) == node;
        // In node order, consecutive collapses read nearby memory.
        for node in (0..model.tree.len() as u32).filter(|&node| is_leader(node)) {
            if self.state.is_collapsed(node) && !is_target[node as usize] {
                self.split_within(node, None);
            }
        }
        let mut collapsed = std::mem::take(&mut self.split);
        for node in (0..model.tree.len() as u32).rev().filter(|&node| is_leader(node)) {
            if is_target[node as usize] {
                collapsed.clear();
                self.state.force_collapse(node, (&model.tree, &model.dependencies), &mut collapsed);
                collapsed.iter().for_each(|&collapse_id| self.count_collapse(collapse_id));
            }
        }
        self.split = collapsed;
        // The schedule is out of date: the next update must evaluate all collapses.
        self.criteria = None;
        self.rebuild(&mut Vec::new());
        Ok(())
    }

    /// Moves between two levels of the sequence. The view must be at level `from`.
    pub(in crate::lod::skip) fn move_between(&mut self, from: usize, to: usize) {
        let model = Arc::clone(&self.model);
        let number = |level: usize| model.order.len() - level;
        let between = &model.order[number(from.max(to))..number(from.min(to))];
        if to < from {
            between
                .iter()
                .filter_map(|collapse_id| collapse_id.get())
                .for_each(|collapse_id| self.collapse(collapse_id));
        } else {
            for collapse_id in between.iter().rev().filter_map(|collapse_id| collapse_id.get()) {
                self.split_within(collapse_id, None);
            }
        }
        // The schedule is out of date: the next update must evaluate all collapses.
        self.criteria = None;
        self.rebuild(&mut Vec::new());
    }
}
