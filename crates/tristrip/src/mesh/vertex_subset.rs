//! The vertices that an index buffer uses, renumbered 0, 1, 2 … in ascending order. Thousands of
//! parts may share one long list of vertices. Per-vertex arrays then need only the size of one
//! part.
//!
//! # Complexity
//! O(n log n) time; 4 bytes per index while building, then 4 bytes per vertex in use.

/// The ratio of vertices to indices above which the used vertices are renumbered before arrays per
/// vertex are allocated.
pub(crate) const SPARSE: usize = 16;

/// Returns the highest index plus 1, or 0 without indices: the size of a table by vertex. Saturates
/// where `usize` has 32 bits; such a table cannot exist.
pub(crate) fn vertex_bound(indices: &[u32]) -> usize {
    // Compiles to SIMD comparisons, unlike `max`.
    let highest = indices.iter().fold(0, |highest, &index| highest.max(index));
    if indices.is_empty() { 0 } else { (highest as usize).saturating_add(1) }
}

/// The vertices that occur in an index buffer, in ascending order.
#[derive(Debug, Clone)]
pub(crate) struct VertexSubset {
    used: Vec<u32>,
}

impl VertexSubset {
    /// Collects the vertices of indices.
    pub(crate) fn of(indices: &[u32]) -> Self {
        let mut used = indices.to_vec();
        used.sort_unstable();
        used.dedup();
        Self { used }
    }

    /// Counts the vertices.
    pub(crate) fn len(&self) -> usize {
        self.used.len()
    }

    /// Returns the vertices in ascending order.
    pub(crate) fn vertices(&self) -> &[u32] {
        &self.used
    }

    /// Returns the vertices in ascending order.
    pub(crate) fn into_vertices(self) -> Vec<u32> {
        self.used
    }

    /// Returns the new number of a vertex. The vertex must belong to the subset.
    #[inline]
    pub(crate) fn number(&self, vertex: u32) -> u32 {
        self.used.partition_point(|&used| used < vertex) as u32
    }

    /// Returns the new number of a vertex, or `None` if it does not belong to the subset.
    pub(crate) fn find(&self, vertex: u32) -> Option<u32> {
        let number = self.number(vertex);
        (self.used.get(number as usize) == Some(&vertex)).then_some(number)
    }

    /// Returns the new number of every index. All indices must belong to the subset.
    pub(crate) fn numbers(&self, indices: &[u32]) -> Vec<u32> {
        indices.iter().map(|&vertex| self.number(vertex)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn bounds_are_above_every_index() {
        assert_eq!([&[][..], &[0], &[3, 7, 5]].map(vertex_bound), [0, 1, 8]);
    }

    proptest! {
        #[test]
        fn numbers_lead_back_to_the_vertices(indices in prop::collection::vec(0..1000_u32, 0..50)) {
            let subset = VertexSubset::of(&indices);
            prop_assert!(subset.vertices().windows(2).all(|w| w[0] < w[1]));
            let back: Vec<u32> = subset.numbers(&indices).iter().map(|&n| subset.vertices()[n as usize]).collect();
            prop_assert_eq!(back, indices.clone());
            for vertex in 0..1000 {
                let number = subset.vertices().iter().position(|&used| used == vertex);
                prop_assert_eq!(subset.find(vertex).map(|number| number as usize), number);
            }
        }
    }
}
