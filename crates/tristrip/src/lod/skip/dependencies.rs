//! Dependencies: the collapses that must be applied before another one. They ensure that a view
//! contains no foldovers that the simplification does not contain.
//!
//! The simplification checked each collapse only in its neighbourhood at that time. A collapse is
//! valid whenever its neighbourhood is the same as then: all vertices around it have the same
//! children as in the simplification.
//!
//! ```text
//!       n1 ── n2
//!      ╱  ╲  ╱  ╲
//!    n0 ── p ── c ── n3
//!      ╲  ╱  ╲  ╱
//!       n5 ── n4
//! ```
//! The collapse of c to p depends on the last earlier collapse into each of c, p and n0 … n5. Its
//! triangles are then the same as in the simplification, whatever else is applied. In turn, a
//! collapse can be split only if no applied collapse depends on it.
//! # Algorithm
//! The collapses are replayed from the full mesh. A collapse depends on the last collapse into each
//! vertex of the triangles around its own vertices. A collapse that drops the last triangle between
//! the kept vertex and a third vertex also counts as a collapse into the third vertex. Otherwise a
//! later collapse of the third vertex would not depend on the removal of this triangle. A
//! dependency is omitted if another dependency in the list already depends on it. The published
//! reduction omits nodes with an ancestor in the list. This reduction also omits nodes that another
//! collapse in the list depends on.
//!
//! Every triangle of a view then also exists at some level of the simplification. The collapse that
//! last changed its corners had the same neighbourhood in the view as in the simplification.
//!
//! # Departures
//! - The neighbours of a kept vertex with more than [`MAX_TRIANGLES`] triangles are ignored. The
//!   time then remains linear even if thousands of vertices collapse to one vertex. The collapses
//!   of `simplify` never keep such a vertex unless they change the topology.
//! - Implicit dependencies (El-Sana, Varshney 1999) compare the vertex numbers around a collapse,
//!   and find them through triangles that are stored and tagged one by one. Display strips have no
//!   such triangles: finding the neighbours of a vertex requires a scan of all strips through it.
//!   Implicit dependencies would save the lists, 8 bytes per vertex, but need this scan for each
//!   check.
//!
//! # References
//! Xia, El-Sana, Varshney 1997 (dependencies); El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli
//! 2000, section 5.2.1 (the reduction).
//!
//! # Complexity
//! O(t) time for t triangles around all collapses. Two packed lists per collapse, with about two
//! entries each.

use super::vertex_tree::{NodeNumbers, VertexTree};
use crate::collapse::{CollapseSequence, Rename};
use crate::csr::Csr;
use crate::ids::OptionalId;
use crate::lod::level::level_mesh::LevelMesh;
use crate::packed::PackedRows;

/// The neighbours of a kept vertex with more triangles than this are ignored.
const MAX_TRIANGLES: usize = 1024;

/// The dependencies and the dependents of each collapse, by collapse id.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dependencies {
    needed: PackedRows,
    dependents: PackedRows,
}

impl Dependencies {
    /// Replays the collapses of a tree and finds their dependencies.
    pub(super) fn new(sequence: &CollapseSequence, tree: &VertexTree, numbers: &NodeNumbers) -> Self {
        let mut mesh = LevelMesh::new(sequence);
        let mut replay = TreeReplay::new(tree.len(), sequence.len());
        let mut collapse_ids = Vec::with_capacity(sequence.len());
        for collapse in sequence.iter() {
            let Some(first) = collapse.renames.first() else { continue };
            collapse_ids.push(numbers.of(first.removed));
            replay.around.clear();
            for rename in collapse.renames {
                for (v, most) in [(rename.removed, usize::MAX), (rename.kept, MAX_TRIANGLES)] {
                    replay.around.push(numbers.of(v));
                    if mesh.around(v).nth(most).is_none() {
                        let triangles = mesh.around(v).map(|corner| mesh.triangle(corner / 3));
                        replay.around.extend(triangles.flatten().map(|v| numbers.of(v)));
                    }
                }
            }
            replay.next(collapse.renames.iter().map(|rename| numbers.of(rename.kept)));
            let corners = collapse.dropped.iter().flat_map(|&t| mesh.triangle(t));
            let mut thirds: Vec<u32> =
                corners.filter(|&v| collapse.renames.iter().all(|r| r.removed != v && r.kept != v)).collect();
            mesh.collapse(&collapse);
            thirds.retain(|&v| is_apart(&mesh, v, collapse.renames));
            replay.touch(thirds.into_iter().map(|v| numbers.of(v)));
        }
        drop(mesh);
        let collapse_ids = &collapse_ids;
        let keyed = replay.rows().flat_map(move |(number, row)| {
            row.iter().map(move |&needed| (collapse_ids[number], collapse_ids[needed as usize]))
        });
        let needed = Csr::group_items(keyed.clone(), tree.len());
        let needed = PackedRows::of(needed.rows());
        let dependents =
            Csr::group_items(keyed.map(|(collapse_id, needed)| (needed, collapse_id)), tree.len());
        Self { needed, dependents: PackedRows::of(dependents.rows()) }
    }

    /// Iterates over the dependencies of a collapse.
    #[inline]
    pub(super) fn needed(&self, collapse_id: u32) -> impl Iterator<Item = u32> {
        self.needed.row(collapse_id)
    }

    /// Iterates over the collapses that depend on a collapse.
    #[inline]
    pub(super) fn dependents(&self, collapse_id: u32) -> impl Iterator<Item = u32> {
        self.dependents.row(collapse_id)
    }

    /// Returns the positions of the dependents of a collapse, for [`Dependencies::dependent`].
    #[inline]
    pub(super) fn dependents_range(&self, collapse_id: u32) -> std::ops::Range<u32> {
        self.dependents.range(collapse_id..collapse_id + 1)
    }

    /// Returns the positions of the dependencies of a collapse, for [`Dependencies::needed_at`].
    #[inline]
    pub(super) fn needed_range(&self, collapse_id: u32) -> std::ops::Range<u32> {
        self.needed.range(collapse_id..collapse_id + 1)
    }

    /// Returns the dependency at a position.
    #[inline]
    pub(super) fn needed_at(&self, position: u32) -> u32 {
        self.needed.item(position)
    }

    /// Returns the dependent at a position.
    #[inline]
    pub(super) fn dependent(&self, position: u32) -> u32 {
        self.dependents.item(position)
    }

    /// Returns the number of dependencies of all collapses.
    pub(super) fn len(&self) -> usize {
        self.needed.item_count()
    }

    pub(super) fn memory(&self) -> usize {
        self.needed.memory() + self.dependents.memory()
    }
}

/// Checks whether a vertex shares no triangle with any kept vertex.
fn is_apart(mesh: &LevelMesh, vertex: u32, renames: &[Rename]) -> bool {
    let mut triangles = mesh.around(vertex).take(MAX_TRIANGLES).map(|corner| mesh.triangle(corner / 3));
    triangles.all(|triangle| renames.iter().all(|rename| !triangle.contains(&rename.kept)))
}

/// The collapses of a replay, numbered from the full mesh, and the dependencies of each.
struct TreeReplay {
    /// The nodes around the next collapse, with repetitions.
    around: Vec<u32>,
    /// The last collapse into each node.
    last: Vec<OptionalId>,
    /// The collapses around the next one, latest first.
    latest: Vec<u32>,
    needed: Vec<u32>,
    ends: Vec<u32>,
    /// For each collapse, the last collapse for which it was found to be an indirect dependency,
    /// plus 1.
    marks: Vec<u32>,
}

impl TreeReplay {
    fn new(node_count: usize, collapse_count: usize) -> Self {
        Self {
            around: Vec::new(),
            last: vec![OptionalId::NONE; node_count],
            latest: Vec::new(),
            needed: Vec::new(),
            ends: Vec::with_capacity(collapse_count),
            marks: vec![0; collapse_count],
        }
    }

    /// Records the current collapse as the last one into these nodes.
    fn touch(&mut self, nodes: impl Iterator<Item = u32>) {
        let number = self.ends.len() as u32 - 1;
        nodes.for_each(|node| self.last[node as usize] = OptionalId::some(number));
    }

    /// Finds the dependencies of the next collapse, which keeps these nodes.
    fn next(&mut self, kept: impl Iterator<Item = u32>) {
        let number = self.ends.len() as u32;
        self.latest.clear();
        self.latest.extend(self.around.iter().filter_map(|&node| self.last[node as usize].get()));
        self.latest.sort_unstable_by(|a, b| b.cmp(a));
        self.latest.dedup();
        for &before in &self.latest {
            if self.marks[before as usize] <= number {
                self.needed.push(before);
                for i in range(&self.ends, before as usize) {
                    self.marks[self.needed[i] as usize] = number + 1;
                }
            }
        }
        self.ends.push(self.needed.len() as u32);
        self.touch(kept);
    }

    /// Iterates over all collapses with the dependencies of each.
    fn rows(&self) -> impl Iterator<Item = (usize, &[u32])> + Clone {
        (0..self.ends.len()).map(|number| (number, &self.needed[range(&self.ends, number)]))
    }
}

/// Returns the range of a row.
fn range(ends: &[u32], row: usize) -> std::ops::Range<usize> {
    let start = if row == 0 { 0 } else { ends[row - 1] };
    start as usize..ends[row] as usize
}
