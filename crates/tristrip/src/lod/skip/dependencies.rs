//! Dependencies: which collapses must be done before another one, so that no view folds the surface over where the simplification did not.
//!
//! A collapse was checked in the neighbourhood that the simplification had at that time. It may be done again whenever that
//! neighbourhood is there: when all vertices around it have the children that they had then.
//!
//! ```text
//!        n1 ── n2             The collapse of c to p needs the last collapse before it into each of c, p, and n0 … n5. Whatever else is done
//!       ╱  ╲  ╱  ╲            or not, its triangles are then those of the simplification.
//!     n0 ── p ── c ── n3
//!       ╲  ╱  ╲  ╱            A split needs, in turn, that none of the collapses that need it is done.
//!        n5 ── n4
//! ```
//! # Algorithm
//! The collapses are replayed from the full mesh on. Each needs, for every vertex of the triangles of its vertices, the last collapse into
//! that vertex. A collapse that drops the last triangle that a third vertex has with the kept one counts as one into that vertex, too: otherwise nothing would tell
//! a later collapse of it that this triangle was gone. One is left out if another one of the list needs it already: the published reduction leaves out nodes of which an ancestor is in the
//! list, and this one also those that are needed otherwise.
//!
//! Every triangle of a view is then one that the simplification had at some time: its corners were last changed by some collapse of the view, which had
//! the neighbourhood of the simplification.
//!
//! # Departures
//! - A kept vertex of more than [`MAX_TRIANGLES`] triangles counts without its neighbours, so that the time stays linear where thousands of collapses go
//!   to one vertex. The collapses of `simplify` never keep such a vertex unless they break the topology.
//! - Implicit dependencies (El-Sana, Varshney 1999) compare the numbers of vertices around a collapse, and find these by triangles that are stored and
//!   tagged one by one. A display strip has no such triangles: what surrounds a vertex is only known by a scan of all strips
//!   through it. They would save the lists, 8 bytes per vertex, and cost that scan at each check.
//!
//! # References
//! Xia, El-Sana, Varshney 1997 (dependencies); El-Sana, Evans, Kalaiah, Varshney, Skiena, Azanli 2000, section 5.2.1 (the reduction).
//!
//! # Complexity
//! O(t) time for t triangles around all collapses; two packed lists, of about two collapses each, per collapse.

use super::vertex_tree::{NodeNumbers, VertexTree};
use crate::collapse::{CollapseSequence, Rename};
use crate::csr::Csr;
use crate::ids::OptionalId;
use crate::lod::level::level_mesh::LevelMesh;
use crate::packed::PackedRows;

/// The most triangles of a kept vertex whose neighbours count.
const MAX_TRIANGLES: usize = 1024;

/// The collapses that each collapse needs, and those that need it, by their ids.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Dependencies {
    needed: PackedRows,
    dependents: PackedRows,
}

impl Dependencies {
    /// Replays the collapses of a tree.
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

    /// Iterates over the collapses that a collapse needs.
    #[inline]
    pub(super) fn needed(&self, collapse_id: u32) -> impl Iterator<Item = u32> {
        self.needed.row(collapse_id)
    }

    /// Iterates over the collapses that need a collapse.
    #[inline]
    pub(super) fn dependents(&self, collapse_id: u32) -> impl Iterator<Item = u32> {
        self.dependents.row(collapse_id)
    }

    /// Returns the positions of the collapses that need a collapse, for [`Dependencies::dependent`].
    #[inline]
    pub(super) fn dependents_range(&self, collapse_id: u32) -> std::ops::Range<u32> {
        self.dependents.range(collapse_id..collapse_id + 1)
    }

    /// Returns the positions of the collapses that a collapse needs, for [`Dependencies::needed_at`].
    #[inline]
    pub(super) fn needed_range(&self, collapse_id: u32) -> std::ops::Range<u32> {
        self.needed.range(collapse_id..collapse_id + 1)
    }

    /// Returns a collapse that is needed by its position.
    #[inline]
    pub(super) fn needed_at(&self, position: u32) -> u32 {
        self.needed.item(position)
    }

    /// Returns a collapse by its position.
    #[inline]
    pub(super) fn dependent(&self, position: u32) -> u32 {
        self.dependents.item(position)
    }

    /// Counts the entries of the lists.
    pub(super) fn len(&self) -> usize {
        self.needed.item_count()
    }

    pub(super) fn memory(&self) -> usize {
        self.needed.memory() + self.dependents.memory()
    }
}

/// Checks whether a vertex has no triangle with a kept vertex.
fn is_apart(mesh: &LevelMesh, vertex: u32, renames: &[Rename]) -> bool {
    let mut triangles = mesh.around(vertex).take(MAX_TRIANGLES).map(|corner| mesh.triangle(corner / 3));
    triangles.all(|triangle| renames.iter().all(|rename| !triangle.contains(&rename.kept)))
}

/// The collapses of a replay, by their numbers from the full mesh, and what each needs.
struct TreeReplay {
    /// The nodes around the next collapse, some of them repeated.
    around: Vec<u32>,
    /// The last collapse into each node.
    last: Vec<OptionalId>,
    /// The collapses around the next one, the latest first.
    latest: Vec<u32>,
    needed: Vec<u32>,
    ends: Vec<u32>,
    /// For each collapse the number after that of the last one for which it was found to be needed already.
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

    /// Counts the collapse that was found last as one into these nodes.
    fn touch(&mut self, nodes: impl Iterator<Item = u32>) {
        let number = self.ends.len() as u32 - 1;
        nodes.for_each(|node| self.last[node as usize] = OptionalId::some(number));
    }

    /// Finds what the next collapse needs, which keeps these nodes.
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

    /// Iterates over all collapses, with what each needs.
    fn rows(&self) -> impl Iterator<Item = (usize, &[u32])> + Clone {
        (0..self.ends.len()).map(|number| (number, &self.needed[range(&self.ends, number)]))
    }
}

/// Returns the range of a row.
fn range(ends: &[u32], row: usize) -> std::ops::Range<usize> {
    let start = if row == 0 { 0 } else { ends[row - 1] };
    start as usize..ends[row] as usize
}
