//! Buffers of every size at once, least recently used first: one pass finds how large each buffer would have to be for a hit.
//!
//! A buffer of k places holds the k different vertices sent last. So a vertex is a hit for k places when fewer than k others
//! were sent since its last time: that is its *stack distance*, and the number of misses for every k is a sum over a histogram
//! of distances. First in, first out has no such property: a larger buffer may miss more.
//!
//! ```text
//! log    4  7  4  9  7  2  9
//! live   0  0  1  0  1  1  1       last times; the next 4 is at distance 3: the live ones after its own
//! ```
//!
//! # Algorithm
//! The live places of the log are bits, 64 a word; how many are set in the words before each stands in a Fenwick tree. The log
//! is written anew with the live places alone, of these the last ones that count, when it is full.
//!
//! # Complexity
//! O(log k) an index for the largest k; 4 bytes a vertex and up to 17 a place.

/// Entries that the log has at least before it is written anew; a multiple of 64.
const LOG: usize = 1 << 12;

/// Counts the distances of vertices that are sent.
#[derive(Debug)]
pub(super) struct Distances {
    /// Entry d counts the indices at distance d, up to the most that counts.
    found: Vec<usize>,
    sent: usize,
    /// When the log begins.
    base: u32,
    /// The place of the log before which all is flushed.
    floor: usize,
    log: Vec<u32>,
    live: Bits,
    /// For each vertex when it was sent last, counted from 1; 0 for never.
    last: Vec<u32>,
}

impl Distances {
    /// Makes empty buffers of 1 to `most` places.
    pub(super) fn new(most: usize, vertex_count: usize) -> Self {
        let room = LOG.max(3 * most.min(vertex_count)).next_multiple_of(64);
        Self {
            found: vec![0; most],
            sent: 0,
            base: 0,
            floor: 0,
            log: Vec::with_capacity(room),
            live: Bits::new(room / 64),
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
        if self.log.len() == self.live.room() {
            self.rewrite();
        }
        let now = self.log.len();
        let last = &mut self.last[vertex as usize];
        if *last > self.base + self.floor as u32 {
            let place = (*last - self.base - 1) as usize;
            // The vertex sent last is its own nearest: nothing to count or move.
            if place + 1 == now {
                self.count(0);
                return;
            }
            let distance = self.live.after(place);
            self.live.toggle(place);
            *last = self.base + now as u32 + 1;
            self.count(distance);
        } else {
            *last = self.base + now as u32 + 1;
        }
        self.live.toggle(now);
        self.log.push(vertex);
    }

    fn count(&mut self, distance: usize) {
        if let Some(found) = self.found.get_mut(distance) {
            *found += 1;
        }
    }

    /// Empties all buffers.
    pub(super) fn flush(&mut self) {
        self.floor = self.log.len();
    }

    /// Gives the misses of buffers of 1, 2, … places.
    pub(super) fn misses(&self) -> Vec<usize> {
        let mut misses = self.sent;
        let less = |found| {
            misses -= found;
            misses
        };
        self.found.iter().copied().map(less).collect()
    }

    /// Begins a log that has the last times of the vertices that can still be hits.
    fn rewrite(&mut self) {
        self.make_room();
        let (base, next) = (self.base, self.base + self.log.len() as u32);
        let last = &mut self.last;
        let mut kept: Vec<u32> = (self.floor..self.log.len())
            .filter(|&i| last[self.log[i] as usize] == base + i as u32 + 1)
            .map(|i| self.log[i])
            .collect();
        kept.drain(..kept.len().saturating_sub(self.found.len()));
        self.live.clear();
        for (i, &vertex) in kept.iter().enumerate() {
            last[vertex as usize] = next + i as u32 + 1;
            self.live.toggle(i);
        }
        self.log.clear();
        self.log.extend_from_slice(&kept);
        (self.base, self.floor) = (next, 0);
    }

    /// Winds times back before they run over.
    fn make_room(&mut self) {
        if self.base < u32::MAX - 3 * self.live.room() as u32 {
            return;
        }
        let floor = self.base + self.floor as u32;
        for last in &mut self.last {
            *last = if *last > floor { *last - self.base + 1 } else { (*last).min(1) };
        }
        self.base = 1;
    }

    /// Makes the times run over soon.
    #[cfg(test)]
    pub(super) fn with_late_times(mut self, left: u32) -> Self {
        self.base = u32::MAX - 3 * self.live.room() as u32 - left;
        self
    }
}

/// Bits, and how many of them are set, by words.
#[derive(Debug)]
struct Bits {
    words: Vec<u64>,
    /// A Fenwick tree: entry i counts the bits of as many words as the lowest bit of i says, the last of them word i − 1.
    tree: Vec<u32>,
    set: u32,
}

impl Bits {
    fn new(words: usize) -> Self {
        Self { words: vec![0; words], tree: vec![0; words + 1], set: 0 }
    }

    fn room(&self) -> usize {
        64 * self.words.len()
    }

    fn clear(&mut self) {
        self.words.fill(0);
        self.tree.fill(0);
        self.set = 0;
    }

    fn toggle(&mut self, place: usize) {
        let word = &mut self.words[place / 64];
        *word ^= 1 << (place % 64);
        let by = if *word >> (place % 64) & 1 == 1 { 1 } else { u32::MAX };
        self.set = self.set.wrapping_add(by);
        let mut i = place / 64 + 1;
        while let Some(count) = self.tree.get_mut(i) {
            *count = count.wrapping_add(by);
            i += i & i.wrapping_neg();
        }
    }

    /// Counts the bits that are set after a place.
    fn after(&self, place: usize) -> usize {
        let word = place / 64;
        let above = (self.words[word] >> (place % 64) >> 1).count_ones();
        let (mut up_to, mut i) = (0, word + 1);
        while i > 0 {
            up_to += self.tree[i];
            i &= i - 1;
        }
        (above + self.set - up_to) as usize
    }
}
