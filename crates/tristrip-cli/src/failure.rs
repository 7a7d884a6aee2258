//! Why one input could not be done: said with the file's name before it, while the other inputs go on.

use std::io;
use std::path::Path;

/// What went wrong with one input.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The input cannot be read or used.
    #[error("{0}")]
    Input(String),
    /// The result does not draw what it should; nothing was written.
    #[error("not proven: {0}")]
    Unproven(String),
    /// The output cannot be made or written.
    #[error("{0}")]
    Output(String),
}

impl Failure {
    /// Takes over a reader's error about the file of this name, which is not said twice.
    pub(crate) fn reading(name: &str, error: &tristrip_io::Error) -> Self {
        Self::Input(match error {
            tristrip_io::Error::Io { path, source } if path == name => plain(source),
            tristrip_io::Error::Io { path, source } => format!("{path}: {}", plain(source)),
            other => other.to_string(),
        })
    }

    /// Takes over a writer's error; the output's name stands in it.
    pub(crate) fn writing(error: &tristrip_io::Error) -> Self {
        Self::Output(match error {
            tristrip_io::Error::Io { path, source } => format!("{path}: {}", plain(source)),
            other => other.to_string(),
        })
    }

    /// Takes over what the system said about a file or directory.
    pub(crate) fn system(path: &Path, error: &io::Error) -> Self {
        Self::Output(format!("{}: {}", path.display(), plain(error)))
    }
}

impl From<tristrip::Error> for Failure {
    fn from(error: tristrip::Error) -> Self {
        Self::Input(error.to_string())
    }
}

/// Says what the system said, in its words, without its number.
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
