//! Why a command failed, by its exit code.

use tristrip_io::system_message;

/// Why a command failed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Wrong usage: exit code 2.
    Usage(String),
    /// A bad input or output, or a result that is not proven: exit code 1.
    Failed(String),
    /// A failure with exit code 1 whose message has been printed.
    Reported,
}

impl From<tristrip_io::Error> for Failure {
    fn from(error: tristrip_io::Error) -> Self {
        Self::Failed(match error {
            tristrip_io::Error::Io { path, source } => format!("{path}: {}", system_message(&source)),
            other => other.to_string(),
        })
    }
}

impl From<tristrip::Error> for Failure {
    fn from(error: tristrip::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<tristrip_pipeline::Error> for Failure {
    fn from(error: tristrip_pipeline::Error) -> Self {
        match error {
            tristrip_pipeline::Error::Unproven { why, .. } => Self::Failed(format!("not proven: {why}")),
            tristrip_pipeline::Error::Format(error) => error.into(),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<tristrip_render::Error> for Failure {
    fn from(error: tristrip_render::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<tristrip_lab::Error> for Failure {
    fn from(error: tristrip_lab::Error) -> Self {
        match error {
            tristrip_lab::Error::Pipeline(error) => error.into(),
            other => Self::Failed(other.to_string()),
        }
    }
}
