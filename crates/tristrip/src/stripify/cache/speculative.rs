//! Vertex caches whose accesses can be undone, for speculative simulation.
//!
//! The FIFO cache of the module `resettable_fifo` and the simulators of `vertex_cache` are
//! separate, because a shared mechanism would be slower. Here, each access logs the previous stamp
//! of the vertex, so undoing the access takes O(1). 32-bit stamps halve the memory traffic. In
//! `resettable_fifo`, a simulation starts from stored contents and needs the contents after it, so
//! only misses are logged; its clock advances at every start and needs 64 bits. The simulators of
//! `vertex_cache` count the misses of several caches in vector lanes and log nothing. The three
//! caches share only the comparison of a stamp with the clock.

/// A vertex cache in which accesses after a checkpoint can be undone.
pub(super) trait SpeculativeCache {
    /// A state to roll back to. Checkpoints are rolled back in reverse order, each any number of
    /// times.
    type Checkpoint: Copy;

    /// Looks up a vertex and loads it on a miss. Returns whether it was a miss.
    fn access(&mut self, vertex: u32) -> bool;

    /// Returns the age of a vertex: 0 for the newest, at least [`SpeculativeCache::entry_count`] if
    /// it is not in the cache.
    fn age(&self, vertex: u32) -> u32;

    /// Returns the number of entries.
    fn entry_count(&self) -> u32;

    /// Returns a checkpoint of the current state.
    fn checkpoint(&mut self) -> Self::Checkpoint;

    /// Rolls back to a checkpoint.
    fn roll_back(&mut self, checkpoint: Self::Checkpoint);

    /// Makes all accesses permanent and discards all checkpoints.
    fn commit(&mut self);
}

/// Maximum number of entries. Misses are counted from the number of entries, and must not overflow
/// on the largest mesh.
const MAX_ENTRIES: u32 = 1 << 30;

/// A FIFO cache. Each vertex stores the number of the miss that loaded it.
#[derive(Debug)]
pub(super) struct SpeculativeFifo {
    entry_count: u32,
    misses: u32,
    loaded_at: Vec<u32>,
    /// The vertices accessed since the last [`SpeculativeCache::commit`], with their previous
    /// `loaded_at`.
    log: Vec<(u32, u32)>,
}

impl SpeculativeFifo {
    /// Creates an empty cache. The number of entries is limited to [`MAX_ENTRIES`].
    pub(super) fn new(entry_count: u32, vertex_count: usize) -> Self {
        let entry_count = entry_count.min(MAX_ENTRIES);
        Self { entry_count, misses: entry_count, loaded_at: vec![0; vertex_count], log: Vec::new() }
    }
}

impl SpeculativeCache for SpeculativeFifo {
    /// The length of the log and the number of misses.
    type Checkpoint = (usize, u32);

    /// Avoids an unpredictable branch: a hit writes the old value again.
    #[inline]
    fn access(&mut self, vertex: u32) -> bool {
        let loaded_at = &mut self.loaded_at[vertex as usize];
        let is_miss = self.misses - *loaded_at >= self.entry_count;
        self.log.push((vertex, *loaded_at));
        self.misses += u32::from(is_miss);
        *loaded_at = if is_miss { self.misses } else { *loaded_at };
        is_miss
    }

    #[inline]
    fn age(&self, vertex: u32) -> u32 {
        self.misses - self.loaded_at[vertex as usize]
    }

    fn entry_count(&self) -> u32 {
        self.entry_count
    }

    fn checkpoint(&mut self) -> (usize, u32) {
        (self.log.len(), self.misses)
    }

    #[inline]
    fn roll_back(&mut self, (len, misses): (usize, u32)) {
        for &(vertex, loaded_at) in self.log[len..].iter().rev() {
            self.loaded_at[vertex as usize] = loaded_at;
        }
        self.log.truncate(len);
        self.misses = misses;
    }

    fn commit(&mut self) {
        self.log.clear();
    }
}

/// An LRU cache as a list of vertices, newest last. Caches are small, so a linear search is faster
/// than an index.
#[derive(Debug)]
pub(super) struct SpeculativeLru {
    entry_count: u32,
    entries: Vec<u32>,
    /// The entries at each checkpoint, concatenated.
    saved: Vec<u32>,
}

impl SpeculativeLru {
    /// Creates an empty cache.
    pub(super) fn new(entry_count: u32) -> Self {
        Self { entry_count, entries: Vec::with_capacity(entry_count as usize + 1), saved: Vec::new() }
    }
}

impl SpeculativeCache for SpeculativeLru {
    /// The start and number of the saved entries.
    type Checkpoint = (usize, usize);

    #[inline]
    fn access(&mut self, vertex: u32) -> bool {
        if let Some(position) = self.entries.iter().rposition(|&v| v == vertex) {
            self.entries[position..].rotate_left(1);
            return false;
        }
        self.entries.push(vertex);
        if self.entries.len() > self.entry_count as usize {
            self.entries.remove(0);
        }
        true
    }

    #[inline]
    fn age(&self, vertex: u32) -> u32 {
        self.entries.iter().rev().position(|&v| v == vertex).map_or(self.entry_count, |age| age as u32)
    }

    fn entry_count(&self) -> u32 {
        self.entry_count
    }

    fn checkpoint(&mut self) -> (usize, usize) {
        let start = self.saved.len();
        self.saved.extend_from_slice(&self.entries);
        (start, self.entries.len())
    }

    fn roll_back(&mut self, (start, len): (usize, usize)) {
        self.entries.clear();
        self.entries.extend_from_slice(&self.saved[start..start + len]);
        self.saved.truncate(start + len);
    }

    fn commit(&mut self) {
        self.saved.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertex_cache::{VertexCache, VertexCacheSimulator};
    use proptest::prelude::*;

    fn check_against_simulator(
        mut speculative: impl SpeculativeCache,
        vertex_cache: VertexCache,
        accesses: &[Vec<u32>],
    ) -> Result<(), TestCaseError> {
        let mut simulator = VertexCacheSimulator::new(vertex_cache, 30).unwrap();
        for (i, vertices) in accesses.iter().enumerate() {
            let before = speculative.checkpoint();
            for &v in vertices {
                // Every second run is speculative, with nested checkpoints.
                if i % 2 == 0 {
                    let is_hit = speculative.age(v) < speculative.entry_count();
                    prop_assert_eq!(!speculative.access(v), is_hit);
                    prop_assert_eq!(is_hit, simulator.send(v).unwrap());
                } else {
                    speculative.access(v);
                    let inner = speculative.checkpoint();
                    speculative.access(v / 2);
                    speculative.roll_back(inner);
                }
            }
            if i % 2 == 1 {
                speculative.roll_back(before);
            } else {
                speculative.commit();
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn misses_are_those_of_the_simulator_after_any_roll_back(
            accesses in prop::collection::vec(prop::collection::vec(0..30_u32, 0..40), 0..12),
            entry_count in 1..20_u32,
        ) {
            check_against_simulator(SpeculativeFifo::new(entry_count, 30), VertexCache::fifo(entry_count), &accesses)?;
            check_against_simulator(SpeculativeLru::new(entry_count), VertexCache::lru(entry_count), &accesses)?;
        }
    }
}
