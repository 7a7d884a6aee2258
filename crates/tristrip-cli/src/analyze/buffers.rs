//! Lists of vertex buffers as they are typed: `fifo:16,lru:4..64`.

use std::collections::HashSet;

use tristrip::strip::Buffer;

/// The most buffers that one list may have.
const MOST: usize = 1024;

/// Vertex buffers in the order in which they were asked for, each once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct BufferList(pub(crate) Vec<Buffer>);

/// The sizes that graphics processors had, and those that studies of strips use.
impl Default for BufferList {
    fn default() -> Self {
        let fifo = [8, 16, 24, 32, 64].map(Buffer::fifo);
        let lru = [8, 16, 24, 32, 64].map(Buffer::lru);
        Self(fifo.into_iter().chain(lru).collect())
    }
}

impl BufferList {
    /// Makes the sizes that a curve is drawn through.
    pub(crate) fn curve() -> Self {
        Self((2..=64).map(Buffer::fifo).chain((2..=64).map(Buffer::lru)).collect())
    }
}

impl std::str::FromStr for BufferList {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (mut seen, mut list) = (HashSet::new(), Vec::new());
        for item in text.split(',') {
            let (first, last) = ends(item)?;
            for places in first.places..=last.places {
                let buffer = Buffer { places, ..first };
                if seen.insert(buffer) {
                    list.push(buffer);
                }
                if list.len() > MOST {
                    return Err(format!("more than {MOST} buffers"));
                }
            }
        }
        Ok(Self(list))
    }
}

/// Reads `fifo:4` or `fifo:4..64`; gives the first and the last buffer.
fn ends(item: &str) -> Result<(Buffer, Buffer), String> {
    let wrong = || {
        let most = Buffer::MAX_PLACES;
        format!(
            "found `{item}`, expected KIND:N or KIND:N..M, KIND fifo or lru, N and M from 1 to {most}, rising"
        )
    };
    let (start, end) = item.split_once("..").map_or((item, None), |(start, end)| (start, Some(end)));
    let first: Buffer = start.parse().map_err(|_| wrong())?;
    let last: Buffer = match end {
        Some(end) => format!("{}:{end}", first.replacement).parse().map_err(|_| wrong())?,
        None => first,
    };
    if last.places < first.places { Err(wrong()) } else { Ok((first, last)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_and_repeats_become_a_list() {
        let list: BufferList = "lru:4,fifo:3..5,lru:4,fifo:4".parse().unwrap();
        assert_eq!(list.0, [Buffer::lru(4), Buffer::fifo(3), Buffer::fifo(4), Buffer::fifo(5)]);
        let names: Vec<String> = BufferList::default().0.iter().map(Buffer::to_string).collect();
        assert_eq!(names.join(",").parse(), Ok(BufferList::default()));
    }

    #[test]
    fn what_makes_no_list_is_said() {
        for wrong in [
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
            let error = wrong.parse::<BufferList>().unwrap_err();
            assert!(error.contains("expected KIND:N or KIND:N..M"), "{wrong}: {error}");
        }
        assert_eq!("fifo:1..65536".parse::<BufferList>(), Err("more than 1024 buffers".into()));
    }
}
