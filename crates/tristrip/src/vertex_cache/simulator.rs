//! A vertex cache of either replacement policy that receives vertices one at a time.

use super::fifo::Fifo;
use super::lru::Lru;
use super::policy::{Replacement, VertexCache};
use crate::error::Error;
use crate::ids::{check_count, index_out_of_range};

/// The state of a vertex cache that receives vertices one at a time.
///
/// ```
/// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
/// let mut cache = VertexCacheSimulator::new(VertexCache::fifo(2), 3)?;
/// let hits: Vec<bool> = [0, 1, 0, 2, 0].into_iter().map(|v| cache.send(v)).collect::<Result<_, _>>()?;
/// assert_eq!(hits, [false, false, true, false, false]);
/// assert_eq!(cache.misses(), 4);
///
/// let mut cache = VertexCacheSimulator::new(VertexCache::lru(2), 3)?;
/// let hits: Vec<bool> = [0, 1, 0, 2, 0].into_iter().map(|v| cache.send(v)).collect::<Result<_, _>>()?;
/// assert_eq!(hits, [false, false, true, false, true]);
/// assert!(cache.send(3).is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct VertexCacheSimulator {
    entries: Entries,
    vertex_count: usize,
}

#[derive(Debug, Clone)]
enum Entries {
    Fifo(Fifo<1>),
    Lru(Lru),
}

impl VertexCacheSimulator {
    /// Creates an empty cache for the vertices 0 to `vertex_count` − 1. The cache takes 4 bytes per
    /// vertex. Sizes above 2²⁸ entries are treated as 2²⁸.
    ///
    /// # Errors
    /// There are too many vertices for 32-bit indices or for the available memory.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
    /// // Without entries there are no hits.
    /// let mut cache = VertexCacheSimulator::new(VertexCache::fifo(0), 3)?;
    /// cache.send_all(&[2, 2, 2])?;
    /// assert_eq!(cache.misses(), 3);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn new(cache: VertexCache, vertex_count: usize) -> Result<Self, Error> {
        check_count("vertices", vertex_count)?;
        let (found, limit) = (vertex_count as u64, isize::MAX as u64 / 4);
        let reserved = Vec::<u32>::new().try_reserve_exact(vertex_count);
        reserved.map_err(|_| Error::LimitExceeded { what: "vertices in memory", found, limit })?;
        Ok(Self::of(cache, vertex_count))
    }

    /// Creates an empty cache. The caller must have checked that the vertices fit in memory.
    pub(super) fn of(cache: VertexCache, vertex_count: usize) -> Self {
        let entries = match cache.replacement {
            Replacement::Fifo => Entries::Fifo(Fifo::new([cache.entries], vertex_count)),
            Replacement::Lru => Entries::Lru(Lru::new(cache.entries, vertex_count)),
        };
        Self { entries, vertex_count }
    }

    /// Sends a vertex. Returns whether the vertex was in the cache.
    ///
    /// # Errors
    /// The vertex is not less than the number of vertices.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
    /// let mut cache = VertexCacheSimulator::new(VertexCache::fifo(2), 9)?;
    /// assert_eq!((cache.send(8)?, cache.send(8)?), (false, true));
    /// assert!(cache.send(9).is_err());
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn send(&mut self, vertex: u32) -> Result<bool, Error> {
        self.check(&[vertex])?;
        Ok(self.receive(vertex))
    }

    /// Sends vertices in order. Equivalent to [`send`](Self::send) for each vertex, but faster.
    ///
    /// # Errors
    /// A vertex is not less than the number of vertices. In this case, nothing is sent.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
    /// let mut cache = VertexCacheSimulator::new(VertexCache::fifo(2), 3)?;
    /// cache.send_all(&[0, 1, 0, 2, 0])?;
    /// assert!(cache.send_all(&[1, 3]).is_err());
    /// assert_eq!(cache.misses(), 4);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn send_all(&mut self, vertices: &[u32]) -> Result<(), Error> {
        self.check(vertices)?;
        self.receive_all(vertices);
        Ok(())
    }

    /// Checks that all vertices are less than the number of vertices.
    fn check(&self, vertices: &[u32]) -> Result<(), Error> {
        match vertices.iter().position(|&vertex| vertex as usize >= self.vertex_count) {
            Some(at) => Err(index_out_of_range(at, vertices[at], self.vertex_count)),
            None => Ok(()),
        }
    }

    /// Sends a vertex that is known to be in range. Returns whether the vertex was in the cache.
    pub(super) fn receive(&mut self, vertex: u32) -> bool {
        match &mut self.entries {
            Entries::Fifo(fifo) => fifo.send(vertex),
            Entries::Lru(lru) => lru.send(vertex),
        }
    }

    /// Sends vertices that are known to be in range, in order.
    pub(super) fn receive_all(&mut self, vertices: &[u32]) {
        match &mut self.entries {
            Entries::Fifo(fifo) => fifo.send_all(vertices),
            Entries::Lru(lru) => lru.send_all(vertices),
        }
    }

    /// Removes all vertices from the cache.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
    /// let mut cache = VertexCacheSimulator::new(VertexCache::lru(16), 3)?;
    /// cache.send_all(&[0, 1, 2, 0])?;
    /// cache.flush();
    /// assert_eq!((cache.send(0)?, cache.misses()), (false, 4));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn flush(&mut self) {
        match &mut self.entries {
            Entries::Fifo(fifo) => fifo.flush(),
            Entries::Lru(lru) => lru.flush(),
        }
    }

    /// Handles a swap of the two vertices of the edge over which a strip continues: they are
    /// exchanged in the order of eviction (FIFO), or the older one becomes the most recent (LRU).
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

    /// Counts the misses so far.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
    /// let mut cache = VertexCacheSimulator::new(VertexCache::lru(3), 5)?;
    /// cache.send_all(&[0, 1, 2, 0, 3, 1])?;
    /// assert_eq!(cache.misses(), 5);
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub fn misses(&self) -> usize {
        match &self.entries {
            Entries::Fifo(fifo) => fifo.misses()[0],
            Entries::Lru(lru) => lru.misses(),
        }
    }
}
