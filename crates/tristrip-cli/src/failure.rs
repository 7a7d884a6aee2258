//! The failure of one input. It is reported with the file name, and the other inputs are still
//! processed.

use std::io;

use tristrip_io::system_message;
use tristrip_pipeline::UnprovenMetrics;
use tristrip_pipeline::text::count;

/// The hint for a missing file whose name is a shell pattern.
const PATTERN_HINT: &str = "; a pattern in quotes is not expanded: remove the quotes";

/// Why an input could not be processed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The input cannot be read or used.
    #[error("{0}")]
    Input(String),
    /// The result does not draw the expected faces; nothing was written.
    #[error("not proven: {why}")]
    Unproven {
        why: String,
        /// The metrics of the result, if it was measured.
        metrics: Option<Box<UnprovenMetrics>>,
    },
    /// The output cannot be created or written.
    #[error("{0}")]
    Output(String),
}

impl Failure {
    /// Converts a reader's error about the file of this name, without repeating the name.
    pub(crate) fn reading(name: &str, error: &tristrip_io::Error) -> Self {
        Self::Input(match error {
            tristrip_io::Error::Io { path, source } if path == name => {
                let is_pattern = source.kind() == io::ErrorKind::NotFound && path.contains(['*', '?', '[']);
                let hint = if is_pattern { PATTERN_HINT } else { "" };
                format!("{}{hint}", system_message(source))
            }
            tristrip_io::Error::Io { path, source } => format!("{path}: {}", system_message(source)),
            other => other.to_string(),
        })
    }

    /// Converts a writer's error, which contains the name of the output.
    pub(crate) fn writing(error: &tristrip_io::Error) -> Self {
        Self::Output(match error {
            tristrip_io::Error::Io { path, source } => format!("{path}: {}", system_message(source)),
            other => other.to_string(),
        })
    }
}

impl From<tristrip::Error> for Failure {
    fn from(error: tristrip::Error) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<tristrip_pipeline::Error> for Failure {
    fn from(error: tristrip_pipeline::Error) -> Self {
        use tristrip_pipeline::Error;
        match error {
            Error::Unproven { why, metrics, .. } => Self::Unproven { why, metrics },
            Error::Format(error) => Self::writing(&error),
            Error::Level { found, last } => {
                let (found, last) = (count(found), count(last));
                Self::Input(format!("level: found {found}, expected at most {last}"))
            }
            other => Self::Input(other.to_string()),
        }
    }
}

#[cfg(feature = "serve")]
impl From<tristrip_serve::Error> for Failure {
    fn from(error: tristrip_serve::Error) -> Self {
        Self::Input(error.to_string())
    }
}

impl From<tristrip_render::Error> for Failure {
    fn from(error: tristrip_render::Error) -> Self {
        match error {
            tristrip_render::Error::Pipeline(error) => error.into(),
            other => Self::Output(other.to_string()),
        }
    }
}
