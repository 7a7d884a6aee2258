//! What a connection does: how many responses it waits for or sends, and when it last got on. So connections that only take space are found.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use tokio::time::Instant;

use crate::options::Limits;

/// The state of a connection, which its requests share.
#[derive(Debug)]
pub(crate) struct Activity {
    start: Instant,
    /// Requests whose responses have not ended.
    requests: AtomicUsize,
    /// Responses whose bodies have begun and not ended.
    bodies: AtomicUsize,
    /// The milliseconds after the start at which something last happened.
    last: AtomicU64,
    has_served: AtomicBool,
    is_http2: AtomicBool,
}

/// Why a connection is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Overdue {
    /// It has sent no whole head of a request.
    Header,
    /// It has been without a request.
    Idle,
    /// It reads nothing of what is sent.
    Stalled,
}

impl Overdue {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Header => "header-time",
            Self::Idle => "idle-time",
            Self::Stalled => "stall-time",
        }
    }
}

impl Activity {
    pub(crate) fn new() -> Self {
        Self {
            start: Instant::now(),
            requests: AtomicUsize::new(0),
            bodies: AtomicUsize::new(0),
            last: AtomicU64::new(0),
            has_served: AtomicBool::new(false),
            is_http2: AtomicBool::new(false),
        }
    }

    /// Notes a request.
    pub(crate) fn request_begins(&self, is_http2: bool) {
        self.requests.fetch_add(1, Ordering::Relaxed);
        self.has_served.store(true, Ordering::Relaxed);
        self.is_http2.store(is_http2, Ordering::Relaxed);
        self.progress();
    }

    /// Notes that a request has its response, or lost its client.
    pub(crate) fn request_ends(&self) {
        self.requests.fetch_sub(1, Ordering::Relaxed);
        self.progress();
    }

    pub(crate) fn body_begins(&self) {
        self.bodies.fetch_add(1, Ordering::Relaxed);
        self.progress();
    }

    pub(crate) fn body_ends(&self) {
        self.bodies.fetch_sub(1, Ordering::Relaxed);
        self.progress();
    }

    /// Notes that bytes were taken.
    pub(crate) fn progress(&self) {
        self.last.store(self.start.elapsed().as_millis() as u64, Ordering::Relaxed);
    }

    /// Returns why the connection should be closed now, if it should.
    ///
    /// A client of HTTP/1.1 that reads nothing is found by its socket, one of HTTP/2 here: its streams wait for it while the socket does not.
    pub(crate) fn overdue(&self, limits: &Limits) -> Option<Overdue> {
        let since =
            self.start.elapsed().saturating_sub(Duration::from_millis(self.last.load(Ordering::Relaxed)));
        let [requests, bodies] = [&self.requests, &self.bodies].map(|count| count.load(Ordering::Relaxed));
        if bodies > 0 {
            let stalls = self.is_http2.load(Ordering::Relaxed) && since >= limits.stall_time;
            return stalls.then_some(Overdue::Stalled);
        }
        if requests > 0 {
            return None;
        }
        let (limit, overdue) = if self.has_served.load(Ordering::Relaxed) {
            (limits.idle_time, Overdue::Idle)
        } else {
            (limits.header_time, Overdue::Header)
        };
        (since >= limit).then_some(overdue)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn connections_that_do_nothing_are_found() {
        let limits = Limits::default();
        let after = async |seconds| tokio::time::advance(Duration::from_secs(seconds)).await;
        let activity = Activity::new();
        assert_eq!(activity.overdue(&limits), None);
        after(10).await;
        assert_eq!(activity.overdue(&limits), Some(Overdue::Header));
        activity.request_begins(true);
        after(1000).await;
        assert_eq!(activity.overdue(&limits), None, "packing takes long");
        activity.body_begins();
        activity.request_ends();
        after(29).await;
        assert_eq!(activity.overdue(&limits), None);
        activity.progress();
        after(30).await;
        assert_eq!(activity.overdue(&limits), Some(Overdue::Stalled));
        activity.body_ends();
        after(59).await;
        assert_eq!(activity.overdue(&limits), None);
        after(1).await;
        assert_eq!(activity.overdue(&limits), Some(Overdue::Idle));
    }
}
