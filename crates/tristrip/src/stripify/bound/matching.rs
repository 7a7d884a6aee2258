//! Maximum matching in a subgraph of a graph with at most three neighbours per node, block by
//! block.
//!
//! # Algorithm
//! 1. *Greedy*: each node in order is matched with the free neighbour that has the fewest free
//!    neighbours. In depth-first order this leaves less than one node in a hundred free.
//! 2. *Augment* (Edmonds): from each free node, search breadth first along alternating paths. Odd
//!    cycles are shrunk by union–find (Gabow). A search that finds no other free node keeps its
//!    labels, because its nodes cannot help any later search.
//!
//! A node that the failed searches labelled even is left free by some maximum matching (Gallai,
//! Edmonds). These labels determine without a search whether one more node would be matched: see
//! [`Matching::would_match`].
//!
//! # References
//! Edmonds: *Paths, trees, and flowers*, 1965; Gabow: *An efficient implementation of Edmonds'
//! algorithm for maximum matching on graphs*, 1976; Karp, Sipser: *Maximum matchings in sparse
//! random graphs*, 1981.
//!
//! # Complexity
//! Usually O(n) time per search, and O(n) for all failed searches together. The number of steps is
//! limited. 17 bytes per node, and 8 per node that the largest search reaches.

use super::blocks::BlockTree;
use crate::ids::OptionalId;
use crate::union_find::UnionFind;

/// The label of a node in the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NodeLabel {
    /// Not a node of the subgraph.
    Outside,
    /// Not reached.
    Unseen,
    /// Reached by an alternating path of even length: some maximum matching leaves it free.
    Even,
    /// Reached only by paths of odd length.
    Odd,
}

/// A matching of the admitted nodes.
#[derive(Debug)]
pub(super) struct Matching {
    mate: Vec<OptionalId>,
    /// The even node from which an odd node was reached. Within a shrunk cycle also the even node
    /// across the cycle.
    from: Vec<u32>,
    /// Shrunk cycles. The root of a set is its base: the node that attaches the cycle to its tree.
    bases: UnionFind,
    label: Vec<NodeLabel>,
    /// The last search for a common ancestor that visited each node.
    mark: Vec<u32>,
    marks: u32,
    /// The nodes that the current search has reached.
    reached: Vec<u32>,
    /// The even nodes among them, in the order in which the search expands them.
    queue: Vec<u32>,
    /// Remaining steps of the searches: one per node that they expand or shrink.
    steps_left: u64,
}

/// The number of matched pairs of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PairCount {
    /// An upper bound.
    pub(super) at_most: usize,
    /// Whether that many pairs were found.
    pub(super) is_exact: bool,
}

impl Matching {
    /// Creates a matching without admitted nodes, with a step limit for all its searches.
    pub(super) fn new(node_count: usize, steps: u64) -> Self {
        Self {
            mate: vec![OptionalId::NONE; node_count],
            from: vec![0; node_count],
            bases: UnionFind::new(node_count),
            label: vec![NodeLabel::Outside; node_count],
            mark: vec![0; node_count],
            marks: 0,
            reached: Vec::new(),
            queue: Vec::new(),
            steps_left: steps,
        }
    }

    /// Admits a node to the subgraph. Its block must not be matched yet.
    pub(super) fn admit(&mut self, node: u32) {
        self.label[node as usize] = NodeLabel::Unseen;
    }

    /// Returns whether a node belongs to the subgraph.
    pub(super) fn contains(&self, node: u32) -> bool {
        self.label[node as usize] != NodeLabel::Outside
    }

    /// Returns whether a node outside the subgraph would also be matched if it were admitted. The
    /// pair count of the block must be exact.
    pub(super) fn would_match(&self, blocks: &BlockTree, node: u32) -> bool {
        blocks.inside(node).any(|other| self.label[other as usize] == NodeLabel::Even)
    }

    /// Matches as many nodes of a block as possible, and counts the pairs. When no steps are left,
    /// free nodes without a failed search count as matched.
    pub(super) fn match_block(&mut self, blocks: &BlockTree, root: u32) -> PairCount {
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
        PairCount { at_most: pairs + unsearched / 2, is_exact: unsearched == 0 }
    }

    /// Returns whether a failed search has reached a node.
    pub(super) fn has_failed(&self, node: u32) -> bool {
        matches!(self.label[node as usize], NodeLabel::Even | NodeLabel::Odd)
    }

    /// Returns whether a node of the subgraph is unmatched.
    pub(super) fn is_free(&self, node: u32) -> bool {
        self.contains(node) && self.mate[node as usize].is_none()
    }

    fn greedy(&mut self, blocks: &BlockTree, root: u32) -> usize {
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
        self.mate[a as usize] = OptionalId::some(b);
        self.mate[b as usize] = OptionalId::some(a);
    }

    /// Searches for an alternating path from a free node to another free node, and augments the
    /// matching along it. Returns whether it found one within the step limit.
    fn augment(&mut self, blocks: &BlockTree, start: u32) -> bool {
        self.reached.clear();
        self.queue.clear();
        self.reached.push(start);
        self.reach_even(start);
        let mut head = 0;
        while let Some(&node) = self.queue.get(head) {
            head += 1;
            self.steps_left = self.steps_left.saturating_sub(1);
            if self.steps_left == 0 {
                self.clear_labels();
                return false;
            }
            for other in blocks.inside(node) {
                let label = self.label[other as usize];
                match label {
                    NodeLabel::Unseen => {
                        self.from[other as usize] = node;
                        let Some(mate) = self.mate[other as usize].get() else {
                            self.augment_along_path(other);
                            self.clear_labels();
                            return true;
                        };
                        self.label[other as usize] = NodeLabel::Odd;
                        self.reached.extend([other, mate]);
                        self.reach_even(mate);
                    }
                    NodeLabel::Even if self.bases.find(node) != self.bases.find(other) => {
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
        self.label[node as usize] = NodeLabel::Even;
        self.queue.push(node);
    }

    /// Augments the matching along the path that leads to a free node.
    fn augment_along_path(&mut self, free: u32) {
        let mut next = Some(free);
        while let Some(node) = next {
            let from = self.from[node as usize];
            next = self.mate[from as usize].get();
            self.pair(node, from);
        }
    }

    /// Clears the labels of the current search.
    fn clear_labels(&mut self) {
        for &node in &self.reached {
            self.label[node as usize] = NodeLabel::Unseen;
            self.bases.isolate(node);
        }
    }

    /// Returns the base of the even node from which the mate of an even node was reached, or `None`
    /// at the root of the tree.
    fn base_above(&mut self, node: u32) -> Option<u32> {
        let mate = self.mate[node as usize].get()?;
        Some(self.bases.find(self.from[mate as usize]))
    }

    /// Finds the node where the paths from two even nodes to the root meet, by going up from both
    /// in turn.
    fn common_ancestor(&mut self, a: u32, b: u32) -> u32 {
        self.marks += 1;
        let (mut here, mut there) = (Some(self.bases.find(a)), Some(self.bases.find(b)));
        loop {
            if let Some(node) = here {
                if std::mem::replace(&mut self.mark[node as usize], self.marks) == self.marks {
                    return node;
                }
                here = self.base_above(node);
            }
            if there.is_some() {
                std::mem::swap(&mut here, &mut there);
            }
        }
    }

    /// Shrinks one side, up to `top`, of the odd cycle that the edge from `node` to `other` closes.
    fn shrink(&mut self, node: u32, other: u32, top: u32) {
        let (mut node, mut other) = (node, other);
        while self.bases.find(node) != top {
            self.steps_left = self.steps_left.saturating_sub(1);
            self.from[node as usize] = other;
            // Only the root of the tree has no mate, and its base is `top`.
            let Some(mate) = self.mate[node as usize].get() else { return };
            other = mate;
            if self.label[other as usize] == NodeLabel::Odd {
                self.reach_even(other);
            }
            for inner in [node, other] {
                if self.bases.is_root(inner) {
                    self.bases.unite_into(top, inner);
                }
            }
            node = self.from[other as usize];
        }
    }
}
