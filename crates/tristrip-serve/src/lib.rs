//! The web server of tristrip. It serves the models of a directory, or models in memory, with a
//! gallery and a viewer that refines models while they load.
//!
//! ```text
//! server: accept ─▶ connections: limits, TLS, watch ─▶ answer: host, method, CORS, log ─▶ site: routes
//!                                                                                         ├─ assets: the viewer
//!   paths ─▶ folder: a handle that no path can leave ─▶ replies: ETag, ranges ◀───────────┤─ content: unchanged files
//!                 ├─ catalogue: the list of models                                        │
//!                 └─ packing, thumbnails ─▶ workshop: one job per file ─────▶ cache ◀─────┘
//! ```
//! The server supports HTTP/1.1 and HTTP/2, and TLS with the feature `tls`. [`Limits`] restricts
//! the connections, request heads and idle times of clients. Files are read in small pieces, so
//! memory use does not depend on their size.

#![forbid(unsafe_code)]

mod activity;
mod answer;
mod assets;
mod bytes_source;
mod cache;
mod catalogue;
mod clients;
mod connections;
mod content;
mod deadline;
mod error;
mod folder;
mod glb_start;
mod hosts;
mod media;
mod metrics;
#[cfg(not(feature = "tls"))]
mod no_tls;
mod options;
mod packing;
mod paths;
mod replies;
mod response_body;
mod server;
mod site;
mod streams;
mod thumbnails;
#[cfg(feature = "tls")]
mod tls;
mod workshop;

pub use content::{Content, MemoryFile};
pub use error::Error;
#[cfg(not(feature = "tls"))]
use no_tls as tls;
#[cfg(feature = "tls")]
pub use options::TlsFiles;
pub use options::{Limits, PackingOptions, ServerOptions};
pub use paths::url_path;
pub use server::{Server, StopHandle, default_cache};
