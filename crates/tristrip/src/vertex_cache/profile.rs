//! One buffer strip by strip, and many buffers in few passes.

use super::distances::Distances;
use super::fifo::Fifo;
use super::stream::{VertexStream, real_triangles};
use super::{FlushPolicy, Replacement, VertexCache, VertexCacheSimulator, VertexCacheStatistics};
use crate::strip::Strips;

/// Buffers, first in, first out, that are simulated side by side: a vector register of stamps. Eight are no faster on bunny, and
/// slower on dragon, whose stamps leave the caches then.
const LANES: usize = 4;

/// Sizes asked for from which on one pass over distances is faster than one pass each, on bunny and dragon.
const SIZES: usize = 4;

/// What one strip costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StripCacheStatistics {
    /// Vertices sent, swaps and winding repeats included.
    pub length: usize,
    /// Real triangles drawn.
    pub triangles: usize,
    /// Vertices that were not in the buffer when they were sent.
    pub misses: usize,
}

impl StripCacheStatistics {
    /// Draws strips as [`VertexCacheStatistics::of`] does; gives what each costs, in their order.
    ///
    /// # Panics
    /// A strip has a vertex that is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::{Strips, vertex_cache::{FlushPolicy, StripCacheStatistics, VertexCache}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[2, 3, 4]);
    /// let each = StripCacheStatistics::of(&strips, VertexCache::fifo(16), FlushPolicy::Keep, 5);
    /// assert_eq!(each[1], StripCacheStatistics { length: 3, triangles: 1, misses: 1 });
    /// ```
    pub fn of(strips: &Strips, buffer: VertexCache, between: FlushPolicy, vertex_count: usize) -> Vec<Self> {
        let sent = VertexStream::strips(strips, vertex_count);
        let mut queue = VertexCacheSimulator::new(buffer, sent.vertex_count);
        let mut each = Vec::with_capacity(strips.len());
        sent.runs(FlushPolicy::Flush, |strip| {
            if between == FlushPolicy::Flush {
                queue.flush();
            }
            let before = queue.misses();
            queue.send_all(strip);
            let misses = queue.misses() - before;
            each.push(Self { length: strip.len(), triangles: real_triangles(strip), misses });
        });
        each
    }
}

/// Counts the misses of buffers of 1 to `most` places, least recently used first, in one pass; entry i is for i + 1 places, and
/// as no entry is larger than the one before it, `most` above [`VertexCache::MAX_ENTRIES`] counts as so many.
///
/// # Panics
/// A strip has a vertex that is not less than `vertex_count`.
///
/// ```
/// use tristrip::{Strips, vertex_cache::{FlushPolicy, lru_profile}};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 0]);
/// assert_eq!(lru_profile(&strips, 5, FlushPolicy::Keep, 4), [5, 5, 5, 4, 4]);
/// ```
pub fn lru_profile(strips: &Strips, most: u32, between: FlushPolicy, vertex_count: usize) -> Vec<usize> {
    VertexStream::strips(strips, vertex_count).lru_profile(most.min(VertexCache::MAX_ENTRIES), between)
}

impl VertexCacheStatistics {
    /// Draws strips with each of several buffers, as [`VertexCacheStatistics::of`] does but faster; gives them in the buffers' order.
    ///
    /// Sizes of LRU come from one pass by stack distances. FIFO buffers are simulated four at a time.
    ///
    /// # Panics
    /// A strip has a vertex that is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::{Strips, vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3, 0]);
    /// let buffers = [VertexCache::fifo(3), VertexCache::fifo(4), VertexCache::lru(4)];
    /// let misses = VertexCacheStatistics::of_each(&strips, &buffers, FlushPolicy::Keep, 4).iter().map(|used| used.misses).collect::<Vec<_>>();
    /// assert_eq!(misses, [5, 4, 4]);
    /// ```
    pub fn of_each(
        strips: &Strips,
        buffers: &[VertexCache],
        between: FlushPolicy,
        vertex_count: usize,
    ) -> Vec<Self> {
        VertexStream::strips(strips, vertex_count).with_each(buffers, between)
    }

    /// Draws a triangle list with each of several buffers, as [`VertexCacheStatistics::of_list`] does but faster; gives them in the buffers'
    /// order.
    ///
    /// # Panics
    /// An index is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheStatistics};
    /// let buffers = [VertexCache::fifo(1), VertexCache::lru(2)];
    /// let used = VertexCacheStatistics::of_list_each(&[0, 1, 2, 2, 1, 3], &buffers, 4);
    /// assert_eq!((used[0].misses, used[1].misses), (5, 4));
    /// ```
    pub fn of_list_each(indices: &[u32], buffers: &[VertexCache], vertex_count: usize) -> Vec<Self> {
        VertexStream::list(indices, vertex_count).with_each(buffers, FlushPolicy::Keep)
    }
}

impl VertexStream<'_> {
    fn with_each(&self, buffers: &[VertexCache], between: FlushPolicy) -> Vec<VertexCacheStatistics> {
        let mut misses = vec![0; buffers.len()];
        let of = |replacement| {
            let numbered = buffers.iter().enumerate();
            numbered.filter(move |(_, buffer)| buffer.replacement == replacement).collect::<Vec<_>>()
        };
        for lanes in of(Replacement::Fifo).chunks(LANES) {
            let places = std::array::from_fn(|lane| lanes.get(lane).map_or(1, |(_, buffer)| buffer.entries));
            let found = self.fifo_misses::<LANES>(places, between);
            lanes.iter().zip(found).for_each(|(&(i, _), found)| misses[i] = found);
        }
        let lru = of(Replacement::Lru);
        let small = |buffer: &VertexCache| (1..=VertexCache::MAX_ENTRIES).contains(&buffer.entries);
        let together = lru.iter().filter(|(_, buffer)| small(buffer));
        let most = together.clone().map(|(_, buffer)| buffer.entries).max().unwrap_or(0);
        let profile = if together.count() < SIZES { Vec::new() } else { self.lru_profile(most, between) };
        for (i, &buffer) in lru {
            let place = (buffer.entries as usize).wrapping_sub(1);
            misses[i] = profile.get(place).copied().unwrap_or_else(|| self.misses(buffer, between));
        }
        let (triangles, vertices) = (self.triangles, self.vertices());
        misses.into_iter().map(|misses| VertexCacheStatistics { misses, triangles, vertices }).collect()
    }

    fn fifo_misses<const N: usize>(&self, places: [u32; N], between: FlushPolicy) -> [usize; N] {
        let mut queues = Fifo::<N>::new(places, self.vertex_count);
        self.runs(between, |run| {
            queues.flush();
            queues.send_all(run);
        });
        queues.misses()
    }

    fn lru_profile(&self, most: u32, between: FlushPolicy) -> Vec<usize> {
        let mut distances = Distances::new(most as usize, self.vertex_count);
        self.runs(between, |run| {
            distances.flush();
            distances.send_all(run);
        });
        distances.misses()
    }
}
