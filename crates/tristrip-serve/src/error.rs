//! The errors of the server, by who must act.

use std::io;
use std::net::SocketAddr;

use tristrip_io::system_message;

/// Why a server cannot start or go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file or directory cannot be read or written.
    #[error("{path}: {}", system_message(.source))]
    Io {
        /// The file or directory.
        path: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The address cannot be used: another program has the port, or it is not one of this machine.
    #[error("{address}: {}", system_message(.source))]
    Address {
        /// The address and the port.
        address: SocketAddr,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The certificate and its key cannot be used.
    #[error("TLS: {0}")]
    Tls(String),
    /// An option has a value that cannot be used.
    #[error("{name}: found {found}, expected {expected}")]
    Parameter {
        /// The name of the option.
        name: &'static str,
        /// Its value.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
    /// The operating system refuses threads, timers or signals.
    #[error("server: {}", system_message(.0))]
    System(#[source] io::Error),
}

impl Error {
    /// Builds the error of a file or directory.
    pub(crate) fn io(path: &std::path::Path, source: io::Error) -> Self {
        Self::Io { path: path.display().to_string(), source }
    }
}
