//! Simulated vertex caches of a graphics processor: the number of vertices that it must transform
//! while strips or a list are drawn.
//!
//! A vertex that is in the cache when it is sent is a hit and costs nothing; any other is a miss
//! and enters the cache. Misses per real triangle are the ACMR, at best near 0.5 and 3 at worst;
//! misses per vertex in use are the ATVR, at best 1.
//!
//! ```text
//! sent          0  1  2  1  3  0        a strip with a swap, then its first vertex again
//! fifo:3        0  01 012 ·  123 230    the second 1 is a hit; 3 evicts 0; 0 evicts 1
//! lru:3         0  01 012 021 213 130   the hit makes 1 the most recent, so 2 is evicted before it
//! ```
//!
//! Strips are sent in order, swaps and winding repeats included; restarts and the degenerate
//! triangles between strips send nothing here. A processor keeps its cache from one strip of an
//! index buffer to the next ([`FlushPolicy::Keep`]); published studies of strips flush it
//! ([`FlushPolicy::Flush`]).
//!
//! [`VertexCacheStatistics`] measures strips or a list, with one cache or many; [`lru_profile`]
//! measures all LRU sizes; [`VertexCacheSimulator`] accepts one vertex after the other.
//! [`GeneralizedCost`] is a different machine, that of the first studies: it receives vertices and
//! references to its cache.
//!
//! # Algorithm
//! *First in, first out:* each vertex stores the number of the miss with which it entered. It has
//! been evicted once as many misses as the cache has entries have followed.
//!
//! *Least recently used:* each vertex stores the time at which it was sent last, in a log of what
//! was sent. A vertex is in the cache if that time is not before the tail of the log; the tail
//! advances until the number of vertices that were sent last at it or later is at most the number
//! of entries. Before the log grows beyond a few times the cache size, it is rewritten without the
//! vertices that were sent again since.
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
//! O(1) per index, for any cache size; 4 bytes per vertex in use, and for LRU up to 12 bytes per
//! entry. Many caches: 16 bytes per vertex for four FIFO caches, O(log k) per index for all LRU
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
