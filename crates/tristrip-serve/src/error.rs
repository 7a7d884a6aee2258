//! The errors of the server, grouped by who must act.

use std::io;
use std::net::SocketAddr;

use tristrip_io::system_message;

/// An error that keeps a server from starting or running.
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
    /// The address cannot be used: another program uses the port, or the address does not belong to
    /// this machine.
    #[error("{address}: {}", system_message(.source))]
    Address {
        /// The address and the port.
        address: SocketAddr,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The certificate or its key cannot be used.
    #[error("TLS: {0}")]
    Tls(String),
    /// The value of an option is not valid.
    #[error("{name}: found {found}, expected {expected}")]
    Parameter {
        /// The name of the option.
        name: &'static str,
        /// The invalid value.
        found: String,
        /// The expected values.
        expected: &'static str,
    },
    /// The operating system does not provide threads, timers or signal handlers.
    #[error("server: {}", system_message(.0))]
    System(#[source] io::Error),
}

impl Error {
    /// Builds the error of a file or directory.
    pub(crate) fn io(path: &std::path::Path, source: io::Error) -> Self {
        Self::Io { path: path.display().to_string(), source }
    }
}
