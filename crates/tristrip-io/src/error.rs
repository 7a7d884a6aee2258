//! The errors of reading and writing, sorted by who can act on them.

/// The reason why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file system operation failed.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: String,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The bytes do not conform to the format.
    #[error("{at}: found {found}, expected {expected}")]
    Format {
        /// The position: `line 12`, `byte 345`, `accessors[3].count`.
        at: String,
        /// What was found there.
        found: String,
        /// What the format requires.
        expected: String,
    },
    /// The file states a size that exceeds a limit, such as what 32-bit ids can name.
    #[error("{at}: found {found}, the limit is {limit}")]
    LimitExceeded {
        /// The position: `line 12`, `byte 345`, `accessors[3].count`.
        at: String,
        /// The size that was found.
        found: u64,
        /// The largest size that is allowed.
        limit: u64,
    },
    /// The geometry is invalid.
    #[error(transparent)]
    Mesh(#[from] tristrip::Error),
    /// The request is not supported by the format, or does not fit the model.
    #[error("{0}")]
    Unsupported(String),
}

impl Error {
    /// Builds the error for bytes that do not conform to the format.
    pub(crate) fn format(
        at: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Format { at: at.into(), found: found.into(), expected: expected.into() }
    }
}

/// Returns the message of a system error, without its number.
///
/// ```
/// let error = std::io::Error::from(std::io::ErrorKind::NotFound);
/// assert_eq!(tristrip_io::system_message(&error), "no such file or directory");
/// ```
pub fn system_message(error: &std::io::Error) -> String {
    if error.kind() == std::io::ErrorKind::NotFound {
        return "no such file or directory".into();
    }
    let message = error.to_string();
    match message.find(" (os error") {
        Some(end) => message[..end].to_lowercase(),
        None => message,
    }
}
