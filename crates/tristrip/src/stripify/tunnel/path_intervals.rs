//! Path intervals represent the cover after the steps of a tunnel without modifying the cover.
//!
//! The cuts of a tunnel divide paths into a few dozen intervals of positions. The links of the
//! tunnel connect the ends of intervals.
//!
//! ```text
//!   path 4:  0 ━ 1 ━ 2 ━ 3 ━ 4 ━ 5      cut between 3 and 4, end 0 of path 9 linked to 3:
//!   path 9:  0 ━ 1 ━ 2                  intervals 4[0..=3], 4[4..=5], 9[0..=2]; the tip is the
//!                                       lower end of the second
//! ```
//!
//! # Complexity
//! A step takes O(number of previous steps).

use super::path_tags::PathTags;
use crate::ids::OptionalId;

/// A part of a path between cuts.
#[derive(Debug, Clone, Copy)]
struct PathInterval {
    path: u32,
    first: u32,
    last: u32,
    /// The ends of other intervals that its first and last triangle are linked to.
    links: [OptionalId; 2],
}

/// The data to undo a step.
#[derive(Debug, Clone, Copy)]
struct UndoRecord {
    /// The number of intervals, the tip and the number of loops before the step.
    interval_count: u32,
    tip: u32,
    loops: u32,
    /// The interval that the step split.
    split: u32,
    /// The ends that the step linked.
    linked: [u32; 2],
}

/// The intervals of a tunnel so far. The ends of interval `i` are `2 i` (at its first triangle) and
/// `2 i + 1` (at its last).
#[derive(Debug, Default)]
pub(super) struct PathIntervals {
    intervals: Vec<PathInterval>,
    undo_records: Vec<UndoRecord>,
    /// The current end of the tunnel.
    tip: u32,
    /// The number of loops that are currently closed.
    loops: u32,
}

impl PathIntervals {
    /// Starts at a terminal.
    pub(super) fn begin(&mut self, tags: &PathTags, terminal: u32) {
        self.intervals.clear();
        self.undo_records.clear();
        self.loops = 0;
        let interval = self.interval_of(tags, terminal);
        self.tip = 2 * interval + u32::from(tags.position(terminal) != 0);
    }

    /// Returns the interval of a triangle. Adds the whole path if the tunnel has not touched it
    /// yet.
    fn interval_of(&mut self, tags: &PathTags, triangle: u32) -> u32 {
        let (path, position) = (tags.path(triangle), tags.position(triangle));
        let contains = |i: &PathInterval| i.path == path && i.first <= position && position <= i.last;
        if let Some(interval) = self.intervals.iter().position(contains) {
            return interval as u32;
        }
        let last = tags.last_position(path);
        self.intervals.push(PathInterval { path, first: 0, last, links: [OptionalId::NONE; 2] });
        self.intervals.len() as u32 - 1
    }

    /// Links the tip to triangle `v`, then cuts `v` from its neighbour `b` on its path. `b` is the
    /// new tip. Returns whether they were still neighbours; otherwise nothing changes.
    pub(super) fn step(&mut self, tags: &PathTags, v: u32, b: u32) -> bool {
        let (interval_count, tip, loops) = (self.intervals.len() as u32, self.tip, self.loops);
        let split = self.interval_of(tags, v);
        let position = tags.position(v);
        let is_upward = tags.position(b) > position;
        let interval = self.intervals[split as usize];
        if position == if is_upward { interval.last } else { interval.first } {
            self.intervals.truncate(interval_count as usize);
            return false;
        }
        if loops > 0 && self.is_on_loop(split) {
            self.loops -= 1;
        }
        // The upper part becomes an interval of its own, with the previous upper end.
        let last = if is_upward { position } else { position - 1 };
        let upper = self.intervals.len() as u32;
        let [lower_link, upper_link] = interval.links;
        let upper_interval =
            PathInterval { first: last + 1, links: [OptionalId::NONE, upper_link], ..interval };
        self.intervals.push(upper_interval);
        self.intervals[split as usize] =
            PathInterval { last, links: [lower_link, OptionalId::NONE], ..interval };
        self.set_opposite_link(upper_link, 2 * upper + 1);
        let from = if tip == 2 * split + 1 { 2 * upper + 1 } else { tip };
        let cut = [2 * split + 1, 2 * upper];
        let [at_v, at_b] = if is_upward { cut } else { [cut[1], cut[0]] };
        if self.other_end(from) == at_v {
            self.loops += 1;
        }
        self.set_link(from, OptionalId::some(at_v));
        self.set_link(at_v, OptionalId::some(from));
        self.undo_records.push(UndoRecord { interval_count, tip, loops, split, linked: [from, at_v] });
        self.tip = at_b;
        true
    }

    /// Undoes the last step.
    pub(super) fn undo(&mut self) {
        let Some(record) = self.undo_records.pop() else { return };
        record.linked.into_iter().for_each(|end| self.set_link(end, OptionalId::NONE));
        if let Some(upper) = self.intervals.pop() {
            let lower = &mut self.intervals[record.split as usize];
            (lower.last, lower.links[1]) = (upper.last, upper.links[1]);
            self.set_opposite_link(upper.links[1], 2 * record.split + 1);
        }
        self.intervals.truncate(record.interval_count as usize);
        (self.tip, self.loops) = (record.tip, record.loops);
    }

    /// Returns whether the tunnel may end at terminal `x`: whether no loop remains when the tip is
    /// linked to it.
    pub(super) fn may_end_at(&mut self, tags: &PathTags, x: u32) -> bool {
        let interval_count = self.intervals.len();
        let i = self.interval_of(tags, x);
        let (interval, position) = (self.intervals[i as usize], tags.position(x));
        let is_free = |side: u32| {
            let is_terminal = position == if side == 0 { 0 } else { tags.last_position(interval.path) };
            is_terminal && interval.links[side as usize].is_none() && self.tip != 2 * i + side
        };
        let end = (0..2).find(|&side| is_free(side)).map(|side| 2 * i + side);
        let may_end = self.loops == 0 && end.is_some_and(|end| self.other_end(self.tip) != end);
        self.intervals.truncate(interval_count);
        may_end
    }

    /// Counts the loops that are currently closed. A later cut may open each of them.
    pub(super) fn loops(&self) -> u32 {
        self.loops
    }

    /// Follows a path from a free end to its other end.
    fn other_end(&self, mut end: u32) -> u32 {
        loop {
            end ^= 1;
            match self.link(end) {
                Some(next) => end = next,
                None => return end,
            }
        }
    }

    fn is_on_loop(&self, interval: u32) -> bool {
        let mut end = 2 * interval;
        while let Some(next) = self.link(end ^ 1) {
            if next / 2 == interval {
                return true;
            }
            end = next;
        }
        false
    }

    fn link(&self, end: u32) -> Option<u32> {
        self.intervals[end as usize / 2].links[end as usize % 2].get()
    }

    fn set_link(&mut self, end: u32, to: OptionalId) {
        self.intervals[end as usize / 2].links[end as usize % 2] = to;
    }

    /// Sets the link of the end that a link leads to, if there is one.
    fn set_opposite_link(&mut self, end: OptionalId, to: u32) {
        if let Some(end) = end.get() {
            self.set_link(end, OptionalId::some(to));
        }
    }
}
