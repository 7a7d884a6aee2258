//! Generalized triangle meshes: a machine that is sent vertices, and references to the last ones that it was sent.
//!
//! Its buffer holds k vertices. A strip names one vertex a triangle (and two more at its start): one that the buffer holds by a
//! reference of ⌈lg k⌉ bits, another one by transmitting it, whereupon it enters the buffer. The cost is the vertices
//! transmitted; the bits of references and swaps are counted apart.
//!
//! ```text
//!     3───4         strip     0 1 2   3     swap 1…        named: 0 1 2 3 4; swaps name nothing
//!     │ ╲ │         at hand   01 12   23    the two vertices of the edge over which the strip goes on
//! 0───1───2         fifo:2    01 12   23    the same two: the machine of the first strips
//! ```
//!
//! # What the study says, and what it leaves open
//! Section 6 of the reference says: the buffer holds k ≥ 2 vertices; a reference costs ⌈lg k⌉ bits, left out of its figures; FIFO
//! never rearranges the buffer but for swaps, which exchange the two latest vertices; LRU makes a vertex that is used the most
//! recent one; the buffer is flushed between two meshes. It does not say what follows, and is taken here to be so:
//!
//! - A mesh of the study is a strip: [`FlushPolicy::Flush`] empties the buffer between strips. [`FlushPolicy::Keep`] does not.
//! - The two vertices of the edge over which a strip goes on are at hand, whether or not they are still in the buffer, and need
//!   no reference. In a buffer of two they are what it holds.
//! - Naming a vertex is its only use: LRU does not make the vertices at hand more recent as triangles are drawn over them.
//! - A swap costs one bit. It exchanges the turns of the two vertices at hand, in FIFO where both are still in the buffer; in
//!   LRU the older one becomes the most recent. For a buffer of two, or while nothing was named by reference, these are the
//!   two latest. A vertex repeated at once, as for the winding of a first triangle, changes nothing and costs nothing.
//!
//! # Relation to the GL cost
//! With two places, FIFO or LRU, flushed, the vertices transmitted are [`Metrics::gl_cost`](crate::strip::Metrics::gl_cost)
//! for every strip of two vertices or more in which no vertex follows itself but the first one: buffer and vertices at hand
//! are then the same, and each real triangle names a third one. Strips that the library emits are of this kind. An LRU of more
//! places never transmits more; a FIFO may, as first in, first out does not keep what a smaller buffer would.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, sections 1 and 6; Deering: *Geometry
//! compression*, SIGGRAPH 1995 (generalized triangle meshes).
//!
//! # Complexity
//! O(1) an index, with the bytes of a vertex buffer.

use super::stream::{VertexStream, real_triangles};
use super::{FlushPolicy, VertexCache, VertexCacheSimulator};
use crate::strip::Strips;

/// What it costs to send strips as generalized triangle meshes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct GeneralizedCost {
    /// Vertices transmitted: the cost in the studies of strips.
    pub transmitted: usize,
    /// Vertices named by a reference to the buffer.
    pub references: usize,
    /// Bits of these references, ⌈lg k⌉ each for k places.
    pub reference_bits: u64,
    /// Swaps, of one bit each.
    pub swaps: usize,
    /// Real triangles drawn.
    pub triangles: usize,
}

impl GeneralizedCost {
    /// Sends strips over vertices 0 to `vertex_count` − 1, the buffer empty at first.
    ///
    /// # Panics
    /// A strip has a vertex that is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::{Strips, strip::Metrics, vertex_cache::{FlushPolicy, GeneralizedCost, VertexCache}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 1, 3, 1, 4, 1, 0]); // a fan around 1 that closes: three swaps
    /// let two = GeneralizedCost::of(&strips, VertexCache::fifo(2), FlushPolicy::Flush, 5);
    /// assert_eq!((two.transmitted, two.swaps), (Metrics::of(&strips).gl_cost, 3));
    /// let eight = GeneralizedCost::of(&strips, VertexCache::fifo(8), FlushPolicy::Flush, 5);
    /// assert_eq!((eight.transmitted, eight.references, eight.reference_bits), (5, 1, 3));
    /// ```
    pub fn of(strips: &Strips, buffer: VertexCache, between: FlushPolicy, vertex_count: usize) -> Self {
        let sent = VertexStream::strips(strips, vertex_count);
        let mut queue = VertexCacheSimulator::new(buffer, sent.vertex_count);
        let mut cost = Self::default();
        sent.runs(FlushPolicy::Flush, |strip| {
            if between == FlushPolicy::Flush {
                queue.flush();
            }
            cost.triangles += real_triangles(strip);
            cost.send(strip, &mut queue);
        });
        cost.transmitted = queue.misses();
        cost.reference_bits = cost.references as u64 * u64::from(bits(buffer.entries));
        cost
    }

    /// Divides the vertices transmitted by the real triangles; 0 where there is none.
    pub fn transmitted_per_triangle(&self) -> f64 {
        if self.triangles == 0 { 0.0 } else { self.transmitted as f64 / self.triangles as f64 }
    }

    fn send(&mut self, strip: &[u32], queue: &mut VertexCacheSimulator) {
        let (mut older, mut newer) = (None, None);
        for &vertex in strip {
            if newer == Some(vertex) {
                continue;
            }
            if let (Some(first), Some(second)) = (older, newer)
                && first == vertex
            {
                self.swaps += 1;
                queue.swap(first, second);
            } else {
                self.references += usize::from(queue.send(vertex));
            }
            (older, newer) = (newer, Some(vertex));
        }
    }
}

/// Sums what parts with vertices of their own cost.
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

/// Counts the bits that tell so many places apart.
fn bits(places: u32) -> u32 {
    u32::BITS - places.saturating_sub(1).leading_zeros()
}
