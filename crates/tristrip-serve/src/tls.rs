//! HTTPS with a given certificate. The client chooses between HTTP/2 and HTTP/1.1.

use std::fmt;
use std::io;
use std::sync::Arc;

use rustls_pki_types::pem::PemObject;
use rustls_pki_types::{CertificateDer, PrivateKeyDer};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::ServerConfig;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::server::TlsStream;

use crate::error::Error;
use crate::options::{ServerOptions, TlsFiles};

/// The certificate in use.
#[derive(Clone)]
pub(crate) struct Tls(TlsAcceptor);

impl fmt::Debug for Tls {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Tls")
    }
}

impl Tls {
    /// Reads the certificate that the options name, if any.
    pub(crate) fn from_options(options: &ServerOptions) -> Result<Option<Self>, Error> {
        options.tls.as_ref().map(|files| acceptor(files).map(Self)).transpose()
    }

    /// Performs the handshake of a connection.
    pub(crate) async fn accept<S>(&self, stream: S) -> io::Result<TlsStream<S>>
    where
        S: AsyncRead + AsyncWrite + Unpin,
    {
        self.0.accept(stream).await
    }
}

/// Reads the certificate and its key.
fn acceptor(files: &TlsFiles) -> Result<TlsAcceptor, Error> {
    let of_file =
        |path: &std::path::Path, message: String| Error::Tls(format!("{}: {message}", path.display()));
    let certificates: Vec<CertificateDer<'static>> = CertificateDer::pem_file_iter(&files.certificate)
        .and_then(Iterator::collect)
        .map_err(|error| of_file(&files.certificate, error.to_string()))?;
    if certificates.is_empty() {
        return Err(of_file(&files.certificate, "found no certificate, expected one in PEM".into()));
    }
    let key =
        PrivateKeyDer::from_pem_file(&files.key).map_err(|error| of_file(&files.key, error.to_string()))?;
    let config = ServerConfig::builder_with_provider(Arc::new(default_provider()))
        .with_safe_default_protocol_versions()
        .and_then(|builder| builder.with_no_client_auth().with_single_cert(certificates, key));
    let mut config = config.map_err(|error| Error::Tls(error.to_string()))?;
    config.alpn_protocols = vec![b"h2".to_vec(), b"http/1.1".to_vec()];
    Ok(TlsAcceptor::from(Arc::new(config)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn certificates_are_read_and_problems_named() {
        let dir = tempfile::tempdir().unwrap();
        let signed = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
        let files = TlsFiles { certificate: dir.path().join("cert.pem"), key: dir.path().join("key.pem") };
        std::fs::write(&files.certificate, signed.cert.pem()).unwrap();
        let message = |files: &TlsFiles| acceptor(files).err().unwrap().to_string();
        assert!(message(&files).contains("key.pem"));
        std::fs::write(&files.key, signed.signing_key.serialize_pem()).unwrap();
        assert!(acceptor(&files).is_ok());
        let other = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
        std::fs::write(&files.key, other.signing_key.serialize_pem()).unwrap();
        assert!(message(&files).starts_with("TLS: "));
        std::fs::write(&files.certificate, "no certificate").unwrap();
        assert!(message(&files).contains("found no certificate"));
    }
}
