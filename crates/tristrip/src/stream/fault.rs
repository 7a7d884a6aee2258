//! What is wrong with a stream: the chunk and the byte, what is there, and what should be.

use crate::text::counted;

/// A fault of a stream.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{at}: found {found}, expected {expected}")]
#[non_exhaustive]
pub struct StreamError {
    /// The chunk and the byte at which it starts.
    pub at: String,
    /// What is there.
    pub found: String,
    /// What should be there.
    pub expected: String,
    /// The limit that the stream exceeds, if that is the fault: it may be valid otherwise.
    pub exceeded: Option<ExceededLimit>,
}

/// A limit of a decoder, and what a stream asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct ExceededLimit {
    /// What is limited.
    pub what: &'static str,
    /// What the stream asks for.
    pub found: u64,
    /// The limit.
    pub limit: u64,
}

/// What is wrong with a chunk.
#[derive(Debug)]
pub(super) struct ChunkFault {
    pub(super) found: String,
    pub(super) expected: String,
    pub(super) exceeded: Option<ExceededLimit>,
}

impl ChunkFault {
    pub(super) fn new(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { found: found.into(), expected: expected.into(), exceeded: None }
    }

    /// Describes a stream that exceeds a limit: `found` and `expected` with the numbers in words.
    pub(super) fn limit(
        (found, expected): (String, String),
        what: &'static str,
        (asked, limit): (u64, u64),
    ) -> Self {
        Self { found, expected, exceeded: Some(ExceededLimit { what, found: asked, limit }) }
    }

    /// Describes a stream with too many corners around the vertices that it visits.
    pub(super) fn corners(found: u64, limit: u64) -> Self {
        let words = format!("{} around vertices that are visited", counted(found, "corner"));
        Self::limit(
            (words, format!("at most {limit}")),
            "corners around vertices that are visited",
            (found, limit),
        )
    }
}
