//! Simulates the vertex cache of a GPU and counts the vertices that must be transformed to draw
//! strips or a list.
//!
//! A vertex that is in the cache when it is sent is a hit and costs nothing. Any other vertex is a
//! miss and enters the cache. Misses per triangle are the ACMR, from about 0.5 (best) to 3 (worst).
//! Misses per vertex in use are the ATVR, at best 1.
//!
//! ```text
//! sent          0  1  2  1  3  0        a strip with a swap, then its first vertex again
//! fifo:3        0  01 012 ·  123 230    the second 1 is a hit; 3 evicts 0; 0 evicts 1
//! lru:3         0  01 012 021 213 130   after the hit 1 is the most recent, so 2 is evicted first
//! ```
//!
//! Strips are sent in order, including swaps and winding repeats. In this simulation, restarts and
//! the degenerate triangles between strips send nothing. A GPU keeps its cache between the strips
//! of one index buffer ([`FlushPolicy::Keep`]); published studies of strips flush it
//! ([`FlushPolicy::Flush`]).
//!
//! [`VertexCacheStatistics`] measures strips or a list, with one cache or many. [`lru_profile`]
//! measures all LRU sizes. [`VertexCacheSimulator`] receives vertices one at a time.
//! [`GeneralizedCost`] models the machine of the first studies, which receives vertices and
//! references to its cache.
//!
//! # Algorithm
//! *FIFO:* each vertex stores the number of the miss at which it entered. It is evicted after as
//! many further misses as the cache has entries.
//!
//! *LRU:* each vertex stores the time at which it was last sent, as a position in a log of sent
//! vertices. A vertex is in the cache if that time is not before the tail of the log. The tail
//! advances until the number of vertices last sent at or after it is at most the number of entries.
//! Before the log grows beyond a few times the cache size, it is rewritten without the vertices
//! that were sent again later.
//!
//! Many caches are not simulated one by one: FIFO caches run side by side, and all LRU caches are
//! evaluated in one pass by stack distances.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996,
//! section 6. Mattson, Gecsei, Slutz, Traiger: *Evaluation techniques for storage hierarchies*, IBM
//! Systems Journal, 1970 (stack distances).
//!
//! # Complexity
//! O(1) per index for any cache size. 4 bytes per vertex in use, and for LRU up to 12 bytes per
//! entry. Many caches: 16 bytes per vertex for four FIFO caches, and O(log k) per index for all LRU
//! caches of up to k entries.

mod distances;
mod fifo;
mod generalized;
mod lru;
mod policy;
mod simulator;
mod statistics;
mod stream;

pub use generalized::GeneralizedCost;
pub use policy::{FlushPolicy, Replacement, VertexCache};
pub use simulator::VertexCacheSimulator;
pub use statistics::{VertexCacheStatistics, lru_profile};

#[cfg(test)]
mod tests;
