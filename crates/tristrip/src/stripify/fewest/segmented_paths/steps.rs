//! Changes of paths: steps of a walk, and cuts. Each changes the links of the cover and the
//! segments of the paths together.
//!
//! ```text
//!   rotate      w ┄┄ v ━━ x         the segments after v are reversed; x is the new tail
//!   take part   w ┄┄ v ━━ x         v's part moves from its path to w's; x is an end of the rest
//!   append      w ┄┄ y              y's path is appended to w's
//!   close       w ┄┄ h, y ┄┄ v      the segments up to v move to the end, followed by y's path
//! ```

use super::segment::reverse_segments;
use super::{LinkChange, NO_EDGE, SegmentedPaths, WalkEnd, WalkStep};
use crate::random::Random;

impl SegmentedPaths<'_> {
    /// Splits a path's segments after a triangle in segment `i`. Returns the index of the first
    /// segment of the second part.
    fn split_after(&mut self, path: usize, i: usize, t: u32) -> usize {
        let segments = &mut self.changed[path].segments;
        let (first, second) = segments[i].split_after(self.positions[t as usize].position);
        segments[i] = first;
        if let Some(second) = second {
            segments.insert(i + 1, second);
            self.segment_count += 1;
        }
        i + 1
    }

    fn link(&mut self, half_edge: u32) {
        let twin = self.twin(half_edge);
        self.cover.link_unchecked(half_edge, twin);
        self.journal.push(LinkChange::Linked(half_edge));
    }

    fn cut(&mut self, half_edge: u32) {
        let twin = self.twin(half_edge);
        self.cover.cut_unchecked(half_edge, twin);
        self.journal.push(LinkChange::Cut(half_edge));
    }

    /// Makes one step from an end, but not back. Joins the end to an adjacent end of another path
    /// if there is one, otherwise moves it by two triangles.
    ///
    /// If the two ends of a path are adjacent, the path can be closed and opened anywhere else.
    /// This is done if the end of another path is adjacent to it, and only while there are at most
    /// `closing_limit` paths, because all their ends are examined.
    pub(in crate::stripify::fewest) fn step(
        &mut self,
        end: WalkEnd,
        closing_limit: usize,
        random: &mut Random,
    ) -> WalkStep {
        let here = end.path;
        let w = self.changed[here].tail;
        let (a, b) = self.cover.packed_edges(w);
        let (mut ways, mut way_count) = ([0; 3], 0);
        let mut closing = None;
        for half_edge in (0..3).filter(|&e| e != a && e != b).map(|e| 3 * w + e) {
            let Some(v) = self.graph.twin_of(half_edge).map(|twin| twin / 3) else { continue };
            if v == w || Some(half_edge) == end.back {
                continue;
            }
            if !self.is_end(v) {
                ways[way_count] = half_edge;
                way_count += 1;
            } else if v == self.changed[here].head {
                closing = Some(half_edge);
            } else {
                let (other, _) = self.locate(v);
                self.link(half_edge);
                self.append(here, other, v);
                return WalkStep::Joined;
            }
        }
        if let Some(half_edge) = closing
            && self.path_count <= closing_limit
            && self.close(here, half_edge)
        {
            return WalkStep::Joined;
        }
        while way_count > 0 {
            let choice = if way_count == 1 { 0 } else { random.below(way_count) };
            let half_edge = ways[choice];
            way_count -= 1;
            ways[choice] = ways[way_count];
            let at = self.locate(self.twin(half_edge) / 3);
            if at.0 != here {
                return WalkStep::Moved(self.take_part(here, half_edge, at, random.coin()));
            }
            if let Some(end) = self.rotate(here, half_edge, at) {
                return WalkStep::Moved(end);
            }
        }
        WalkStep::Stuck
    }

    /// Rotates a path at its tail (Pósa): links the tail to `v`, inside the path, and cuts v's link
    /// on the side of the tail. Returns `None` if v is linked to the tail.
    fn rotate(&mut self, id: usize, half_edge: u32, at: (usize, usize)) -> Option<WalkEnd> {
        let v = self.twin(half_edge) / 3;
        let toward_tail = self.half_edge_toward(at, v, true);
        let back = self.twin(toward_tail);
        if back / 3 == self.changed[id].tail {
            return None;
        }
        self.cut(toward_tail);
        self.link(half_edge);
        let second = self.split_after(id, at.1, v);
        let path = &mut self.changed[id];
        reverse_segments(&mut path.segments[second..]);
        path.tail = back / 3;
        Some(WalkEnd { path: id, back: Some(back) })
    }

    /// Links the tail of a path to `v`, inside another path, and cuts v's link toward the other
    /// path's head or tail. The path takes v's part; the other part has the new end.
    fn take_part(&mut self, id: usize, half_edge: u32, at: (usize, usize), toward_tail: bool) -> WalkEnd {
        let v = self.twin(half_edge) / 3;
        let other = at.0;
        let cut = self.half_edge_toward(at, v, toward_tail);
        let back = self.twin(cut);
        self.cut(cut);
        self.link(half_edge);
        // Reverse the other path if the cut is toward its tail: v's part is then always the second
        // one.
        let mut i = at.1;
        if toward_tail {
            self.changed[other].reverse();
            i = self.changed[other].segments.len() - 1 - i;
        }
        let mut donor = std::mem::take(&mut self.changed[other]);
        let (first, second) = donor.segments[i].reverse().split_after(self.positions[v as usize].position);
        let taker = &mut self.changed[id];
        taker.segments.push(first.reverse());
        taker.segments.extend_from_slice(&donor.segments[i + 1..]);
        taker.tail = donor.tail;
        donor.segments.truncate(i);
        if let Some(second) = second {
            donor.segments.push(second.reverse());
            self.segment_count += 1;
        }
        donor.tail = back / 3;
        self.changed[other] = donor;
        WalkEnd { path: other, back: Some(back) }
    }

    /// Appends a path, starting at its end `v`, to the tail of another path.
    fn append(&mut self, id: usize, other: usize, v: u32) {
        if self.changed[other].head != v {
            self.changed[other].reverse();
        }
        let mut segments = std::mem::take(&mut self.changed[other].segments);
        self.changed[id].segments.append(&mut segments);
        self.changed[id].tail = self.changed[other].tail;
        self.changed[other].segments = segments;
        self.path_count -= 1;
    }

    /// Closes a path across `closing` and opens it next to the end of another path, to which it is
    /// joined. Returns whether there was such an end.
    fn close(&mut self, id: usize, closing: u32) -> bool {
        for y in self.other_ends(id) {
            let (a, b) = self.cover.packed_edges(y);
            for half_edge in (0..3).filter(|&e| e != a && e != b).map(|e| 3 * y + e) {
                let Some(v) = self.graph.twin_of(half_edge).map(|twin| twin / 3) else { continue };
                if self.marks[self.positions[v as usize].path as usize] != self.mark {
                    continue;
                }
                let at = self.locate(v);
                if at.0 != id || v == self.changed[id].tail || v == self.changed[id].head {
                    continue;
                }
                let toward_tail = self.half_edge_toward(at, v, true);
                let other = self.locate(y).0;
                self.link(closing);
                self.cut(toward_tail);
                self.link(half_edge);
                let second = self.split_after(id, at.1, v);
                let head = self.twin(toward_tail) / 3;
                let path = &mut self.changed[id];
                path.segments.rotate_left(second);
                (path.head, path.tail) = (head, v);
                self.append(id, other, y);
                return true;
            }
        }
        false
    }

    /// Returns the ends of all paths except one.
    fn other_ends(&self, id: usize) -> Vec<u32> {
        let mut ends = Vec::with_capacity(2 * self.path_count);
        for (other, path) in self.changed[..self.changed_count].iter().enumerate() {
            if other != id && !path.segments.is_empty() {
                ends.extend([path.head, path.tail]);
            }
        }
        for &number in &self.alive {
            if self.marks[number as usize] != self.mark {
                let order = &self.paths[number as usize];
                ends.extend([order[0], order[order.len() - 1]]);
            }
        }
        ends
    }

    /// Cuts the path after a triangle, toward its tail. Returns the half-edge that was cut, or
    /// `None` if the path ends there.
    pub(in crate::stripify::fewest) fn cut_after(&mut self, t: u32) -> Option<u32> {
        let at = self.locate(t);
        if t == self.changed[at.0].tail {
            return None;
        }
        let cut = match self.linked_edges(t) {
            // A head has only one link.
            (edge, NO_EDGE) => 3 * t + edge,
            _ => self.half_edge_toward(at, t, true),
        };
        let head = self.twin(cut) / 3;
        self.cut(cut);
        let second = self.split_after(at.0, at.1, t);
        let id = self.new_changed(head, self.changed[at.0].tail);
        let (before, after) = self.changed.split_at_mut(id);
        after[0].segments.extend(before[at.0].segments.drain(second..));
        before[at.0].tail = t;
        self.path_count += 1;
        Some(cut)
    }
}
