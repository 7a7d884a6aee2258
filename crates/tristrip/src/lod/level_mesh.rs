//! The triangles of a level and who shares an edge with whom, kept up to date by collapses and splits.
//!
//! ```text
//!        x                      x         The corners around each vertex stand in a ring. A collapse takes the dropped
//!      ╱ │ ╲                   ╱ ╲        triangles' corners out of their rings and moves the removed vertex's ring into the
//!    ╱ d │ d ╲       ─▶      ╱     ╲      kept one's. What is taken out of a linked ring still knows its neighbours, so that
//!  kept──removed──         kept────────   the split puts it back in O(1), as long as splits undo the last collapse first.
//! ```
//! The two sides of an edge are each other's twins where they have opposite directions. Of more sides, those that
//! were twins stay so, and each other one, in order of the triangles, takes the last of the other direction that has none yet. Sides change only around the kept vertex of a collapse, and around both
//! vertices of a split, and are found there anew.
//!
//! # References
//! Knuth: *Dancing links*, 2000.
//!
//! # Complexity
//! A collapse or a split takes O(k log k) time where k triangles stand around the vertices that it names; 36 bytes a triangle and 8 a vertex.

use crate::collapse::{Collapse, CollapseSequence};
use crate::mesh::is_degenerate;

/// Triangles that collapses rename and drop. Corner e of triangle t is 3 t + e.
#[derive(Debug, Clone)]
pub(super) struct LevelMesh {
    /// The vertex at each corner, as it is named now, or was when its triangle was dropped.
    corners: Vec<u32>,
    /// The ring of each vertex: its corners and, after all corners, its head.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Sides around a vertex, sorted by edge.
    sides: Vec<u64>,
    /// Those of an edge that have no twin yet.
    waiting: Vec<u64>,
}

impl LevelMesh {
    /// Takes the triangles of the full mesh that are drawn; the others have no place in the rings.
    pub(super) fn new(sequence: &CollapseSequence) -> Self {
        let corners = sequence.triangles().to_vec();
        let ring = 0..(corners.len() + sequence.vertex_count()) as u32;
        let mut surface = Self {
            corners,
            next: ring.clone().collect(),
            previous: ring.collect(),
            sides: Vec::new(),
            waiting: Vec::new(),
        };
        for t in 0..surface.triangle_count() as u32 {
            if surface.is_drawn(t) {
                surface.triangle(t).into_iter().zip(3 * t..).for_each(|(v, corner)| {
                    let head = surface.head(v);
                    surface.next[corner as usize] = head;
                    surface.previous[corner as usize] = surface.previous[head as usize];
                    surface.link(corner);
                });
            }
        }
        surface
    }

    pub(super) fn triangle_count(&self) -> usize {
        self.corners.len() / 3
    }

    /// Tells whether a triangle is there: one that was dropped has lost its area.
    pub(super) fn is_drawn(&self, t: u32) -> bool {
        !is_degenerate(self.triangle(t))
    }

    /// The vertices of a triangle.
    pub(super) fn triangle(&self, t: u32) -> [u32; 3] {
        [0, 1, 2].map(|e| self.corners[3 * t as usize + e])
    }

    /// Walks over the corners at a vertex that is not removed.
    pub(super) fn around(&self, v: u32) -> impl Iterator<Item = u32> {
        let head = self.head(v);
        std::iter::successors(Some(self.next[head as usize]), |&corner| Some(self.next[corner as usize]))
            .take_while(move |&corner| corner != head)
    }

    /// Does a collapse.
    pub(super) fn collapse(&mut self, collapse: &Collapse<'_>) {
        for rename in collapse.renames {
            let (from, to) = (self.head(rename.removed), self.head(rename.kept));
            let (first, last) = (self.next[from as usize], self.previous[from as usize]);
            if first == from {
                continue;
            }
            self.rename(first, from, rename.kept);
            let before = self.previous[to as usize];
            self.follow(before, first);
            self.follow(last, to);
        }
        for &t in collapse.dropped {
            (3 * t..3 * t + 3).for_each(|corner| self.unlink(corner));
        }
    }

    /// Undoes a collapse, which must be the last that is not undone.
    pub(super) fn split(&mut self, collapse: &Collapse<'_>) {
        for &t in collapse.dropped.iter().rev() {
            (3 * t..3 * t + 3).rev().for_each(|corner| self.link(corner));
        }
        for rename in collapse.renames.iter().rev() {
            // The removed vertex's head still knows the ends of its ring.
            let from = self.head(rename.removed);
            let (first, last) = (self.next[from as usize], self.previous[from as usize]);
            if first == from {
                continue;
            }
            let (before, after) = (self.previous[first as usize], self.next[last as usize]);
            self.follow(before, after);
            self.follow(from, first);
            self.follow(last, from);
            self.rename(first, from, rename.removed);
        }
    }

    /// Gives the edges that two triangles share, by the half-edges of the two sides, numbered as in [`LevelMesh::sides_around`].
    pub(super) fn shared(&self, t: u32, u: u32) -> impl Iterator<Item = [u32; 2]> {
        let [from, to] = [t, u].map(|t| self.triangle(t));
        let edges = (0..3_u32).flat_map(|e| (0..3_u32).map(move |f| (e, f)));
        edges.filter_map(move |(e, f)| {
            let [a, b] = [from[e as usize], from[(e as usize + 1) % 3]];
            let is_shared = [b, a] == [to[f as usize], to[(f as usize + 1) % 3]];
            is_shared.then_some([4 * t + e, 4 * u + f])
        })
    }

    /// Tells of each half-edge at a vertex that is not removed, on either side of an edge there, what its other side is, knowing what it
    /// was. They are numbered by fours, as paths have them: edge e of triangle t is 4 t + e.
    pub(super) fn sides_around(
        &mut self,
        v: u32,
        was: impl Fn(u32) -> Option<u32>,
        mut tell: impl FnMut(u32, Option<u32>),
    ) {
        let [mut sides, mut waiting] = [&mut self.sides, &mut self.waiting].map(std::mem::take);
        sides.clear();
        for corner in self.around(v) {
            let (next, previous) = match corner % 3 {
                0 => (corner + 1, corner + 2),
                1 => (corner + 1, corner - 1),
                _ => (corner - 2, corner - 1),
            };
            let side = |other: u32, half_edge: u32, comes: u64| {
                let by_fours = half_edge + half_edge / 3;
                u64::from(self.corners[other as usize]) << 32 | u64::from(by_fours) << 1 | comes
            };
            sides.extend([side(next, corner, 0), side(previous, previous, 1)]);
        }
        sides.sort_unstable();
        let half_edge = |side: u64| side as u32 >> 1;
        for edge in sides.chunk_by(|a, b| a >> 32 == b >> 32) {
            if let [one, other] = *edge
                && (one ^ other) & 1 == 1
            {
                tell(half_edge(one), Some(half_edge(other)));
                tell(half_edge(other), Some(half_edge(one)));
                continue;
            }
            let place = |h: u32| edge.binary_search_by_key(&h, |&side| half_edge(side)).ok();
            let keeps =
                |side: u64| was(half_edge(side)).and_then(place).filter(|&i| (edge[i] ^ side) & 1 == 1);
            waiting.clear();
            for &side in edge {
                if let Some(other) = keeps(side) {
                    tell(half_edge(side), Some(half_edge(edge[other])));
                    continue;
                }
                // All that wait have one direction.
                match waiting.pop_if(|last| (*last ^ side) & 1 == 1) {
                    Some(last) => {
                        tell(half_edge(last), Some(half_edge(side)));
                        tell(half_edge(side), Some(half_edge(last)));
                    }
                    None => waiting.push(side),
                }
            }
            waiting.iter().for_each(|&side| tell(half_edge(side), None));
        }
        self.waiting = waiting;
        self.sides = sides;
    }

    /// The place of a vertex in its own ring.
    fn head(&self, v: u32) -> u32 {
        self.corners.len() as u32 + v
    }

    /// Names the vertex at the corners of a ring from one of them up to an end.
    fn rename(&mut self, first: u32, end: u32, vertex: u32) {
        let mut corner = first;
        while corner != end {
            self.corners[corner as usize] = vertex;
            corner = self.next[corner as usize];
        }
    }

    fn follow(&mut self, before: u32, after: u32) {
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
    }

    /// Puts a corner back between the neighbours that it knows.
    fn link(&mut self, corner: u32) {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        self.next[before as usize] = corner;
        self.previous[after as usize] = corner;
    }

    /// Takes a corner out from between its neighbours, and leaves it knowing them.
    fn unlink(&mut self, corner: u32) {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
    }
}
