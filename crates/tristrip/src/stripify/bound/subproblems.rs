//! Improves the bound of a block by solving subproblems exactly.
//!
//! # Algorithm
//! A small block is solved as a whole. In a large one, disjoint subproblems are solved and their
//! path ends are added up. No end is counted twice, because paths may leave a subproblem over any
//! edge. Triangles with three neighbours rarely force ends. Ends are forced where a matching
//! failed, and sometimes along the boundary:
//! 1. The triangles that the failed searches reached form subproblems together with their
//!    surroundings, with the largest radius that can be solved. If no subproblem can be solved,
//!    each unmatched triangle together with its neighbours still counts as one end. The even nodes
//!    of the searches form components of odd size. The number of unmatched triangles is the number
//!    of these components minus the number of odd nodes that could be matched with them.
//! 2. The triangles with two neighbours form subproblems together with the surrounding triangles
//!    that are not in a subproblem yet. A subproblem that is too wide is halved recursively.
//!
//! # Complexity
//! The number of states is limited for the whole graph. 5 bytes per triangle.

use super::blocks::BlockTree;
use super::frontier::{FrontierNode, least_ends};
use super::matching::Matching;
use super::neighbours::Neighbours;
use crate::ids::OptionalId;

/// Maximum distance from a seed to the rim of a subproblem, in triangles. On the dragon's
/// boundaries, 3 and 4 give the same result.
const RADIUS: u8 = 3;
/// Larger subproblems are not tried.
const LARGEST: usize = 2048;
/// Smaller halves are not made.
const SMALL: usize = 16;

/// A distance value: not within reach of any seed.
const FAR: u8 = u8::MAX;
/// A distance value: already in a subproblem.
const DONE: u8 = u8::MAX - 1;

/// Solves subproblems of the blocks of a graph.
#[derive(Debug)]
pub(super) struct SubproblemSolver {
    /// The index of each node in the current subproblem.
    number: Vec<OptionalId>,
    /// The distance of each node from the nearest seed.
    distance: Vec<u8>,
    states_at_once: usize,
    states_left: u64,
}

impl SubproblemSolver {
    /// Creates a solver for a graph, with limits for the states at once and in total.
    pub(super) fn new(node_count: usize, states_at_once: usize, states: u64) -> Self {
        Self {
            number: vec![OptionalId::NONE; node_count],
            distance: vec![FAR; node_count],
            states_at_once,
            states_left: states,
        }
    }

    /// Returns the minimum number of path ends of a whole block, or `None` if it cannot be solved.
    /// `is_taken` returns whether a bridge is used at a node.
    pub(super) fn solve_block(
        &mut self,
        blocks: &BlockTree,
        members: &[u32],
        is_taken: impl Fn(u32) -> bool,
    ) -> Option<usize> {
        self.solve(blocks, members, &is_taken)
    }

    /// Adds up the minimum ends of a block's subproblems, first around the nodes that the matching
    /// left free, then along the boundary.
    pub(super) fn least_ends_in_parts(
        &mut self,
        blocks: &BlockTree,
        members: &[u32],
        matching: &Matching,
        is_taken: impl Fn(u32) -> bool,
    ) -> usize {
        let failed = members.iter().copied().filter(|&node| matching.has_failed(node)).collect();
        // Nodes without a reached neighbour are outside such a subproblem.
        let around_failed = self.around_seeds(blocks, failed, &is_taken, |_, nodes| {
            nodes.iter().filter(|&&node| matching.has_failed(node) && matching.is_free(node)).count()
        });
        let boundary = members.iter().copied().filter(|&node| blocks.inside(node).count() == 2).collect();
        let along_boundary = self.around_seeds(blocks, boundary, &is_taken, |solver, nodes| {
            solver.solve_halves(blocks, nodes, &is_taken)
        });
        around_failed + along_boundary
    }

    /// Adds up the minimum ends of subproblems around seeds. `known` returns a bound for those that
    /// cannot be solved.
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

    /// Returns the nodes within `radius` of the seeds that are in no subproblem yet.
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

    /// Collects the nodes within reach that are connected to `node`, and the seeds among them.
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

    /// Halves a subproblem recursively until its parts can be solved, and adds up their minimum
    /// ends.
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
