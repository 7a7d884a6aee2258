//! Tasks of the web server.

use std::path::PathBuf;

use tristrip::text::counted;
use tristrip_io::Format;
use tristrip_serve::{Limits, PackingOptions, ServerOptions};

use crate::args::{LogFormat, ServeArgs, ViewArgs};
use crate::job::{Job, Output, inputs};
use crate::values::{BitRate, ByteCount};

#[derive(Debug)]
pub(crate) struct ServeTask {
    pub(crate) directory: PathBuf,
    pub(crate) options: ServerOptions,
    pub(crate) log: LogFormat,
}

#[derive(Debug)]
pub(crate) struct ViewTask {
    pub(crate) jobs: Vec<Job>,
    pub(crate) options: ServerOptions,
    /// Whether to open the browser.
    pub(crate) opens: bool,
}

pub(super) fn serve_task(args: ServeArgs) -> Result<ServeTask, String> {
    let ServeArgs { directory, listen, packing, limits, log } = args;
    let ByteCount(found) = limits.header_bytes;
    let header_bytes = usize::try_from(found).ok().filter(|bytes| (8192..=1 << 24).contains(bytes));
    let out_of_range = || format!("--header-bytes: found {}, expected 8K to 16M", counted(found, "byte"));
    let header_bytes = header_bytes.ok_or_else(out_of_range)?;
    let times = [
        ("--header-time", limits.header_time),
        ("--stall-time", limits.stall_time),
        ("--idle-time", limits.idle_time),
        ("--wait-time", limits.wait_time),
    ];
    if let Some((flag, _)) = times.iter().find(|(_, time)| time.is_zero()) {
        return Err(format!("{flag}: found 0 seconds, expected more"));
    }
    let [ByteCount(largest_input), ByteCount(cache_bytes)] = [packing.largest_input, packing.cache_bytes];
    let mut packing_options = PackingOptions::default()
        .with_on_demand(packing.pack_on_demand)
        .with_largest_input_bytes(largest_input)
        .with_wait_time(limits.wait_time)
        .with_cache(packing.cache, cache_bytes);
    if let Some(at_once) = packing.packings {
        packing_options = packing_options.with_at_once(usize::from(at_once));
    }
    let options = ServerOptions::default()
        .with_address(listen.address)
        .with_port(listen.port)
        .with_hosts(listen.host)
        .with_cors(listen.cors)
        .with_bandwidth(limits.bandwidth.map(|BitRate(rate)| rate))
        .with_packing(packing_options)
        .with_limits(
            Limits::default()
                .with_connections(limits.connections as usize, limits.connections_per_client as usize)
                .with_headers(header_bytes, limits.header_time)
                .with_stall_time(limits.stall_time)
                .with_idle_time(limits.idle_time)
                .with_grace_time(limits.grace_time),
        );
    #[cfg(feature = "tls")]
    let options = {
        let files = listen.tls_certificate.zip(listen.tls_key);
        options.with_tls(files.map(|(certificate, key)| tristrip_serve::TlsFiles { certificate, key }))
    };
    Ok(ServeTask { directory, options, log })
}

pub(super) fn view_task(args: ViewArgs) -> Result<ViewTask, String> {
    let inputs = inputs(args.models, args.from.from)?;
    // As for `pack`, with an output in memory.
    let jobs =
        inputs.into_iter().map(|input| Job { output: Some(Output::in_memory(Format::Glb)), input }).collect();
    let options = ServerOptions::default()
        .with_port(args.port)
        .with_bandwidth(args.bandwidth.map(|BitRate(rate)| rate))
        .with_limits(Limits::default().with_grace_time(std::time::Duration::from_secs(1)));
    Ok(ViewTask { jobs, options, opens: !args.no_open })
}
