//! Vertex-cache statistics: for strips or a list with one cache or many, and for all sizes of an
//! LRU cache.

use super::distances::Distances;
use super::fifo::Fifo;
use super::policy::{FlushPolicy, Replacement, VertexCache};
use super::simulator::VertexCacheSimulator;
use super::stream::VertexStream;
use crate::error::Error;
use crate::strip::Strips;

/// Number of FIFO caches simulated side by side: one vector register of stamps. Eight are not
/// faster on bunny, and slower on dragon, because the stamps no longer fit in the processor's
/// caches.
const LANES: usize = 4;

/// Number of LRU sizes from which one pass by stack distances is faster than one pass per size.
/// Measured on bunny and dragon.
const SIZES: usize = 4;

/// Vertex-cache statistics of strips or of a triangle list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct VertexCacheStatistics {
    /// Number of misses: vertices that were not in the cache when they were sent.
    pub misses: usize,
    /// Number of triangles drawn, without degenerate ones.
    pub triangles: usize,
    /// Number of distinct vertices sent.
    pub vertices: usize,
}

impl VertexCacheStatistics {
    /// Simulates strips with an initially empty cache.
    ///
    /// ```
    /// use tristrip::{Strips, vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[2, 3, 4]);
    /// let used = VertexCacheStatistics::of(&strips, VertexCache::fifo(16), FlushPolicy::Keep);
    /// assert_eq!((used.misses, used.triangles, used.vertices), (5, 3, 5));
    /// assert_eq!((used.acmr(), used.atvr()), (5.0 / 3.0, 1.0));
    /// assert_eq!(VertexCacheStatistics::of(&strips, VertexCache::fifo(16), FlushPolicy::Flush).misses, 7);
    /// ```
    pub fn of(strips: &Strips, cache: VertexCache, flush: FlushPolicy) -> Self {
        Self::of_stream(&VertexStream::strips(strips), cache, flush)
    }

    /// Simulates a triangle list with an initially empty cache. All indices are sent. Degenerate
    /// triangles are not counted as triangles.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheStatistics};
    /// let used = VertexCacheStatistics::of_list(&[[0, 1, 2], [2, 1, 3]], VertexCache::fifo(16));
    /// assert_eq!((used.misses, used.triangles, used.vertices), (4, 2, 4));
    /// ```
    pub fn of_list(triangles: &[[u32; 3]], cache: VertexCache) -> Self {
        Self::of_stream(&VertexStream::list(triangles), cache, FlushPolicy::Keep)
    }

    fn of_stream(stream: &VertexStream<'_>, cache: VertexCache, flush: FlushPolicy) -> Self {
        let misses = misses(stream, cache, flush);
        Self { misses, triangles: stream.triangles, vertices: stream.vertices() }
    }

    /// Returns the misses per triangle (the ACMR), or 0 if there are no triangles.
    ///
    /// ```
    /// use tristrip::vertex_cache::VertexCacheStatistics;
    /// let mut used = VertexCacheStatistics::default();
    /// assert_eq!(used.acmr(), 0.0);
    /// (used.misses, used.triangles) = (300, 400);
    /// assert_eq!(used.acmr(), 0.75);
    /// ```
    pub fn acmr(&self) -> f64 {
        if self.triangles == 0 { 0.0 } else { self.misses as f64 / self.triangles as f64 }
    }

    /// Returns the misses per vertex in use (the ATVR), or 0 if there are no vertices.
    ///
    /// ```
    /// use tristrip::vertex_cache::VertexCacheStatistics;
    /// let mut used = VertexCacheStatistics::default();
    /// (used.misses, used.vertices) = (300, 200);
    /// // Each vertex is transformed 1.5 times on average.
    /// assert_eq!(used.atvr(), 1.5);
    /// ```
    pub fn atvr(&self) -> f64 {
        if self.vertices == 0 { 0.0 } else { self.misses as f64 / self.vertices as f64 }
    }

    /// Simulates strips with several caches, faster than calling [`VertexCacheStatistics::of`] for
    /// each cache. Returns the statistics in the order of the caches.
    ///
    /// All LRU sizes are computed in one pass by stack distances. FIFO caches are simulated four at
    /// a time.
    ///
    /// ```
    /// use tristrip::{Strips, vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3, 0]);
    /// let caches = [VertexCache::fifo(3), VertexCache::fifo(4), VertexCache::lru(4)];
    /// let used = VertexCacheStatistics::of_each(&strips, &caches, FlushPolicy::Keep);
    /// assert_eq!([used[0].misses, used[1].misses, used[2].misses], [5, 4, 4]);
    /// ```
    pub fn of_each(strips: &Strips, caches: &[VertexCache], flush: FlushPolicy) -> Vec<Self> {
        Self::of_stream_each(&VertexStream::strips(strips), caches, flush)
    }

    /// Simulates a triangle list with several caches, faster than calling
    /// [`VertexCacheStatistics::of_list`] for each cache. Returns the statistics in the order of
    /// the caches.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheStatistics};
    /// let caches = [VertexCache::fifo(1), VertexCache::lru(2)];
    /// let used = VertexCacheStatistics::of_list_each(&[[0, 1, 2], [2, 1, 3]], &caches);
    /// assert_eq!((used[0].misses, used[1].misses), (5, 4));
    /// ```
    pub fn of_list_each(triangles: &[[u32; 3]], caches: &[VertexCache]) -> Vec<Self> {
        Self::of_stream_each(&VertexStream::list(triangles), caches, FlushPolicy::Keep)
    }

    fn of_stream_each(stream: &VertexStream<'_>, caches: &[VertexCache], flush: FlushPolicy) -> Vec<Self> {
        let mut misses = vec![0; caches.len()];
        let with = |replacement| {
            let numbered = caches.iter().enumerate();
            numbered.filter(move |(_, cache)| cache.replacement == replacement).collect::<Vec<_>>()
        };
        for lanes in with(Replacement::Fifo).chunks(LANES) {
            let entries = std::array::from_fn(|lane| lanes.get(lane).map_or(1, |(_, cache)| cache.entries));
            let mut record = |found: &[usize]| {
                lanes.iter().zip(found).for_each(|(&(i, _), &found)| misses[i] = found);
            };
            match *lanes {
                [_, _] => record(&fifo_misses(stream, [entries[0], entries[1]], flush)),
                _ => record(&fifo_misses::<LANES>(stream, entries, flush)),
            }
        }
        let lru = with(Replacement::Lru);
        let small = |cache: &VertexCache| (1..=VertexCache::MAX_ENTRIES).contains(&cache.entries);
        let in_profile = lru.iter().filter(|(_, cache)| small(cache));
        let largest = in_profile.clone().map(|(_, cache)| cache.entries).max().unwrap_or(0);
        let profile =
            if in_profile.count() < SIZES { Vec::new() } else { lru_misses(stream, largest, flush) };
        for (i, &cache) in lru {
            let size = (cache.entries as usize).wrapping_sub(1);
            misses[i] = profile.get(size).copied().unwrap_or_else(|| self::misses(stream, cache, flush));
        }
        let (triangles, vertices) = (stream.triangles, stream.vertices());
        misses.into_iter().map(|misses| Self { misses, triangles, vertices }).collect()
    }
}

/// Counts the misses of one cache.
fn misses(stream: &VertexStream<'_>, cache: VertexCache, flush: FlushPolicy) -> usize {
    let mut simulator = VertexCacheSimulator::of(cache, stream.vertex_count);
    stream.runs(flush, |run| {
        simulator.flush();
        simulator.receive_all(run);
    });
    simulator.misses()
}

/// Counts the misses of several FIFO caches.
fn fifo_misses<const N: usize>(
    stream: &VertexStream<'_>,
    entries: [u32; N],
    flush: FlushPolicy,
) -> [usize; N] {
    let mut caches = Fifo::<N>::new(entries, stream.vertex_count);
    stream.runs(flush, |run| {
        caches.flush();
        caches.send_all(run);
    });
    caches.misses()
}

/// Counts the misses of LRU caches of 1 to `largest` entries.
fn lru_misses(stream: &VertexStream<'_>, largest: u32, flush: FlushPolicy) -> Vec<usize> {
    let mut distances = Distances::new(largest as usize, stream.vertex_count);
    stream.runs(flush, |run| {
        distances.flush();
        distances.send_all(run);
    });
    distances.misses()
}

/// Sums the statistics of parts that do not share vertices.
impl std::iter::Sum for VertexCacheStatistics {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |a, b| Self {
            misses: a.misses + b.misses,
            triangles: a.triangles + b.triangles,
            vertices: a.vertices + b.vertices,
        })
    }
}

/// Counts the misses of LRU caches of 1 to `largest` entries in one pass. Item i contains the
/// misses of a cache with i + 1 entries. The misses never increase with the size.
///
/// # Errors
/// `largest` is above [`VertexCache::MAX_ENTRIES`].
///
/// ```
/// use tristrip::{Strips, vertex_cache::{FlushPolicy, lru_profile}};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 0]);
/// assert_eq!(lru_profile(&strips, 5, FlushPolicy::Keep)?, [5, 5, 5, 4, 4]);
/// # Ok::<(), tristrip::Error>(())
/// ```
pub fn lru_profile(strips: &Strips, largest: u32, flush: FlushPolicy) -> Result<Vec<usize>, Error> {
    if largest > VertexCache::MAX_ENTRIES {
        let (found, limit) = (u64::from(largest), u64::from(VertexCache::MAX_ENTRIES));
        return Err(Error::LimitExceeded { what: "entries of a vertex cache", found, limit });
    }
    Ok(lru_misses(&VertexStream::strips(strips), largest, flush))
}
