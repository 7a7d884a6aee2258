//! Buffers that their vertices leave in the order in which they came in, one or several side by side.

/// The most places that a simulated buffer has: clocks of 31 bits have room for several times as many.
pub(super) const MOST_PLACES: u32 = 1 << 28;

/// Vertices sent between two looks at whether the clocks still have room.
const BLOCK: usize = 1 << 16;

/// Several buffers that are sent the same vertices.
///
/// Misses of each are counted by a clock that starts at its `places`, so that a stamp of 0, which says never, is too old from
/// the start. Clocks and stamps are signed, as vector instructions compare them.
///
/// Invariant: a vertex is in a buffer when `clock - entered < places`; `clock >= places`.
#[derive(Debug, Clone)]
pub(super) struct Fifo<const LANES: usize> {
    places: [i32; LANES],
    clocks: [i32; LANES],
    misses: [usize; LANES],
    /// For each vertex what the clocks showed after the misses that brought it in.
    entered: Vec<[i32; LANES]>,
}

impl<const LANES: usize> Fifo<LANES> {
    pub(super) fn new(places: [u32; LANES], vertex_count: usize) -> Self {
        // No vertex leaves a buffer that has a place for each; small steps of a flush spare the clocks.
        let most = vertex_count.min(MOST_PLACES as usize) as u32;
        let places = places.map(|places| places.min(most).cast_signed());
        Self { places, clocks: places, misses: [0; LANES], entered: vec![[0; LANES]; vertex_count] }
    }

    /// Sends vertices without a branch that depends on them.
    pub(super) fn send_all(&mut self, vertices: &[u32]) {
        for block in vertices.chunks(BLOCK) {
            self.make_room([(block.len() as u32).cast_signed(); LANES]);
            let (places, before) = (self.places, self.clocks);
            let mut clocks = before;
            let entered = self.entered.as_mut_slice();
            for &vertex in block {
                let stamps = &mut entered[vertex as usize];
                for lane in 0..LANES {
                    let miss = clocks[lane] - stamps[lane] >= places[lane];
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
        self.make_room(self.places);
        for lane in 0..LANES {
            self.clocks[lane] += self.places[lane];
        }
    }

    pub(super) fn misses(&self) -> [usize; LANES] {
        self.misses
    }

    /// Winds clocks back before they run over: stamps of what is inside move with them, those of what has left become 1.
    fn make_room(&mut self, more: [i32; LANES]) {
        for lane in 0..LANES {
            if self.clocks[lane] <= i32::MAX - more[lane] {
                continue;
            }
            let oldest = self.clocks[lane] - self.places[lane];
            for stamps in &mut self.entered {
                let stamp = &mut stamps[lane];
                *stamp = if *stamp > oldest { *stamp - oldest + 1 } else { (*stamp).min(1) };
            }
            self.clocks[lane] = self.places[lane] + 1;
        }
    }

    /// Makes the clocks run over soon.
    #[cfg(test)]
    pub(super) fn with_late_clocks(mut self, left: i32) -> Self {
        self.clocks = [i32::MAX - left; LANES];
        self
    }
}

/// One buffer.
impl Fifo<1> {
    pub(super) fn send(&mut self, vertex: u32) -> bool {
        let before = self.misses;
        self.send_all(&[vertex]);
        self.misses == before
    }

    pub(super) fn has(&self, vertex: u32) -> bool {
        self.clocks[0] - self.entered[vertex as usize][0] < self.places[0]
    }

    /// Lets two vertices exchange their turns to leave, where both are in the buffer.
    pub(super) fn exchange(&mut self, a: u32, b: u32) {
        if self.has(a) && self.has(b) {
            self.entered.swap(a as usize, b as usize);
        }
    }
}
