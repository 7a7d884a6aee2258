//! Whether two lists of triangles draw the same: each oriented triangle as often, in any order and from any corner.
//!
//! # Algorithm
//! A counting sort groups the triangles of each list by their lowest vertex, mostly two or three per vertex. The rows of a vertex are
//! compared as sorted pairs of the two other vertices, in winding order. Degenerate triangles draw nothing and are left out.
//!
//! # Complexity
//! O(n) time for meshes of bounded valence, O(n log n) at worst; 4 bytes per triangle and 4 per vertex up to the highest one, for each list.
//! Lists that use few of the vertices up to the highest one are sorted as a whole, in 24 bytes per triangle.

use std::ops::Range;

use crate::csr::Csr;
use crate::ids::MAX_COUNT;
use crate::mesh::{SPARSE, canonical_triangle, canonical_triangles, is_degenerate};

/// The number of ranges of vertices that are compared in parallel.
#[cfg(feature = "rayon")]
const RANGES: u32 = 64;

/// Returns whether two lists of triangles draw the same.
pub(super) fn same_triangles(a: &[[u32; 3]], b: &[[u32; 3]]) -> bool {
    let highest = a.iter().chain(b).flatten().max().map_or(0, |&v| v as usize);
    if highest >= MAX_COUNT || highest / SPARSE > 3 * a.len().max(b.len()) {
        return canonical_triangles(a.iter().copied()) == canonical_triangles(b.iter().copied());
    }
    let group = |triangles| ByLowest::new(triangles, highest + 1);
    #[cfg(feature = "rayon")]
    let (a, b) = rayon::join(|| group(a), || group(b));
    #[cfg(not(feature = "rayon"))]
    let (a, b) = (group(a), group(b));
    let vertices = highest as u32 + 1;
    #[cfg(feature = "rayon")]
    {
        use rayon::prelude::*;
        let bound = |i: u32| (u64::from(vertices) * u64::from(i) / u64::from(RANGES)) as u32;
        (0..RANGES).into_par_iter().all(|i| a.equals(&b, bound(i)..bound(i + 1)))
    }
    #[cfg(not(feature = "rayon"))]
    a.equals(&b, 0..vertices)
}

/// Triangles grouped by their lowest vertex.
struct ByLowest<'a> {
    triangles: &'a [[u32; 3]],
    rows: Csr,
}

impl<'a> ByLowest<'a> {
    /// Groups triangles over vertices below `vertex_count`. The last row has the degenerate ones.
    fn new(triangles: &'a [[u32; 3]], vertex_count: usize) -> Self {
        let key =
            |&t: &[u32; 3]| if is_degenerate(t) { vertex_count as u32 } else { t[0].min(t[1]).min(t[2]) };
        Self { triangles, rows: Csr::group(triangles.iter().map(key), vertex_count + 1) }
    }

    /// Returns whether the triangles of some vertices are the same.
    fn equals(&self, other: &Self, vertices: Range<u32>) -> bool {
        let (mut here, mut there) = (Vec::new(), Vec::new());
        vertices.into_iter().all(|v| {
            if self.rows.row(v).len() != other.rows.row(v).len() {
                return false;
            }
            self.sorted_row(v, &mut here);
            other.sorted_row(v, &mut there);
            here == there
        })
    }

    /// Returns the triangles of a vertex by their two other vertices, sorted.
    fn sorted_row(&self, vertex: u32, row: &mut Vec<u64>) {
        row.clear();
        row.extend(self.rows.row(vertex).iter().map(|&t| {
            let [_, b, c] = canonical_triangle(self.triangles[t as usize]);
            u64::from(b) << 32 | u64::from(c)
        }));
        row.sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// The oracle sorts both lists.
        #[test]
        fn lists_are_the_same_if_their_sorted_triangles_are(
            a in prop::collection::vec([0..6_u32, 0..6, 0..6], 0..40),
            change in prop::option::of((any::<prop::sample::Index>(), [0..6_u32, 0..6, 0..6])),
            turns in prop::collection::vec(0..3_usize, 40),
            scale in prop_oneof![Just(1_u32), Just(100_000)],
        ) {
            let mut b: Vec<[u32; 3]> = a.iter().rev().copied().collect();
            b.iter_mut().zip(turns).for_each(|(triangle, turn)| triangle.rotate_left(turn));
            if let (Some((at, other)), false) = (change, b.is_empty()) {
                let at = at.index(b.len());
                b[at] = other;
            }
            let [a, b] = [a, b].map(|list| list.into_iter().map(|t| t.map(|v| v * scale)).collect::<Vec<_>>());
            let expected = canonical_triangles(a.iter().copied()) == canonical_triangles(b.iter().copied());
            prop_assert_eq!(same_triangles(&a, &b), expected);
        }
    }

    #[test]
    fn windings_and_numbers_of_triangles_count() {
        assert!(same_triangles(&[[0, 1, 2], [5, 5, 6]], &[[1, 2, 0]]));
        assert!(!same_triangles(&[[0, 1, 2]], &[[0, 2, 1]]));
        assert!(!same_triangles(&[[0, 1, 2], [0, 1, 2]], &[[0, 1, 2]]));
        assert!(same_triangles(&[], &[[3, 3, 3]]));
    }
}
