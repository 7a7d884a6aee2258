//! The log of the web server on standard error: requests, packings, warnings.

use std::io;

use tracing_subscriber::filter::LevelFilter;
use tracing_subscriber::fmt;

use crate::args::LogFormat;

/// Starts the log. A second call changes nothing.
pub(crate) fn start(format: LogFormat) {
    let log =
        fmt().with_writer(io::stderr).with_max_level(LevelFilter::INFO).with_target(false).with_ansi(false);
    match format {
        LogFormat::Text => log.try_init(),
        LogFormat::Json => log.json().flatten_event(true).try_init(),
    }
    .unwrap_or_default();
}
