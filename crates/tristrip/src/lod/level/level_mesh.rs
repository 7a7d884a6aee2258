//! The triangles of a level and the ring of corners around each vertex, updated by collapses and
//! splits.
//!
//! ```text
//!        x                      x
//!      ╱ │ ╲                   ╱ ╲
//!    ╱ d │ d ╲       ─▶      ╱     ╲
//!  kept──removed──         kept────────
//! ```
//! The corners around each vertex form a ring. A collapse removes the corners of the dropped
//! triangles from their rings, and moves the ring of the removed vertex into the ring of the kept
//! vertex. A corner removed from a linked ring keeps its neighbours. A split therefore restores it
//! in O(1), provided that splits undo the last collapse first.
//!
//! `simplify` has its own structure (`simplify/surface/topology.rs`): it never splits, needs no
//! twins, and stores rings as arrays, which its searches read sequentially. Here splits must
//! restore rings exactly. Linked rings do that in O(1) per corner.
//!
//! A view of Skip Strips undoes collapses in a different order. The collapses that depend on a
//! collapse are undone first, but other later collapses may remain applied. The stored neighbours
//! of a corner may then have left the ring, and the corner is inserted at the front instead. A
//! split takes corners from the ring of the kept vertex. It takes a corner if its vertex in the
//! full mesh is the removed vertex or one of its descendants in the collapse tree.
//!
//! # References
//! Knuth: *Dancing links*, 2000.
//!
//! # Complexity
//! A collapse or split takes O(k) time, where k is the number of triangles around the removed
//! vertices, or around the kept vertices in arbitrary order. The structure takes 36 bytes per
//! triangle and 8 bytes per vertex. Arbitrary order takes another 8 bytes per vertex.

use std::sync::Arc;

use super::vertex_ranges::VertexRanges;
use crate::collapse::{Collapse, CollapseSequence};
use crate::mesh::is_degenerate;

/// The triangles of a level, updated by collapses and splits. Corner e of triangle t is 3 t + e.
#[derive(Debug, Clone)]
pub(crate) struct LevelMesh {
    /// The current vertex at each corner. Corners of dropped triangles keep the vertex they had
    /// when the triangle was dropped.
    corners: Vec<u32>,
    /// The ring of each vertex, made of its corners and a head. Heads are numbered after all
    /// corners.
    next: Vec<u32>,
    previous: Vec<u32>,
    /// The data for splits in arbitrary order.
    full: Option<FullMesh>,
}

/// The data for undoing any collapse that no other collapse depends on.
#[derive(Debug, Clone)]
struct FullMesh {
    sequence: Arc<CollapseSequence>,
    ranges: VertexRanges,
}

impl LevelMesh {
    /// Builds the full mesh for collapses and splits in any order that respects their dependencies.
    pub(crate) fn in_any_order(sequence: &Arc<CollapseSequence>) -> Self {
        let full = FullMesh { sequence: Arc::clone(sequence), ranges: VertexRanges::new(sequence) };
        Self { full: Some(full), ..Self::new(sequence) }
    }

    /// Builds the full mesh. Degenerate triangles belong to no ring.
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

    /// Checks whether a triangle is drawn. Dropped triangles are degenerate.
    pub(crate) fn is_drawn(&self, t: u32) -> bool {
        !is_degenerate(self.triangle(t))
    }

    /// Returns the vertices of a triangle.
    pub(crate) fn triangle(&self, t: u32) -> [u32; 3] {
        [0, 1, 2].map(|e| self.corners[3 * t as usize + e])
    }

    /// Returns the start and end vertex of a half-edge. Half-edges use the numbering of priced
    /// paths: edge e of triangle t is 4 t + e.
    pub(crate) fn edge(&self, half_edge: u32) -> [u32; 2] {
        let triangle = self.triangle(half_edge / 4);
        let e = half_edge as usize % 4;
        [triangle[e], triangle[(e + 1) % 3]]
    }

    /// Iterates over the corners at a vertex of the level.
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

    /// Undoes a collapse: the last one applied, or, in arbitrary order, one that no other applied
    /// collapse depends on.
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
            // The removed vertex's head still points to both ends of its ring.
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

    /// Inserts a corner at the front of the ring of a vertex.
    fn insert(&mut self, corner: u32, vertex: u32) {
        let head = self.head(vertex);
        let after = self.next[head as usize];
        self.follow(head, corner);
        self.follow(corner, after);
    }

    /// Returns the shared edges of two triangles as pairs of half-edges, numbered as in
    /// [`LevelMesh::edge`].
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

    /// Sets the vertex of the corners of a ring from `first` up to, but excluding, `end`.
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

    /// Relinks a corner between its stored neighbours.
    fn link(&mut self, corner: u32) {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        self.next[before as usize] = corner;
        self.previous[after as usize] = corner;
    }

    /// Unlinks a corner from its ring. The corner keeps its stored neighbours.
    fn unlink(&mut self, corner: u32) {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
    }
}
