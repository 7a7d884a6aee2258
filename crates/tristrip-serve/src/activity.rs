//! The activity of a connection: the number of its requests and responses, and the time of its last
//! progress. The server uses it to find and close stalled and idle connections.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use crate::bytes_source::PIECE_BYTES;
use crate::options::Limits;
use crate::streams::StreamEnd;

/// If each body of a connection could have sent this many bytes in turn while one body waits, the
/// client is not reading that body. With fewer bytes, the bodies may only share a slow network.
const TURNS_BYTES: u64 = 2 * PIECE_BYTES as u64;
/// The maximum time that one body may wait for its client, as a multiple of the stall time.
const BODY_PATIENCE: u32 = 4;

/// A response body of a connection, with the time at which it began to wait for its client.
#[derive(Debug, Clone)]
pub(crate) struct OpenBody(Arc<BodyState>);

#[derive(Debug)]
struct BodyState {
    /// The time at which the body sent its last bytes, in milliseconds since the start of the
    /// connection; `NONE` while the server prepares more bytes.
    since: AtomicU64,
    /// The value of `share` of the connection at that time.
    share: AtomicU64,
    /// `None` once it has been used, and for HTTP/1.1.
    end: Mutex<Option<StreamEnd>>,
}

impl OpenBody {
    const NONE: u64 = u64::MAX;

    /// Records that the client is ready for more bytes.
    pub(crate) fn is_asked(&self) {
        self.0.since.store(Self::NONE, Ordering::Relaxed);
    }

    /// Returns how long the body has been waiting for its client.
    fn wait(&self, now: u64) -> Duration {
        Duration::from_millis(now.saturating_sub(self.0.since.load(Ordering::Relaxed)))
    }
}

/// The state of a connection, shared by its requests.
#[derive(Debug)]
pub(crate) struct Activity {
    start: Instant,
    /// The number of requests that have no response yet.
    requests: AtomicUsize,
    /// The bodies that have begun but not ended.
    bodies: Mutex<Vec<OpenBody>>,
    /// The bytes that each body could have sent so far: the bytes that were sent, divided by the
    /// number of bodies at that time.
    share: AtomicU64,
    /// The time of the last progress, in milliseconds since the start.
    last: AtomicU64,
    has_served: AtomicBool,
    is_http2: AtomicBool,
}

/// Why a connection is closed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Overdue {
    /// It has not sent a complete request head.
    Header,
    /// It has had no request.
    Idle,
    /// It does not read what is sent.
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
            bodies: Mutex::default(),
            share: AtomicU64::new(0),
            last: AtomicU64::new(0),
            has_served: AtomicBool::new(false),
            is_http2: AtomicBool::new(false),
        }
    }

    /// Records the start of a request.
    pub(crate) fn request_begins(&self, is_http2: bool) {
        self.requests.fetch_add(1, Ordering::Relaxed);
        self.has_served.store(true, Ordering::Relaxed);
        self.is_http2.store(is_http2, Ordering::Relaxed);
        self.progress();
    }

    /// Records that a request has its response, or that its client has left.
    pub(crate) fn request_ends(&self) {
        self.requests.fetch_sub(1, Ordering::Relaxed);
        self.progress();
    }

    /// Records a body that waits for its client from now on, with the stream that sends it.
    pub(crate) fn body_begins(&self, end: Option<StreamEnd>) -> OpenBody {
        let (since, share) = (AtomicU64::new(self.now()), AtomicU64::new(self.share.load(Ordering::Relaxed)));
        let body = OpenBody(Arc::new(BodyState { since, share, end: Mutex::new(end) }));
        self.bodies().push(body.clone());
        self.progress();
        body
    }

    /// Records that a body has sent bytes and now waits for its client.
    pub(crate) fn body_gives(&self, body: &OpenBody, bytes: u64) {
        let share = bytes / self.bodies().len().max(1) as u64;
        let all = self.share.fetch_add(share, Ordering::Relaxed) + share;
        body.0.share.store(all, Ordering::Relaxed);
        body.0.since.store(self.now(), Ordering::Relaxed);
        self.progress();
    }

    pub(crate) fn body_ends(&self, ended: &OpenBody) {
        self.bodies().retain(|body| !Arc::ptr_eq(&body.0, &ended.0));
        self.progress();
    }

    fn bodies(&self) -> MutexGuard<'_, Vec<OpenBody>> {
        self.bodies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Ends the streams that their client has not read for the stall time although it has read
    /// enough of other streams. Returns how many were ended.
    pub(crate) fn end_stalled_streams(&self, limits: &Limits) -> usize {
        let (now, share) = (self.now(), self.share.load(Ordering::Relaxed));
        let bodies = self.bodies();
        let is_stalled = |body: &&OpenBody| {
            let wait = body.wait(now);
            let had_turns = share.saturating_sub(body.0.share.load(Ordering::Relaxed)) >= TURNS_BYTES;
            wait >= limits.stall_time && had_turns || wait >= limits.stall_time.saturating_mul(BODY_PATIENCE)
        };
        let end_of = |body: &OpenBody| body.0.end.lock().unwrap_or_else(PoisonError::into_inner).take();
        let ends: Vec<StreamEnd> = bodies.iter().filter(is_stalled).filter_map(end_of).collect();
        ends.iter().for_each(StreamEnd::end);
        ends.len()
    }

    /// Returns the time in milliseconds since the start.
    pub(crate) fn now(&self) -> u64 {
        self.start.elapsed().as_millis() as u64
    }

    /// Records progress.
    pub(crate) fn progress(&self) {
        self.last.store(self.now(), Ordering::Relaxed);
    }

    /// Returns why the connection must be closed now, or `None` if it can stay open.
    ///
    /// A stalled HTTP/1.1 client is detected at its socket. A stalled HTTP/2 client is detected
    /// here: its streams wait while its socket does not.
    pub(crate) fn overdue(&self, limits: &Limits) -> Option<Overdue> {
        let now = self.now();
        let since = Duration::from_millis(now.saturating_sub(self.last.load(Ordering::Relaxed)));
        let bodies = self.bodies();
        if !bodies.is_empty() {
            // A body that waits for the server does not show that its client has stalled.
            let stalls = self.is_http2.load(Ordering::Relaxed)
                && since >= limits.stall_time
                && bodies.iter().all(|body| body.wait(now) >= limits.stall_time);
            return stalls.then_some(Overdue::Stalled);
        }
        drop(bodies);
        if self.requests.load(Ordering::Relaxed) > 0 {
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
        let body = activity.body_begins(None);
        activity.request_ends();
        after(29).await;
        assert_eq!(activity.overdue(&limits), None);
        activity.body_gives(&body, 10);
        after(29).await;
        assert_eq!(activity.overdue(&limits), None);
        body.is_asked();
        after(1000).await;
        assert_eq!(activity.overdue(&limits), None, "it waits for the server");
        activity.body_gives(&body, 10);
        after(30).await;
        assert_eq!(activity.overdue(&limits), Some(Overdue::Stalled));
        activity.body_ends(&body);
        after(59).await;
        assert_eq!(activity.overdue(&limits), None);
        after(1).await;
        assert_eq!(activity.overdue(&limits), Some(Overdue::Idle));
    }

    #[tokio::test(start_paused = true)]
    async fn a_stream_that_is_not_read_is_ended_beside_others() {
        let limits = Limits::default();
        let activity = Activity::new();
        activity.request_begins(true);
        let [read, _unread] = [(); 2].map(|()| activity.body_begins(Some(StreamEnd::default())));
        activity.request_ends();
        for second in 1..=40 {
            tokio::time::advance(Duration::from_secs(1)).await;
            activity.body_gives(&read, PIECE_BYTES as u64);
            assert_eq!(activity.overdue(&limits), None);
            assert_eq!(activity.end_stalled_streams(&limits), usize::from(second == 30), "{second}");
        }
    }

    #[tokio::test(start_paused = true)]
    async fn streams_that_share_a_slow_network_have_more_time() {
        let limits = Limits::default();
        let activity = Activity::new();
        activity.request_begins(true);
        let bodies: Vec<OpenBody> =
            (0..60).map(|_| activity.body_begins(Some(StreamEnd::default()))).collect();
        activity.request_ends();
        // One after the other gives a piece per second: each waits for a minute.
        for second in 0..300 {
            tokio::time::advance(Duration::from_secs(1)).await;
            activity.body_gives(&bodies[second % 60], PIECE_BYTES as u64);
            assert_eq!((activity.overdue(&limits), activity.end_stalled_streams(&limits)), (None, 0));
        }
        // One waits for the server, another for its client, and the network is slow.
        bodies[1].is_asked();
        bodies[3..].iter().for_each(|body| activity.body_ends(body));
        for second in 0..200 {
            tokio::time::advance(Duration::from_secs(1)).await;
            activity.body_gives(&bodies[0], 100);
            // It has waited for 58 seconds before.
            assert_eq!(activity.end_stalled_streams(&limits), usize::from(second == 62), "{second}");
        }
    }
}
