//! Generalized triangle meshes: a machine that receives vertices, and references to recently
//! received vertices.
//!
//! The cache of the machine holds k vertices. A strip names one vertex per triangle, and two more
//! at its start. A vertex in the cache is named by a reference of ⌈lg k⌉ bits; any other vertex is
//! transmitted and enters the cache. The cost is the number of vertices transmitted. The bits of
//! references and swaps are counted separately.
//!
//! ```text
//!     3───4         strip     0 1 2   3     swap 1…        named: 0 1 2 3 4; swaps name nothing
//!     │ ╲ │         at hand   01 12   23    the vertices of the edge where the strip continues
//! 0───1───2         fifo:2    01 12   23    the same two: the machine of the first strips
//! ```
//!
//! # What the study specifies and what it leaves open
//! Section 6 of the reference specifies the following. The cache holds k ≥ 2 vertices. A reference
//! costs ⌈lg k⌉ bits, which the results of the study do not include. FIFO never rearranges the
//! cache, except for swaps: a swap exchanges the two latest vertices. LRU makes a used vertex the
//! most recent one. The cache is flushed between meshes. This module decides the open points as
//! follows:
//!
//! - A mesh of the study is a strip: [`FlushPolicy::Flush`] flushes the cache between strips, and
//!   [`FlushPolicy::Keep`] does not.
//! - The two vertices of the edge over which a strip continues are *at hand*: they need no
//!   reference, whether or not they are still in the cache. A cache of two entries contains exactly
//!   these two vertices.
//! - A vertex is used only when it is named. LRU does not make the vertices at hand more recent
//!   when triangles are drawn with them.
//! - A swap costs one bit. With FIFO it exchanges the two vertices at hand in the order of eviction
//!   if both are still in the cache; with LRU the older one becomes the most recent. With two
//!   entries, or as long as nothing was named by reference, these are the two latest vertices. A
//!   vertex repeated immediately, for example for the winding of a first triangle, changes nothing
//!   and costs nothing.
//!
//! # Relation to the GL cost
//! With two entries, FIFO or LRU, and flushes, the number of vertices transmitted equals
//! [`Metrics::gl_cost`](crate::strip::Metrics::gl_cost) for every strip of at least two vertices in
//! which no vertex except the first is repeated immediately. The cache then contains exactly the
//! vertices at hand, and each triangle names a third one. The library emits only strips of this
//! kind. A larger LRU cache never transmits more; a larger FIFO cache may.
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

/// The cost of strips sent as generalized triangle meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GeneralizedCost {
    /// Number of vertices transmitted: the cost in the studies of strips.
    pub transmitted: usize,
    /// Number of vertices sent as references to the cache.
    pub references: usize,
    /// Number of bits of these references: ⌈lg k⌉ per reference for k entries.
    pub reference_bits: u64,
    /// Number of swaps; each takes one bit.
    pub swaps: usize,
    /// Number of triangles drawn, without degenerate ones.
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

/// Returns the number of bits of a reference to one of `entries` entries.
fn reference_bits(entries: u32) -> u32 {
    u32::BITS - entries.saturating_sub(1).leading_zeros()
}
