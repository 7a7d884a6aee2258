//! Server configuration: address, packing and limits.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::time::Duration;

use tristrip_pipeline::pack;

/// The configuration of a server. The default listens on 127.0.0.1:8080 and packs nothing.
///
/// ```
/// use tristrip_serve::{PackingOptions, ServerOptions};
/// let packing = PackingOptions::default().with_on_demand(true);
/// let options = ServerOptions::default().with_port(0).with_packing(packing);
/// assert!(options.address.is_loopback() && options.packing.on_demand);
/// ```
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ServerOptions {
    /// The address to listen on.
    pub address: IpAddr,
    /// The port; 0 for any free port.
    pub port: u16,
    /// Allowed host names in addition to `localhost` and loopback addresses. Only a server on a
    /// loopback address checks host names.
    pub hosts: Vec<String>,
    /// The origins whose pages may read the responses; `*` for all.
    pub cors: Vec<String>,
    /// The bandwidth of each response in bits per second, to simulate a slow network. `None`:
    /// unlimited.
    pub bandwidth: Option<u64>,
    /// The certificate for HTTPS; `None` for HTTP.
    #[cfg(feature = "tls")]
    pub tls: Option<TlsFiles>,
    /// The configuration of packing on demand.
    pub packing: PackingOptions,
    /// The limits for clients.
    pub limits: Limits,
}

impl Default for ServerOptions {
    fn default() -> Self {
        Self {
            address: IpAddr::V4(Ipv4Addr::LOCALHOST),
            port: 8080,
            hosts: Vec::new(),
            cors: Vec::new(),
            bandwidth: None,
            #[cfg(feature = "tls")]
            tls: None,
            packing: PackingOptions::default(),
            limits: Limits::default(),
        }
    }
}

impl ServerOptions {
    /// Sets the address to listen on.
    #[must_use]
    pub fn with_address(self, address: IpAddr) -> Self {
        Self { address, ..self }
    }

    /// Sets the port; 0 for any free port.
    #[must_use]
    pub fn with_port(self, port: u16) -> Self {
        Self { port, ..self }
    }

    /// Sets the allowed host names in addition to `localhost` and loopback addresses.
    #[must_use]
    pub fn with_hosts(self, hosts: Vec<String>) -> Self {
        Self { hosts, ..self }
    }

    /// Sets the origins whose pages may read the responses; `*` for all.
    #[must_use]
    pub fn with_cors(self, cors: Vec<String>) -> Self {
        Self { cors, ..self }
    }

    /// Sets the bandwidth of each response in bits per second; `None`: unlimited.
    #[must_use]
    pub fn with_bandwidth(self, bandwidth: Option<u64>) -> Self {
        Self { bandwidth, ..self }
    }

    /// Sets the certificate for HTTPS; `None` for HTTP.
    #[cfg(feature = "tls")]
    #[must_use]
    pub fn with_tls(self, tls: Option<TlsFiles>) -> Self {
        Self { tls, ..self }
    }

    /// Sets the configuration of packing on demand.
    #[must_use]
    pub fn with_packing(self, packing: PackingOptions) -> Self {
        Self { packing, ..self }
    }

    /// Sets the limits for clients.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }
}

/// The PEM files of a certificate.
#[cfg(feature = "tls")]
#[derive(Debug, Clone)]
pub struct TlsFiles {
    /// The certificate chain.
    pub certificate: PathBuf,
    /// The private key.
    pub key: PathBuf,
}

/// The configuration of packing on demand and of the cache.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PackingOptions {
    /// Whether files that are not progressive are packed on request.
    pub on_demand: bool,
    /// The options of packing.
    pub pack: pack::Options,
    /// The maximum number of files that are packed at once. Thumbnails do not wait for packing:
    /// half this number of thumbnails, but at least one, are drawn at the same time.
    pub at_once: usize,
    /// The maximum number of waiting packing jobs, and of waiting thumbnails. Further requests get
    /// 503.
    pub waiting: usize,
    /// The maximum time that a request waits for a packed file or thumbnail. After that it gets 503
    /// with `Retry-After`, and the job continues.
    pub wait_time: Duration,
    /// The maximum time of a packing or thumbnail job. After that it is cancelled, but the
    /// simplification of the current mesh is completed first.
    pub job_time: Duration,
    /// The maximum size in bytes of a file to pack or draw.
    pub largest_input_bytes: u64,
    /// The cache directory. This user must own it, and others must not be able to write to it.
    /// `None`: [`default_cache`](crate::default_cache).
    pub cache: Option<PathBuf>,
    /// The maximum size of the cache in bytes.
    pub cache_bytes: u64,
    /// The time after which a failed job may be tried again.
    pub failure_time: Duration,
    /// The number of threads that all packing jobs share; `None` for one per core.
    pub threads: Option<usize>,
}

impl Default for PackingOptions {
    fn default() -> Self {
        Self {
            on_demand: false,
            pack: pack::Options::default(),
            at_once: std::thread::available_parallelism().map_or(1, usize::from),
            waiting: 64,
            // Less than one minute, the usual timeout of proxies.
            wait_time: Duration::from_secs(15),
            job_time: Duration::from_mins(30),
            largest_input_bytes: 512 << 20,
            cache: None,
            cache_bytes: 2 << 30,
            failure_time: Duration::from_secs(30),
            threads: None,
        }
    }
}

impl PackingOptions {
    /// Sets whether files are packed on request.
    #[must_use]
    pub fn with_on_demand(self, on_demand: bool) -> Self {
        Self { on_demand, ..self }
    }

    /// Sets the maximum number of files that are packed at once.
    #[must_use]
    pub fn with_at_once(self, at_once: usize) -> Self {
        Self { at_once, ..self }
    }

    /// Sets the maximum number of waiting packing jobs, and of waiting thumbnails.
    #[must_use]
    pub fn with_waiting(self, waiting: usize) -> Self {
        Self { waiting, ..self }
    }

    /// Sets the maximum time that a request waits for a packed file or thumbnail.
    #[must_use]
    pub fn with_wait_time(self, wait_time: Duration) -> Self {
        Self { wait_time, ..self }
    }

    /// Sets the maximum time of a packing or thumbnail job.
    #[must_use]
    pub fn with_job_time(self, job_time: Duration) -> Self {
        Self { job_time, ..self }
    }

    /// Sets the maximum size in bytes of a file to pack or draw.
    #[must_use]
    pub fn with_largest_input_bytes(self, largest_input_bytes: u64) -> Self {
        Self { largest_input_bytes, ..self }
    }

    /// Sets the cache directory and its maximum size in bytes.
    #[must_use]
    pub fn with_cache(self, cache: Option<PathBuf>, cache_bytes: u64) -> Self {
        Self { cache, cache_bytes, ..self }
    }

    /// Sets the number of threads that all packing jobs share; `None` for one per core.
    #[must_use]
    pub fn with_threads(self, threads: Option<usize>) -> Self {
        Self { threads, ..self }
    }
}

/// Limits for the clients of a server.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// The maximum number of simultaneous connections.
    pub connections: usize,
    /// The maximum number of simultaneous connections from one IPv4 address or one 64-bit IPv6
    /// network.
    pub connections_per_client: usize,
    /// The maximum size of a request head in bytes.
    pub header_bytes: usize,
    /// The maximum time to receive a request head, and the maximum time of the TLS handshake.
    pub header_time: Duration,
    /// How long a client may go without reading any of a response.
    pub stall_time: Duration,
    /// The maximum time that a connection may be idle.
    pub idle_time: Duration,
    /// The maximum time that running responses get when the server stops.
    pub grace_time: Duration,
    /// The maximum number of simultaneous requests on one HTTP/2 connection.
    pub streams: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 1024,
            connections_per_client: 512,
            header_bytes: 16 << 10,
            header_time: Duration::from_secs(10),
            stall_time: Duration::from_secs(30),
            idle_time: Duration::from_mins(1),
            grace_time: Duration::from_secs(10),
            streams: 64,
        }
    }
}

impl Limits {
    /// Sets the maximum numbers of simultaneous connections, in total and per client.
    #[must_use]
    pub fn with_connections(self, connections: usize, connections_per_client: usize) -> Self {
        Self { connections, connections_per_client, ..self }
    }

    /// Sets the maximum size of a request head in bytes, and the maximum time to receive it.
    #[must_use]
    pub fn with_headers(self, header_bytes: usize, header_time: Duration) -> Self {
        Self { header_bytes, header_time, ..self }
    }

    /// Sets how long a client may go without reading any of a response.
    #[must_use]
    pub fn with_stall_time(self, stall_time: Duration) -> Self {
        Self { stall_time, ..self }
    }

    /// Sets the maximum time for which a connection may have no request.
    #[must_use]
    pub fn with_idle_time(self, idle_time: Duration) -> Self {
        Self { idle_time, ..self }
    }

    /// Sets the maximum time that running responses get when the server stops.
    #[must_use]
    pub fn with_grace_time(self, grace_time: Duration) -> Self {
        Self { grace_time, ..self }
    }
}
