//! HTTP/2 without TLS, and invalid options.

use std::time::Duration;

use axum::body::Body;
use bytes::Bytes;
use futures_util::future::join_all;
use http_body_util::BodyExt;
use hyper::client::conn::http2;
use hyper::{Request, Version};
use hyper_util::rt::{TokioExecutor, TokioIo};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tristrip_serve::{Content, Error, Limits, Server, ServerOptions};

use super::Running;

/// Requests a file 20 times at once over one HTTP/2 connection.
pub(super) async fn ask_together(
    io: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
    authority: &str,
    bytes: &[u8],
) {
    let (sender, connection) = http2::handshake(TokioExecutor::new(), TokioIo::new(io)).await.unwrap();
    tokio::spawn(connection);
    let asked = (0..20).map(|_| {
        let mut sender = sender.clone();
        let request = Request::get(format!("http://{authority}/files/a.glb")).body(Body::empty()).unwrap();
        async move {
            let response = sender.send_request(request).await.unwrap();
            assert_eq!((response.status().as_u16(), response.version()), (200, Version::HTTP_2));
            response.into_body().collect().await.unwrap().to_bytes()
        }
    });
    let bodies: Vec<Bytes> = join_all(asked).await;
    assert!(bodies.iter().all(|body| *body == bytes));
}

#[tokio::test]
async fn http2_without_tls_on_the_same_port() {
    let bytes: Vec<u8> = (0..=250).cycle().take(300_000).collect();
    let server = Running::with_files(ServerOptions::default(), &[("a.glb", &bytes)]);
    ask_together(TcpStream::connect(server.address).await.unwrap(), "localhost", &bytes).await;
    let socket = TcpStream::connect(server.address).await.unwrap();
    let (mut sender, connection) =
        http2::handshake(TokioExecutor::new(), TokioIo::new(socket)).await.unwrap();
    tokio::spawn(connection);
    let request = Request::get("http://evil.example/files/a.glb").body(Body::empty()).unwrap();
    assert_eq!(sender.send_request(request).await.unwrap().status().as_u16(), 403);
    drop(sender);
    // The server waits for its connections to end on another thread.
    tokio::task::spawn_blocking(move || drop(server)).await.unwrap();
}

#[tokio::test]
async fn streams_of_http2_count_as_connections() {
    let bytes = vec![9; 20_000_000];
    let limits = Limits::default().with_connections(10, 3);
    let server = Running::with_files(ServerOptions::default().with_limits(limits), &[("a.glb", &bytes)]);
    let socket = TcpStream::connect(server.address).await.unwrap();
    let (mut sender, connection) =
        http2::handshake(TokioExecutor::new(), TokioIo::new(socket)).await.unwrap();
    tokio::spawn(connection);
    let mut unread = Vec::new();
    for status in [200, 200, 200, 503, 503] {
        let request = Request::get("http://localhost/files/a.glb").body(Body::empty()).unwrap();
        let response = sender.send_request(request).await.unwrap();
        assert_eq!(response.status().as_u16(), status);
        unread.push(response.into_body());
    }
    drop((unread, sender));
    tokio::task::spawn_blocking(move || drop(server)).await.unwrap();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stream_that_is_not_read_is_ended_and_others_go_on() {
    let bytes = vec![9; 8_000_000];
    let limits = Limits::default().with_stall_time(Duration::from_secs(2));
    let server = Running::with_files(ServerOptions::default().with_limits(limits), &[("a.glb", &bytes)]);
    let socket = TcpStream::connect(server.address).await.unwrap();
    let (sender, connection) = http2::handshake(TokioExecutor::new(), TokioIo::new(socket)).await.unwrap();
    tokio::spawn(connection);
    let get = async || {
        let request = Request::get("http://localhost/files/a.glb").body(Body::empty()).unwrap();
        sender.clone().send_request(request).await.unwrap().into_body()
    };
    let (unread, slow) = (get().await, get().await);
    // In total this takes longer than the limit, but no pause between bytes does.
    let slow = tokio::spawn(async move {
        let (mut slow, mut received) = (slow, 0);
        while let Some(frame) = slow.frame().await {
            received += frame.unwrap().into_data().map_or(0, |data| data.len());
            tokio::time::sleep(Duration::from_millis(8)).await;
        }
        received
    });
    let ended = || server.metric("tristrip_refused_connections_total{limit=\"stream-stall-time\"}");
    while tokio::task::block_in_place(ended) == 0 {
        assert!(get().await.collect().await.unwrap().to_bytes() == bytes);
    }
    // The bytes within the client's window arrive; then the stream ends.
    let ended = unread.collect().await;
    assert!(
        ended.is_err_and(
            |error| error.to_string().contains("stream") || format!("{error:?}").contains("Reset")
        )
    );
    assert_eq!(slow.await.unwrap(), bytes.len());
    assert!(get().await.collect().await.unwrap().to_bytes() == bytes);
    drop(sender);
    tokio::task::spawn_blocking(move || {
        assert_eq!(server.metric("tristrip_refused_connections_total{limit=\"stream-stall-time\"}"), 1);
        drop(server);
    })
    .await
    .unwrap();
}

#[test]
fn wrong_options_are_named() {
    let dir = tempfile::tempdir().unwrap();
    let first = Server::bind(Content::Folder(dir.path().into()), &cached(dir.path()).with_port(0)).unwrap();
    let again = cached(dir.path()).with_port(first.address().port());
    let error = Server::bind(Content::Folder(dir.path().into()), &again).unwrap_err();
    assert!(matches!(error, Error::Address { .. }), "{error}");
    let missing = Server::bind(Content::Folder(dir.path().join("none")), &cached(dir.path())).unwrap_err();
    assert!(missing.to_string().ends_with("none: no such file or directory"), "{missing}");
    let cors = cached(dir.path()).with_port(0).with_cors(vec!["example.org".into()]);
    let error = Server::bind(Content::Folder(dir.path().into()), &cors).unwrap_err();
    assert!(matches!(error, Error::Parameter { name: "cors", .. }), "{error}");
}

fn cached(dir: &std::path::Path) -> ServerOptions {
    let packing = tristrip_serve::PackingOptions::default().with_cache(Some(dir.join("cache")), 0);
    ServerOptions::default().with_packing(packing)
}
