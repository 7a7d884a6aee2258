//! Sharpens the bound on a block by pieces of it that are solved exactly.
//!
//! # Algorithm
//! A small block is solved whole. Of a large one disjoint pieces are, and the ends of paths that they need are added up: edges between
//! a piece and the rest are free to use, so that no piece sees what another needs. Among triangles of three neighbours
//! paths find their way; ends are forced where a matching failed, and perhaps along the boundary. So:
//! 1. The triangles that the failed searches reached, and those around them, make pieces: as far around as can be solved. Where none
//!    can, it is known that they hold an end for each triangle left unmatched, themselves and their neighbours together: the
//!    searches' even nodes make components of odd size, more of them by so many than there are odd nodes to match them with.
//! 2. So do the triangles of two neighbours, and what is around them and not in a piece yet. Where that is too wide to be solved, it
//!    is cut in half, and again.
//!
//! # Complexity
//! Limited by a number of states for the whole graph; 5 bytes a triangle.

use super::NONE;
use super::blocks::Blocks;
use super::frontier::{Node, least_ends};
use super::matching::Matching;

/// How far around its seeds a piece reaches at most, in triangles: for the dragon's boundaries, 3 and 4 give the same.
const RADIUS: u8 = 3;
/// Pieces of more triangles are not tried.
const LARGEST: usize = 2048;
/// Pieces of fewer triangles are not cut in half.
const SMALL: usize = 16;

/// Not in reach of any seed.
const FAR: u8 = u8::MAX;
/// In a piece.
const DONE: u8 = u8::MAX - 1;

/// Solves pieces of the blocks of a graph.
#[derive(Debug)]
pub(super) struct Pieces {
    /// The place of each node in the piece at hand.
    place: Vec<u32>,
    /// The distance of each node from the nearest seed.
    distance: Vec<u8>,
    states_at_once: usize,
    states_left: u64,
}

impl Pieces {
    /// Makes ready for a graph of so many nodes, with so many states at once and in all.
    pub(super) fn new(node_count: usize, states_at_once: usize, states: u64) -> Self {
        Self {
            place: vec![NONE; node_count],
            distance: vec![FAR; node_count],
            states_at_once,
            states_left: states,
        }
    }

    /// Counts the least ends of a whole block, where that can be done; `is_taken` tells whether a bridge is used at a node.
    pub(super) fn whole(
        &mut self,
        blocks: &Blocks,
        members: &[u32],
        is_taken: impl Fn(u32) -> bool,
    ) -> Option<usize> {
        self.solve(blocks, members, &is_taken)
    }

    /// Adds up the least ends of pieces of a block around what a matching left over, and then along the boundary.
    pub(super) fn around(
        &mut self,
        blocks: &Blocks,
        members: &[u32],
        matching: &Matching,
        is_taken: impl Fn(u32) -> bool,
    ) -> usize {
        let failed = members.iter().copied().filter(|&node| matching.has_failed(node)).collect();
        // What has no neighbour that the searches reached is outside such a piece, so that its ends are counted in it.
        let around_failed = self.around_seeds(blocks, failed, &is_taken, |_, piece| {
            piece.iter().filter(|&&node| matching.has_failed(node) && matching.is_free(node)).count()
        });
        let boundary = members.iter().copied().filter(|&node| blocks.inside(node).count() == 2).collect();
        let along_boundary = self.around_seeds(blocks, boundary, &is_taken, |pieces, piece| {
            pieces.solve_halves(blocks, piece, &is_taken)
        });
        around_failed + along_boundary
    }

    /// Adds up the least ends of pieces around seeds, and what is `known` of those that cannot be solved.
    fn around_seeds(
        &mut self,
        blocks: &Blocks,
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
                let (piece, seeds) = self.gather(blocks, node);
                if let Some(found) = self.solve(blocks, &piece, is_taken) {
                    ends += found;
                } else if radius > 1 {
                    piece.iter().for_each(|&node| self.distance[node as usize] = FAR);
                    open.push((seeds, radius - 1));
                } else {
                    ends += known(self, &piece);
                }
            }
        }
        ends
    }

    /// Finds what is at most so far from the seeds, and in no piece yet.
    fn reach(&mut self, blocks: &Blocks, seeds: &[u32], radius: u8) -> Vec<u32> {
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

    /// Gathers the nodes in reach that are connected with this one, and the seeds among them.
    fn gather(&mut self, blocks: &Blocks, node: u32) -> (Vec<u32>, Vec<u32>) {
        let mut piece = vec![node];
        let mut seeds: Vec<u32> = piece.iter().copied().filter(|&n| self.distance[n as usize] == 0).collect();
        self.distance[node as usize] = DONE;
        let mut head = 0;
        while let Some(&node) = piece.get(head) {
            head += 1;
            for other in blocks.inside(node) {
                let distance = &mut self.distance[other as usize];
                if *distance <= RADIUS {
                    if *distance == 0 {
                        seeds.push(other);
                    }
                    *distance = DONE;
                    piece.push(other);
                }
            }
        }
        (piece, seeds)
    }

    /// Cuts a piece in half, and again, until what is left can be solved.
    fn solve_halves(&mut self, blocks: &Blocks, piece: &[u32], is_taken: &impl Fn(u32) -> bool) -> usize {
        if piece.len() < 2 * SMALL || piece.len() > LARGEST {
            return 0;
        }
        let (near, far) = piece.split_at(piece.len() / 2);
        let halves = [near, far].map(|half| match self.solve(blocks, half, is_taken) {
            Some(ends) => ends,
            None => self.solve_halves(blocks, half, is_taken),
        });
        halves.iter().sum()
    }

    fn solve(&mut self, blocks: &Blocks, piece: &[u32], is_taken: &impl Fn(u32) -> bool) -> Option<usize> {
        if piece.len() > LARGEST {
            return None;
        }
        piece.iter().zip(0..).for_each(|(&node, place)| self.place[node as usize] = place);
        let nodes: Vec<Node> = piece
            .iter()
            .map(|&node| {
                let mut neighbours = [NONE; 3];
                let mut count = 0;
                let mut outward = 0;
                for other in blocks.inside(node) {
                    let place = self.place[other as usize];
                    if place == NONE {
                        outward += 1;
                    } else {
                        neighbours[count] = place;
                        count += 1;
                    }
                }
                Node { neighbours, outward, is_taken: is_taken(node) }
            })
            .collect();
        piece.iter().for_each(|&node| self.place[node as usize] = NONE);
        least_ends(&nodes, self.states_at_once, &mut self.states_left)
    }
}
