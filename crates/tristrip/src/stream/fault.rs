//! Errors of a stream: the chunk and byte, what was found, and what was expected.

use crate::text::counted;

/// An error in a stream.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{at}: found {found}, expected {expected}")]
#[non_exhaustive]
pub struct StreamError {
    /// The chunk, and the byte at which it starts.
    pub at: String,
    /// What was found.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// The limit that the stream exceeds; `None` for any other error. A stream that exceeds a limit
    /// may still be valid.
    pub exceeded: Option<ExceededLimit>,
}

/// A decoder limit, and the value that exceeds it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct ExceededLimit {
    /// What is limited.
    pub what: &'static str,
    /// The value in the stream.
    pub found: u64,
    /// The limit.
    pub limit: u64,
}

/// An error in a chunk.
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

    /// Returns the error of a chunk that exceeds a limit. `found` and `expected` contain the
    /// numbers as text.
    pub(super) fn limit(
        (found, expected): (String, String),
        what: &'static str,
        (asked, limit): (u64, u64),
    ) -> Self {
        Self { found, expected, exceeded: Some(ExceededLimit { what, found: asked, limit }) }
    }

    /// Returns the error of a chunk that visits too many corners.
    pub(super) fn corners(found: u64, limit: u64) -> Self {
        let words = format!("{} around vertices that are visited", counted(found, "corner"));
        Self::limit(
            (words, format!("at most {limit}")),
            "corners around vertices that are visited",
            (found, limit),
        )
    }
}
