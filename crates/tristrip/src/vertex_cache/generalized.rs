//! Generalized triangle meshes: a machine that receives vertices, and references to the last
//! vertices that it received.
//!
//! Its cache holds k vertices. A strip names one vertex per triangle (and two more at its start):
//! one that is in the cache by a reference of ⌈lg k⌉ bits, any other one by transmitting it; it
//! then enters the cache. The cost is the number of vertices transmitted; the bits of references
//! and swaps are counted separately.
//!
//! ```text
//!     3───4         strip     0 1 2   3     swap 1…        named: 0 1 2 3 4; swaps name nothing
//!     │ ╲ │         at hand   01 12   23    the two vertices of the edge over which the strip continues
//! 0───1───2         fifo:2    01 12   23    the same two: the machine of the first strips
//! ```
//!
//! # What the study specifies, and what it leaves open
//! Section 6 of the reference specifies: the cache holds k ≥ 2 vertices; a reference costs ⌈lg k⌉
//! bits, which its results do not include; FIFO never rearranges the cache except for swaps, which
//! exchange the two latest vertices; LRU makes a vertex that is used the most recent one; the cache
//! is flushed between two meshes. It leaves the following open, which this module decides so:
//!
//! - A mesh of the study is a strip: [`FlushPolicy::Flush`] flushes the cache between strips.
//!   [`FlushPolicy::Keep`] does not.
//! - The two vertices of the edge over which a strip continues are at hand, whether or not they are
//!   still in the cache, and need no reference. In a cache of two entries they are its contents.
//! - Naming a vertex is its only use: LRU does not make the vertices at hand more recent when
//!   triangles are drawn over them.
//! - A swap costs one bit. It exchanges the two vertices at hand in the order of eviction, with
//!   FIFO if both are still in the cache; with LRU the older one becomes the most recent. With two
//!   entries, or as long as nothing was named by reference, these are the two latest vertices. A
//!   vertex repeated immediately, as for the winding of a first triangle, changes nothing and costs
//!   nothing.
//!
//! # Relation to the GL cost
//! With two entries, FIFO or LRU, flushed, the number of vertices transmitted is
//! [`Metrics::gl_cost`](crate::strip::Metrics::gl_cost) for every strip of two vertices or more in
//! which no vertex except the first is repeated immediately: the cache and the vertices at hand are
//! then the same, and each real triangle names a third one. Strips that the library emits are of
//! this kind. A larger LRU cache never transmits more; a larger FIFO cache may.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996,
//! sections 1 and 6; Deering: *Geometry compression*, SIGGRAPH 1995 (generalized triangle meshes).
//!
//! # Complexity
//! O(1) per index, with the memory of one simulated vertex cache.

use super::policy::{FlushPolicy, VertexCache};
use super::simulator::VertexCacheSimulator;
use super::stream::VertexStream;
use crate::strip::{Strips, count_triangles};

/// The cost of sending strips as generalized triangle meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GeneralizedCost {
    /// Vertices transmitted: the cost in the studies of strips.
    pub transmitted: usize,
    /// Vertices named by a reference to the cache.
    pub references: usize,
    /// Bits of these references, ⌈lg k⌉ each for k entries.
    pub reference_bits: u64,
    /// Swaps, of one bit each.
    pub swaps: usize,
    /// Real triangles drawn.
    pub triangles: usize,
}

impl GeneralizedCost {
    /// Simulates strips with an initially empty cache.
    ///
    /// ```
    /// use tristrip::{Metrics, Strips};
    /// use tristrip::vertex_cache::{FlushPolicy, GeneralizedCost, VertexCache};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 1, 3, 1, 4, 1, 0]); // a fan around 1 that closes: three swaps
    /// let two = GeneralizedCost::of(&strips, VertexCache::fifo(2), FlushPolicy::Flush);
    /// assert_eq!((two.transmitted, two.swaps), (Metrics::of(&strips).gl_cost, 3));
    /// let eight = GeneralizedCost::of(&strips, VertexCache::fifo(8), FlushPolicy::Flush);
    /// assert_eq!((eight.transmitted, eight.references, eight.reference_bits), (5, 1, 3));
    /// ```
    pub fn of(strips: &Strips, cache: VertexCache, flush: FlushPolicy) -> Self {
        let sent = VertexStream::strips(strips);
        let mut simulator = VertexCacheSimulator::of(cache, sent.vertex_count);
        let mut cost = Self::default();
        sent.runs(FlushPolicy::Flush, |strip| {
            if flush == FlushPolicy::Flush {
                simulator.flush();
            }
            cost.triangles += count_triangles(strip);
            cost.send(strip, &mut simulator);
        });
        cost.transmitted = simulator.misses();
        cost.reference_bits = cost.references as u64 * u64::from(reference_bits(cache.entries));
        cost
    }

    fn send(&mut self, strip: &[u32], simulator: &mut VertexCacheSimulator) {
        let (mut older, mut newer) = (None, None);
        for &vertex in strip {
            if newer == Some(vertex) {
                continue;
            }
            if let (Some(first), Some(second)) = (older, newer)
                && first == vertex
            {
                self.swaps += 1;
                simulator.swap(first, second);
            } else {
                self.references += usize::from(simulator.receive(vertex));
            }
            (older, newer) = (newer, Some(vertex));
        }
    }
}

/// Sums the costs of parts that do not share vertices.
impl std::iter::Sum for GeneralizedCost {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |a, b| Self {
            transmitted: a.transmitted + b.transmitted,
            references: a.references + b.references,
            reference_bits: a.reference_bits + b.reference_bits,
            swaps: a.swaps + b.swaps,
            triangles: a.triangles + b.triangles,
        })
    }
}

/// Returns the number of bits of a reference to one of `entries`.
fn reference_bits(entries: u32) -> u32 {
    u32::BITS - entries.saturating_sub(1).leading_zeros()
}
