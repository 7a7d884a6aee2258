//! One buffer strip by strip, and many buffers in few passes.

use super::distances::Distances;
use super::fifo::Fifo;
use super::sent::{Sent, real_triangles};
use super::{Between, Buffer, BufferUse, Replacement, VertexBuffer};
use crate::strip::Strips;

/// Buffers, first in, first out, that are simulated side by side: a vector register of stamps. Eight are no faster on bunny, and
/// slower on dragon, whose stamps leave the caches then.
const LANES: usize = 4;

/// Sizes asked for from which on one pass over distances is faster than one pass each, on bunny and dragon.
const SIZES: usize = 4;

/// What one strip costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StripUse {
    /// Vertices sent, swaps and winding repeats included.
    pub length: usize,
    /// Real triangles drawn.
    pub triangles: usize,
    /// Vertices that were not in the buffer when they were sent.
    pub misses: usize,
}

impl StripUse {
    /// Draws strips as [`BufferUse::of`] does; gives what each costs, in their order.
    ///
    /// # Panics
    /// A strip has a vertex that is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::{Strips, strip::{Between, Buffer, StripUse}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[2, 3, 4]);
    /// let each = StripUse::of(&strips, Buffer::fifo(16), Between::Keep, 5);
    /// assert_eq!(each[1], StripUse { length: 3, triangles: 1, misses: 1 });
    /// ```
    pub fn of(strips: &Strips, buffer: Buffer, between: Between, vertex_count: usize) -> Vec<Self> {
        let sent = Sent::strips(strips, vertex_count);
        let mut queue = VertexBuffer::new(buffer, sent.vertex_count);
        let mut each = Vec::with_capacity(strips.len());
        sent.runs(Between::Flush, |strip| {
            if between == Between::Flush {
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
/// as no entry is larger than the one before it, `most` above [`Buffer::MAX_PLACES`] counts as so many.
///
/// # Panics
/// A strip has a vertex that is not less than `vertex_count`.
///
/// ```
/// use tristrip::{Strips, strip::{Between, lru_profile}};
/// let mut strips = Strips::default();
/// strips.push(&[0, 1, 2, 3, 0]);
/// assert_eq!(lru_profile(&strips, 5, Between::Keep, 4), [5, 5, 5, 4, 4]);
/// ```
pub fn lru_profile(strips: &Strips, most: u32, between: Between, vertex_count: usize) -> Vec<usize> {
    Sent::strips(strips, vertex_count).lru_profile(most.min(Buffer::MAX_PLACES), between)
}

impl BufferUse {
    /// Draws strips with each of several buffers, as [`BufferUse::of`] does but faster; gives them in the buffers' order.
    ///
    /// Sizes of LRU come from one pass by stack distances. FIFO buffers are simulated four at a time.
    ///
    /// # Panics
    /// A strip has a vertex that is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::{Strips, strip::{Between, Buffer, BufferUse}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3, 0]);
    /// let buffers = [Buffer::fifo(3), Buffer::fifo(4), Buffer::lru(4)];
    /// let misses = BufferUse::of_each(&strips, &buffers, Between::Keep, 4).iter().map(|used| used.misses).collect::<Vec<_>>();
    /// assert_eq!(misses, [5, 4, 4]);
    /// ```
    pub fn of_each(strips: &Strips, buffers: &[Buffer], between: Between, vertex_count: usize) -> Vec<Self> {
        Sent::strips(strips, vertex_count).with_each(buffers, between)
    }

    /// Draws a triangle list with each of several buffers, as [`BufferUse::of_list`] does but faster; gives them in the buffers'
    /// order.
    ///
    /// # Panics
    /// An index is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::strip::{Buffer, BufferUse};
    /// let buffers = [Buffer::fifo(1), Buffer::lru(2)];
    /// let used = BufferUse::of_list_each(&[0, 1, 2, 2, 1, 3], &buffers, 4);
    /// assert_eq!((used[0].misses, used[1].misses), (5, 4));
    /// ```
    pub fn of_list_each(indices: &[u32], buffers: &[Buffer], vertex_count: usize) -> Vec<Self> {
        Sent::list(indices, vertex_count).with_each(buffers, Between::Keep)
    }
}

impl Sent<'_> {
    fn with_each(&self, buffers: &[Buffer], between: Between) -> Vec<BufferUse> {
        let mut misses = vec![0; buffers.len()];
        let of = |replacement| {
            let numbered = buffers.iter().enumerate();
            numbered.filter(move |(_, buffer)| buffer.replacement == replacement).collect::<Vec<_>>()
        };
        for lanes in of(Replacement::Fifo).chunks(LANES) {
            let places = std::array::from_fn(|lane| lanes.get(lane).map_or(1, |(_, buffer)| buffer.places));
            let found = self.fifo_misses::<LANES>(places, between);
            lanes.iter().zip(found).for_each(|(&(i, _), found)| misses[i] = found);
        }
        let lru = of(Replacement::Lru);
        let small = |buffer: &Buffer| (1..=Buffer::MAX_PLACES).contains(&buffer.places);
        let together = lru.iter().filter(|(_, buffer)| small(buffer));
        let most = together.clone().map(|(_, buffer)| buffer.places).max().unwrap_or(0);
        let profile = if together.count() < SIZES { Vec::new() } else { self.lru_profile(most, between) };
        for (i, &buffer) in lru {
            let place = (buffer.places as usize).wrapping_sub(1);
            misses[i] = profile.get(place).copied().unwrap_or_else(|| self.misses(buffer, between));
        }
        let (triangles, vertices) = (self.triangles, self.vertices());
        misses.into_iter().map(|misses| BufferUse { misses, triangles, vertices }).collect()
    }

    fn fifo_misses<const N: usize>(&self, places: [u32; N], between: Between) -> [usize; N] {
        let mut queues = Fifo::<N>::new(places, self.vertex_count);
        self.runs(between, |run| {
            queues.flush();
            queues.send_all(run);
        });
        queues.misses()
    }

    fn lru_profile(&self, most: u32, between: Between) -> Vec<usize> {
        let mut distances = Distances::new(most as usize, self.vertex_count);
        self.runs(between, |run| {
            distances.flush();
            distances.send_all(run);
        });
        distances.misses()
    }
}
