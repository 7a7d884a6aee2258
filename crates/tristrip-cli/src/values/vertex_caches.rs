//! Lists of vertex caches as typed: `fifo:16,lru:4..64`.

use std::collections::HashSet;

use tristrip::strip::Buffer;

/// The maximum length of a list.
const MAX_LENGTH: usize = 1024;

/// Vertex caches in the order given, without repetitions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct VertexCacheList(pub(crate) Vec<Buffer>);

/// The sizes of real graphics processors, and those used in studies of strips.
impl Default for VertexCacheList {
    fn default() -> Self {
        let fifo = [8, 16, 24, 32, 64].map(Buffer::fifo);
        let lru = [8, 16, 24, 32, 64].map(Buffer::lru);
        Self(fifo.into_iter().chain(lru).collect())
    }
}

impl VertexCacheList {
    /// Returns the sizes at which a curve is sampled by default.
    pub(crate) fn curve() -> Self {
        Self((2..=64).map(Buffer::fifo).chain((2..=64).map(Buffer::lru)).collect())
    }
}

impl std::str::FromStr for VertexCacheList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (mut seen, mut list) = (HashSet::new(), Vec::new());
        for item in text.split(',') {
            let (first, last) = parse_range(item)?;
            for places in first.places..=last.places {
                let cache = Buffer { places, ..first };
                if seen.insert(cache) {
                    list.push(cache);
                }
                if list.len() > MAX_LENGTH {
                    return Err(format!("more than {MAX_LENGTH} vertex caches"));
                }
            }
        }
        Ok(Self(list))
    }
}

/// Parses `fifo:4` or `fifo:4..64` into the first and the last vertex cache.
fn parse_range(item: &str) -> Result<(Buffer, Buffer), String> {
    let invalid = || {
        let max = Buffer::MAX_PLACES;
        format!(
            "found `{item}`, expected KIND:N or KIND:N..M, where KIND is fifo or lru and 1 <= N <= M <= {max}"
        )
    };
    let (start, end) = item.split_once("..").map_or((item, None), |(start, end)| (start, Some(end)));
    let first: Buffer = start.parse().map_err(|_| invalid())?;
    let last: Buffer = match end {
        Some(end) => format!("{}:{end}", first.replacement).parse().map_err(|_| invalid())?,
        None => first,
    };
    if last.places < first.places { Err(invalid()) } else { Ok((first, last)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_expanded_and_repetitions_dropped() {
        let list: VertexCacheList = "lru:4,fifo:3..5,lru:4,fifo:4".parse().unwrap();
        assert_eq!(list.0, [Buffer::lru(4), Buffer::fifo(3), Buffer::fifo(4), Buffer::fifo(5)]);
        let names: Vec<String> = VertexCacheList::default().0.iter().map(Buffer::to_string).collect();
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
        assert_eq!("fifo:1..65536".parse::<VertexCacheList>(), Err("more than 1024 vertex caches".into()));
    }
}
