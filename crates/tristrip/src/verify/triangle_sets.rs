//! Compares two lists of triangles: each oriented triangle must occur equally often in both. Order
//! and first corner do not matter.
//!
//! # Algorithm
//! 1. A counting sort groups the triangles of one list by their lowest vertex. There are two
//!    triangles per vertex on average. Each is stored as the pair of its other two vertices in
//!    winding order. Degenerate triangles draw nothing and are ignored.
//! 2. Each triangle of the other list removes its pair from the row of its lowest vertex. The lists
//!    are equal if every triangle finds its pair and the counts match.
//! 3. Long rows, at vertices with many triangles, are not searched: their pairs are sorted and
//!    compared with the sorted pairs of the other list.
//!
//! The other list is read once, in order, and never stored. Large lists are divided by blocks of
//! vertices, and the parts are compared in parallel.
//!
//! # Complexity
//! O(n) time for meshes of bounded valence, O(n log n) in the worst case. 8 bytes per triangle, 4
//! per vertex up to the highest one, and 32 per triangle in a long row. Lists that use few of the
//! vertices up to the highest one are sorted completely, in 24 bytes per triangle.

use crate::csr::Csr;
use crate::ids::MAX_COUNT;
use crate::mesh::{SPARSE, canonical_triangles, is_degenerate, vertex_bound};

/// Rows with more triangles are sorted. Shorter rows are searched, which takes a few nanoseconds.
const LONG_ROW: usize = 32;

/// The binary logarithm of the number of vertices per block.
const BLOCK_BITS: u32 = 12;

/// Lists with fewer triangles are compared by one thread, in about a millisecond.
#[cfg(feature = "rayon")]
const SMALL: usize = 1 << 16;

/// The binary logarithm of the maximum number of parts compared in parallel. Each part reads both
/// lists.
#[cfg(feature = "rayon")]
const PART_BITS: u32 = 3;

/// Returns the number of triangles that two lists draw, or `None` if they draw different ones. `b`
/// returns the other list each time it is called.
pub(super) fn same_triangles<I>(a: &[[u32; 3]], b: impl Fn() -> I + Sync) -> Option<usize>
where
    I: Iterator<Item = [u32; 3]>,
{
    let vertex_count = vertex_bound(a.as_flattened());
    if vertex_count > MAX_COUNT || vertex_count.saturating_sub(1) / SPARSE > 3 * a.len() {
        let expected = canonical_triangles(a.iter().copied());
        return (expected == canonical_triangles(b())).then_some(expected.len());
    }
    #[cfg(feature = "rayon")]
    if a.len() >= SMALL {
        return same_in_parts(a, b, vertex_count as u32, rayon::current_num_threads().ilog2().min(PART_BITS));
    }
    TrianglePart { number: 0, bits: 0, vertex_count: vertex_count as u32 }.count_same(a, b())
}

/// Compares `1 << bits` parts of the vertices in parallel.
#[cfg(feature = "rayon")]
fn same_in_parts<I>(a: &[[u32; 3]], b: impl Fn() -> I + Sync, vertex_count: u32, bits: u32) -> Option<usize>
where
    I: Iterator<Item = [u32; 3]>,
{
    use rayon::prelude::*;
    let part = |number| TrianglePart { number, bits, vertex_count };
    (0..1_u32 << bits).into_par_iter().map(|number| part(number).count_same(a, b())).sum()
}

/// A part of the vertices: every `1 << bits`-th block from block `number` on, and the triangles
/// whose lowest vertices are in it.
#[derive(Debug, Clone, Copy)]
struct TrianglePart {
    number: u32,
    /// The binary logarithm of the number of parts.
    bits: u32,
    /// The number of vertices of all parts.
    vertex_count: u32,
}

impl TrianglePart {
    /// Returns the lowest vertex of a triangle, counted within this part, and the pair of the other
    /// two. Returns `None` for triangles of other parts and for degenerate ones.
    #[inline]
    fn keyed(self, [a, b, c]: [u32; 3]) -> Option<(u32, u64)> {
        let lowest = a.min(b).min(c);
        let pair = |b: u32, c: u32| u64::from(b) << 32 | u64::from(c);
        let others = if lowest == a { pair(b, c) } else { pair(c, a) };
        let others = if lowest == c { pair(a, b) } else { others };
        let block = lowest >> BLOCK_BITS;
        let key = block >> self.bits << BLOCK_BITS | lowest & ((1 << BLOCK_BITS) - 1);
        let is_here = block & ((1 << self.bits) - 1) == self.number;
        (is_here && !is_degenerate([a, b, c])).then_some((key, others))
    }

    /// Returns an upper bound of the keys.
    fn key_count(self) -> usize {
        let blocks = self.vertex_count.div_ceil(1 << BLOCK_BITS).div_ceil(1 << self.bits);
        ((blocks as usize) << BLOCK_BITS).min(self.vertex_count as usize)
    }

    /// Returns the number of triangles of this part, or `None` if the lists differ.
    fn count_same(self, a: &[[u32; 3]], mut b: impl Iterator<Item = [u32; 3]>) -> Option<usize> {
        let keyed = a.iter().filter_map(move |&triangle| self.keyed(triangle));
        let mut rows: Csr<u64> = Csr::group_items(keyed, self.key_count());
        let (mut count, mut in_long_rows) = (0, Vec::new());
        let all_found = b.all(|triangle| {
            let Some((key, pair)) = self.keyed(triangle) else { return true };
            if key as usize >= rows.key_count() {
                return false;
            }
            count += 1;
            let row = rows.row_mut(key);
            if row.len() > LONG_ROW {
                in_long_rows.push((key, pair));
                return true;
            }
            row.iter_mut().find(|slot| **slot == pair).map(|slot| *slot = TAKEN).is_some()
        });
        let is_same = all_found && count == rows.item_count() && is_same_in_long_rows(&rows, in_long_rows);
        is_same.then_some(count)
    }
}

/// Marks a pair that was removed. No triangle has it, because its two vertices are equal.
const TAKEN: u64 = u64::MAX;

/// Returns whether the long rows contain exactly the given pairs.
fn is_same_in_long_rows(rows: &Csr<u64>, mut pairs: Vec<(u32, u64)>) -> bool {
    let long = (0_u32..).zip(rows.rows()).filter(|(_, row)| row.len() > LONG_ROW);
    let mut expected: Vec<_> = long.flat_map(|(key, row)| row.iter().map(move |&pair| (key, pair))).collect();
    expected.sort_unstable();
    pairs.sort_unstable();
    expected == pairs
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
            let real = a.iter().filter(|&&triangle| !is_degenerate(triangle)).count();
            let expected = expected.then_some(real);
            prop_assert_eq!(same_triangles(&a, || b.iter().copied()), expected);
            #[cfg(feature = "rayon")]
            for bits in 0..3 {
                let vertex_count = vertex_bound(a.as_flattened()) as u32;
                prop_assert_eq!(same_in_parts(&a, || b.iter().copied(), vertex_count, bits), expected);
            }
        }
    }

    fn same(a: &[[u32; 3]], b: &[[u32; 3]]) -> Option<usize> {
        same_triangles(a, || b.iter().copied())
    }

    #[test]
    fn windings_and_numbers_of_triangles_count() {
        assert_eq!(same(&[[0, 1, 2], [5, 5, 6]], &[[1, 2, 0]]), Some(1));
        assert_eq!(same(&[[0, 1, 2]], &[[0, 2, 1]]), None);
        assert_eq!(same(&[[0, 1, 2], [0, 1, 2]], &[[0, 1, 2]]), None);
        assert_eq!(same(&[[0, 1, 2]], &[[0, 1, 2], [0, 1, 2]]), None);
        assert_eq!(same(&[], &[[3, 3, 3]]), Some(0));
        let beyond = u32::MAX;
        assert_eq!(same(&[[0, 1, 2]], &[[beyond - 1, beyond - 2, beyond]]), None);
    }

    #[test]
    fn vertices_of_many_triangles_are_compared_by_sorting() {
        let fan = |n: u32| (1..n).map(|i| [i + 1, 0, i]).collect::<Vec<_>>();
        let backward: Vec<_> = fan(100_000).into_iter().rev().collect();
        assert_eq!(same(&fan(100_000), &backward), Some(99_999));
        let mut other = backward;
        other[7] = other[8];
        assert_eq!(same(&fan(100_000), &other), None);
        let whole = LONG_ROW as u32;
        for n in whole..whole + 4 {
            assert_eq!(same(&fan(n), &fan(n)), Some(n as usize - 1));
            assert_eq!(same(&fan(n), &fan(n + 1)), None);
            assert_eq!(same(&fan(n + 1), &fan(n)), None);
        }
    }

    /// Compares lists of vertices in many blocks.
    #[test]
    fn every_block_belongs_to_one_part() {
        let a: Vec<_> = (0..70_000).map(|i| [i, i + 1, i + 2]).collect();
        assert_eq!(same(&a, &a), Some(a.len()));
        #[cfg(feature = "rayon")]
        for bits in 1..4 {
            let vertex_count = 70_002;
            assert_eq!(same_in_parts(&a, || a.iter().rev().copied(), vertex_count, bits), Some(a.len()));
            assert_eq!(same_in_parts(&a, || a.iter().skip(1).copied(), vertex_count, bits), None);
            let mut b = a.clone();
            b[40_000].swap(0, 1);
            assert_eq!(same_in_parts(&a, || b.iter().copied(), vertex_count, bits), None);
        }
    }
}
