//! Views as levels of the sequence: every collapse of a level done, and no other.

use std::sync::Arc;

use super::SkipView;
use crate::error::Error;

impl SkipView {
    /// Moves to a level of the sequence, from whatever the view draws. Each collapse is done only where all that it needs is done, and each split after those
    /// that need it.
    ///
    /// # Errors
    /// There is no such level.
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
        // In the order of the nodes, what is read for one collapse is near what is read for the next.
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
        // What waits does not know of this.
        self.criteria = None;
        self.rebuild(&mut Vec::new());
        Ok(())
    }

    /// Moves between two levels of the sequence, of which the view has the first.
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
        // What waits does not know of this.
        self.criteria = None;
        self.rebuild(&mut Vec::new());
    }
}
