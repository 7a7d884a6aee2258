//! The web server of tristrip: the models of a folder, or of memory, with a gallery and a viewer that refines them while they load.
//!
//! ```text
//! server: accept ─▶ connections: limits, TLS, watch ─▶ answer: host, method, CORS, log ─▶ site: routes
//!                                                                                         ├─ assets: the viewer
//!   paths ─▶ folder: a handle that no path leads out of ─▶ replies: ETag, ranges ◀────────┤─ content: files as they are
//!                 ├─ catalogue: the list of models                                        │
//!                 └─ packing, thumbnails ─▶ workshop: once for all who ask ─▶ cache ◀─────┘
//! ```
//! It speaks HTTP/1.1 and HTTP/2, and TLS with the feature `tls`. What a client may take is limited ([`Limits`]): connections, heads of requests, time without progress.
//! Files are read in small pieces, so that memory does not grow with their size.

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
