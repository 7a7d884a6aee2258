//! Union–find: disjoint sets of the numbers 0, 1, 2 …, each represented by its root.
//!
//! # References
//! Tarjan, van Leeuwen: *Worst-case Analysis of Set Union Algorithms*, 1984 (path halving).
//!
//! # Complexity
//! 4 bytes per element. Nearly O(1) amortized time per call, or O(log n) for unions by lowest root.

/// Disjoint sets of `u32` elements.
///
/// ```
/// use tristrip::union_find::UnionFind;
/// // The components of two edges between five vertices.
/// let mut components = UnionFind::new(5);
/// components.unite(4, 1);
/// components.unite(1, 3);
/// assert_eq!([0, 1, 2, 3, 4].map(|vertex| components.find(vertex)), [0, 1, 2, 1, 1]);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnionFind {
    parents: Vec<u32>,
}

impl UnionFind {
    /// Creates `count` sets of one element each. `count` is at most 2³².
    ///
    /// ```
    /// assert_eq!(tristrip::union_find::UnionFind::new(3).find(2), 2);
    /// ```
    pub fn new(count: usize) -> Self {
        Self { parents: (0..count as u32).collect() }
    }

    /// Returns the root of the set of an element, and halves the path to the root.
    ///
    /// # Panics
    /// Panics if the element is not less than the number of elements.
    ///
    /// ```
    /// let mut sets = tristrip::union_find::UnionFind::new(3);
    /// sets.unite(1, 2);
    /// assert_eq!(sets.find(2), sets.find(1));
    /// ```
    #[inline]
    pub fn find(&mut self, mut element: u32) -> u32 {
        while self.parents[element as usize] != element {
            let parent = self.parents[element as usize];
            let grandparent = self.parents[parent as usize];
            self.parents[element as usize] = grandparent;
            element = grandparent;
        }
        element
    }

    /// Unites the sets of two elements. The lower of the two roots becomes the root of the united
    /// set.
    ///
    /// # Panics
    /// Panics if an element is not less than the number of elements.
    ///
    /// ```
    /// let mut sets = tristrip::union_find::UnionFind::new(3);
    /// sets.unite(2, 1);
    /// assert_eq!(sets.find(2), 1);
    /// ```
    pub fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parents[a.max(b) as usize] = a.min(b);
    }

    /// Returns whether an element is the root of its set.
    #[inline]
    pub(crate) fn is_root(&self, element: u32) -> bool {
        self.parents[element as usize] == element
    }

    /// Unites the sets of two roots. The first root becomes the root of both.
    #[inline]
    pub(crate) fn unite_into(&mut self, root: u32, other: u32) {
        debug_assert!(self.is_root(root) && self.is_root(other));
        self.parents[other as usize] = root;
    }

    /// Makes an element a set of its own. The caller must isolate all elements of the old set.
    #[inline]
    pub(crate) fn isolate(&mut self, element: u32) {
        self.parents[element as usize] = element;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The oracle relabels every element of a set at each union.
        #[test]
        fn sets_are_those_of_relabelling(unions in prop::collection::vec((0..40_u32, 0..40_u32), 0..60)) {
            let mut sets = UnionFind::new(40);
            let mut lowest: Vec<u32> = (0..40).collect();
            for (a, b) in unions {
                sets.unite(a, b);
                let (x, y) = (lowest[a as usize], lowest[b as usize]);
                lowest.iter_mut().filter(|l| **l == x.max(y)).for_each(|l| *l = x.min(y));
            }
            for element in 0..40 {
                prop_assert_eq!(sets.find(element), lowest[element as usize]);
            }
        }
    }

    #[test]
    fn a_chosen_root_stays_the_root() {
        let mut sets = UnionFind::new(4);
        sets.unite(0, 1);
        sets.unite_into(3, 0);
        assert_eq!([0, 1, 2, 3].map(|element| sets.find(element)), [3, 3, 2, 3]);
        assert!(sets.is_root(3) && !sets.is_root(0));
        [0, 1, 3].into_iter().for_each(|element| sets.isolate(element));
        assert!((0..4).all(|element| sets.is_root(element)));
    }
}
