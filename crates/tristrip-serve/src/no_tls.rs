//! Replaces the module `tls` if the feature `tls` is off. A server then has no certificate.

use std::future::Ready;
use std::io;

use crate::error::Error;
use crate::options::ServerOptions;

/// The certificate in use. This type has no values.
#[derive(Debug, Clone)]
pub(crate) enum Tls {}

impl Tls {
    /// Returns `None`: without the feature, options cannot contain a certificate.
    #[expect(clippy::unnecessary_wraps, reason = "the signature with the feature")]
    pub(crate) fn from_options(_: &ServerOptions) -> Result<Option<Self>, Error> {
        Ok(None)
    }

    /// Never called.
    pub(crate) fn accept<S>(&self, _: S) -> Ready<io::Result<S>> {
        match *self {}
    }
}
