//! Computes the bound on strips block by block, from the leaves of the bridge tree to its root.
//!
//! # Algorithm
//! When all blocks behind a block are done, some of its triangles already have a link over a used
//! bridge. Using a bridge saves a strip. It costs each of the two blocks at most one strip, because
//! one path end of the block is linked over the bridge. Therefore a bridge is used exactly if the
//! block behind the bridge then needs no more strips than before. This is the best choice
//! regardless of the rest of the tree.
//!
//! A block of n triangles and E edges needs at least n − E + r strips. Here r is the minimum number
//! of edges to remove so that each triangle keeps at most two edges, or at most one edge at a used
//! bridge. r is the number of triangles with an extra edge minus the size of a maximum matching
//! among them. A cover may need closed paths to reach that number. The bound is therefore at least
//! one, and exactly solved subproblems of the block may raise it.

use super::blocks::BlockTree;
use super::matching::Matching;
use super::method::BoundMethod;
use super::subproblems::SubproblemSolver;
use crate::dual::DualGraph;

/// Work limits of a bound.
#[derive(Debug, Clone, Copy)]
pub(super) struct BoundLimits {
    /// Maximum steps of the matching's searches.
    pub(super) steps: u64,
    /// Maximum triangles of a block that is solved as a whole.
    pub(super) whole: usize,
    /// Maximum states of a subproblem at once.
    pub(super) states_at_once: usize,
    /// Maximum states in total.
    pub(super) states: u64,
}

impl BoundLimits {
    /// Returns the limits for a graph. 200 steps per triangle, where scans and machine parts need
    /// two. 8 states per triangle, which take a second per million triangles. Small graphs get at
    /// least a tenth of a second.
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

/// The bound of a component.
#[derive(Debug, Clone, Copy)]
pub(super) struct ComponentStrips {
    pub(super) triangles: usize,
    pub(super) strips: usize,
    pub(super) method: BoundMethod,
}

/// Computes the bound on the strips of each component, in order of their lowest triangles.
pub(super) fn bound(graph: &DualGraph) -> Vec<ComponentStrips> {
    bound_within(graph, BoundLimits::of(graph.face_count()))
}

/// Computes the bound on the strips of each component within limits.
pub(super) fn bound_within(graph: &DualGraph, limits: BoundLimits) -> Vec<ComponentStrips> {
    let blocks = BlockTree::new(graph);
    let mut solver = BlockSolver::new(&blocks, limits);
    let none = ComponentStrips { triangles: 0, strips: 0, method: BoundMethod::Exact };
    let mut components = Vec::new();
    // The strips of the component's blocks so far, minus the bridges used.
    let mut so_far = none;
    for root in (0..blocks.len() as u32).rev().filter(|&node| blocks.root(node) == node) {
        let block = solver.bound(root);
        so_far.triangles += block.triangles;
        so_far.strips += block.strips;
        so_far.method = so_far.method.min(block.method);
        match blocks.above(root) {
            None => components.push(std::mem::replace(&mut so_far, none)),
            Some(above) if block.allows_bridge => {
                solver.bridges_used[above as usize] += 1;
                so_far.strips -= 1;
            }
            Some(_) => (),
        }
    }
    components.reverse();
    components
}

/// Computes the bounds of blocks. The blocks behind a block are processed before it.
struct BlockSolver<'a> {
    blocks: &'a BlockTree,
    matching: Matching,
    subproblems: SubproblemSolver,
    /// The number of used bridges at each node that lead away from the root.
    bridges_used: Vec<u8>,
    /// Maximum triangles of a block that is solved as a whole.
    whole: usize,
}

/// The bound of a block.
struct BlockBound {
    triangles: usize,
    strips: usize,
    /// Whether the bound stays the same if the bridge toward the root is used.
    allows_bridge: bool,
    method: BoundMethod,
}

impl<'a> BlockSolver<'a> {
    fn new(blocks: &'a BlockTree, limits: BoundLimits) -> Self {
        let n = blocks.len();
        Self {
            matching: Matching::new(n, limits.steps),
            subproblems: SubproblemSolver::new(n, limits.states_at_once, limits.states),
            bridges_used: vec![0; n],
            blocks,
            whole: limits.whole,
        }
    }

    /// Computes the bound of the block with this lowest node.
    fn bound(&mut self, root: u32) -> BlockBound {
        if self.blocks.is_single(root) {
            // Two bridges belong to one strip. A third one ends there, which is as good as not
            // using it.
            let used = self.bridges_used[root as usize];
            let strips = if used == 3 { 2 } else { 1 };
            return BlockBound { triangles: 1, strips, allows_bridge: used < 2, method: BoundMethod::Exact };
        }
        let members: Vec<u32> = self.blocks.members(root).collect();
        self.solve_whole(root, &members).unwrap_or_else(|| self.bound_in_parts(root, &members))
    }

    /// Solves a small block exactly. If every triangle has three neighbours, the result is hardly
    /// ever better than the matching.
    fn solve_whole(&mut self, root: u32, members: &[u32]) -> Option<BlockBound> {
        let has_boundary = members.iter().any(|&node| self.blocks.inside(node).count() == 2);
        if members.len() > self.whole || !has_boundary {
            return None;
        }
        let used = &self.bridges_used;
        let taken: usize = members.iter().map(|&node| usize::from(used[node as usize])).sum();
        let is_taken = |node: u32| used[node as usize] > 0;
        let without_bridge = self.subproblems.solve_block(self.blocks, members, is_taken)?;
        let with_bridge =
            self.subproblems.solve_block(self.blocks, members, |node| node == root || is_taken(node))?;
        // Every strip has two ends.
        let strips = usize::midpoint(taken, without_bridge);
        let allows_bridge = usize::midpoint(taken + 1, with_bridge) == strips;
        Some(BlockBound { triangles: members.len(), strips, allows_bridge, method: BoundMethod::Exact })
    }

    /// Computes the bound of a block from its matching and its subproblems.
    fn bound_in_parts(&mut self, root: u32, members: &[u32]) -> BlockBound {
        let (mut degrees, mut demand, mut taken) = (0, 0, 0);
        for &node in members {
            let degree = self.blocks.inside(node).count();
            let used = usize::from(self.bridges_used[node as usize]);
            degrees += degree;
            taken += used;
            if degree + used > 2 {
                self.matching.admit(node);
                demand += 1;
            }
        }
        let pairs = self.matching.match_block(self.blocks, root);
        let by_matching = members.len() + demand - pairs.at_most - degrees / 2;
        let rises = pairs.is_exact && !self.matching.would_match(self.blocks, root);
        let used = &self.bridges_used;
        let is_taken = |node: u32| used[node as usize] > 0;
        let ends = self.subproblems.least_ends_in_parts(self.blocks, members, &self.matching, is_taken);
        let strips = by_matching.max((taken + ends).div_ceil(2)).max(1);
        let method = if strips > by_matching { BoundMethod::Subproblems } else { BoundMethod::Matching };
        let allows_bridge = by_matching + usize::from(rises) <= strips;
        BlockBound { triangles: members.len(), strips, allows_bridge, method }
    }
}
