//! The failure of one input. It is reported with the name of the file, and the other inputs are still processed.

use std::io;
use std::path::Path;

/// Why an input could not be processed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The input cannot be read or used.
    #[error("{0}")]
    Input(String),
    /// The result does not draw the expected faces; nothing was written.
    #[error("not proven: {0}")]
    Unproven(String),
    /// The output cannot be created or written.
    #[error("{0}")]
    Output(String),
}

impl Failure {
    /// Converts a reader's error about the file of this name, without repeating the name.
    pub(crate) fn reading(name: &str, error: &tristrip_io::Error) -> Self {
        Self::Input(match error {
            tristrip_io::Error::Io { path, source } if path == name => plain(source),
            tristrip_io::Error::Io { path, source } => format!("{path}: {}", plain(source)),
            other => other.to_string(),
        })
    }

    /// Converts a writer's error, which contains the name of the output.
    pub(crate) fn writing(error: &tristrip_io::Error) -> Self {
        Self::Output(match error {
            tristrip_io::Error::Io { path, source } => format!("{path}: {}", plain(source)),
            other => other.to_string(),
        })
    }

    /// Converts a system error about a file or directory.
    pub(crate) fn system(path: &Path, error: &io::Error) -> Self {
        Self::Output(format!("{}: {}", path.display(), plain(error)))
    }
}

impl From<tristrip::Error> for Failure {
    fn from(error: tristrip::Error) -> Self {
        Self::Input(error.to_string())
    }
}

/// Returns the message of a system error, without its number.
fn plain(error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::NotFound {
        return "no such file or directory".into();
    }
    let message = error.to_string();
    match message.find(" (os error") {
        Some(end) => message[..end].to_lowercase(),
        None => message,
    }
}
