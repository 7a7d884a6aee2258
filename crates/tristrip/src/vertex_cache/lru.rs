//! A buffer that the vertex leaves which was not sent for the longest time.
//!
//! ```text
//! log      4  7  4  9  7  2  9        what was sent, the newest at the right
//!          ·  ·  4  ·  7  2  9        last times only: from left to right the order in which vertices leave
//!                   ↑ tail            in a buffer of three places, 4 has left
//! ```

use super::fifo::MOST_PLACES;

/// Entries that the log has at least before it is written anew.
const LOG: usize = 1 << 12;

/// A vertex was sent last at the place of the log that its stamp names: `stamp - base - 1`.
///
/// Invariant: those with stamps after `base + tail` are in the buffer; they are `inside`, at most `places`.
#[derive(Debug, Clone)]
pub(super) struct Lru {
    places: usize,
    inside: usize,
    misses: usize,
    /// When the log begins.
    base: u32,
    tail: usize,
    log: Vec<u32>,
    /// For each vertex when it was sent last, counted from 1; 0 for never.
    last: Vec<u32>,
}

impl Lru {
    pub(super) fn new(places: u32, vertex_count: usize) -> Self {
        let places = (places as usize).min(vertex_count).min(MOST_PLACES as usize);
        Self {
            places,
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

    /// Sends vertices; as many as the log has room for enter it together, and are looked at afterwards.
    pub(super) fn send_all(&mut self, mut vertices: &[u32]) {
        while !vertices.is_empty() {
            if self.log.len() >= self.longest_log() {
                self.rewrite();
            }
            let room = self.longest_log() - self.log.len();
            let (block, later) = vertices.split_at(room.min(vertices.len()));
            let mut now = self.base + self.log.len() as u32;
            self.log.extend_from_slice(block);
            for &vertex in block {
                now += 1;
                let last = std::mem::replace(&mut self.last[vertex as usize], now);
                if last <= self.base + self.tail as u32 {
                    self.misses += 1;
                    self.inside += 1;
                    if self.inside > self.places {
                        self.drive_out();
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
        LOG.max(3 * self.places)
    }

    /// Moves the tail past the oldest last time.
    fn drive_out(&mut self) {
        self.inside -= 1;
        loop {
            let vertex = self.log[self.tail];
            self.tail += 1;
            if self.last[vertex as usize] == self.base + self.tail as u32 {
                return;
            }
        }
    }

    /// Begins a log that has the last times of what is inside and nothing else.
    fn rewrite(&mut self) {
        self.make_room();
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

    /// Winds times back before they run over: what is inside moves, what has left becomes 1.
    fn make_room(&mut self) {
        if self.base < u32::MAX - 3 * self.longest_log() as u32 {
            return;
        }
        let oldest = self.base + self.tail as u32;
        for last in &mut self.last {
            *last = if *last > oldest { *last - self.base + 1 } else { (*last).min(1) };
        }
        self.base = 1;
    }
    /// Makes the times run over soon.
    #[cfg(test)]
    pub(super) fn with_late_times(mut self, left: u32) -> Self {
        self.base = u32::MAX - 3 * self.longest_log() as u32 - left;
        self.tail = 0;
        self
    }
}
