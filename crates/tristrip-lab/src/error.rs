//! The errors of measurements, charts and reproductions.

use std::io;
use std::path::Path;

/// Why something could not be measured, drawn or reproduced.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A model could not be processed, or a result is not proven.
    #[error(transparent)]
    Pipeline(#[from] tristrip_pipeline::Error),
    /// A method of a comparison failed.
    #[error("pareto: {label}: {source}")]
    Method {
        /// The label of the method.
        label: String,
        /// What failed.
        source: tristrip_pipeline::Error,
    },
    /// A file or directory could not be read or written.
    #[error("{path}: {}", system_message(.source))]
    Io {
        /// The file or directory.
        path: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A directory is needed, but there is a file.
    #[error("{0}: found a file, expected a directory")]
    NotADirectory(String),
    /// The data of a paper is invalid.
    #[error("{0}")]
    Data(String),
    /// A chart could not be drawn.
    #[error("chart: {0}")]
    Chart(String),
    /// A picture cannot be drawn as requested.
    #[error("picture: {0}")]
    Picture(String),
    /// The user interrupted before all results were there.
    #[error("{0}: interrupted")]
    Interrupted(&'static str),
}

impl Error {
    /// Builds the error of a file or directory.
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { path: path.display().to_string(), source }
    }
}

impl From<tristrip::Error> for Error {
    fn from(error: tristrip::Error) -> Self {
        Self::Pipeline(error.into())
    }
}

/// Returns the message of a system error, without its number.
///
/// ```
/// let error = std::io::Error::from(std::io::ErrorKind::NotFound);
/// assert_eq!(tristrip_lab::system_message(&error), "no such file or directory");
/// ```
pub fn system_message(error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::NotFound {
        return "no such file or directory".into();
    }
    let message = error.to_string();
    match message.find(" (os error") {
        Some(end) => message[..end].to_lowercase(),
        None => message,
    }
}
