//! Vertex buffers that can take back what was sent for trial.

/// A vertex buffer under trial: what was sent after a mark can be undone.
pub(super) trait Trial {
    /// A state to come back to. Marks are undone in the opposite order, each as often as wanted.
    type Mark: Copy;

    /// Sends a vertex; tells whether it was missing.
    fn send(&mut self, vertex: u32) -> bool;

    /// Counts how far a vertex is from the buffer's young end: at least [`Trial::places`] where it is not in the buffer.
    fn age(&self, vertex: u32) -> u32;

    /// Gives the number of places.
    fn places(&self) -> u32;

    fn mark(&mut self) -> Self::Mark;

    /// Goes back to a mark.
    fn undo(&mut self, mark: Self::Mark);

    /// Forgets all marks.
    fn keep(&mut self);
}

/// First in, first out: each vertex knows the miss that brought it in.
#[derive(Debug)]
pub(super) struct FifoTrial {
    places: u32,
    misses: u32,
    entered: Vec<u32>,
    /// The vertices that were sent since the last [`Trial::keep`], and what was known of them before.
    log: Vec<(u32, u32)>,
}

impl FifoTrial {
    pub(super) fn new(places: u32, vertex_count: usize) -> Self {
        Self { places, misses: places, entered: vec![0; vertex_count], log: Vec::new() }
    }
}

impl Trial for FifoTrial {
    /// The length of the log, and the misses.
    type Mark = (usize, u32);

    /// Without a branch, which no processor could foresee: a hit writes what was there.
    #[inline]
    fn send(&mut self, vertex: u32) -> bool {
        let entered = &mut self.entered[vertex as usize];
        let is_missing = self.misses - *entered >= self.places;
        self.log.push((vertex, *entered));
        self.misses += u32::from(is_missing);
        *entered = if is_missing { self.misses } else { *entered };
        is_missing
    }

    #[inline]
    fn age(&self, vertex: u32) -> u32 {
        self.misses - self.entered[vertex as usize]
    }

    fn places(&self) -> u32 {
        self.places
    }

    fn mark(&mut self) -> (usize, u32) {
        (self.log.len(), self.misses)
    }

    #[inline]
    fn undo(&mut self, (len, misses): (usize, u32)) {
        for &(vertex, entered) in self.log[len..].iter().rev() {
            self.entered[vertex as usize] = entered;
        }
        self.log.truncate(len);
        self.misses = misses;
    }

    fn keep(&mut self) {
        self.log.clear();
    }
}

/// Least recently used: the vertices in a row, the youngest last. Buffers are small, so that a row is searched faster than any
/// structure is kept.
#[derive(Debug)]
pub(super) struct LruTrial {
    places: u32,
    row: Vec<u32>,
    /// Rows that were marked, one after the other.
    saved: Vec<u32>,
}

impl LruTrial {
    pub(super) fn new(places: u32) -> Self {
        Self { places, row: Vec::with_capacity(places as usize + 1), saved: Vec::new() }
    }
}

impl Trial for LruTrial {
    /// Where a saved row begins, and its length.
    type Mark = (usize, usize);

    #[inline]
    fn send(&mut self, vertex: u32) -> bool {
        if let Some(place) = self.row.iter().rposition(|&v| v == vertex) {
            self.row[place..].rotate_left(1);
            return false;
        }
        self.row.push(vertex);
        if self.row.len() > self.places as usize {
            self.row.remove(0);
        }
        true
    }

    #[inline]
    fn age(&self, vertex: u32) -> u32 {
        self.row.iter().rev().position(|&v| v == vertex).map_or(self.places, |age| age as u32)
    }

    fn places(&self) -> u32 {
        self.places
    }

    fn mark(&mut self) -> (usize, usize) {
        let start = self.saved.len();
        self.saved.extend_from_slice(&self.row);
        (start, self.row.len())
    }

    fn undo(&mut self, (start, len): (usize, usize)) {
        self.row.clear();
        self.row.extend_from_slice(&self.saved[start..start + len]);
        self.saved.truncate(start + len);
    }

    fn keep(&mut self) {
        self.saved.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vertex_cache::{VertexCache, VertexCacheSimulator};
    use proptest::prelude::*;

    fn misses_as_simulated(
        mut trial: impl Trial,
        buffer: VertexCache,
        sent: &[Vec<u32>],
    ) -> Result<(), TestCaseError> {
        let mut simulated = VertexCacheSimulator::new(buffer, 30);
        for (i, vertices) in sent.iter().enumerate() {
            let before = trial.mark();
            for &v in vertices {
                // Every second run is a trial, undone twice over.
                if i % 2 == 0 {
                    let is_in = trial.age(v) < trial.places();
                    prop_assert_eq!(!trial.send(v), is_in);
                    prop_assert_eq!(is_in, simulated.send(v));
                } else {
                    trial.send(v);
                    let inner = trial.mark();
                    trial.send(v / 2);
                    trial.undo(inner);
                }
            }
            if i % 2 == 1 {
                trial.undo(before);
            } else {
                trial.keep();
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn trials_are_the_simulators_and_leave_no_trace(
            sent in prop::collection::vec(prop::collection::vec(0..30_u32, 0..40), 0..12),
            places in 1..20_u32,
        ) {
            misses_as_simulated(FifoTrial::new(places, 30), VertexCache::fifo(places), &sent)?;
            misses_as_simulated(LruTrial::new(places), VertexCache::lru(places), &sent)?;
        }
    }
}
