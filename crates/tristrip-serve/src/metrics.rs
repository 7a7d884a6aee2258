//! The metrics of a server: requests, bytes, connections, jobs and cache. `/metrics` returns them
//! as text for Prometheus.

use std::sync::atomic::AtomicU64;
use std::time::Duration;

use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::histogram::Histogram;
use prometheus_client::registry::Registry;

type Labels<const N: usize> = [(&'static str, String); N];

/// The upper bounds of the buckets of request times, in seconds.
const SECONDS: [f64; 10] = [0.001, 0.005, 0.02, 0.1, 0.5, 1.0, 2.0, 5.0, 20.0, 60.0];

/// The metrics of a server.
#[derive(Debug)]
pub(crate) struct ServerMetrics {
    registry: Registry,
    requests: Family<Labels<2>, Counter>,
    seconds: Family<Labels<1>, Histogram>,
    sent_bytes: Counter,
    pub(crate) connections: Gauge,
    refused: Family<Labels<1>, Counter>,
    /// Running and waiting jobs, and the results of finished jobs.
    pub(crate) running: Gauge,
    pub(crate) waiting: Gauge,
    made: Family<Labels<2>, Counter>,
    pub(crate) shared: Counter,
    pub(crate) cache_hits: Counter,
    pub(crate) cache_misses: Counter,
    pub(crate) cache_bytes: Gauge<u64, AtomicU64>,
}

impl ServerMetrics {
    pub(crate) fn new() -> Self {
        let mut registry = Registry::with_prefix("tristrip");
        let seconds = Family::new_with_constructor((|| Histogram::new(SECONDS)) as fn() -> Histogram);
        let mut metrics = Self {
            registry: Registry::default(),
            requests: Family::default(),
            seconds,
            sent_bytes: Counter::default(),
            connections: Gauge::default(),
            refused: Family::default(),
            running: Gauge::default(),
            waiting: Gauge::default(),
            made: Family::default(),
            shared: Counter::default(),
            cache_hits: Counter::default(),
            cache_misses: Counter::default(),
            cache_bytes: Gauge::default(),
        };
        registry.register("requests", "Requests by route and status", metrics.requests.clone());
        registry.register(
            "request_seconds",
            "Seconds from a request to the end of its response",
            metrics.seconds.clone(),
        );
        registry.register("sent_bytes", "Bytes of response bodies", metrics.sent_bytes.clone());
        registry.register("connections", "Open connections", metrics.connections.clone());
        registry.register(
            "refused_connections",
            "Connections and streams refused or ended, by limit",
            metrics.refused.clone(),
        );
        registry.register(
            "jobs_running",
            "Packing and thumbnail jobs that are running",
            metrics.running.clone(),
        );
        registry.register(
            "jobs_waiting",
            "Packing and thumbnail jobs that are waiting",
            metrics.waiting.clone(),
        );
        registry.register("jobs", "Finished packing and thumbnail jobs by result", metrics.made.clone());
        registry.register(
            "jobs_shared",
            "Requests that shared the job of another request",
            metrics.shared.clone(),
        );
        registry.register("cache_hits", "Results found in the cache", metrics.cache_hits.clone());
        registry.register("cache_misses", "Results not found in the cache", metrics.cache_misses.clone());
        registry.register(
            "cache_bytes",
            "Total size of all cached files in bytes",
            metrics.cache_bytes.clone(),
        );
        metrics.registry = registry;
        metrics
    }

    /// Counts a response after its body has ended.
    pub(crate) fn count_response(&self, route: &'static str, status: u16, bytes: u64, time: Duration) {
        self.requests.get_or_create(&[("route", route.into()), ("status", status.to_string())]).inc();
        self.seconds.get_or_create(&[("route", route.into())]).observe(time.as_secs_f64());
        self.sent_bytes.inc_by(bytes);
    }

    /// Counts a connection or a stream that a limit ended.
    pub(crate) fn count_refused(&self, limit: &'static str) {
        self.refused.get_or_create(&[("limit", limit.into())]).inc();
    }

    /// Counts a job that has ended.
    pub(crate) fn count_job(&self, kind: &'static str, result: &'static str) {
        self.made.get_or_create(&[("kind", kind.into()), ("result", result.into())]).inc();
    }

    /// Returns all metrics as text.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail.
        encode(&mut text, &self.registry).unwrap_or_default();
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metrics_are_printed() {
        let metrics = ServerMetrics::new();
        metrics.count_response("files", 206, 100, Duration::from_millis(3));
        metrics.count_refused("client");
        metrics.count_job("packing", "done");
        metrics.cache_bytes.set(7);
        let text = metrics.text();
        for line in [
            "tristrip_requests_total{route=\"files\",status=\"206\"} 1",
            "tristrip_sent_bytes_total 100",
            "tristrip_refused_connections_total{limit=\"client\"} 1",
            "tristrip_jobs_total{kind=\"packing\",result=\"done\"} 1",
            "tristrip_cache_bytes 7",
            "tristrip_request_seconds_bucket{le=\"0.005\",route=\"files\"} 1",
            "# EOF",
        ] {
            assert!(text.contains(line), "{line} in\n{text}");
        }
    }
}
