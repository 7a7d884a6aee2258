//! Errors of reading and writing, grouped by who can fix them.

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
    /// A count or size exceeds a limit. Readers limit the numbers of vertices and faces to 32-bit
    /// ids. They also limit the number of JSON values, and the number of decoded bytes and
    /// triangles relative to the file size. Further limits are
    /// [`TlodLimits`](crate::tlod::TlodLimits), [`ArrivalLimits`](crate::gltf::ArrivalLimits), the
    /// limits of a stream, and the total file size of [`read_beside`](crate::read_beside). Writers
    /// limit a GLB to 4 GiB, and limit the number of JSON values of a document with levels of
    /// detail.
    #[error("{at}: found {found}, the limit is {limit}")]
    LimitExceeded {
        /// The position or the quantity: `line 12`, `accessors[3].count`, `vertices of all parts`.
        at: String,
        /// The size that was found.
        found: u64,
        /// The maximum allowed size.
        limit: u64,
    },
    /// The geometry is invalid.
    #[error(transparent)]
    Mesh(#[from] tristrip::Error),
    /// The format does not support the request, or the request does not fit the model.
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

/// Returns the message of a system error without the error code.
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
