//! The flags of the web server: `serve`, `view`.

use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};

use super::groups::FromArgs;
use crate::values::{BitRate, ByteCount};

/// The examples of `serve` that every build has.
macro_rules! examples {
    () => {
        "Examples:
  tristrip serve models/                            http://127.0.0.1:8080/
  tristrip serve models/ --pack-on-demand           also OBJ, PLY, STL, OFF and glTF
  tristrip serve models/ --bandwidth 5M             simulate a slow network
  curl -H 'Range: bytes=0-9999' http://127.0.0.1:8080/files/bunny.glb | tristrip unpack - -o a.ply"
    };
}

/// Serve the models of a directory over HTTP, with a gallery and a viewer
///
/// The gallery shows all models in the directory and its subdirectories. The viewer refines
/// progressive models while they load. Only programs on this machine can connect unless --address
/// is set. Files outside the directory and hidden files are never served. On Ctrl-C, the server
/// completes the running responses and then stops. `tristrip help server` explains addresses,
/// packing, the cache and limits.
#[derive(Debug, Args)]
#[cfg_attr(feature = "tls", command(after_long_help = concat!(examples!(), "
  tristrip serve models/ --address 0.0.0.0 --tls-certificate cert.pem --tls-key key.pem")))]
#[cfg_attr(not(feature = "tls"), command(after_long_help = examples!()))]
pub(crate) struct ServeArgs {
    /// The directory with the models
    #[arg(value_name = "DIRECTORY")]
    pub(crate) directory: PathBuf,
    #[command(flatten)]
    pub(crate) listen: ListenArgs,
    #[command(flatten)]
    pub(crate) packing: PackingArgs,
    #[command(flatten)]
    pub(crate) limits: LimitArgs,
    /// Write the request log to standard error as text or json
    #[arg(
        long,
        value_name = "FORMAT",
        value_enum,
        default_value_t,
        hide_possible_values = true,
        hide_short_help = true
    )]
    pub(crate) log: LogFormat,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Address")]
pub(crate) struct ListenArgs {
    /// Listen on this address; 0.0.0.0 or :: for all
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1")]
    pub(crate) address: IpAddr,
    /// Listen on this port; 0 for any free port
    #[arg(long, value_name = "PORT", default_value_t = 8080)]
    pub(crate) port: u16,
    /// Also accept requests for this host name; repeatable
    #[arg(long, value_name = "NAME")]
    pub(crate) host: Vec<String>,
    /// Allow pages from this origin (* for any) to read the files; repeatable
    #[arg(long, value_name = "ORIGIN")]
    pub(crate) cors: Vec<String>,
    /// Serve HTTPS with this certificate chain, in PEM
    #[cfg(feature = "tls")]
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    pub(crate) tls_certificate: Option<PathBuf>,
    /// Use this private key for the certificate, in PEM
    #[cfg(feature = "tls")]
    #[arg(long, value_name = "FILE", requires = "tls_certificate")]
    pub(crate) tls_key: Option<PathBuf>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Packing")]
pub(crate) struct PackingArgs {
    /// Pack OBJ, PLY, STL, OFF, glTF and GLB files on request, as `pack` does
    #[arg(long)]
    pub(crate) pack_on_demand: bool,
    /// Pack at most this many files at once [default: one per core]
    #[arg(long, hide_short_help = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) packings: Option<u16>,
    /// Pack or draw only files up to this size, such as 512M or 2G
    #[arg(long, hide_short_help = true, value_name = "BYTES", default_value = "512M")]
    pub(crate) largest_input: ByteCount,
    /// Keep packed files in this directory [default: tristrip in the user's cache directory]
    #[arg(long, value_name = "DIRECTORY")]
    pub(crate) cache: Option<PathBuf>,
    /// Limit the size of the cache; the least recently used files are removed
    #[arg(long, hide_short_help = true, value_name = "BYTES", default_value = "2G")]
    pub(crate) cache_bytes: ByteCount,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Limits")]
pub(crate) struct LimitArgs {
    /// Limit each response to this bit rate, such as 5M
    #[arg(long, value_name = "RATE")]
    pub(crate) bandwidth: Option<BitRate>,
    /// Accept at most this many connections
    #[arg(long, hide_short_help = true, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) connections: u32,
    /// Accept at most this many connections from one address
    #[arg(long, hide_short_help = true, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) connections_per_client: u32,
    /// Limit the size of a request head
    #[arg(long, hide_short_help = true, value_name = "BYTES", default_value = "16K")]
    pub(crate) header_bytes: ByteCount,
    /// Limit the time to receive a request head
    #[arg(long, hide_short_help = true, value_name = "TIME", default_value = "10s", value_parser = humantime::parse_duration)]
    pub(crate) header_time: Duration,
    /// Close a connection when the client reads nothing for this long
    #[arg(long, hide_short_help = true, value_name = "TIME", default_value = "30s", value_parser = humantime::parse_duration)]
    pub(crate) stall_time: Duration,
    /// Close an idle connection after this time; with HTTP/1.1, after at most --header-time
    #[arg(long, hide_short_help = true, value_name = "TIME", default_value = "1m", value_parser = humantime::parse_duration)]
    pub(crate) idle_time: Duration,
    /// Answer 503 if a packed file or thumbnail takes longer than this
    #[arg(long, hide_short_help = true, value_name = "TIME", default_value = "15s", value_parser = humantime::parse_duration)]
    pub(crate) wait_time: Duration,
    /// When the server stops, wait this long for running responses
    #[arg(long, hide_short_help = true, value_name = "TIME", default_value = "10s", value_parser = humantime::parse_duration)]
    pub(crate) grace_time: Duration,
}

/// The format of the request log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum LogFormat {
    /// One line of text per request
    #[default]
    Text,
    /// One JSON object per request
    Json,
}

/// View models in the browser
///
/// Pack the models in memory, serve them to this machine only, and open the browser. A progressive
/// GLB is served unchanged. Ctrl-C stops the server.
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
    /// Listen on this port [default: any free port]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    pub(crate) port: u16,
    /// Limit each response to this bit rate, such as 5M, to simulate a slow network
    #[arg(long, value_name = "RATE")]
    pub(crate) bandwidth: Option<BitRate>,
}
