//! Limits: connections, slow heads, clients that read nothing, bandwidth, and stopping a server.

use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use tristrip_serve::{Limits, ServerOptions};

use super::Running;
use super::client::{connect, parse, read};

const MILLION: usize = 1_000_000;
/// The maximum time that a test waits for the server to react.
const PATIENCE: Duration = Duration::from_mins(1);

fn with(limits: Limits) -> ServerOptions {
    ServerOptions::default().with_limits(limits)
}

/// Reads until the server closes the connection. The socket has a time limit.
fn wait_for_close(mut socket: impl Read) -> Vec<u8> {
    let mut bytes = Vec::new();
    if let Err(error) = socket.read_to_end(&mut bytes) {
        assert_ne!(error.kind(), ErrorKind::WouldBlock, "the connection stays open");
    }
    bytes
}

#[test]
fn connections_over_a_limit_are_refused() {
    let server = Running::new(with(Limits::default().with_connections(10, 3)));
    let mut open: Vec<_> = (0..3).map(|_| connect(server.address)).collect();
    // Connections count once they are accepted.
    for socket in &mut open {
        socket.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        assert!(socket.read(&mut [0; 512]).unwrap() > 0);
    }
    let mut refused = connect(server.address);
    let mut bytes = Vec::new();
    refused.read_to_end(&mut bytes).unwrap_or_default();
    let response = parse(&bytes).unwrap();
    assert_eq!((response.status, response.header("retry-after")), (503, "1"));
    drop(open.pop());
    // The server notices the closed connection a moment later.
    let start = Instant::now();
    while parse(&attempt(&server)).is_none_or(|response| response.status != 200) {
        assert!(start.elapsed() < PATIENCE);
    }
    drop(open);
    while server_metric(&server) == 0 {
        assert!(start.elapsed() < PATIENCE);
    }
}

fn attempt(server: &Running) -> Vec<u8> {
    let mut socket = connect(server.address);
    socket
        .write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")
        .unwrap_or_default();
    let mut bytes = Vec::new();
    socket.read_to_end(&mut bytes).unwrap_or_default();
    bytes
}

fn server_metric(server: &Running) -> u64 {
    server.metric("tristrip_refused_connections_total{limit=\"client\"}")
}

#[test]
fn slow_heads_and_idle_connections_are_closed_and_hold_up_nobody() {
    let limits = Limits::default()
        .with_headers(16 << 10, Duration::from_millis(400))
        .with_idle_time(Duration::from_millis(300));
    let server = Running::new(with(limits));
    // Nothing, half a head, half a head a letter at a time, half the preface of HTTP/2.
    let silent = connect(server.address);
    let mut half = connect(server.address);
    half.write_all(b"GET / HTTP/1.1\r\nHost: local").unwrap();
    let mut preface = connect(server.address);
    preface.write_all(b"PRI * HTTP/2").unwrap();
    let mut slow = connect(server.address);
    let mut writer = slow.try_clone().unwrap();
    let writing = std::thread::spawn(move || {
        for letter in
            b"GET /healthz HTTP/1.1\r\nHost: localhost\r\nAaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa: a\r\n\r\n"
        {
            if writer.write_all(&[*letter]).is_err() {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    });
    assert_eq!(server.get("/healthz").status, 200);
    for socket in [silent, half, preface] {
        wait_for_close(socket);
    }
    let mut bytes = Vec::new();
    slow.read_to_end(&mut bytes).unwrap_or_default();
    assert!(parse(&bytes).is_none_or(|response| response.status == 408));
    writing.join().unwrap();
    let mut idle = connect(server.address);
    idle.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    wait_for_close(idle);
}

/// Requests a file that is larger than the buffers of both sockets on connections that read
/// nothing.
fn stall(server: &Running, count: usize) -> Vec<std::net::TcpStream> {
    let mut stalled: Vec<_> = (0..count).map(|_| connect(server.address)).collect();
    for socket in &mut stalled {
        socket.write_all(b"GET /files/large.glb HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    }
    stalled
}

#[test]
fn clients_that_read_nothing_hold_up_nobody() {
    let large = vec![5; 20 * MILLION];
    // No connection is closed during the test.
    let limits = Limits::default().with_stall_time(Duration::from_hours(1));
    let server = Running::with_files(with(limits), &[("large.glb", &large), ("small.glb", b"a")]);
    let stalled = stall(&server, 20);
    for _ in 0..20 {
        assert_eq!(server.get("/files/small.glb").body, b"a");
    }
    assert!(server.get("/files/large.glb").body == large);
    drop(stalled);
}

#[test]
fn a_client_that_reads_nothing_is_closed() {
    let large = vec![5; 20 * MILLION];
    let limits = Limits::default().with_stall_time(Duration::from_millis(500));
    let server = Running::with_files(with(limits), &[("large.glb", &large)]);
    let stalled = stall(&server, 1);
    std::thread::sleep(Duration::from_millis(1500));
    for socket in stalled {
        assert!(wait_for_close(socket).len() < large.len(), "the connection was not closed");
    }
}

#[test]
fn every_response_has_the_bandwidth_of_its_own() {
    // One byte per second: 64 bytes immediately, and the next ones after a minute, when the server
    // has ended.
    let limits = Limits::default().with_grace_time(Duration::ZERO);
    let mut server = Running::with_files(with(limits).with_bandwidth(Some(8)), &[("a.glb", &vec![3; 1000])]);
    let mut sockets = [(); 2].map(|()| connect(server.address));
    for socket in &mut sockets {
        socket.write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    }
    let bodies = sockets.map(|mut socket| {
        let mut bytes = Vec::new();
        while parse(&bytes).is_none_or(|response| response.body.is_empty()) {
            let mut piece = [0; 512];
            let count = socket.read(&mut piece).unwrap();
            bytes.extend(&piece[..count]);
        }
        (socket, bytes)
    });
    server.stop.stop();
    server.thread.take().unwrap().join().unwrap().unwrap();
    for (socket, mut bytes) in bodies {
        bytes.extend(wait_for_close(socket));
        assert_eq!(parse(&bytes).unwrap().body, [3; 64]);
    }
}

#[test]
fn running_responses_end_before_the_server_does() {
    let bytes = vec![3; 100_000];
    let mut server =
        Running::with_files(ServerOptions::default().with_bandwidth(Some(2_000_000)), &[("a.glb", &bytes)]);
    let mut idle = connect(server.address);
    idle.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let mut socket = connect(server.address);
    socket.write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let mut first = [0; 1];
    socket.read_exact(&mut first).unwrap();
    server.stop.stop();
    let response = read(&mut first.chain(socket));
    assert!(response.body == bytes);
    server.thread.take().unwrap().join().unwrap().unwrap();
    assert!(std::net::TcpStream::connect(server.address).is_err());
}

#[test]
fn the_grace_time_ends_what_does_not_end_itself() {
    let limits = Limits::default().with_grace_time(Duration::from_millis(200));
    let mut server =
        Running::with_files(with(limits).with_bandwidth(Some(8000)), &[("a.glb", &vec![3; MILLION])]);
    let mut socket = connect(server.address);
    socket.write_all(b"GET /files/a.glb HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    socket.read_exact(&mut [0; 100]).unwrap();
    server.stop.stop();
    server.thread.take().unwrap().join().unwrap().unwrap();
    assert!(wait_for_close(socket).len() < MILLION, "the response has ended before the server");
}
