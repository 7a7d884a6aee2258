//! The changes of paths: steps of an end, and cuts. Each changes the links of the cover and the segments of the strands alike.
//!
//! ```text
//!   rotate     w ┄┄ v ━━ x         the segments behind v are turned, so that x is the tail
//!   exchange   w ┄┄ v ━━ x         v's piece goes from its strand to w's; x is the new end of what is left
//!   append     w ┄┄ y              y's strand goes to the end of w's
//!   close      w ┄┄ h, y ┄┄ v      the segments up to v go behind the others, and y's strand behind them
//! ```

use super::{Change, NONE, OPEN, Step, Strands, Walker};
use crate::random::Random;

impl Strands<'_> {
    /// Splits a strand's segments behind a triangle in segment `i`; gives where the second part begins.
    fn split_behind(&mut self, id: usize, i: usize, t: u32) -> usize {
        let segments = &mut self.current[id].segments;
        let (first, second) = segments[i].split_behind(self.places[t as usize].position);
        segments[i] = first;
        if let Some(second) = second {
            segments.insert(i + 1, second);
            self.segment_count += 1;
        }
        i + 1
    }

    fn link(&mut self, half_edge: u32) {
        self.cover.link_unchecked(half_edge, self.twins[half_edge as usize]);
        self.journal.push(Change::Linked(half_edge));
    }

    fn cut(&mut self, half_edge: u32) {
        self.cover.cut_unchecked(half_edge, self.twins[half_edge as usize]);
        self.journal.push(Change::Cut(half_edge));
    }

    /// Goes one step from an end, but not back: joins it to another path's end where there is one beside it, else moves the end by
    /// two triangles.
    ///
    /// Where both ends of a path lie beside each other, the path can be closed and opened anywhere else. That is done where the end
    /// of another path lies beside it, and only while there are at most `closing_limit` paths, since all their ends are looked at.
    pub(in crate::stripify::fewest) fn step(
        &mut self,
        walker: Walker,
        closing_limit: usize,
        random: &mut Random,
    ) -> Step {
        let here = walker.strand;
        let w = self.current[here].tail;
        let (a, b) = self.cover.packed_edges(w);
        let (mut ways, mut way_count) = ([NONE; 3], 0);
        let mut closing = None;
        for half_edge in (0..3).filter(|&e| e != a && e != b).map(|e| 3 * w + e) {
            let twin = self.twins[half_edge as usize];
            if twin == NONE || twin / 3 == w || Some(half_edge) == walker.back {
                continue;
            }
            let v = twin / 3;
            if !self.is_end(v) {
                ways[way_count] = half_edge;
                way_count += 1;
            } else if v == self.current[here].head {
                closing = Some(half_edge);
            } else {
                let (other, _) = self.locate(v);
                self.link(half_edge);
                self.append(here, other, v);
                return Step::Joined;
            }
        }
        if let Some(half_edge) = closing
            && self.path_count <= closing_limit
            && self.close(here, half_edge)
        {
            return Step::Joined;
        }
        while way_count > 0 {
            let pick = if way_count == 1 { 0 } else { random.below(way_count) };
            let half_edge = ways[pick];
            way_count -= 1;
            ways[pick] = ways[way_count];
            let at = self.locate(self.twins[half_edge as usize] / 3);
            if at.0 != here {
                return Step::Moved(self.exchange(here, half_edge, at, random.coin()));
            }
            if let Some(walker) = self.rotate(here, half_edge, at) {
                return Step::Moved(walker);
            }
        }
        Step::Stuck
    }

    /// Rotates a path at its tail (Pósa): links the tail to `v`, inside the path, and cuts v's link on the side toward the
    /// tail. Refused where v is the tail's neighbour on the path.
    fn rotate(&mut self, id: usize, half_edge: u32, at: (usize, usize)) -> Option<Walker> {
        let v = self.twins[half_edge as usize] / 3;
        let toward_tail = self.half_edge_toward(at, v, true);
        let back = self.twins[toward_tail as usize];
        if back / 3 == self.current[id].tail {
            return None;
        }
        self.cut(toward_tail);
        self.link(half_edge);
        let turned = self.split_behind(id, at.1, v);
        let strand = &mut self.current[id];
        strand.segments[turned..].reverse();
        strand.segments[turned..].iter_mut().for_each(|s| *s = s.turned());
        strand.tail = back / 3;
        Some(Walker { strand: id, back: Some(back) })
    }

    /// Links the tail of a strand to `v`, inside another one, and cuts v's link toward that one's head or its tail. The strand takes
    /// v's piece; the other piece has the new end.
    fn exchange(&mut self, id: usize, half_edge: u32, at: (usize, usize), toward_tail: bool) -> Walker {
        let v = self.twins[half_edge as usize] / 3;
        let other = at.0;
        let cut = self.half_edge_toward(at, v, toward_tail);
        let back = self.twins[cut as usize];
        self.cut(cut);
        self.link(half_edge);
        // Seen the other way round where the cut is toward the tail, v's piece is always the second one.
        let mut i = at.1;
        if toward_tail {
            self.current[other].turn();
            i = self.current[other].segments.len() - 1 - i;
        }
        let mut donor = std::mem::take(&mut self.current[other]);
        let (first, second) = donor.segments[i].turned().split_behind(self.places[v as usize].position);
        let taker = &mut self.current[id];
        taker.segments.push(first.turned());
        taker.segments.extend_from_slice(&donor.segments[i + 1..]);
        taker.tail = donor.tail;
        donor.segments.truncate(i);
        if let Some(second) = second {
            donor.segments.push(second.turned());
            self.segment_count += 1;
        }
        donor.tail = back / 3;
        self.current[other] = donor;
        Walker { strand: other, back: Some(back) }
    }

    /// Appends a strand, from its end `v`, to the tail of another.
    fn append(&mut self, id: usize, other: usize, v: u32) {
        if self.current[other].head != v {
            self.current[other].turn();
        }
        let mut segments = std::mem::take(&mut self.current[other].segments);
        let strand = &mut self.current[id];
        strand.segments.append(&mut segments);
        self.current[id].tail = self.current[other].tail;
        self.current[other].segments = segments;
        self.path_count -= 1;
    }

    /// Closes a path across `closing` and opens it beside the end of another path, to which it is joined. Returns whether there
    /// was such an end.
    fn close(&mut self, id: usize, closing: u32) -> bool {
        let mut ends: Vec<u32> = Vec::with_capacity(2 * self.path_count);
        for (other, strand) in self.current[..self.strand_count].iter().enumerate() {
            if other != id && !strand.segments.is_empty() {
                ends.extend([strand.head, strand.tail]);
            }
        }
        for &path in &self.alive {
            if self.marks[path as usize] != self.mark {
                let order = &self.paths[path as usize];
                ends.extend([order[0], order[order.len() - 1]]);
            }
        }
        for y in ends {
            let (a, b) = self.cover.packed_edges(y);
            for half_edge in (0..3).filter(|&e| e != a && e != b).map(|e| 3 * y + e) {
                let twin = self.twins[half_edge as usize];
                if twin == NONE || self.marks[self.places[twin as usize / 3].path as usize] != self.mark {
                    continue;
                }
                let v = twin / 3;
                let at = self.locate(v);
                if at.0 != id || v == self.current[id].tail || v == self.current[id].head {
                    continue;
                }
                let toward_tail = self.half_edge_toward(at, v, true);
                let other = self.locate(y).0;
                self.link(closing);
                self.cut(toward_tail);
                self.link(half_edge);
                let second = self.split_behind(id, at.1, v);
                let strand = &mut self.current[id];
                strand.segments.rotate_left(second);
                strand.head = self.twins[toward_tail as usize] / 3;
                strand.tail = v;
                self.append(id, other, y);
                return true;
            }
        }
        false
    }

    /// Cuts the path behind a triangle, toward its tail. Gives the half-edge that was cut; `None` where the path ends there.
    pub(in crate::stripify::fewest) fn cut_behind(&mut self, t: u32) -> Option<u32> {
        let at = self.locate(t);
        if t == self.current[at.0].tail {
            return None;
        }
        let cut = self.half_edge_toward_from_end(at, t);
        let beyond = self.twins[cut as usize] / 3;
        self.cut(cut);
        let second = self.split_behind(at.0, at.1, t);
        let id = self.fresh_strand(beyond, self.current[at.0].tail);
        let (before, after) = self.current.split_at_mut(id);
        after[0].segments.extend(before[at.0].segments.drain(second..));
        before[at.0].tail = t;
        self.path_count += 1;
        Some(cut)
    }

    /// The half-edge toward the tail, also of a head, which has one link only.
    fn half_edge_toward_from_end(&self, at: (usize, usize), t: u32) -> u32 {
        let (a, b) = self.inner_edges(t);
        if b == OPEN { 3 * t + a } else { self.half_edge_toward(at, t, true) }
    }
}
