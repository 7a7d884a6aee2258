//! Paths that are rotated, exchanged, joined and cut many times between two numberings.
//!
//! ```text
//!   as numbered    path 0  ●━●━●━●━●━●━●━●      path 1  ○━○━○━○
//!   as it is now   strand  [0: 0–2] [0: 7–5] [1: 1–3]    strand  [1: 0–0] [0: 4–3]
//! ```
//! # Algorithm
//! Each triangle has a place: its path and its position, as they were when the paths were numbered last. A path as it is now is a
//! *strand*: a list of segments, each of which is a range of positions of one numbered path, forward or backward. A rotation at an
//! end splits one segment and turns those after it; no triangle is visited. The segment of a triangle is found by its place
//! among the segments of the strands. When there are many segments, [`Strands::settle`] numbers the paths anew; each
//! path keeps the places of its first segment if that begins a numbered path.
//!
//! The links of the cover are changed along with the segments, so that the cover is right at any time.
//!
//! # Complexity
//! A change takes O(segments); settling takes O(triangles of the paths that were touched). 12 bytes a triangle, and up to 8 more
//! while paths grow; 24 bytes a path.

use crate::cover::PathCover;
use crate::stripify::random::Random;

const NONE: u32 = u32::MAX;
/// No edge, where the edge of a triangle is named.
const OPEN: u32 = 3;

/// Where a triangle stood when the paths were numbered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Place {
    path: u32,
    position: u32,
}

/// Positions `low` to `high` of a numbered path.
#[derive(Debug, Clone, Copy)]
struct Segment {
    path: u32,
    low: u32,
    high: u32,
    reversed: bool,
}

impl Segment {
    fn turned(self) -> Self {
        Self { reversed: !self.reversed, ..self }
    }

    #[inline]
    fn holds(&self, place: Place) -> bool {
        self.path == place.path && self.low <= place.position && place.position <= self.high
    }

    fn last(&self) -> u32 {
        if self.reversed { self.low } else { self.high }
    }

    /// Splits the segment behind a position, in its own direction; the second part is `None` behind its last position.
    fn split_behind(self, position: u32) -> (Self, Option<Self>) {
        if position == self.last() {
            (self, None)
        } else if self.reversed {
            (Self { low: position, ..self }, Some(Self { high: position - 1, ..self }))
        } else {
            (Self { high: position, ..self }, Some(Self { low: position + 1, ..self }))
        }
    }

    fn len(&self) -> usize {
        (self.high - self.low) as usize + 1
    }
}

/// A path as it is now, from its head to its tail. No segments: it was joined to another.
#[derive(Debug, Clone, Default)]
struct Strand {
    segments: Vec<Segment>,
    head: u32,
    tail: u32,
}

impl Strand {
    /// Becomes the same as another; its buffer is kept.
    fn copy(&mut self, other: &Self) {
        self.segments.clone_from(&other.segments);
        (self.head, self.tail) = (other.head, other.tail);
    }

    fn turn(&mut self) {
        self.segments.reverse();
        self.segments.iter_mut().for_each(|s| *s = s.turned());
        std::mem::swap(&mut self.head, &mut self.tail);
    }
}

/// What was done to the links.
#[derive(Debug, Clone, Copy)]
enum Change {
    Linked(u32),
    Cut(u32),
}

/// A state to come back to.
#[derive(Debug, Default)]
struct Saved {
    strands: Vec<Strand>,
    strand_count: usize,
    segment_count: usize,
    touched_count: usize,
    path_count: usize,
}

/// An end on its way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Walker {
    /// The strand whose tail is the end.
    strand: usize,
    /// The half-edge that led back, were it linked again.
    back: Option<u32>,
}

/// What a step at an end came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// Two paths were joined: there is one less.
    Joined,
    /// There is a new end.
    Moved(Walker),
    /// There is nowhere to go from this end but back.
    Stuck,
}

/// The paths of a cover, ready for many changes.
#[derive(Debug)]
pub(super) struct Strands<'a> {
    twins: &'a [u32],
    cover: &'a mut PathCover,
    places: Vec<Place>,
    /// The triangles of each numbered path.
    paths: Vec<Vec<u32>>,
    /// Numbers of the paths that there are, and where each stands in the list.
    alive: Vec<u32>,
    alive_at: Vec<u32>,
    /// Numbers that are free.
    spare: Vec<u32>,
    path_count: usize,
    /// Paths touched since they were numbered; a mark tells them.
    touched: Vec<u32>,
    marks: Vec<u32>,
    mark: u32,
    current: Vec<Strand>,
    strand_count: usize,
    segment_count: usize,
    /// Half-edges linked and cut since the state was saved.
    journal: Vec<Change>,
    saved: Saved,
}

impl<'a> Strands<'a> {
    /// Numbers the paths of a cover over triangles joined across `twins`.
    pub(super) fn new(twins: &'a [u32], cover: &'a mut PathCover) -> Self {
        let mut strands = Self {
            twins,
            places: vec![Place { path: NONE, position: 0 }; cover.len()],
            cover,
            paths: Vec::new(),
            alive: Vec::new(),
            alive_at: Vec::new(),
            spare: Vec::new(),
            path_count: 0,
            touched: Vec::new(),
            marks: Vec::new(),
            mark: 1,
            current: Vec::new(),
            strand_count: 0,
            segment_count: 0,
            journal: Vec::new(),
            saved: Saved::default(),
        };
        strands.number();
        strands
    }

    /// Counts the paths.
    pub(super) fn path_count(&self) -> usize {
        self.path_count
    }

    /// Counts the segments since the paths were numbered: what a change costs.
    pub(super) fn segment_count(&self) -> usize {
        self.segment_count
    }

    /// Counts the paths touched since they were numbered.
    pub(super) fn touched_count(&self) -> usize {
        self.touched.len()
    }

    fn number(&mut self) {
        let mut count = 0;
        for start in 0..self.places.len() as u32 {
            if self.places[start as usize].path != NONE || !self.is_end(start) {
                continue;
            }
            let mut path = Vec::new();
            let (mut t, mut exit) = (start, self.inner_edges(start).0);
            loop {
                self.places[t as usize] = Place { path: count as u32, position: path.len() as u32 };
                path.push(t);
                if exit == OPEN {
                    break;
                }
                let entry = self.twins[(3 * t + exit) as usize];
                t = entry / 3;
                let (a, b) = self.cover.packed_edges(t);
                exit = if a == entry % 3 { b } else { a };
            }
            self.paths.push(path);
            count += 1;
        }
        self.alive = (0..count as u32).collect();
        self.alive_at.clone_from(&self.alive);
        self.path_count = count;
        self.marks.resize(count, 0);
    }

    /// The edges over which a triangle is linked, `OPEN` last.
    #[inline]
    fn inner_edges(&self, t: u32) -> (u32, u32) {
        let (a, b) = self.cover.packed_edges(t);
        if a == OPEN { (b, a) } else { (a, b) }
    }

    /// Picks an end of any path, and turns its strand so that it is the tail.
    pub(super) fn random_end(&mut self, random: &mut Random) -> Walker {
        let path = self.alive[random.below(self.alive.len())];
        let mut id = self.strand_count;
        if self.marks[path as usize] == self.mark {
            // The path is not what it was: any strand that there is will do.
            while id == self.strand_count || self.current[id].segments.is_empty() {
                id = random.below(self.strand_count);
            }
        } else {
            self.open(path);
        }
        if random.coin() {
            self.current[id].turn();
        }
        Walker { strand: id, back: None }
    }

    /// The end's triangle, and the half-edge that leads back.
    pub(super) fn end(&self, walker: Walker) -> (u32, Option<u32>) {
        (self.current[walker.strand].tail, walker.back)
    }

    /// Gets ready to walk from the end of a path, not over the half-edge `back` at first; `None` inside a path.
    pub(super) fn walker(&mut self, end: u32, back: Option<u32>) -> Option<Walker> {
        if !self.is_end(end) {
            return None;
        }
        let (strand, _) = self.locate(end);
        if self.current[strand].tail != end {
            self.current[strand].turn();
        }
        Some(Walker { strand, back })
    }

    /// Makes a strand of a path that was not touched yet.
    fn open(&mut self, path: u32) -> usize {
        self.marks[path as usize] = self.mark;
        self.touched.push(path);
        let order = &self.paths[path as usize];
        let (head, tail, high) = (order[0], order[order.len() - 1], order.len() as u32 - 1);
        let id = self.fresh_strand(head, tail);
        self.current[id].segments.push(Segment { path, low: 0, high, reversed: false });
        self.segment_count += 1;
        id
    }

    fn fresh_strand(&mut self, head: u32, tail: u32) -> usize {
        if self.current.len() == self.strand_count {
            self.current.push(Strand::default());
        }
        let strand = &mut self.current[self.strand_count];
        strand.segments.clear();
        (strand.head, strand.tail) = (head, tail);
        self.strand_count += 1;
        self.strand_count - 1
    }

    /// Finds the strand of a triangle and the segment in it.
    fn locate(&mut self, t: u32) -> (usize, usize) {
        let place = self.places[t as usize];
        if self.marks[place.path as usize] == self.mark {
            for (id, strand) in self.current[..self.strand_count].iter().enumerate() {
                if let Some(i) = strand.segments.iter().position(|s| s.holds(place)) {
                    return (id, i);
                }
            }
        }
        (self.open(place.path), 0)
    }

    /// The half-edge of a linked inner triangle toward the tail of its strand, or toward its head.
    fn half_edge_toward(&self, (id, i): (usize, usize), t: u32, tail: bool) -> u32 {
        let segments = &self.current[id].segments;
        let (segment, position) = (segments[i], self.places[t as usize].position);
        let up = segment.reversed != tail;
        let limit = if up { segment.high } else { segment.low };
        let next = if position != limit {
            let next = if up { position + 1 } else { position - 1 };
            Place { path: segment.path, position: next }
        } else if tail {
            let s = segments[i + 1];
            Place { path: s.path, position: s.turned().last() }
        } else {
            let s = segments[i - 1];
            Place { path: s.path, position: s.last() }
        };
        let (a, b) = self.cover.packed_edges(t);
        let over_a = self.twins[(3 * t + a) as usize] / 3;
        3 * t + if self.places[over_a as usize] == next { a } else { b }
    }

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
    pub(super) fn step(&mut self, walker: Walker, closing_limit: usize, random: &mut Random) -> Step {
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
    pub(super) fn cut_behind(&mut self, t: u32) -> Option<u32> {
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

    /// Saves the state, to come back to until the paths are numbered anew.
    pub(super) fn save(&mut self) {
        let count = self.strand_count;
        let saved = &mut self.saved;
        if saved.strands.len() < count {
            saved.strands.resize(count, Strand::default());
        }
        for (saved, strand) in saved.strands.iter_mut().zip(&self.current[..count]) {
            saved.copy(strand);
        }
        saved.strand_count = count;
        saved.segment_count = self.segment_count;
        saved.touched_count = self.touched.len();
        saved.path_count = self.path_count;
        self.journal.clear();
    }

    /// Comes back to the state that was saved.
    pub(super) fn restore(&mut self) {
        while let Some(change) = self.journal.pop() {
            match change {
                Change::Linked(h) => self.cover.cut_unchecked(h, self.twins[h as usize]),
                Change::Cut(h) => self.cover.link_unchecked(h, self.twins[h as usize]),
            }
        }
        let saved = &self.saved;
        for (strand, saved) in self.current.iter_mut().zip(&saved.strands[..saved.strand_count]) {
            strand.copy(saved);
        }
        self.strand_count = saved.strand_count;
        self.segment_count = saved.segment_count;
        self.path_count = saved.path_count;
        for path in self.touched.drain(saved.touched_count..) {
            self.marks[path as usize] = 0;
        }
    }

    /// The half-edge on the other side.
    pub(super) fn twin(&self, half_edge: u32) -> u32 {
        self.twins[half_edge as usize]
    }

    /// Tells whether a path ends at this triangle.
    pub(super) fn is_end(&self, t: u32) -> bool {
        self.inner_edges(t).1 == OPEN
    }

    /// Numbers the paths that were touched anew.
    pub(super) fn settle(&mut self) {
        let mut strands = std::mem::take(&mut self.current);
        let mut moved: Vec<(Option<u32>, usize, Vec<u32>)> = Vec::new();
        for strand in strands[..self.strand_count].iter_mut().filter(|s| !s.segments.is_empty()) {
            let starts = |s: &Segment| s.low == 0 && !s.reversed;
            let last = strand.segments[strand.segments.len() - 1].turned();
            if starts(&last) && !(starts(&strand.segments[0]) && strand.segments[0].len() >= last.len()) {
                strand.turn();
            }
            let kept = strand.segments.first().filter(|s| starts(s)).copied();
            let rest = &strand.segments[usize::from(kept.is_some())..];
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
        self.current = strands;
        let mut free: Vec<u32> = std::mem::take(&mut self.touched);
        free.retain(|&path| self.marks[path as usize] == self.mark);
        for (path, kept, triangles) in moved {
            let path = path.or_else(|| free.pop()).unwrap_or_else(|| self.new_path());
            let order = &mut self.paths[path as usize];
            order.truncate(kept);
            for (position, &t) in (kept as u32..).zip(&triangles) {
                self.places[t as usize] = Place { path, position };
            }
            if kept == 0 {
                *order = triangles;
            } else {
                order.extend_from_slice(&triangles);
            }
        }
        for path in free {
            let at = self.alive_at[path as usize] as usize;
            self.alive.swap_remove(at);
            if let Some(&other) = self.alive.get(at) {
                self.alive_at[other as usize] = at as u32;
            }
            self.paths[path as usize] = Vec::new();
            self.spare.push(path);
        }
        self.mark += 1;
        self.strand_count = 0;
        self.segment_count = 0;
        self.journal.clear();
    }

    fn new_path(&mut self) -> u32 {
        let path = self.spare.pop().unwrap_or_else(|| {
            self.paths.push(Vec::new());
            self.alive_at.push(0);
            self.marks.push(0);
            self.paths.len() as u32 - 1
        });
        self.alive_at[path as usize] = self.alive.len() as u32;
        self.alive.push(path);
        path
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::dual::DualGraph;
    use crate::stripify::sequential::tests::triangle_graph;

    impl Strands<'_> {
        /// Lists the triangles of each path by its segments, from head to tail.
        fn by_segments(&self) -> Vec<Vec<u32>> {
            let now = self.current[..self.strand_count].iter().filter(|s| !s.segments.is_empty());
            let mut paths: Vec<Vec<u32>> = now
                .map(|strand| {
                    let triangles: Vec<u32> = strand
                        .segments
                        .iter()
                        .flat_map(|s| {
                            let part = self.paths[s.path as usize][s.low as usize..=s.high as usize].iter();
                            let part: Vec<u32> = if s.reversed {
                                part.rev().copied().collect()
                            } else {
                                part.copied().collect()
                            };
                            part
                        })
                        .collect();
                    assert_eq!((triangles[0], triangles[triangles.len() - 1]), (strand.head, strand.tail));
                    triangles
                })
                .collect();
            let untouched = self.alive.iter().filter(|&&path| self.marks[path as usize] != self.mark);
            paths.extend(untouched.map(|&path| self.paths[path as usize].clone()));
            paths
        }

        /// Checks the cover, and the segments against its links.
        fn check(&self, graph: &DualGraph) {
            assert_eq!(self.cover.check(graph), Ok(()));
            assert_eq!(self.cover.path_count(), self.path_count);
            let mut seen = 0;
            let paths = self.by_segments();
            assert_eq!(paths.len(), self.path_count);
            for path in paths {
                let ends = [path[0], path[path.len() - 1]];
                let walked: Vec<u32> =
                    self.cover.walk(graph, crate::FaceId(ends[0])).map(|(face, _, _)| face.0).collect();
                assert_eq!(walked, path);
                seen += path.len();
            }
            assert_eq!(seen, self.cover.len());
        }
    }

    /// Lists all half-edges that are linked.
    fn links(cover: &PathCover) -> Vec<crate::HalfEdge> {
        let faces = (0..cover.len() as u32).map(crate::FaceId);
        let mut links: Vec<_> = faces.flat_map(|face| cover.edges(face).into_iter().flatten()).collect();
        links.sort_unstable();
        links
    }

    /// Does random things, so many of them.
    fn play(strands: &mut Strands<'_>, graph: &DualGraph, random: &mut Random, moves: usize) {
        let mut walker = strands.random_end(random);
        for _ in 0..moves {
            match random.below(8) {
                0 => walker = strands.random_end(random),
                1 => {
                    strands.cut_behind(random.below(graph.face_count()) as u32);
                    walker = strands.random_end(random);
                }
                _ => match strands.step(walker, 64, random) {
                    Step::Moved(moved) => walker = moved,
                    Step::Joined | Step::Stuck => walker = strands.random_end(random),
                },
            }
            strands.check(graph);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

        #[test]
        fn segments_follow_the_links(graph in triangle_graph(), seed: u64) {
            prop_assume!(graph.face_count() > 0);
            let mut cover = PathCover::isolated(graph.face_count());
            let mut strands = Strands::new(graph.twins(), &mut cover);
            let mut random = Random::new(seed);
            for _ in 0..3 {
                play(&mut strands, &graph, &mut random, 10);
                strands.save();
                let saved = strands.by_segments();
                let links = links(strands.cover);
                play(&mut strands, &graph, &mut random, 10);
                if random.coin() {
                    strands.restore();
                    strands.check(&graph);
                    prop_assert_eq!(self::links(strands.cover), links);
                    prop_assert_eq!(strands.by_segments().len(), saved.len());
                }
                strands.settle();
                strands.check(&graph);
            }
        }
    }
}
