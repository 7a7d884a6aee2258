//! The server. It listens, accepts connections, and ends them when it is stopped.

use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use etcetera::{BaseStrategy, choose_base_strategy};
use tokio::runtime::Builder;
use tokio::sync::{oneshot, watch};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

use crate::answer::Answerer;
use crate::cache::Cache;
use crate::clients::Clients;
use crate::connections::{Connections, refuse};
use crate::content::{Content, Store};
use crate::error::Error;
use crate::metrics::ServerMetrics;
use crate::options::{PackingOptions, ServerOptions};
use crate::site::{Site, router};
use crate::tls::Tls;
use crate::workshop::Workshop;

/// The number of open files in addition to the connections and the files that they send.
const OTHER_FILES: u64 = 128;
/// The pause after the system could not accept a connection, for lack of file handles or memory.
const PAUSE: Duration = Duration::from_millis(50);

/// A listening server. It answers requests while it runs.
///
/// ```
/// use std::io::{Read, Write};
/// use tristrip_serve::{Content, MemoryFile, Server, ServerOptions};
/// let file = MemoryFile { name: "triangle.obj".into(), bytes: b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec() };
/// let server = Server::bind(Content::Files(vec![file]), &ServerOptions::default().with_port(0))?;
/// let (address, stop) = (server.address(), server.stop_handle());
/// let running = std::thread::spawn(|| server.run());
/// let mut socket = std::net::TcpStream::connect(address)?;
/// socket.write_all(b"GET /files/triangle.obj HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n")?;
/// let mut response = String::new();
/// socket.read_to_string(&mut response)?;
/// assert!(response.starts_with("HTTP/1.1 200 OK") && response.ends_with("f 1 2 3\n"));
/// stop.stop();
/// assert!(running.join().is_ok_and(|ended| ended.is_ok()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    options: ServerOptions,
    answerer: Answerer,
    metrics: Arc<ServerMetrics>,
    tls: Option<Tls>,
    stop: StopHandle,
}

/// Stops a server. The server then accepts no more connections. It ends when the running responses
/// have ended, or after the grace time.
///
/// ```
/// use tristrip_serve::{Content, Server, ServerOptions};
/// let server = Server::bind(Content::Files(Vec::new()), &ServerOptions::default().with_port(0))?;
/// server.stop_handle().stop();
/// server.run()?;
/// # Ok::<(), tristrip_serve::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct StopHandle {
    sender: Arc<watch::Sender<bool>>,
}

impl StopHandle {
    fn new() -> Self {
        Self { sender: Arc::new(watch::Sender::new(false)) }
    }

    /// Stops the server.
    pub fn stop(&self) {
        self.sender.send_replace(true);
    }
}

/// Returns the default cache directory, `tristrip` in the user's cache directory, or `None` if the
/// user has no home directory. In that case the server uses a temporary directory and removes it
/// when it ends.
///
/// ```
/// assert!(tristrip_serve::default_cache().is_none_or(|folder| folder.ends_with("tristrip")));
/// ```
pub fn default_cache() -> Option<PathBuf> {
    choose_base_strategy().ok().map(|dirs| dirs.cache_dir().join("tristrip"))
}

impl Server {
    /// Opens the content and the cache and starts listening. Clients can connect immediately, but
    /// wait until the server runs.
    ///
    /// # Errors
    /// The directory or the cache cannot be opened, the address is in use or not available, or the
    /// certificate or an option is not valid.
    pub fn bind(content: Content, options: &ServerOptions) -> Result<Self, Error> {
        let options = options.clone();
        let store = Store::open(content)?;
        let tls = Tls::from_options(&options)?;
        let metrics = Arc::new(ServerMetrics::new());
        let workshop = match &store {
            Store::Folder(_) => Some(Arc::new(open_workshop(&options.packing, &metrics)?)),
            Store::Memory(_) => None,
        };
        let wanted = SocketAddr::new(options.address, options.port);
        let listen = || {
            let listener = TcpListener::bind(wanted)?;
            listener.set_nonblocking(true)?;
            Ok((listener.local_addr()?, listener))
        };
        let (address, listener) = listen().map_err(|source| Error::Address { address: wanted, source })?;
        let site = Site::new(store, workshop, options.packing.clone(), Arc::clone(&metrics));
        let answerer = Answerer::new(router(Arc::new(site)), &options, Arc::clone(&metrics))?;
        let stop = StopHandle::new();
        Ok(Self { listener, address, options, answerer, metrics, tls, stop })
    }

    /// Returns the address and the port.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Returns the URL of the gallery for a browser on this machine.
    pub fn url(&self) -> String {
        let scheme = if self.tls.is_some() { "https" } else { "http" };
        let mut address = self.address;
        if address.ip().is_unspecified() {
            address.set_ip(if address.is_ipv4() {
                [127, 0, 0, 1].into()
            } else {
                std::net::Ipv6Addr::LOCALHOST.into()
            });
        }
        format!("{scheme}://{address}/")
    }

    /// Returns a handle that stops the server from any thread.
    pub fn stop_handle(&self) -> StopHandle {
        self.stop.clone()
    }

    /// Answers requests until the server is stopped.
    ///
    /// # Errors
    /// The system does not provide threads or timers.
    pub fn run(self) -> Result<(), Error> {
        self.run_on_runtime(false)
    }

    /// Answers requests until the server is stopped or the process receives an interrupt (Ctrl-C)
    /// or SIGTERM. A second signal ends the server immediately.
    ///
    /// # Errors
    /// The system does not provide threads, timers or signal handlers.
    pub fn run_until_signal(self) -> Result<(), Error> {
        self.run_on_runtime(true)
    }

    fn run_on_runtime(self, signals: bool) -> Result<(), Error> {
        raise_file_limit(self.options.limits.connections as u64);
        let runtime = Builder::new_multi_thread().enable_all().build().map_err(Error::System)?;
        let stop = self.stop.clone();
        let ended = runtime.block_on(async {
            let (second, at_once) = oneshot::channel();
            if signals {
                watch_signals(stop, second)?;
            }
            tokio::select! {
                ended = self.accept() => ended,
                Ok(()) = at_once => Ok(()),
            }
        });
        // A job that is still running has written no file or a complete file.
        runtime.shutdown_background();
        ended
    }

    async fn accept(self) -> Result<(), Error> {
        let listener = tokio::net::TcpListener::from_std(self.listener).map_err(Error::System)?;
        let metrics = self.metrics;
        let limits = Arc::new(self.options.limits);
        let mut stop = self.stop.sender.subscribe();
        let connections = Connections {
            answerer: self.answerer,
            limits: Arc::clone(&limits),
            metrics: Arc::clone(&metrics),
            tls: self.tls,
            clients: Arc::new(Clients::default()),
            stop: stop.clone(),
        };
        let mut running = JoinSet::new();
        loop {
            let accepted = tokio::select! {
                accepted = listener.accept() => accepted,
                Some(_) = running.join_next() => continue,
                _ = stop.wait_for(|stop| *stop) => break,
            };
            match accepted {
                Ok((socket, client)) => match connections.clients.enter(client.ip(), &limits) {
                    Ok(place) => {
                        running.spawn(connections.clone().serve(socket, client.ip().to_canonical(), place));
                    }
                    Err(limit) => {
                        metrics.count_refused(limit);
                        if connections.tls.is_none() {
                            refuse(&socket);
                        }
                    }
                },
                Err(error) => {
                    tracing::warn!(%error, "could not accept a connection");
                    sleep(PAUSE).await;
                }
            }
        }
        drop(listener);
        tracing::info!(connections = running.len(), "stopping");
        let all = async { while running.join_next().await.is_some() {} };
        if timeout(limits.grace_time, all).await.is_err() {
            tracing::warn!("grace time is over: ended running responses early");
        }
        Ok(())
    }
}

fn open_workshop(options: &PackingOptions, metrics: &Arc<ServerMetrics>) -> Result<Workshop, Error> {
    let cache = match options.cache.clone().or_else(default_cache) {
        Some(folder) => Cache::open(&folder, options.cache_bytes)?,
        None => Cache::temporary(options.cache_bytes)?,
    };
    Workshop::new(options, cache, Arc::clone(metrics))
}

/// Stops the server at the first interrupt or SIGTERM, and ends it immediately at the second one.
fn watch_signals(stop: StopHandle, second: oneshot::Sender<()>) -> Result<(), Error> {
    #[cfg(unix)]
    let mut terminate =
        tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()).map_err(Error::System)?;
    #[cfg(unix)]
    let mut interrupt =
        tokio::signal::unix::signal(tokio::signal::unix::SignalKind::interrupt()).map_err(Error::System)?;
    tokio::spawn(async move {
        let mut signal = async || {
            #[cfg(unix)]
            let received = tokio::select! {
                received = interrupt.recv() => received,
                received = terminate.recv() => received,
            };
            #[cfg(not(unix))]
            let received = tokio::signal::ctrl_c().await.ok();
            received.is_some()
        };
        if signal().await {
            stop.stop();
            if signal().await {
                // The server may already have ended.
                second.send(()).unwrap_or_default();
            }
        }
    });
    Ok(())
}

/// Raises the limit of open files of the process as far as the system allows. Each connection needs
/// two: the socket and the file that it sends.
fn raise_file_limit(connections: u64) {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, getrlimit, setrlimit};
        let wanted = 2 * connections + OTHER_FILES;
        let mut limit = getrlimit(Resource::Nofile);
        if limit.current.is_some_and(|current| current < wanted) {
            limit.current = Some(limit.maximum.map_or(wanted, |maximum| maximum.min(wanted)));
            if let Err(error) = setrlimit(Resource::Nofile, limit) {
                tracing::debug!(%error, "could not raise the limit of open files");
            }
        }
    }
    #[cfg(not(unix))]
    let _ = connections;
}
