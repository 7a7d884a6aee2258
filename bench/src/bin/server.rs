//! Tests the limits of the web server: many concurrent clients, slow clients, hostile paths, a kill
//! while it packs, and requests per second on one core.
//!
//! ```text
//! cargo run --profile dist -p tristrip-bench --bin server
//! ```
//! The server is a separate process with its own memory and core. Each response is compared with
//! the expected bytes.

#![allow(clippy::print_stdout, reason = "a program that prints")]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use tristrip_bench::failure::Failure;
use tristrip_serve::{Content, Limits, PackingOptions, Server, ServerOptions};

/// The limits of the server.
const MAX_MEMORY_BYTES: u64 = 200 << 20;
const FEWEST_REQUESTS_PER_SECOND: f64 = 1000.0;
/// The maximum time that slow clients may delay another client.
const MAX_HELD_UP: Duration = Duration::from_secs(1);

/// Measure the web server
#[derive(Debug, Parser)]
struct Args {
    /// The number of concurrent clients
    #[arg(long, default_value_t = 500)]
    clients: usize,
    /// The bytes per second that each client reads
    #[arg(long, default_value_t = 1_000_000)]
    rate: u64,
    /// The size of the file that they read, in bytes
    #[arg(long, default_value_t = 8_000_000)]
    bytes: usize,
    /// The squares along each side of the model that is packed when the server is killed
    #[arg(long, default_value_t = 300)]
    side: usize,
    /// Serve this directory, with the cache in it; the benchmark starts the server this way
    #[arg(long, hide = true)]
    serve: Option<PathBuf>,
}

fn main() -> ExitCode {
    let args = Args::parse();
    let done = match &args.serve {
        Some(directory) => serve(directory).map(|()| true),
        None => measure(&args),
    };
    match done {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            println!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Serves until standard input ends. The first line of standard output is the address.
fn serve(directory: &Path) -> Result<(), Failure> {
    let packing =
        PackingOptions::default().with_on_demand(true).with_cache(Some(directory.join(".cache")), 1 << 30);
    let limits = Limits::default().with_connections(2048, 1024);
    let options = ServerOptions::default().with_port(0).with_packing(packing).with_limits(limits);
    let server = Server::bind(Content::Folder(directory.to_path_buf()), &options)?;
    let stop = server.stop_handle();
    println!("{}", server.address());
    std::thread::spawn(move || {
        std::io::stdin().read(&mut [0]).unwrap_or_default();
        stop.stop();
    });
    Ok(server.run()?)
}

/// Measures everything. Returns whether all limits are met.
fn measure(args: &Args) -> Result<bool, Failure> {
    let directory = tempfile::tempdir()?;
    let large: Vec<u8> =
        (0..args.bytes as u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
    std::fs::write(directory.path().join("large.glb"), &large)?;
    std::fs::write(directory.path().join("small.glb"), &large[..1000])?;
    std::fs::write(directory.path().join("first.obj"), grid(40))?;
    std::fs::write(directory.path().join("second.obj"), grid(args.side))?;
    let mut reached = many_clients(args, directory.path(), &large)?;
    reached &= slow_clients(directory.path(), &large[..1000])?;
    reached &= hostile_paths(directory.path())?;
    reached &= killed(directory.path())?;
    reached &= requests_per_second(directory.path(), &large[..1000])?;
    Ok(reached)
}

/// Reads one file with many clients, each at its rate.
fn many_clients(args: &Args, directory: &Path, expected: &[u8]) -> Result<bool, Failure> {
    let server = Process::start(directory, None)?;
    let (failed, start) = (AtomicUsize::new(0), Instant::now());
    std::thread::scope(|scope| {
        for _ in 0..args.clients {
            let read = || {
                if !matches!(paced(server.address, args.rate, expected), Ok(true)) {
                    failed.fetch_add(1, Ordering::Relaxed);
                }
            };
            // The data of a client is on the heap.
            if std::thread::Builder::new().stack_size(128 << 10).spawn_scoped(scope, read).is_err() {
                failed.fetch_add(1, Ordering::Relaxed);
            }
        }
    });
    let seconds = start.elapsed().as_secs_f64();
    let (failed, memory) = (failed.into_inner(), server.most_memory()?);
    let rate = args.clients as f64 * expected.len() as f64 / seconds / 1e6;
    println!(
        "{} clients at {} kB/s: {failed} failed, {seconds:.1} s, {rate:.0} MB/s in all, {:.1} MiB of memory",
        args.clients,
        args.rate / 1000,
        memory as f64 / f64::from(1 << 20)
    );
    Ok(failed == 0 && memory <= MAX_MEMORY_BYTES)
}

/// Reads the large file at a rate. Returns whether all its bytes arrived.
fn paced(address: SocketAddr, rate: u64, expected: &[u8]) -> std::io::Result<bool> {
    let mut socket = TcpStream::connect(address)?;
    socket.set_read_timeout(Some(Duration::from_mins(1)))?;
    socket.write_all(&request("/files/large.glb", "close"))?;
    let mut start = Vec::new();
    let mut byte = [0];
    while !start.ends_with(b"\r\n\r\n") {
        socket.read_exact(&mut byte)?;
        start.extend(byte);
    }
    let (begun, mut at, mut piece) = (Instant::now(), 0, vec![0; 32 << 10]);
    loop {
        let count = socket.read(&mut piece)?;
        if count == 0 {
            return Ok(start.starts_with(b"HTTP/1.1 200") && at == expected.len());
        }
        if expected.get(at..at + count) != Some(&piece[..count]) {
            return Ok(false);
        }
        at += count;
        let due = Duration::from_secs_f64(at as f64 / rate as f64);
        std::thread::sleep(due.saturating_sub(begun.elapsed()));
    }
}

/// Requests a small file while other clients send incomplete headers, or read nothing.
fn slow_clients(directory: &Path, expected: &[u8]) -> Result<bool, Failure> {
    let server = Process::start(directory, None)?;
    let mut slow = Vec::new();
    for number in 0..400 {
        let mut socket = TcpStream::connect(server.address)?;
        if number % 2 == 0 {
            socket.write_all(b"GET /files/small.glb HTTP/1.1\r\nHost: loc")?;
        } else {
            socket.write_all(&request("/files/large.glb", "close"))?;
        }
        slow.push(socket);
    }
    let mut times = Vec::new();
    for _ in 0..200 {
        let start = Instant::now();
        let is_right = get(server.address, "/files/small.glb")? == (200, expected.to_vec());
        times.push(if is_right { start.elapsed() } else { Duration::MAX });
    }
    times.sort();
    let (median, most) = (times[times.len() / 2], times[times.len() - 1]);
    println!("with 200 slow requests and 200 slow readers: median {median:.1?}, at most {most:.1?}");
    Ok(most <= MAX_HELD_UP)
}

/// Requests paths outside the directory in more than 200 ways.
fn hostile_paths(directory: &Path) -> Result<bool, Failure> {
    let server = Process::start(directory, None)?;
    let ups = [
        "..",
        "%2e%2e",
        ".%2e",
        "%2E%2E",
        "..%00",
        "%c0%ae%c0%ae",
        "%252e%252e",
        "....",
        "..;",
        "C:",
        "CON",
        ".cache",
    ];
    let (mut count, mut wrong) = (0, 0);
    for up in ups {
        for separator in ["/", "%2f", "%5c", "//", "/./", "%00/"] {
            for depth in [1, 3] {
                for route in ["/files/", "/packed/", "/thumbnails/", "/src/"] {
                    let target = if route == "/packed/" { "etc/passwd.glb" } else { "etc/passwd" };
                    let path = format!("{route}{}{target}", format!("{up}{separator}").repeat(depth));
                    let (status, _) = get(server.address, &path)?;
                    count += 1;
                    wrong += usize::from(!(400..500).contains(&status));
                }
            }
        }
    }
    println!("{count} hostile paths: {wrong} without a client error");
    Ok(wrong == 0)
}

/// Kills the server while it packs, at several moments. The cached files must remain, and the next
/// request must succeed.
fn killed(directory: &Path) -> Result<bool, Failure> {
    let first = {
        let server = Process::start(directory, None)?;
        get(server.address, "/packed/first.obj.glb")?.1
    };
    let mut intact = 0;
    let delays = [0, 20, 50, 100, 200, 400];
    for delay in delays {
        let mut server = Process::start(directory, None)?;
        let mut socket = TcpStream::connect(server.address)?;
        socket.write_all(&request("/packed/second.obj.glb", "close"))?;
        while figure(server.address, "tristrip_jobs_running ")? == 0 {
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_millis(delay));
        // On Unix this is SIGKILL.
        server.child.kill()?;
        server.child.wait()?;
        let server = Process::start(directory, None)?;
        let again = get(server.address, "/packed/first.obj.glb")? == (200, first.clone());
        let is_cached = figure(server.address, "tristrip_cache_hits_total ")? == 1;
        let left = std::fs::read_dir(directory.join(".cache"))?.flatten();
        let is_clean =
            left.filter(|entry| entry.path().extension().is_some_and(|found| found == "writing")).count()
                == 0;
        intact += usize::from(again && is_cached && is_clean);
    }
    let server = Process::start(directory, None)?;
    let (status, second) = get(server.address, "/packed/second.obj.glb")?;
    let model = tristrip_io::read_path(directory.join("second.obj"))?;
    let expected = tristrip_pipeline::pack::run(&model, &tristrip_pipeline::pack::Options::default(), &())?;
    let is_right = status == 200 && second == expected.bytes;
    println!(
        "killed {} times while packing: cache intact {intact} times, the file is packed afterwards: {is_right}",
        delays.len()
    );
    Ok(intact == delays.len() && is_right)
}

/// Requests a small file as often as possible. The server has one core.
fn requests_per_second(directory: &Path, expected: &[u8]) -> Result<bool, Failure> {
    let server = Process::start(directory, Some("0"))?;
    let (done, start) = (AtomicUsize::new(0), Instant::now());
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                let asked = ask_repeatedly(server.address, expected, start + Duration::from_secs(3));
                done.fetch_add(asked.unwrap_or(0), Ordering::Relaxed);
            });
        }
    });
    let rate = done.into_inner() as f64 / start.elapsed().as_secs_f64();
    println!("{rate:.0} requests per second of 1000 bytes on one core, 8 connections");
    Ok(rate >= FEWEST_REQUESTS_PER_SECOND)
}

fn ask_repeatedly(address: SocketAddr, expected: &[u8], end: Instant) -> std::io::Result<usize> {
    let mut socket = TcpStream::connect(address)?;
    socket.set_nodelay(true)?;
    let (request, mut count, mut answer) = (request("/files/small.glb", "keep-alive"), 0, vec![0; 4096]);
    while Instant::now() < end {
        socket.write_all(&request)?;
        let mut filled = 0;
        while !answer[..filled].ends_with(expected) {
            match socket.read(&mut answer[filled..])? {
                0 => return Ok(count),
                read => filled += read,
            }
        }
        count += 1;
    }
    Ok(count)
}

/// The server process. It ends when this value is dropped.
struct Process {
    child: Child,
    address: SocketAddr,
}

impl Process {
    /// Starts the server, on one core if `core` is given and the system has `taskset`.
    fn start(directory: &Path, core: Option<&str>) -> Result<Self, Failure> {
        let program = std::env::current_exe()?;
        let mut command = match core {
            Some(core) => {
                let mut command = Command::new("taskset");
                command.args(["-c", core]).arg(program);
                command
            }
            None => Command::new(program),
        };
        command.arg("--serve").arg(directory).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = command.spawn()?;
        let mut line = Vec::new();
        if let Some(stdout) = &mut child.stdout {
            let mut byte = [0];
            while stdout.read(&mut byte)? > 0 && byte != *b"\n" {
                line.extend(byte);
            }
        }
        let address = String::from_utf8_lossy(&line).trim().parse()?;
        Ok(Self { child, address })
    }

    /// Returns the peak memory of the process, as reported by Linux.
    fn most_memory(&self) -> Result<u64, Failure> {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.child.id()))?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
        let kibibytes = line.trim().trim_end_matches(" kB").parse::<u64>()?;
        Ok(kibibytes << 10)
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.child.kill().unwrap_or_default();
        self.child.wait().map(|_| ()).unwrap_or_default();
    }
}

fn request(path: &str, connection: &str) -> Vec<u8> {
    format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: {connection}\r\n\r\n").into_bytes()
}

/// Returns the status and the body of a response.
fn get(address: SocketAddr, path: &str) -> Result<(u16, Vec<u8>), Failure> {
    let mut socket = TcpStream::connect(address)?;
    socket.write_all(&request(path, "close"))?;
    let mut answer = Vec::new();
    socket.read_to_end(&mut answer)?;
    let end = answer.windows(4).position(|window| window == b"\r\n\r\n").map_or(answer.len(), |at| at + 4);
    let status =
        std::str::from_utf8(answer.get(9..12).unwrap_or_default()).ok().and_then(|text| text.parse().ok());
    Ok((status.unwrap_or(0), answer.split_off(end)))
}

fn figure(address: SocketAddr, name: &str) -> Result<u64, Failure> {
    let (_, text) = get(address, "/metrics")?;
    let text = String::from_utf8_lossy(&text).into_owned();
    Ok(text.lines().find_map(|line| line.strip_prefix(name)?.parse().ok()).unwrap_or(0))
}

/// Returns a grid of `side` × `side` squares as OBJ.
fn grid(side: usize) -> String {
    let row = |y: usize| (0..=side).map(move |x| format!("v {x} {y} {}\n", x * y % 3));
    let first = |y: usize| y * (side + 1) + 1;
    let squares = |y: usize| {
        (0..side).map(move |x| {
            let (a, b) = (first(y) + x, first(y + 1) + x);
            format!("f {a} {} {} {b}\n", a + 1, b + 1)
        })
    };
    (0..=side).flat_map(row).chain((0..side).flat_map(squares)).collect()
}
