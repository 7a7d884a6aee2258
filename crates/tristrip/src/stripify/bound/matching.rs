//! Maximum matching in a subgraph of a graph of at most three neighbours a node, grown block by block.
//!
//! # Algorithm
//! 1. *Greedy*: nodes in order take the free neighbour that has the fewest free neighbours itself. In the order of a
//!    depth-first search this leaves less than one node in a hundred free.
//! 2. *Augment* (Edmonds): from each free node a breadth-first search along alternating paths; odd cycles are shrunk by union-find
//!    (Gabow). A search that finds no other free node leaves its labels where they are: its nodes cannot help any later search.
//!
//! What the failed searches labelled even are then the nodes that some maximum matching leaves free (Gallai, Edmonds), so that
//! what one more node would gain is known without a search: see [`Matching::would_match`].
//!
//! # References
//! Edmonds: *Paths, trees, and flowers*, 1965; Gabow: *An efficient implementation of Edmonds' algorithm for maximum matching on
//! graphs*, 1976; Karp, Sipser: *Maximum matchings in sparse random graphs*, 1981.
//!
//! # Complexity
//! O(n) for a search as a rule, and in all O(n) for those that fail; limited by a number of steps. 17 bytes a node and 8 for each
//! that the largest search reaches.

use super::blocks::Blocks;
use super::{NONE, topmost};

/// What a node is to the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Label {
    /// Not a node of the subgraph.
    Outside,
    /// Not reached.
    Unseen,
    /// Reached by an alternating path of even length, at whose end it may be left free.
    Even,
    /// Reached by paths of odd length only.
    Odd,
}

/// A matching of the nodes that were let in.
#[derive(Debug)]
pub(super) struct Matching {
    mate: Vec<u32>,
    /// The even node from which an odd one was reached; within a shrunk cycle also across it.
    from: Vec<u32>,
    /// Union-find over shrunk cycles: toward the node by which a cycle hangs on its tree.
    base: Vec<u32>,
    label: Vec<Label>,
    /// The last search for a common ancestor that came by.
    mark: Vec<u32>,
    marks: u32,
    /// The nodes that a search has reached.
    reached: Vec<u32>,
    /// The even ones of them, in the order in which they are searched from.
    queue: Vec<u32>,
    /// Steps that searches may still take, a step for each node that they search from or shrink.
    steps_left: u64,
}

/// What was found for a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Pairs {
    /// How many pairs there are at most.
    pub(super) at_most: usize,
    /// Whether so many were found.
    pub(super) is_exact: bool,
}

impl Matching {
    /// Makes the matching of no node out of so many, and gives it so many steps for all its searches.
    pub(super) fn new(node_count: usize, steps: u64) -> Self {
        Self {
            mate: vec![NONE; node_count],
            from: vec![NONE; node_count],
            base: (0..node_count as u32).collect(),
            label: vec![Label::Outside; node_count],
            mark: vec![0; node_count],
            marks: 0,
            reached: Vec::new(),
            queue: Vec::new(),
            steps_left: steps,
        }
    }

    /// Lets a node of a block that is not matched yet into the subgraph.
    pub(super) fn admit(&mut self, node: u32) {
        self.label[node as usize] = Label::Unseen;
    }

    /// Tells whether a node is one of the subgraph.
    pub(super) fn has(&self, node: u32) -> bool {
        self.label[node as usize] != Label::Outside
    }

    /// Tells whether a node outside would be matched, too, if it were let in; for a block whose pairs are exact.
    pub(super) fn would_match(&self, blocks: &Blocks, node: u32) -> bool {
        blocks.inside(node).any(|other| self.label[other as usize] == Label::Even)
    }

    /// Matches as many nodes of a block as can be, and counts the pairs. Where there are no steps left, the nodes that no search
    /// has failed for count as matched.
    pub(super) fn match_block(&mut self, blocks: &Blocks, root: u32) -> Pairs {
        let mut pairs = self.greedy(blocks, root);
        let mut unsearched = 0;
        for node in blocks.members(root) {
            if !self.is_free(node) {
                continue;
            }
            if self.augment(blocks, node) {
                pairs += 1;
            } else if self.steps_left == 0 {
                unsearched += 1;
            }
        }
        Pairs { at_most: pairs + unsearched / 2, is_exact: unsearched == 0 }
    }

    /// Tells whether a search that failed has reached a node.
    pub(super) fn has_failed(&self, node: u32) -> bool {
        matches!(self.label[node as usize], Label::Even | Label::Odd)
    }

    /// Tells whether a node of the subgraph is unmatched.
    pub(super) fn is_free(&self, node: u32) -> bool {
        self.has(node) && self.mate[node as usize] == NONE
    }

    fn greedy(&mut self, blocks: &Blocks, root: u32) -> usize {
        let mut pairs = 0;
        for node in blocks.members(root) {
            if !self.is_free(node) {
                continue;
            }
            let free = |node: u32| blocks.inside(node).filter(|&other| self.is_free(other));
            let scarcest = free(node).min_by_key(|&other| free(other).count());
            if let Some(other) = scarcest {
                self.pair(node, other);
                pairs += 1;
            }
        }
        pairs
    }

    fn pair(&mut self, a: u32, b: u32) {
        self.mate[a as usize] = b;
        self.mate[b as usize] = a;
    }

    /// Searches an alternating path from a free node to another and exchanges along it. Returns whether it
    /// found one, before there were no steps left.
    fn augment(&mut self, blocks: &Blocks, start: u32) -> bool {
        self.reached.clear();
        self.queue.clear();
        self.reached.push(start);
        self.reach_even(start);
        let mut head = 0;
        while let Some(&node) = self.queue.get(head) {
            head += 1;
            self.steps_left = self.steps_left.saturating_sub(1);
            if self.steps_left == 0 {
                self.forget();
                return false;
            }
            for other in blocks.inside(node) {
                let label = self.label[other as usize];
                match label {
                    Label::Unseen => {
                        self.from[other as usize] = node;
                        let mate = self.mate[other as usize];
                        if mate == NONE {
                            self.exchange(other);
                            self.forget();
                            return true;
                        }
                        self.label[other as usize] = Label::Odd;
                        self.reached.extend([other, mate]);
                        self.reach_even(mate);
                    }
                    Label::Even if self.find(node) != self.find(other) => {
                        let top = self.common_ancestor(node, other);
                        self.shrink(node, other, top);
                        self.shrink(other, node, top);
                    }
                    _ => (),
                }
            }
        }
        false
    }

    fn reach_even(&mut self, node: u32) {
        self.label[node as usize] = Label::Even;
        self.queue.push(node);
    }

    /// Exchanges along the path that led to a free node.
    fn exchange(&mut self, free: u32) {
        let mut node = free;
        while node != NONE {
            let from = self.from[node as usize];
            let before = self.mate[from as usize];
            self.pair(node, from);
            node = before;
        }
    }

    /// Takes the labels of a search away.
    fn forget(&mut self) {
        for &node in &self.reached {
            self.label[node as usize] = Label::Unseen;
            self.base[node as usize] = node;
        }
    }

    fn find(&mut self, node: u32) -> u32 {
        topmost(&mut self.base, node)
    }

    /// Finds where the paths of two even nodes meet, by going up from both in turn.
    fn common_ancestor(&mut self, a: u32, b: u32) -> u32 {
        self.marks += 1;
        let (mut here, mut there) = (self.find(a), self.find(b));
        loop {
            if here != NONE {
                if std::mem::replace(&mut self.mark[here as usize], self.marks) == self.marks {
                    return here;
                }
                let mate = self.mate[here as usize];
                here = if mate == NONE { NONE } else { self.find(self.from[mate as usize]) };
            }
            if there != NONE {
                std::mem::swap(&mut here, &mut there);
            }
        }
    }

    /// Shrinks one side of the odd cycle that the edge from `node` to `other` closes, up to `top`.
    fn shrink(&mut self, node: u32, other: u32, top: u32) {
        let (mut node, mut other) = (node, other);
        while self.find(node) != top {
            self.steps_left = self.steps_left.saturating_sub(1);
            self.from[node as usize] = other;
            other = self.mate[node as usize];
            if self.label[other as usize] == Label::Odd {
                self.reach_even(other);
            }
            // The node by which the cycle hangs stays the name of the union.
            for inner in [node, other] {
                if self.base[inner as usize] == inner {
                    self.base[inner as usize] = top;
                }
            }
            node = self.from[other as usize];
        }
    }
}
