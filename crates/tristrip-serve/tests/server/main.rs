//! The server over real sockets: files, hostile clients, limits, packing, protocols.

#![expect(clippy::panic, clippy::unwrap_used, reason = "a test that panics fails")]

mod client;
mod files;
mod hostile;
mod limits;
mod packing;
mod protocols;
#[cfg(feature = "tls")]
mod tls;

use std::fs;
use std::net::SocketAddr;
use std::path::Path;
use std::thread::JoinHandle;

use tempfile::TempDir;
use tristrip_serve::{Content, Error, PackingOptions, Server, ServerOptions, StopHandle};

use client::Response;

/// A server with its own directory, which ends with the test.
struct Running {
    address: SocketAddr,
    stop: StopHandle,
    thread: Option<JoinHandle<Result<(), Error>>>,
    folder: TempDir,
    cache: TempDir,
}

impl Running {
    fn new(options: ServerOptions) -> Self {
        Self::with_files(options, &[])
    }

    fn with_files(options: ServerOptions, files: &[(&str, &[u8])]) -> Self {
        let (folder, cache) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        for (name, bytes) in files {
            write(folder.path(), name, bytes);
        }
        Self::with_folders(options, folder, cache)
    }

    fn with_folders(options: ServerOptions, folder: TempDir, cache: TempDir) -> Self {
        let cache_bytes = options.packing.cache_bytes;
        let packing = options.packing.clone().with_cache(Some(cache.path().to_path_buf()), cache_bytes);
        let options = options.with_port(0).with_packing(packing);
        let server = Server::bind(Content::Folder(folder.path().to_path_buf()), &options).unwrap();
        let (address, stop) = (server.address(), server.stop_handle());
        let thread = Some(std::thread::spawn(|| server.run()));
        Self { address, stop, thread, folder, cache }
    }

    fn get(&self, path: &str) -> Response {
        self.get_with(path, "")
    }

    /// Sends a GET with additional header lines, each with its line ending.
    fn get_with(&self, path: &str, lines: &str) -> Response {
        client::request(self.address, &format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{lines}"))
    }

    /// Returns a value of `/metrics`, or 0 if it is missing.
    fn metric(&self, name: &str) -> u64 {
        let text = self.get("/metrics").text();
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.map_or(0, |value| value.parse().unwrap())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.stop.stop();
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap().unwrap();
        }
    }
}

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// Returns options with packing on demand.
fn packs() -> ServerOptions {
    ServerOptions::default().with_packing(PackingOptions::default().with_on_demand(true))
}

/// Returns a grid with this many squares along each side, as OBJ.
fn grid(side: usize) -> Vec<u8> {
    let row = |y: usize| (0..=side).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
    let n = side + 1;
    let square = move |i: usize| {
        (i..i + side).map(move |i| format!("f {} {} {} {}\n", i + 1, i + 2, i + n + 2, i + n + 1))
    };
    (0..=side).flat_map(row).chain((0..side).flat_map(|y| square(n * y))).collect::<String>().into_bytes()
}
