//! What a server may be told: where it listens, what it packs, and its limits.

use std::net::{IpAddr, Ipv4Addr};
use std::path::PathBuf;
use std::time::Duration;

use tristrip_pipeline::pack;

/// How a server works. The default listens to this machine alone, and packs nothing.
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
    /// The address to listen at.
    pub address: IpAddr,
    /// The port; 0 for any that is free.
    pub port: u16,
    /// The names beside `localhost` that requests may have for a server that listens to this machine alone.
    pub hosts: Vec<String>,
    /// The origins whose pages may read the answers; `*` for all.
    pub cors: Vec<String>,
    /// The bits per second of each response, to show a model over a slow network; `None` for no limit.
    pub bandwidth: Option<u64>,
    /// The certificate of HTTPS; `None` for HTTP.
    #[cfg(feature = "tls")]
    pub tls: Option<TlsFiles>,
    /// What is packed, and how.
    pub packing: PackingOptions,
    /// Limits on what clients may take.
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
    /// Sets the address to listen at.
    #[must_use]
    pub fn with_address(self, address: IpAddr) -> Self {
        Self { address, ..self }
    }

    /// Sets the port; 0 for any that is free.
    #[must_use]
    pub fn with_port(self, port: u16) -> Self {
        Self { port, ..self }
    }

    /// Sets the names beside `localhost` that requests may have.
    #[must_use]
    pub fn with_hosts(self, hosts: Vec<String>) -> Self {
        Self { hosts, ..self }
    }

    /// Sets the origins whose pages may read the answers; `*` for all.
    #[must_use]
    pub fn with_cors(self, cors: Vec<String>) -> Self {
        Self { cors, ..self }
    }

    /// Sets the bits per second of each response; `None` for no limit.
    #[must_use]
    pub fn with_bandwidth(self, bandwidth: Option<u64>) -> Self {
        Self { bandwidth, ..self }
    }

    /// Sets the certificate of HTTPS; `None` for HTTP.
    #[cfg(feature = "tls")]
    #[must_use]
    pub fn with_tls(self, tls: Option<TlsFiles>) -> Self {
        Self { tls, ..self }
    }

    /// Sets what is packed, and how.
    #[must_use]
    pub fn with_packing(self, packing: PackingOptions) -> Self {
        Self { packing, ..self }
    }

    /// Sets limits on what clients may take.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }
}

/// The files of a certificate, in PEM.
#[cfg(feature = "tls")]
#[derive(Debug, Clone)]
pub struct TlsFiles {
    /// The certificate, and those that it depends on.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

/// What is packed on demand, and where the results are kept.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PackingOptions {
    /// Whether files that are not progressive are packed when they are asked for.
    pub on_demand: bool,
    /// How they are packed.
    pub pack: pack::Options,
    /// The packings that are made at once. Thumbnails do not wait for them: half as many are drawn beside them, at least one.
    pub at_once: usize,
    /// The packings that may wait for others, and the thumbnails; more are refused for the moment.
    pub waiting: usize,
    /// How long a request waits for a packing or a thumbnail. It is then told to come back, and the work goes on.
    pub wait_time: Duration,
    /// How long a packing or a thumbnail may take before it is given up. A mesh whose simplification has begun is simplified to its end.
    pub job_time: Duration,
    /// The bytes of the largest file that is read for a packing or a picture.
    pub largest_input_bytes: u64,
    /// The folder of the cache, of this user and not writable by others; `None` for [`default_cache`](crate::default_cache).
    pub cache: Option<PathBuf>,
    /// The bytes that the cache may take.
    pub cache_bytes: u64,
    /// How long a file that cannot be packed is not tried again.
    pub failure_time: Duration,
    /// The threads of all packings together; `None` for one per core.
    pub threads: Option<usize>,
}

impl Default for PackingOptions {
    fn default() -> Self {
        Self {
            on_demand: false,
            pack: pack::Options::default(),
            at_once: std::thread::available_parallelism().map_or(1, usize::from),
            waiting: 64,
            // Less than the minute that proxies wait.
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
    /// Sets whether files are packed when they are asked for.
    #[must_use]
    pub fn with_on_demand(self, on_demand: bool) -> Self {
        Self { on_demand, ..self }
    }

    /// Sets the packings that are made at once.
    #[must_use]
    pub fn with_at_once(self, at_once: usize) -> Self {
        Self { at_once, ..self }
    }

    /// Sets the packings that may wait for others, and the thumbnails.
    #[must_use]
    pub fn with_waiting(self, waiting: usize) -> Self {
        Self { waiting, ..self }
    }

    /// Sets how long a request waits for a packing or a thumbnail.
    #[must_use]
    pub fn with_wait_time(self, wait_time: Duration) -> Self {
        Self { wait_time, ..self }
    }

    /// Sets how long a packing or a thumbnail may take before it is given up.
    #[must_use]
    pub fn with_job_time(self, job_time: Duration) -> Self {
        Self { job_time, ..self }
    }

    /// Sets the bytes of the largest file that is read for a packing or a picture.
    #[must_use]
    pub fn with_largest_input_bytes(self, largest_input_bytes: u64) -> Self {
        Self { largest_input_bytes, ..self }
    }

    /// Sets the folder of the cache, and the bytes that it may take.
    #[must_use]
    pub fn with_cache(self, cache: Option<PathBuf>, cache_bytes: u64) -> Self {
        Self { cache, cache_bytes, ..self }
    }

    /// Sets the threads of all packings together; `None` for one per core.
    #[must_use]
    pub fn with_threads(self, threads: Option<usize>) -> Self {
        Self { threads, ..self }
    }
}

/// Limits on what clients may take of a server.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Limits {
    /// Connections at once.
    pub connections: usize,
    /// Connections at once from one address; for IPv6 from one network of 64 bits.
    pub connections_per_client: usize,
    /// Bytes of the head of a request.
    pub header_bytes: usize,
    /// How long the head of a request may take, TLS included.
    pub header_time: Duration,
    /// How long a client may read nothing of what is sent.
    pub stall_time: Duration,
    /// How long a connection may be without a request.
    pub idle_time: Duration,
    /// How long running responses may take once the server stops.
    pub grace_time: Duration,
    /// Requests at once over one connection of HTTP/2.
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
    /// Sets the connections at once, in all and from one address.
    #[must_use]
    pub fn with_connections(self, connections: usize, connections_per_client: usize) -> Self {
        Self { connections, connections_per_client, ..self }
    }

    /// Sets the bytes of the head of a request, and how long it may take.
    #[must_use]
    pub fn with_headers(self, header_bytes: usize, header_time: Duration) -> Self {
        Self { header_bytes, header_time, ..self }
    }

    /// Sets how long a client may read nothing of what is sent.
    #[must_use]
    pub fn with_stall_time(self, stall_time: Duration) -> Self {
        Self { stall_time, ..self }
    }

    /// Sets how long a connection may be without a request.
    #[must_use]
    pub fn with_idle_time(self, idle_time: Duration) -> Self {
        Self { idle_time, ..self }
    }

    /// Sets how long running responses may take once the server stops.
    #[must_use]
    pub fn with_grace_time(self, grace_time: Duration) -> Self {
        Self { grace_time, ..self }
    }
}
