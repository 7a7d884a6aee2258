//! The errors of the pipeline, by who can act on them.

/// Why a model could not be processed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The model is invalid, or an option does not fit it.
    #[error(transparent)]
    Input(#[from] tristrip::Error),
    /// A result cannot be stored in the requested format.
    #[error(transparent)]
    Format(#[from] tristrip_io::Error),
    /// A result does not draw exactly the expected faces; it is not returned.
    #[error("not proven: {0}")]
    Unproven(String),
    /// The requested level of detail does not exist.
    #[error("level: found {found}, expected at most {last}, the full mesh")]
    Level {
        /// The level requested.
        found: usize,
        /// The highest level, which is the number of collapses.
        last: usize,
    },
    /// The observer cancelled.
    #[error("cancelled")]
    Cancelled,
}
