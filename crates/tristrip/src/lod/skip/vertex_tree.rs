//! The vertex tree: each vertex has pointers to the vertex it collapses to, and to its ancestors 2,
//! 4, 8 … steps up.
//!
//! Vertices are numbered depth-first as *nodes*. The vertices that a node replaces are then a
//! contiguous range of nodes, and the children of a node can be found without a list:
//!
//! ```text
//!        a               nodes      0 1 2 3 4
//!      ╱ │ ╲             vertices   a b e c d
//!     d  c  b            ends       5 3 3 4 5
//!           │            parents    - 0 1 0 0
//!           e
//! ```
//! The child that collapsed last comes first. The children of a are node 1, node 3 (the end of the
//! subtree of 1) and node 4 (the end of the subtree of 3).
//!
//! A point on a seam has several vertices, which collapse together. The collapse is identified by
//! the node of the first one.
//!
//! # Complexity
//! O(n) time. 12 bytes per vertex, plus log₂(depth) packed pointers per vertex.

use crate::collapse::CollapseSequence;
use crate::error::Error;
use crate::ids::OptionalId;
use crate::lod::level::vertex_ranges::{CollapseTree, ends};
use crate::mesh::{SPARSE, VertexSubset};
use crate::packed::PackedRows;

/// The vertices in use as nodes of a forest.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct VertexTree {
    vertices: Vec<u32>,
    parents: Vec<OptionalId>,
    ends: Vec<u32>,
    /// The ancestors 2, 4, 8 … steps up.
    ancestors: PackedRows,
    /// The nodes of collapses with several vertices: the id and the other nodes, sorted by id.
    groups: Vec<(u32, Vec<u32>)>,
    /// The collapse ids of these other nodes, sorted by node.
    followers: Vec<(u32, u32)>,
    /// Whether a node is in a group, one bit per node. Most nodes are not, which avoids a search.
    is_grouped: Vec<u64>,
    depth: u32,
}

/// The node of each vertex in use.
pub(super) struct NodeNumbers {
    subset: Option<VertexSubset>,
    nodes: Vec<u32>,
}

impl NodeNumbers {
    /// Returns the node of a vertex in use.
    #[inline]
    pub(super) fn of(&self, vertex: u32) -> u32 {
        let number = self.subset.as_ref().map_or(vertex, |subset| subset.number(vertex));
        self.nodes[number as usize]
    }
}

impl VertexTree {
    /// Builds the tree of all collapses, and returns it with the node of each vertex.
    ///
    /// # Errors
    /// A vertex is removed twice, or kept after it was removed.
    pub(super) fn new(sequence: &CollapseSequence) -> Result<(Self, NodeNumbers), Error> {
        let triangles = sequence.triangles();
        let is_sparse = sequence.vertex_count() / SPARSE > triangles.len();
        let subset = is_sparse.then(|| VertexSubset::of(triangles));
        let count = subset.as_ref().map_or(sequence.vertex_count(), VertexSubset::len);
        let number = |v: u32| subset.as_ref().map_or(v, |subset| subset.number(v));
        let mut links = CollapseTree::new(count);
        for (i, rename) in sequence.iter().flat_map(|collapse| collapse.renames).enumerate() {
            if !links.add(number(rename.removed), number(rename.kept)) {
                return Err(Error::Parameter {
                    name: "collapses",
                    found: format!("vertex {} renamed to {} by rename {i}", rename.removed, rename.kept),
                    expected: "vertices that were not removed before",
                });
            }
        }
        let order = links.depth_first();
        let mut nodes = vec![0; count];
        (0..).zip(&order).for_each(|(node, &v)| nodes[v as usize] = node);
        let parent = |&v: &u32| links.parent(v).map(|p| nodes[p as usize]).into();
        let parents: Vec<OptionalId> = order.iter().map(parent).collect();
        let vertices = match &subset {
            Some(subset) => order.iter().map(|&v| subset.vertices()[v as usize]).collect(),
            None => order,
        };
        let numbers = NodeNumbers { subset, nodes };
        let (ancestors, depth) = ancestors(&parents);
        let mut tree = Self {
            ends: ends(&parents),
            vertices,
            parents,
            ancestors,
            groups: Vec::new(),
            followers: Vec::new(),
            is_grouped: Vec::new(),
            depth,
        };
        tree.group(sequence, &numbers);
        Ok((tree, numbers))
    }

    /// Finds the ids of collapses with several vertices.
    fn group(&mut self, sequence: &CollapseSequence, numbers: &NodeNumbers) {
        for collapse in sequence.iter().filter(|collapse| collapse.renames.len() > 1) {
            let mut nodes = collapse.renames.iter().map(|rename| numbers.of(rename.removed));
            let Some(collapse_id) = nodes.next() else { continue };
            let others: Vec<u32> = nodes.collect();
            self.followers.extend(others.iter().map(|&other| (other, collapse_id)));
            self.groups.push((collapse_id, others));
        }
        self.groups.sort_unstable();
        self.followers.sort_unstable();
        self.is_grouped = vec![0; self.len().div_ceil(64)];
        for &(follower, collapse_id) in &self.followers {
            for node in [follower, collapse_id] {
                self.is_grouped[node as usize / 64] |= 1 << (node % 64);
            }
        }
    }

    /// Checks whether a node collapses together with others.
    #[inline]
    fn is_grouped(&self, node: u32) -> bool {
        self.is_grouped[node as usize / 64] >> (node % 64) & 1 == 1
    }

    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Returns the maximum number of ancestors of a node.
    pub(super) fn depth(&self) -> u32 {
        self.depth
    }

    /// Returns the vertex of a node.
    #[inline]
    pub(super) fn vertex(&self, node: u32) -> u32 {
        self.vertices[node as usize]
    }

    /// Returns the node that a node collapses to.
    #[inline]
    pub(super) fn parent(&self, node: u32) -> Option<u32> {
        self.parents[node as usize].get()
    }

    /// Returns the end of the subtree of a node. The subtree is the range of nodes that starts with
    /// the node itself.
    #[inline]
    pub(super) fn end(&self, node: u32) -> u32 {
        self.ends[node as usize]
    }

    /// Returns the child of `parent` that collapsed before `child`.
    #[inline]
    pub(super) fn child_before(&self, parent: u32, child: u32) -> OptionalId {
        let next = self.end(child);
        if next < self.end(parent) { OptionalId::some(next) } else { OptionalId::NONE }
    }

    /// Returns the child of a node that collapses last.
    #[inline]
    pub(super) fn last_child(&self, node: u32) -> OptionalId {
        if node + 1 < self.end(node) { OptionalId::some(node + 1) } else { OptionalId::NONE }
    }

    /// Returns the number of ancestor pointers of a node, which lead 1, 2, 4 … steps up.
    #[inline]
    pub(super) fn pointer_count(&self, node: u32) -> u32 {
        let skips = self.ancestors.range(node..node + 1);
        u32::from(self.parent(node).is_some()) + skips.end - skips.start
    }

    /// Returns the ancestor 2^`pointer` steps up, if it exists.
    #[inline]
    pub(super) fn ancestor(&self, node: u32, pointer: u32) -> Option<u32> {
        let Some(skip) = pointer.checked_sub(1) else { return self.parent(node) };
        let range = self.ancestors.range(node..node + 1);
        (skip < range.end - range.start).then(|| self.ancestors.item(range.start + skip))
    }

    /// Returns the id of the collapse that removes a node.
    #[inline]
    pub(super) fn collapse_id(&self, node: u32) -> u32 {
        if !self.is_grouped(node) {
            return node;
        }
        let found = self.followers.binary_search_by_key(&node, |&(follower, _)| follower);
        found.map_or(node, |i| self.followers[i].1)
    }

    /// Returns the nodes of a collapse other than its id.
    #[inline]
    pub(super) fn others(&self, collapse_id: u32) -> &[u32] {
        if !self.is_grouped(collapse_id) {
            return &[];
        }
        let found = self.groups.binary_search_by_key(&collapse_id, |(collapse_id, _)| *collapse_id);
        found.map_or(&[], |i| &self.groups[i].1[..])
    }

    /// Iterates over the nodes of a collapse, starting with its id.
    #[inline]
    pub(super) fn members(&self, collapse_id: u32) -> impl Iterator<Item = u32> {
        std::iter::once(collapse_id).chain(self.others(collapse_id).iter().copied())
    }

    /// Returns the memory of the tree in bytes.
    pub(super) fn memory(&self) -> usize {
        let groups: usize = self.groups.iter().map(|(_, others)| size_of_val(&others[..])).sum();
        size_of_val(&self.vertices[..])
            + size_of_val(&self.parents[..])
            + size_of_val(&self.ends[..])
            + self.ancestors.memory()
            + size_of_val(&self.groups[..])
            + groups
            + size_of_val(&self.followers[..])
            + size_of_val(&self.is_grouped[..])
    }
}

/// Returns the ancestors of each node 2, 4, 8 … steps up, and the maximum depth.
fn ancestors(parents: &[OptionalId]) -> (PackedRows, u32) {
    let mut depths: Vec<u32> = Vec::with_capacity(parents.len());
    let (mut count, mut deepest) = (0, 0);
    for parent in parents {
        let depth = parent.get().map_or(0, |parent| depths[parent as usize] + 1);
        count += depth.checked_ilog2().unwrap_or(0) as usize;
        deepest = deepest.max(depth);
        depths.push(depth);
    }
    let mut rows = PackedRows::of_items(count, parents.len() as u32);
    // The path from the root to the current node.
    let mut path: Vec<u32> = Vec::new();
    for (node, &depth) in (0..).zip(&depths) {
        path.truncate(depth as usize);
        for power in 1..=depth.checked_ilog2().unwrap_or(0) {
            rows.push(path[path.len() - (1 << power)]);
        }
        rows.end_row();
        path.push(node);
    }
    (rows, deepest)
}
