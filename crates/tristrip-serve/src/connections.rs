//! Connections: limits on their number and on the time without progress.
//!
//! # Algorithm
//! 1. A connection that exceeds a limit gets a 503 response immediately and is closed. IPv6
//!    connections are counted per 64-bit network, because one client usually has a complete
//!    network.
//! 2. The size of a request head and the time to receive it are limited. The TLS handshake has the
//!    same time limit.
//! 3. A timer checks each connection a few times per time limit. Connections without a request and
//!    connections whose client reads nothing are closed. The check of one connection never waits
//!    for another connection. If the client of an HTTP/2 stream does not read it while other
//!    streams make progress, only this stream is ended (`streams.rs`).
//! 4. Simultaneous responses have the same limits as connections, in total and per client. HTTP/2
//!    streams therefore cannot open more files than HTTP/1.1 connections.
//! 5. The memory per connection is small: read and write buffers are as small as a request head.

use std::net::IpAddr;
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::conn::auto;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio::time::{MissedTickBehavior, interval, timeout};
use tokio_io_timeout::TimeoutStream;

use crate::activity::Activity;
use crate::answer::Answerer;
use crate::clients::{Clients, Place};
use crate::metrics::ServerMetrics;
use crate::options::Limits;
use crate::streams::StreamExecutor;
use crate::tls::Tls;

/// The response to a connection that exceeds a limit.
const REFUSAL: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nContent-Type: text/plain; charset=utf-8\r\nContent-Length: 21\r\nConnection: close\r\n\r\ntoo many connections\n";
/// The maximum number of buffered bytes per HTTP/2 stream that the client has not read.
const SEND_BYTES: usize = 64 << 10;

/// The state that all connections share.
#[derive(Clone)]
pub(crate) struct Connections {
    pub(crate) answerer: Answerer,
    pub(crate) limits: Arc<Limits>,
    pub(crate) metrics: Arc<ServerMetrics>,
    pub(crate) tls: Option<Tls>,
    pub(crate) clients: Arc<Clients>,
    /// True once the server stops.
    pub(crate) stop: watch::Receiver<bool>,
}

/// A connection that the metrics count.
struct Counted(Arc<ServerMetrics>);

impl Counted {
    fn new(metrics: &Arc<ServerMetrics>) -> Self {
        metrics.connections.inc();
        Self(Arc::clone(metrics))
    }
}

impl Drop for Counted {
    fn drop(&mut self) {
        self.0.connections.dec();
    }
}

/// Sends the 503 response if this is possible without waiting. The caller closes the connection.
pub(crate) fn refuse(socket: &TcpStream) {
    socket.try_write(REFUSAL).unwrap_or_default();
}

impl Connections {
    /// Serves a connection to its end.
    pub(crate) async fn serve(self, socket: TcpStream, client: IpAddr, place: Place) {
        let (_place, _counted) = (place, Counted::new(&self.metrics));
        // Send small responses immediately.
        socket.set_nodelay(true).unwrap_or_default();
        let mut stream = TimeoutStream::new(socket);
        stream.set_write_timeout(Some(self.limits.stall_time));
        let Some(tls) = self.tls.clone() else { return self.serve_stream(Box::pin(stream), client).await };
        match timeout(self.limits.header_time, tls.accept(Box::pin(stream))).await {
            Ok(Ok(stream)) => self.serve_stream(stream, client).await,
            Ok(Err(error)) => tracing::debug!(%client, %error, "TLS handshake failed"),
            Err(_) => self.metrics.count_refused("header-time"),
        }
    }

    async fn serve_stream(
        self,
        stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static,
        client: IpAddr,
    ) {
        let activity = Arc::new(Activity::new());
        let service = service_fn({
            let (answerer, activity) = (self.answerer.clone(), Arc::clone(&activity));
            move |request| answerer.clone().answer(request, client, Arc::clone(&activity))
        });
        let builder = self.builder();
        let mut connection = pin!(builder.serve_connection(TokioIo::new(stream), service));
        let mut watch = interval(self.watch_time());
        watch.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut stop = self.stop.clone();
        let mut is_stopping = false;
        loop {
            tokio::select! {
                result = connection.as_mut() => {
                    if let Err(error) = result {
                        tracing::debug!(%client, error, "connection ended");
                    }
                    return;
                }
                _ = watch.tick() => {
                    if let Some(overdue) = activity.overdue(&self.limits) {
                        self.metrics.count_refused(overdue.name());
                        tracing::debug!(%client, limit = overdue.name(), "connection closed");
                        return;
                    }
                    for _ in 0..activity.end_stalled_streams(&self.limits) {
                        self.metrics.count_refused("stream-stall-time");
                        tracing::debug!(%client, limit = "stream-stall-time", "stream ended");
                    }
                }
                _ = stop.wait_for(|stop| *stop), if !is_stopping => {
                    is_stopping = true;
                    connection.as_mut().graceful_shutdown();
                }
            }
        }
    }

    fn builder(&self) -> auto::Builder<StreamExecutor> {
        let Limits { header_bytes, header_time, streams, .. } = *self.limits;
        let mut builder = auto::Builder::new(StreamExecutor);
        builder
            .http1()
            .timer(TokioTimer::new())
            .header_read_timeout(header_time)
            // The minimum that hyper accepts.
            .max_buf_size(header_bytes.max(8192));
        builder
            .http2()
            .timer(TokioTimer::new())
            .max_concurrent_streams(streams)
            .max_header_list_size(u32::try_from(header_bytes).unwrap_or(u32::MAX))
            .max_send_buf_size(SEND_BYTES)
            // Detect a disconnected client even if nothing is sent.
            .keep_alive_interval(Some(Duration::from_secs(20)))
            .keep_alive_timeout(Duration::from_secs(20));
        builder
    }

    /// Returns the interval between two checks of a connection.
    fn watch_time(&self) -> Duration {
        let Limits { header_time, stall_time, idle_time, .. } = *self.limits;
        let shortest = header_time.min(stall_time).min(idle_time);
        (shortest / 4).clamp(Duration::from_millis(10), Duration::from_secs(1))
    }
}
