//! Paths as lists of segments. Many rotations, joins and cuts are possible between two
//! renumberings, without visiting the triangles.
//!
//! ```text
//!   as numbered    path 0  ●━●━●━●━●━●━●━●      path 1  ○━○━○━○
//!   as they are    path    [0: 0–2] [0: 7–5] [1: 1–3]      path    [1: 0–0] [0: 4–3]
//! ```
//! # Algorithm
//! Each triangle stores its path and position at the last numbering. A current path is a list of
//! *segments*. Each segment is a range of positions of a numbered path, forward or backward. A
//! rotation at an end splits one segment and reverses those after it; no triangle is visited. The
//! segment of a triangle is found by its numbered position among the segments of all changed paths.
//! When there are many segments, [`SegmentedPaths::renumber_touched`] renumbers the changed paths.
//! Each path keeps the positions of its first segment if that is the start of a numbered path.
//!
//! The links of the cover change along with the segments, so the cover is always valid.
//!
//! # Complexity
//! A change takes O(segments). Renumbering takes O(triangles of the touched paths). 12 bytes per
//! triangle, up to 8 more while paths grow, and 24 bytes per path.

mod segment;
mod steps;
#[cfg(test)]
mod tests;

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::random::Random;
use segment::{PathPosition, Segment, SegmentedPath};

/// The value of [`PathCover::packed_edges`] for a missing link.
const NO_EDGE: u32 = 3;

/// A change of a link, by its half-edge.
#[derive(Debug, Clone, Copy)]
enum LinkChange {
    Linked(u32),
    Cut(u32),
}

/// A saved state.
#[derive(Debug, Default)]
struct SavedPaths {
    changed: Vec<SegmentedPath>,
    changed_count: usize,
    segment_count: usize,
    touched_count: usize,
    path_count: usize,
}

/// An end of a path from which a walk continues.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct WalkEnd {
    /// The changed path whose tail is the end.
    path: usize,
    /// The half-edge that a step must not link, because it would undo the previous step.
    back: Option<u32>,
}

/// The result of a step from an end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WalkStep {
    /// Two paths were joined.
    Joined,
    /// The end moved.
    Moved(WalkEnd),
    /// The only step from this end leads back.
    Stuck,
}

/// The paths of a cover, prepared for many changes.
#[derive(Debug)]
pub(super) struct SegmentedPaths<'a> {
    graph: &'a DualGraph,
    cover: &'a mut PathCover,
    /// The position of each triangle at the last numbering.
    positions: Vec<PathPosition>,
    /// The triangles of each numbered path.
    paths: Vec<Vec<u32>>,
    /// The numbers of the paths in use, and the index of each in this list.
    alive: Vec<u32>,
    alive_at: Vec<u32>,
    /// Unused path numbers.
    spare: Vec<u32>,
    path_count: usize,
    /// Numbered paths touched since the numbering. Their `marks` equal `mark`.
    touched: Vec<u32>,
    marks: Vec<u32>,
    mark: u32,
    /// The current paths made of the touched ones. The first `changed_count` are in use.
    changed: Vec<SegmentedPath>,
    changed_count: usize,
    segment_count: usize,
    /// Half-edges linked and cut since the state was saved.
    journal: Vec<LinkChange>,
    saved: SavedPaths,
}

impl<'a> SegmentedPaths<'a> {
    /// Numbers the paths of a cover.
    pub(super) fn new(graph: &'a DualGraph, cover: &'a mut PathCover) -> Self {
        let mut paths = Self {
            graph,
            positions: vec![PathPosition { path: 0, position: 0 }; cover.len()],
            cover,
            paths: Vec::new(),
            alive: Vec::new(),
            alive_at: Vec::new(),
            spare: Vec::new(),
            path_count: 0,
            touched: Vec::new(),
            marks: Vec::new(),
            mark: 1,
            changed: Vec::new(),
            changed_count: 0,
            segment_count: 0,
            journal: Vec::new(),
            saved: SavedPaths::default(),
        };
        paths.number();
        paths
    }

    /// Counts the paths.
    pub(super) fn path_count(&self) -> usize {
        self.path_count
    }

    /// Counts the segments since the numbering, which determine the cost of a change.
    pub(super) fn segment_count(&self) -> usize {
        self.segment_count
    }

    /// Counts the numbered paths touched since the numbering.
    pub(super) fn touched_count(&self) -> usize {
        self.touched.len()
    }

    /// Numbers all paths, in order of their lower ends.
    fn number(&mut self) {
        let mut is_numbered = vec![false; self.positions.len()];
        for start in 0..self.positions.len() as u32 {
            if is_numbered[start as usize] || !self.is_end(start) {
                continue;
            }
            let number = self.paths.len() as u32;
            let mut path = Vec::new();
            let (mut t, mut exit) = (start, self.linked_edges(start).0);
            loop {
                self.positions[t as usize] = PathPosition { path: number, position: path.len() as u32 };
                is_numbered[t as usize] = true;
                path.push(t);
                if exit == NO_EDGE {
                    break;
                }
                let entry = self.twin(3 * t + exit);
                t = entry / 3;
                let (a, b) = self.cover.packed_edges(t);
                exit = if a == entry % 3 { b } else { a };
            }
            self.paths.push(path);
        }
        self.path_count = self.paths.len();
        self.alive = (0..self.path_count as u32).collect();
        self.alive_at.clone_from(&self.alive);
        self.marks.resize(self.path_count, 0);
    }

    /// Returns the edges over which a triangle is linked. `NO_EDGE` comes last.
    #[inline]
    fn linked_edges(&self, t: u32) -> (u32, u32) {
        let (a, b) = self.cover.packed_edges(t);
        if a == NO_EDGE { (b, a) } else { (a, b) }
    }

    /// Chooses a random end of a random path. Reverses the path if necessary, so the end is its
    /// tail.
    pub(super) fn random_end(&mut self, random: &mut Random) -> WalkEnd {
        let number = self.alive[random.below(self.alive.len())];
        let mut path = self.changed_count;
        if self.marks[number as usize] == self.mark {
            // The numbered path has changed: choose any of the changed paths.
            while path == self.changed_count || self.changed[path].segments.is_empty() {
                path = random.below(self.changed_count);
            }
        } else {
            self.touch(number);
        }
        if random.coin() {
            self.changed[path].reverse();
        }
        WalkEnd { path, back: None }
    }

    /// Returns the triangle of an end, and the half-edge that leads back.
    pub(super) fn triangle_and_back(&self, end: WalkEnd) -> (u32, Option<u32>) {
        (self.changed[end.path].tail, end.back)
    }

    /// Prepares a walk from the end of a path. Its first step must not link the half-edge `back`.
    /// Returns `None` if the triangle is not an end.
    pub(super) fn walk_end(&mut self, end: u32, back: Option<u32>) -> Option<WalkEnd> {
        if !self.is_end(end) {
            return None;
        }
        let (path, _) = self.locate(end);
        if self.changed[path].tail != end {
            self.changed[path].reverse();
        }
        Some(WalkEnd { path, back })
    }

    /// Converts an untouched numbered path to a changed path of one segment.
    fn touch(&mut self, number: u32) -> usize {
        self.marks[number as usize] = self.mark;
        self.touched.push(number);
        let order = &self.paths[number as usize];
        let (head, tail, high) = (order[0], order[order.len() - 1], order.len() as u32 - 1);
        let path = self.new_changed(head, tail);
        self.changed[path].segments.push(Segment { path: number, low: 0, high, reversed: false });
        self.segment_count += 1;
        path
    }

    /// Adds a changed path without segments.
    fn new_changed(&mut self, head: u32, tail: u32) -> usize {
        if self.changed.len() == self.changed_count {
            self.changed.push(SegmentedPath::default());
        }
        let path = &mut self.changed[self.changed_count];
        path.segments.clear();
        (path.head, path.tail) = (head, tail);
        self.changed_count += 1;
        self.changed_count - 1
    }

    /// Returns the changed path of a triangle and the index of its segment.
    fn locate(&mut self, t: u32) -> (usize, usize) {
        let at = self.positions[t as usize];
        if self.marks[at.path as usize] == self.mark {
            for (id, path) in self.changed[..self.changed_count].iter().enumerate() {
                if let Some(i) = path.segments.iter().position(|s| s.contains(at)) {
                    return (id, i);
                }
            }
        }
        (self.touch(at.path), 0)
    }

    /// Returns the half-edge from a triangle inside a path toward the tail of the path, or toward
    /// its head.
    fn half_edge_toward(&self, (path, i): (usize, usize), t: u32, tail: bool) -> u32 {
        let segments = &self.changed[path].segments;
        let (segment, position) = (segments[i], self.positions[t as usize].position);
        let up = segment.reversed != tail;
        let limit = if up { segment.high } else { segment.low };
        let next = if position != limit {
            let next = if up { position + 1 } else { position - 1 };
            PathPosition { path: segment.path, position: next }
        } else if tail {
            let s = segments[i + 1];
            PathPosition { path: s.path, position: s.reverse().last() }
        } else {
            let s = segments[i - 1];
            PathPosition { path: s.path, position: s.last() }
        };
        let (a, b) = self.cover.packed_edges(t);
        let over_a = self.twin(3 * t + a) / 3;
        3 * t + if self.positions[over_a as usize] == next { a } else { b }
    }

    /// Saves the state. It can be restored until the paths are renumbered.
    pub(super) fn save(&mut self) {
        let count = self.changed_count;
        let saved = &mut self.saved;
        if saved.changed.len() < count {
            saved.changed.resize(count, SegmentedPath::default());
        }
        for (saved, path) in saved.changed.iter_mut().zip(&self.changed[..count]) {
            saved.copy_from(path);
        }
        saved.changed_count = count;
        saved.segment_count = self.segment_count;
        saved.touched_count = self.touched.len();
        saved.path_count = self.path_count;
        self.journal.clear();
    }

    /// Restores the saved state.
    pub(super) fn restore(&mut self) {
        while let Some(change) = self.journal.pop() {
            match change {
                LinkChange::Linked(h) => self.cover.cut_unchecked(h, self.graph.twins()[h as usize]),
                LinkChange::Cut(h) => self.cover.link_unchecked(h, self.graph.twins()[h as usize]),
            }
        }
        let saved = &self.saved;
        for (path, saved) in self.changed.iter_mut().zip(&saved.changed[..saved.changed_count]) {
            path.copy_from(saved);
        }
        self.changed_count = saved.changed_count;
        self.segment_count = saved.segment_count;
        self.path_count = saved.path_count;
        for path in self.touched.drain(saved.touched_count..) {
            self.marks[path as usize] = 0;
        }
    }

    /// Returns the twin of a half-edge. The twin must exist.
    #[inline]
    pub(super) fn twin(&self, half_edge: u32) -> u32 {
        self.graph.twins()[half_edge as usize]
    }

    /// Returns whether a path ends at this triangle.
    pub(super) fn is_end(&self, t: u32) -> bool {
        self.linked_edges(t).1 == NO_EDGE
    }

    /// Renumbers the paths that were touched since the last numbering.
    pub(super) fn renumber_touched(&mut self) {
        let mut changed = std::mem::take(&mut self.changed);
        // For each path: the numbered path whose start it keeps, the number of triangles kept, and
        // the triangles after them.
        let mut moved: Vec<(Option<u32>, usize, Vec<u32>)> = Vec::new();
        for path in changed[..self.changed_count].iter_mut().filter(|path| !path.segments.is_empty()) {
            let starts = |s: &Segment| s.low == 0 && !s.reversed;
            let last = path.segments[path.segments.len() - 1].reverse();
            if starts(&last) && !(starts(&path.segments[0]) && path.segments[0].len() >= last.len()) {
                path.reverse();
            }
            let kept = path.segments.first().filter(|s| starts(s)).copied();
            let rest = &path.segments[usize::from(kept.is_some())..];
            let mut triangles = Vec::with_capacity(rest.iter().map(Segment::len).sum());
            for s in rest {
                let part = &self.paths[s.path as usize][s.low as usize..=s.high as usize];
                if s.reversed {
                    triangles.extend(part.iter().rev());
                } else {
                    triangles.extend_from_slice(part);
                }
            }
            if let Some(s) = kept {
                self.marks[s.path as usize] = 0;
            }
            moved.push((kept.map(|s| s.path), kept.map_or(0, |s| s.len()), triangles));
        }
        self.changed = changed;
        let mut free: Vec<u32> = std::mem::take(&mut self.touched);
        free.retain(|&number| self.marks[number as usize] == self.mark);
        for (kept_number, kept, triangles) in moved {
            let number = kept_number.or_else(|| free.pop()).unwrap_or_else(|| self.new_number());
            let order = &mut self.paths[number as usize];
            order.truncate(kept);
            for (position, &t) in (kept as u32..).zip(&triangles) {
                self.positions[t as usize] = PathPosition { path: number, position };
            }
            if kept == 0 {
                *order = triangles;
            } else {
                order.extend_from_slice(&triangles);
            }
        }
        for number in free {
            let at = self.alive_at[number as usize] as usize;
            self.alive.swap_remove(at);
            if let Some(&other) = self.alive.get(at) {
                self.alive_at[other as usize] = at as u32;
            }
            self.paths[number as usize] = Vec::new();
            self.spare.push(number);
        }
        self.mark += 1;
        self.changed_count = 0;
        self.segment_count = 0;
        self.journal.clear();
    }

    /// Returns an unused path number.
    fn new_number(&mut self) -> u32 {
        let number = self.spare.pop().unwrap_or_else(|| {
            self.paths.push(Vec::new());
            self.alive_at.push(0);
            self.marks.push(0);
            self.paths.len() as u32 - 1
        });
        self.alive_at[number as usize] = self.alive.len() as u32;
        self.alive.push(number);
        number
    }
}
