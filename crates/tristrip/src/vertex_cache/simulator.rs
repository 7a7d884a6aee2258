//! A vertex cache of either replacement policy, for vertices that are sent one by one.

use super::fifo::Fifo;
use super::lru::Lru;
use super::policy::{Replacement, VertexCache};

/// The state of a vertex cache, for vertices that are sent one by one.
///
/// ```
/// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
/// let mut cache = VertexCacheSimulator::new(VertexCache::fifo(2), 3);
/// let hits: Vec<bool> = [0, 1, 0, 2, 0].into_iter().map(|v| cache.send(v)).collect();
/// assert_eq!(hits, [false, false, true, false, false]);
/// assert_eq!(cache.misses(), 4);
///
/// let mut cache = VertexCacheSimulator::new(VertexCache::lru(2), 3);
/// let hits: Vec<bool> = [0, 1, 0, 2, 0].into_iter().map(|v| cache.send(v)).collect();
/// assert_eq!(hits, [false, false, true, false, true]);
/// ```
#[derive(Debug, Clone)]
pub struct VertexCacheSimulator {
    entries: Entries,
}

#[derive(Debug, Clone)]
enum Entries {
    Fifo(Fifo<1>),
    Lru(Lru),
}

impl VertexCacheSimulator {
    /// Creates an empty cache for vertices 0 to `vertex_count` − 1. More than 2²⁸ entries count as 2²⁸.
    pub fn new(cache: VertexCache, vertex_count: usize) -> Self {
        let entries = match cache.replacement {
            Replacement::Fifo => Entries::Fifo(Fifo::new([cache.entries], vertex_count)),
            Replacement::Lru => Entries::Lru(Lru::new(cache.entries, vertex_count)),
        };
        Self { entries }
    }

    /// Sends a vertex. Returns whether it was in the cache.
    ///
    /// # Panics
    /// The vertex is not less than the number of vertices.
    pub fn send(&mut self, vertex: u32) -> bool {
        match &mut self.entries {
            Entries::Fifo(fifo) => fifo.send(vertex),
            Entries::Lru(lru) => lru.send(vertex),
        }
    }

    /// Sends vertices in order; the same as [`send`](Self::send) for each, but faster.
    ///
    /// # Panics
    /// A vertex is not less than the number of vertices.
    pub fn send_all(&mut self, vertices: &[u32]) {
        match &mut self.entries {
            Entries::Fifo(fifo) => fifo.send_all(vertices),
            Entries::Lru(lru) => lru.send_all(vertices),
        }
    }

    /// Removes all vertices from the cache.
    pub fn flush(&mut self) {
        match &mut self.entries {
            Entries::Fifo(fifo) => fifo.flush(),
            Entries::Lru(lru) => lru.flush(),
        }
    }

    /// Swaps the two vertices of the edge over which a strip continues: the older one takes the place of the newer one in the order of
    /// eviction.
    pub(super) fn swap(&mut self, older: u32, newer: u32) {
        match &mut self.entries {
            Entries::Fifo(fifo) => fifo.exchange(older, newer),
            Entries::Lru(lru) => {
                if lru.has(older) {
                    lru.send(older);
                }
            }
        }
    }

    /// Counts the vertices that were not in the cache when they were sent.
    pub fn misses(&self) -> usize {
        match &self.entries {
            Entries::Fifo(fifo) => fifo.misses()[0],
            Entries::Lru(lru) => lru.misses(),
        }
    }
}
