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

mod segment;
mod steps;
#[cfg(test)]
mod tests;

use crate::cover::PathCover;
use crate::random::Random;
use segment::{Place, Segment, Strand};

const NONE: u32 = u32::MAX;
/// No edge, where the edge of a triangle is named.
const OPEN: u32 = 3;

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
