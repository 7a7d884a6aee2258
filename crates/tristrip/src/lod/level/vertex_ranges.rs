//! The subtree of each vertex in the collapse tree, as a range of vertex numbers.
//!
//! # Complexity
//! O(n) time, 8 bytes per vertex.

use crate::collapse::CollapseSequence;
use crate::ids::OptionalId;

/// A depth-first numbering of the vertices: the subtree of a vertex in the collapse tree is a
/// contiguous range.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct VertexRanges {
    numbers: Vec<u32>,
    /// The end of the subtree range of each vertex, indexed by number.
    ends: Vec<u32>,
}

impl VertexRanges {
    /// Numbers the vertices of a sequence.
    pub(crate) fn new(sequence: &CollapseSequence) -> Self {
        let mut links = CollapseTree::new(sequence.vertex_count());
        for rename in sequence.iter().flat_map(|collapse| collapse.renames) {
            links.add(rename.removed, rename.kept);
        }
        let order = links.depth_first();
        let mut numbers = vec![0; order.len()];
        (0..).zip(&order).for_each(|(number, &v)| numbers[v as usize] = number);
        let parent = |&v: &u32| links.parent(v).map(|p| numbers[p as usize]).into();
        let parents: Vec<OptionalId> = order.iter().map(parent).collect();
        Self { ends: ends(&parents), numbers }
    }

    /// Checks whether `other` is `vertex` or below it in the collapse tree.
    #[inline]
    pub(crate) fn contains(&self, vertex: u32, other: u32) -> bool {
        let [first, number] = [vertex, other].map(|v| self.numbers[v as usize]);
        (first..self.ends[first as usize]).contains(&number)
    }

    pub(crate) fn memory(&self) -> usize {
        size_of_val(&self.numbers[..]) + size_of_val(&self.ends[..])
    }
}

/// The collapse tree, with the children of each vertex as linked lists, last child first.
pub(crate) struct CollapseTree {
    parent: Vec<OptionalId>,
    first_child: Vec<OptionalId>,
    next: Vec<OptionalId>,
}

impl CollapseTree {
    /// Creates a tree of `count` vertices without collapses.
    pub(crate) fn new(count: usize) -> Self {
        let none = || vec![OptionalId::NONE; count];
        Self { parent: none(), first_child: none(), next: none() }
    }

    /// Adds a child and returns `true`. Returns `false` if the two are equal, out of range, or one
    /// of them was removed before.
    pub(crate) fn add(&mut self, removed: u32, kept: u32) -> bool {
        let is_there = |v: u32| self.parent.get(v as usize).is_some_and(|parent| parent.is_none());
        if !is_there(removed) || !is_there(kept) || removed == kept {
            return false;
        }
        self.parent[removed as usize] = OptionalId::some(kept);
        self.next[removed as usize] =
            std::mem::replace(&mut self.first_child[kept as usize], OptionalId::some(removed));
        true
    }

    /// Returns the vertex that a vertex collapses to.
    pub(crate) fn parent(&self, v: u32) -> Option<u32> {
        self.parent[v as usize].get()
    }

    /// Returns all vertices in depth-first order, parents before children.
    pub(crate) fn depth_first(&self) -> Vec<u32> {
        let mut order = Vec::with_capacity(self.parent.len());
        let mut stack = Vec::new();
        for root in (0..self.parent.len() as u32).filter(|&v| self.parent[v as usize].is_none()) {
            stack.push(root);
            while let Some(v) = stack.pop() {
                order.push(v);
                let from = stack.len();
                let children = std::iter::successors(self.first_child[v as usize].get(), |&child| {
                    self.next[child as usize].get()
                });
                stack.extend(children);
                stack[from..].reverse();
            }
        }
        order
    }
}

/// Returns the end of the subtree of each node, given the parents of nodes in depth-first order.
pub(crate) fn ends(parents: &[OptionalId]) -> Vec<u32> {
    let mut ends: Vec<u32> = (1..=parents.len() as u32).collect();
    for node in (0..parents.len()).rev() {
        if let Some(parent) = parents[node].get() {
            ends[parent as usize] = ends[parent as usize].max(ends[node]);
        }
    }
    ends
}
