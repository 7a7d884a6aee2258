//! The body of a response. Its bytes are counted, and it is logged when it ends. If the bandwidth
//! is limited, it is paced.
//!
//! # Algorithm
//! A paced body is sent in pieces that take 1/20 second each. The next piece is due when the
//! previous pieces would have arrived at the given rate. If a client is slower, later pieces are
//! not sent faster to compensate.

use std::net::IpAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use axum::body::Body;
use axum::http::{Method, StatusCode};
use bytes::Bytes;
use http_body::{Body as HttpBody, Frame, SizeHint};
use tokio::time::{Instant, Sleep, sleep_until};

use crate::activity::{Activity, OpenBody};
use crate::clients::Place;
use crate::metrics::ServerMetrics;
use crate::streams::StreamEnd;

/// The number of pieces per second of a paced body, and the minimum and maximum size of a piece in
/// bytes.
const PIECES_PER_SECOND: u64 = 20;
const FEWEST_BYTES: u64 = 64;
const MAX_BYTES: u64 = 64 << 10;

/// The pacing of a body.
#[derive(Debug)]
pub(crate) struct Pace {
    bytes_per_second: u64,
    due: Pin<Box<Sleep>>,
    rest: Bytes,
}

impl Pace {
    /// Starts pacing now, at a rate in bits per second.
    pub(crate) fn new(bits_per_second: u64) -> Self {
        let bytes_per_second = (bits_per_second / 8).max(1);
        Self { bytes_per_second, due: Box::pin(sleep_until(Instant::now())), rest: Bytes::new() }
    }

    /// Returns the next piece of the remaining bytes once it is due. The remaining bytes must not
    /// be empty.
    fn poll_piece(&mut self, context: &mut Context<'_>) -> Poll<Bytes> {
        ready!(self.due.as_mut().poll(context));
        let most = (self.bytes_per_second / PIECES_PER_SECOND).clamp(FEWEST_BYTES, MAX_BYTES);
        let piece = self.rest.split_to(self.rest.len().min(most as usize));
        let time = Duration::from_secs_f64(piece.len() as f64 / self.bytes_per_second as f64);
        let next = self.due.deadline().max(Instant::now()) + time;
        self.due.as_mut().reset(next);
        Poll::Ready(piece)
    }
}

/// The log entry of a response.
#[derive(Debug)]
pub(crate) struct Record {
    pub(crate) method: Method,
    pub(crate) path: String,
    pub(crate) route: &'static str,
    pub(crate) status: StatusCode,
    pub(crate) client: IpAddr,
    pub(crate) started: Instant,
}

/// A body that is paced, counted and logged.
#[derive(Debug)]
pub(crate) struct ResponseBody {
    inner: Body,
    pace: Option<Pace>,
    sent: u64,
    is_whole: bool,
    record: Record,
    metrics: Arc<ServerMetrics>,
    activity: Arc<Activity>,
    open: OpenBody,
    /// Counts the response until its body ends.
    _place: Option<Place>,
}

impl ResponseBody {
    pub(crate) fn new(
        inner: Body,
        pace: Option<Pace>,
        record: Record,
        metrics: Arc<ServerMetrics>,
        activity: Arc<Activity>,
        place: Option<Place>,
    ) -> Self {
        let open = activity.body_begins(StreamEnd::of_task());
        let is_whole = inner.is_end_stream();
        Self { inner, pace, sent: 0, is_whole, record, metrics, activity, open, _place: place }
    }

    fn poll_inner(&mut self, context: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let Some(pace) = &mut self.pace else { return Pin::new(&mut self.inner).poll_frame(context) };
        if pace.rest.is_empty() {
            match ready!(Pin::new(&mut self.inner).poll_frame(context)) {
                Some(Ok(frame)) => match frame.into_data() {
                    Ok(data) => pace.rest = data,
                    Err(frame) => return Poll::Ready(Some(Ok(frame))),
                },
                other => return Poll::Ready(other),
            }
        }
        pace.poll_piece(context).map(|piece| Some(Ok(Frame::data(piece))))
    }
}

impl HttpBody for ResponseBody {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        self.open.is_asked();
        let polled = ready!(self.poll_inner(context));
        let data = polled.as_ref().and_then(|polled| polled.as_ref().ok()?.data_ref());
        let bytes = data.map_or(0, |data| data.len() as u64);
        self.activity.body_gives(&self.open, bytes);
        match &polled {
            Some(Ok(_)) => self.sent += bytes,
            Some(Err(error)) => tracing::warn!(path = self.record.path, %error, "response ended early"),
            None => self.is_whole = true,
        }
        if self.is_end_stream() {
            self.is_whole = true;
        }
        Poll::Ready(polled)
    }

    fn is_end_stream(&self) -> bool {
        self.inner.is_end_stream() && self.pace.as_ref().is_none_or(|pace| pace.rest.is_empty())
    }

    fn size_hint(&self) -> SizeHint {
        let inner = self.inner.size_hint();
        let rest = self.pace.as_ref().map_or(0, |pace| pace.rest.len() as u64);
        let mut hint = SizeHint::new();
        if let Some(upper) = inner.upper() {
            hint.set_upper(upper + rest);
        }
        hint.set_lower(inner.lower() + rest);
        hint
    }
}

impl Drop for ResponseBody {
    fn drop(&mut self) {
        self.activity.body_ends(&self.open);
        let time = self.record.started.elapsed();
        let Record { method, path, route, status, client, .. } = &self.record;
        self.metrics.count_response(route, status.as_u16(), self.sent, time);
        tracing::info!(
            %method,
            path,
            status = status.as_u16(),
            bytes = self.sent,
            ms = time.as_millis() as u64,
            %client,
            whole = self.is_whole,
            "request"
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn the_bandwidth_is_that_of_each_body() {
        let metrics = Arc::new(ServerMetrics::new());
        let started = Instant::now();
        tokio::join!(take(&metrics), take(&metrics));
        let seconds = started.elapsed().as_secs_f64();
        assert!((1.9..2.1).contains(&seconds), "{seconds} of virtual time");
        assert!(metrics.text().contains("tristrip_sent_bytes_total 200000"));
    }

    /// Reads a paced body whose 100,000 bytes are due within two seconds.
    async fn take(metrics: &Arc<ServerMetrics>) {
        let record = Record {
            method: Method::GET,
            path: "/".into(),
            route: "files",
            status: StatusCode::OK,
            client: IpAddr::from([127, 0, 0, 1]),
            started: Instant::now(),
        };
        let inner = Body::from(vec![1; 100_000]);
        let activity = Arc::new(Activity::new());
        let mut body =
            ResponseBody::new(inner, Some(Pace::new(400_000)), record, Arc::clone(metrics), activity, None);
        let mut left = 100_000;
        while let Some(frame) = std::future::poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await
        {
            let piece = frame.unwrap().into_data().unwrap();
            assert!(piece.len() <= 2500);
            left -= piece.len();
            assert_eq!(body.size_hint().exact(), Some(left as u64));
        }
        assert!(left == 0 && body.is_whole);
    }
}
