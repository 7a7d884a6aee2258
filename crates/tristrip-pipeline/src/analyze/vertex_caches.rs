//! Parses lists of vertex caches, such as `fifo:16,lru:4..64`.

use std::collections::HashSet;

use tristrip::vertex_cache::VertexCache;

/// The maximum length of a list.
const MAX_LENGTH: usize = 1024;

/// Vertex caches in the given order, without repeats.
///
/// ```
/// use tristrip::vertex_cache::VertexCache;
/// use tristrip_pipeline::analyze::VertexCacheList;
/// let list: VertexCacheList = "fifo:3..4,lru:8".parse()?;
/// assert_eq!(list.0, [VertexCache::fifo(3), VertexCache::fifo(4), VertexCache::lru(8)]);
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VertexCacheList(pub Vec<VertexCache>);

/// Cache sizes of real GPUs, and those used in the literature on strips.
impl Default for VertexCacheList {
    fn default() -> Self {
        let fifo = [8, 16, 24, 32, 64].map(VertexCache::fifo);
        let lru = [8, 16, 24, 32, 64].map(VertexCache::lru);
        Self(fifo.into_iter().chain(lru).collect())
    }
}

impl VertexCacheList {
    /// Returns the default vertex cache sizes of a curve.
    pub fn curve() -> Self {
        Self((2..=64).map(VertexCache::fifo).chain((2..=64).map(VertexCache::lru)).collect())
    }
}

impl std::str::FromStr for VertexCacheList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (mut seen, mut list) = (HashSet::new(), Vec::new());
        for item in text.split(',') {
            let (first, last) = parse_range(item)?;
            for entries in first.entries..=last.entries {
                let cache = VertexCache { entries, ..first };
                if seen.insert(cache) {
                    list.push(cache);
                }
                if list.len() > MAX_LENGTH {
                    return Err(format!(
                        "found more than {MAX_LENGTH} vertex caches, expected at most {MAX_LENGTH}"
                    ));
                }
            }
        }
        Ok(Self(list))
    }
}

/// Parses `fifo:4` or `fifo:4..64` into the first and the last vertex cache.
fn parse_range(item: &str) -> Result<(VertexCache, VertexCache), String> {
    let invalid = || {
        let max = VertexCache::MAX_ENTRIES;
        format!(
            "found `{item}`, expected KIND:N or KIND:N..M, where KIND is fifo or lru and 1 <= N <= M <= {max}"
        )
    };
    let (start, end) = item.split_once("..").map_or((item, None), |(start, end)| (start, Some(end)));
    let first: VertexCache = start.parse().map_err(|_| invalid())?;
    let last: VertexCache = match end {
        Some(end) => format!("{}:{end}", first.replacement).parse().map_err(|_| invalid())?,
        None => first,
    };
    if last.entries < first.entries { Err(invalid()) } else { Ok((first, last)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_expanded_and_repetitions_dropped() {
        let list: VertexCacheList = "lru:4,fifo:3..5,lru:4,fifo:4".parse().unwrap();
        assert_eq!(
            list.0,
            [VertexCache::lru(4), VertexCache::fifo(3), VertexCache::fifo(4), VertexCache::fifo(5)]
        );
        let names: Vec<String> = VertexCacheList::default().0.iter().map(VertexCache::to_string).collect();
        assert_eq!(names.join(",").parse(), Ok(VertexCacheList::default()));
    }

    #[test]
    fn invalid_lists_are_rejected() {
        for invalid in [
            "",
            "fifo",
            "fifo:",
            "fifo:0",
            "fifo:8..4",
            "fifo:4..",
            "fifo:..4",
            "fifo:4...8",
            "lru:4,,lru:5",
            "mru:4",
            "fifo:1..65537",
            "fifo:4..lru:8",
        ] {
            let error = invalid.parse::<VertexCacheList>().unwrap_err();
            assert!(error.contains("expected KIND:N or KIND:N..M"), "{invalid}: {error}");
        }
        assert_eq!(
            "fifo:1..65536".parse::<VertexCacheList>(),
            Err("found more than 1024 vertex caches, expected at most 1024".into())
        );
    }
}
