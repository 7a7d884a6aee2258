//! A tunnel under construction: its steps so far, and the steps that a depth-first search has yet
//! to try.

use super::accesses::{AccessCounter, SearchOutcome};
use super::context::SearchContext;
use super::path_intervals::PathIntervals;
use super::path_tags::TunnelStep;

/// The state of a depth-first search from one terminal.
#[derive(Debug, Default)]
pub(in crate::stripify) struct PartialTunnel {
    intervals: PathIntervals,
    steps: Vec<TunnelStep>,
    /// The steps to try, each with the number of steps before it.
    candidates: Vec<(usize, TunnelStep)>,
}

impl PartialTunnel {
    /// Starts at a terminal.
    pub(in crate::stripify) fn begin(&mut self, context: &SearchContext<'_>, terminal: u32) {
        self.intervals.begin(context.tags, terminal);
        self.steps.clear();
        self.candidates.clear();
    }

    /// Returns the steps so far. A complete tunnel ends with a red edge.
    #[inline]
    pub(in crate::stripify) fn steps(&self) -> &[TunnelStep] {
        &self.steps
    }

    /// Counts the loops that are currently closed.
    #[inline]
    pub(in crate::stripify) fn loops(&self) -> u32 {
        self.intervals.loops()
    }

    /// Adds steps to try from the tip. The last one is tried first.
    #[inline]
    pub(in crate::stripify) fn add_candidates(&mut self, steps: impl Iterator<Item = TunnelStep>) {
        let depth = self.steps.len();
        self.candidates.extend(steps.map(|step| (depth, step)));
    }

    /// Adds all steps from a triangle, the tip, to those to try.
    pub(super) fn add_all_candidates(&mut self, context: &SearchContext<'_>, from: u32) {
        let (depth, candidates) = (self.steps.len(), &mut self.candidates);
        context.for_each_step(&self.steps, from, |step, _| candidates.push((depth, step)));
    }

    /// Tries steps until one ends the tunnel without a loop, none are left, or `max_accesses` have
    /// been tried. Calls `visit` with every step over two triangles `v` and `b`; it may add the
    /// step and further steps to try.
    #[inline]
    pub(in crate::stripify) fn search(
        &mut self,
        context: &SearchContext<'_>,
        counter: &mut AccessCounter<'_>,
        max_accesses: u64,
        mut visit: impl FnMut(&mut Self, TunnelStep, [u32; 2]),
    ) -> SearchOutcome {
        for _ in 0..max_accesses {
            let Some((depth, step)) = self.candidates.pop() else { break };
            if !counter.count(context.cover) {
                return SearchOutcome::Stopped;
            }
            while self.steps.len() > depth {
                self.steps.pop();
                self.intervals.undo();
            }
            let Some(v) = context.across(step.red) else { continue };
            if let Some(b) = step.black.get().and_then(|black| context.across(black)) {
                visit(self, step, [v, b]);
            } else if self.intervals.may_end_at(context.tags, v) {
                self.steps.push(step);
                return SearchOutcome::Found;
            }
        }
        SearchOutcome::NotFound
    }

    /// Adds a step over triangle `v` to `b` if their black edge is not cut and at most `max_loops`
    /// loops are then closed. Returns whether the step was added.
    #[inline]
    pub(in crate::stripify) fn try_step(
        &mut self,
        context: &SearchContext<'_>,
        step: TunnelStep,
        [v, b]: [u32; 2],
        max_loops: u32,
    ) -> bool {
        if !self.intervals.step(context.tags, v, b) {
            return false;
        }
        if self.intervals.loops() > max_loops {
            self.intervals.undo();
            return false;
        }
        self.steps.push(step);
        true
    }
}
