//! A buffer that its vertices leave in the order in which they came in.

/// The most places that a simulated buffer has: clocks of 32 bits have room for several times as many.
pub(super) const MOST_PLACES: u32 = 1 << 28;

/// Vertices sent between two looks at whether the clock still has room.
const BLOCK: usize = 1 << 16;

/// Misses are counted by a clock that starts at `places`, so that a stamp of 0, which says never, is too old from the start.
///
/// Invariant: a vertex is in the buffer when `clock - entered < places`; `clock >= places`.
#[derive(Debug, Clone)]
pub(super) struct Fifo {
    places: u32,
    clock: u32,
    misses: usize,
    /// For each vertex what the clock showed after the miss that brought it in.
    entered: Vec<u32>,
}

impl Fifo {
    pub(super) fn new(places: u32, vertex_count: usize) -> Self {
        let places = places.min(MOST_PLACES);
        Self { places, clock: places, misses: 0, entered: vec![0; vertex_count] }
    }

    pub(super) fn send(&mut self, vertex: u32) -> bool {
        let before = self.misses;
        self.send_all(&[vertex]);
        self.misses == before
    }

    /// Sends vertices without a branch that depends on them.
    pub(super) fn send_all(&mut self, vertices: &[u32]) {
        for block in vertices.chunks(BLOCK) {
            self.make_room(block.len() as u32);
            let (places, before) = (self.places, self.clock);
            let mut clock = before;
            let entered = self.entered.as_mut_slice();
            for &vertex in block {
                let stamp = &mut entered[vertex as usize];
                let miss = clock - *stamp >= places;
                clock += u32::from(miss);
                *stamp = if miss { clock } else { *stamp };
            }
            self.clock = clock;
            self.misses += (clock - before) as usize;
        }
    }

    pub(super) fn flush(&mut self) {
        self.make_room(self.places);
        self.clock += self.places;
    }

    pub(super) fn misses(&self) -> usize {
        self.misses
    }

    /// Winds the clock back before it runs over: stamps of what is inside move with it, those of what has left become 1.
    fn make_room(&mut self, more: u32) {
        if self.clock <= u32::MAX - more {
            return;
        }
        let oldest = self.clock - self.places;
        for stamp in &mut self.entered {
            *stamp = if *stamp > oldest { *stamp - oldest + 1 } else { (*stamp).min(1) };
        }
        self.clock = self.places + 1;
    }

    /// Makes the clock run over soon.
    #[cfg(test)]
    pub(super) fn with_late_clock(mut self, left: u32) -> Self {
        self.clock = u32::MAX - left;
        self
    }
}
