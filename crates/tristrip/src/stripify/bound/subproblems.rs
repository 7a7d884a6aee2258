//! Improves the bound on a block by subproblems that are solved exactly.
//!
//! # Algorithm
//! A small block is solved as a whole. In a large one disjoint subproblems are solved, and the path
//! ends that they need are added up: paths may leave a subproblem over any edge, so that no end is
//! counted twice. Among triangles of three neighbours paths find their way; ends are forced where a
//! matching failed, and perhaps along the boundary. So:
//! 1. The triangles that the failed searches reached, and those around them, make subproblems: as
//!    far around as can be solved. Where none can, it is known that they contain an end for each
//!    triangle left unmatched, together with their neighbours: the searches' even nodes make
//!    components of odd size, more of them by that number than there are odd nodes to match them
//!    with.
//! 2. So do the triangles of two neighbours, with those around them that are not in a subproblem
//!    yet. One that is too wide to be solved is halved, and its halves again.
//!
//! # Complexity
//! Limited by a number of states for the whole graph; 5 bytes per triangle.

use super::blocks::BlockTree;
use super::frontier::{FrontierNode, least_ends};
use super::matching::Matching;
use super::neighbours::Neighbours;
use crate::ids::OptionalId;

/// Most triangles from a seed to the rim of a subproblem: for the dragon's boundaries, 3 and 4 give
/// the same result.
const RADIUS: u8 = 3;
/// Subproblems of more triangles are not tried.
const LARGEST: usize = 2048;
/// Halves of fewer triangles are not made.
const SMALL: usize = 16;

/// In the distances: not in reach of any seed.
const FAR: u8 = u8::MAX;
/// In the distances: in a subproblem.
const DONE: u8 = u8::MAX - 1;

/// Solves subproblems of the blocks of a graph.
#[derive(Debug)]
pub(super) struct SubproblemSolver {
    /// The number of each node in the current subproblem.
    number: Vec<OptionalId>,
    /// The distance of each node from the nearest seed.
    distance: Vec<u8>,
    states_at_once: usize,
    states_left: u64,
}

impl SubproblemSolver {
    /// Creates a solver for a graph, with limits of the states at once and in all.
    pub(super) fn new(node_count: usize, states_at_once: usize, states: u64) -> Self {
        Self {
            number: vec![OptionalId::NONE; node_count],
            distance: vec![FAR; node_count],
            states_at_once,
            states_left: states,
        }
    }

    /// Returns the least number of path ends of a whole block, if it can be solved; `is_taken`
    /// returns whether a bridge is used at a node.
    pub(super) fn solve_block(
        &mut self,
        blocks: &BlockTree,
        members: &[u32],
        is_taken: impl Fn(u32) -> bool,
    ) -> Option<usize> {
        self.solve(blocks, members, &is_taken)
    }

    /// Adds up the least ends of subproblems of a block around the nodes that a matching left over,
    /// and then along the boundary.
    pub(super) fn least_ends_in_parts(
        &mut self,
        blocks: &BlockTree,
        members: &[u32],
        matching: &Matching,
        is_taken: impl Fn(u32) -> bool,
    ) -> usize {
        let failed = members.iter().copied().filter(|&node| matching.has_failed(node)).collect();
        // Nodes without a neighbour that the searches reached are outside such a subproblem.
        let around_failed = self.around_seeds(blocks, failed, &is_taken, |_, nodes| {
            nodes.iter().filter(|&&node| matching.has_failed(node) && matching.is_free(node)).count()
        });
        let boundary = members.iter().copied().filter(|&node| blocks.inside(node).count() == 2).collect();
        let along_boundary = self.around_seeds(blocks, boundary, &is_taken, |solver, nodes| {
            solver.solve_halves(blocks, nodes, &is_taken)
        });
        around_failed + along_boundary
    }

    /// Adds up the least ends of subproblems around seeds; `known` bounds those that cannot be
    /// solved.
    fn around_seeds(
        &mut self,
        blocks: &BlockTree,
        seeds: Vec<u32>,
        is_taken: &impl Fn(u32) -> bool,
        known: impl Fn(&mut Self, &[u32]) -> usize,
    ) -> usize {
        let mut ends = 0;
        let mut open = vec![(seeds, RADIUS)];
        while let Some((seeds, radius)) = open.pop() {
            for node in self.reach(blocks, &seeds, radius) {
                if self.distance[node as usize] > RADIUS {
                    continue;
                }
                let (nodes, seeds) = self.collect_connected(blocks, node);
                if let Some(found) = self.solve(blocks, &nodes, is_taken) {
                    ends += found;
                } else if radius > 1 {
                    nodes.iter().for_each(|&node| self.distance[node as usize] = FAR);
                    open.push((seeds, radius - 1));
                } else {
                    ends += known(self, &nodes);
                }
            }
        }
        ends
    }

    /// Lists the nodes that are at most `radius` from the seeds and in no subproblem yet.
    fn reach(&mut self, blocks: &BlockTree, seeds: &[u32], radius: u8) -> Vec<u32> {
        let mut reached: Vec<u32> =
            seeds.iter().copied().filter(|&seed| self.distance[seed as usize] == FAR).collect();
        reached.iter().for_each(|&seed| self.distance[seed as usize] = 0);
        let mut head = 0;
        while let Some(&node) = reached.get(head) {
            head += 1;
            let next = self.distance[node as usize] + 1;
            for other in blocks.inside(node).filter(|_| next <= radius) {
                if self.distance[other as usize] == FAR {
                    self.distance[other as usize] = next;
                    reached.push(other);
                }
            }
        }
        reached
    }

    /// Collects the nodes in reach that are connected with this one, and the seeds among them.
    fn collect_connected(&mut self, blocks: &BlockTree, node: u32) -> (Vec<u32>, Vec<u32>) {
        let mut nodes = vec![node];
        let mut seeds: Vec<u32> = nodes.iter().copied().filter(|&n| self.distance[n as usize] == 0).collect();
        self.distance[node as usize] = DONE;
        let mut head = 0;
        while let Some(&node) = nodes.get(head) {
            head += 1;
            for other in blocks.inside(node) {
                let distance = &mut self.distance[other as usize];
                if *distance <= RADIUS {
                    if *distance == 0 {
                        seeds.push(other);
                    }
                    *distance = DONE;
                    nodes.push(other);
                }
            }
        }
        (nodes, seeds)
    }

    /// Halves a subproblem repeatedly until its parts can be solved, and adds up their least ends.
    fn solve_halves(&mut self, blocks: &BlockTree, nodes: &[u32], is_taken: &impl Fn(u32) -> bool) -> usize {
        if nodes.len() < 2 * SMALL || nodes.len() > LARGEST {
            return 0;
        }
        let (near, far) = nodes.split_at(nodes.len() / 2);
        let halves = [near, far].map(|half| match self.solve(blocks, half, is_taken) {
            Some(ends) => ends,
            None => self.solve_halves(blocks, half, is_taken),
        });
        halves.iter().sum()
    }

    fn solve(&mut self, blocks: &BlockTree, nodes: &[u32], is_taken: &impl Fn(u32) -> bool) -> Option<usize> {
        if nodes.len() > LARGEST {
            return None;
        }
        nodes.iter().zip(0..).for_each(|(&node, n)| self.number[node as usize] = OptionalId::some(n));
        let frontier_nodes: Vec<FrontierNode> = nodes
            .iter()
            .map(|&node| {
                let mut neighbours = Neighbours::default();
                let mut outward = 0;
                for other in blocks.inside(node) {
                    match self.number[other as usize].get() {
                        None => outward += 1,
                        Some(number) => neighbours.insert(number),
                    }
                }
                FrontierNode { neighbours, outward, is_taken: is_taken(node) }
            })
            .collect();
        nodes.iter().for_each(|&node| self.number[node as usize] = OptionalId::NONE);
        least_ends(&frontier_nodes, self.states_at_once, &mut self.states_left)
    }
}
