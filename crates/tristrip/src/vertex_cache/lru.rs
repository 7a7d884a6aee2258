//! LRU caches: the least recently used vertex is evicted.
//!
//! ```text
//! log      4  7  4  9  7  2  9        sent vertices, the newest on the right
//!          ·  ·  4  ·  7  2  9        last uses only, in the order of eviction
//!                   ↑ tail            a cache of three entries has evicted 4
//! ```

use super::fifo::LARGEST_CACHE;

/// Minimum length of the log at which it is rewritten.
const LOG: usize = 1 << 12;

/// An LRU cache. The slot of the log in which a vertex was last sent is `last - base - 1`.
///
/// Invariant: the vertices whose `last` is after `base + tail` are in the cache. Their number is
/// `inside`, at most `entries`.
#[derive(Debug, Clone)]
pub(super) struct Lru {
    entries: usize,
    inside: usize,
    misses: usize,
    /// The time of the first slot of the log.
    base: u32,
    tail: usize,
    log: Vec<u32>,
    /// The time at which each vertex was last sent, counted from 1; 0 for never.
    last: Vec<u32>,
}

impl Lru {
    pub(super) fn new(entries: u32, vertex_count: usize) -> Self {
        let entries = (entries as usize).min(vertex_count).min(LARGEST_CACHE as usize);
        Self {
            entries,
            inside: 0,
            misses: 0,
            base: 0,
            tail: 0,
            log: Vec::with_capacity(LOG),
            last: vec![0; vertex_count],
        }
    }

    pub(super) fn send(&mut self, vertex: u32) -> bool {
        let before = self.misses;
        self.send_all(&[vertex]);
        self.misses == before
    }

    /// Sends vertices. Appends as many as fit to the log at once, then processes them.
    pub(super) fn send_all(&mut self, mut vertices: &[u32]) {
        while !vertices.is_empty() {
            if self.log.len() >= self.longest_log() {
                self.rewrite();
            }
            let free = self.longest_log() - self.log.len();
            let (block, later) = vertices.split_at(free.min(vertices.len()));
            let mut now = self.base + self.log.len() as u32;
            self.log.extend_from_slice(block);
            for &vertex in block {
                now += 1;
                let last = std::mem::replace(&mut self.last[vertex as usize], now);
                if last <= self.base + self.tail as u32 {
                    self.misses += 1;
                    self.inside += 1;
                    if self.inside > self.entries {
                        self.evict();
                    }
                }
            }
            vertices = later;
        }
    }

    pub(super) fn has(&self, vertex: u32) -> bool {
        self.last[vertex as usize] > self.base + self.tail as u32
    }

    pub(super) fn flush(&mut self) {
        self.tail = self.log.len();
        self.inside = 0;
    }

    pub(super) fn misses(&self) -> usize {
        self.misses
    }

    fn longest_log(&self) -> usize {
        LOG.max(3 * self.entries)
    }

    /// Advances the tail past the oldest last use.
    fn evict(&mut self) {
        self.inside -= 1;
        loop {
            let vertex = self.log[self.tail];
            self.tail += 1;
            if self.last[vertex as usize] == self.base + self.tail as u32 {
                return;
            }
        }
    }

    /// Rewrites the log with only the last uses of the vertices in the cache.
    fn rewrite(&mut self) {
        self.rewind_times();
        let mut kept = 0;
        let next = self.base + self.log.len() as u32;
        for i in self.tail..self.log.len() {
            let vertex = self.log[i];
            let last = &mut self.last[vertex as usize];
            if *last == self.base + i as u32 + 1 {
                self.log[kept] = vertex;
                kept += 1;
                *last = next + kept as u32;
            }
        }
        (self.base, self.tail) = (next, 0);
        self.log.truncate(kept);
    }

    /// Rewinds times before they overflow. Times of vertices in the cache are shifted; those of
    /// evicted vertices become 1.
    fn rewind_times(&mut self) {
        if self.base < u32::MAX - 3 * self.longest_log() as u32 {
            return;
        }
        let oldest = self.base + self.tail as u32;
        for last in &mut self.last {
            *last = if *last > oldest { *last - self.base + 1 } else { (*last).min(1) };
        }
        self.base = 1;
    }

    /// Sets the times close to overflow.
    #[cfg(test)]
    pub(super) fn with_late_times(mut self, left: u32) -> Self {
        self.base = u32::MAX - 3 * self.longest_log() as u32 - left;
        self.tail = 0;
        self
    }
}
