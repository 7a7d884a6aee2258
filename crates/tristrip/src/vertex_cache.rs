//! Simulated vertex buffers of a graphics processor: how many vertices it must transform while strips or a list are drawn.
//!
//! A vertex that is in the buffer when it is sent is a hit and costs nothing; another is a miss and enters the buffer. Misses per
//! real triangle are the ACMR, at best near 0.5 and 3 at worst; misses per vertex in use are the ATVR, at best 1.
//!
//! ```text
//! sent          0  1  2  1  3  0        a strip with a swap, then its first vertex again
//! fifo:3        0  01 012 ·  123 230    the second 1 is a hit; 3 drives out 0; 0 drives out 1
//! lru:3         0  01 012 021 213 130   the hit makes 1 the youngest, so that 2 leaves before it
//! ```
//!
//! Strips are sent in order, swaps and winding repeats included; restarts and the degenerate triangles between strips send
//! nothing here. A processor keeps its buffer from one strip of an index buffer to the next ([`FlushPolicy::Keep`]); published
//! studies of strips flush it ([`FlushPolicy::Flush`]).
//!
//! [`VertexCacheStatistics`] prices strips or a list, with one buffer or many; [`StripCacheStatistics`] tells it strip by strip, [`lru_profile`] for all
//! sizes; [`VertexCacheSimulator`] takes one vertex after the other. [`GeneralizedCost`] is another machine, that of the first studies:
//! it is sent vertices and references to its buffer.
//!
//! # Algorithm
//! *First in, first out:* each vertex remembers which miss brought it in. It has left again when as many misses as the buffer has
//! places came after that one.
//!
//! *Least recently used:* each vertex remembers when it was sent last, in a log of what was sent. A vertex is in the buffer when
//! that was not before the log's oldest place that counts; this place moves on until as many vertices as the buffer has places
//! were sent last at it or later. The log is written anew without what was sent again since, before it outgrows a few times
//! the buffer.
//!
//! Many buffers are not simulated one by one: FIFO ones stand side by side, the LRU ones are read from one pass by stack
//! distances.
//!
//! # References
//! Evans, Skiena, Varshney: *Efficiently Generating Triangle Strips for Fast Rendering*, 1996, section 6. Mattson, Gecsei, Slutz,
//! Traiger: *Evaluation techniques for storage hierarchies*, IBM Systems Journal, 1970 (stack distances).
//!
//! # Complexity
//! O(1) an index, whatever the size of the buffer; 4 bytes a vertex in use, for LRU up to 12 bytes a place more. Many buffers:
//! 16 bytes a vertex for four FIFO ones, O(log k) an index for all LRU ones up to k places.

mod distances;
mod fifo;
mod generalized;
mod lru;
mod profile;
mod stream;

pub use generalized::GeneralizedCost;
pub use profile::{StripCacheStatistics, lru_profile};

use crate::error::Error;
use crate::strip::Strips;
use fifo::Fifo;
use lru::Lru;
use stream::VertexStream;

/// Which vertex leaves a full buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Replacement {
    /// The one that came in first.
    #[default]
    Fifo,
    /// The one that was not sent for the longest time.
    Lru,
}

impl std::fmt::Display for Replacement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Fifo => "fifo",
            Self::Lru => "lru",
        })
    }
}

impl std::str::FromStr for Replacement {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self, Error> {
        match name {
            "fifo" => Ok(Self::Fifo),
            "lru" => Ok(Self::Lru),
            _ => {
                Err(Error::Parameter { name: "replacement", found: name.into(), expected: "`fifo` or `lru`" })
            }
        }
    }
}

/// A vertex buffer: its rule and its number of places. Written and parsed as `fifo:16`.
///
/// ```
/// use tristrip::vertex_cache::{Replacement, VertexCache};
/// let buffer: VertexCache = "lru:32".parse()?;
/// assert_eq!(buffer, VertexCache { replacement: Replacement::Lru, entries: 32 });
/// assert_eq!(VertexCache::default().to_string(), "fifo:16");
/// assert!("lru:0".parse::<VertexCache>().is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct VertexCache {
    /// Which vertex leaves when it is full.
    pub replacement: Replacement,
    /// How many vertices it holds; one of no places never hits.
    pub entries: u32,
}

impl VertexCache {
    /// The most places that a buffer is parsed with.
    pub const MAX_ENTRIES: u32 = 1 << 16;

    /// Makes a buffer in which the vertex that came in first leaves first.
    pub const fn fifo(entries: u32) -> Self {
        Self { replacement: Replacement::Fifo, entries }
    }

    /// Makes a buffer in which the vertex that was not sent for the longest time leaves first.
    pub const fn lru(entries: u32) -> Self {
        Self { replacement: Replacement::Lru, entries }
    }
}

/// The buffer of 16 places that strips are mostly measured with, first in, first out.
impl Default for VertexCache {
    fn default() -> Self {
        Self::fifo(16)
    }
}

impl std::fmt::Display for VertexCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}", self.replacement, self.entries)
    }
}

impl std::str::FromStr for VertexCache {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let wrong = || Error::Parameter {
            name: "buffer",
            found: format!("`{text}`"),
            expected: "`fifo:N` or `lru:N`, N from 1 to 65536",
        };
        let (name, entries) = text.split_once(':').ok_or_else(wrong)?;
        let replacement = name.parse().map_err(|_| wrong())?;
        let digits = entries.bytes().all(|b| b.is_ascii_digit());
        match entries.parse() {
            Ok(entries @ 1..=Self::MAX_ENTRIES) if digits => Ok(Self { replacement, entries }),
            _ => Err(wrong()),
        }
    }
}

/// What happens to the buffer between two strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FlushPolicy {
    /// It keeps its vertices, as a graphics processor does within one draw call.
    #[default]
    Keep,
    /// It is emptied, as before each draw call, or in studies that look at one strip at a time.
    Flush,
}

/// A vertex buffer in use, for vertices that come one by one.
///
/// ```
/// use tristrip::vertex_cache::{VertexCache, VertexCacheSimulator};
/// let mut buffer = VertexCacheSimulator::new(VertexCache::fifo(2), 3);
/// let hits: Vec<bool> = [0, 1, 0, 2, 0].into_iter().map(|v| buffer.send(v)).collect();
/// assert_eq!(hits, [false, false, true, false, false]);
/// assert_eq!(buffer.misses(), 4);
///
/// let mut buffer = VertexCacheSimulator::new(VertexCache::lru(2), 3);
/// let hits: Vec<bool> = [0, 1, 0, 2, 0].into_iter().map(|v| buffer.send(v)).collect();
/// assert_eq!(hits, [false, false, true, false, true]);
/// ```
#[derive(Debug, Clone)]
pub struct VertexCacheSimulator {
    queue: Queue,
}

#[derive(Debug, Clone)]
enum Queue {
    Fifo(Fifo<1>),
    Lru(Lru),
}

impl VertexCacheSimulator {
    /// Makes an empty buffer for vertices 0 to `vertex_count` − 1. More than 2²⁸ places count as so many.
    pub fn new(buffer: VertexCache, vertex_count: usize) -> Self {
        let queue = match buffer.replacement {
            Replacement::Fifo => Queue::Fifo(Fifo::new([buffer.entries], vertex_count)),
            Replacement::Lru => Queue::Lru(Lru::new(buffer.entries, vertex_count)),
        };
        Self { queue }
    }

    /// Sends a vertex; tells whether it was in the buffer.
    ///
    /// # Panics
    /// The vertex is not less than the number of vertices.
    pub fn send(&mut self, vertex: u32) -> bool {
        match &mut self.queue {
            Queue::Fifo(queue) => queue.send(vertex),
            Queue::Lru(queue) => queue.send(vertex),
        }
    }

    /// Sends vertices in order; the same as [`send`](Self::send) for each, but faster.
    ///
    /// # Panics
    /// A vertex is not less than the number of vertices.
    pub fn send_all(&mut self, vertices: &[u32]) {
        match &mut self.queue {
            Queue::Fifo(queue) => queue.send_all(vertices),
            Queue::Lru(queue) => queue.send_all(vertices),
        }
    }

    /// Empties the buffer.
    pub fn flush(&mut self) {
        match &mut self.queue {
            Queue::Fifo(queue) => queue.flush(),
            Queue::Lru(queue) => queue.flush(),
        }
    }

    /// Swaps the two vertices of an edge that a strip goes on over: the older one takes the other's turn.
    fn swap(&mut self, older: u32, newer: u32) {
        match &mut self.queue {
            Queue::Fifo(queue) => queue.exchange(older, newer),
            Queue::Lru(queue) => {
                if queue.has(older) {
                    queue.send(older);
                }
            }
        }
    }

    /// Counts the vertices that were not in the buffer when they were sent.
    pub fn misses(&self) -> usize {
        match &self.queue {
            Queue::Fifo(queue) => queue.misses()[0],
            Queue::Lru(queue) => queue.misses(),
        }
    }
}

/// What drawing strips or a list costs with one vertex buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct VertexCacheStatistics {
    /// Vertices that were not in the buffer when they were sent.
    pub misses: usize,
    /// Real triangles drawn.
    pub triangles: usize,
    /// Different vertices that were sent.
    pub vertices: usize,
}

impl VertexCacheStatistics {
    /// Draws strips over vertices 0 to `vertex_count` − 1 with a buffer that is empty at first.
    ///
    /// # Panics
    /// A strip has a vertex that is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::{Strips, vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics}};
    /// let mut strips = Strips::default();
    /// strips.push(&[0, 1, 2, 3]);
    /// strips.push(&[2, 3, 4]);
    /// let used = VertexCacheStatistics::of(&strips, VertexCache::fifo(16), FlushPolicy::Keep, 5);
    /// assert_eq!((used.misses, used.triangles, used.vertices), (5, 3, 5));
    /// assert_eq!((used.acmr(), used.atvr()), (5.0 / 3.0, 1.0));
    /// assert_eq!(VertexCacheStatistics::of(&strips, VertexCache::fifo(16), FlushPolicy::Flush, 5).misses, 7);
    /// ```
    pub fn of(strips: &Strips, buffer: VertexCache, between: FlushPolicy, vertex_count: usize) -> Self {
        VertexStream::strips(strips, vertex_count).with(buffer, between)
    }

    /// Draws a triangle list, three indices a triangle, over vertices 0 to `vertex_count` − 1 with a buffer that is empty at
    /// first. All indices are sent; triangles with two equal ones do not count as real.
    ///
    /// # Panics
    /// An index is not less than `vertex_count`.
    ///
    /// ```
    /// use tristrip::vertex_cache::{VertexCache, VertexCacheStatistics};
    /// let used = VertexCacheStatistics::of_list(&[0, 1, 2, 2, 1, 3], VertexCache::fifo(16), 4);
    /// assert_eq!((used.misses, used.triangles, used.vertices), (4, 2, 4));
    /// ```
    pub fn of_list(indices: &[u32], buffer: VertexCache, vertex_count: usize) -> Self {
        VertexStream::list(indices, vertex_count).with(buffer, FlushPolicy::Keep)
    }

    /// Divides the misses by the real triangles (the ACMR); 0 where there is none.
    pub fn acmr(&self) -> f64 {
        if self.triangles == 0 { 0.0 } else { self.misses as f64 / self.triangles as f64 }
    }

    /// Divides the misses by the vertices in use (the ATVR); 0 where there is none.
    pub fn atvr(&self) -> f64 {
        if self.vertices == 0 { 0.0 } else { self.misses as f64 / self.vertices as f64 }
    }
}

/// Sums what parts with vertices of their own cost.
impl std::iter::Sum for VertexCacheStatistics {
    fn sum<I: Iterator<Item = Self>>(parts: I) -> Self {
        parts.fold(Self::default(), |a, b| Self {
            misses: a.misses + b.misses,
            triangles: a.triangles + b.triangles,
            vertices: a.vertices + b.vertices,
        })
    }
}

#[cfg(test)]
mod tests;
