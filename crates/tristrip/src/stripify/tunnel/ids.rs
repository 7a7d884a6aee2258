//! Identifiers: which strip each triangle is on, and where, so that a search can tell a loop before it is made.
//!
//! Porcu and Scateni tag every node with its strip, and write the tags anew, node by node, whenever a search links or cuts. Here
//! a tag is a path and a position on it, and a search writes none: the pieces that its cuts leave are intervals of positions,
//! a few dozen of them, and its links lead from an end of one piece to an end of another. Only a complement that is kept writes
//! tags, those of the paths that it has changed.
//!
//! ```text
//!   path 4:  0 ━ 1 ━ 2 ━ 3 ━ 4 ━ 5      cut between 3 and 4, end 0 of path 9 linked to 3:
//!   path 9:  0 ━ 1 ━ 2                  pieces 4[0..=3], 4[4..=5], 9[0..=2]; the second's lower end is the tunnel's
//! ```
//!
//! # Complexity
//! 8 bytes a triangle and 8 a path. A simulated step takes O(steps before it), a complement O(length of the paths it changes).

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;

pub(super) const NONE: u32 = u32::MAX;

/// The path and the position of every triangle, kept up to date.
#[derive(Debug)]
pub(super) struct Ids {
    path: Vec<u32>,
    position: Vec<u32>,
    /// The first and the last triangle of each path; of one that was joined to another, `NONE`.
    ends: Vec<[u32; 2]>,
    /// The paths that a complement changes.
    touched: Vec<u32>,
    /// Triangles that may be ends of them.
    loose: Vec<u32>,
}

impl Ids {
    pub(super) fn new(graph: &DualGraph, cover: &PathCover) -> Self {
        let numbering = cover.renumber(graph);
        let mut ends: Vec<[u32; 2]> = numbering.first.iter().map(|first| [first.0; 2]).collect();
        for (t, &path) in numbering.path.iter().enumerate() {
            let last = &mut ends[path as usize][1];
            if numbering.position[t] > numbering.position[*last as usize] {
                *last = t as u32;
            }
        }
        let (touched, loose) = (Vec::new(), Vec::new());
        Self { path: numbering.path, position: numbering.position, ends, touched, loose }
    }

    #[inline]
    pub(super) fn path(&self, t: u32) -> u32 {
        self.path[t as usize]
    }

    #[inline]
    pub(super) fn position(&self, t: u32) -> u32 {
        self.position[t as usize]
    }

    /// The position of a path's last triangle.
    #[inline]
    fn last(&self, path: u32) -> u32 {
        self.position(self.ends[path as usize][1])
    }

    /// Complements a tunnel: cuts its black edges, links its red ones, and writes the tags of the paths that it has changed. Gives
    /// the number of tags.
    pub(super) fn complement(&mut self, graph: &DualGraph, cover: &mut PathCover, steps: &[Step]) -> u64 {
        let twins = graph.twins();
        self.touched.clear();
        self.loose.clear();
        for h in steps.iter().flat_map(|step| [step.red, step.black]).filter(|&h| h != NONE) {
            for t in [h / 3, twins[h as usize] / 3] {
                self.touched.push(self.path(t));
                self.loose.push(t);
            }
        }
        complement(graph, cover, steps);
        self.touched.sort_unstable();
        self.touched.dedup();
        for &path in &self.touched {
            self.loose.extend(std::mem::replace(&mut self.ends[path as usize], [NONE; 2]));
        }
        let written = self.write_tags(graph, cover);
        #[cfg(test)]
        assert!(cover.len() > 4096 || cover.check(graph).is_ok() && self.check(graph, cover));
        written
    }

    /// Numbers the changed paths again, each from an end that is not yet known as the other end of one.
    fn write_tags(&mut self, graph: &DualGraph, cover: &PathCover) -> u64 {
        let mut written = 0;
        let mut free = self.touched.iter();
        self.loose.retain(|&t| cover.degree(FaceId(t)) < 2);
        self.loose.sort_unstable();
        self.loose.dedup();
        for &start in &self.loose {
            if self.ends[self.path(start) as usize].contains(&start) {
                continue;
            }
            let Some(&path) = free.next() else { break };
            let mut last = start;
            for (position, (face, _, _)) in cover.walk(graph, FaceId(start)).enumerate() {
                self.path[face.0 as usize] = path;
                self.position[face.0 as usize] = position as u32;
                last = face.0;
                written += 1;
            }
            self.ends[path as usize] = [start, last];
        }
        written
    }

    /// Checks that the tags are those of the cover, but for the paths' names and directions.
    #[cfg(test)]
    pub(super) fn check(&self, graph: &DualGraph, cover: &PathCover) -> bool {
        let mut seen = std::collections::HashSet::new();
        cover.path_starts(graph).all(|start| {
            let path = self.path(start.0);
            let walked: Vec<u32> = cover.walk(graph, start).map(|(face, _, _)| face.0).collect();
            let mut positions: Vec<u32> = walked.iter().map(|&t| self.position(t)).collect();
            let mut ends = [walked[0], walked[walked.len() - 1]];
            if positions[0] != 0 {
                positions.reverse();
                ends.reverse();
            }
            seen.insert(path)
                && self.ends[path as usize] == ends
                && walked.iter().all(|&t| self.path(t) == path)
                && positions.iter().copied().eq(0..walked.len() as u32)
        })
    }
}

/// A step of a tunnel: over a red edge, then over a black one; `NONE` after the last red one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Step {
    /// Leads on from where the tunnel has come to.
    pub(super) red: u32,
    /// Leads on from there.
    pub(super) black: u32,
}

/// Cuts the black edges of a tunnel and links its red ones.
fn complement(graph: &DualGraph, cover: &mut PathCover, steps: &[Step]) {
    let twin = |h: u32| graph.twins()[h as usize];
    for step in steps.iter().filter(|step| step.black != NONE) {
        cover.cut_unchecked(step.black, twin(step.black));
    }
    steps.iter().for_each(|step| cover.link_unchecked(step.red, twin(step.red)));
}

/// A part of a path between cuts.
#[derive(Debug, Clone, Copy)]
struct Piece {
    path: u32,
    first: u32,
    last: u32,
    /// The ends of other pieces that its first and its last triangle are linked with.
    links: [u32; 2],
}

/// What a step has changed.
#[derive(Debug, Clone, Copy)]
struct Change {
    /// Pieces before it.
    before: u32,
    /// The tip and the loops before it.
    tip: u32,
    loops: u32,
    /// The piece that it has split.
    split: u32,
    /// The ends that it has linked.
    linked: [u32; 2],
}

/// The pieces that a tunnel has made so far. An end of piece `p` is named `2 p` at its first, `2 p + 1` at its last triangle.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    all: Vec<Piece>,
    changes: Vec<Change>,
    /// The end that the tunnel has come to.
    tip: u32,
    /// Loops that are closed at present.
    loops: u32,
}

impl Pieces {
    /// Begins at a terminal.
    pub(super) fn begin(&mut self, ids: &Ids, terminal: u32) {
        self.all.clear();
        self.changes.clear();
        self.loops = 0;
        let piece = self.piece_of(ids, terminal);
        self.tip = 2 * piece + u32::from(ids.position(terminal) != 0);
    }

    /// Finds the piece that a triangle is on; that of a path not met before is the whole path.
    fn piece_of(&mut self, ids: &Ids, t: u32) -> u32 {
        let (path, position) = (ids.path(t), ids.position(t));
        let is_on = |p: &Piece| p.path == path && p.first <= position && position <= p.last;
        if let Some(piece) = self.all.iter().position(is_on) {
            return piece as u32;
        }
        self.all.push(Piece { path, first: 0, last: ids.last(path), links: [NONE; 2] });
        self.all.len() as u32 - 1
    }

    /// Links the tip to triangle `v`, which is then cut from its neighbour `b` on its path: the new tip. Returns whether they
    /// were still neighbours; otherwise nothing is done.
    pub(super) fn step(&mut self, ids: &Ids, v: u32, b: u32) -> bool {
        let (before, tip, loops) = (self.all.len() as u32, self.tip, self.loops);
        let split = self.piece_of(ids, v);
        let position = ids.position(v);
        let upward = ids.position(b) > position;
        let piece = self.all[split as usize];
        if position == if upward { piece.last } else { piece.first } {
            self.all.truncate(before as usize);
            return false;
        }
        if loops > 0 && self.is_on_loop(split) {
            self.loops -= 1;
        }
        // The upper part becomes a piece of its own, with what was the upper end.
        let last = if upward { position } else { position - 1 };
        let upper = self.all.len() as u32;
        self.all.push(Piece { first: last + 1, links: [NONE, piece.links[1]], ..piece });
        self.all[split as usize] = Piece { last, links: [piece.links[0], NONE], ..piece };
        self.set_link(piece.links[1], 2 * upper + 1);
        let from = if tip == 2 * split + 1 { 2 * upper + 1 } else { tip };
        let cut = [2 * split + 1, 2 * upper];
        let [at_v, at_b] = if upward { cut } else { [cut[1], cut[0]] };
        if self.other_end(from) == at_v {
            self.loops += 1;
        }
        self.set_link(from, at_v);
        self.set_link(at_v, from);
        self.changes.push(Change { before, tip, loops, split, linked: [from, at_v] });
        self.tip = at_b;
        true
    }

    /// Takes the last step back.
    pub(super) fn undo(&mut self) {
        let Some(change) = self.changes.pop() else { return };
        change.linked.into_iter().for_each(|end| self.set_link(end, NONE));
        if let Some(upper) = self.all.pop() {
            let lower = &mut self.all[change.split as usize];
            (lower.last, lower.links[1]) = (upper.last, upper.links[1]);
            self.set_link(upper.links[1], 2 * change.split + 1);
        }
        self.all.truncate(change.before as usize);
        (self.tip, self.loops) = (change.tip, change.loops);
    }

    /// Tells whether the tunnel may end at terminal `x`: whether nothing is closed when the tip is linked with it.
    pub(super) fn may_end_at(&mut self, ids: &Ids, x: u32) -> bool {
        let before = self.all.len();
        let p = self.piece_of(ids, x);
        let (piece, position) = (self.all[p as usize], ids.position(x));
        let is_free = |side: u32| {
            let is_terminal = position == if side == 0 { 0 } else { ids.last(piece.path) };
            is_terminal && piece.links[side as usize] == NONE && self.tip != 2 * p + side
        };
        let end = (0..2).find(|&side| is_free(side)).map(|side| 2 * p + side);
        let may = self.loops == 0 && end.is_some_and(|end| self.other_end(self.tip) != end);
        self.all.truncate(before);
        may
    }

    /// Counts the loops that are closed at present, each of which a later cut may open.
    pub(super) fn loops(&self) -> u32 {
        self.loops
    }

    /// Follows a path from a free end of it to the other one.
    fn other_end(&self, mut end: u32) -> u32 {
        loop {
            end ^= 1;
            let next = self.link(end);
            if next == NONE {
                return end;
            }
            end = next;
        }
    }

    fn is_on_loop(&self, piece: u32) -> bool {
        let mut end = 2 * piece;
        loop {
            end = self.link(end ^ 1);
            if end == NONE || end / 2 == piece {
                return end != NONE;
            }
        }
    }

    fn link(&self, end: u32) -> u32 {
        self.all[end as usize / 2].links[end as usize % 2]
    }

    fn set_link(&mut self, end: u32, to: u32) {
        if end != NONE {
            self.all[end as usize / 2].links[end as usize % 2] = to;
        }
    }
}
