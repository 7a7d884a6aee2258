//! The blocks of a dual graph: what is left of its components when the bridges are taken out, and the tree that bridges make of them.
//!
//! ```text
//!   ●─●        ○ ── ○ ── ● ─ ●      Two blocks of several triangles (●), two of one (○), three bridges. A triangle has
//!   │ │ ────── ╱          ╲ ╱       three edges at most, so that within a block no triangle cuts it apart, and a triangle
//!   ●─●                    ●        with a bridge has at most two edges within its block.
//! ```
//! Triangles are numbered anew, in the order of a depth-first search: every block is then named by its lowest triangle, through
//! which the bridge toward the root leads, and the blocks behind a block have higher names. Two triangles that share two or
//! three edges are joined once, since a path takes only one of them.
//!
//! # References
//! Tarjan: *A note on finding the bridges of a graph*, 1974.
//!
//! # Complexity
//! O(n) time; 28 bytes a triangle.

use super::NONE;
use crate::dual::DualGraph;

/// A dual graph in the order of a depth-first search, with its blocks.
#[derive(Debug)]
pub(super) struct Blocks {
    /// The neighbours of each node, each once, `NONE` behind the last.
    pub(super) neighbours: Vec<[u32; 3]>,
    /// The node from which the search came; `NONE` for the first of a component.
    pub(super) parent: Vec<u32>,
    /// The lowest node of the block that a node is in.
    pub(super) root: Vec<u32>,
    /// The next higher node of the same block, or `NONE`.
    pub(super) next: Vec<u32>,
}

impl Blocks {
    /// Searches the graph of triangles.
    pub(super) fn new(graph: &DualGraph) -> Self {
        let twins = graph.twins();
        let n = twins.len() / 3;
        let mut number = vec![NONE; n];
        let mut faces: Vec<u32> = Vec::with_capacity(n);
        let mut parent: Vec<u32> = Vec::with_capacity(n);
        for first in 0..n {
            if number[first] != NONE {
                continue;
            }
            let mut here = NONE;
            let mut next = Some(first as u32);
            loop {
                if let Some(face) = next {
                    number[face as usize] = faces.len() as u32;
                    parent.push(here);
                    here = faces.len() as u32;
                    faces.push(face);
                } else {
                    here = parent[here as usize];
                    if here == NONE {
                        break;
                    }
                }
                let around = &twins[3 * faces[here as usize] as usize..][..3];
                next = around.iter().find(|&&h| h != NONE && number[h as usize / 3] == NONE).map(|&h| h / 3);
            }
        }
        let neighbours: Vec<[u32; 3]> = faces
            .iter()
            .enumerate()
            .map(|(node, &face)| {
                let mut around = [NONE; 3];
                let mut count = 0;
                for &twin in twins[3 * face as usize..][..3].iter().filter(|&&twin| twin != NONE) {
                    let other = number[twin as usize / 3];
                    if other != node as u32 && !around.contains(&other) {
                        around[count] = other;
                        count += 1;
                    }
                }
                around
            })
            .collect();
        let root = block_roots(&neighbours, &parent);
        let mut next = vec![NONE; n];
        let mut lowest = number;
        lowest.fill(NONE);
        for node in (0..n).rev() {
            next[node] = std::mem::replace(&mut lowest[root[node] as usize], node as u32);
        }
        Self { neighbours, parent, root, next }
    }

    /// Counts the nodes.
    pub(super) fn len(&self) -> usize {
        self.root.len()
    }

    /// Walks over the neighbours of a node.
    pub(super) fn around(&self, node: u32) -> impl Iterator<Item = u32> + use<> {
        self.neighbours[node as usize].into_iter().take_while(|&other| other != NONE)
    }

    /// Walks over the neighbours of a node in its own block.
    pub(super) fn inside(&self, node: u32) -> impl Iterator<Item = u32> {
        self.around(node).filter(move |&other| self.root[other as usize] == self.root[node as usize])
    }

    /// Walks over the nodes of the block that begins with this node, in rising order.
    pub(super) fn members(&self, root: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(root), |&node| Some(self.next[node as usize]).filter(|&next| next != NONE))
    }
}

/// Finds the lowest node of each block: one behind which no edge but the search's own leads up again.
fn block_roots(neighbours: &[[u32; 3]], parent: &[u32]) -> Vec<u32> {
    let mut low: Vec<u32> = (0..neighbours.len() as u32).collect();
    for node in (0..neighbours.len()).rev() {
        for &other in neighbours[node].iter().filter(|&&other| other != NONE && other != parent[node]) {
            let reach = if parent[other as usize] == node as u32 { low[other as usize] } else { other };
            low[node] = low[node].min(reach);
        }
    }
    for node in 0..low.len() {
        if low[node] != node as u32 {
            low[node] = low[parent[node] as usize];
        }
    }
    low
}
