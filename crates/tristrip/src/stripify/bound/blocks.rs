//! The blocks of a dual graph are the parts into which its components fall when the bridges are
//! removed. Blocks and bridges form trees.
//!
//! ```text
//!   ●─●        ○ ── ○ ── ● ─ ●      Two blocks of several triangles (●), two of one (○), three
//!   │ │ ────── ╱          ╲ ╱       bridges. A triangle has at most three edges, so it cannot be
//!   ●─●                    ●        a cut vertex of its block, and a triangle with a bridge has
//!                                   at most two edges within its block.
//! ```
//! Triangles are renumbered in depth-first order. Every block is then identified by its lowest
//! triangle, where the bridge toward the root starts, and the blocks behind a block (farther from
//! the root) have higher numbers. Two triangles that share two or three edges count as neighbours
//! only once, because a path uses only one of the edges.
//!
//! # References
//! Tarjan: *A note on finding the bridges of a graph*, 1974.
//!
//! # Complexity
//! O(n) time and 28 bytes per triangle.

use super::neighbours::Neighbours;
use crate::dual::DualGraph;
use crate::ids::OptionalId;

/// A dual graph in depth-first order, with its blocks.
#[derive(Debug)]
pub(super) struct BlockTree {
    neighbours: Vec<Neighbours>,
    /// The node from which the search reached a node; none for the first node of a component.
    parent: Vec<OptionalId>,
    /// The lowest node of each node's block.
    root: Vec<u32>,
    /// The next higher node of the same block, if any.
    next: Vec<OptionalId>,
}

impl BlockTree {
    /// Builds the block tree of a graph of triangles.
    pub(super) fn new(graph: &DualGraph) -> Self {
        let (faces, parent, number) = depth_first_order(graph);
        let neighbours: Vec<Neighbours> = faces
            .iter()
            .enumerate()
            .map(|(node, &face)| {
                let mut neighbours = Neighbours::default();
                for twin in (3 * face..3 * face + 3).filter_map(|h| graph.twin_of(h)) {
                    // By now every face has a number.
                    if let Some(other) = number[twin as usize / 3].get().filter(|&other| other != node as u32)
                    {
                        neighbours.insert(other);
                    }
                }
                neighbours
            })
            .collect();
        let root = block_roots(&neighbours, &parent);
        let mut next = vec![OptionalId::NONE; faces.len()];
        let mut lowest = number;
        lowest.fill(OptionalId::NONE);
        for node in (0..faces.len()).rev() {
            let lowest = &mut lowest[root[node] as usize];
            next[node] = std::mem::replace(lowest, OptionalId::some(node as u32));
        }
        Self { neighbours, parent, root, next }
    }

    /// Counts the nodes.
    pub(super) fn len(&self) -> usize {
        self.root.len()
    }

    /// Returns the lowest node of a node's block.
    pub(super) fn root(&self, node: u32) -> u32 {
        self.root[node as usize]
    }

    /// Returns the node at the other end of the bridge from a block's lowest node, or `None` for
    /// the first block of a component.
    pub(super) fn above(&self, root: u32) -> Option<u32> {
        self.parent[root as usize].get()
    }

    /// Returns whether a block consists of a single node.
    pub(super) fn is_single(&self, root: u32) -> bool {
        self.next[root as usize].is_none()
    }

    /// Iterates over the neighbours of a node in its own block.
    pub(super) fn inside(&self, node: u32) -> impl Iterator<Item = u32> {
        let neighbours = self.neighbours[node as usize].iter();
        neighbours.filter(move |&other| self.root[other as usize] == self.root[node as usize])
    }

    /// Iterates over the nodes of the block with this lowest node, in ascending order.
    pub(super) fn members(&self, root: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(root), |&node| self.next[node as usize].get())
    }
}

/// Returns the faces in depth-first order, the parent of each as its number in that order, and the
/// number of each face.
fn depth_first_order(graph: &DualGraph) -> (Vec<u32>, Vec<OptionalId>, Vec<OptionalId>) {
    let n = graph.face_count();
    let mut number = vec![OptionalId::NONE; n];
    let mut faces: Vec<u32> = Vec::with_capacity(n);
    let mut parent = Vec::with_capacity(n);
    for first in 0..n as u32 {
        if !number[first as usize].is_none() {
            continue;
        }
        let mut here = OptionalId::NONE;
        let mut next = Some(first);
        loop {
            if let Some(face) = next {
                let node = OptionalId::some(faces.len() as u32);
                number[face as usize] = node;
                parent.push(here);
                here = node;
                faces.push(face);
            } else if let Some(node) = here.get() {
                here = parent[node as usize];
            }
            let Some(node) = here.get() else { break };
            let face = faces[node as usize];
            let neighbours = (3 * face..3 * face + 3).filter_map(|h| graph.twin_of(h)).map(|twin| twin / 3);
            next = neighbours.into_iter().find(|&other| number[other as usize].is_none());
        }
    }
    (faces, parent, number)
}

/// Returns the lowest node of each block: a node behind which no edge leads up except the tree
/// edge.
fn block_roots(neighbours: &[Neighbours], parent: &[OptionalId]) -> Vec<u32> {
    let mut low: Vec<u32> = (0..neighbours.len() as u32).collect();
    for node in (0..neighbours.len()).rev() {
        for other in neighbours[node].iter().filter(|&other| parent[node].get() != Some(other)) {
            let is_child = parent[other as usize].get() == Some(node as u32);
            let reach = if is_child { low[other as usize] } else { other };
            low[node] = low[node].min(reach);
        }
    }
    for (node, parent) in parent.iter().enumerate() {
        if let Some(parent) = parent.get()
            && low[node] != node as u32
        {
            low[node] = low[parent as usize];
        }
    }
    low
}
