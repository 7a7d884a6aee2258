//! The order of the triangles along paths that are cut and joined all the time: a tree for each path.
//!
//! Tags as in the module `ids` are written anew along a whole path when it changes. Here a change, and a question for the path of a
//! triangle or its position on it, take time in the logarithm of the path's length.
//!
//! ```text
//!   path a ━ b ━ c ━ d ━ e      b          in order: left, itself, right; a node that is marked as reversed stands for the
//!                              ╱ ╲         mirror image of all below it, so that a path is turned round in one step
//!                             a   d
//!                                ╱ ╲
//!                               c   e
//! ```
//!
//! # References
//! Sleator, Tarjan: *Self-Adjusting Binary Search Trees*, 1985.
//!
//! # Complexity
//! O(log n) time for each change and question, on average over many; 17 bytes a triangle.

use crate::cover::PathCover;
use crate::dual::DualGraph;
use crate::ids::FaceId;

const NONE: u32 = u32::MAX;

/// The paths of a cover, as trees of triangles.
#[derive(Debug, Default)]
pub(super) struct Order {
    children: Vec<[u32; 2]>,
    parent: Vec<u32>,
    size: Vec<u32>,
    is_reversed: Vec<bool>,
    /// The nodes from one up to its root.
    up: Vec<u32>,
}

impl Order {
    pub(super) fn new(graph: &DualGraph, cover: &PathCover) -> Self {
        let mut order = Self::default();
        order.grow(cover.len());
        if graph.half_edge_count() != 3 * cover.len() {
            return order;
        }
        let mut path = Vec::new();
        let mut seen = vec![false; cover.len()];
        for start in cover.path_starts(graph) {
            path.clear();
            // A loop, which is no path, is taken as one that is open.
            let is_new = |t: &u32| !std::mem::replace(&mut seen[*t as usize], true);
            path.extend(cover.walk(graph, start).map(|(face, _, _)| face.0).take_while(is_new));
            order.build(&path);
        }
        order
    }

    /// Makes room for triangles that are new, each a path by itself.
    pub(super) fn grow(&mut self, triangle_count: usize) {
        if self.parent.len() < triangle_count {
            self.children.resize(triangle_count, [NONE; 2]);
            self.parent.resize(triangle_count, NONE);
            self.size.resize(triangle_count, 1);
            self.is_reversed.resize(triangle_count, false);
        }
    }

    /// Makes a balanced tree of a path. Gives its root, `NONE` of nothing.
    fn build(&mut self, path: &[u32]) -> u32 {
        let Some(&root) = path.get(path.len() / 2) else { return NONE };
        let left = self.build(&path[..path.len() / 2]);
        let right = self.build(&path[path.len() / 2 + 1..]);
        self.set_child(root, 0, left);
        self.set_child(root, 1, right);
        self.measure(root);
        root
    }

    /// Gives the first triangle of the path of this one.
    pub(super) fn first(&mut self, t: u32) -> u32 {
        self.splay(t);
        self.extreme(t, 0)
    }

    /// Counts the triangles before this one on its path.
    pub(super) fn position(&mut self, t: u32) -> u32 {
        self.splay(t);
        self.size_of(self.children[t as usize][0])
    }

    /// Counts the triangles of the path of this one.
    pub(super) fn length(&mut self, t: u32) -> u32 {
        self.splay(t);
        self.size[t as usize]
    }

    /// Cuts and joins paths as the cover's are at these triangles, the only ones whose links have changed.
    pub(super) fn follow(
        &mut self,
        graph: &DualGraph,
        cover: &PathCover,
        changed: impl Iterator<Item = u32> + Clone,
    ) {
        let links = |t: u32| {
            let edges = cover.edges(FaceId(t)).into_iter().flatten();
            edges.filter_map(|h| graph.twin(h)).map(|twin| twin.0 / 3)
        };
        for t in changed.clone() {
            for side in 0..2 {
                let neighbour = self.neighbour(t, side);
                if neighbour != NONE && !links(t).any(|linked| linked == neighbour) {
                    self.cut(t, side);
                }
            }
        }
        for t in changed {
            links(t).for_each(|linked| self.join(t, linked));
        }
    }

    /// Gives the triangle before or after one, `NONE` at the end of a path.
    fn neighbour(&mut self, t: u32, side: usize) -> u32 {
        self.splay(t);
        match self.children[t as usize][side] {
            NONE => NONE,
            child => {
                // `t` stays on top of the nearest one, which comes next below.
                let nearest = self.extreme_below(child, 1 - side);
                self.splay(nearest);
                nearest
            }
        }
    }

    /// Cuts a path before or after a triangle.
    fn cut(&mut self, t: u32, side: usize) {
        self.splay(t);
        let child = std::mem::replace(&mut self.children[t as usize][side], NONE);
        if child != NONE {
            self.parent[child as usize] = NONE;
        }
        self.measure(t);
    }

    /// Joins the paths of two ends, if they are ends of different paths.
    fn join(&mut self, t: u32, other: u32) {
        if self.first(t) == self.first(other) || !self.turn(t, 1) || !self.turn(other, 0) {
            return;
        }
        self.set_child(t, 1, other);
        self.measure(t);
    }

    /// Makes a triangle the root and, turning the path round if need be, one with nothing to this side. Returns whether it could.
    fn turn(&mut self, t: u32, side: usize) -> bool {
        self.splay(t);
        if self.children[t as usize][side] != NONE {
            self.is_reversed[t as usize] = true;
            self.push(t);
        }
        self.children[t as usize][side] == NONE
    }

    /// Gives the first or the last triangle of a tree, and makes it the root.
    fn extreme(&mut self, root: u32, side: usize) -> u32 {
        let extreme = self.extreme_below(root, side);
        self.splay(extreme);
        extreme
    }

    /// Gives the first or the last triangle below a node, whose marks have been pushed down as far as it.
    fn extreme_below(&mut self, mut node: u32, side: usize) -> u32 {
        loop {
            self.push(node);
            match self.children[node as usize][side] {
                NONE => return node,
                child => node = child,
            }
        }
    }

    /// Makes a node the root of its tree.
    fn splay(&mut self, t: u32) {
        self.up.clear();
        let mut node = t;
        while node != NONE {
            self.up.push(node);
            node = self.parent[node as usize];
        }
        while let Some(node) = self.up.pop() {
            self.push(node);
        }
        while self.parent[t as usize] != NONE {
            let parent = self.parent[t as usize];
            let above = self.parent[parent as usize];
            if above != NONE {
                let straight = self.side(t) == self.side(parent);
                self.rotate(if straight { parent } else { t });
            }
            self.rotate(t);
        }
    }

    /// Lifts a node above its parent.
    fn rotate(&mut self, t: u32) {
        let parent = self.parent[t as usize];
        let above = self.parent[parent as usize];
        let side = self.side(t);
        if above == NONE {
            self.parent[t as usize] = NONE;
        } else {
            let side_above = self.side(parent);
            self.set_child(above, side_above, t);
        }
        let inner = self.children[t as usize][1 - side];
        self.set_child(parent, side, inner);
        self.set_child(t, 1 - side, parent);
        self.measure(parent);
        self.measure(t);
    }

    /// Turns a node's children round, if it is marked, and marks them.
    fn push(&mut self, t: u32) {
        if std::mem::replace(&mut self.is_reversed[t as usize], false) {
            self.children[t as usize].swap(0, 1);
            for child in self.children[t as usize].into_iter().filter(|&child| child != NONE) {
                self.is_reversed[child as usize] ^= true;
            }
        }
    }

    fn side(&self, t: u32) -> usize {
        usize::from(self.children[self.parent[t as usize] as usize][1] == t)
    }

    fn set_child(&mut self, t: u32, side: usize, child: u32) {
        self.children[t as usize][side] = child;
        if child != NONE {
            self.parent[child as usize] = t;
        }
    }

    fn size_of(&self, t: u32) -> u32 {
        if t == NONE { 0 } else { self.size[t as usize] }
    }

    fn measure(&mut self, t: u32) {
        let [left, right] = self.children[t as usize];
        self.size[t as usize] = 1 + self.size_of(left) + self.size_of(right);
    }

    /// Checks that the trees are the paths of a cover.
    #[cfg(test)]
    pub(super) fn check(&mut self, graph: &DualGraph, cover: &PathCover) -> bool {
        cover.path_starts(graph).all(|start| {
            let mut path: Vec<u32> = cover.walk(graph, start).map(|(face, _, _)| face.0).collect();
            if self.first(path[0]) != path[0] {
                path.reverse();
            }
            path.iter().enumerate().all(|(position, &t)| {
                let tags = (self.first(t), self.position(t), self.length(t));
                tags == (path[0], position as u32, path.len() as u32)
            })
        })
    }
}
