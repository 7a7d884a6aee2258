//! What a connection does: how many responses it waits for or sends, and when it last got on. So connections that only take space are found.

use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::time::Instant;

use crate::options::Limits;

/// How many times as long as a connection that gets on nowhere one body may wait for its client, while other bodies of the connection get on: they share what a slow
/// network takes.
const BODY_PATIENCE: u32 = 4;

/// Since when a body waits for its client: the milliseconds after the start of the connection.
#[derive(Debug, Clone)]
pub(crate) struct ClientWait(Arc<AtomicU64>);

impl ClientWait {
    const NONE: u64 = u64::MAX;

    /// Notes that the body has given bytes, and that the client may take long until it takes more.
    pub(crate) fn begins(&self, now: u64) {
        self.0.store(now, Ordering::Relaxed);
    }

    /// Notes that the client takes more.
    pub(crate) fn ends(&self) {
        self.0.store(Self::NONE, Ordering::Relaxed);
    }
}

/// The state of a connection, which its requests share.
#[derive(Debug)]
pub(crate) struct Activity {
    start: Instant,
    /// Requests whose responses have not ended.
    requests: AtomicUsize,
    /// The waits of the bodies that have begun and not ended.
    bodies: Mutex<Vec<ClientWait>>,
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
            bodies: Mutex::default(),
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

    /// Notes a body, which waits for its client from now on.
    pub(crate) fn body_begins(&self) -> ClientWait {
        let wait = ClientWait(Arc::new(AtomicU64::new(self.now())));
        self.bodies().push(wait.clone());
        self.progress();
        wait
    }

    pub(crate) fn body_ends(&self, wait: &ClientWait) {
        self.bodies().retain(|body| !Arc::ptr_eq(&body.0, &wait.0));
        self.progress();
    }

    fn bodies(&self) -> MutexGuard<'_, Vec<ClientWait>> {
        self.bodies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the milliseconds since the start.
    pub(crate) fn now(&self) -> u64 {
        self.start.elapsed().as_millis() as u64
    }

    /// Notes that bytes were taken.
    pub(crate) fn progress(&self) {
        self.last.store(self.now(), Ordering::Relaxed);
    }

    /// Returns why the connection should be closed now, if it should.
    ///
    /// A client of HTTP/1.1 that reads nothing is found by its socket, one of HTTP/2 here: its streams wait for it while the socket does not.
    pub(crate) fn overdue(&self, limits: &Limits) -> Option<Overdue> {
        let now = self.now();
        let time_since =
            |time: &AtomicU64| Duration::from_millis(now.saturating_sub(time.load(Ordering::Relaxed)));
        let since = time_since(&self.last);
        let bodies = self.bodies();
        if !bodies.is_empty() {
            let body_waits = || {
                let longest = limits.stall_time.saturating_mul(BODY_PATIENCE);
                bodies.iter().any(|ClientWait(wait)| time_since(wait) >= longest)
            };
            let stalls =
                self.is_http2.load(Ordering::Relaxed) && (since >= limits.stall_time || body_waits());
            return stalls.then_some(Overdue::Stalled);
        }
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
        let wait = activity.body_begins();
        activity.request_ends();
        after(29).await;
        assert_eq!(activity.overdue(&limits), None);
        activity.progress();
        after(30).await;
        assert_eq!(activity.overdue(&limits), Some(Overdue::Stalled));
        activity.body_ends(&wait);
        after(59).await;
        assert_eq!(activity.overdue(&limits), None);
        after(1).await;
        assert_eq!(activity.overdue(&limits), Some(Overdue::Idle));
    }

    #[tokio::test(start_paused = true)]
    async fn a_body_that_is_not_read_is_found_beside_others() {
        let limits = Limits::default();
        let activity = Activity::new();
        activity.request_begins(true);
        let [read, unread] = [activity.body_begins(), activity.body_begins()];
        activity.request_ends();
        for _ in 0..11 {
            tokio::time::advance(Duration::from_secs(10)).await;
            activity.progress();
            read.begins(activity.now());
            assert_eq!(activity.overdue(&limits), None);
        }
        tokio::time::advance(Duration::from_secs(10)).await;
        activity.progress();
        assert_eq!(activity.overdue(&limits), Some(Overdue::Stalled));
        // It waits for the server.
        unread.ends();
        assert_eq!(activity.overdue(&limits), None);
    }
}
