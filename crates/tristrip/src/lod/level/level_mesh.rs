//! The triangles of a level and the rings of corners around its vertices, updated by collapses and splits.
//!
//! ```text
//!        x                      x         The corners around each vertex form a ring. A collapse removes the dropped triangles'
//!      ╱ │ ╲                   ╱ ╲        corners from their rings and moves the removed vertex's ring into the kept one's.
//!    ╱ d │ d ╲       ─▶      ╱     ╲      A corner removed from a linked ring still knows its neighbours, so that the split
//!  kept──removed──         kept────────   restores it in O(1), as long as splits undo the last collapse first.
//! ```
//! `simplify` keeps its own structure under collapses (`simplify/topology.rs`): it never splits, needs no twins, and stores rings as arrays, which its
//! searches read in order. Here splits must restore rings exactly, which linked rings do in O(1) per corner.
//!
//! A view of Skip Strips undoes collapses in another order: all that depend on one first, but others that were done later may stay. Then the neighbours that a
//! corner knows may be gone, and it goes to the front of its ring; and the corners that a split takes from the kept vertex's ring are
//! those whose vertex in the full mesh is below the removed one in the tree of all collapses.
//!
//! # References
//! Knuth: *Dancing links*, 2000.
//!
//! # Complexity
//! A collapse or a split takes O(k) time where k triangles surround the removed vertices, or, in any order, the kept ones. 36 bytes per triangle and 8 per
//! vertex; in any order 8 bytes per vertex more.

use std::sync::Arc;

use super::vertex_ranges::VertexRanges;
use crate::collapse::{Collapse, CollapseSequence};
use crate::mesh::is_degenerate;

/// The triangles of a level under collapses and splits. Corner e of triangle t is 3 t + e.
#[derive(Debug, Clone)]
pub(crate) struct LevelMesh {
    /// The current vertex at each corner, or the one at the time when its triangle was dropped.
    corners: Vec<u32>,
    /// The ring of each vertex: its corners and its head. Heads are numbered after all corners.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// What splits in any order need.
    full: Option<FullMesh>,
}

/// The full mesh of a level mesh of which any collapse may be undone that no other one depends on.
#[derive(Debug, Clone)]
struct FullMesh {
    sequence: Arc<CollapseSequence>,
    ranges: VertexRanges,
}

impl LevelMesh {
    /// Builds the full mesh, of which collapses may be done and undone in any order in which what they depend on is done.
    pub(crate) fn in_any_order(sequence: &Arc<CollapseSequence>) -> Self {
        let full = FullMesh { sequence: Arc::clone(sequence), ranges: VertexRanges::new(sequence) };
        Self { full: Some(full), ..Self::new(sequence) }
    }

    /// Builds the full mesh. Triangles that are not drawn are in no ring.
    pub(crate) fn new(sequence: &CollapseSequence) -> Self {
        let corners = sequence.triangles().to_vec();
        let ring = 0..(corners.len() + sequence.vertex_count()) as u32;
        let mut surface =
            Self { corners, next: ring.clone().collect(), previous: ring.collect(), full: None };
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

    /// Returns the memory of the mesh in bytes.
    pub(crate) fn memory(&self) -> usize {
        let ranges = self.full.as_ref().map_or(0, |full| full.ranges.memory());
        let lists = [&self.corners, &self.next, &self.previous].map(|list| size_of_val(&list[..]));
        ranges + lists.iter().sum::<usize>()
    }

    pub(crate) fn triangle_count(&self) -> usize {
        self.corners.len() / 3
    }

    /// Returns whether a triangle is drawn. A dropped triangle is degenerate.
    pub(crate) fn is_drawn(&self, t: u32) -> bool {
        !is_degenerate(self.triangle(t))
    }

    /// Returns the vertices of a triangle.
    pub(crate) fn triangle(&self, t: u32) -> [u32; 3] {
        [0, 1, 2].map(|e| self.corners[3 * t as usize + e])
    }

    /// Returns the vertices at which a half-edge begins and ends. Half-edges are numbered by fours, as in priced paths: edge e of triangle t
    /// is 4 t + e.
    pub(crate) fn edge(&self, half_edge: u32) -> [u32; 2] {
        let triangle = self.triangle(half_edge / 4);
        let e = half_edge as usize % 4;
        [triangle[e], triangle[(e + 1) % 3]]
    }

    /// Iterates over the corners at a vertex that is not removed.
    pub(crate) fn around(&self, v: u32) -> impl Iterator<Item = u32> {
        let head = self.head(v);
        std::iter::successors(Some(self.next[head as usize]), |&corner| Some(self.next[corner as usize]))
            .take_while(move |&corner| corner != head)
    }

    /// Applies a collapse.
    pub(crate) fn collapse(&mut self, collapse: &Collapse<'_>) {
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

    /// Undoes a collapse: the last applied one, or in a mesh of any order one that no other depends on.
    pub(crate) fn split(&mut self, collapse: &Collapse<'_>) {
        if let Some(full) = self.full.take() {
            self.split_in_any_order(collapse, &full);
            self.full = Some(full);
            return;
        }
        for &t in collapse.dropped.iter().rev() {
            (3 * t..3 * t + 3).rev().for_each(|corner| self.link(corner));
        }
        for rename in collapse.renames.iter().rev() {
            // The removed vertex's head still refers to the ends of its ring.
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

    fn split_in_any_order(&mut self, collapse: &Collapse<'_>, full: &FullMesh) {
        for &t in collapse.dropped {
            for (v, corner) in self.triangle(t).into_iter().zip(3 * t..) {
                self.insert(corner, v);
            }
        }
        for rename in collapse.renames.iter().rev() {
            let head = self.head(rename.removed);
            self.follow(head, head);
            let kept = self.head(rename.kept);
            let mut corner = self.next[kept as usize];
            while corner != kept {
                let next = self.next[corner as usize];
                let leaf = full.sequence.triangles()[corner as usize];
                if full.ranges.contains(rename.removed, leaf) {
                    self.unlink(corner);
                    self.corners[corner as usize] = rename.removed;
                    self.insert(corner, rename.removed);
                }
                corner = next;
            }
        }
    }

    /// Puts a corner to the front of the ring of a vertex.
    fn insert(&mut self, corner: u32, vertex: u32) {
        let head = self.head(vertex);
        let after = self.next[head as usize];
        self.follow(head, corner);
        self.follow(corner, after);
    }

    /// Returns the edges that two triangles share, by the half-edges of the two sides, numbered as in [`LevelMesh::edge`].
    pub(crate) fn shared(&self, t: u32, u: u32) -> impl Iterator<Item = [u32; 2]> {
        let [from, to] = [t, u].map(|t| self.triangle(t));
        let edges = (0..3_u32).flat_map(|e| (0..3_u32).map(move |f| (e, f)));
        edges.filter_map(move |(e, f)| {
            let [a, b] = [from[e as usize], from[(e as usize + 1) % 3]];
            let is_shared = [b, a] == [to[f as usize], to[(f as usize + 1) % 3]];
            is_shared.then_some([4 * t + e, 4 * u + f])
        })
    }

    /// Returns the head of the ring of a vertex.
    fn head(&self, v: u32) -> u32 {
        self.corners.len() as u32 + v
    }

    /// Sets the vertex at the corners of a ring from one of them up to `end`.
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

    /// Puts a corner back between its stored neighbours.
    fn link(&mut self, corner: u32) {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        self.next[before as usize] = corner;
        self.previous[after as usize] = corner;
    }

    /// Removes a corner from its ring; it keeps its stored neighbours.
    fn unlink(&mut self, corner: u32) {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
    }
}
