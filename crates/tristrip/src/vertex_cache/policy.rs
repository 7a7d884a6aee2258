//! Parameters of a simulated vertex cache: replacement policy, size, and flushes between strips.

use crate::error::Error;
use crate::names::names;

/// The replacement policy: which vertex a full cache evicts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Replacement {
    /// First in, first out: the vertex that entered first.
    #[default]
    Fifo,
    /// The least recently used vertex.
    Lru,
}

names! {
    "tristrip::vertex_cache::Replacement", Replacement, "replacement",
    Fifo => "fifo", "Evicts the vertex that entered first";
    Lru => "lru", "Evicts the least recently used vertex";
}

/// A vertex cache: its replacement policy and number of entries. The text form is the policy and
/// the number of entries, for example `fifo:16`.
///
/// ```
/// use tristrip::vertex_cache::{Replacement, VertexCache};
/// let cache: VertexCache = "lru:32".parse()?;
/// assert_eq!(cache, VertexCache { replacement: Replacement::Lru, entries: 32 });
/// assert_eq!(VertexCache::default().to_string(), "fifo:16");
/// assert!("lru:0".parse::<VertexCache>().is_err());
/// # Ok::<(), tristrip::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct VertexCache {
    /// Which vertex is evicted when the cache is full.
    pub replacement: Replacement,
    /// Number of vertices that the cache holds. A cache without entries has no hits.
    pub entries: u32,
}

impl VertexCache {
    /// Maximum number of entries accepted by the parser.
    pub const MAX_ENTRIES: u32 = 1 << 16;

    /// Creates a FIFO cache.
    ///
    /// ```
    /// use tristrip::vertex_cache::VertexCache;
    /// assert_eq!(VertexCache::fifo(16), VertexCache::default());
    /// assert_eq!(VertexCache::fifo(32).to_string(), "fifo:32");
    /// ```
    pub const fn fifo(entries: u32) -> Self {
        Self { replacement: Replacement::Fifo, entries }
    }

    /// Creates an LRU cache.
    ///
    /// ```
    /// use tristrip::vertex_cache::{FlushPolicy, VertexCache, VertexCacheStatistics};
    /// let strips = tristrip::Strips::from_parts(vec![0, 1, 2, 0, 3, 0, 4], vec![7])?;
    /// let misses = |cache| VertexCacheStatistics::of(&strips, cache, FlushPolicy::Keep).misses;
    /// // Vertex 0 entered first but was used recently.
    /// assert_eq!((misses(VertexCache::lru(3)), misses(VertexCache::fifo(3))), (5, 6));
    /// # Ok::<(), tristrip::Error>(())
    /// ```
    pub const fn lru(entries: u32) -> Self {
        Self { replacement: Replacement::Lru, entries }
    }
}

/// The cache that is usually simulated for strips: FIFO with 16 entries.
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
            name: "vertex_cache",
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

/// Whether the cache is flushed between strips.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FlushPolicy {
    /// The cache keeps its vertices, as a GPU does within one draw call.
    #[default]
    Keep,
    /// The cache is flushed, as between draw calls or in studies of single strips.
    Flush,
}

names! {
    "tristrip::vertex_cache::FlushPolicy", FlushPolicy, "flush_policy",
    Keep => "keep", "The cache keeps its vertices from one strip to the next";
    Flush => "flush", "The cache is flushed between strips";
}
