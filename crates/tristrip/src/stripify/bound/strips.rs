//! The bound on strips: block by block, from the leaves of the bridge tree to its root.
//!
//! # Algorithm
//! What remains of a block when the blocks behind it are settled is a graph in which some triangles have an edge taken: the bridges
//! that are used. Taking a bridge spares a strip and costs the blocks at its two ends at most one each, by a place at an end
//! of a path there. So a bridge is used exactly if the block behind it does not need more strips for it; that is the best choice
//! whatever comes above it.
//!
//! A block of n triangles and E edges needs at least n − E + r strips, where r is the least number of edges to leave out so
//! that each triangle keeps two at most, or one where a bridge is used: the triangles with an edge too many, less
//! a maximum matching among them. That number may be reached by closed paths only, so that one strip is still the least.

use super::NONE;
use super::blocks::Blocks;
use super::matching::Matching;
use crate::dual::DualGraph;

/// Steps of the matching's searches for each triangle, and for a mesh: scans and machine parts take two a triangle.
const STEPS: u64 = 200;
const LEAST_STEPS: u64 = 1 << 20;

/// What was found for a component.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Component {
    pub(super) triangles: usize,
    pub(super) strips: usize,
}

/// Bounds the strips of each component, in order of their lowest triangles.
pub(super) fn bound(graph: &DualGraph) -> Vec<Component> {
    bound_in_steps(graph, LEAST_STEPS + STEPS * graph.face_count() as u64)
}

/// The same with so many steps for the matching.
pub(super) fn bound_in_steps(graph: &DualGraph, steps: u64) -> Vec<Component> {
    let blocks = Blocks::new(graph);
    let matching = Matching::new(blocks.len(), steps);
    let mut settled = Settled { matching, used: vec![0; blocks.len()], blocks: &blocks };
    let mut components = Vec::new();
    let mut triangles = 0;
    // Strips less bridges used, of the blocks of the component so far.
    let mut strips = 0;
    for root in (0..blocks.len() as u32).rev().filter(|&node| blocks.root[node as usize] == node) {
        let block = settled.settle(root);
        triangles += block.triangles;
        strips += block.strips;
        let above = blocks.parent[root as usize];
        if above == NONE {
            components.push(Component { triangles, strips });
            (triangles, strips) = (0, 0);
        } else if block.spares_one {
            settled.used[above as usize] += 1;
            strips -= 1;
        }
    }
    components.reverse();
    components
}

/// The blocks settled so far.
struct Settled<'a> {
    blocks: &'a Blocks,
    matching: Matching,
    /// The bridges used at each node, of those that lead away from the root.
    used: Vec<u8>,
}

/// What a block needs.
struct Block {
    triangles: usize,
    strips: usize,
    /// Whether it may need no more where the bridge toward the root is used.
    spares_one: bool,
}

impl Settled<'_> {
    fn settle(&mut self, root: u32) -> Block {
        if self.blocks.next[root as usize] == NONE {
            // Two bridges pass through one strip; a third ends there, which is as good as not to use it.
            let used = self.used[root as usize];
            return Block { triangles: 1, strips: if used == 3 { 2 } else { 1 }, spares_one: used < 2 };
        }
        let (mut triangles, mut ends, mut demand) = (0, 0, 0);
        for node in self.blocks.members(root) {
            let degree = self.blocks.inside(node).count();
            triangles += 1;
            ends += degree;
            if degree + usize::from(self.used[node as usize]) > 2 {
                self.matching.admit(node);
                demand += 1;
            }
        }
        let pairs = self.matching.match_block(self.blocks, root);
        let strips = triangles + demand - pairs.at_most - ends / 2;
        let spares_one = strips == 0 || !pairs.is_exact || self.matching.would_match(self.blocks, root);
        Block { triangles, strips: strips.max(1), spares_one }
    }
}
