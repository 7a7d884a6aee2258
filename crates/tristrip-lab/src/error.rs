//! The errors of measurements, charts and reproductions.

use std::io;
use std::path::Path;

use tristrip_io::system_message;

/// Why a measurement, chart or reproduction failed.
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
        /// The reason.
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
    /// The path of a directory is a file.
    #[error("{0}: found a file, expected a directory")]
    NotADirectory(String),
    /// The data of a paper is invalid.
    #[error("{0}")]
    Data(String),
    /// A chart or an image could not be drawn.
    #[error(transparent)]
    Render(tristrip_render::Error),
    /// The user interrupted before all results were available.
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

impl From<tristrip_render::Error> for Error {
    fn from(error: tristrip_render::Error) -> Self {
        match error {
            tristrip_render::Error::Pipeline(error) => Self::Pipeline(error),
            other => Self::Render(other),
        }
    }
}
