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
//! a maximum matching among them. That number may be reached by closed paths only, so that one strip is still the least, and pieces
//! of the block that are solved exactly may show that it needs more.

use super::blocks::Blocks;
use super::matching::Matching;
use super::pieces::Pieces;
use super::{NONE, Proof};
use crate::dual::DualGraph;

/// How much work a bound may take.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Steps of the matching's searches.
    pub(super) steps: u64,
    /// Blocks of more triangles are not tried whole.
    pub(super) whole: usize,
    /// States of a piece at once.
    pub(super) states_at_once: usize,
    /// States in all.
    pub(super) states: u64,
}

impl Limits {
    /// Gives a graph 200 steps a triangle, of which scans and machine parts take two, and 8 states a triangle, that is a second for a
    /// million triangles; and a small graph a tenth of a second.
    fn of(triangle_count: usize) -> Self {
        let count = triangle_count as u64;
        Self {
            steps: (1 << 20) + 200 * count,
            whole: 2048,
            states_at_once: 20_000,
            states: (1 << 20) + 8 * count,
        }
    }
}

/// What was found for a component.
#[derive(Debug, Clone, Copy)]
pub(super) struct Component {
    pub(super) triangles: usize,
    pub(super) strips: usize,
    pub(super) proof: Proof,
}

/// Bounds the strips of each component, in order of their lowest triangles.
pub(super) fn bound(graph: &DualGraph) -> Vec<Component> {
    bound_within(graph, Limits::of(graph.face_count()))
}

/// The same with so much work.
pub(super) fn bound_within(graph: &DualGraph, limits: Limits) -> Vec<Component> {
    let blocks = Blocks::new(graph);
    settle(&mut Settled::new(&blocks, limits))
}

/// Settles all blocks.
fn settle(settled: &mut Settled<'_>) -> Vec<Component> {
    let blocks = settled.blocks;
    let none = Component { triangles: 0, strips: 0, proof: Proof::Exact };
    let mut components = Vec::new();
    // Strips less bridges used, of the blocks of a component so far.
    let mut so_far = none;
    for root in (0..blocks.len() as u32).rev().filter(|&node| blocks.root[node as usize] == node) {
        let block = settled.settle(root);
        so_far.triangles += block.triangles;
        so_far.strips += block.strips;
        so_far.proof = so_far.proof.min(block.proof);
        let above = blocks.parent[root as usize];
        if above == NONE {
            components.push(std::mem::replace(&mut so_far, none));
        } else if block.spares_one {
            settled.used[above as usize] += 1;
            settled.joined[root as usize] = true;
            so_far.strips -= 1;
        }
    }
    components.reverse();
    components
}

/// The blocks settled so far.
struct Settled<'a> {
    blocks: &'a Blocks,
    matching: Matching,
    pieces: Pieces,
    /// The bridges used at each node, of those that lead away from the root.
    used: Vec<u8>,
    /// Whether the bridge is used that leads from the lowest node of a block toward the root.
    joined: Vec<bool>,
    whole: usize,
}

/// What a block needs.
struct Block {
    triangles: usize,
    strips: usize,
    /// Whether it may need no more where the bridge toward the root is used.
    spares_one: bool,
    proof: Proof,
}

impl<'a> Settled<'a> {
    fn new(blocks: &'a Blocks, limits: Limits) -> Self {
        let n = blocks.len();
        Self {
            matching: Matching::new(n, limits.steps),
            pieces: Pieces::new(n, limits.states_at_once, limits.states),
            used: vec![0; n],
            joined: vec![false; n],
            blocks,
            whole: limits.whole,
        }
    }

    fn settle(&mut self, root: u32) -> Block {
        if self.blocks.next[root as usize] == NONE {
            // Two bridges pass through one strip; a third ends there, which is as good as not to use it.
            let used = self.used[root as usize];
            let strips = if used == 3 { 2 } else { 1 };
            return Block { triangles: 1, strips, spares_one: used < 2, proof: Proof::Exact };
        }
        let members: Vec<u32> = self.blocks.members(root).collect();
        self.settle_whole(root, &members).unwrap_or_else(|| self.settle_in_parts(root, &members))
    }

    /// Settles a small block exactly. Where every triangle has three neighbours, there is hardly ever more to know than the matching.
    fn settle_whole(&mut self, root: u32, members: &[u32]) -> Option<Block> {
        let has_boundary = members.iter().any(|&node| self.blocks.inside(node).count() == 2);
        if members.len() > self.whole || !has_boundary {
            return None;
        }
        let taken: usize = members.iter().map(|&node| usize::from(self.used[node as usize])).sum();
        let used = &self.used;
        let apart = self.pieces.whole(self.blocks, members, |node| used[node as usize] > 0)?;
        let joined =
            self.pieces.whole(self.blocks, members, |node| node == root || used[node as usize] > 0)?;
        // Every strip has two ends.
        let strips = usize::midpoint(taken, apart);
        let spares_one = usize::midpoint(taken + 1, joined) == strips;
        Some(Block { triangles: members.len(), strips, spares_one, proof: Proof::Exact })
    }

    /// Settles a block by its matching, and by pieces of it.
    fn settle_in_parts(&mut self, root: u32, members: &[u32]) -> Block {
        let (mut degrees, mut demand, mut taken) = (0, 0, 0);
        for &node in members {
            let degree = self.blocks.inside(node).count();
            let used = usize::from(self.used[node as usize]);
            degrees += degree;
            taken += used;
            if degree + used > 2 {
                self.matching.admit(node);
                demand += 1;
            }
        }
        let pairs = self.matching.match_block(self.blocks, root);
        let matched = members.len() + demand - pairs.at_most - degrees / 2;
        let rises = pairs.is_exact && !self.matching.would_match(self.blocks, root);
        let used = &self.used;
        let ends = self.pieces.around(self.blocks, members, &self.matching, |node| used[node as usize] > 0);
        let strips = matched.max((taken + ends).div_ceil(2)).max(1);
        let proof = if strips > matched { Proof::Pieces } else { Proof::Matching };
        Block { triangles: members.len(), strips, spares_one: matched + usize::from(rises) <= strips, proof }
    }
}
