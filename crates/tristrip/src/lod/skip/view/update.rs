//! The update of a view: finds the collapses whose choice may have changed, and applies the
//! resulting collapses and splits.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use super::{MAX_SCALE, SkipView, ViewUpdate};
use crate::csr::Csr;
use crate::lod::skip::bounds::{NodeBounds, TreeBounds};
use crate::lod::skip::camera::CameraFrame;
use crate::lod::skip::criteria::{CollapseChoice, Criteria, ViewCriteria};
use crate::lod::skip::schedule::Schedule;

/// The maximum factor by which one frame raises the allowed error to keep the budget.
const MAX_RISE: f64 = 2.0;
/// The number of node groups by which collapses are ordered roughly by memory address.
const GROUPS: usize = 4096;
/// The number of collapses whose bounds are loaded before the first of them is evaluated.
const LOOKED_AT_ONCE: usize = 64;

/// The working data of an update.
struct Frame<'a> {
    criteria: Criteria,
    view_criteria: &'a ViewCriteria,
    schedule: Schedule,
    /// Whether all candidates are evaluated.
    is_first: bool,
    splits: BinaryHeap<PendingSplit>,
}

/// A collapse to split.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PendingSplit {
    ratio: f64,
    collapse_id: u32,
}

impl Eq for PendingSplit {}

impl Ord for PendingSplit {
    fn cmp(&self, other: &Self) -> Ordering {
        self.ratio.total_cmp(&other.ratio).then(other.collapse_id.cmp(&self.collapse_id))
    }
}

impl PartialOrd for PendingSplit {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Orders nodes roughly by memory address, in linear time.
fn near_together(nodes: &mut Vec<u32>, node_count: usize) {
    let shift = node_count.div_ceil(GROUPS).max(1).next_power_of_two().ilog2();
    let groups = Csr::group_items(nodes.iter().map(|&node| (node >> shift, node)), GROUPS + 1);
    nodes.clear();
    groups.rows().for_each(|row| nodes.extend_from_slice(row));
}

impl SkipView {
    /// Moves the view to the detail of a frame, at the current scale.
    pub(super) fn work(&mut self, frame: CameraFrame, view_criteria: &ViewCriteria, update: &mut ViewUpdate) {
        let model = Arc::clone(&self.model);
        let Some(bounds) = &model.bounds else { return };
        let farthest = frame.farthest((bounds.center, bounds.radius));
        let far = match &self.criteria {
            Some(before) if farthest <= before.far() => before.far(),
            _ => 2.0 * farthest,
        };
        let criteria = Criteria::new(frame, view_criteria, self.scale, far);
        let travel = self
            .criteria
            .as_ref()
            .and_then(|before| criteria.travel_from(before, (bounds.center, bounds.radius)));
        self.criteria = Some(criteria);
        let mut schedule = match self.schedule.take() {
            Some(schedule) => schedule,
            None => Schedule::new(model.tree.len(), bounds.radius),
        };
        let mut expired = std::mem::take(&mut self.expired);
        let travel = travel.filter(|&travel| !schedule.ends_with(travel));
        let is_first = travel.is_none();
        if let Some(travel) = travel {
            schedule.advance(travel, &mut expired, &mut self.new_candidates);
            near_together(&mut expired, model.tree.len());
        } else {
            schedule.clear();
            expired.extend(self.candidates());
            schedule.expire(&expired);
        }
        let mut frame = Frame { criteria, view_criteria, schedule, is_first, splits: BinaryHeap::new() };
        self.look_at(&expired, bounds, &mut frame, update);
        expired.clear();
        self.expired = expired;
        self.process(bounds, &mut frame, update);
        self.schedule = Some(frame.schedule);
    }

    /// Returns the collapses that can be applied or undone next.
    fn candidates(&self) -> Vec<u32> {
        let model = &self.model;
        let collapse_ids = (0..model.tree.len() as u32)
            .filter(|&node| model.tree.parent(node).is_some() && model.tree.collapse_id(node) == node);
        let may_change = |&collapse_id: &u32| {
            self.state.is_last(collapse_id, &model.tree)
                || self.state.can_collapse(collapse_id, &model.dependencies)
        };
        collapse_ids.filter(may_change).collect()
    }

    /// Evaluates collapses whose schedule entry expired. Those that change are listed, the others
    /// are scheduled again.
    fn look_at(&mut self, expired: &[u32], bounds: &TreeBounds, frame: &mut Frame, update: &mut ViewUpdate) {
        update.looked_at += expired.len();
        // Loading a whole block first lets the memory accesses overlap.
        let mut block = [(NodeBounds::default(), false); LOOKED_AT_ONCE];
        for collapse_ids in expired.chunks(LOOKED_AT_ONCE) {
            for (slot, &collapse_id) in block.iter_mut().zip(collapse_ids) {
                *slot = (bounds.nodes[collapse_id as usize], self.state.is_collapsed(collapse_id));
            }
            for ((node, is_collapsed), &collapse_id) in block.iter().zip(collapse_ids) {
                self.choose(collapse_id, node, *is_collapsed, frame);
            }
        }
    }

    /// Evaluates a collapse, and then lists it as a change or schedules it.
    fn choose(&mut self, collapse_id: u32, node: &NodeBounds, is_collapsed: bool, frame: &mut Frame) {
        match frame.criteria.choose(node, is_collapsed) {
            CollapseChoice::Stay { travel } => frame.schedule.wait(collapse_id, travel),
            CollapseChoice::Change { ratio } if is_collapsed => {
                frame.splits.push(PendingSplit { ratio, collapse_id })
            }
            CollapseChoice::Change { .. } => self.to_collapse.push(collapse_id),
        }
    }

    /// Applies the listed changes: collapses first, then splits, largest error first.
    fn process(&mut self, bounds: &TreeBounds, frame: &mut Frame, update: &mut ViewUpdate) {
        let model = Arc::clone(&self.model);
        let (tree, dependencies) = (&model.tree, &model.dependencies);
        let steps = frame.view_criteria.steps.unwrap_or(usize::MAX);
        let mut unfit = Vec::new();
        let is_over = |update: &ViewUpdate| update.collapses + update.splits >= steps;
        while !is_over(update) {
            if let Some(collapse_id) = self.to_collapse.pop() {
                if !frame.schedule.has_expired(collapse_id)
                    || !self.state.can_collapse(collapse_id, dependencies)
                {
                    continue;
                }
                let replaced = tree.members(collapse_id).flat_map(|node| [Some(node), tree.parent(node)]);
                let replaced: Vec<u32> =
                    replaced.flatten().filter_map(|node| self.state.active_child(node)).collect();
                self.collapse(collapse_id);
                update.collapses += 1;
                for child in replaced.into_iter().map(|child| tree.collapse_id(child)) {
                    if !self.state.is_last(child, tree) {
                        frame.schedule.cancel(child);
                    }
                }
                self.new_candidates.push(collapse_id);
                self.new_candidates
                    .extend(dependencies.dependents(collapse_id).filter(|&d| !self.state.is_collapsed(d)));
            } else if let Some(collapse_id) = self.new_candidates.pop() {
                self.look_at_candidate(collapse_id, bounds, frame, update);
            } else if let Some(next) = frame.splits.pop() {
                if !frame.schedule.has_expired(next.collapse_id)
                    || !self.state.is_last(next.collapse_id, tree)
                {
                    continue;
                }
                if !self.split_within(next.collapse_id, frame.view_criteria.budget) {
                    if next.ratio.is_infinite() {
                        // The eye is inside the sphere, so raising the allowed error does not help.
                        unfit.push(next.collapse_id);
                        continue;
                    }
                    // The first update of a view knows all ratios. The largest one that does not
                    // fit gives the scale.
                    let most = if frame.is_first { MAX_SCALE / self.scale } else { MAX_RISE };
                    self.scale *= next.ratio.min(most).max(1.0 + 1e-6);
                    frame.splits.push(next);
                    break;
                }
                update.splits += self.split.len();
                for i in 0..self.split.len() {
                    let collapse_id = self.split[i];
                    self.new_candidates.push(collapse_id);
                    dependencies
                        .dependents(collapse_id)
                        .for_each(|dependent| frame.schedule.cancel(dependent));
                    for node in tree.members(collapse_id) {
                        let children = [Some(node), tree.parent(node)].into_iter().flatten();
                        let active = children.filter_map(|node| self.state.active_child(node));
                        self.new_candidates.extend(active.map(|child| tree.collapse_id(child)));
                    }
                }
            } else {
                break;
            }
        }
        // The next update evaluates the remaining changes again.
        let splits = frame.splits.drain().map(|split| split.collapse_id);
        let left = self.new_candidates.drain(..).chain(self.to_collapse.drain(..)).chain(splits).chain(unfit);
        let before = frame.schedule.left_count();
        frame.schedule.leave(left);
        update.is_complete &= !is_over(update) || frame.schedule.left_count() == before;
    }

    /// Evaluates a collapse that may have become the next one of its vertices.
    fn look_at_candidate(
        &mut self,
        collapse_id: u32,
        bounds: &TreeBounds,
        frame: &mut Frame,
        update: &mut ViewUpdate,
    ) {
        let is_collapsed = self.state.is_collapsed(collapse_id);
        let may_change = if is_collapsed {
            self.state.is_last(collapse_id, &self.model.tree)
        } else {
            self.state.can_collapse(collapse_id, &self.model.dependencies)
        };
        if may_change {
            frame.schedule.expire(&[collapse_id]);
            update.looked_at += 1;
            self.choose(collapse_id, &bounds.nodes[collapse_id as usize], is_collapsed, frame);
        }
    }
}
