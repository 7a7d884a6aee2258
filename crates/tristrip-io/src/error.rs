//! The errors of reading and writing, sorted by who can act on them.

/// Says why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The system refused.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// The bytes are not what the format asks for.
    #[error("{at}: found {found}, expected {expected}")]
    Format {
        /// Where: `line 12`, `byte 345`, `accessors[3].count`.
        at: String,
        /// What stands there.
        found: String,
        /// What the format asks for.
        expected: String,
    },
    /// The file says that it holds more than it can, or more than 32-bit ids can name.
    #[error("{at}: found {found}, the limit is {limit}")]
    LimitExceeded {
        /// Where: `line 12`, `byte 345`, `accessors[3].count`.
        at: String,
        /// How much was asked for.
        found: u64,
        /// How much there may be.
        limit: u64,
    },
    /// The geometry is not usable.
    #[error(transparent)]
    Mesh(#[from] tristrip::Error),
    /// What was asked for does not fit the format.
    #[error("{0}")]
    Unsupported(String),
}

impl Error {
    /// Says that the bytes at a place are not what the format asks for.
    pub(crate) fn format(
        at: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Format { at: at.into(), found: found.into(), expected: expected.into() }
    }
}
