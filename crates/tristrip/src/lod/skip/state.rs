//! The state of a view: which vertices have collapsed.
//!
//! A collapse sets the flag of the node's parent pointer and makes the node the active child of its
//! parent. A split clears the flag, and the child that collapsed before becomes the active one.
//! Nodes are numbered depth-first, so an active child is stored as a node id.

use super::dependencies::Dependencies;
use super::vertex_tree::VertexTree;
use crate::ids::OptionalId;

/// The flags and pointers of a view, indexed by node.
#[derive(Debug, Clone)]
pub(super) struct ViewState {
    /// Whether a node has collapsed to its parent.
    done: Vec<bool>,
    /// The child of each node that collapsed last.
    active_child: Vec<OptionalId>,
    /// The pointer used last to go from each node toward its first active ancestor.
    active_pointer: Vec<u8>,
}

impl ViewState {
    /// Creates the state of the full mesh.
    pub(super) fn full(tree: &VertexTree) -> Self {
        let count = tree.len();
        Self {
            done: vec![false; count],
            active_child: vec![OptionalId::NONE; count],
            active_pointer: vec![0; count],
        }
    }

    /// Creates the state of the base mesh.
    pub(super) fn base(tree: &VertexTree) -> Self {
        let nodes = || 0..tree.len() as u32;
        Self {
            done: nodes().map(|node| tree.parent(node).is_some()).collect(),
            active_child: nodes().map(|node| tree.last_child(node)).collect(),
            active_pointer: vec![0; tree.len()],
        }
    }

    /// Checks whether a node has collapsed.
    #[inline]
    pub(super) fn is_collapsed(&self, node: u32) -> bool {
        self.done[node as usize]
    }

    /// Returns for each node whether it has collapsed.
    pub(super) fn done(&self) -> &[bool] {
        &self.done
    }

    /// Returns the child of a node that collapsed last.
    #[inline]
    pub(super) fn active_child(&self, node: u32) -> Option<u32> {
        self.active_child[node as usize].get()
    }

    /// Checks whether a collapse can be applied.
    #[inline]
    pub(super) fn can_collapse(&self, collapse_id: u32, dependencies: &Dependencies) -> bool {
        !self.is_collapsed(collapse_id)
            && dependencies.needed(collapse_id).all(|needed| self.is_collapsed(needed))
    }

    /// Checks whether a collapse is the last one into an active node. Only such a collapse can be
    /// chosen for a split.
    #[inline]
    pub(super) fn is_last(&self, collapse_id: u32, tree: &VertexTree) -> bool {
        self.is_collapsed(collapse_id)
            && tree.members(collapse_id).any(|node| {
                tree.parent(node).is_some_and(|p| !self.is_collapsed(p) && self.active_child(p) == Some(node))
            })
    }

    /// Applies a collapse whose dependencies are applied.
    #[inline]
    pub(super) fn collapse(&mut self, collapse_id: u32, tree: &VertexTree) {
        for node in tree.members(collapse_id) {
            if let Some(parent) = tree.parent(node) {
                self.done[node as usize] = true;
                self.active_child[parent as usize] = OptionalId::some(node);
            }
        }
    }

    /// Undoes a collapse that no applied collapse depends on.
    #[inline]
    pub(super) fn split(&mut self, collapse_id: u32, tree: &VertexTree) {
        for node in tree.members(collapse_id) {
            if let Some(parent) = tree.parent(node) {
                self.done[node as usize] = false;
                self.active_child[parent as usize] = tree.child_before(parent, node);
            }
        }
    }

    /// Undoes a collapse after those that depend on it, and appends them to `split` in this order.
    pub(super) fn force_split(
        &mut self,
        collapse_id: u32,
        (tree, dependencies): (&VertexTree, &Dependencies),
        split: &mut Vec<u32>,
    ) {
        if self.is_collapsed(collapse_id)
            && dependencies.dependents(collapse_id).all(|dependent| !self.is_collapsed(dependent))
        {
            self.split(collapse_id, tree);
            split.push(collapse_id);
            return;
        }
        // The collapses to split, each with the positions of its remaining dependents.
        let mut stack = vec![(collapse_id, dependencies.dependents_range(collapse_id))];
        while let Some((collapse_id, range)) = stack.last_mut() {
            let collapse_id = *collapse_id;
            let next = range.map(|position| dependencies.dependent(position)).find(|&d| self.is_collapsed(d));
            if let Some(dependent) = next {
                stack.push((dependent, dependencies.dependents_range(dependent)));
                continue;
            }
            if self.is_collapsed(collapse_id) {
                self.split(collapse_id, tree);
                split.push(collapse_id);
            }
            stack.pop();
        }
    }

    /// Applies a collapse after its dependencies, and appends them to `collapsed` in this order.
    pub(super) fn force_collapse(
        &mut self,
        collapse_id: u32,
        (tree, dependencies): (&VertexTree, &Dependencies),
        collapsed: &mut Vec<u32>,
    ) {
        if self.can_collapse(collapse_id, dependencies) {
            self.collapse(collapse_id, tree);
            collapsed.push(collapse_id);
            return;
        }
        // The collapses to apply, each with the positions of its remaining dependencies.
        let mut stack = vec![(collapse_id, dependencies.needed_range(collapse_id))];
        while let Some((collapse_id, range)) = stack.last_mut() {
            let collapse_id = *collapse_id;
            let next =
                range.map(|position| dependencies.needed_at(position)).find(|&d| !self.is_collapsed(d));
            if let Some(needed) = next {
                stack.push((needed, dependencies.needed_range(needed)));
                continue;
            }
            if !self.is_collapsed(collapse_id) {
                self.collapse(collapse_id, tree);
                collapsed.push(collapse_id);
            }
            stack.pop();
        }
    }

    /// Returns the first active node among a node and its ancestors. Follows the skip pointers,
    /// starting with the one used last.
    #[inline]
    pub(super) fn representative(&mut self, node: u32, tree: &VertexTree) -> u32 {
        if !self.is_collapsed(node) {
            return node;
        }
        match tree.parent(node) {
            Some(parent) if self.is_collapsed(parent) => self.skip_from(node, tree),
            Some(parent) => parent,
            None => node,
        }
    }

    fn skip_from(&mut self, node: u32, tree: &VertexTree) -> u32 {
        let mut at = node;
        while self.is_collapsed(at) {
            let pointer = self.pointer_from(at, u32::from(self.active_pointer[at as usize]), tree);
            self.active_pointer[at as usize] = pointer as u8;
            match tree.ancestor(at, pointer) {
                Some(ancestor) => at = ancestor,
                None => break,
            }
        }
        at
    }

    /// Returns the highest pointer of a collapsed node to an ancestor that has collapsed too, or
    /// pointer 0. The search starts at `known`.
    #[inline]
    fn pointer_from(&self, node: u32, known: u32, tree: &VertexTree) -> u32 {
        let is_below = |pointer: u32| tree.ancestor(node, pointer).is_some_and(|a| self.is_collapsed(a));
        let mut pointer = known;
        if pointer > 0 && !is_below(pointer) {
            while pointer > 0 && !is_below(pointer) {
                pointer -= 1;
            }
        } else {
            while is_below(pointer + 1) {
                pointer += 1;
            }
        }
        pointer
    }

    /// Counts the pointers followed from a node to its first active ancestor, for three methods:
    /// parent pointers only, skip pointers starting with the highest, and skip pointers starting
    /// with the one used last.
    pub(super) fn hops(&mut self, node: u32, tree: &VertexTree) -> [u32; 3] {
        let mut hops = [0; 3];
        let mut at = node;
        while let Some(parent) = tree.parent(at).filter(|_| self.is_collapsed(at)) {
            hops[0] += 1;
            at = parent;
        }
        at = node;
        while self.is_collapsed(at) {
            let pointer = self.pointer_from(at, tree.pointer_count(at) - 1, tree);
            hops[1] += 1;
            at = tree.ancestor(at, pointer).unwrap_or(at);
        }
        at = node;
        while self.is_collapsed(at) {
            let pointer = self.pointer_from(at, u32::from(self.active_pointer[at as usize]), tree);
            hops[2] += 1;
            self.active_pointer[at as usize] = pointer as u8;
            at = tree.ancestor(at, pointer).unwrap_or(at);
        }
        hops
    }

    pub(super) fn memory(&self) -> usize {
        size_of_val(&self.done[..])
            + size_of_val(&self.active_child[..])
            + size_of_val(&self.active_pointer[..])
    }
}
