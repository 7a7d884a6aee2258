//! A FIFO vertex cache that can be set to any contents, for order annealing.
//!
//! The module `speculative` explains why this cache is separate from the FIFO cache there.

/// Marks an unused entry in stored contents.
const EMPTY: u32 = u32::MAX;

/// A FIFO vertex cache. Contents are stored as one vertex per entry, the newest last.
#[derive(Debug)]
pub(super) struct ResettableFifo {
    entry_count: u64,
    /// The clock at the miss that loaded each vertex. The clock never decreases, so nothing needs
    /// to be cleared.
    loaded_at: Vec<u64>,
    clock: u64,
    /// The loaded vertices, newest last.
    log: Vec<u32>,
}

impl ResettableFifo {
    /// Creates an empty cache.
    pub(super) fn new(entry_count: usize, vertex_count: usize) -> Self {
        let clock = entry_count as u64;
        let loaded_at = vec![0; vertex_count];
        Self { entry_count: entry_count as u64, loaded_at, clock, log: vec![EMPTY; entry_count] }
    }

    /// Sets the cache to stored contents.
    pub(super) fn set(&mut self, contents: &[u32]) {
        self.clock += self.entry_count;
        self.log.clear();
        for &vertex in contents {
            self.clock += 1;
            self.log.push(vertex);
            if vertex != EMPTY {
                self.loaded_at[vertex as usize] = self.clock;
            }
        }
    }

    /// Looks up vertices in order and loads them on misses. Returns the number of misses.
    pub(super) fn access(&mut self, vertices: &[u32]) -> u32 {
        let before = self.clock;
        for &vertex in vertices {
            let loaded_at = &mut self.loaded_at[vertex as usize];
            if self.clock - *loaded_at >= self.entry_count {
                self.clock += 1;
                *loaded_at = self.clock;
                self.log.push(vertex);
            }
        }
        (self.clock - before) as u32
    }

    /// Returns the contents.
    pub(super) fn contents(&self) -> &[u32] {
        &self.log[self.log.len() - self.entry_count as usize..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertex_cache::{VertexCache, VertexCacheSimulator};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn stored_contents_continue_the_simulation(
            accesses in prop::collection::vec(prop::collection::vec(0..30_u32, 0..40), 0..12),
            entry_count in 1..20_u32,
        ) {
            let mut simulator = VertexCacheSimulator::new(VertexCache::fifo(entry_count), 30).unwrap();
            let mut fifo = ResettableFifo::new(entry_count as usize, 30);
            for vertices in &accesses {
                let contents = fifo.contents().to_vec();
                fifo.access(&[29, 3, 17]);
                fifo.set(&contents);
                prop_assert_eq!(fifo.contents(), &contents[..]);
                let misses = vertices.iter().filter(|&&v| !simulator.send(v).unwrap()).count();
                prop_assert_eq!(fifo.access(vertices) as usize, misses);
            }
        }
    }
}
