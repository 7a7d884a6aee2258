//! LRU caches of all sizes at once: one pass finds the smallest cache in which each index is a hit.
//!
//! An LRU cache of k entries holds the k distinct vertices sent last. A vertex is therefore a hit
//! for k entries if fewer than k other vertices were sent since its last use. That number is its
//! *stack distance*. The misses for every k follow from a histogram of distances. FIFO caches have
//! no such property: a larger cache may miss more.
//!
//! ```text
//! log    4  7  4  9  7  2  9
//! live   0  0  1  0  1  1  1       last uses; if 4 comes next, its distance is 3
//! ```
//!
//! # Algorithm
//! The live slots of the log are bits, 64 per word. A Fenwick tree counts the bits of the preceding
//! words. A full log is rewritten with only the live slots that can still be hits.
//!
//! # Complexity
//! O(log k) per index for the largest size k. 4 bytes per vertex and up to 17 per entry.

/// Minimum length of the log at which it is rewritten; a multiple of 64.
const LOG: usize = 1 << 12;

/// A histogram of the stack distances of the vertices sent.
#[derive(Debug)]
pub(super) struct Distances {
    /// Entry d counts the indices at distance d, up to the largest cache size.
    histogram: Vec<usize>,
    sent: usize,
    /// The time of the first slot of the log.
    base: u32,
    /// The slot of the log before which everything is flushed.
    flushed: usize,
    log: Vec<u32>,
    live: Bits,
    /// The time at which each vertex was last sent, counted from 1; 0 for never.
    last: Vec<u32>,
}

impl Distances {
    /// Creates empty caches of 1 to `largest` entries.
    pub(super) fn new(largest: usize, vertex_count: usize) -> Self {
        let capacity = LOG.max(3 * largest.min(vertex_count)).next_multiple_of(64);
        Self {
            histogram: vec![0; largest],
            sent: 0,
            base: 0,
            flushed: 0,
            log: Vec::with_capacity(capacity),
            live: Bits::new(capacity / 64),
            last: vec![0; vertex_count],
        }
    }

    pub(super) fn send_all(&mut self, vertices: &[u32]) {
        self.sent += vertices.len();
        for &vertex in vertices {
            self.send(vertex);
        }
    }

    fn send(&mut self, vertex: u32) {
        if self.log.len() == self.live.capacity() {
            self.rewrite();
        }
        let now = self.log.len();
        let last = &mut self.last[vertex as usize];
        if *last > self.base + self.flushed as u32 {
            let slot = (*last - self.base - 1) as usize;
            // The vertex was sent immediately before: distance 0, and the log stays the same.
            if slot + 1 == now {
                self.count(0);
                return;
            }
            let distance = self.live.after(slot);
            self.live.toggle(slot);
            *last = self.base + now as u32 + 1;
            self.count(distance);
        } else {
            *last = self.base + now as u32 + 1;
        }
        self.live.toggle(now);
        self.log.push(vertex);
    }

    fn count(&mut self, distance: usize) {
        if let Some(count) = self.histogram.get_mut(distance) {
            *count += 1;
        }
    }

    /// Removes all vertices from all caches.
    pub(super) fn flush(&mut self) {
        self.flushed = self.log.len();
    }

    /// Returns the misses of caches of 1, 2, … entries.
    pub(super) fn misses(&self) -> Vec<usize> {
        let mut misses = self.sent;
        let without = |hits| {
            misses -= hits;
            misses
        };
        self.histogram.iter().copied().map(without).collect()
    }

    /// Rewrites the log with the last uses of the vertices that can still be hits.
    fn rewrite(&mut self) {
        self.rewind_times();
        let (base, next) = (self.base, self.base + self.log.len() as u32);
        let last = &mut self.last;
        let mut kept: Vec<u32> = (self.flushed..self.log.len())
            .filter(|&i| last[self.log[i] as usize] == base + i as u32 + 1)
            .map(|i| self.log[i])
            .collect();
        kept.drain(..kept.len().saturating_sub(self.histogram.len()));
        self.live.clear();
        for (i, &vertex) in kept.iter().enumerate() {
            last[vertex as usize] = next + i as u32 + 1;
            self.live.toggle(i);
        }
        self.log.clear();
        self.log.extend_from_slice(&kept);
        (self.base, self.flushed) = (next, 0);
    }

    /// Rewinds times before they overflow.
    fn rewind_times(&mut self) {
        if self.base < u32::MAX - 3 * self.live.capacity() as u32 {
            return;
        }
        let flushed = self.base + self.flushed as u32;
        for last in &mut self.last {
            *last = if *last > flushed { *last - self.base + 1 } else { (*last).min(1) };
        }
        self.base = 1;
    }

    /// Sets the times close to overflow.
    #[cfg(test)]
    pub(super) fn with_late_times(mut self, left: u32) -> Self {
        self.base = u32::MAX - 3 * self.live.capacity() as u32 - left;
        self
    }
}

/// A bit set with fast counts of the bits that are set.
#[derive(Debug)]
struct Bits {
    words: Vec<u64>,
    /// A Fenwick tree: entry i counts the bits of the words that end at word i − 1. Their number is
    /// the lowest set bit of i.
    tree: Vec<u32>,
    set: u32,
}

impl Bits {
    fn new(words: usize) -> Self {
        Self { words: vec![0; words], tree: vec![0; words + 1], set: 0 }
    }

    fn capacity(&self) -> usize {
        64 * self.words.len()
    }

    fn clear(&mut self) {
        self.words.fill(0);
        self.tree.fill(0);
        self.set = 0;
    }

    fn toggle(&mut self, bit: usize) {
        let word = &mut self.words[bit / 64];
        *word ^= 1 << (bit % 64);
        let by = if *word >> (bit % 64) & 1 == 1 { 1 } else { u32::MAX };
        self.set = self.set.wrapping_add(by);
        let mut i = bit / 64 + 1;
        while let Some(count) = self.tree.get_mut(i) {
            *count = count.wrapping_add(by);
            i += i & i.wrapping_neg();
        }
    }

    /// Counts the set bits after a given bit.
    fn after(&self, bit: usize) -> usize {
        let word = bit / 64;
        let above = (self.words[word] >> (bit % 64) >> 1).count_ones();
        let (mut up_to, mut i) = (0, word + 1);
        while i > 0 {
            up_to += self.tree[i];
            i &= i - 1;
        }
        (above + self.set - up_to) as usize
    }
}
