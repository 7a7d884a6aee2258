//! HTTP/2 and HTTP/1.1 with TLS.

use std::fs;
use std::sync::Arc;

use rustls_pki_types::{CertificateDer, ServerName};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::{ClientConfig, RootCertStore};
use tristrip_serve::{ServerOptions, TlsFiles};

use super::Running;
use super::protocols::ask_together;

#[tokio::test]
async fn tls_with_both_protocols() {
    let dir = tempfile::tempdir().unwrap();
    let signed = rcgen::generate_simple_self_signed(["localhost".to_owned()]).unwrap();
    let files = TlsFiles { certificate: dir.path().join("cert.pem"), key: dir.path().join("key.pem") };
    fs::write(&files.certificate, signed.cert.pem()).unwrap();
    fs::write(&files.key, signed.signing_key.serialize_pem()).unwrap();
    let bytes = vec![9; 100_000];
    let server = Running::with_files(ServerOptions::default().with_tls(Some(files)), &[("a.glb", &bytes)]);
    let connect = async |protocol: &[u8]| {
        let mut roots = RootCertStore::empty();
        roots.add(CertificateDer::from(signed.cert.der().to_vec())).unwrap();
        let config = ClientConfig::builder_with_provider(Arc::new(default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap();
        let mut config = config.with_root_certificates(roots).with_no_client_auth();
        config.alpn_protocols = vec![protocol.to_vec()];
        let socket = TcpStream::connect(server.address).await.unwrap();
        let name = ServerName::try_from("localhost").unwrap();
        TlsConnector::from(Arc::new(config)).connect(name, socket).await.unwrap()
    };
    ask_together(connect(b"h2").await, "localhost", &bytes).await;
    let mut old = connect(b"http/1.1").await;
    old.write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        .await
        .unwrap();
    let mut answer = Vec::new();
    old.read_to_end(&mut answer).await.unwrap();
    assert!(super::client::parse(&answer).unwrap().body == bytes);
    tokio::task::spawn_blocking(move || drop(server)).await.unwrap();
}
