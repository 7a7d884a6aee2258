//! The flags of the web server: `serve`, `view`.

use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use super::groups::FromArgs;
use crate::values::{BitRate, ByteCount};

/// Serve the models of a directory over HTTP, with a gallery and a viewer
///
/// A browser shows the models of the directory and of those in it; a click on one opens a viewer, which refines a progressive model while it loads. Files are under /files/, packed files
/// under /packed/, the list is /models.json; FORMAT.md describes it. Only programs of this machine can connect unless --address says otherwise. Nothing outside the directory is served, whatever
/// links are in it, and no file whose name begins with a dot. Ctrl-C stops the server once running responses have ended.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip serve models/                            http://127.0.0.1:8080/
  tristrip serve models/ --pack-on-demand           OBJ, PLY, STL, OFF and glTF, too
  tristrip serve models/ --bandwidth 5M             as over a slow network
  tristrip serve models/ --address 0.0.0.0 --tls-certificate cert.pem --tls-key key.pem
  curl -H 'Range: bytes=0-9999' http://127.0.0.1:8080/files/bunny.glb | tristrip unpack - -o first.ply")]
pub(crate) struct ServeArgs {
    /// The directory of the models
    #[arg(value_name = "DIRECTORY")]
    pub(crate) directory: PathBuf,
    #[command(flatten)]
    pub(crate) listen: ListenArgs,
    #[command(flatten)]
    pub(crate) packing: PackingArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    /// How the log of requests is written to standard error
    #[arg(long, value_name = "FORMAT", value_enum, default_value_t)]
    pub(crate) log: LogFormat,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Address")]
pub(crate) struct ListenArgs {
    /// The address to listen at: 0.0.0.0 or :: for all networks
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    pub(crate) address: IpAddr,
    /// The port; 0 for any that is free
    #[arg(long, value_name = "PORT", default_value_t = 8080)]
    pub(crate) port: u16,
    /// Also answer to this name: for a server that listens to this machine alone, behind a proxy
    ///
    /// Such a server otherwise answers only to localhost and addresses of this machine, so that pages of other sites cannot read its files. May be given several times.
    #[arg(long, value_name = "NAME")]
    pub(crate) host: Vec<String>,
    /// Let pages of this origin read the files, or of all origins: *
    ///
    /// An origin is a scheme and a name: `https://example.org`. May be given several times.
    #[arg(long, value_name = "ORIGIN")]
    pub(crate) cors: Vec<String>,
    /// The certificate for HTTPS, in PEM, with those that it depends on
    #[cfg(feature = "tls")]
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    pub(crate) tls_certificate: Option<PathBuf>,
    /// The private key of the certificate, in PEM
    #[cfg(feature = "tls")]
    #[arg(long, value_name = "FILE", requires = "tls_certificate")]
    pub(crate) tls_key: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Packing")]
pub(crate) struct PackingArgs {
    /// Pack OBJ, PLY, STL, OFF, glTF and GLB when they are asked for, as `pack` does
    ///
    /// A file is packed once however many clients ask for it, and again when it has changed.
    #[arg(long)]
    pub(crate) pack_on_demand: bool,
    /// The packings that are made at once [default: one per core]
    ///
    /// Up to 64 others wait; more are refused for the moment. Thumbnails do not wait for packings.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) packings: Option<u16>,
    /// The bytes of the largest file that is packed or drawn, such as 512M or 2G
    #[arg(long, value_name = "BYTES", default_value = "512M")]
    pub(crate) largest_input: ByteCount,
    /// The directory for packed files and thumbnails [default: tristrip in the user's directory of caches]
    #[arg(long, value_name = "DIRECTORY")]
    pub(crate) cache: Option<PathBuf>,
    /// The bytes that this directory may take; the least recently used files are removed
    #[arg(long, value_name = "BYTES", default_value = "2G")]
    pub(crate) cache_bytes: ByteCount,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// The bits per second of each response, such as 500k or 5M, to see a model load over a slow network
    #[arg(long, value_name = "RATE")]
    pub(crate) bandwidth: Option<BitRate>,
    /// The connections at once
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) connections: u32,
    /// The connections at once from one address
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) connections_per_client: u32,
    /// The bytes of the head of a request
    #[arg(long, value_name = "BYTES", default_value = "16K")]
    pub(crate) header_bytes: ByteCount,
    /// How long the head of a request may take
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = humantime::parse_duration)]
    pub(crate) header_time: Duration,
    /// How long a client may read nothing of what is sent
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = humantime::parse_duration)]
    pub(crate) stall_time: Duration,
    /// How long a connection may be without a request; over HTTP/1.1 at most --header-time
    #[arg(long, value_name = "TIME", default_value = "1m", value_parser = humantime::parse_duration)]
    pub(crate) idle_time: Duration,
    /// How long a request waits for a packing or a thumbnail
    ///
    /// It then gets status 503 with Retry-After. The work goes on, and its result is there for the next request.
    #[arg(long, value_name = "TIME", default_value = "15s", value_parser = humantime::parse_duration)]
    pub(crate) wait_time: Duration,
    /// How long running responses may take once the server stops
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = humantime::parse_duration)]
    pub(crate) grace_time: Duration,
}

/// How the log is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum LogFormat {
    /// A line of text per request
    #[default]
    Text,
    /// An object of JSON per request
    Json,
}

/// View models in the browser
///
/// Models are packed in memory, served to this machine alone, and shown in the browser until Ctrl-C. A progressive GLB is served as it is.
#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  tristrip view bunny.ply
  tristrip view scene.glb other.obj                 a gallery of both
  tristrip view bunny.ply --no-open                 only print the address")]
pub(crate) struct ViewArgs {
    /// Mesh files, or - for standard input
    #[arg(required = true, value_name = "MODEL")]
    pub(crate) models: Vec<PathBuf>,
    #[command(flatten)]
    pub(crate) from: FromArgs,
    /// Do not open the browser
    #[arg(long)]
    pub(crate) no_open: bool,
    /// The port [default: any that is free]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    pub(crate) port: u16,
    /// The bits per second of each response, such as 500k or 5M, to see a model load over a slow network
    #[arg(long, value_name = "RATE")]
    pub(crate) bandwidth: Option<BitRate>,
}
