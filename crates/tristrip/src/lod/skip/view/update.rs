//! What an update of a view does: which collapses are due, what is wanted of them, and what follows from each.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use super::{MAX_SCALE, SkipView, ViewUpdate};
use crate::csr::Csr;
use crate::lod::skip::bounds::{Bounds, NodeBounds};
use crate::lod::skip::camera::CameraFrame;
use crate::lod::skip::criteria::{Choice, Criteria, ViewCriteria};
use crate::lod::skip::schedule::Schedule;

/// The largest factor by which a frame raises the allowed error to keep a budget.
const MAX_RISE: f64 = 2.0;
/// The groups of nodes by which collapses are read in the order of memory.
const GROUPS: usize = 4096;
/// Collapses that are read before the first of them is looked at.
const LOOKED_AT_ONCE: usize = 64;

/// What an update of a view works with.
struct Frame<'a> {
    criteria: Criteria,
    wanted: &'a ViewCriteria,
    schedule: Schedule,
    /// Whether everything is looked at.
    is_first: bool,
    splits: BinaryHeap<WantedSplit>,
}

/// A collapse that is to be split.
#[derive(Debug, Clone, Copy, PartialEq)]
struct WantedSplit {
    ratio: f64,
    leader: u32,
}

impl Eq for WantedSplit {}

impl Ord for WantedSplit {
    fn cmp(&self, other: &Self) -> Ordering {
        self.ratio.total_cmp(&other.ratio).then(other.leader.cmp(&self.leader))
    }
}

impl PartialOrd for WantedSplit {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Brings nodes that are near each other in memory near each other in a list, in linear time.
fn near_together(nodes: &mut Vec<u32>, node_count: usize) {
    let shift = node_count.div_ceil(GROUPS).max(1).next_power_of_two().ilog2();
    let groups = Csr::group_items(nodes.iter().map(|&node| (node >> shift, node)), GROUPS + 1);
    nodes.clear();
    groups.rows().for_each(|row| nodes.extend_from_slice(row));
}

impl SkipView {
    /// Does what a frame wants, at the current scale.
    pub(super) fn work(&mut self, frame: CameraFrame, wanted: &ViewCriteria, update: &mut ViewUpdate) {
        let model = Arc::clone(&self.model);
        let Some(bounds) = &model.bounds else { return };
        let farthest = frame.farthest((bounds.center, bounds.radius));
        let far = match &self.criteria {
            Some(before) if farthest <= before.far() => before.far(),
            _ => 2.0 * farthest,
        };
        let criteria = Criteria::new(frame, wanted, self.scale, far);
        let travel = self
            .criteria
            .as_ref()
            .and_then(|before| criteria.travel_from(before, (bounds.center, bounds.radius)));
        self.criteria = Some(criteria);
        let mut schedule = match self.schedule.take() {
            Some(schedule) => schedule,
            None => Schedule::new(model.tree.len(), bounds.radius),
        };
        let mut due = std::mem::take(&mut self.due);
        let travel = travel.filter(|&travel| !schedule.ends_with(travel));
        let is_first = travel.is_none();
        if let Some(travel) = travel {
            schedule.advance(travel, &mut due, &mut self.fresh);
            near_together(&mut due, model.tree.len());
        } else {
            schedule.clear();
            due.extend(self.candidates());
            schedule.make_due(&due);
        }
        let mut frame = Frame { criteria, wanted, schedule, is_first, splits: BinaryHeap::new() };
        self.look_at(&due, bounds, &mut frame, update);
        due.clear();
        self.due = due;
        self.process(bounds, &mut frame, update);
        self.schedule = Some(frame.schedule);
    }

    /// Returns the collapses that may be done or undone next.
    fn candidates(&self) -> Vec<u32> {
        let model = &self.model;
        let leaders = (0..model.tree.len() as u32)
            .filter(|&node| model.tree.parent(node).is_some() && model.tree.leader(node) == node);
        let may_change = |&leader: &u32| {
            self.state.is_last(leader, &model.tree) || self.state.can_collapse(leader, &model.dependencies)
        };
        leaders.filter(may_change).collect()
    }

    /// Looks at what is due: what is to change is wanted, and the others wait.
    fn look_at(&mut self, due: &[u32], bounds: &Bounds, frame: &mut Frame, update: &mut ViewUpdate) {
        update.looked_at += due.len();
        // Reading all of a block first lets the reads overlap.
        let mut block = [(NodeBounds::default(), false); LOOKED_AT_ONCE];
        for leaders in due.chunks(LOOKED_AT_ONCE) {
            for (slot, &leader) in block.iter_mut().zip(leaders) {
                *slot = (bounds.nodes[leader as usize], self.state.is_done(leader));
            }
            for ((node, is_done), &leader) in block.iter().zip(leaders) {
                self.choose(leader, node, *is_done, frame);
            }
        }
    }

    /// Chooses for a collapse, which is wanted to change then or waits.
    fn choose(&mut self, leader: u32, node: &NodeBounds, is_done: bool, frame: &mut Frame) {
        match frame.criteria.choose(node, is_done) {
            Choice::Stay { travel } => frame.schedule.wait(leader, travel),
            Choice::Change { ratio } if is_done => frame.splits.push(WantedSplit { ratio, leader }),
            Choice::Change { .. } => self.wanted.push(leader),
        }
    }

    /// Does what is wanted: collapses first, then splits, those with the largest errors first.
    fn process(&mut self, bounds: &Bounds, frame: &mut Frame, update: &mut ViewUpdate) {
        let model = Arc::clone(&self.model);
        let (tree, dependencies) = (&model.tree, &model.dependencies);
        let steps = frame.wanted.steps().unwrap_or(usize::MAX);
        let mut unfit = Vec::new();
        let is_over = |update: &ViewUpdate| update.collapses + update.splits >= steps;
        while !is_over(update) {
            if let Some(leader) = self.wanted.pop() {
                if !frame.schedule.is_due(leader) || !self.state.can_collapse(leader, dependencies) {
                    continue;
                }
                let replaced = tree.members(leader).flat_map(|node| [Some(node), tree.parent(node)]);
                let replaced: Vec<u32> =
                    replaced.flatten().filter_map(|node| self.state.active_child(node)).collect();
                self.collapse(leader);
                update.collapses += 1;
                for child in replaced.into_iter().map(|child| tree.leader(child)) {
                    if !self.state.is_last(child, tree) {
                        frame.schedule.cancel(child);
                    }
                }
                self.fresh.push(leader);
                self.fresh.extend(dependencies.dependents(leader).filter(|&d| !self.state.is_done(d)));
            } else if let Some(leader) = self.fresh.pop() {
                self.look_at_fresh(leader, bounds, frame, update);
            } else if let Some(next) = frame.splits.pop() {
                if !frame.schedule.is_due(next.leader) || !self.state.is_last(next.leader, tree) {
                    continue;
                }
                if !self.split_within(next.leader, frame.wanted.budget()) {
                    if next.ratio.is_infinite() {
                        // The eye is within its sphere: no error that is allowed makes room.
                        unfit.push(next.leader);
                        continue;
                    }
                    // Of a view that was not looked at before, all ratios are known, and the largest that does not fit is the right one.
                    let most = if frame.is_first { MAX_SCALE / self.scale } else { MAX_RISE };
                    self.scale *= next.ratio.min(most).max(1.0 + 1e-6);
                    frame.splits.push(next);
                    break;
                }
                update.splits += self.split.len();
                for i in 0..self.split.len() {
                    let leader = self.split[i];
                    self.fresh.push(leader);
                    dependencies.dependents(leader).for_each(|dependent| frame.schedule.cancel(dependent));
                    for node in tree.members(leader) {
                        let children = [Some(node), tree.parent(node)].into_iter().flatten();
                        let active = children.filter_map(|node| self.state.active_child(node));
                        self.fresh.extend(active.map(|child| tree.leader(child)));
                    }
                }
            } else {
                break;
            }
        }
        // What is left is wanted again at the next update.
        let splits = frame.splits.drain().map(|split| split.leader);
        let left = self.fresh.drain(..).chain(self.wanted.drain(..)).chain(splits).chain(unfit);
        let before = frame.schedule.left_count();
        frame.schedule.leave(left);
        update.is_complete &= !is_over(update) || frame.schedule.left_count() == before;
    }

    /// Looks at a collapse that has become the next one of its vertices, or may have.
    fn look_at_fresh(&mut self, leader: u32, bounds: &Bounds, frame: &mut Frame, update: &mut ViewUpdate) {
        let is_done = self.state.is_done(leader);
        let may_change = if is_done {
            self.state.is_last(leader, &self.model.tree)
        } else {
            self.state.can_collapse(leader, &self.model.dependencies)
        };
        if may_change {
            frame.schedule.make_due(&[leader]);
            update.looked_at += 1;
            self.choose(leader, &bounds.nodes[leader as usize], is_done, frame);
        }
    }
}
