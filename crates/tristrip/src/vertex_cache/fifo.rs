//! FIFO caches, one or several side by side.
//!
//! The speculative simulation of the method `cache` uses the same stamps but is separate. That
//! simulation logs every send to undo it later, has no lanes, and would become invalid if the clock
//! were rewound.

/// Maximum number of entries of a simulated cache. Clocks of 31 bits can count several times as
/// far.
pub(super) const LARGEST_CACHE: u32 = 1 << 28;

/// Number of vertices between two checks for the overflow of clocks.
const BLOCK: usize = 1 << 16;

/// Several caches that receive the same vertices.
///
/// A clock counts the misses of each cache. It starts at the number of entries, so a stamp of 0
/// (never) is expired from the start. Clocks and stamps are signed because SIMD instructions
/// compare signed integers.
///
/// Invariant: a vertex is in a cache if `clock - entered < entries`; `clock >= entries`.
#[derive(Debug, Clone)]
pub(super) struct Fifo<const LANES: usize> {
    entries: [i32; LANES],
    clocks: [i32; LANES],
    misses: [usize; LANES],
    /// The clocks after the misses at which each vertex entered.
    entered: Vec<[i32; LANES]>,
}

impl<const LANES: usize> Fifo<LANES> {
    pub(super) fn new(entries: [u32; LANES], vertex_count: usize) -> Self {
        // A cache with one entry per vertex never evicts. Limiting the entries to that makes
        // flushes advance the clocks less.
        let largest = vertex_count.min(LARGEST_CACHE as usize) as u32;
        let entries = entries.map(|entries| entries.min(largest).cast_signed());
        Self { entries, clocks: entries, misses: [0; LANES], entered: vec![[0; LANES]; vertex_count] }
    }

    /// Sends vertices without data-dependent branches.
    pub(super) fn send_all(&mut self, vertices: &[u32]) {
        for block in vertices.chunks(BLOCK) {
            self.rewind_clocks([(block.len() as u32).cast_signed(); LANES]);
            let (entries, before) = (self.entries, self.clocks);
            let mut clocks = before;
            let entered = self.entered.as_mut_slice();
            for &vertex in block {
                let stamps = &mut entered[vertex as usize];
                for lane in 0..LANES {
                    let miss = clocks[lane] - stamps[lane] >= entries[lane];
                    clocks[lane] += i32::from(miss);
                    stamps[lane] = if miss { clocks[lane] } else { stamps[lane] };
                }
            }
            self.clocks = clocks;
            for lane in 0..LANES {
                self.misses[lane] += (clocks[lane] - before[lane]).cast_unsigned() as usize;
            }
        }
    }

    pub(super) fn flush(&mut self) {
        self.rewind_clocks(self.entries);
        for lane in 0..LANES {
            self.clocks[lane] += self.entries[lane];
        }
    }

    pub(super) fn misses(&self) -> [usize; LANES] {
        self.misses
    }

    /// Rewinds clocks before they overflow. Stamps of vertices in the cache are shifted; those of
    /// evicted vertices become 1.
    fn rewind_clocks(&mut self, more: [i32; LANES]) {
        for lane in 0..LANES {
            if self.clocks[lane] <= i32::MAX - more[lane] {
                continue;
            }
            let oldest = self.clocks[lane] - self.entries[lane];
            for stamps in &mut self.entered {
                let stamp = &mut stamps[lane];
                *stamp = if *stamp > oldest { *stamp - oldest + 1 } else { (*stamp).min(1) };
            }
            self.clocks[lane] = self.entries[lane] + 1;
        }
    }

    /// Sets the clocks close to overflow.
    #[cfg(test)]
    pub(super) fn with_late_clocks(mut self, left: i32) -> Self {
        self.clocks = [i32::MAX - left; LANES];
        self
    }
}

/// A single cache.
impl Fifo<1> {
    pub(super) fn send(&mut self, vertex: u32) -> bool {
        let before = self.misses;
        self.send_all(&[vertex]);
        self.misses == before
    }

    pub(super) fn has(&self, vertex: u32) -> bool {
        self.clocks[0] - self.entered[vertex as usize][0] < self.entries[0]
    }

    /// Exchanges two vertices in the order of eviction if both are in the cache.
    pub(super) fn exchange(&mut self, a: u32, b: u32) {
        if self.has(a) && self.has(b) {
            self.entered.swap(a as usize, b as usize);
        }
    }
}
